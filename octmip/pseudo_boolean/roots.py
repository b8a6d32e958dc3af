"""Which parts of the samples need lemmas: intervals of the root's cuts, each closed by a stump on either side.

A cut from a to b - 1 of a column sends the samples of ranks up to a left and those from b on right, whatever the cut.
If the least stumps on these two parts cost the bound together, no cut of the interval is below it.

Where there is a budget, the stumps may read only what is affordable with the root's column: the left one some columns,
the right one those that are affordable with any of these (`groups`).
"""

from dataclasses import dataclass

from octmip.pseudo_boolean.counts import TOO_FEW, Counts, StumpCosts
from octmip.pseudo_boolean.question import Question


@dataclass(frozen=True, slots=True)
class Group:
    """Columns that the left and the right side of the root may read together with the root's column."""

    left: frozenset[int]
    right: frozenset[int]


@dataclass(frozen=True, slots=True)
class RootInterval:
    """Cuts from a to b - 1 of a column of the root, and what is to be proven of the two sides (0: nothing).

    Or else one side, `too_few`, cannot have the samples of a leaf.
    """

    a: int
    b: int
    least_left: int
    least_right: int
    too_few: str | None = None


def groups(question: Question, j: int) -> list[Group]:
    """Return groups that cover all that the two sides may read beside column j, one of them for any right side."""
    affordable = [k for k in range(question.n_columns) if question.is_affordable((j, k))]
    beside: dict[frozenset[int], set[int]] = {frozenset(affordable): set()}
    for k in affordable:
        others = frozenset(other for other in affordable if question.is_affordable((j, k, other)))
        beside.setdefault(others, set()).add(k)
    return [Group(frozenset(left), right) for right, left in beside.items()]


class Roots:
    """Intervals of the root's cuts for one bound."""

    def __init__(self, question: Question, bound: int) -> None:
        self.question, self.counts, self.bound = question, Counts(question), bound
        self._known: dict[tuple[str, int, int], int] = {}

    def costs(self, j: int, side: str, cuts: tuple[int, int], group: Group) -> StumpCosts:
        """Return the costs of stumps on one side of the cuts from a to b - 1 of column j."""
        a, b = cuts
        ranks, all_ranks = self.question.ranks[j], self.question.all_ranks[j]
        if side == "left":
            return self.counts.stumps(ranks <= a, all_ranks < b, group.left)
        return self.counts.stumps(ranks >= b, all_ranks > a, group.right)

    def _least(self, j: int, side: str, cuts: tuple[int, int], group: Group) -> int:
        own, other = cuts if side == "left" else cuts[::-1]
        key = (side, own, other if self.question.leaf_size > 1 else 0)
        if key not in self._known:
            self._known[key] = self.costs(j, side, cuts, group).least
        return self._known[key]

    def intervals(self, j: int, group: Group) -> list[RootInterval] | None:
        """Return intervals that cover the cuts of column j; None where a cut is below the bound."""
        self._known.clear()
        found, a, last = [], 0, int(self.question.n_ranks[j]) - 1
        need = max(0, self.bound - self.question.penalty)
        step = 1
        while a < last:
            b = self._furthest(j, a, need, min(step, last - a), group)
            if b is None:
                return None
            left, right = (self._least(j, side, (a, b), group) for side in ("left", "right"))
            found.append(_shared(a, b, left, right, need))
            step, a = b - a, b
        return found

    def _furthest(self, j: int, a: int, need: int, step: int, group: Group) -> int | None:
        """Return the last b for which the two sides cost what is needed, found by doubling steps."""
        low, high = a, int(self.question.n_ranks[j])  # low is closed (or is a itself), high is not
        probe = a + step
        while high - low > 1:
            if sum(self._least(j, side, (a, probe), group) for side in ("left", "right")) >= need:
                low, step = probe, 2 * step
            else:
                high, step = probe, max(1, (probe - low) // 2)
            probe = min(low + step, high - 1)
        return low if low > a else None


def _shared(a: int, b: int, left: int, right: int, need: int) -> RootInterval:
    """Return an interval whose sides prove no more than is needed; what can be spared is spared in shares."""
    if max(left, right) == TOO_FEW:
        return RootInterval(a, b, 0, 0, "left" if left == TOO_FEW else "right")
    if left >= need:
        return RootInterval(a, b, need, 0)
    if right >= need:
        return RootInterval(a, b, 0, need)
    spare = left + right - need
    less = spare * left // (left + right)
    return RootInterval(a, b, left - less, need - left + less)
