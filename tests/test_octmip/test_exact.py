"""The exact core against exhaustive enumeration, and against itself with every prune switched off."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from benchmarks.oracles.enumeration import optimum
from octmip import ClassCosts, Solution, certify
from octmip.errors import ProblemError
from octmip.trees import _native
from octmip.trees.methods import native_call
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.proof import check_proof
from octmip.trees.solution import Limits, Progress, Stop
from octmip.trees.tree import HyperplaneSplit, Leaf, Split, n_splits


def without(prune: str, problem: Problem, limits: Limits | None = None) -> Solution:
    with native_call.without(prune):
        return branch_and_bound(problem, limits=limits or Limits())


def random_problem(seed: int, depth: int | None = None) -> Problem:
    """Return a small problem with ties, duplicates, weights, costs, leaf sizes and penalties, by chance."""
    rng = np.random.default_rng(seed)
    n, p, k = int(rng.integers(2, 13)), int(rng.integers(1, 4)), int(rng.integers(2, 6))
    n = max(n, k)
    labels = np.concatenate([np.arange(k), rng.integers(0, k, n - k)]) if rng.random() < 0.8 else np.arange(n) % 2
    classes = len(set(labels.tolist()))
    return Problem(
        rng.integers(0, rng.integers(2, 9), (n, p)).astype(float),
        labels,
        depth=int(rng.integers(1, 4)) if depth is None else depth,
        weights=None if rng.random() < 0.5 else rng.integers(0, 5, n) + (np.arange(n) == 0),
        loss=ClassCosts(None if rng.random() < 0.6 else rng.integers(0, 6, (classes, classes))),
        leaf_size=1 if rng.random() < 0.6 else int(rng.integers(1, 1 + n // 2)),
        leaf_penalty=0 if rng.random() < 0.6 else int(rng.integers(0, 3)),
        allowed_splits=None if p == 1 or rng.random() < 0.8 else [[0], [1]],
    )


@pytest.mark.parametrize("block", range(8))
def test_it_finds_the_optimum_of_enumeration(block: int) -> None:
    for seed in range(50 * block, 50 * block + 50):
        problem = random_problem(seed)
        solution = branch_and_bound(problem, n_jobs=1 + seed % 2)
        assert certify(problem, solution).objective == optimum(problem).objective, seed
        assert solution.stop is Stop.OPTIMAL, seed


@pytest.mark.parametrize("prune", _native.prunes())
def test_the_optimum_stays_with_a_prune_switched_off(prune: str) -> None:
    for seed in range(1000, 1030):
        problem = random_problem(seed)
        assert without(prune, problem).objective == branch_and_bound(problem).objective, seed


def test_the_optimum_stays_with_every_prune_switched_off() -> None:
    for seed in range(2000, 2020):
        problem = random_problem(seed, depth=3)
        with native_call.without(*_native.prunes()):
            assert branch_and_bound(problem).objective == optimum(problem).objective, seed


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


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_a_sensor_budget_is_kept_and_proven(n_jobs: int) -> None:
    rng = np.random.default_rng(7)
    for _ in range(25):
        n = int(rng.integers(5, 13))
        problem = Problem(
            rng.integers(0, 6, (n, 4)).astype(float),
            np.arange(n) % 3,
            depth=int(rng.integers(1, 4)),
            leaf_size=int(rng.integers(1, 3)),
            sensor_of_feature=["a", "a", "b", "c"],
            sensor_cost=rng.integers(0, 4, 3) / 10,
            sensor_budget=float(rng.integers(0, 6)) / 10,
        )
        solution = branch_and_bound(problem, n_jobs=n_jobs)
        assert certify(problem, solution).objective == optimum(problem).objective
        assert solution.is_optimal


def larger(seed: int, n: int = 150, classes: int = 3) -> Problem:
    """Return a problem whose lists fill several buckets."""
    rng = np.random.default_rng(seed)
    features = np.round(rng.normal(size=(n, 4)), 1)
    labels = (features[:, 0] * features[:, 1] > 0).astype(int) + (rng.random(n) < 0.2) * rng.integers(0, classes, n)
    return Problem(features, np.minimum(labels, classes - 1), depth=2)


@pytest.mark.parametrize("prune", _native.prunes())
def test_larger_problems_do_not_depend_on_prunes(prune: str) -> None:
    for seed in range(6):
        problem = larger(seed, classes=2 + seed % 4)
        assert without(prune, problem).objective == branch_and_bound(problem).objective, seed


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
    apart = without("merging", problem)
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
    whole = without("cancelling", problem)
    assert (found.objective, found.bound, found.stop) == (whole.objective, whole.bound, Stop.OPTIMAL)
    assert check_proof(problem, tmp_path / "log", bound=found.bound).bound == found.objective
    kept = tmp_path / "kept"
    branch_and_bound(problem, options=ExactOptions(checkpoint=kept), limits=Limits(nodes=found.n_nodes / 2))
    resumed = branch_and_bound(problem, options=ExactOptions(checkpoint=kept))
    assert (resumed.objective, resumed.bound) == (found.objective, found.bound)


def test_equal_samples_of_several_classes_bound_the_cost_at_every_depth() -> None:
    problem = unclear(6, n=4000)
    _, group = np.unique(problem.features, axis=0, return_inverse=True)
    counts = np.zeros((group.max() + 1, 2))
    np.add.at(counts, (group.ravel(), problem.codes), 1)
    least = counts.min(axis=1).sum()
    found = branch_and_bound(problem, limits=Limits(nodes=1))
    assert found.stop is Stop.NODES
    assert 1000 < least <= found.bound


@pytest.mark.parametrize(("depth", "n_classes"), [(5, 5), (5, 6), (6, 5)])
def test_deep_trees_of_many_labels_are_bounded_by_shallow_ones_of_sets_of_labels(depth: int, n_classes: int) -> None:
    rng = np.random.default_rng(depth + n_classes)
    features = rng.integers(0, 40, (1000, 3)).astype(float)
    labels = (features @ [3, 5, 0]).astype(int) // 29 % n_classes
    labels = np.where(rng.random(1000) < 0.3, rng.integers(0, n_classes, 1000), labels)
    problem, limits = Problem(features, labels, depth=depth), Limits(nodes=50_000)
    reports: list[Progress] = []
    found = branch_and_bound(problem, limits=limits, progress=reports.append)
    assert found.stop is Stop.NODES
    assert without("label_sets", problem, limits).bound == 0 < found.bound <= found.objective
    assert reports[-1].bound <= found.bound
    if n_classes == 5:  # sets of four labels: what costs is the label that is left out
        left_out = Problem(features, labels, depth=depth - 2, loss=ClassCosts(np.eye(5)))
        assert found.bound == branch_and_bound(left_out).objective


@pytest.mark.parametrize(
    "options", [{}, {"leaf_penalty": 0.5}, {"loss": ClassCosts(np.abs(np.subtract.outer(range(6), range(6))))}]
)
def test_that_bound_is_none_above_the_optimum(options: dict[str, object]) -> None:
    """Proofs that begin with it end with the answer of those that do not."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        problem = Problem(rng.integers(0, 9, (40, 2)).astype(float), rng.integers(0, 6, 40), depth=5, **options)
        found, alone = branch_and_bound(problem), without("label_sets", problem)
        assert (found.objective, found.bound, found.stop) == (alone.objective, alone.bound, Stop.OPTIMAL)
        assert found.n_nodes != alone.n_nodes
        assert branch_and_bound(problem, n_jobs=3).tree == found.tree


def test_float64_values_a_millionth_apart_are_told_apart() -> None:
    features = (900 + 1e-6 * np.arange(40))[:, None]
    problem = Problem(features, np.arange(40) >= 17, depth=1)
    assert branch_and_bound(problem).objective == 0


def test_the_tree_is_the_same_for_any_number_of_threads_and_any_vectors() -> None:
    for seed in range(4):
        small = larger(seed, n=120, classes=2 + seed % 3)
        problem = Problem(small.features, small.targets, depth=3)
        first = branch_and_bound(problem)
        assert branch_and_bound(problem, n_jobs=2).tree == first.tree, seed
        assert branch_and_bound(problem, n_jobs=2).n_nodes == first.n_nodes, seed
        assert without("vectors", problem).tree == first.tree, seed


def test_fewest_splits_are_found_among_optimal_trees() -> None:
    for seed in range(40):
        problem = random_problem(seed, depth=2)
        fewer = branch_and_bound(problem, break_ties=True)
        assert fewer.details["ties_broken"]["splits"] == "fewest, proven"
        assert fewer.details["ties_broken"]["sensors"] == "fewest, proven"
        assert fewer.tree is not None
        assert certify(problem, fewer).objective == branch_and_bound(problem).objective
        best = optimum(problem)
        assert n_splits(fewer.tree) == best.n_splits, seed
        assert len(problem.sensors_used(fewer.tree)) == best.n_sensors, seed


def test_too_little_memory_ends_with_a_tree_and_a_bound() -> None:
    problem = larger(0)
    solution = branch_and_bound(problem, limits=Limits(memory=1000.0))
    assert solution.stop is Stop.MEMORY
    assert certify(problem, solution).bound == 0


def test_limits_return_a_tree_and_a_bound() -> None:
    problem = larger(1, n=400)
    problem = Problem(problem.features, problem.targets, depth=5)
    solution = branch_and_bound(problem, limits=Limits(seconds=0.05))
    assert solution.stop in (Stop.TIME, Stop.OPTIMAL)
    assert certify(problem, solution).bound <= solution.objective


def test_an_incumbent_that_is_no_tree_of_the_problem_is_refused() -> None:
    problem = Problem([[0.0], [1.0], [2.0]], [0, 1, 0], depth=1, leaf_size=2)
    for incumbent in (
        Split(0, 0.5, Leaf(0), Leaf(1)),
        Split(1, 0.5, Leaf(0), Leaf(1)),
        Split(0, 0.5, Leaf(0), Leaf(2)),
        Split(0, 0.5, Leaf(0), Split(0, 1.5, Leaf(1), Leaf(0))),
        HyperplaneSplit((0,), (1.0,), 0.5, Leaf(0), Leaf(1)),
    ):
        with pytest.raises(ProblemError, match="incumbent"):
            branch_and_bound(problem, incumbent=incumbent)


def test_the_order_of_samples_and_features_changes_nothing_but_names() -> None:
    for seed, (rows, columns) in enumerate(itertools.product((False, True), repeat=2)):
        problem = larger(seed)
        rng = np.random.default_rng(seed)
        order = rng.permutation(problem.n_samples) if rows else np.arange(problem.n_samples)
        names = rng.permutation(4) if columns else np.arange(4)
        other = Problem(problem.features[order][:, names], problem.targets[order], depth=2)
        assert branch_and_bound(other).objective == branch_and_bound(problem).objective
