"""The exact core at its limits: sensor budgets by any number of threads, and memory."""

import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

from octmip import ClassCosts, Leaf, Problem, Split, certify, predict, solve
from octmip.errors import ProblemError
from octmip.trees import _native
from octmip.trees.answer.solution import Limits, Progress, Stop, closing_tolerance
from octmip.trees.encoding import costs as grid
from octmip.trees.encoding import integer_costs, native_problem, rank_features
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.native_call import without
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.nodes.tree import n_splits
from tests.oracles.enumeration import optimum
from tests.oracles.wide_problems import wide_problem


def with_ties(seed: int) -> Problem:
    """Return a problem under a tight budget in which many trees cost the same: every feature comes twice."""
    generator = np.random.default_rng([33, seed])
    features = generator.integers(0, 4, (40, 4)).astype(float)
    labels = generator.integers(0, 3, 40)
    return Problem(np.hstack([features, features[:, ::-1]]), labels, depth=3, sensor_budget=2)


@pytest.mark.parametrize("seed", range(12))
def test_under_a_budget_the_tree_is_the_same_for_any_number_of_threads(seed: int) -> None:
    problem = with_ties(seed)
    first, *others = (branch_and_bound(problem, n_jobs=n_jobs) for n_jobs in (1, 2, 3))
    assert first.stop is Stop.OPTIMAL
    assert problem.shape.sensor_cost_of(first.tree) <= 2
    for other in others:
        assert (other.tree, other.objective, other.bound) == (first.tree, first.objective, first.bound)


def hard(n_features: int = 12, **options: object) -> Problem:
    generator = np.random.default_rng(5)
    features, labels = generator.normal(size=(400, n_features)), generator.integers(0, 3, 400)
    return Problem(features, labels, depth=4, **options)


def test_a_search_that_is_stopped_keeps_the_bound_of_the_level_below(tmp_path) -> None:
    generator = np.random.default_rng(3)
    features, labels = generator.normal(size=(500, 8)), generator.integers(0, 6, 500)
    below = branch_and_bound(Problem(features, labels, depth=3))
    problem, limits = Problem(features, labels, depth=4), Limits(nodes=below.n_nodes / 2)
    stopped = branch_and_bound(problem, limits=limits)
    assert stopped.stop is Stop.NODES
    assert 0.0 < stopped.bound <= 2.0 * below.objective - 500.0
    with without("level_below"):
        assert branch_and_bound(problem, limits=limits).bound == 0.0
    logged = branch_and_bound(problem, limits=limits, options=ExactOptions(proof=tmp_path / "log"))
    assert logged.bound == check_proof(problem, tmp_path / "log").bound == 0.0


def table_bytes(problem: Problem, n_jobs: int = 1) -> float:
    native = native_problem(problem, rank_features(problem), integer_costs(problem))
    return _native.exact_bytes(native, n_jobs)


def test_memory_too_small_for_the_tables_ends_before_the_search() -> None:
    problem = hard()
    solution = branch_and_bound(problem, limits=Limits(memory=table_bytes(problem) - 1))
    assert (solution.stop, solution.n_nodes) == (Stop.MEMORY, 0)
    assert certify(problem, solution).bound == 0


def test_memory_too_small_for_the_queue_ends_the_search_with_the_best_tree_and_bound() -> None:
    problem = hard()
    solution = branch_and_bound(problem, limits=Limits(memory=table_bytes(problem) + 1, seconds=20))
    assert solution.stop is Stop.MEMORY
    assert solution.n_nodes > 0
    leaf = branch_and_bound(problem, limits=Limits(memory=1))
    assert certify(problem, solution).objective < leaf.objective


def test_a_proof_that_memory_ends_is_followed_by_a_search_with_its_bound() -> None:
    problem = hard()
    leaf = branch_and_bound(problem, limits=Limits(memory=1))
    found = solve(problem, "exact", limits=Limits(memory=1, seconds=3))
    assert (found.stop, found.bound, found.details["tree_by"]) == (Stop.MEMORY, leaf.bound, "search")
    assert certify(problem, found).objective < 0.8 * leaf.objective


@pytest.mark.long
def test_the_bound_of_a_large_table_rises_step_by_step_before_its_proof_ends() -> None:
    random = np.random.default_rng(0)
    features = random.normal(size=(420_000, 10))
    by_the_tree = np.where(features[:, 0] > 0.3, features[:, 1] > -0.5, features[:, 2] > 0)
    problem = Problem(features, by_the_tree ^ (random.random(len(features)) < 0.1), depth=2)
    truth = Split(0, 0.3, Split(2, 0.0, Leaf(0), Leaf(1)), Split(1, -0.5, Leaf(0), Leaf(1)))
    reports: list[Progress] = []
    found = branch_and_bound(problem, incumbent=truth, progress=reports.append)
    assert found.is_optimal
    bounds = [report.bound for report in reports]
    assert bounds == sorted(bounds)
    assert any(0.74 * found.objective < bound < 0.97 * found.objective for bound in bounds)


PEAK = """
import ctypes, sys
import numpy as np
from octmip.trees import _native
from octmip.trees.encoding import integer_costs, native_problem, rank_features
from octmip.trees.question.problem import Problem
from octmip.trees.answer.solution import Limits
n, p, classes, depth, threads, seconds = map(int, sys.argv[1:7])
generator = np.random.default_rng(0)
problem = Problem(generator.normal(size=(n, p)), generator.integers(0, classes, n), depth=depth)
native = native_problem(problem, rank_features(problem), integer_costs(problem))
_native.branch_and_bound(native, None, Limits(seconds=0.0, nodes=1.0, memory=0.0), 1)
ctypes.CDLL(None).malloc_trim(0)
with open("/proc/self/clear_refs", "w") as file:
    file.write("5")  # the peak from now on
def status(name):
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith(name))
before = status("VmRSS")
_native.branch_and_bound(native, None, Limits(seconds=seconds, memory=float("inf")), threads)
print(status("VmHWM") - before, _native.exact_bytes(native, threads))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the peak is read from /proc")
@pytest.mark.parametrize("shape", [(100_000, 10, 2, 2, 1), (10_000, 20, 3, 3, 2)])
def test_the_tables_are_reckoned_no_smaller_than_they_become(shape: tuple[int, ...]) -> None:
    command = [sys.executable, "-c", PEAK, *map(str, shape), "1"]
    peak, reckoned = map(float, subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())
    assert 0.25 * reckoned < peak < reckoned


BLOCK = 30


def exact_objective(problem, tree):
    """Return the objective of a tree as the rational number that it is."""
    samples = problem.samples
    answers = zip(samples.weights.tolist(), samples.codes, predict(tree, samples.features), strict=True)
    paid = (Fraction(weight) * Fraction(float(problem.costs[code, k])) for weight, code, k in answers)
    return sum(paid, n_splits(tree) * Fraction(problem.shape.leaf_penalty))


def check(problem, solution, best):
    """Assert that a solution is the optimum within its tolerance, or leaves only what float64 cannot hold."""
    certify(problem, solution)
    assert Fraction(solution.bound) <= best
    if solution.stop is Stop.OPTIMAL:
        rounding = best / 2**52
        assert exact_objective(problem, solution.tree) - best <= Fraction(solution.tolerance) + rounding
    else:
        assert solution.stop is Stop.NUMERICS
        assert solution.tolerance == 0
        assert not solution.is_optimal


@pytest.mark.parametrize("first", range(0, 60, BLOCK))
def test_the_optimum_is_proven_unless_float64_cannot_tell_two_trees_apart(first):
    for seed in range(first, first + BLOCK):
        problem = wide_problem(np.random.default_rng([51, seed]))
        solution = branch_and_bound(problem)
        check(problem, solution, exact_objective(problem, optimum(problem).tree))
        if solution.stop is Stop.NUMERICS:
            # Half a unit in the last place of the objective, one of the bound that is rounded down.
            assert 1.5 * np.spacing(solution.objective) >= problem.least_saving, f"seed {seed}"


def test_with_weights_and_costs_rounded_each_for_itself_every_bound_still_holds(monkeypatch):
    monkeypatch.setattr(grid, "MOST_OWN_ROWS", 0)
    for seed in range(BLOCK):
        problem = wide_problem(np.random.default_rng([52, seed]))
        check(problem, branch_and_bound(problem), exact_objective(problem, optimum(problem).tree))


@pytest.mark.parametrize("scale", [1e-275, 1e-200, 1e200, 1e298])
def test_the_ends_of_float64_give_a_tree_and_a_bound_that_holds(scale):
    for seed in range(6):
        rng = np.random.default_rng([55, seed])
        n = int(rng.integers(3, 9))
        features, labels = rng.integers(0, 4, (n, 2)).astype(float), rng.integers(0, 3, n)
        labels[:2] = [0, 1]
        costs = None if seed % 2 else rng.random((3, 3))
        weights = rng.integers(1, 1000, n) * scale
        problem = Problem(features, labels, depth=2, weights=weights, loss=ClassCosts(costs), class_names=(0, 1, 2))
        check(problem, branch_and_bound(problem), exact_objective(problem, optimum(problem).tree))


@pytest.mark.parametrize(("weight", "cost"), [(1e300, 1e12), (1e303, 1.0), (1e-200, 1e-200), (5e-324, 1.0)])
def test_costs_beyond_float64_are_refused_with_a_way_out(weight, cost):
    with pytest.raises(ProblemError, match=r"expected from 1e-280 to 1e\+303, .*; scale weights or costs"):
        Problem([[0.0], [1.0]], [0, 1], depth=1, weights=[weight, weight], loss=ClassCosts([[0, cost], [cost, 0]]))


@pytest.mark.parametrize(
    ("solver", "split"), [(branch_and_bound, {}), (two_feature_branch_and_bound, {"split": "hyperplane"})]
)
def test_an_objective_whose_rounding_hides_a_split_is_not_called_optimal(solver, split):
    problem = Problem([[2.0], [2.0], [0.0]], [0, 1, 0], depth=1, weights=[1e12, 1e12 + 1, 1e-12], **split)
    solution = solver(problem)
    better = Split(0, 1.0, Leaf(0), Leaf(1))
    assert problem.exact_objective(solution.tree) - problem.exact_objective(better) == Fraction(1e-12)
    assert (solution.stop, solution.is_optimal) == (Stop.NUMERICS, False)


def test_a_tolerance_is_as_wide_as_the_bound_is_away_and_no_sample_is_lighter():
    problem = Problem([[0.0], [1.0]], [0, 1], depth=1, weights=[0.1, 5.0])
    assert closing_tolerance(1.0, 1.5, problem.least_saving) == 0
    assert 1.0 - closing_tolerance(1.0, 0.95, problem.least_saving) <= 0.95
    assert closing_tolerance(1.0, 0.89, problem.least_saving) == -1
