"""What the scripts of the page know: each node with its question, and samples for a look into the leaves."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.formats.columns.spellings import DAYS
from octmip.formats.columns.written import is_date
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.measure import Measure
from octmip.interfaces.report.tree.words import LONGEST_NAME, Wording, figure, question, short_name, short_names
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, features_used, leaf_index, leaves
from octmip.trees.question.problem import Problem

MOST_ROWS = 200
"""Samples of one leaf that stand in the page."""
MOST_CELLS = 60_000
"""Cells of all samples in the page, so that it stays below some megabytes whatever the table."""
MOST_COLUMNS = 12
LONGEST_CELL = 60


def node_data(
    tree: Node,
    wording: Wording,
    counts: NDArray[np.int64],
    said: Sequence[Mapping[str, Any]],
    others: Sequence[Sequence[Sequence[str]]],
) -> list[dict[str, Any]]:
    """Return the nodes in preorder: what each asks, where yes and no lead, and the samples that come there.

    `said` is what a leaf answers and how that misses, leaves from the left; `others` are of each node other columns and
    what these cost there.
    """
    answers = iter(said)
    found: list[dict[str, Any]] = []

    def add(node: Node, here: NDArray[np.int64]) -> int:
        own = len(found)
        found.append({"counts": here.sum(axis=0).tolist()})
        if isinstance(node, Leaf):
            found[own] |= {"label": node.label, **next(answers)}
            return own
        n_left = len(leaves(node.left))
        left, right = add(node.left, here[:n_left]), add(node.right, here[n_left:])
        asked = question(node, wording)
        found[own] |= {"text": f"{asked.text}?", "left": left, "right": right, "yesIsLeft": asked.yes_is_left}
        found[own] |= _rule(node, wording) | {"others": others[own]}
        return own

    add(tree, counts)
    return found


def _rule(node: Split | HyperplaneSplit, wording: Wording) -> dict[str, Any]:
    """Return a split as the page's scripts ask it: `cut` None where it asks for missing values alone."""
    side = {"missing": node.missing}
    if isinstance(node, Split):
        return {"cut": node.threshold, "asks": [_asked(node.feature, 1.0, wording, node)]} | side
    terms = zip(node.features, node.coefficients, strict=True)
    return {"cut": node.offset, "asks": [_asked(feature, weight, wording, node) for feature, weight in terms]} | side


def _asked(index: int, coefficient: float, wording: Wording, node: Split | HyperplaneSplit) -> dict[str, Any]:
    """Return how a case's value of a column becomes the feature that a split reads."""
    item = wording.feature(index)
    asked: dict[str, Any] = {
        "feature": index,
        "coefficient": coefficient,
        "key": next(j for j in range(index + 1) if wording.feature(j).column == item.column),
        "column": wording.short(item.column),
        "unit": wording.unit(item.column).strip(),
        "kind": item.kind,
        "value": item.value,
        "members": list(item.members),
        "hasMissing": node.missing is not None,
    }
    if wording.columns is None:
        return asked
    column = wording.columns.column_of(item)
    if column.form == DAYS or is_date(column.form):
        example = column.number_text(column.least)
        asked |= {
            "time": "duration" if column.form == DAYS else "date",
            "hasZone": bool(column.zone),
            "example": example,
        }
    asked |= {"values": list(column.values), "shown": short_names(column.values, LONGEST_NAME)}
    ends = (column.least, column.most) if column.kind == "number" else (0.0, len(column.values) - 1.0)
    return asked | {
        "hasMissing": column.has_missing or (node.missing is not None and not column.asks_texts),
        "least": ends[0],
        "most": ends[1],
        "isOrder": column.kind == "order",
    }


def sample_data(evidence: Evidence, measure: Measure, wording: Wording) -> dict[str, Any]:
    """Return samples of each leaf in the order of the table, as text, within the limits of this module."""
    problem, tree, table = evidence.problem, measure.file.tree, evidence.table
    reached = leaf_index(tree, problem.samples.features)
    names, is_number, cells = _columns(problem, tree, wording, table)
    n_leaves = len(leaves(tree))
    each = max(1, min(MOST_ROWS, MOST_CELLS // (n_leaves * max(1, len(names)))))
    rows_of = [np.flatnonzero(reached == k)[:each] for k in range(n_leaves)]
    place = range(problem.samples.n_samples) if table is None else table.index.tolist()
    found = []
    for k, rows in enumerate(rows_of):
        samples = zip(rows.tolist(), measure.script_samples(evidence, rows.tolist(), k), strict=True)
        found.append([[place[row] + 1, *judged, *cells(row)] for row, judged in samples])
    total = problem.samples.n_features if table is None else table.shape[1]
    return {"columns": short_names(names), "isNumber": is_number, "leaves": found, "of": total}


def _columns(problem: Problem, tree: Node, wording: Wording, table: pd.DataFrame | None) -> tuple[Any, ...]:
    """Return the columns that are shown, those that the tree reads first; which hold numbers; what gives a row's."""
    read = list(features_used(tree))
    if table is None:
        chosen = [*read, *(j for j in range(problem.samples.n_features) if j not in read)][:MOST_COLUMNS]
        names = [problem.samples.feature_names[j] for j in chosen]
        return names, [True] * len(names), lambda row: [figure(problem.samples.features[row, j]) for j in chosen]
    every = [str(name) for name in table.columns]
    first = [name for j in read if (name := wording.feature(j).column) in every]
    names = list(dict.fromkeys([*first, *every]))[:MOST_COLUMNS]
    series = [table.iloc[:, every.index(name)] for name in names]
    cells = [column.tolist() for column in series]
    is_number = [column.dtype.kind in "iuf" for column in series]
    return names, is_number, lambda row: [_cell(column[row]) for column in cells]


def _cell(value: Any) -> str:
    if pd.isna(value):
        return "missing"
    if isinstance(value, int | float) and not isinstance(value, bool):
        return figure(float(value))
    return short_name(value, LONGEST_CELL)
