"""What the search for regression trees asks at a node: each choice on samples made to decide it."""

import numpy as np
import pytest

from octmip import Problem
from octmip.trees.nodes.tree import HyperplaneSplit, Split
from octmip.trees.question.losses import AbsoluteError, SquaredError
from octmip.trees.regression.best_split import Samples, by_means, parts
from octmip.trees.regression.leaf_models import fitted_leaf

SQUARE = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])


def asked(problem: Problem) -> Split | HyperplaneSplit | None:
    """Return the question for all samples of a problem."""
    rows, targets = np.arange(problem.samples.n_samples), problem.samples.targets
    samples = Samples(problem, rows, np.arange(problem.samples.n_features))
    return samples.best(by_means(problem.samples.weights, targets), targets - targets.mean())


@pytest.mark.parametrize(("price", "kind"), [(0.0, HyperplaneSplit), (5.9, HyperplaneSplit), (6.1, Split)])
def test_a_hyperplane_pays_for_its_second_feature(price: float, kind: type) -> None:
    """One corner is higher: a line errs by 0, a cut of one feature by half of its square, 6."""
    targets = [0.0, 0.0, 0.0, np.sqrt(12.0)]
    problem = Problem(SQUARE, targets, depth=1, split="hyperplane", split_size=2, loss=SquaredError())
    problem = problem.replace(leaf_penalty=price)
    assert isinstance(asked(problem), kind)


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_a_hyperplane_is_the_same_in_any_unit_of_a_feature(unit: float) -> None:
    features = np.random.default_rng(2).normal(size=(40, 2))
    sides = []
    for sizes in ([1.0, 1.0], [unit, 1.0]):
        problem = Problem(features * sizes, np.sign(features.sum(1)), depth=1, split="hyperplane", loss=SquaredError())
        question = asked(problem)
        assert isinstance(question, HyperplaneSplit)
        sides.append(parts(question, problem.samples.features, np.arange(40))[0].tolist())
    assert sides[0] == sides[1]


def test_both_sides_of_a_question_have_a_leafs_samples() -> None:
    targets = np.array([0.0, 0.0, 0.0, 1.0, 9.0])
    problem = Problem(np.arange(5.0)[:, None], targets, depth=1, leaf_size=2, loss=SquaredError())
    for features in (problem.samples.features, -problem.samples.features):
        turned = Problem(features, targets, depth=1, leaf_size=2, loss=SquaredError())
        question = asked(turned)
        assert question is not None
        assert sorted(map(len, parts(question, features, np.arange(5)))) == [2, 3]


def test_light_samples_are_cut_where_heavy_ones_are() -> None:
    order, targets = np.arange(5)[:, None], np.array([0.0, 1.0, 5.0, 6.0, 9.0])
    weights = np.array([1.0, 2.0, 1.0, 3.0, 1.0])
    heavy = by_means(weights, targets)(order)
    assert by_means(weights / 1024, targets)(order) * 1024 == pytest.approx(heavy)


def test_a_median_between_two_targets_is_the_lower_one() -> None:
    values = np.array([3.0, 1.0, 2.0, 4.0])
    problem = Problem(np.zeros((4, 1)), values, depth=1, loss=AbsoluteError())
    assert fitted_leaf(problem, np.arange(4), np.arange(1)).value == 2.0
