"""All trees within some amount of the optimum, counted.

optimum   a tree from the exact core; the count itself proves it, since a better one would be counted
count     native core: cuts of the root that may belong, then the trees of each (docs/theory/near-optimal.md)
limit     optimum + amount, in exact arithmetic: a tree at the border belongs
"""

import math
import time
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby

from octmip.errors import ProblemError, SolverError
from octmip.trees import _native
from octmip.trees.answer import interruption
from octmip.trees.answer.certificate import checked_leaf_index
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.encoding import centred_tree
from octmip.trees.encoding.ranks import Ranks, threshold_of_cut
from octmip.trees.near_sets.near_set import Cut, Entry, NearOptimalSet, NearTree, Place, RootInterval, Wanted
from octmip.trees.near_sets.whole_numbers import WholeProblem, whole_problem
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import refuse_unknown
from octmip.trees.solver import solve

FIRST_SHARE = 0.5
"""Share of the time that the proof of the optimum may take."""
UNCOUNTABLE = 2**127
"""Counts of this size may have overflown."""


@interruption.whole_call()
def near_optimal(
    problem: Problem,
    within: float | Fraction | None = None,
    relative: float | Fraction | None = None,
    limits: Limits = Limits(),  # noqa: B008 - frozen
    *,
    by_sets: bool = False,
    most_predictions: int = 1_000_000,
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
) -> NearOptimalSet:
    """Return the set of all trees whose objective is within some amount of the proven optimum.

    Parameters
    ----------
    problem
        with ``split="axis"``; any weights, costs, leaf size, penalty and sensor budget.
    within
        amount above the optimum, in units of cost; exactly the float64 that is given.
    relative
        the same as a share of the optimum; a float is the decimal that it is written as (0.01 is 1/100).
    limits
        seconds and nodes of the whole; reaching one is no error, what is counted comes back.
    by_sets
        also count the trees by the set of sensors that they read. A sensor budget that binds does so in any case.
    most_predictions
        distinct predictions are counted for sets of so many trees at most.
    incumbent
        a solution or tree to start from; a proven optimum saves its proof.
    seed, n_jobs, progress
        of the search for the optimum; threads serve the count too.

    Raises
    ------
    ProblemError
        the splits are hyperplanes, not one of `within` and `relative` is given, or weights and costs span too
        many digits.
    SolverError
        there are more than 2**127 trees.

    Examples
    --------
    >>> near_optimal(Problem([[0, 0], [1, 1]], ["a", "b"], depth=1), within=0).trees
    2
    """
    started = time.perf_counter()
    _check(problem, within, relative)
    first = _optimum(problem, limits, incumbent, seed, n_jobs, progress)
    margin = _Margin(Fraction(within) if within is not None else None, _decimal(relative))
    whole = whole_problem(problem, first.tree, by_sets)
    known = problem.exact_objective(first.tree)
    if first.stop is Stop.INTERRUPTED:
        interruption.note()
    seconds = 0.0 if interruption.is_heard() else max(0.0, limits.seconds - (time.perf_counter() - started))
    counted = whole.native.count(
        whole.units(margin.above(known)), replace(limits, seconds=seconds, gap=0.0), n_jobs, None
    )
    if counted.stop == Stop.INTERRUPTED:
        interruption.note()
    count = _Count(problem, whole, margin, known, first, counted)
    note, predictions = count.predictions(most_predictions, limits.seconds - (time.perf_counter() - started))
    return replace(
        count.result(), predictions=predictions, predictions_note=note, seconds=time.perf_counter() - started
    )


def _decimal(number: float | Fraction | None) -> Fraction | None:
    return None if number is None else Fraction(str(number))


def _check(problem: Problem, within: float | Fraction | None, relative: float | Fraction | None) -> None:
    refuse_unknown(problem, "near_optimal")
    if problem.shape.split != "axis":
        raise ProblemError("trees are counted with splits over one feature but split is 'hyperplane'; use split='axis'")
    if (within is None) == (relative is None):
        raise ProblemError(
            f"within is {within} and relative is {relative}; expected one of the two, for instance relative=0.01"
        )
    given = within if within is not None else relative
    assert given is not None
    if not (0 <= given < math.inf):
        raise ProblemError(f"trees within {given} of the optimum are asked for; expected a number of 0 or more")


def _optimum(
    problem: Problem,
    limits: Limits,
    incumbent: Node | Solution | None,
    seed: int,
    n_jobs: int,
    progress: ProgressCallback | None,
) -> Solution:
    if isinstance(incumbent, Solution) and incumbent.is_optimal:
        return incumbent
    share = replace(limits, seconds=limits.seconds * FIRST_SHARE)
    return solve(problem, "exact", share, incumbent, seed=seed, n_jobs=n_jobs, progress=progress)


@dataclass(frozen=True, slots=True)
class _Margin:
    """How far above the optimum a tree may be."""

    within: Fraction | None
    relative: Fraction | None

    def above(self, cost: Fraction) -> Fraction:
        if self.within is not None:
            return cost + self.within
        assert self.relative is not None
        return cost * (1 + self.relative)


class _Count:
    """What the core has counted up to a cost, cut down to the set that was asked for."""

    def __init__(
        self,
        problem: Problem,
        whole: WholeProblem,
        margin: _Margin,
        known: Fraction,
        first: Solution,
        found: _native.Counted,
    ) -> None:
        self.problem, self.whole, self.margin = problem, whole, margin
        leaves, cuts = found.leaves, [Cut(**cut) for cut in found.cuts]
        self.open_features, self.n_nodes = found.open, first.n_nodes + found.n_nodes
        self.is_complete = not self.open_features and all(cut.trees is not None for cut in cuts)
        stop = Stop.INTERRUPTED if interruption.is_heard() else Stop(found.stop)
        self.stop = Stop.FINISHED if self.is_complete else stop
        counted = [entry for entries in (leaves, *(cut.trees or [] for cut in cuts)) for entry in entries]
        self.optimum = self._optimum(counted, known, first)
        # Without a proven optimum, what is within the amount above its bound is in the set for certain.
        least = self.optimum if self.optimum is not None else Fraction(max(0.0, first.bound))
        self.limit = margin.above(least)
        self.units = whole.units(self.limit)
        self.leaves = self._kept(leaves)
        cuts = [cut if cut.trees is None else cut._replace(trees=self._kept(cut.trees)) for cut in cuts]
        self.cuts = [cut for cut in cuts if cut.trees is None or cut.trees]

    def _optimum(self, counted: Sequence[Entry], known: Fraction, first: Solution) -> Fraction | None:
        if self.is_complete:
            return self.whole.cost(min(cost for cost, _, _ in counted))
        is_exact = first.is_optimal and first.tolerance == 0 and Fraction(first.bound) >= known
        return known if is_exact else None

    def _kept(self, entries: list[Entry]) -> list[Entry]:
        return [entry for entry in entries if entry[0] <= self.units]

    @property
    def places(self) -> tuple[Place, ...]:
        of_leaves = [Place(None, entry) for entry in self.leaves]
        of_cuts = [Place(cut._replace(trees=None), entry) for cut in self.cuts for entry in cut.trees or []]
        return (*of_leaves, *of_cuts)

    @property
    def n_trees(self) -> int:
        total = sum(place.entry[2] for place in self.places)
        if total >= UNCOUNTABLE:
            raise SolverError("there are more than 2**127 trees, too many to count; ask for less above the optimum")
        return total

    def predictions(self, most: int, seconds: float) -> tuple[str, int | None]:
        if not self.is_complete:
            return "not counted: not all trees are", None
        if self.n_trees > most:
            return f"not counted: {self.n_trees} trees are more than {most}, the most that are walked through", None
        found = self.whole.native.predictions(self.units, most, max(0.0, seconds))
        if found is None:
            return f"not counted: out of time, or some part of the trees predicts in more than {most} ways", None
        return "told apart by 128-bit hashes", found

    def result(self) -> NearOptimalSet:
        total = self.n_trees
        spectrum: Counter[int] = Counter()
        for place in self.places:
            spectrum[place.entry[0]] += place.entry[2]
        intervals = _intervals(self.cuts, self.whole.ranks)
        return NearOptimalSet(
            problem=self.problem,
            optimum=self.optimum,
            limit=None if self.optimum is None else self.limit,
            trees=total if self.is_complete else None,
            trees_at_least=total,
            predictions=None,
            predictions_note="",
            spectrum=tuple((self.whole.cost(units), n) for units, n in sorted(spectrum.items())),
            by_root=self._by_root(),
            by_sensors=self._by_sensors(),
            roots=tuple(interval for interval in intervals if interval.trees is not None),
            open=(
                *(interval for interval in intervals if interval.trees is None),
                *(open for column in self.open_features for open in _whole_column(column, self.whole.ranks)),
            ),
            stop=self.stop,
            seconds=0.0,
            n_nodes=self.n_nodes,
            _unit=self.whole.cost(1),
            _places=self.places,
            _look_up=self.look_up,
        )

    def _by_root(self) -> dict[str, int]:
        by_root: dict[str, int] = defaultdict(int)
        for place in self.places:
            feature = None if place.cut is None else self.whole.ranks.feature(place.cut.feature)
            by_root["" if feature is None else self.problem.samples.feature_names[feature]] += place.entry[2]
        return dict(sorted(by_root.items(), key=lambda item: -item[1]))

    def _by_sensors(self) -> dict[tuple[str, ...], int] | None:
        masks: Counter[int] = Counter()
        for place in self.places:
            masks[place.entry[1]] += place.entry[2]
        is_told_apart = any(masks) or (self.is_complete and not self.cuts)
        if not is_told_apart:
            return None
        named = {
            tuple(name for s, name in enumerate(self.problem.shape.sensors) if mask >> s & 1): n
            for mask, n in masks.items()
        }
        return dict(sorted(named.items(), key=lambda item: -item[1]))

    def look_up(self, chosen: list[tuple[Place, int]]) -> list[NearTree]:
        """Return trees by their number among those of one place, each checked: a tree of the problem of that cost."""
        wanted = [Wanted(place.cut, place.entry[0], place.entry[1], number) for place, number in chosen]
        rows = self.whole.native.trees(wanted)
        if rows is None:
            if interruption.is_heard():
                raise KeyboardInterrupt
            raise SolverError("the trees were not looked up: interrupted, or a count that is not theirs")
        found = []
        for (place, _), row in zip(chosen, rows, strict=True):
            tree = centred_tree(row, self.whole.ranks, self.problem.samples.features)
            checked_leaf_index(self.problem, tree)
            if self.problem.exact_objective(tree) != self.whole.cost(place.entry[0]):
                raise SolverError(f"a tree counted at {self.whole.cost(place.entry[0])} costs something else")
            found.append(NearTree(tree, self.problem.objective(tree)))
        return found


def _intervals(cuts: Sequence[Cut], ranks: Ranks) -> list[RootInterval]:
    """Return runs of neighbouring cuts of one feature and side for missing readings, counted ones and others apart."""
    found = []
    numbered = enumerate(sorted(cuts, key=lambda cut: (cut.feature, cut.rank)))
    for _, run in groupby(numbered, lambda item: (_group(item[1], ranks), item[1].rank - item[0])):
        members = [cut for _, cut in run]
        entries = [cut.trees for cut in members]
        trees = None if entries[0] is None else sum(entry[2] for cut in entries for entry in cut or [])
        found.append(_interval(ranks, members[0].feature, range(members[0].rank, members[-1].rank + 1), trees))
    return found


def _group(cut: Cut, ranks: Ranks) -> tuple[int, bool, bool]:
    return cut.feature, cut.trees is None, threshold_of_cut(ranks, cut.feature, cut.rank) is None


def _interval(ranks: Ranks, column: int, cuts: range, trees: int | None) -> RootInterval:
    first, last = (threshold_of_cut(ranks, column, cut) for cut in (cuts[0], cuts[-1]))
    return RootInterval(ranks.feature(column), first, last, ranks.side(column), len(cuts), trees)


def _whole_column(column: int, ranks: Ranks) -> list[RootInterval]:
    """Return the intervals of all cuts of a column that no other column has."""
    n_cuts, side = ranks.n_values[column] - 1, ranks.side(column)
    gap = [range(1)] if side == "left" else []  # as the last cut of the column that ranks them above
    rest = range(1, n_cuts) if side == "left" else range(n_cuts - 1) if side == "right" else range(n_cuts)
    return [_interval(ranks, column, cuts, None) for cuts in (*gap, rest) if cuts]
