"""Monotone trees: proven against a list of all trees, recounted by the certificate, kept by every method and door."""

import time

import numpy as np
import pytest
from sklearn.tree import DecisionTreeRegressor

from benchmarks.kinds.classes import complaint
from benchmarks.kinds.shaped import MONOTONE_KINDS
from octmip import Leaf, Limits, Problem, Split, certify, solve
from octmip.errors import CertificateError, ProblemError
from octmip.interfaces.estimator import OptimalTreeClassifier, OptimalTreeRegressor
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.ordering import ordered
from octmip.trees.nodes.order import disorder
from octmip.trees.nodes.tree import predict
from octmip.trees.question.losses import AbsoluteError, QuantileError, SquaredError
from octmip.trees.runs.registry import Run
from octmip.trees.runs.solver_call import Call
from octmip.trees.solver import SHALLOWER, _first_tree

RNG = np.random.default_rng(4)
FEATURES, LABELS = RNG.normal(size=(40, 3)), RNG.integers(0, 2, 40)
ACROSS = Split(0, 0.0, Split(1, 0.0, Leaf(0), Leaf(1)), Split(2, 0.0, Leaf(0), Leaf(1)))
"""Left of 0 it predicts 1 above x1 = 0; right of 0 it may predict 0 there."""


def asked(**options: object) -> Problem:
    return Problem(FEATURES, LABELS, depth=2, **({"monotone": {"x0": "+", "x2": -1}} | options))


@pytest.mark.parametrize("kind", MONOTONE_KINDS.values(), ids=MONOTONE_KINDS)
@pytest.mark.parametrize("seed", [*range(20), 157, 193, 194])
def test_every_method_against_the_list_of_all_trees(kind, seed):
    problem = kind.draw(np.random.default_rng([kind.stream, seed]))
    truth = kind.truth(problem)
    best = solve(problem, "exact")
    assert best.is_optimal
    for solution in (best, solve(problem, "search"), solve(problem, "cart")):
        assert complaint(problem, solution, truth) == ""


def test_one_threshold_may_need_its_first_place_and_another_its_last():
    # Below f = 0.5 the places are 2 to 60 where h = 0 and 40 to 92 where h = 1. Above it 1 is predicted from 10 or 20
    # on to 80 or 90: where they meet, the 2 below would fall to it. Only 2 to 20 and 80 to 92 keep the order.
    rows = [(0, 0, 2, (0, 2)), (0, 0, 1, (60, 95)), (0, 1, 1, (0, 40)), (0, 1, 2, (92, 102))]
    rows += [(1, h, 3, (1, 10, 90, 101)) for h in (0, 1)] + [(1, h, 1, (20, 40, 60, 80)) for h in (0, 1)]
    samples = [(f, h, g, label) for f, h, label, places in rows for g in places]
    features, labels = np.array(samples, dtype=float)[:, :3], [label for *_, label in samples]
    found = solve(Problem(features, labels, depth=3, monotone={"x0": "+"}), "exact")
    assert (found.objective, found.is_optimal) == (0.0, True)


@pytest.mark.parametrize(
    ("tree", "directions", "found"),
    [
        (Split(0, 0.0, Leaf(1), Leaf(0)), (1, 0, 0), (0, 1, 0)),
        (Split(0, 0.0, Leaf(1), Leaf(0)), (-1, 0, 0), None),
        (Split(0, 0.0, Leaf(1), Leaf(0)), (0, 1, 1), None),
        (ACROSS, (1, 0, 0), (1, 2, 0)),
        (Split(0, 0.0, ACROSS.left, Split(1, 0.0, Leaf(0), Leaf(1))), (1, 1, 0), None),
        (Split(0, 0.0, Split(1, 1.0, Leaf(0), Leaf(1)), Split(1, 2.0, Leaf(0), Leaf(1))), (1, 0, 0), (1, 2, 0)),
        (Split(0, 0.0, Split(1, 2.0, Leaf(0), Leaf(1)), Split(1, 1.0, Leaf(0), Leaf(1))), (1, 0, 0), None),
    ],
)
def test_the_first_leaves_out_of_order_are_found(tree, directions, found):
    assert disorder(tree, directions) == found


@pytest.mark.parametrize("seed", range(10))
def test_order_of_leaves_is_order_of_predictions(seed):
    rng = np.random.default_rng(seed)
    tree = solve(Problem(rng.integers(0, 4, (20, 2)), rng.integers(0, 2, 20), depth=3)).tree
    grid = np.array([[a, b] for a in np.arange(-1, 5) for b in np.arange(-1, 5)], dtype=float)
    rising = np.diff(predict(tree, grid).reshape(6, 6), axis=0)
    assert (disorder(tree, (1, 0)) is None) == bool((rising >= 0).all())
    assert (disorder(tree, (-1, 0)) is None) == bool((rising <= 0).all())


def test_a_certificate_refutes_a_tree_out_of_order():
    free = solve(Problem(FEATURES, LABELS, depth=2))
    assert disorder(free.tree, asked().shape.directions) is not None
    with pytest.raises(CertificateError, match=r"the prediction (falls|rises) along x\d between leaves"):
        certify(asked(), free)
    with pytest.raises(ProblemError, match="the incumbent is no tree of this problem: the prediction"):
        solve(asked(), incumbent=free)


def test_leaves_out_of_order_get_one_prediction():
    problem = asked(monotone=[1, 0, 0])
    tree = ordered(problem, ACROSS)
    assert disorder(tree, problem.shape.directions) is None
    assert tree is ordered(problem, tree)


def test_thresholds_between_the_same_neighbours_are_aligned_at_no_cost():
    rows = [(0, 1), (0, 2), (1, 1), (1, 2)]
    problem = Problem(rows, [0, 1, 0, 1], depth=2, monotone=[1, 1], class_order=[0, 1])
    tree = Split(0, 0.5, Split(1, 1.4, Leaf(0), Leaf(1)), Split(1, 1.6, Leaf(0), Leaf(1)))
    assert disorder(tree, (1, 1)) is not None
    assert problem.objective(ordered(problem, tree)) == 0


@pytest.mark.parametrize(("loss", "depth"), [(SquaredError(), 3), (AbsoluteError(), 2), (QuantileError(0.8), 2)])
def test_ordered_numbers_are_no_worse_than_an_ordered_tree_that_is_known(depth, loss):
    kept = 0
    for seed in range(2):
        rng = np.random.default_rng(seed)
        features = rng.normal(size=(40, 3))
        targets = features @ rng.uniform(0, 1, 3) + rng.uniform(0, 1) * rng.normal(size=40)
        problem = Problem(features, targets, depth=depth, loss=loss, monotone=[1, 1, 1])
        free, found = solve(problem.replace(monotone=None)), solve(problem)
        if disorder(free.tree, problem.shape.directions) is None:
            kept += 1
            assert (found.objective, found.is_optimal) == (free.objective, True)
        assert found.bound == free.bound
        assert found.objective <= solve(problem.replace(depth=depth - 1)).objective
        grown = DecisionTreeRegressor(max_depth=depth, monotonic_cst=[1, 1, 1], random_state=0).fit(features, targets)
        errors = loss.of_misses(targets - grown.predict(features))
        assert found.objective <= errors.sum() * (1 + 1e-9)
    assert kept or depth == 3


@pytest.mark.long
def test_numbers_are_searched_and_their_proof_says_that_it_cannot():
    numbers = Problem(FEATURES, -(FEATURES[:, 0] ** 2), depth=3, loss=SquaredError(), monotone={0: "+"})
    assert certify(numbers, solve(numbers, "search")).n_splits >= 1
    with pytest.raises(ProblemError, match="does not know the problem's monotone"):
        solve(numbers, "exact")
    tree = OptimalTreeRegressor(3, monotonic_cst=[1, 0, 0]).fit(FEATURES, -(FEATURES[:, 0] ** 2))
    assert disorder(tree.tree_, (1, 0, 0)) is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"monotone": {"x9": "+"}}, "monotone names 'x9'; expected one of the features x0, x1, x2"),
        ({"monotone": {"x0": "up"}}, "monotone of x0 is 'up'; expected"),
        ({"monotone": [1, 0]}, "expected a direction, 1, -1 or 0, for each of the 3 features"),
        ({"split": "hyperplane"}, "monotone is given but split is 'hyperplane'"),
        ({"takes_missing": True}, "monotone is given but readings may be missing"),
    ],
)
def test_an_order_that_is_none_is_refused(options, message):
    with pytest.raises(ProblemError, match=message):
        asked(**options)


def test_what_no_proof_knows_is_searched_unless_a_proof_is_asked_for():
    priced = asked(sensor_budget=2)
    assert (solve(priced).solver, solve(asked()).solver) == ("search", "exact")
    with pytest.raises(ProblemError, match="does not know the problem's sensor_budget; use method 'cart' or 'search'"):
        solve(priced, "exact")


def test_the_classifier_takes_scikit_learns_name():
    tree = OptimalTreeClassifier(2, monotonic_cst=[1, 0, -1]).fit(FEATURES, LABELS)
    assert tree.objective_ == solve(asked()).objective
    assert disorder(tree.tree_, (1, 0, -1)) is None
    with pytest.raises(ProblemError, match="monotonic_cst names 'a'"):
        OptimalTreeClassifier(2, monotonic_cst={"a": 1}).fit(FEATURES, LABELS)


def test_a_proof_in_order_that_is_stopped_has_a_tree_no_worse_than_the_best_one_less_deep():
    rng = np.random.default_rng(3)
    features = rng.normal(size=(3000, 8)).round(2)
    labels = features[:, 0] + features[:, 1] * features[:, 2] + rng.normal(size=3000) > 0
    less, deep = (Problem(features, labels, depth=depth, monotone=[1] + 7 * [0]) for depth in (3, 4))
    seen = []
    call = Call(deep, Run("exact", Limits(seconds=60.0), progress=seen.append), time.perf_counter())
    first = _first_tree(call, "exact", share=0.2)
    assert (first.solver, first.bound) == (SHALLOWER, -np.inf)
    assert first.objective == solve(less, "exact").objective
    assert deep.objective(first.tree) == first.objective
    assert seen
    assert {state.bound for state in seen} == {-np.inf}


def test_a_proof_in_order_without_a_tree_to_start_from_has_one_when_it_is_stopped_at_once():
    found = branch_and_bound(asked(), limits=Limits(seconds=0.0))
    assert found.objective == asked().objective(asked().best_leaf())
    assert found.bound < found.objective
