"""Lemmas "on these samples, every stump at node m costs c or more", and the sums that consecutive lemmas share.

    sum_{i in X} price_i * wrong[m, i]  +  penalty * split[m]  >=  c

Proof by contradiction. For each column the cuts are divided into intervals: cuts from a to b - 1, so that samples of
ranks up to a surely go left, from b on surely right. Added up, their clauses and "one label at most" count both leaves;
with the negation they give "not left[a] or left[b]". All intervals of a column together: "not left[0]", the column is
not split on. No split at all is counted in the same way, and one of all these must be.

X grows from lemma to lemma. The clauses of its samples are summed by the blocks of each column's grid, and a sum is
carried on with the new samples alone, so that a lemma names blocks, and samples only where an interval ends inside one.
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.pseudo_boolean.column import Column
from octmip.pseudo_boolean.counts import StumpCosts
from octmip.pseudo_boolean.formula import Formula, label
from octmip.pseudo_boolean.lines import Lines, times, total
from octmip.pseudo_boolean.sizes import Side, Sizes


@dataclass(frozen=True, slots=True)
class Interval:
    """Cuts from a to b - 1 of one column, and which of the two leaves are counted, or which has too few samples."""

    a: int
    b: int
    counts_left: bool
    counts_right: bool
    too_few: str | None = None


@dataclass(slots=True)
class _Sums:
    """Sums over the samples of X in the blocks of one column; each is the number of a constraint."""

    left: dict[int, int]
    right: dict[int, int]
    gaps: dict[int, int]  # wrong[m, i] >= 0, ranks between two grid ranks
    on_grid: dict[int, int]  # the same, ranks on the grid


class Stump:
    """Lemmas of one node whose sides are leaves."""

    def __init__(self, formula: Formula, lines: Lines, m: int) -> None:
        self.formula, self.lines, self.m = formula, lines, m
        self.question = formula.question
        self.prices: list[int] = self.question.prices.tolist()
        self.columns = [Column(formula, lines, m, j) for j in range(self.question.n_columns)]
        self.sizes = Sizes(formula, lines, m)
        self.splits = [self._used_means_split(j) for j in range(self.question.n_columns)]
        self.begin()

    def _used_means_split(self, j: int) -> int | None:
        """Return the number of "split[m] or not left[m, j, 0]", where a split has a price or a leaf a size."""
        if not self.question.penalty and self.question.leaf_size == 1:
            return None
        others = [f" {column.name(0)} w" for column in self.columns if column.j != j]
        return self.lines.derive(f"{self.formula.single[self.m]}{''.join(others)}")

    def begin(self, columns: Collection[int] | None = None) -> None:
        """Begin with no samples, and the columns that a stump may read (None: all)."""
        self.active = [column for column in self.columns if columns is None or column.j in columns]
        self.members = np.zeros(self.question.n_samples, dtype=np.bool_)
        self.sums = [_Sums({}, {}, {}, {}) for _ in self.columns]
        self.unsplit: int | None = None

    def end(self) -> None:
        """Delete all sums."""
        for sums in self.sums:
            for kind in (sums.left, sums.right, sums.gaps, sums.on_grid):
                self.lines.delete(kind.values())
        if self.unsplit is not None:
            self.lines.delete([self.unsplit])
        self.begin()

    def prove(self, part: NDArray[np.bool_], costs: StumpCosts, least: int, side: Side) -> int:
        """Return the number of the lemma: on a part, which grows from call to call, every stump costs `least`.

        Or else the assumption of `side` is false, or the stump reads another column than those in play.
        """
        new = np.flatnonzero(part & ~self.members).tolist()
        self.members = part
        self._grow(new)
        plans = [self._intervals(column, costs, least) for column in self.active]
        for column, plan in zip(self.active, plans, strict=True):
            _prepare(column, plan)
        terms = [(self.prices[i], f"w{self.m}_{i}") for i in np.flatnonzero(part).tolist()]
        if self.question.penalty:
            terms.append((self.question.penalty, f"s{self.m}"))
        names = [name for _, name in terms]
        others = [column.name(0) for column in self.columns if column not in self.active]
        free = [*side.literals, *others]
        terms += [(least, literal) for literal in free]
        negation = self.lines.begin(" ".join(f"{price} {name}" for price, name in terms), least)
        big = sum(price for price, _ in terms) + 1
        forced = ""
        if free:  # the negation says that all of these are false; with that it is two constraints
            false = self.lines.derive(f"{negation} {' w '.join(names)} w {least} d")
            negation = self.lines.derive(f"{negation} {' w '.join(literal.lstrip('~') for literal in free)} w")
            forced = times(false, len(self.active) + 1)
        unused = [
            _ColumnProof(self, column, costs, negation, big).unused(plan, side)
            for column, plan in zip(self.active, plans, strict=True)
        ]
        split = self._not_unsplit(costs, negation, big)
        return self.lines.end(self.lines.derive(total([self.formula.some[self.m], split, *unused]) + forced))

    def _not_unsplit(self, costs: StumpCosts, negation: int, big: int) -> int:
        """Return the number of "node m splits": one leaf for all costs too much."""
        assert self.unsplit is not None
        operations = f"{negation} {self.unsplit} +{self.counted('right', costs.total.tolist())}"
        if self.question.penalty:
            operations += times(f"s{self.m}", self.question.penalty)
        return self.lines.derive(f"{operations} {big} d")

    def counted(self, side: str, prices: list[int]) -> str:
        """Return the operations that turn labels' prices into what a leaf costs at least, whatever its label."""
        most = max(prices)
        rest = [f" {label(self.m, side, k)} w" for k, price in enumerate(prices) if price < most]
        return times(self.formula.one_label[self.m, side], most) + "".join(rest)

    def _intervals(self, column: Column, costs: StumpCosts, least: int) -> list[Interval]:
        """Return intervals that cover the cuts of a column, each closed by the leaves that it counts."""
        left, right = costs.cost_left[column.j], costs.cost_right[column.j]
        need = least - self.question.penalty
        ascending = right[::-1]
        first, final = costs.first[column.j], costs.last[column.j]
        found, a = [], first
        if first:
            found.append(Interval(0, first, False, False, "left"))
        while a <= final:
            lacking = need - int(left[a])
            if lacking <= 0:
                b = column.last
            else:  # the last rank from which on the right costs what the left lacks
                b = min(column.last, len(right) - 1 - int(np.searchsorted(ascending, lacking)))
            grid = column.grid[column.below[b]]
            if grid > a:
                b = grid
            assert b > a, "a cut costs less than the lemma says"
            found.append(Interval(a, b, int(left[a]) > 0 and (lacking <= 0 or int(right[b]) < need), lacking > 0))
            a = b
        if a < column.last:
            found.append(Interval(a, column.last, False, False, "right"))
        return found

    def _grow(self, new: list[int]) -> None:
        """Add samples to all sums."""
        if not new:
            return
        clauses = ((self.formula.unsplit[self.m, i], self.prices[i]) for i in new)
        self.unsplit = self._carried(self.unsplit, list(clauses), [])
        for column in self.active:
            self._grow_column(column, self.sums[column.j], new)

    def _grow_column(self, column: Column, sums: _Sums, new: list[int]) -> None:
        groups: dict[tuple[int, int], list[tuple[int | str, int]]] = {}
        for i in new:
            r, price = column.ranks[i], self.prices[i]
            above, below = column.above(r), column.below[r]
            if column.grid[above] < column.last:
                groups.setdefault((0, above), []).append((column.clause_left(i), price))
            if below > 0:
                groups.setdefault((1, below), []).append((column.clause_right(i), price))
            groups.setdefault((3 if above == below else 2, below), []).append((f"w{self.m}_{i}", price))
        old = []
        kinds = (sums.left, sums.right, sums.gaps, sums.on_grid)
        for (kind, t), added in groups.items():
            known = kinds[kind].get(t)
            literal = [f"~{column.name(column.grid[t])}"] if kind == 0 else [column.name(column.grid[t])]
            has_literal = kind < 2 and column.grid[t] < column.last
            kinds[kind][t] = self._sum(known, added, literal if has_literal else [])
            old += [] if known is None else [known]
        self.lines.delete(old)

    def _carried(self, known: int | None, added: list[tuple[int, int]], literals: list[str]) -> int:
        number = self._sum(known, list(added), literals)
        if known is not None:
            self.lines.delete([known])
        return number

    def _sum(self, known: int | None, added: list[tuple[int | str, int]], literals: list[str]) -> int:
        """Return the number of a sum carried on; a new one begins with its literals, so that they are always there."""
        if known is None:
            (first, price), *added = added
            start = f"{first}" if price == 1 else f"{first} {price} *"
            start += "".join(times(literal, 1) for literal in literals)
        else:
            start = f"{known}"
        return self.lines.derive(start + "".join(times(operand, price) for operand, price in added))


def _prepare(column: Column, plan: list[Interval]) -> None:
    """Derive what the intervals of a column need and later lemmas may need again."""
    for interval in plan:
        if interval.counts_left:
            column.bundle_left(interval.a)
            column.axioms_left(interval.a)
        if interval.counts_right and interval.b < column.last:
            column.bundle_right(interval.b)
            column.axioms_right(interval.b)


class _ColumnProof:
    """The part of a lemma's proof that closes one column."""

    def __init__(self, stump: Stump, column: Column, costs: StumpCosts, negation: int, big: int) -> None:
        self.stump, self.column, self.costs = stump, column, costs
        self.negation, self.big = negation, big + column.last
        self.sums = stump.sums[column.j]
        self.at_rank: dict[int, list[int]] = {}
        for i in np.flatnonzero(stump.members).tolist():
            self.at_rank.setdefault(column.ranks[i], []).append(i)

    def unused(self, plan: list[Interval], side: Side) -> int:
        """Return the number of "the column is not split on, or the assumption is false"."""
        column, lines, penalty = self.column, self.stump.lines, self.stump.question.penalty
        lefts = self._running_left(sorted({x.a for x in plan if x.counts_left}))
        rights = self._running_right(sorted({x.b for x in plan if x.counts_right}, reverse=True))
        clauses = []
        for x in plan:
            if x.too_few is None:
                operations = self._interval(x, lefts.get(x.a), rights.get(x.b))
            else:
                rank = x.b if x.too_few == "left" else x.a
                operations = self.stump.sizes.too_few(side, x.too_few, column.j, rank)
            clauses.append(lines.derive(operations))
        if len(clauses) == 1 and not penalty and plan[0].too_few is None:
            return clauses[0]
        split = self.stump.splits[column.j]
        # Clauses that hold where the node does not split: all but counts of samples on the right.
        n_free = sum(x.too_few == "left" or (penalty > 0 and x.too_few is None) for x in plan)
        joined = total(clauses) + (times(split, n_free) if split is not None and n_free else "")
        return lines.derive(f"{joined} s")

    def _interval(self, x: Interval, left: int | None, right: int | None) -> str:
        column, costs = self.column, self.costs
        operations, bundles = f"{self.negation}", ""
        mid_from, mid_to = (x.a + 1 if x.counts_left else 0), (x.b if x.counts_right else column.last + 1)
        if x.counts_left:
            operations += self._leaf("left", x.a, left, costs.left[column.j][x.a].tolist())
            bundle = column.bundle_left(x.a)
            bundles += "" if bundle is None else f" {bundle} +"
        if x.counts_right:
            beyond = costs.total - costs.left[column.j][x.b - 1]
            operations += self._leaf("right", x.b, right, beyond.tolist())
            bundle = column.bundle_right(x.b) if x.b < column.last else None
            bundles += "" if bundle is None else f" {bundle} +"
        operations += self._weakened(mid_from, mid_to)
        if not x.counts_left:
            operations += f" ~{column.name(x.a)} +"
        if not x.counts_right and x.b < column.last:
            operations += f" {column.name(x.b)} +"
        return f"{operations} {self.big} d{bundles}{' s' if bundles else ''}"

    def _leaf(self, side: str, rank: int, running: int | None, prices: list[int]) -> str:
        """Return the operations that add what is counted at one leaf: whole blocks, single samples, labels."""
        column = self.column
        operations = "" if running is None else f" {running} +"
        if side == "left":
            axioms, ranks = column.axioms_left(rank), column.literals_left(rank)
        else:
            bottom = column.grid[column.below[rank]]
            off_grid = range(rank, column.grid[column.below[rank] + 1]) if rank != bottom else range(0)
            ranks = list(off_grid)
            axioms = column.axioms_right(rank) if rank < column.last else None
        operations += "" if axioms is None else f" {axioms} +"
        goes = self.stump.formula.goes[self.stump.m, side]
        for r in ranks:
            for i in self.at_rank.get(r, ()):
                operations += times(goes[column.j, i], self.stump.prices[i])
        return operations + self.stump.counted(side, prices)

    def _weakened(self, start: int, stop: int) -> str:
        """Return the operations that take samples of ranks from start to stop - 1 out of the negation."""
        column, operations, r = self.column, "", start
        while r < stop:
            t = column.below[r]
            on_grid = column.grid[t] == r
            after = r + 1 if on_grid else (column.grid[t + 1] if t + 1 < len(column.grid) else column.last + 1)
            sums = self.sums.on_grid if on_grid else self.sums.gaps
            whole = after <= stop and (on_grid or r == column.grid[t] + 1)
            members = [i for rank in range(r, min(after, stop)) for i in self.at_rank.get(rank, ())]
            if whole and len(members) > 1:
                operations += f" {sums[t]} +"
            else:
                operations += "".join(f" w{self.stump.m}_{i} w" for i in members)
            r = min(after, stop)
        return operations

    def _running_left(self, places: list[int]) -> dict[int, int]:
        """Return the sums of all whole blocks up to each place."""
        column, found, running, t = self.column, {}, [], 0
        for a in places:
            while t < len(column.grid) and column.grid[t] <= a:
                number = self.sums.left.get(t)
                running.append(f"~{column.name(column.grid[t])}" if number is None else f"{number}")
                t += 1
            found[a] = self._joined(running)
            running = [f"{found[a]}"]
        return found

    def _running_right(self, places: list[int]) -> dict[int, int | None]:
        """Return the sums of all whole blocks from each place on."""
        column, found, running, t = self.column, {}, [], len(self.column.grid) - 1
        for b in places:
            while t >= 0 and column.grid[t] >= b:
                number = self.sums.right.get(t)
                if number is not None:
                    running.append(f"{number}")
                elif column.grid[t] < column.last:
                    running.append(column.name(column.grid[t]))
                t -= 1
            found[b] = self._joined(running) if running else None
            running = [] if found[b] is None else [f"{found[b]}"]
        return found

    def _joined(self, parts: list[str]) -> int:
        if len(parts) == 1 and parts[0].isdigit():
            return int(parts[0])
        return self.stump.lines.derive(total(parts))
