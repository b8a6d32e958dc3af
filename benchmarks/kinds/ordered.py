"""Monotone trees of classes, some with a number of splits too: random problems against a list of all trees."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.random import Generator

from benchmarks.kinds.classes import Classes
from benchmarks.oracles.monotone import least_monotone_cost
from octmip.trees.losses import ClassCosts
from octmip.trees.problem import Problem

MOST_SAMPLES = {1: 12, 2: 10, 3: 7}
"""By depth: the list of all trees grows with their power."""


@dataclass(frozen=True, slots=True)
class Ordered(Classes):
    """Trees of least cost that keep the order of some features."""

    def truth(self, problem: Problem) -> Fraction:
        """Return the least cost of any tree that keeps the order."""
        return Fraction(least_monotone_cost(problem))


def ordered_problem(rng: Generator, *, has_splits: bool) -> Problem:
    """Return a problem of whole costs with directions of some features, and a number of splits where it is wanted."""
    depth, p = int(rng.choice([1, 2, 2, 3])), int(rng.integers(1, 4))
    n, k = int(rng.integers(3, MOST_SAMPLES[depth] + (3 if p < 3 else 0))), int(rng.integers(2, 4))
    labels = rng.integers(0, k, n)
    labels[:2] = 0, 1
    costs = rng.integers(0, 5, (k, k)) * (1 - np.eye(k)) if rng.random() < 0.4 else 1 - np.eye(k)
    directions = rng.choice([-1, 0, 1], p)
    directions[int(rng.integers(0, p))] = rng.choice([-1, 1])
    return Problem(
        rng.integers(0, 4 if depth < 3 else 3, (n, p)).astype(float),
        labels,
        depth=depth,
        loss=ClassCosts(costs),
        class_names=tuple(range(k)),
        weights=rng.integers(1, 4 if rng.random() < 0.5 else 2, n).astype(float),
        leaf_size=int(rng.choice([1, 1, 2])),
        leaf_penalty=float(rng.choice([0, 0, 1])),
        max_splits=int(rng.integers(1, 2**depth)) if has_splits else None,
        monotone=directions.tolist(),
    )


def _monotone(rng: Generator) -> Problem:
    return ordered_problem(rng, has_splits=False)


def _monotone_few(rng: Generator) -> Problem:
    return ordered_problem(rng, has_splits=True)


METHODS = {"exact": 1.0, "search": 0.2, "cart": 0.2}
MONOTONE_KIND = Ordered(23, _monotone, METHODS, 0.3, ())
MONOTONE_FEW_KIND = Ordered(29, _monotone_few, METHODS, 0.3, ())
