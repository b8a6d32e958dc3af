"""The set of all trees near the optimum: how many they are, what they read, and any of them when asked for."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Stop
from octmip.trees.nodes.tree import Node, Side
from octmip.trees.question.problem import Problem

Entry = tuple[int, int, int]
"""Cost in units, sensors as bits, number of trees."""


class Cut(NamedTuple):
    """A cut of the root as the native core names it.

    Attributes
    ----------
    feature
        the column of ranks.
    rank
        the largest that goes left.
    position
        samples left of it.
    bounds
        of both sides.
    trees
        with this cut; None where they are not counted.
    """

    feature: int
    rank: int
    position: int
    bounds: tuple[int, int]
    trees: list[Entry] | None


class Wanted(NamedTuple):
    """A tree by its number among those of one cut (None: a leaf), cost [units] and set of sensors (bits)."""

    cut: Cut | None
    cost: int
    sensors: int
    number: int


@dataclass(frozen=True, slots=True)
class RootInterval:
    """Neighbouring cuts of one feature that trees of the set have at their root.

    Attributes
    ----------
    feature
        its index.
    first, last
        lowest and highest threshold; both None where the cut asks "is the reading missing?".
    missing
        side to which these cuts send missing readings; None where the feature lacks none.
    n_cuts
        cuts between neighbouring values of the feature, both ends included.
    trees
        of the set with one of these cuts at the root; None where they are not all counted.
    """

    feature: int
    first: float | None
    last: float | None
    missing: Side | None
    n_cuts: int
    trees: int | None


@dataclass(frozen=True, slots=True)
class NearTree:
    """A tree of the set and its objective."""

    tree: Node
    objective: float


@dataclass(frozen=True, slots=True)
class Place:
    """Where trees stand in a count: a cut of the root as the core names it, None for leaves, and their entry."""

    cut: Cut | None
    entry: Entry


@dataclass(frozen=True, slots=True, eq=False)
class NearOptimalSet:
    """All trees of a problem whose objective is within some amount of the optimum.

    Two trees are the same if they have the same shape, features, labels, and at each node the same partition of the
    samples, whichever side is called left. A split between two leaves of one label is no tree of its own; no side of a
    split is empty.

    Attributes
    ----------
    problem
        whose trees these are.
    optimum
        the least objective of all trees; None where it is not proven.
    limit
        the most that a tree of the set costs; None where the optimum is not proven.
    trees
        how many there are; None where not all are counted.
    trees_at_least
        how many are counted for certain.
    predictions
        how many different vectors of labels they give the samples, told apart by 128-bit hashes; None where that
        is not known, and `predictions_note` says why.
    predictions_note
        how predictions were told apart, or why they are not known.
    spectrum
        objective and number of trees, ascending; of the trees counted.
    by_root
        number of trees by the feature at the root; the trees that are one leaf under "".
    by_sensors
        number of trees by the set of sensors that they read; None where it was not asked for.
    roots
        the cuts at the root, in intervals.
    open
        intervals of the root where trees may be that are not counted.
    stop
        FINISHED where all trees are counted, else why not.
    seconds, n_nodes
        spent.
    """

    problem: Problem
    optimum: Fraction | None
    limit: Fraction | None
    trees: int | None
    trees_at_least: int
    predictions: int | None
    predictions_note: str
    spectrum: tuple[tuple[Fraction, int], ...]
    by_root: Mapping[str, int]
    by_sensors: Mapping[tuple[str, ...], int] | None
    roots: tuple[RootInterval, ...]
    open: tuple[RootInterval, ...]
    stop: Stop
    seconds: float
    n_nodes: int
    _unit: Fraction = field(repr=False)
    _places: tuple[Place, ...] = field(repr=False)
    _look_up: Callable[[list[tuple[Place, int]]], list[NearTree]] = field(repr=False)

    @property
    def is_complete(self) -> bool:
        """Whether every tree of the set is counted."""
        return self.trees is not None

    @property
    def least_reading(self) -> dict[str, Fraction]:
        """Least objective of the counted trees that read each sensor, of those that any reads."""
        least: dict[str, Fraction] = {}
        for place in self._places:
            cost, mask, _ = place.entry
            for s, sensor in enumerate(self.problem.shape.sensors):
                if mask >> s & 1:
                    least[sensor] = min(least.get(sensor, cost * self._unit), cost * self._unit)
        return least

    def best(self, n: int) -> list[NearTree]:
        """Return the best trees of the set, `n` at most, by objective, each checked against it.

        Of an incomplete set, the best of those counted.

        Raises
        ------
        ProblemError
            n is negative.
        """
        if n < 0:
            raise ProblemError(f"n is {n}; expected 0 or more trees")
        chosen: list[tuple[Place, int]] = []
        for place in sorted(self._places, key=lambda place: place.entry[0]):
            chosen += [(place, number) for number in range(min(place.entry[2], n - len(chosen)))]
        return self._look_up(chosen)

    def sample(self, n: int, seed: int = 0) -> list[NearTree]:
        """Return `n` trees drawn uniformly from the set, with replacement: each tree has the same chance.

        Raises
        ------
        ProblemError
            the set is incomplete, so that no draw from it would be uniform, or n is negative.
        """
        if n < 0:
            raise ProblemError(f"n is {n}; expected 0 or more trees")
        if self.trees is None:
            raise ProblemError(
                f"the set is not counted to its end (stop: {self.stop}), so no sample of it is uniform; allow more time"
            )
        ends = list(accumulate(place.entry[2] for place in self._places))
        chosen = []
        for number in _numbers(np.random.default_rng(seed), self.trees, n):
            k = next(k for k, end in enumerate(ends) if number < end)
            chosen.append((self._places[k], number - (ends[k] - self._places[k].entry[2])))
        return self._look_up(chosen)


def _numbers(rng: np.random.Generator, most: int, n: int) -> Iterator[int]:
    """Yield whole numbers below `most`, each as likely: of so many random bits, those too large are drawn again."""
    n_bits = most.bit_length()
    for _ in range(n):
        number = most
        while number >= most:
            number = int.from_bytes(rng.bytes((n_bits + 7) // 8)) >> (-n_bits % 8)
        yield number
