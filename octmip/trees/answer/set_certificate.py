"""Certificates of sets of trees: counted again by plain enumeration, each tree's objective again. Imports no solver.

Every cut of every feature, every label of every leaf, in rational numbers; no bound but that no cost is negative. What
it takes grows as (samples x features)^depth, so it serves small problems; the trees that a set lists are checked in
problems of any size.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError
from octmip.trees.answer.certificate import checked_leaf_index
from octmip.trees.nodes.tree import Leaf, Node, predict, splits
from octmip.trees.question.problem import Problem

MOST_CUTS = 200
"""Cuts of all features together up to which a set is enumerated."""


class ListedTree(Protocol):
    """A tree and what it is said to cost."""

    @property
    def tree(self) -> Node:
        """The tree."""

    @property
    def objective(self) -> float:
        """Its objective."""


class CountedSet(Protocol):
    """What a set of trees claims."""

    @property
    def limit(self) -> Fraction | None:
        """The most that its trees cost."""

    @property
    def optimum(self) -> Fraction | None:
        """The least objective of all trees."""

    @property
    def trees(self) -> int | None:
        """How many there are, if that is known."""

    @property
    def trees_at_least(self) -> int:
        """How many there are at least."""

    @property
    def predictions(self) -> int | None:
        """How many vectors of labels they predict, if that is known."""

    @property
    def by_root(self) -> Mapping[str, int]:
        """Number of trees by the feature at the root."""


@dataclass(frozen=True, slots=True)
class Recount:
    """A set of trees as enumeration finds it.

    Attributes
    ----------
    least
        the least objective.
    trees, predictions
        numbers of trees, and of different vectors of labels.
    spectrum
        number of trees by objective.
    by_root
        number of trees by the feature at the root, leaves under "".
    by_sensors
        number of trees by the sensors that they read.
    """

    least: Fraction
    trees: int
    predictions: int
    spectrum: Mapping[Fraction, int]
    by_root: Mapping[str, int]
    by_sensors: Mapping[tuple[str, ...], int]


_Counts = Counter[tuple[int, frozenset[int]]]
_Vectors = dict[tuple[tuple[int, ...], frozenset[int]], int]
_Cut = tuple[int, int]  # feature, mask of the samples left of it


def recount(problem: Problem, limit: Fraction) -> Recount:
    """Return the set of all trees of at most a cost, by enumeration.

    Raises
    ------
    CertificateError
        there are more than `MOST_CUTS` cuts.
    """
    return _Enumeration(problem, limit).recount()


def certify_set(problem: Problem, claimed: CountedSet, listed: Iterable[ListedTree] = ()) -> Recount | None:
    """Recount a set, and the objective of every tree that it lists; None where it is too large to be enumerated.

    Raises
    ------
    CertificateError
        a number is another one, a tree is none of the problem, twice the same, or beyond the limit.
    """
    _check_listed(problem, claimed, listed)
    if claimed.limit is None or sum(_n_cuts(column) for column in problem.samples.features.T) > MOST_CUTS:
        return None
    found = recount(problem, claimed.limit)
    if claimed.optimum != found.least:
        raise CertificateError(f"the set claims the optimum {claimed.optimum} but the best tree costs {found.least}")
    if claimed.trees_at_least > found.trees:
        raise CertificateError(f"the set claims {claimed.trees_at_least} trees or more but there are {found.trees}")
    if claimed.trees is None:
        return found
    pairs = ("trees", claimed.trees, found.trees), ("predictions", claimed.predictions, found.predictions)
    for name, claim, counted in pairs:
        if claim is not None and claim != counted:
            raise CertificateError(f"the set claims {claim} {name} but enumeration counts {counted}")
    if dict(claimed.by_root) != dict(found.by_root):
        raise CertificateError(f"the set claims {claimed.by_root} by root but enumeration counts {found.by_root}")
    return found


def _thresholds(column: NDArray[np.float64]) -> list[float]:
    """Return every reading but the largest: each parts the readings in another way."""
    readings: list[float] = np.unique(column[~np.isnan(column)]).tolist()
    return readings[:-1]


def _n_cuts(column: NDArray[np.float64]) -> int:
    n_thresholds = len(_thresholds(column))
    return 2 * n_thresholds + 1 if np.isnan(column).any() else n_thresholds


def _check_listed(problem: Problem, claimed: CountedSet, listed: Iterable[ListedTree]) -> None:
    for entry in listed:
        checked_leaf_index(problem, entry.tree)
        if not math.isclose(entry.objective, problem.objective(entry.tree), rel_tol=1e-12):
            raise CertificateError(
                f"a listed tree claims {entry.objective} but costs {problem.objective(entry.tree)}, recounted"
            )
        if any(split.left == split.right and isinstance(split.left, Leaf) for split in splits(entry.tree)):
            raise CertificateError("a listed tree splits two leaves of one label; expected the leaf instead")
        exact = _exact_cost(problem, entry.tree)
        if claimed.limit is not None and exact > claimed.limit:
            raise CertificateError(f"a listed tree costs {exact}, above the limit {claimed.limit} of the set")


def _exact_cost(problem: Problem, tree: Node) -> Fraction:
    price = Fraction(problem.shape.leaf_penalty) * len(splits(tree))
    labels = predict(tree, problem.samples.features)
    rows = zip(problem.samples.weights.tolist(), problem.samples.codes.tolist(), labels.tolist(), strict=True)
    return price + sum((Fraction(w) * Fraction(float(problem.costs[i, k])) for w, i, k in rows), Fraction(0))


class _Enumeration:
    """All trees of a problem up to a cost; costs are whole numbers of one unit, a set of samples is a bit mask."""

    def __init__(self, problem: Problem, limit: Fraction) -> None:
        self.problem = problem
        self.cuts = list(self._cuts())
        if len(self.cuts) > MOST_CUTS:
            raise CertificateError(f"the problem has {len(self.cuts)} cuts, too many to enumerate its trees")
        rows = zip(problem.samples.weights.tolist(), problem.samples.codes.tolist(), strict=True)
        costs = [[Fraction(w) * Fraction(float(c)) for c in problem.costs[code]] for w, code in rows]
        price = Fraction(problem.shape.leaf_penalty)
        self.units = math.lcm(price.denominator, *(cost.denominator for row in costs for cost in row))
        self.price, self.limit = int(price * self.units), math.floor(limit * self.units)
        self.costs = [[int(cost * self.units) for cost in row] for row in costs]
        self.fits = cache(self._fits)
        self.sides = cache(lambda samples: list(self._sides(samples)))
        self.counts = cache(self._counts)
        self.vectors = cache(self._vectors)
        self.leaves = cache(self._leaves)

    def _cuts(self) -> Iterable[_Cut]:
        for feature in range(self.problem.samples.n_features):
            if self.problem.shape.is_allowed((feature,)):
                column = self.problem.samples.features[:, feature]
                is_missing = np.isnan(column)
                lefts = [column <= low for low in _thresholds(column)]
                if is_missing.any():  # each of them sends missing readings left or right, or asks for nothing else
                    lefts = [*lefts, *(left | is_missing for left in lefts), is_missing]
                for left in lefts:
                    yield feature, sum(1 << int(i) for i in np.flatnonzero(left))

    def _fits(self, sensors: frozenset[int]) -> bool:
        return math.fsum(self.problem.shape.sensor_costs[list(sensors)]) <= self.problem.shape.sensor_limit

    def _leaves(self, samples: int) -> list[int]:
        members = [row for i, row in enumerate(self.costs) if samples >> i & 1]
        return [sum(row[k] for row in members) for k in range(self.problem.samples.n_classes)]

    def _sides(self, samples: int) -> Iterable[tuple[int, frozenset[int], int, int]]:
        """Yield each way to split some samples in two once for every feature: cuts that part them alike are one."""
        seen = set()
        for feature, mask in self.cuts:
            left, right = samples & mask, samples & ~mask
            parts = feature, min(left, right)  # whichever side is called left
            if min(left.bit_count(), right.bit_count()) >= self.problem.shape.leaf_size and parts not in seen:
                seen.add(parts)
                yield feature, frozenset([int(self.problem.shape.sensor_index[feature])]), left, right

    def _of_split(self, sensor: frozenset[int], left: int, right: int, depth: int) -> _Counts:
        counts: _Counts = Counter()
        rights = self.counts(right, depth).items()
        for (cost, read), n in self.counts(left, depth).items():
            for (more, also), m in rights:
                if cost + more + self.price <= self.limit and self.fits(read | also | sensor):
                    counts[cost + more + self.price, read | also | sensor] += n * m
        for cost, more in zip(self.leaves(left), self.leaves(right), strict=True):
            if cost + more + self.price <= self.limit and self.fits(sensor):
                counts[cost + more + self.price, sensor] -= 1
        return counts

    def _counts(self, samples: int, depth: int) -> _Counts:
        counts: _Counts = Counter((cost, frozenset()) for cost in self.leaves(samples) if cost <= self.limit)
        for _, sensor, left, right in self.sides(samples) if depth else ():
            counts.update(self._of_split(sensor, left, right, depth - 1))
        return counts

    def _vectors(self, samples: int, depth: int) -> _Vectors:
        """Return the least cost of each vector of labels and set of sensors."""
        members = samples.bit_count()
        found: _Vectors = {}
        for label, cost in enumerate(self.leaves(samples)):
            if cost <= self.limit:
                found[(label,) * members, frozenset()] = cost
        order = [i for i in range(self.problem.samples.n_samples) if samples >> i & 1]
        for _, sensor, left, right in self.sides(samples) if depth else ():
            is_left = [bool(left >> i & 1) for i in order]
            rights = self.vectors(right, depth - 1).items()
            for (labels, read), cost in self.vectors(left, depth - 1).items():
                for (others, also), more in rights:
                    total = cost + more + self.price
                    if total <= self.limit and self.fits(read | also | sensor):
                        ours, theirs = iter(labels), iter(others)
                        key = tuple(next(ours if side else theirs) for side in is_left), read | also | sensor
                        found[key] = min(total, found.get(key, total))
        return found

    def recount(self) -> Recount:
        every, depth = (1 << self.problem.samples.n_samples) - 1, self.problem.shape.depth
        by_root: dict[str, int] = defaultdict(int)
        total: _Counts = Counter((cost, frozenset()) for cost in self.leaves(every) if cost <= self.limit)
        by_root[""] = sum(total.values())
        for feature, sensor, left, right in self.sides(every):
            counts = self._of_split(sensor, left, right, depth - 1)
            by_root[self.problem.samples.feature_names[feature]] += sum(counts.values())
            total.update(counts)
        spectrum: dict[Fraction, int] = defaultdict(int)
        by_sensors: dict[tuple[str, ...], int] = defaultdict(int)
        for (cost, read), n in total.items():
            spectrum[Fraction(cost, self.units)] += n
            by_sensors[tuple(self.problem.shape.sensors[s] for s in sorted(read))] += n
        return Recount(
            least=min(cost for cost, n in spectrum.items() if n),
            trees=sum(spectrum.values()),
            predictions=len({labels for labels, _ in self.vectors(every, depth)}),
            spectrum={cost: n for cost, n in sorted(spectrum.items()) if n},
            by_root={name: n for name, n in by_root.items() if n},
            by_sensors={read: n for read, n in by_sensors.items() if n},
        )
