"""The enumeration oracle against trees written out one by one, and against optima worked out by hand."""

import itertools

import numpy as np
import pytest

from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.strategies import random_problem
from octmip import Leaf, Split
from octmip.errors import CertificateError
from octmip.trees.certificate import checked_leaf_index
from octmip.trees.tree import n_splits


def every_tree(problem, depth):
    """Yield every tree over the cuts of the whole data, the useless and the forbidden included."""
    yield from (Leaf(k) for k in range(problem.n_classes))
    if depth:
        for feature in range(problem.n_features):
            for threshold in np.unique(problem.features[:, feature])[:-1]:
                sides = list(every_tree(problem, depth - 1))
                for left, right in itertools.product(sides, sides):
                    yield Split(feature, float(threshold), left, right)


def value(problem, tree):
    """Return (objective, splits, sensors) of a tree, None when the problem forbids it."""
    try:
        checked_leaf_index(problem, tree)
    except CertificateError:
        return None
    objective = problem.objective(tree)
    return objective, n_splits(tree), len(problem.sensors_used(tree))


def tiny_problems():
    """Yield problems whose trees are few enough to write out."""
    for seed in itertools.count():
        problem = random_problem(np.random.default_rng(seed), max_samples=6, max_features=2, max_depth=2)
        if problem.n_classes <= 3:
            yield pytest.param(problem, id=f"seed {seed}")


@pytest.mark.parametrize("problem", list(itertools.islice(tiny_problems(), 40)))
def test_no_tree_written_out_is_better_than_the_oracles(problem):
    best = optimum(problem)
    values = [v for tree in every_tree(problem, problem.depth) if (v := value(problem, tree)) is not None]
    least = min(objective for objective, _, _ in values)
    assert best.objective == pytest.approx(least, rel=1e-12, abs=1e-12)
    tied = [v[1:] for v in values if v[0] <= least + 1e-12 * max(1.0, least)]
    assert (best.n_splits, best.n_sensors) == min(tied)


def test_random_problems_hold_every_complication():
    problems = [random_problem(np.random.default_rng(seed)) for seed in range(300)]
    assert {problem.n_classes for problem in problems} == {2, 3, 4, 5, 6}
    assert {problem.depth for problem in problems} == {1, 2, 3}
    for complication in (
        lambda q: q.leaf_size > 1,
        lambda q: q.leaf_penalty > 0,
        lambda q: q.sensor_budget is not None,
        lambda q: len(q.sensors) < q.n_features,
        lambda q: q.allowed_splits is not None,
        lambda q: q.has_integer_costs and q.weights.max() > 1,
        lambda q: not q.has_integer_costs,
        lambda q: q.costs.diagonal().any(),
        lambda q: not q.weights.all(),
        lambda q: any(len(np.unique(column)) == 1 for column in q.features.T),
        lambda q: len(np.unique(q.features, axis=0)) < q.n_samples,
    ):
        assert sum(map(complication, problems)) >= 10
