"""Least sizes of leaves in a proof: cuts that leave a leaf with too few samples, whatever the rest of the tree.

Every sample of a leaf went left or right at the stump, and left or right at the root. Where the root's cut lies within
an interval, the samples that can be on a side are known (`Side.candidates`), and so are those of them that a stump's
cut can send to a leaf. If they are fewer than a leaf needs, no such cut is a tree's: the leaf's size, with the clauses
of all other samples added, says so.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.pseudo_boolean.formula import Formula, left
from octmip.pseudo_boolean.lines import Lines, times

LETTERS = {"left": "x", "right": "z"}


@dataclass(slots=True)
class Side:
    """What a lemma may assume: nothing (depth 1), or that the root splits on column j within an interval of cuts.

    Attributes
    ----------
    literals
        one of which is true where the assumption is not.
    j, rank
        the root's column, and the rank whose samples and all beyond are surely on the other side.
    candidates
        (n_all_samples,) which samples can be on this side.
    outside
        sample -> number of "not on this side", as far as derived in the proof of the one lemma of this side.
    chains
        rank -> number of "the lower of it and `rank` goes left, or the higher does not", likewise.
    """

    literals: tuple[str, ...]
    j: int
    rank: int
    candidates: NDArray[np.bool_]
    outside: dict[int, int] = field(default_factory=dict)
    chains: dict[int, int] = field(default_factory=dict)


class Sizes:
    """Consequences of the leaf sizes of one node whose sides are leaves."""

    def __init__(self, formula: Formula, lines: Lines, m: int) -> None:
        self.formula, self.lines, self.m = formula, lines, m
        self.question = formula.question
        self.n_all = self.question.all_ranks.shape[1]

    def too_few(self, side: Side, leaf: str, column: int | None, rank: int) -> str:
        """Return the operations for "no cut below `rank` (left leaf) or from it on (right) of a column", on a side.

        Without a column: the side itself has too few samples.
        """
        letter, needed = LETTERS[leaf], self.question.leaf_size
        ranks = None if column is None else self.question.all_ranks[column]
        inside = np.ones(self.n_all, dtype=np.bool_)
        if ranks is not None:
            inside = ranks < rank if leaf == "left" else ranks > rank
        operations = f"{self.formula.sizes[self.m, leaf]}"
        if column is not None:
            operations += self._routed(leaf, column, rank)
        for i in np.flatnonzero(inside).tolist():
            if side.candidates[i]:
                operations += f" {letter}{self.m}_{i} w"
            else:
                operations += f" {self.formula.arrives[self.m, leaf][i]} + {self._outside(side, i)} +"
        if leaf == "right" and self.m == 1:
            operations += times(self._root_splits(side.j), needed)
        return f"{operations} {2 * (self.n_all + needed)} d"

    def _routed(self, leaf: str, column: int, rank: int) -> str:
        """Return the operations that add the clauses of the samples that such cuts send to the other leaf."""
        enters, order = self.formula.enters[self.m, leaf], self.formula.order
        ranks, last = self.question.all_ranks[column], int(self.question.n_ranks[column]) - 1
        operations, weight = "", 0
        path = range(last, rank - 1, -1) if leaf == "left" else range(rank + 1)
        for r in path:
            if weight:  # what is there of the rank before, moved to this one
                operations += times(order[self.m, column, r + 1 if leaf == "left" else r], weight)
            members = np.flatnonzero(ranks == r).tolist()
            operations += "".join(f" {enters[column, i]} +" for i in members)
            weight += len(members) if r < last else 0
        return operations

    def _outside(self, side: Side, i: int) -> int:
        """Return the number of "sample i is not on this side"."""
        if i not in side.outside:
            clause, r = self.formula.reaches[self.m][side.j, i], int(self.question.all_ranks[side.j, i])
            is_plain = r == side.rank or r == self.question.n_ranks[side.j] - 1
            chain = "" if is_plain else f" {self._chain(side, r)} +"
            side.outside[i] = self.lines.derive(f"{clause}{chain}") if chain else clause
        return side.outside[i]

    def _chain(self, side: Side, r: int) -> int:
        """Return the number of "the lower of r and the side's rank goes left, or the higher does not" at the root."""
        low, high = min(r, side.rank), max(r, side.rank)
        if high == low + 1:
            return self.formula.order[0, side.j, high]
        if r not in side.chains:
            steps = [f"{self.formula.order[0, side.j, step]} +" for step in range(low + 2, high + 1)]
            side.chains[r] = self.lines.derive(" ".join([f"{self.formula.order[0, side.j, low + 1]}", *steps]))
        return side.chains[r]

    def _root_splits(self, j: int) -> str:
        """Return the operations for "the root splits, or not on column j"."""
        others = "".join(f" {left(0, k, 0)} w" for k in range(self.question.n_columns) if k != j)
        return f"{self.formula.single[0]}{others}"
