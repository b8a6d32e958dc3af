"""The words and tables of the page of a tree, as its template takes them."""

import shlex
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.formats.names import visible
from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.text import tree_text
from octmip.interfaces.report.tree.curve import depth_curve
from octmip.interfaces.report.tree.drawing import draw_tree
from octmip.interfaces.report.tree.embedded import node_data, sample_data
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.goodness import comparison, depth_words, quality
from octmip.interfaces.report.tree.measure import Measure, measure_of
from octmip.interfaces.report.tree.proof import certificate_words
from octmip.interfaces.report.tree.settings import reads, risk, settings_rows
from octmip.interfaces.report.tree.summary import figures, subtitle, title, verdict
from octmip.interfaces.report.tree.words import Wording, percent, question, short_name
from octmip.trees.tree import Leaf, Node, leaf_index, leaves

MOST_CLASSES = 30
"""Classes that a table of confusions has room for."""


def page_contents(
    file: TreeFile, source: str | None, evidence: Evidence | None, wording: Wording, data: str | None
) -> dict[str, Any]:
    """Return the context of `tree.html`."""
    measure = measure_of(file)
    page = {
        "title": title(file),
        "subtitle": subtitle(file, wording),
        "verdict": verdict(file, evidence, measure),
        "figures": figures(file, evidence, measure, wording),
        "legend": [short_name(name, 40) for name in file.class_names],
        "drawing": draw_tree(file.tree, wording, file.leaf_counts),
        "quality": quality(file, evidence, measure),
        "comparison": comparison(file, evidence, measure, wording),
        "greedy_drawing": _greedy_drawing(evidence, wording),
        "confusions": _confusions(file, evidence, wording),
        "reads": reads(file, wording),
        "risk": risk(file, evidence),
        "certificate": certificate_words(file, evidence, measure, data),
        "words": tree_text(file.tree, file.feature_names, file.class_names, file.leaf_counts, wording.columns),
        "leaves": _leaves(file, wording),
        "settings": settings_rows(file),
        "commands": _commands(source, data) if source else "",
        "data": _data(file, evidence, wording),
    }
    return page | _depths(evidence, measure)


def _greedy_drawing(evidence: Evidence | None, wording: Wording) -> Any:
    if evidence is None:
        return None
    tree, problem = evidence.greedy.tree, evidence.problem
    assert tree is not None
    counts = np.zeros((len(leaves(tree)), problem.n_classes), dtype=np.int64)
    np.add.at(counts, (leaf_index(tree, problem.features), problem.codes), 1)
    return draw_tree(tree, wording, counts)


def _depths(evidence: Evidence | None, measure: Measure) -> dict[str, Any]:
    if evidence is None or len(evidence.depths) < 2:
        return {"curve": None}
    words = depth_words(evidence, measure)
    return words | {"curve": depth_curve(evidence.depths, measure.noun)}


def confusion_of(file: TreeFile) -> NDArray[np.int64]:
    """Return training samples by true and predicted class, shape (n_classes, n_classes)."""
    counts = np.zeros((len(file.class_names), len(file.class_names)), dtype=np.int64)
    for leaf, row in zip(leaves(file.tree), file.leaf_counts, strict=True):
        counts[:, leaf.label] += row
    return counts


def _confusions(file: TreeFile, evidence: Evidence | None, wording: Wording) -> list[dict[str, Any]]:
    found = [_confusion("Training samples", confusion_of(file), wording)]
    if evidence is not None and evidence.held_out is not None:
        held = evidence.held_out
        found.append(_confusion("Samples held out", held.confusion(held.tree, len(file.class_names)), wording))
    return found


def _confusion(what: str, counts: NDArray[np.int64], wording: Wording) -> dict[str, Any]:
    names = [short_name(name, 40) for name in wording.classes]
    caption = f"{what}: true class in rows, answer of the tree in columns"
    if len(names) <= MOST_CLASSES:
        rows = [[name, *row, sum(row)] for name, row in zip(names, counts.tolist(), strict=True)]
        return {
            "caption": caption,
            "head": ["true class", *names, "all"],
            "rows": rows,
            "right": range(1, len(names) + 2),
        }
    wrong = counts - np.diag(np.diag(counts))
    worst = np.argsort(-wrong, axis=None, kind="stable")[:MOST_CLASSES]
    pairs = [divmod(int(k), len(names)) for k in worst if wrong.flat[k] > 0]
    rows = [[names[true], names[got], int(wrong[true, got])] for true, got in pairs]
    head = ["true class", "answer", "samples"]
    return {"caption": f"{what}: the most frequent errors", "head": head, "rows": rows, "right": (2,)}


def _leaves(file: TreeFile, wording: Wording) -> dict[str, Any]:
    total = max(1, file.n_samples)
    rows = []
    for path, leaf, counts in zip(_paths(file.tree, wording), leaves(file.tree), file.leaf_counts, strict=True):
        here = int(counts.sum())
        share = percent(here / total)
        rows.append(
            [
                path or "always",
                short_name(file.class_names[leaf.label], 40),
                here,
                share,
                here - int(counts[leaf.label]),
            ]
        )
    return {"head": ["questions on the way", "answer", "samples", "share", "wrong"], "rows": rows}


def _paths(node: Node, wording: Wording) -> list[str]:
    """Return the answers that lead to each leaf, leaves from the left."""
    if isinstance(node, Leaf):
        return [""]
    asked = question(node, wording)
    words = ("yes", "no") if asked.yes_is_left else ("no", "yes")
    found = []
    for side, word in zip((node.left, node.right), words, strict=True):
        found += [f"{asked.text}: {word}{'; ' if path else ''}{path}" for path in _paths(side, wording)]
    return found


def _commands(source: str, data: str | None) -> str:
    """Return the commands that check the tree again; none where it is in no file."""
    if not source:
        return ""
    tree, table = shlex.quote(visible(source)), shlex.quote(visible(data)) if data else "DATA"
    return f"octmip certify {tree} {table}\noctmip certify {tree} {table} --proof LOG"


def _data(file: TreeFile, evidence: Evidence | None, wording: Wording) -> dict[str, Any]:
    samples = None
    if evidence is not None:
        samples = sample_data(evidence.problem, file.tree, wording, evidence.table)
    return {
        "nodes": node_data(file.tree, wording, file.leaf_counts),
        "classes": [short_name(name, 40) for name in file.class_names],
        "label": short_name(file.target_column or "class", 40),
        "total": file.n_samples,
        "samples": samples,
    }
