"""Consequences of the order of one column's cuts at one node: clauses moved to other cuts, and bundles of them.

The ranks of a column are divided by a grid 0 = g_0 < g_1 < ... < R - 1. A clause of a sample that goes left where rank
r does holds as well where rank g >= r does: it is written once with the next grid rank in place of r, and from then on
sums of many samples carry one literal for each block of the grid, not one for each rank.

`bundle_left(a)` turns a clause over the literals of all blocks up to rank a into one over rank a alone: it is the sum
of "g_s goes left, or a does not" over these blocks; `bundle_right(b)` does so for the blocks from rank b on.
"""

from octmip.pseudo_boolean.formula import Formula, left
from octmip.pseudo_boolean.lines import Lines, times, total

Bundle = tuple[int | None, int]
"""Number of a sum of clauses, and how many."""

N_BLOCKS = 16


class Column:
    """One column at one node whose sides are leaves.

    Parameters
    ----------
    formula, lines
        what is given, and where derived constraints go; each is derived when it is first asked for.
    m, j
        node and column.
    """

    def __init__(self, formula: Formula, lines: Lines, m: int, j: int) -> None:
        self.formula, self.lines, self.m, self.j = formula, lines, m, j
        self.last = int(formula.question.n_ranks[j]) - 1
        self.ranks: list[int] = formula.question.ranks[j].tolist()
        self.grid = sorted({self.last * t // N_BLOCKS for t in range(N_BLOCKS + 1)})
        self.below = [0] * (self.last + 1)  # block t of rank r: grid[t] <= r < grid[t + 1]
        for t, g in enumerate(self.grid):
            for r in range(g, self.last + 1):
                self.below[r] = t
        self._known: dict[tuple[str, int], int] = {}
        self._left: dict[int, Bundle] = {}
        self._right: dict[int, Bundle] = {}

    def name(self, r: int) -> str:
        """Return the variable of rank r on the left."""
        return left(self.m, self.j, r)

    def above(self, r: int) -> int:
        """Return the block t with grid[t - 1] < r <= grid[t]."""
        t = self.below[r]
        return t if self.grid[t] == r else t + 1

    def order(self, r: int) -> int:
        """Return the number of "r - 1 goes left, or r does not"."""
        return self.formula.order[self.m, self.j, r]

    def _derived(self, kind: str, place: int, operations: str) -> int:
        if (kind, place) not in self._known:
            self._known[kind, place] = self.lines.derive(operations)
        return self._known[kind, place]

    def up(self, r: int) -> int:
        """Return the number of "r goes left, or the next grid rank above r does not"."""
        if self.above(r + 1) == self.below[r + 1]:
            return self.order(r + 1)
        known = self._known.get(("up", r))
        return known or self._derived("up", r, f"{self.up(r + 1)} {self.order(r + 1)} +")

    def down(self, r: int) -> int:
        """Return the number of "the next grid rank below r goes left, or r does not"."""
        if ("down", r) in self._known:
            return self._known["down", r]
        if r - 1 == self.grid[self.below[r - 1]]:
            return self.order(r)
        return self._derived("down", r, f"{self.down(r - 1)} {self.order(r)} +")

    def clause_left(self, i: int) -> int:
        """Return the number of sample i's clause on the left, moved up to the grid."""
        clause, r = self.formula.goes[self.m, "left"][self.j, i], self.ranks[i]
        if self.grid[self.below[r]] == r:
            return clause
        known = self._known.get(("left", i))
        return known or self._derived("left", i, f"{clause} {self.up(r)} +")

    def clause_right(self, i: int) -> int:
        """Return the number of sample i's clause on the right, moved down to the grid."""
        clause, r = self.formula.goes[self.m, "right"][self.j, i], self.ranks[i]
        if self.grid[self.below[r]] == r:
            return clause
        known = self._known.get(("right", i))
        return known or self._derived("right", i, f"{clause} {self.down(r)} +")

    def bundle_left(self, a: int) -> int | None:
        """Return the number of the bundle of the blocks up to rank a; None where there is one only."""
        return self._bundles_left(a)[0]

    def bundle_right(self, b: int) -> int | None:
        """Return the number of the bundle of the blocks from rank b on; None where there is one at most."""
        return self._bundles_right(b)[0]

    def _bundles_left(self, a: int) -> Bundle:
        if a == 0:
            return None, 0
        if a not in self._left:
            t = self.below[a]
            on_grid = self.grid[t] == a
            before = self._bundles_left(self.grid[t - 1] if on_grid else a - 1)
            self._left[a] = self._longer(before, self.up(self.grid[t - 1]) if on_grid else self.order(a))
        return self._left[a]

    def _bundles_right(self, b: int) -> Bundle:
        t = self.below[b]
        on_grid = self.grid[t] == b
        after = self.grid[t + 1] if on_grid and b < self.last else b + 1
        if after >= self.last:
            return None, 0
        if b not in self._right:
            self._right[b] = self._longer(self._bundles_right(after), self.up(b) if on_grid else self.order(after))
        return self._right[b]

    def _longer(self, bundle: Bundle, step: int) -> Bundle:
        number, size = bundle
        if number is None:
            return step, 1
        return self.lines.derive(f"{number}{times(step, size + 1)}"), size + 1

    def literals_left(self, a: int) -> list[int]:
        """Return the ranks beyond the grid rank below a, up to a."""
        return list(range(self.grid[self.below[a]] + 1, a + 1))

    def literals_right(self, b: int) -> list[int]:
        """Return the ranks from b on, below the next grid rank, that can go left."""
        if self.grid[self.below[b]] == b:
            return []
        return list(range(b, min(self.grid[self.below[b] + 1], self.last)))

    def axioms_left(self, a: int) -> int | None:
        """Return the number of "0 or more of the ranks of `literals_left` do not go left"."""
        names = [f"~{self.name(r)}" for r in self.literals_left(a)]
        return self._derived("axioms left", a, total(names)) if names else None

    def axioms_right(self, b: int) -> int | None:
        """Return the number of "0 or more of the ranks of `literals_right` go left"."""
        names = [self.name(r) for r in self.literals_right(b)]
        return self._derived("axioms right", b, total(names)) if names else None
