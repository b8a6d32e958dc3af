"""Every prune and bound of the two-feature core can be switched off, and the optimum stays."""

import numpy as np
import pytest

from octmip import ClassCosts, Problem, certify
from octmip.trees import _native
from octmip.trees.methods.native_call import without
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from tests.oracles.two_feature_problems import clouds

PRUNES = _native.two_feature_prunes()


def optimum(problem: Problem, off: list[str]) -> float:
    with without(*off):
        solution = two_feature_branch_and_bound(problem)
    assert solution.is_optimal
    return solution.objective


def variants(problem: Problem) -> list[Problem]:
    """Return the problem with weights, graded costs, and leaf size and penalty."""
    rng = np.random.default_rng(0)
    k = problem.samples.n_classes
    return [
        problem.replace(weights=rng.integers(1, 4, problem.samples.n_samples).astype(float)),
        problem.replace(loss=ClassCosts(np.abs(np.subtract.outer(np.arange(k), np.arange(k))).astype(float))),
        problem.replace(leaf_size=9, leaf_penalty=2.0),
    ]


@pytest.mark.parametrize("off", PRUNES)
def test_the_optimum_stays_without(off: str) -> None:
    for seed in (4, 355):
        problem = clouds(seed, most_samples=130)
        for variant in [problem, *variants(problem)]:
            assert optimum(variant, [off]) == optimum(variant, [])


def test_the_optimum_stays_without_any_of_many_together() -> None:
    rng = np.random.default_rng(7)
    for seed in range(6):
        problem = clouds(seed, most_samples=110)
        off = [name for name in PRUNES if name != "narrow" and rng.random() < 0.5]
        assert optimum(problem, off) == optimum(problem, []), off


@pytest.mark.parametrize(("seed", "best"), [(177, 14), (98, 39), (355, 4), (279, 59)])
def test_what_more_samples_teach_about_a_strip_is_not_held_against_fewer(seed: int, best: int) -> None:
    """Slope intervals bounded with open samples once counted as bounded without: these optima came out too high."""
    problem = clouds(seed)
    assert optimum(problem, []) == optimum(problem, ["wide"]) == best


@pytest.mark.parametrize("seed", [0, 4, 8, 21])
def test_what_one_set_of_sensors_teaches_is_not_used_under_another(seed: int) -> None:
    """Good lines of other nodes once served sets that may not read their sensors: the tree was over its budget."""
    problem = clouds(seed, most_samples=130)
    budget = problem.replace(sensor_budget=problem.samples.n_features - 1.0)
    solution = two_feature_branch_and_bound(budget)
    certify(budget, solution)
    assert solution.is_optimal
    assert solution.objective >= optimum(problem, [])
