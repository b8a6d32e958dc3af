"""The least objective of any tree inside a scope, read from its words alone: what the words leave out limits nothing.

Splits are along directions: the features, and where a split may read several, lines through pairs of samples turned a
little both ways, so that over two features no parting is left out. Imports nothing of octmip but the problem.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]
Cuts = Sequence[Sequence[float]]
TURN = 1e-7


@dataclass(frozen=True, slots=True)
class Said:
    """The limits that a scope names; None for those that it does not."""

    depth: int | None
    quantiles: int | None
    leaf_size: int
    splits: int | None
    budget: float
    band: float
    split_size: int

    @classmethod
    def read(cls, words: str) -> "Said":
        """Return the limits in some words.

        Raises
        ------
        ValueError
            the words name no depth, not even any.
        """
        if "of any depth" not in words and not re.search(r"of depth \d+ or less", words):
            raise ValueError(f"{words!r} names no depth")
        found = {name: re.search(pattern, words) for name, pattern in PATTERNS.items()}
        number = {name: None if match is None else float(match[1].replace(",", "")) for name, match in found.items()}

        def whole(name: str) -> int | None:
            value = number[name]
            return None if value is None else int(value)

        return cls(
            depth=whole("depth"),
            quantiles=whole("quantiles"),
            leaf_size=whole("leaf_size") or 1,
            splits=whole("splits"),
            budget=math.inf if number["budget"] is None else number["budget"] + 1e-9,
            band=number["band"] or 0.0,
            split_size=whole("split_size") or 1,
        )


PATTERNS = {
    "depth": r"of depth (\d+) or less",
    "quantiles": r"at (\d+) quantiles at most",
    "leaf_size": r"with ([\d,]+) samples or more in each leaf",
    "splits": r"with at most (\d+) (?:splits?|features? in all splits)",
    "budget": r"sensors that cost ([\d.e+-]+) or less",
    "band": r"outside a band of ([\d.e+-]+) at each split",
    "split_size": r"with up to (\d+) features in a split",
}


def least_inside(problem: Problem, words: str, cuts: Cuts = ()) -> float:
    """Return the least objective of the trees that some words speak about, with the problem's data and prices.

    `cuts`: for each feature the thresholds that "quantiles" stands for.
    """
    said = Said.read(words)
    return min(_least(problem, said, _directions(problem, said, features, cuts)) for features in _paid(problem, said))


def _paid(problem: Problem, said: Said) -> Iterator[list[int]]:
    for size in range(len(problem.shape.sensors) + 1):
        for chosen in combinations(range(len(problem.shape.sensors)), size):
            if math.fsum(problem.shape.sensor_costs[list(chosen)]) <= said.budget:
                yield [j for j, sensor in enumerate(problem.shape.sensor_index.tolist()) if sensor in chosen]


def _directions(problem: Problem, said: Said, features: list[int], cuts: Cuts) -> list[tuple[Floats, int]]:
    """Return the places (n_samples,) of the samples along each direction, and the features that it reads."""
    found: list[tuple[Floats, int]] = []
    ranges = np.nanmax(problem.samples.features, axis=0) - np.nanmin(problem.samples.features, axis=0)
    x = problem.samples.features / np.where(ranges > 0, ranges, 1.0)
    for j in features:
        column = x[:, j]
        if said.quantiles:
            assert len(cuts[j]) <= said.quantiles
            column = np.where(np.isnan(column), np.nan, np.searchsorted(cuts[j], problem.samples.features[:, j]))
        sides = (np.inf, -np.inf) if np.isnan(column).any() else (0.0,)
        found += [(np.where(np.isnan(column), side, column), 1) for side in sides]
    for pair in combinations(features, 2) if said.split_size > 1 else ():
        points = x[:, list(pair)]
        for a, b in combinations(np.unique(points, axis=0), 2):
            for turn in (-TURN, 0.0, TURN) if said.band == 0 else (0.0, -0.05, 0.05):
                angle = math.atan2(*(b - a)) + turn
                normal = np.array([math.cos(angle), -math.sin(angle)])
                found.append((points @ (normal / np.abs(normal).sum()), 2))
    return found


def _least(problem: Problem, said: Said, directions: list[tuple[Floats, int]]) -> float:
    price, everything = problem.shape.leaf_penalty, (1 << problem.samples.n_samples) - 1
    least_gap = said.band * (1 + 1e-6) if said.band else 1e-9 if said.split_size > 1 else 0.0
    orders = [(np.argsort(at, kind="stable").tolist(), at.tolist(), reads) for at, reads in directions]
    cost = cache(lambda samples: _leaf(problem, [i for i in range(problem.samples.n_samples) if samples >> i & 1]))

    @cache
    def sides(samples: int) -> dict[int, int]:
        found: dict[int, int] = {}
        for order, at, reads in orders:
            own, left = [i for i in order if samples >> i & 1], 0
            for before, after in pairwise(own):
                left |= 1 << before
                if at[after] - at[before] > least_gap and at[after] > at[before]:
                    found[left] = min(reads, found.get(left, reads))
        size = said.leaf_size
        return {
            left: reads for left, reads in found.items() if min(left.bit_count(), (samples & ~left).bit_count()) >= size
        }

    @cache
    def best(samples: int, depth: int | None, splits: int | None) -> float:
        found: float = cost(samples)
        if depth == 0 or splits == 0:
            return found
        below = None if depth is None else depth - 1
        for left, reads in sides(samples).items():
            rest = None if splits is None else splits - reads
            for of_left in (None,) if rest is None else range(rest + 1):
                of_right = None if rest is None or of_left is None else rest - of_left
                both = best(left, below, of_left) + best(samples & ~left, below, of_right)
                found = min(found, both + price * reads)
        return found

    return best(everything, said.depth, said.splits)


def _leaf(problem: Problem, rows: list[int]) -> float:
    """Return the least cost of one leaf."""
    weights: Any = problem.samples.weights[rows]
    if isinstance(problem.loss, ClassCosts):
        paid = weights[:, None] * problem.cost_table[problem.cost_rows[rows]]
        return min(math.fsum(column) for column in paid.T.tolist())
    targets = problem.samples.targets[rows].astype(float)
    total = math.fsum(weights)
    mean = math.fsum(weights * targets) / total if total else 0.0
    return math.fsum(weights * (targets - mean) ** 2)
