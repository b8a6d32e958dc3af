"""Benders: the optimum of OCT by masters on HiGHS. The fuzz holds it against enumeration."""

import subprocess
import sys
import threading

import numpy as np
import pytest

from octmip import Limits, Problem, Stop, solve
from octmip.trees.mip.benders.bounds import Bounds
from octmip.trees.mip.benders.memory import Memory
from octmip.trees.mip.benders.solver import solve_benders
from octmip.trees.mip.benders.subproblem import Subproblem
from octmip.trees.mip.prices import own_prices
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem


def mixed(n: int, p: int, n_classes: int, seed: int, **options) -> Problem:
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(n, p)).round(1)
    labels = (features[:, 0] > 0).astype(int) + (features[:, 1] > 0.5) * (rng.random(n) < 0.8) * (n_classes > 2)
    labels = np.where(rng.random(n) < 0.2, rng.integers(0, n_classes, n), labels)
    return Problem(features, labels, **options)


def test_without_a_feature_that_varies_the_tree_is_a_leaf():
    problem = Problem(np.ones((6, 2)), [0, 1, 1, 0, 1, 1], depth=2, leaf_size=2)
    found = solve_benders(problem)
    assert (found.objective, found.bound, found.stop) == (2.0, 2.0, Stop.OPTIMAL)


@pytest.mark.parametrize("seed", [89, 203])
def test_a_master_that_the_primal_simplex_method_leaves_open_is_solved_anew(seed):
    problem = random_problem(np.random.default_rng(seed), max_samples=8 + seed % 6, max_features=3)
    found = solve_benders(problem)
    assert found.stop is Stop.OPTIMAL
    assert found.objective == pytest.approx(solve(problem, "exact").objective, rel=1e-12)


def test_a_limit_ends_the_run_with_a_tree_and_a_bound_that_holds():
    problem = mixed(120, 5, 3, 3, depth=3)
    for limits, stop in ((Limits(seconds=0.5), Stop.TIME), (Limits(nodes=4), Stop.NODES), (Limits(gap=0.99), Stop.GAP)):
        found = solve_benders(problem, limits=limits)
        assert found.stop is stop
        assert found.bound <= solve(problem, "exact").objective <= found.objective


def test_an_interrupt_in_a_round_ends_every_thread_and_keeps_the_bound():
    problem, n_threads = mixed(120, 5, 3, 3, depth=3), threading.active_count()

    def interrupt(state):
        if state.n_nodes > 5:
            raise KeyboardInterrupt

    found = solve_benders(problem, n_jobs=2, progress=interrupt)
    assert found.stop is Stop.INTERRUPTED
    assert found.tree is not None
    assert not [thread for thread in threading.enumerate()[n_threads:] if "ThreadPool" in thread.name]


def best_price(problem: Problem, samples: np.ndarray) -> float:
    if len(set(problem.samples.targets[samples].tolist())) < 2:
        return 0.0
    part = Problem(problem.samples.features[samples], problem.samples.targets[samples], depth=problem.shape.depth - 1)
    return optimum(part).objective


def test_every_bound_that_a_subproblem_teaches_holds_for_every_cut():
    rng = np.random.default_rng(4)
    for seed in range(12):
        problem = mixed(10, 2, 3, seed, depth=2)
        prices = own_prices(problem)
        bounds = Bounds.of_class_counts(problem, prices)
        for _ in range(3):
            samples = rng.random(10) < 0.5
            if samples.any():
                bounds.learn(samples, best_price(problem, samples))
        for place in range(len(bounds.cuts.feature)):
            left = bounds.is_left(bounds.cut(place))
            assert bounds.left[place] <= best_price(problem, left)
            assert bounds.right[place] <= best_price(problem, ~left)


def test_what_is_remembered_of_other_nodes_holds_for_the_samples_asked():
    rng = np.random.default_rng(5)
    problem = mixed(12, 2, 3, 6, depth=2)
    prices = own_prices(problem)
    memory = Memory(prices.weights * prices.costs[prices.profile].max(axis=1))
    for _ in range(20):
        rows = np.flatnonzero(rng.random(12) < 0.6)
        memory.add(1, rows, best_price(problem, np.isin(np.arange(12), rows)))
    inside = np.flatnonzero(rng.random(12) < 0.8)
    part = Problem(problem.samples.features[inside], problem.samples.targets[inside], depth=2)
    recalled = memory.recall(Subproblem(part, own_prices(part), inside))
    assert recalled
    for samples, price in recalled:
        assert price <= best_price(part, samples)


@pytest.mark.long
def test_benders_runs_without_a_line_of_the_exact_core():
    program = """
import sys
class Refused:
    def find_spec(self, name, path=None, target=None):
        if name in ("octmip.trees.methods.exact", "octmip.trees.methods.two_feature", "octmip.trees.methods.search"):
            raise ImportError(f"{name} is refused")
sys.meta_path.insert(0, Refused())
import numpy as np
from octmip.trees import _native
for name in ("search", "branch_and_bound", "prove", "two_feature_branch_and_bound"):
    assert hasattr(_native, name)
    setattr(_native, name, None)
from octmip.trees.mip.benders.solver import solve_benders
from octmip.trees.question.problem import Problem
rng = np.random.default_rng(0)
features = rng.normal(size=(60, 3)).round(1)
found = solve_benders(Problem(features, (features.sum(axis=1) > 0).astype(int), depth=2))
print(found.stop, found.objective)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["optimal"]
