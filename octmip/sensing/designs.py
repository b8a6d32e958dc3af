"""Sensors chosen without the best tree, by rules: the comparison for a placement by tree.

by_reading  the highest readings: the ad-hoc choice, where the signal is strong
by_chance   at random
by_tree     forward selection: the sensor with which a quick tree errs least, one after the other

Each returns names of sensors that cost the budget at most.
"""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from octmip.sensing.placement import problem_on
from octmip.trees.answer.solution import Limits
from octmip.trees.methods.options import SearchOptions
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve

QUICK = SearchOptions(restarts=1, perturbations=0)
QUICK_LIMITS = Limits(nodes=10)
"""Visits to a node: the trial trees of a forward selection are many."""


def by_reading(problem: Problem, budget: float) -> tuple[str, ...]:
    """Return the sensors of highest mean absolute reading (of a sensor's features the highest).

    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> by_reading(problem, 1)
    ('g2',)
    """
    strength = np.zeros(len(problem.shape.sensors))
    np.maximum.at(strength, problem.shape.sensor_index, np.abs(problem.samples.features).mean(axis=0, dtype=np.float64))
    return _affordable(problem, np.argsort(-strength, kind="stable"), budget)


def by_chance(problem: Problem, budget: float, rng: np.random.Generator) -> tuple[str, ...]:
    """Return sensors in a random order while they can be paid for.

    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> len(by_chance(problem, 1, np.random.default_rng(0)))
    1
    """
    return _affordable(problem, rng.permutation(len(problem.shape.sensors)), budget)


def by_tree(problem: Problem, budget: float, *, seed: int = 0) -> tuple[str, ...]:
    """Return sensors by forward selection: each time the one with which, beside those chosen, a quick tree errs least.

    Of equals the cheapest, then the first. It ends when no further sensor can be paid for. `seed` is that of the
    trial trees.

    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> by_tree(problem, 1)
    ('g1',)
    """
    chosen: list[str] = []
    while candidates := _payable(problem, chosen, budget):
        trials = []
        for name in candidates:
            part = problem_on(problem, [*chosen, name]).replace(sensor_budget=None)
            found = solve(part, "search", QUICK_LIMITS, seed=seed, options=QUICK)
            s = problem.shape.sensors.index(name)
            trials.append((found.objective, float(problem.shape.sensor_costs[s]), s))
        chosen.append(problem.shape.sensors[min(trials)[2]])
    return _in_order(problem, chosen)


def _payable(problem: Problem, chosen: Iterable[str], budget: float) -> list[str]:
    """Return the sensors that can be paid for beside those chosen."""
    costs = dict(zip(problem.shape.sensors, problem.shape.sensor_costs.tolist(), strict=True))
    bought = list(chosen)
    limit = budget + 1e-9 * max(1.0, budget)
    return [
        s
        for s in problem.shape.sensors
        if s not in bought and math.fsum([costs[s], *(costs[b] for b in bought)]) <= limit
    ]


def _affordable(problem: Problem, ranking: NDArray[np.int64], budget: float) -> tuple[str, ...]:
    """Return the sensors of a ranking, the best first, each that can still be paid for."""
    chosen: list[str] = []
    for s in ranking:
        if problem.shape.sensors[int(s)] in _payable(problem, chosen, budget):
            chosen.append(problem.shape.sensors[int(s)])
    return _in_order(problem, chosen)


def _in_order(problem: Problem, chosen: Iterable[str]) -> tuple[str, ...]:
    kept = set(chosen)
    return tuple(name for name in problem.shape.sensors if name in kept)
