"""A proof that every tree of a formula costs a bound or more."""

import numpy as np
from numpy.typing import NDArray

from octmip.errors import SolverError
from octmip.pseudo_boolean.budget import Budget
from octmip.pseudo_boolean.counts import Counts
from octmip.pseudo_boolean.formula import Formula, left
from octmip.pseudo_boolean.lines import Lines, times, total
from octmip.pseudo_boolean.roots import Group, RootInterval, Roots, groups
from octmip.pseudo_boolean.sizes import Side
from octmip.pseudo_boolean.stump import Stump


def prove(formula: Formula, bound: int) -> tuple[Lines, int]:
    """Return a proof of a bound of the objective, and the number of the constraint that states it.

    Raises
    ------
    SolverError
        a tree costs less than the bound.
    """
    lines = Lines(len(formula.lines))
    if bound <= 0:  # what no objective can be below: prices are positive
        return lines, lines.derive(total(f"{name} {price} *" for price, name in formula.objective))
    if formula.question.depth == 2:
        return lines, _Root(formula, lines, bound).prove()
    everything = np.ones(formula.question.n_samples, dtype=np.bool_)
    everybody = np.ones(formula.question.all_ranks.shape[1], dtype=np.bool_)
    costs = Counts(formula.question).stumps(everything, everybody)
    if costs.least < bound:
        raise _too_high(bound)
    return lines, Stump(formula, lines, 0).prove(everything, costs, bound, Side((), 0, 0, everybody))


def _too_high(bound: int) -> SolverError:
    return SolverError(f"the second search finds a tree below the bound {bound}; no proof is written, please report it")


class _Root:
    """The proof for trees of depth 2: lemmas for both sides of the root, column by column, then all together."""

    def __init__(self, formula: Formula, lines: Lines, bound: int) -> None:
        self.formula, self.lines, self.bound = formula, lines, bound
        self.question = formula.question
        self.prices: list[int] = self.question.prices.tolist()
        self.roots = Roots(self.question, bound)
        self.budget = Budget(formula, lines)
        self.stumps = {side: Stump(formula, lines, m) for side, m in (("left", 1), ("right", 2))}

    def prove(self) -> int:
        """Return the number of "the objective is the bound or more"."""
        question, lines = self.question, self.lines
        plans: list[list[tuple[Group, list[RootInterval], list[int | None]]]] = []
        for j in range(question.n_columns):
            plans.append([])
            for group in groups(question, j):
                plan = self.roots.intervals(j, group)
                if plan is None:
                    raise _too_high(self.bound)
                plans[j].append((group, plan, self._column(j, plan, group)))
        used = [self._used_means_split(j) for j in range(question.n_columns)] if question.penalty else []
        whole = self._one_leaf()
        terms = " ".join(f"{price} {name}" for price, name in self.formula.objective)
        negation = lines.begin(terms, self.bound)
        big = 4 * sum(price for price, _ in self.formula.objective) + question.all_ranks.shape[1] + 1
        unused = []
        for j, cases in enumerate(plans):
            closed = {}
            for group, plan, sums in cases:
                parts = [self._closed(j, x, number, negation, big) for x, number in zip(plan, sums, strict=True)]
                n_free = sum(x.too_few is None for x in plan)
                with_split = times(used[j], n_free) if used and n_free else ""
                closed[group] = lines.derive(f"{total(parts)}{with_split}{self._others(group)} s")
            unused.append(self.budget.joined(j, closed))
        penalty = question.penalty
        free = f" s1 w s2 w{times('s0', penalty)}" if penalty else ""
        split = lines.derive(f"{negation} {whole} +{free} {2 * big} d")
        return lines.end(lines.derive(total([self.formula.some[0], split, *unused])))

    def _others(self, group: Group) -> str:
        """Return the operations that name all columns outside a group, so that every case has the same literals."""
        columns = range(self.question.n_columns)
        outside = [left(1, k, 0) for k in columns if k not in group.left]
        outside += [left(2, k, 0) for k in columns if k not in group.right]
        return "".join(f" {name} +" for name in outside)

    def _used_means_split(self, j: int) -> int:
        others = "".join(f" {left(0, k, 0)} w" for k in range(self.question.n_columns) if k != j)
        return self.lines.derive(f"{self.formula.single[0]}{others}")

    def _closed(self, j: int, x: RootInterval, number: int | None, negation: int, big: int) -> int:
        """Return the number of "not left[a] or left[b]" at the root, samples between a and b left out."""
        if x.too_few is not None:
            assert number is not None
            literal = f" ~{left(0, j, x.a)} +" if x.too_few == "left" else ""
            if x.too_few == "right" and x.b < self.question.n_ranks[j] - 1:
                literal = f" {left(0, j, x.b)} +"
            return self.lines.derive(f"{number}{literal}")
        ranks = self.question.ranks[j]
        counted = ((ranks <= x.a) & (x.least_left > 0)) | ((ranks >= x.b) & (x.least_right > 0))
        between = np.flatnonzero(~counted)
        free = "".join(f" w0_{i} w" for i in between.tolist())
        literals = ""
        if not x.least_left:
            literals += f" ~{left(0, j, x.a)} +"
        if not x.least_right and x.b < self.question.n_ranks[j] - 1:
            literals += f" {left(0, j, x.b)} +"
        if self.question.penalty:
            free += (" s1 w" if not x.least_left else "") + (" s2 w" if not x.least_right else "")
        sides = "" if number is None else f" {number} +"
        return self.lines.derive(f"{negation}{sides}{free}{literals} {big} d")

    def _column(self, j: int, plan: list[RootInterval], group: Group) -> list[int | None]:
        """Return for each interval the number of what its sides cost under its cuts, None where they may cost 0."""
        lefts = self._side("left", j, [x for x in plan if x.least_left], group)
        rights = self._side("right", j, [x for x in reversed(plan) if x.least_right], group)
        sums: list[int | None] = []
        for x in plan:
            if x.too_few is not None:
                stump = self.stumps[x.too_few]
                few = stump.sizes.too_few(self._assumption(x.too_few, j, x), "right", None, 0)
                sums.append(self.lines.derive(few))
                continue
            parts = [side[rank] for side, rank in ((lefts, x.a), (rights, x.b)) if rank in side]
            sums.append(self.lines.derive(total(parts)) if len(parts) > 1 else parts[0] if parts else None)
        self.lines.delete(sorted({*lefts.values(), *rights.values()} - set(sums)))
        return sums

    def _assumption(self, side: str, j: int, x: RootInterval) -> Side:
        """Return what a lemma of one side of an interval may assume: only leaf sizes need it."""
        all_ranks, last = self.question.all_ranks[j], int(self.question.n_ranks[j]) - 1
        if side == "left":
            beyond = (left(0, j, x.b),) if x.b < last else ()
            literals, rank, candidates = (f"~{left(0, j, 0)}", *beyond), x.b, all_ranks < x.b
        else:
            literals, rank, candidates = (f"~{left(0, j, x.a)}",), x.a, all_ranks > x.a
        return Side(literals if self.question.leaf_size > 1 else (), j, rank, candidates)

    def _side(self, side: str, j: int, plan: list[RootInterval], group: Group) -> dict[int, int]:
        """Return for each rank the number of what the side that it begins or ends costs, under such a cut."""
        stump, found = self.stumps[side], {}
        stump.begin(group.left if side == "left" else group.right)
        routed: int | None = None
        members = np.zeros(self.question.n_samples, dtype=np.bool_)
        before = 0
        for x in plan:
            rank, least = (x.a, x.least_left) if side == "left" else (x.b, x.least_right)
            ranks = self.question.ranks[j]
            part = ranks <= rank if side == "left" else ranks >= rank
            costs = self.roots.costs(j, side, (x.a, x.b), group)
            lemma = stump.prove(part, costs, least, self._assumption(side, j, x))
            carried = self._routed(side, j, routed, (before, rank), part & ~members)
            self.lines.delete([] if routed is None else [routed])
            routed, members, before = carried, part, rank
            found[rank] = self.lines.derive(f"{routed} {lemma} +")
            self.lines.delete([lemma])
        self.lines.delete([] if routed is None else [routed])
        stump.end()
        return found

    def _routed(self, side: str, j: int, known: int | None, step: tuple[int, int], new: NDArray[np.bool_]) -> int:
        """Return the number of the sum of "wrong[0, i], or right on this side, or the cut is elsewhere"."""
        before, rank = step
        question, order = self.question, self.formula.order
        last = int(question.n_ranks[j]) - 1
        ranks = question.ranks[j]
        at_rank: dict[int, list[int]] = {}
        for i in np.flatnonzero(new).tolist():
            at_rank.setdefault(int(ranks[i]), []).append(i)
        operations = [] if known is None else [f"{known}"]
        old = ranks <= before if side == "left" else (ranks >= before) & (ranks < last)
        weight = 0 if known is None else int(question.prices[old].sum())
        path = range(min(at_rank, default=rank), rank + 1)
        if known is not None:
            path = range(before, rank + 1) if side == "left" else range(before, rank - 1, -1)
        elif side == "right":
            path = range(last, rank - 1, -1)
        previous = None
        for r in path:
            if previous is not None and weight:
                chain = order[0, j, r] if side == "left" else order.get((0, j, previous))
                if chain is not None and previous < last:
                    operations.append(_more(bool(operations), chain, weight))
            for i in at_rank.get(r, ()):
                operations.append(_more(bool(operations), self.formula.goes[0, side][j, i], self.prices[i]))
                weight += self.prices[i] if r < last else 0
            previous = r
        return self.lines.derive("".join(operations))

    def _one_leaf(self) -> int:
        """Return the number of "without a split at the root, the objective is that of one leaf"."""
        question, formula = self.question, self.formula
        operations: list[str] = []
        for i, price in enumerate(self.prices):
            operations.append(_more(bool(operations), formula.unsplit[0, i], price))
            operations.append(_more(True, formula.unsplit[2, i], price))
        operations.append(times(formula.below[2], sum(self.prices)))
        prices = np.bincount(question.labels, question.prices, question.n_classes).astype(np.int64).tolist()
        return self.lines.derive("".join(operations) + self.stumps["right"].counted("right", prices))


def _more(is_added: bool, number: int, factor: int) -> str:
    if is_added:
        return times(number, factor)
    return f"{number}" if factor == 1 else f"{number} {factor} *"
