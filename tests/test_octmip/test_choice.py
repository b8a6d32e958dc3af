"""Cross-validation: folds are fair, the curve is what direct fits would give, and every backend gives the same."""

import math
from itertools import pairwise

import joblib
import numpy as np
import pytest
from sklearn.datasets import load_iris

from octmip import ClassCosts, Leaf, Limits, Problem, Solution, SquaredError, Stop, certify, predict, solve
from octmip.errors import ProblemError
from octmip.trees.nodes.tree import n_splits
from octmip.trees.tradeoff import choose_tree
from octmip.trees.tradeoff.folds import part_of, stratified_folds
from octmip.trees.tradeoff.frontier import Point, _with_bounds_of_wider_limits, default_values, trace_frontier
from octmip.trees.tradeoff.path import trace_path

IRIS = Problem(*load_iris(return_X_y=True), depth=2)
RNG = np.random.default_rng(5)
COSTLY = Problem(
    RNG.normal(size=(60, 3)).round(1),
    np.arange(60) % 3,
    depth=2,
    weights=RNG.integers(1, 4, 60),
    loss=ClassCosts([[0, 1, 4], [2, 0, 1], [5, 1, 0]]),
)


def noisy_step(n=60):
    """Return a problem whose truth is one split, with noise that deeper trees learn by heart."""
    rng = np.random.default_rng(0)
    features = rng.random((n, 2))
    labels = (features[:, 0] > 0.5).astype(int)
    flipped = rng.random(n) < 0.15
    return Problem(features, np.where(flipped, 1 - labels, labels), depth=3)


@pytest.mark.parametrize("n_folds", [2, 3, 7])
def test_folds_are_of_equal_size_and_hold_equal_shares_of_each_class(n_folds):
    folds = stratified_folds(IRIS, n_folds, seed=1)
    held = np.concatenate([rows for _, rows in folds])
    assert sorted(held) == list(range(150))
    assert not any(np.intersect1d(*fold).size for fold in folds)
    sizes = [len(rows) for _, rows in folds]
    shares = np.array([np.bincount(IRIS.samples.codes[rows], minlength=3) for _, rows in folds])
    assert max(sizes) - min(sizes) <= 1
    assert (np.ptp(shares, axis=0) <= 1).all()


@pytest.mark.parametrize("problem", [IRIS, COSTLY], ids=["iris", "weights and costs"])
def test_a_step_costs_what_the_trees_of_its_alpha_cost_on_the_folds_that_they_have_not_seen(problem):
    choice = choose_tree(problem, folds=3, method="exact", seed=2)
    folds = stratified_folds(problem, 3, seed=2)
    paths = [
        [trace_path(part_of(problem, train, "rows").replace(depth=d), method="exact", seed=2) for d in (1, 2)]
        for train, _ in folds
    ]
    for step in choice.steps:
        high = step.alpha_high if math.isfinite(step.alpha_high) else 9.0
        for share in (1e-6, 0.3, 1 - 1e-6):
            total = 0.0
            for (_, held), of_fold in zip(folds, paths, strict=True):
                path = of_fold[step.depth - 1]
                penalty = (step.alpha_low + share * (high - step.alpha_low)) * path.problem.baseline
                told = predict(path.best_at(penalty).tree, problem.samples.features[held])
                total += (problem.samples.weights[held] * problem.costs[problem.samples.codes[held], told]).sum()
            assert step.validation_cost == pytest.approx(total / problem.samples.weights.sum())
        of_all = choice.paths[step.depth - 1].best_at(step.alpha * problem.baseline).tree
        assert step.training_cost == pytest.approx(problem.objective(of_all) / problem.samples.weights.sum())
        assert step.complexity == n_splits(of_all)


def test_every_alpha_of_every_depth_has_its_step():
    choice = choose_tree(IRIS, folds=3, method="cart")
    steps = choice.steps
    assert [choice.step_at(step.depth, step.alpha) for step in steps] == list(steps)
    assert {step.depth for step in steps} == {1, 2}
    for depth in (1, 2):
        mine = [step for step in steps if step.depth == depth]
        assert mine[0].alpha_low == 0
        assert mine[-1].alpha_high == math.inf
        assert all(a.alpha_high == b.alpha_low for a, b in pairwise(mine))
        assert all(step.alpha_low <= step.alpha <= step.alpha_high for step in mine)
    with pytest.raises(ProblemError, match=r"no step of depth 3 and alpha 0; expected a depth of \[1, 2\]"):
        choice.step_at(3, 0)


def test_the_tree_that_generalises_is_chosen_and_fitted_to_all_samples():
    said: list[str] = []
    choice = choose_tree(noisy_step(), method="exact", seed=1, stage=said.append)
    assert said[-1] == "cross-validating, 6 of 6 fits done (all rows, each fold), 0 s left"
    rows = choice.table()
    assert [row["validation_cost"] for row in rows] == [step.validation_cost for step in choice.steps]
    assert [(row["depth"], row["alpha_low"]) for row in rows if row["chosen"]] == [
        (choice.chosen.depth, choice.chosen.alpha_low)
    ]
    assert choice.chosen.complexity == 1
    assert choice.tree.feature == 0
    assert abs(choice.tree.threshold - 0.5) < 0.1
    assert choice.problem.samples.n_samples == 60
    assert choice.solution.is_optimal
    assert choice.problem.shape.depth == choice.chosen.depth
    assert choice.problem.shape.leaf_penalty == choice.chosen.alpha * choice.problem.baseline
    assert certify(choice.problem, choice.solution).objective == choice.solution.objective
    assert choice.chosen.validation_cost == min(step.validation_cost for step in choice.steps)
    assert f"n_steps={len(choice.steps)}, n_paths={len(choice.paths)})" in repr(choice)
    assert str(choice).endswith(f"\n\n{choice.tree}")


def test_one_pair_of_training_and_validation_rows_chooses_as_bertsimas_and_dunn_do():
    rng = np.random.default_rng(0)
    x = rng.random((24, 1))
    labels = (x[:, 0] > 0.5).astype(int)
    noisy = labels.copy()
    noisy[:3] = 1 - noisy[:3]
    both = Problem(np.concatenate([x, x]), np.concatenate([noisy, labels]), depth=2)
    choice = choose_tree(both, folds=[(range(24), range(24, 48))], method="exact")
    assert choice.chosen.complexity == 1
    assert choice.chosen.validation_cost == 0
    assert choice.chosen.standard_error == 0  # not one row is wrong
    assert (choice.fold == np.repeat([-1, 0], 24)).all()


def test_one_standard_error_buys_a_simpler_tree():
    least, simple = (choose_tree(COSTLY, method="cart", rule=rule) for rule in ("least", "one_se"))
    assert simple.steps == least.steps
    assert least.chosen.validation_cost == min(step.validation_cost for step in least.steps)
    assert simple.chosen.complexity < least.chosen.complexity
    assert simple.chosen.validation_cost <= least.chosen.validation_cost + least.chosen.standard_error


def test_folds_come_out_the_same_in_threads_in_processes_and_alone():
    alone = choose_tree(COSTLY, folds=3, method="search")
    for backend in ("threading", "loky"):
        with joblib.parallel_config(backend=backend, n_jobs=2):
            other = choose_tree(COSTLY, folds=3, method="search")
        assert other.steps == alone.steps
        assert other.tree == alone.tree
        assert other.chosen == alone.chosen


ROWS = (range(0, 75), range(75, 150))
WEIGHTLESS = IRIS.replace(weights=np.repeat([1.0, 0.0], [140, 10]))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"folds": 1}, "folds is 1; expected a whole number from 2 to 150"),
        ({"folds": 2.5}, r"folds is 2\.5; expected a whole number"),
        ({"folds": []}, "folds has 0 entries; expected a number of folds, or pairs"),
        ({"folds": [ROWS, ROWS]}, "row 75 is held out in 2 folds"),
        ({"folds": [(range(10), range(5, 20))]}, "fold 0 trains on 5 of the rows that judge it"),
        ({"folds": [(range(10), [150])]}, "validation rows from 150 to 150"),
        ({"folds": [([0.5], [3])]}, "training rows"),
        ({"folds": [(range(10), range(60, 70))]}, "training rows of fold 0 cost nothing in a single leaf"),
        ({"depths": [3]}, "depths is"),
        ({"depths": [0, 1]}, "depths is"),
        ({"rule": "best"}, "rule is 'best'"),
        ({"most_solves": 0}, "most_solves is 0"),
        ({"problem": WEIGHTLESS, "folds": [(range(140), range(140, 150))]}, "all have weight 0"),
        ({"problem": IRIS.replace(loss=ClassCosts(np.zeros((3, 3)))), "folds": 2}, "cost nothing in a single leaf"),
    ],
)
def test_what_cannot_be_chosen_by_is_refused_with_a_sentence(options, sentence):
    with pytest.raises(ProblemError, match=sentence):
        choose_tree(**{"problem": IRIS, **options})


@pytest.mark.parametrize("exponent", [600, -600])
@pytest.mark.parametrize("scaled", ["costs", "weights"])
def test_costs_or_weights_in_another_unit_choose_the_same_tree_where_their_squares_are_no_numbers(exponent, scaled):
    unit = 2.0**exponent
    changes = {"loss": ClassCosts(IRIS.costs * unit)} if scaled == "costs" else {"weights": np.full(150, unit)}
    plain, other = choose_tree(IRIS, folds=3), choose_tree(IRIS.replace(**changes), folds=3)
    assert other.solution.tree == plain.solution.tree
    per_weight = unit if scaled == "costs" else 1.0
    assert [s.standard_error / per_weight for s in other.steps] == [s.standard_error for s in plain.steps]
    assert other.expectation.tree.high / per_weight == plain.expectation.tree.high


# Frontiers: each point is the optimum of its own problem, and neither objectives nor bounds go the wrong way


FEATURES = np.random.default_rng(3).normal(size=(40, 3)).round(1)
LABELS = (FEATURES[:, 0] + 0.5 * FEATURES[:, 1] > 0).astype(int) + (FEATURES[:, 2] > 0.8)
PROBLEM = Problem(FEATURES, LABELS, depth=3)
NUMBERS = Problem(FEATURES, np.round(FEATURES[:, 0] * FEATURES[:, 1], 1), depth=2, loss=SquaredError())


@pytest.mark.parametrize("problem", [PROBLEM, NUMBERS], ids=["classes", "numbers"])
@pytest.mark.parametrize("over", ["depth", "budget", "penalty"])
def test_every_point_is_the_optimum_of_its_own_problem(over, problem):
    points = trace_frontier(problem, over)
    if over == "penalty":
        assert [point.value for point in points] == [best.penalty for best in trace_path(problem).trees]
    else:
        assert [point.value for point in points] == list(default_values(problem, over))
    for point in points:
        certify(point.problem, point.solution)
        assert point.solution.is_optimal
        assert point.solution.objective == solve(point.problem).objective
    plain = [problem.replace(leaf_penalty=0.0).objective(point.solution.tree) for point in points]
    assert plain == sorted(plain, reverse=over != "penalty")


def test_a_bound_of_a_wider_limit_serves_the_tighter_ones():
    def point(value, objective, bound, stop=Stop.TIME):
        solution = Solution(Leaf(0), objective, bound, stop, 0.0, 0, "exact", "1", 0)
        return Point(value, PROBLEM, solution)

    points = [point(1, 9.0, -math.inf), point(2, 7.0, 7.0, Stop.OPTIMAL), point(3, 5.0, 2.0), point(4, 4.0, 3.0)]
    after = [p.solution for p in _with_bounds_of_wider_limits(points)]
    assert [s.bound for s in after] == [7.0, 7.0, 3.0, 3.0]
    same = _with_bounds_of_wider_limits([point(1, 7.0, 1.0), point(2, 7.0, 7.0, Stop.OPTIMAL)])[0].solution
    assert same.is_optimal
    assert same.stop is Stop.OPTIMAL


def test_a_bound_that_is_taken_over_never_exceeds_the_tree_of_its_point():
    """Sums of two problems are rounded each for itself: the wider bound may lie above the tighter tree by a hair."""
    above = math.nextafter(7.0, 8.0)
    tight = Solution(Leaf(0), 7.0, 1.0, Stop.TIME, 0.0, 0, "exact", "1", 0)
    wide = Solution(Leaf(0), above, above, Stop.OPTIMAL, 0.0, 0, "exact", "1", 0)
    after = _with_bounds_of_wider_limits([Point(1, PROBLEM, tight), Point(2, PROBLEM, wide)])
    assert [point.solution.bound for point in after] == [7.0, above]
    assert after[0].solution.stop is Stop.OPTIMAL


def test_values_are_taken_in_order_whatever_order_they_come_in():
    points = trace_frontier(PROBLEM, "depth", [2, 1], method="cart", limits=Limits(seconds=10))
    assert [point.problem.shape.depth for point in points] == [1, 2]


@pytest.mark.parametrize(
    ("over", "values", "sentence"),
    [("depth", [1.5], r"depth is 1\.5"), ("budget", [-1], "sensor_budget is -1"), ("width", None, "over is 'width'")],
)
def test_a_value_that_makes_no_problem_is_refused(over, values, sentence):
    with pytest.raises(ProblemError, match=sentence):
        trace_frontier(PROBLEM, over, values, method="cart")


def test_budgets_must_be_named_where_sensors_differ_in_cost():
    expensive = PROBLEM.replace(sensor_cost=[1, 2, 5])
    with pytest.raises(ProblemError, match="name the values"):
        trace_frontier(expensive, "budget")
    assert len(trace_frontier(expensive, "budget", [2, 3], method="cart")) == 2


def test_penalties_have_no_default_values_without_their_path():
    with pytest.raises(ProblemError, match="over is 'penalty'; expected depth or budget"):
        default_values(PROBLEM, "penalty")
