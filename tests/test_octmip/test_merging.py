"""Equal samples merged: the trees of one problem are those of the other, and the search cannot tell them apart."""

import numpy as np
import pytest

from octmip import Problem, certify
from octmip.trees.methods.merging import merged
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search

FEATURES = [[1.0, 2.0], [0.0, 5.0], [1.0, 2.0], [1.0, 2.0], [-0.0, 5.0]]


def test_rows_without_weight_are_left_out_unless_they_make_up_a_class_or_lie_far_outside():
    problem = Problem(FEATURES, ["a", "b", "a", "b", "b"], depth=1, weights=[1, 2, 0, 4, 0])
    assert merged(problem)[0].samples.n_samples == 3
    assert merged(problem.replace(weights=[1, 0, 3, 0, 0]))[0].samples.n_samples == 3
    far = Problem([*FEATURES, [1e300, 0.0]], ["a", "b", "a", "b", "b", "a"], depth=1, weights=[1, 2, 3, 4, 1, 0])
    assert merged(far)[0].samples.n_samples == 4


@pytest.mark.parametrize("options", [{}, {"split": "hyperplane"}, {"split": "hyperplane", "split_size": 2}])
def test_weights_and_repeated_rows_in_any_order_get_the_same_tree(options):
    rng = np.random.default_rng(31)
    for seed in range(4):
        features = np.round(rng.normal(size=(40, 3)), 1)
        labels, weights = rng.integers(0, 3, 40), rng.integers(0, 4, 40)
        labels[:3], weights[:3] = [0, 1, 2], 1
        weighed = Problem(features, labels, depth=3, weights=weights.astype(float), **options)
        rows = rng.permutation(np.repeat(np.arange(40), weights))
        repeated = Problem(features[rows], labels[rows], depth=3, **options)
        first, second = (
            local_search(problem, seed=seed, options=SearchOptions(restarts=2, perturbations=4))
            for problem in (weighed, repeated)
        )
        certify(weighed, first)
        assert first.tree == second.tree
        assert first.objective == second.objective
