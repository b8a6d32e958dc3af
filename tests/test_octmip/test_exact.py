"""The exact core against itself with every prune switched off, and against enumeration with none on."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from octmip import ClassCosts, Leaf, Problem, Solution, certify
from octmip.trees import _native
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.native_call import without
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.ties import UNBROKEN
from octmip.trees.nodes.tree import n_splits
from tests.oracles.enumeration import optimum
from tests.oracles.rational import least_cost
from tests.oracles.strategies import random_problem


def solved_without(problem: Problem, *prunes: str) -> Solution:
    with without(*prunes):
        return branch_and_bound(problem)


@pytest.mark.parametrize("prune", _native.prunes())
def test_the_optimum_stays_with_a_prune_switched_off(prune: str) -> None:
    for seed in range(1000, 1020):
        problem = random_problem(np.random.default_rng(seed), max_samples=12)
        least = branch_and_bound(problem, n_jobs=1 + seed % 2).objective
        assert solved_without(problem, prune).objective == pytest.approx(least, rel=1e-12), seed
    for seed in range(6):
        problem = larger(seed, classes=2 + seed % 4)
        assert solved_without(problem, prune).objective == branch_and_bound(problem).objective, seed


def with_large_leaves(seed: int) -> Problem:
    """Return rows of few values and of classes that mostly follow them, and leaves of up to a quarter of the rows."""
    rng = np.random.default_rng([77, seed])
    n, n_features, n_classes, depth = (int(rng.integers(*ends)) for ends in ((14, 80), (1, 4), (2, 5), (2, 4)))
    leaf_size = int(rng.integers(3, max(4, n // 4)))
    features = rng.integers(0, int(rng.integers(4, 60)), (n, n_features)).astype(float)
    if rng.random() < 0.6:
        labels = ((features[:, 0] // 7 + (features[:, -1] // 5) * (rng.random() < 0.5)) % n_classes).astype(int)
    else:
        labels = rng.integers(0, n_classes, n)
    is_other = rng.random(n) < 0.25
    labels[is_other] = rng.integers(0, n_classes, is_other.sum())
    labels[:n_classes] = np.arange(n_classes)
    more: dict[str, Any] = {"weights": rng.integers(1, 4, n).astype(float)} if rng.random() < 0.3 else {}
    more |= {"leaf_penalty": float(rng.choice([0.5, 1.0]))} if rng.random() < 0.2 else {}
    more |= {"sensor_budget": 1} if rng.random() < 0.2 else {}
    return Problem(features, labels, depth=depth, leaf_size=leaf_size, **more)


def test_bounds_from_smaller_leaves_in_narrow_runs_of_cuts_are_none_too_high() -> None:
    # Of 3,000 seeds these are among the 40 whose optimum is missed where runs count as half as wide.
    for seed in (16, 256, 490, 597, 623, 817, 835, 836, 840, 956, 1026, 1081, 1182, 1799, 1820, 1896, 2303, 2630):
        problem = with_large_leaves(seed)
        assert branch_and_bound(problem).objective == solved_without(problem, "free").objective, seed


def test_the_optimum_stays_with_every_prune_switched_off() -> None:
    for seed in range(2000, 2012):
        problem = random_problem(np.random.default_rng(seed), max_samples=12).replace(depth=3)
        found = solved_without(problem, *_native.prunes()).objective
        assert found == pytest.approx(optimum(problem).objective, rel=1e-12), seed


@pytest.mark.parametrize("seed", range(3))
def test_a_tree_that_none_undercuts_ends_the_search_for_any_number_of_threads(seed: int) -> None:
    rng = np.random.default_rng([5, seed])
    features = rng.normal(size=(300, 5))
    is_above = features[:, :3] > np.array([0.2, -0.3, 0.1])
    problem = Problem(features, is_above.sum(axis=1) % 2, depth=4)
    alone, shared = branch_and_bound(problem), branch_and_bound(problem, n_jobs=2)
    assert (alone.objective, alone.bound, alone.stop) == (0, 0, Stop.OPTIMAL)
    assert (shared.tree, shared.bound) == (alone.tree, 0)
    assert alone.n_nodes < 600  # 640 to 760 where the round is worked to its end


def larger(seed: int, n: int = 150, classes: int = 3) -> Problem:
    """Return a problem whose lists fill several buckets."""
    rng = np.random.default_rng(seed)
    features = np.round(rng.normal(size=(n, 4)), 1)
    labels = (features[:, 0] * features[:, 1] > 0).astype(int) + (rng.random(n) < 0.2) * rng.integers(0, classes, n)
    return Problem(features, np.minimum(labels, classes - 1), depth=2)


@pytest.mark.parametrize("costs", [None, np.array([[0, 1, 4], [2, 0, 1], [5, 3, 0]])])
def test_equal_samples_are_searched_as_one_and_logged_as_many(costs: np.ndarray | None, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    features = rng.integers(0, 5, (300, 3)).astype(float)
    features[:, 2] += 10 * rng.integers(0, 30, 300)  # equal samples differ only where no split may look
    problem = Problem(
        features,
        rng.integers(0, 3, 300),
        depth=3,
        loss=ClassCosts(costs),
        weights=rng.integers(1, 4, 300),
        allowed_splits=[[0], [1]],
    )
    solution = branch_and_bound(problem, options=ExactOptions(proof=tmp_path / "proof.log"))
    apart = solved_without(problem, "merging")
    assert (solution.objective, solution.bound) == (apart.objective, apart.bound)
    assert check_proof(problem, tmp_path / "proof.log", bound=solution.bound).bound == solution.objective
    assert solution.n_nodes < apart.n_nodes * 1.5


def unclear(depth: int, n_classes: int = 2, n: int = 500, **options: object) -> Problem:
    """Rows of which many are equal and of several classes."""
    rng = np.random.default_rng(7)
    rows = rng.integers(0, 12, (n // 5, 4)).astype(float)
    return Problem(rows[rng.integers(0, len(rows), n)], rng.integers(0, n_classes, n), depth=depth, **options)


@pytest.mark.parametrize(
    ("n_classes", "options"),
    [
        (2, {}),
        (3, {}),
        (2, {"weights": np.arange(1.0, 501.0)}),
        (2, {"loss": ClassCosts(np.array([[1, 4], [2, 0]])), "leaf_penalty": 3.0}),
        (2, {"sensor_budget": 2}),
        (3, {"loss": ClassCosts(np.arange(9).reshape(3, 3))}),
    ],
)
def test_what_equal_samples_of_all_classes_gain_is_taken_from_the_search_not_from_the_answer(
    n_classes: int, options: dict[str, object], tmp_path: Path
) -> None:
    problem = unclear(3, n_classes, **options)
    found = branch_and_bound(problem, options=ExactOptions(proof=tmp_path / "log"))
    whole = solved_without(problem, "cancelling")
    assert (found.objective, found.bound, found.stop) == (whole.objective, whole.bound, Stop.OPTIMAL)
    assert check_proof(problem, tmp_path / "log", bound=found.bound).bound == found.objective


def test_equal_samples_of_several_classes_bound_the_cost_at_every_depth() -> None:
    problem = unclear(6, n=4000)
    _, group = np.unique(problem.samples.features, axis=0, return_inverse=True)
    counts = np.zeros((group.max() + 1, 2))
    np.add.at(counts, (group.ravel(), problem.samples.codes), 1)
    least = counts.min(axis=1).sum()
    found = branch_and_bound(problem, limits=Limits(nodes=1))
    assert found.stop is Stop.NODES
    assert 1000 < least <= found.bound


def test_the_tree_is_the_same_for_any_number_of_threads_and_any_vectors() -> None:
    for seed in range(4):
        small = larger(seed, n=120, classes=2 + seed % 3)
        problem = Problem(small.samples.features, small.samples.targets, depth=3)
        first = branch_and_bound(problem)
        assert branch_and_bound(problem, n_jobs=2).tree == first.tree, seed
        assert branch_and_bound(problem, n_jobs=2).n_nodes == first.n_nodes, seed
        assert solved_without(problem, "vectors").tree == first.tree, seed


BLOCK = 30
COST_BOUNDS = ("mixed_labels", "buckets", "cost_range", "vectors")


def cost_problem(rng, n, p, depth):
    """Return samples of three to seven classes in order along the features, under some cost matrix."""
    k = int(rng.integers(3, 8))
    labels = np.concatenate([np.arange(k), rng.integers(0, k, max(n - k, 0))])[:n]
    features = labels[:, None] * rng.uniform(0, 1, p) + rng.normal(size=(len(labels), p))
    if rng.random() < 0.5:
        features = np.round(features)
    state = np.arange(k)
    kind = rng.integers(5)
    if kind == 0:
        costs = np.abs(state[:, None] - state)
    elif kind == 1:
        costs = (state[:, None] != state) * np.where(np.not_equal.outer(state > k // 2, state > k // 2), 5, 1)
    elif kind == 2:
        costs = rng.integers(0, 9, (k, k))
    elif kind == 3:
        costs = (state[:, None] - state) ** 2 * rng.integers(0, 3, (k, 1))
    else:
        costs = rng.choice([0.0, 0.5, 3.0], (k, k))
    weights = rng.integers(0, 4, n) + (np.arange(n) == 0) if rng.random() < 0.5 else np.ones(n)
    options = {"leaf_penalty": float(rng.choice([0.0, 0.0, 1.0])), "leaf_size": int(rng.choice([1, 1, 1, 2]))}
    return Problem(
        features, labels, depth=depth, loss=ClassCosts(costs), weights=weights, class_names=tuple(range(k)), **options
    )


@pytest.mark.parametrize("first", range(0, 60, BLOCK))
def test_the_optimum_stays_without_the_bounds_of_costs(first):
    for seed in range(first, first + BLOCK):
        rng = np.random.default_rng([72, seed])
        problem = cost_problem(rng, int(rng.integers(30, 90)), int(rng.integers(1, 5)), int(rng.integers(2, 4)))
        solution, plain = branch_and_bound(problem), solved_without(problem, *COST_BOUNDS)
        assert certify(problem, solution).objective == solution.bound == plain.objective == plain.bound, f"seed {seed}"


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_every_bound_of_costs_is_valid_by_itself(seed):
    rng = np.random.default_rng([76, seed])
    problem = cost_problem(rng, int(rng.integers(40, 80)), 1 + seed % 10, 3)
    least = branch_and_bound(problem).objective
    for kept in COST_BOUNDS:
        alone = solved_without(problem, *(name for name in COST_BOUNDS if name != kept))
        assert alone.objective == alone.bound == least, kept


def in_smaller_units(problem, **options):
    """Return a problem whose costs are 20 times as much, and 7 more whatever is predicted for the first class."""
    costs = problem.costs * 20
    costs[0] += 7
    return problem.replace(loss=ClassCosts(costs), leaf_penalty=problem.shape.leaf_penalty * 20, **options)


@pytest.mark.parametrize("budget", [None, 2])
def test_costs_of_a_common_factor_are_searched_and_logged_as_without_it(budget, tmp_path):
    for seed in range(4):
        rng = np.random.default_rng([73, seed])
        problem = cost_problem(rng, 80, 4, 2 + seed % 2)
        if budget is not None:
            problem = problem.replace(sensor_budget=budget)
        finer, path = in_smaller_units(problem), tmp_path / "proof.log"
        plain, solution = branch_and_bound(problem), branch_and_bound(finer, options=ExactOptions(proof=path))
        assert (solution.tree, solution.n_nodes) == (plain.tree, plain.n_nodes), f"seed {seed}"
        assert solution.bound == solution.objective == finer.objective(plain.tree), f"seed {seed}"
        assert check_proof(finer, path).bound == solution.bound, f"seed {seed}"


@pytest.mark.parametrize("unit", [0.2, 1 / 3, 1e-7])
def test_costs_that_are_multiples_but_for_rounding_are_counted_in_whole_numbers(unit, tmp_path):
    for seed in range(3):
        rng = np.random.default_rng([75, seed])
        whole = cost_problem(rng, 60, 3, 3)
        whole = whole.replace(loss=ClassCosts(np.round(whole.costs)), leaf_penalty=np.round(whole.shape.leaf_penalty))
        problem = whole.replace(loss=ClassCosts(whole.costs * unit), leaf_penalty=whole.shape.leaf_penalty * unit)
        path = tmp_path / "proof.log"
        plain, solution = branch_and_bound(whole), branch_and_bound(problem, options=ExactOptions(proof=path))
        assert solution.objective == pytest.approx(plain.objective * unit, rel=1e-12), f"seed {seed}"
        assert (solution.stop, solution.n_nodes) == (plain.stop, plain.n_nodes), f"seed {seed}"
        assert certify(problem, solution).objective - solution.bound <= 1e-9 * solution.objective, f"seed {seed}"
        assert check_proof(problem, path).bound == solution.bound, f"seed {seed}"


@pytest.mark.parametrize("top", [1, 6, 100_000])
@pytest.mark.parametrize("n_classes", [7, 8, 9, 10, 11])
def test_many_classes_cost_the_same_by_histograms_and_by_walks(n_classes: int, top: int) -> None:
    rng = np.random.default_rng([n_classes, top])
    features, labels = rng.normal(size=(160, 4)).round(1), rng.integers(0, n_classes, 160)
    costs = rng.integers(1, top + 1, (n_classes, n_classes)) * (1 - np.eye(n_classes))
    problem = Problem(features, labels, depth=2, loss=ClassCosts(costs))
    found, walked = branch_and_bound(problem), solved_without(problem, "buckets")
    assert found.is_optimal
    assert found.objective == walked.objective == problem.objective(found.tree)


@pytest.mark.parametrize("max_splits", [3, 4, 5, 6])
def test_few_splits_under_costs_are_those_of_a_list_of_all_trees(max_splits):
    # Enough samples that the bound of mixed labels counts on a side of two splits.
    for seed in range(max_splits, 60, 4):
        rng = np.random.default_rng([83, seed])
        n, k = int(rng.integers(30, 45)), 4
        features = rng.integers(0, 6, (n, 2)).astype(float)
        labels = (features.sum(axis=1).astype(int) + (rng.random(n) < 0.2) * rng.integers(0, k, n)) % k
        costs = ClassCosts(rng.integers(1, 6, (k, k)) * (1 - np.eye(k)))
        weights = rng.integers(1, 5, n).astype(float)
        options = {"leaf_size": 1 + seed % 3, "leaf_penalty": float(rng.choice([0, 1])), "weights": weights}
        problem = Problem(
            features, labels, depth=3, loss=costs, class_names=tuple(range(k)), max_splits=max_splits, **options
        )
        solution = branch_and_bound(problem)
        assert (solution.is_optimal, solution.objective) == (True, least_cost(problem)), seed


# Ties: what is proven of the fewest splits and sensors is said. The fuzz holds both against enumeration


def equal(depth: int = 2, **options: object) -> Problem:
    """Return samples of which no split makes fewer errors than a leaf."""
    return Problem([[0.0], [0.0], [1.0], [1.0]], [0, 1, 0, 1], depth=depth, **options)


def test_a_tree_without_splits_takes_the_place_of_an_equal_one_with_some() -> None:
    found = branch_and_bound(equal(), break_ties=True)
    assert (found.tree, n_splits(found.tree)) == (Leaf(0), 0)
    assert found.details["ties_broken"] == UNBROKEN | dict.fromkeys(("splits", "sensors"), "fewest, proven")
    assert branch_and_bound(equal()).details["ties_broken"] == UNBROKEN


@pytest.mark.parametrize(
    ("options", "kind", "said"),
    [
        ({"weights": [0.1, 0.7, 1.3, 2.9]}, "splits", "not broken: the costs are too fine to count splits"),
        ({"sensor_cost": [1.0, 2.0], "sensor_budget": 2.0}, "sensors", "not broken: a budget of sensors of different"),
    ],
)
def test_why_ties_are_not_broken_is_said(options: dict[str, object], kind: str, said: str) -> None:
    features = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    problem = Problem(features, [0, 1, 0, 1], depth=2, **options)
    assert branch_and_bound(problem, break_ties=True).details["ties_broken"][kind].startswith(said)
