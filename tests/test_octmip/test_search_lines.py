"""Local search over lines of two features, whose moves ask the exact single-split solver."""

import numpy as np

from octmip import certify
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from tests.oracles.two_feature_problems import random_two_feature_problem


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
