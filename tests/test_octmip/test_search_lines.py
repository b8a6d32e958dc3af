"""Local search over lines of two features, whose moves ask the exact single-split solver: no limit is broken."""

import numpy as np

from octmip import ClassCosts, Problem, certify
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from tests.oracles.two_feature_problems import clouds, random_two_feature_problem


def variants(problem: Problem, rng: np.random.Generator) -> list[Problem]:
    """Return the problem with each kind of limit and price."""
    k, p = problem.samples.n_classes, problem.samples.n_features
    return [
        problem.replace(weights=rng.integers(0, 4, problem.samples.n_samples).astype(float)),
        problem.replace(loss=ClassCosts(rng.integers(0, 6, (k, k)).astype(float))),
        problem.replace(leaf_size=7, leaf_penalty=1.5),
        problem.replace(sensor_budget=2.0),
        problem.replace(allowed_splits=[[0, 1], *([f] for f in range(2, p))]),
        problem.replace(integer_normals=3),
        problem.replace(depth=4, leaf_size=3),
    ]


def test_lines_keep_every_limit_of_the_problem():
    for seed in range(3):
        rng = np.random.default_rng([71, seed])
        for problem in variants(clouds(seed, most_samples=130), rng):
            certify(problem, local_search(problem, seed=seed, options=SearchOptions(restarts=1, perturbations=4)))


def test_small_searches_are_never_better_than_the_proven_optimum_and_mostly_at_it():
    n_hits = 0
    for seed in range(24):
        problem = random_two_feature_problem(np.random.default_rng([72, seed]), depth=1 + seed % 2, max_samples=30)
        found, best = (
            local_search(problem, seed=seed, options=SearchOptions(restarts=3)),
            two_feature_branch_and_bound(problem),
        )
        certify(problem, found)
        assert best.is_optimal
        assert found.objective >= best.bound - best.tolerance
        n_hits += found.objective <= best.objective + best.tolerance
    assert n_hits >= 22
