"""Which parts of the samples need lemmas: intervals of the root's cuts, each closed by a stump on either side.

A cut from a to b - 1 of a column sends the samples of ranks up to a left and those from b on right, whatever the cut.
If the least stumps on these two parts cost the bound together, no cut of the interval is below it.
"""

from dataclasses import dataclass

from octmip.pseudo_boolean.counts import Counts, StumpCosts
from octmip.pseudo_boolean.question import Question


@dataclass(frozen=True, slots=True)
class RootInterval:
    """Cuts from a to b - 1 of a column of the root, and what is to be proven of the two sides (0: nothing)."""

    a: int
    b: int
    least_left: int
    least_right: int


class Roots:
    """Intervals of the root's cuts for one bound."""

    def __init__(self, question: Question, bound: int) -> None:
        self.question, self.counts, self.bound = question, Counts(question), bound
        self._known: dict[tuple[int, int, bool], StumpCosts] = {}

    def side(self, j: int, rank: int, is_left: bool) -> StumpCosts:
        """Return the costs of stumps on the samples of ranks up to `rank` of column j, or from it on."""
        key = (j, rank, is_left)
        if key not in self._known:
            ranks = self.question.ranks[j]
            self._known[key] = self.counts.stumps(ranks <= rank if is_left else ranks >= rank)
        return self._known[key]

    def intervals(self, j: int) -> list[RootInterval] | None:
        """Return intervals that cover the cuts of column j; None where a cut is below the bound."""
        self._known.clear()
        found, a, last = [], 0, int(self.question.n_ranks[j]) - 1
        need = self.bound - self.question.penalty
        step = 1
        while a < last:
            left = self.side(j, a, True).least
            b = self._furthest(j, a, need - left, min(step, last - a))
            if b is None:
                return None
            found.append(_shared(a, b, left, self.side(j, b, False).least, need))
            step, a = b - a, b
        return found

    def _furthest(self, j: int, a: int, lacking: int, step: int) -> int | None:
        """Return the last rank from which on the right side costs what is lacking, found by doubling steps."""
        last = int(self.question.n_ranks[j]) - 1
        if lacking <= 0:
            return last
        low, high = a, last + 1  # low reaches (or is a itself), high does not
        probe = a + step
        while high - low > 1:
            if self.side(j, probe, False).least >= lacking:
                low, step = probe, 2 * step
                probe = min(probe + step, (low + high) // 2) if high <= last else min(probe + step, last)
                if probe == low:
                    break
            else:
                high = probe
                probe = (low + high) // 2
        return low if low > a else None


def _shared(a: int, b: int, left: int, right: int, need: int) -> RootInterval:
    """Return an interval whose sides prove no more than is needed, and what can be spared spared in shares."""
    if left >= need:
        return RootInterval(a, b, max(need, 0), 0)
    if right >= need:
        return RootInterval(a, b, 0, need)
    spare = left + right - need
    less = spare * left // max(left + right, 1)
    return RootInterval(a, b, left - less, need - left + less)
