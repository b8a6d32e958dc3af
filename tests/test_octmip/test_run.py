"""Run: what functions that solve several problems hand on; solving by a run is solving by its parts."""

import dataclasses

import numpy as np
import pytest

from octmip import Limits, Problem, solve
from octmip.trees.methods.options import SearchOptions
from octmip.trees.registry import Run
from octmip.trees.solver import solve_run

RNG = np.random.default_rng(0)
PROBLEM = Problem(RNG.normal(size=(60, 3)), RNG.integers(0, 3, 60), depth=2)


@pytest.mark.parametrize(
    "run", [Run(), Run("search", seed=3, options=SearchOptions(restarts=2)), Run("cart", n_jobs=2)]
)
def test_a_run_solves_as_its_parts_do(run):
    found = solve_run(PROBLEM, run)
    parts = solve(PROBLEM, run.method, run.limits, None, run.seed, run.n_jobs, run.progress, run.options)
    assert dataclasses.replace(found, seconds=0.0) == dataclasses.replace(parts, seconds=0.0)


def test_progress_and_incumbent_reach_the_solver():
    seen = []
    first = solve(PROBLEM, "cart").tree
    found = solve_run(PROBLEM, Run("exact", Limits(seconds=20.0), progress=seen.append), first)
    assert found.objective <= PROBLEM.objective(first)
    assert all(state.objective >= found.objective for state in seen)
