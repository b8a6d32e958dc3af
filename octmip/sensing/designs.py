"""Sensors chosen without the best tree, by rules: the comparison for a placement by tree.

by_reading  the highest readings: the ad-hoc choice, where the signal is strong
by_chance   at random
by_tree     forward selection: the sensor with which a quick tree errs least, one after the other

Each returns names of sensors that cost the budget at most.
"""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.sensing.placement import problem_on
from octmip.trees.methods.options import Options, SearchOptions
from octmip.trees.problem import Problem
from octmip.trees.registry import Method
from octmip.trees.solution import Limits
from octmip.trees.solver import solve

QUICK = SearchOptions(restarts=1, perturbations=0)
QUICK_NODES = 10  # visits to a node: the trial trees of a forward selection are many


def by_reading(problem: Problem, budget: float) -> tuple[str, ...]:
    """Return the sensors of highest mean absolute reading (of a sensor's features the highest)."""
    strength = np.zeros(len(problem.sensors))
    np.maximum.at(strength, problem.sensor_index, np.abs(problem.features).mean(axis=0, dtype=np.float64))
    return _affordable(problem, np.argsort(-strength, kind="stable"), budget)


def by_chance(problem: Problem, budget: float, rng: np.random.Generator) -> tuple[str, ...]:
    """Return sensors in a random order while they can be paid for."""
    return _affordable(problem, rng.permutation(len(problem.sensors)), budget)


def by_tree(
    problem: Problem,
    budget: float,
    *,
    rows: int | None = None,
    method: Method = "search",
    limits: Limits = Limits(nodes=QUICK_NODES),  # noqa: B008 (frozen)
    seed: int = 0,
    options: Options = QUICK,
) -> tuple[str, ...]:
    """Return sensors by forward selection: each time the one with which, beside those chosen, a quick tree errs least.

    Of equals the cheapest, then the first. It ends when no further sensor can be paid for.

    Parameters
    ----------
    problem
        its tree is tried.
    budget
        of sensor costs.
    rows
        so many samples judge the trials, every class by its share; None: all.
    method, limits, seed, options
        of the trial trees.
    """
    judged = _thinned(problem, rows, seed)
    chosen: list[str] = []
    while candidates := _payable(problem, chosen, budget):
        trials = []
        for name in candidates:
            part = problem_on(judged, [*chosen, name])
            found = solve(replace(part, sensor_budget=None), method, limits, None, seed, 1, None, options)
            s = problem.sensors.index(name)
            trials.append((found.objective, float(problem.sensor_costs[s]), s))
        chosen.append(problem.sensors[min(trials)[2]])
    return _in_order(problem, chosen)


def _thinned(problem: Problem, rows: int | None, seed: int) -> Problem:
    """Return the problem with `rows` samples, dealt out evenly over the classes."""
    if rows is None or rows >= problem.n_samples:
        return problem
    if rows < 2:
        raise ProblemError(f"rows is {rows}; expected 2 or more; give None for all samples")
    shuffled = np.random.default_rng(seed).permutation(problem.n_samples)
    by_class = shuffled[np.argsort(problem.codes[shuffled], kind="stable")]
    kept = np.sort(by_class[np.linspace(0, problem.n_samples - 1, rows).round().astype(np.int64)])
    return problem.of_rows(kept, leaf_size=1, leaf_weight=None)


def _payable(problem: Problem, chosen: Iterable[str], budget: float) -> list[str]:
    """Return the sensors that can be paid for beside those chosen."""
    costs = dict(zip(problem.sensors, problem.sensor_costs.tolist(), strict=True))
    bought = list(chosen)
    limit = budget + 1e-9 * max(1.0, budget)
    return [
        s for s in problem.sensors if s not in bought and math.fsum([costs[s], *(costs[b] for b in bought)]) <= limit
    ]


def _affordable(problem: Problem, ranking: NDArray[np.int64], budget: float) -> tuple[str, ...]:
    """Return the sensors of a ranking, the best first, each that can still be paid for."""
    chosen: list[str] = []
    for s in ranking:
        if problem.sensors[int(s)] in _payable(problem, chosen, budget):
            chosen.append(problem.sensors[int(s)])
    return _in_order(problem, chosen)


def _in_order(problem: Problem, chosen: Iterable[str]) -> tuple[str, ...]:
    kept = set(chosen)
    return tuple(name for name in problem.sensors if name in kept)
