"""Trees of any depth where splits have a price: exact, kept by every door and file, refused where unknown."""

import numpy as np
import pytest

from benchmarks.kinds.classes import SPARSE_KIND
from octmip import Leaf, Problem, Split, solve
from octmip.errors import ProblemError
from octmip.interfaces.estimator import OptimalTreeClassifier
from octmip.trees.methods import exact, native_call
from octmip.trees.nodes.tree import depth

RNG = np.random.default_rng(5)
FEATURES, LABELS = RNG.normal(size=(30, 2)), RNG.integers(0, 3, 30)


def priced(price: float, **more: object) -> Problem:
    return Problem(FEATURES, LABELS, leaf_penalty=price, **more)


@pytest.mark.parametrize("prune", ["price", "kept", "shallower_first", "monotone", "cost_range", "mixed_labels"])
def test_no_bound_costs_the_optimum(prune):
    for seed in range(12):
        problem = SPARSE_KIND.draw(np.random.default_rng([77, 1000 + seed]))
        if problem.shape.is_shaped:
            continue
        with native_call.without(prune):
            found = solve(problem, "exact").objective
        assert found == solve(problem, "exact").objective, seed


def test_counts_by_value_cost_no_optimum():
    for seed in range(10):
        rng = np.random.default_rng([11, seed])
        features = rng.integers(0, int(rng.integers(2, 6)), (int(rng.integers(20, 60)), int(rng.integers(2, 5))))
        labels = (features.sum(1) + rng.integers(0, 1 + seed % 3, len(features))) % int(rng.integers(2, 5))
        shape = {"depth": None if rng.random() < 0.7 else 3, "leaf_penalty": float(rng.choice([1, 2, 3, 5]))}
        problem = Problem(features, labels, weights=rng.integers(1, 4, len(features)), **shape)
        with native_call.without("by_values"):
            slower = solve(problem, "exact")
        assert slower.meets_bound
        assert solve(problem, "exact").objective == slower.objective, seed


@pytest.mark.parametrize("values", [4, 40])  # a table of few boxes, whose levels are not searched one by one
def test_threads_change_nothing_though_nodes_are_kept(values):
    rng = np.random.default_rng(values)
    features = rng.integers(0, values, (90, 3))
    problem = Problem(features, (features.sum(1) // values + (rng.random(90) < 0.2)) % 3, leaf_penalty=4.0)
    one = exact.branch_and_bound(problem, n_jobs=1)
    for jobs in (2, 3):
        more = exact.branch_and_bound(problem, n_jobs=jobs)
        assert (more.tree, more.bound, more.n_nodes) == (one.tree, one.bound, one.n_nodes)


def test_the_depth_follows_the_price_and_a_depth_that_is_given_stays():
    problem = priced(2.0)
    assert problem.shape.any_depth
    assert "depth=any" in repr(problem)
    assert problem.shape.depth * 2.0 >= problem.baseline
    assert problem.replace(leaf_penalty=20.0).shape.depth < problem.shape.depth
    fixed = problem.replace(depth=3)
    assert not fixed.shape.any_depth
    assert fixed.shape.depth == 3
    assert [priced(0.0, max_splits=most).shape.depth for most in (0, 1, 4)] == [1, 1, 4]


def test_a_tree_deeper_than_any_that_pays_is_one_of_the_problem():
    problem, tree = priced(15.0), Leaf(0)
    for cut in np.sort(FEATURES[:, 0])[1:6]:
        tree = Split(0, float(cut), tree, Leaf(1))
    assert depth(tree) > problem.shape.depth
    assert solve(problem, "exact", incumbent=tree).is_optimal


def test_where_deeper_trees_might_pay_the_bound_says_for_which_it_holds(monkeypatch):
    assert "scope" not in solve(priced(2.0), "exact").details
    monkeypatch.setattr(exact, "MAX_DEPTH", 2)
    solution = solve(priced(2.0), "exact")
    assert solution.bound > 3 * 2.0
    assert solution.details["scope"] == "trees of depth 2 or less"


def test_an_estimator_takes_no_depth():
    model = OptimalTreeClassifier(max_depth=None, leaf_penalty=2.0).fit(FEATURES, LABELS)
    assert model.objective_ == solve(priced(2.0)).objective
    with pytest.raises(ProblemError, match="depth is None"):
        OptimalTreeClassifier(max_depth=None).fit(FEATURES, LABELS)
