"""Certificates: true claims pass with the right counts, and every hand-broken one fails with a sentence."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octmip import HyperplaneSplit, Leaf, Problem, Solution, Split, SquaredError, Stop, ValueLeaf, certify, predict
from octmip.errors import CertificateError
from octmip.trees.answer.certificate import first_forbidden_split
from octmip.trees.nodes.tree import leaf_index, leaves
from octmip.trees.question.losses import ClassCosts
from tests.oracles.strategies import problems, random_tree

FEATURES = np.array([[0.0, 5.0], [1.0, 5.0], [2.0, 7.0], [3.0, 7.0], [4.0, 9.0]])
PROBLEM = Problem(FEATURES, ["a", "a", "b", "b", "a"], depth=2, leaf_size=1, sensor_budget=2, feature_names=("g", "h"))
TREE = Split(0, 1.5, Leaf(0), Split(1, 8.0, Leaf(1), Leaf(0)))
SOLUTION = Solution(TREE, 0.0, 0.0, Stop.OPTIMAL, 0.1, 1, "exact", "1", 0)
STUMP = dataclasses.replace(SOLUTION, tree=Split(0, 1.5, Leaf(0), Leaf(1)), objective=1.0, bound=0.0, stop=Stop.TIME)


def problem_with(**changes):
    settings = {"depth": 2, "feature_names": ("g", "h")} | changes
    features = settings.pop("features", FEATURES)
    labels = settings.pop("targets", PROBLEM.samples.targets)
    return Problem(features, labels, **settings)


def test_what_is_true_is_counted():
    certificate = certify(PROBLEM, SOLUTION)
    assert (certificate.objective, certificate.errors, certificate.gap, certificate.bound) == (0, 0, 0, 0)
    assert (certificate.n_splits, certificate.depth, certificate.sensors, certificate.sensor_cost) == (
        2,
        2,
        ("g", "h"),
        2,
    )
    assert certify(PROBLEM, STUMP).normalised_objective == 0.5  # one error where the best leaf makes two


def test_weights_costs_and_penalty_are_paid():
    problem = problem_with(weights=[1, 1, 1, 1, 10], loss=ClassCosts([[0, 3], [1, 0]]), leaf_penalty=0.5)
    paid = dataclasses.replace(STUMP, objective=30.5)
    assert certify(problem, paid).errors == 1
    with pytest.raises(CertificateError, match=r"claims objective 30\.0 but the tree's own"):
        certify(problem, dataclasses.replace(paid, objective=30.0))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"objective": 1.0}, r"claims objective 1\.0 but the tree's own"),
        ({"tree": Split(0, 0.5, Leaf(0), TREE.right)}, "claims objective 0.0 but the tree's own"),
        ({"tree": Split(0, 1.5, Leaf(1), TREE.right)}, "claims objective 0.0 but the tree's own"),
        ({"tree": Split(0, 1.5, Leaf(5), TREE.right)}, "a leaf predicts class 5"),
        ({"tree": Split(7, 1.5, Leaf(0), Leaf(1))}, "reads feature 7"),
        ({"tree": Split(0, 1.5, Leaf(0), Split(1, 8.0, TREE, Leaf(0)))}, "depth 4 but the problem allows 2"),
        ({"tree": Split(0, 9.0, TREE.right, Leaf(0))}, "leaf 2 .from the left. holds 0 samples"),
        ({"tree": HyperplaneSplit((0, 1), (1.0, 1.0), 1.0, Leaf(0), Leaf(1))}, "is not allowed"),
        ({"tree": None, "objective": math.inf, "bound": 0.0}, "found no tree"),
        ({"bound": 0.5}, r"no tree is below 0\.5"),
        ({"bound": -1.0}, "says optimal but its bound"),
        ({"bound": -math.inf}, "says optimal but its bound"),
        ({"tolerance": 1.0}, "too wide"),
        ({"tolerance": -1.0}, "too wide|no tree is below"),
        ({"tolerance": math.nan}, "too wide|says optimal"),
    ],
)
def test_a_hand_broken_claim_fails_with_a_sentence(changes, sentence):
    with pytest.raises(CertificateError, match=sentence):
        certify(PROBLEM, dataclasses.replace(SOLUTION, **changes))


@pytest.mark.parametrize("bound", [5.5, 3.0, math.nextafter(2.0, 3.0)])
def test_a_bound_above_the_best_leaf_fails(bound):
    problem = problem_with(leaf_penalty=5.0)
    claim = dataclasses.replace(STUMP, objective=6.0, bound=bound)
    with pytest.raises(CertificateError, match=r"one leaf alone costs 2\.0"):
        certify(problem, claim)


@pytest.mark.parametrize("bound", [math.nextafter(1.0, 2.0), 1.5, 1.999, 2.0])
def test_a_bound_above_the_own_tree_fails_however_little_and_below_the_best_leaf(bound):
    assert certify(PROBLEM, STUMP).objective == 1
    with pytest.raises(CertificateError, match="claims that no tree is below"):
        certify(PROBLEM, dataclasses.replace(STUMP, bound=bound))


@pytest.mark.parametrize("share", [1e-9, 0.5, 0.9])
def test_a_bound_above_a_tree_of_real_weights_fails(share):
    problem = problem_with(weights=[0.1, 0.2, 0.3, 0.4, 0.7])
    objective = problem.objective(STUMP.tree)
    claim = dataclasses.replace(STUMP, objective=objective, bound=objective)
    certify(problem, claim)
    least = problem.least_saving
    certify(problem, dataclasses.replace(claim, bound=objective + 0.5 * least, tolerance=0.6 * least))
    with pytest.raises(CertificateError, match=r"claims that no tree is below|one leaf alone"):
        certify(problem, dataclasses.replace(claim, bound=objective * (1 + share)))


def test_a_bound_of_numbers_has_no_tolerance_of_rounded_costs():
    problem = problem_with(targets=[1.0, 1.0, 2.0, 2.0, 4.0], loss=SquaredError())
    tree = Split(0, 1.5, ValueLeaf(1.0), Split(1, 8.0, ValueLeaf(2.0), ValueLeaf(3.0)))
    claim = dataclasses.replace(SOLUTION, tree=tree, objective=1.0, bound=1.0)
    certify(problem, claim)
    with pytest.raises(CertificateError, match="claims that no tree is below"):
        certify(problem, dataclasses.replace(claim, bound=1.25, tolerance=0.5))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"features": FEATURES[::-1]}, "claims objective 0.0 but the tree's own"),
        ({"features": FEATURES + 0.6}, "claims objective 0.0 but the tree's own"),
        ({"targets": ["a", "b", "b", "b", "a"]}, "claims objective 0.0 but the tree's own"),
        ({"leaf_penalty": 0.25}, "claims objective 0.0 but the tree's own"),
        ({"leaf_size": 2}, "leaf 2 .from the left. holds 1 samples but leaf_size is 2"),
        ({"depth": 1}, "depth 2 but the problem allows 1"),
        ({"max_splits": 1}, "2 splits but max_splits is 1"),
        ({"max_splits": 1, "split": "hyperplane"}, "2 features in its splits but max_splits is 1"),
        ({"sensor_budget": 1}, "over the budget of 1"),
        ({"sensor_cost": {"g": 1, "h": 1.5}, "sensor_budget": 2}, "over the budget of 2"),
        ({"allowed_splits": [["g"]]}, "a split over .'h'. is not allowed"),
    ],
)
def test_a_tree_of_another_problem_fails_with_a_sentence(changes, sentence):
    with pytest.raises(CertificateError, match=sentence):
        certify(problem_with(**changes), SOLUTION)


@pytest.mark.parametrize("coefficients", [(1.0, -2.0), (1.5, 1.0), (4.0, 1.0)])
def test_coefficients_that_are_no_integers_fail_where_integers_are_wanted(coefficients):
    problem = problem_with(split="hyperplane", integer_normals=3)
    tree = HyperplaneSplit((0, 1), coefficients, float(FEATURES[0, :2] @ coefficients), Leaf(0), Leaf(1))
    objective = problem.objective_of(tree, predict(tree, FEATURES))
    claim = dataclasses.replace(STUMP, tree=tree, objective=objective, bound=0.0)
    if coefficients == (1.0, -2.0):
        certify(problem, claim)
    else:
        with pytest.raises(CertificateError, match="not integers within limits"):
            certify(problem, claim)


@given(problems(max_samples=12), st.integers(0, 2**32 - 1))
def test_the_objective_is_the_sum_over_the_samples_one_by_one(problem, seed):
    samples, shape = problem.samples, problem.shape
    tree = random_tree(np.random.default_rng(seed), samples.n_features, samples.n_classes, shape.depth)
    total = 0.0
    for x, code, weight in zip(problem.samples.features, problem.samples.codes, problem.samples.weights, strict=True):
        node = tree
        while isinstance(node, Split):
            node = node.left if x[node.feature] <= node.threshold else node.right
            total += 0.0
        total += weight * problem.costs[code, node.label]
    objective = problem.objective(tree)
    paid = total + problem.shape.leaf_penalty * repr(tree).count("Split(")
    assert objective == pytest.approx(paid, rel=1e-12)
    claim = Solution(tree, objective, -math.inf, Stop.FINISHED, 0.0, 0, "search", "1", 0)
    smallest = np.bincount(leaf_index(tree, problem.samples.features), minlength=len(leaves(tree))).min()
    is_allowed = first_forbidden_split(problem, tree) is None and shape.sensor_cost_of(tree) <= shape.sensor_limit
    if is_allowed and smallest >= problem.shape.leaf_size:
        assert certify(problem, claim).objective == objective
    else:
        with pytest.raises(CertificateError, match=r"leaf|not allowed|budget"):
            certify(problem, claim)
