"""A tree as an assignment of a formula's variables: it proves that the objective can be as low as the tree's cost."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from octmip.encoding import Ranks, rows_from_tree
from octmip.encoding.rows import NodeRow
from octmip.pseudo_boolean.formula import Formula, label, left
from octmip.tree import Node

Rows = list[NodeRow]


def true_variables(formula: Formula, tree: Node, ranks: Ranks) -> set[str]:
    """Return the variables that are true for a tree, none of whose splits leaves a side without samples."""
    return _Assignment(formula, rows_from_tree(tree, ranks)).true


def assignment(formula: Formula, true: Iterable[str]) -> str:
    """Return all variables as literals."""
    chosen = set(true)
    return " ".join(name if name in chosen else f"~{name}" for name in formula.variables())


class _Assignment:
    def __init__(self, formula: Formula, rows: Rows) -> None:
        self.formula, self.question, self.rows = formula, formula.question, rows
        self.true: set[str] = set()
        self.everywhere = np.ones(self.question.all_ranks.shape[1], dtype=np.bool_)
        if self.question.depth == 1:
            self._wrong(0, self._stump(0, 0, self.everywhere))
        else:
            self._root()

    def _root(self) -> None:
        """Set all three nodes; a tree of one leaf is the right side of a root that does not split."""
        is_leaf = self.rows[0][0] == 0
        sides = (0, 0) if is_leaf else (self.rows[0][3], self.rows[0][4])
        goes_left = ~self.everywhere if is_leaf else self._cut(0, self.rows[0])
        arrives = (goes_left, ~goes_left)
        wrong = [self._stump(m, index, here) for m, index, here in zip((1, 2), sides, arrives, strict=True)]
        for m in (1, 2):
            self._wrong(m, wrong[m - 1])
        self._wrong(0, np.where(goes_left[self.question.counted], *wrong))

    def _stump(self, m: int, index: int, here: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Set cut, labels and leaves of a node whose sides are leaves; return which samples it answers wrongly."""
        row = self.rows[index]
        labels = [row[5]] * 2 if row[0] == 0 else [self.rows[side][5] for side in row[3:5]]
        self.true |= {label(m, side, k) for side, k in zip(("left", "right"), labels, strict=True)}
        goes_left = ~self.everywhere if row[0] == 0 else self._cut(m, row)
        if self.question.leaf_size > 1:
            places = (("g", here), ("x", here & goes_left), ("z", here & ~goes_left))
            self.true |= {f"{x}{m}_{i}" for x, part in places if m or x != "g" for i in np.flatnonzero(part).tolist()}
        return np.asarray(np.where(goes_left[self.question.counted], *labels) != self.question.labels)

    def _cut(self, m: int, row: NodeRow) -> NDArray[np.bool_]:
        """Set the cut of a node and return which samples go left."""
        j, cut = self.question.columns.index(row[1]), row[2]
        self.true |= {left(m, j, r) for r in range(cut + 1)} | {f"s{m}"}
        if self.question.sensor_limit is not None:
            self.true.add(f"u{self.question.sensors[j]}")
        return np.asarray(self.question.all_ranks[j] <= cut)

    def _wrong(self, m: int, wrong: NDArray[np.bool_]) -> None:
        self.true |= {f"w{m}_{i}" for i in np.flatnonzero(wrong).tolist()}
