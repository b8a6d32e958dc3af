"""How the rows and columns of a table became the samples of a problem, so that they can become so again."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Self

import numpy as np

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.formats.table.samples import Table
from octmip.trees.answer.solution import Solution
from octmip.trees.question.problem import Problem

RowsKept = Literal["all", "labelled", "complete"]


@dataclass(frozen=True, slots=True)
class Preparation:
    """What became of a table.

    Attributes
    ----------
    columns
        how its columns became features.
    index
        the column that names the rows, None without one.
    rows
        those that are kept: "all", the "labelled" (their label is not missing), or the "complete" (no cell of
        theirs is missing: features, label, weights).
    class_weight
        what multiplies the weight of the training rows of each class, in the order of the problem's; None: nothing.
    """

    columns: Columns
    index: str | None = None
    rows: RowsKept = "all"
    class_weight: tuple[float, ...] | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the preparation as a JSON object."""
        weight = None if self.class_weight is None else list(self.class_weight)
        return {"columns": self.columns.to_json(), "index": self.index, "rows": self.rows, "class_weight": weight}

    @classmethod
    def from_json(cls, content: dict[str, Any]) -> Self:
        """Return the preparation of a JSON object whose kinds were checked.

        Raises
        ------
        DataError
            the columns are none.
        """
        weight = None if content["class_weight"] is None else tuple(content["class_weight"])
        return cls(Columns.from_json(content["columns"]), content["index"], content["rows"], weight)


def with_written_cuts(problem: Problem, solution: Solution, columns: Columns) -> Solution:
    """Return a solution whose tree asks for dates and durations in the fewest fields, and parts the samples alike.

    Splits that are given, or those of an old tree, stay as they are.
    """
    if solution.tree is None or (problem.shape.fixed_splits or ()) or problem.shape.old_tree is not None:
        return solution
    return replace(solution, tree=columns.with_written_cuts(solution.tree, problem.samples.features))


def kept_rows(table: Table, rows: RowsKept, label: str, others: Sequence[str]) -> Table:
    """Return the table of the rows that are kept; numbers among a label's words for "missing" are numbers again.

    Raises
    ------
    DataError
        a column is missing, or no row is kept.
    """
    if rows == "all":
        return table
    is_missing = table.missing(label, "label")
    for name in others if rows == "complete" else ():
        is_missing = is_missing | table.missing(name, "feature")
    if not is_missing.any():
        return table
    if is_missing.all():
        raise DataError(
            f"{table.name} has no row without a missing cell; expected some; leave columns out with --drop, or let "
            "missing cells go to either side (--missing either-side)"
        )
    return table.rows(np.logical_not(is_missing)).with_plain_numbers(label)
