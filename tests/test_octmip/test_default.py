"""The default answer: what it is chosen among, that it is the same wherever it runs, and what it says of new rows."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from sklearn.datasets import load_iris
from sklearn.tree import DecisionTreeClassifier

from octmip import Problem, SquaredError, certify
from octmip.interfaces.report.new_rows import choice_text
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.encoding import Coarse
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.methods.pruning import priced_prunings, prunings
from octmip.trees.nodes.tree import Leaf, Node, depth, n_splits, predict
from octmip.trees.runs.registry import Run
from octmip.trees.tradeoff import choice as choice_module
from octmip.trees.tradeoff import default as default_module
from octmip.trees.tradeoff.choice import RULES
from octmip.trees.tradeoff.default import solve_default
from octmip.trees.tradeoff.family import default_families, trace_families
from octmip.trees.tradeoff.repeats import counted
from octmip.trees.tradeoff.sample import FEWEST_ROWS, sampled
from octmip.trees.tradeoff.validation import Judged, Nearness

IRIS = Problem(*load_iris(return_X_y=True), depth=1)
RNG = np.random.default_rng(3)
WEIGHED = Problem(RNG.normal(size=(60, 3)).round(1), RNG.integers(3, size=60), depth=6, weights=RNG.integers(1, 4, 60))
NUMBERS = Problem(RNG.normal(size=(60, 2)).round(1), RNG.normal(size=60).round(1), depth=5, loss=SquaredError())


def every_pruning(problem: Problem, tree: Node, rows: np.ndarray) -> list[tuple[int, float, Node]]:
    """Return splits, cost and tree of every pruning of a small tree."""
    leaf, cost = problem.leaf_and_cost(rows)
    found: list[tuple[int, float, Node]] = [(0, cost, leaf)]
    if not isinstance(tree, Leaf):
        left = problem.samples.features[rows, tree.feature] <= tree.threshold
        sides = (every_pruning(problem, side, rows[part]) for side, part in ((tree.left, left), (tree.right, ~left)))
        for (a, cost_a, left_tree), (b, cost_b, right_tree) in itertools.product(*sides):
            found.append((a + b + 1, cost_a + cost_b, replace(tree, left=left_tree, right=right_tree)))
    return found


@pytest.mark.parametrize("problem", [WEIGHED, NUMBERS], ids=["classes", "numbers"])
def test_for_every_price_some_pruning_that_is_kept_is_as_good_as_any(problem):
    problem = problem.replace(depth=4)
    tree = greedy_tree(problem).tree
    kept = list(prunings(problem, tree))
    every = every_pruning(problem, tree, np.arange(problem.samples.n_samples))
    for price in np.linspace(0.001, problem.baseline, 60):
        best = min(cost + price * size for size, cost, _ in every)
        assert min(problem.objective(t) + price * n_splits(t) for t in [tree, *kept]) == pytest.approx(best)
    assert [n_splits(t) for t in kept] == sorted({n_splits(t) for t in kept}, reverse=True)
    assert n_splits(kept[-1]) == 0


def test_cuts_are_at_quantiles_and_a_tree_over_intervals_is_the_same_over_readings():
    readings = np.array([1.0, 1, 2, 5, 6, 9])[:, None]
    coarse = Coarse.of(Problem(readings, [0, 0, 0, 1, 1, 0], depth=2), 2)
    assert coarse.cuts[0].tolist() == [1.5, 5.5]
    assert coarse.problem.samples.features[:, 0].tolist() == [0, 0, 1, 1, 2, 2]
    few = Coarse.of(IRIS, 4)
    assert max(map(len, few.cuts)) == 4
    for tree in (greedy_tree(few.problem.replace(depth=4)).tree,):
        over = few.over_readings(tree)
        assert IRIS.objective(over) == few.problem.objective(tree)
        assert few.problem.objective(few.over_intervals(over)) == IRIS.objective(over)
    all_values = Coarse.of(IRIS, 1000)
    assert [len(cuts) + 1 for cuts in all_values.cuts] == [len(np.unique(column)) for column in IRIS.samples.features.T]


def test_missing_readings_stay_missing_over_intervals():
    features = np.array([[1.0], [2.0], [np.nan], [4.0]])
    coarse = Coarse.of(Problem(features, [0, 0, 1, 1], depth=1), 5)
    assert np.isnan(coarse.problem.samples.features[2, 0])
    assert coarse.problem.samples.features[[0, 1, 3], 0].tolist() == [0, 1, 2]


def answer_of(problem, **run):
    return solve_default(problem, Run("auto", Limits(), 0, **run))


@pytest.fixture(scope="module")
def of_iris():
    return answer_of(IRIS)


def test_the_default_is_the_best_step_of_all_families_and_is_certified(of_iris):
    found = of_iris
    certify(found.problem, found.solution)
    assert {step.family.words for step in found.choice.steps} == {family.words for family in default_families(IRIS)}
    least = min(step.validation_cost for step in found.choice.steps)
    chosen = found.choice.chosen
    assert chosen.validation_cost <= least + 0.5 * max(step.standard_error for step in found.choice.steps)
    assert not [
        step
        for step in found.choice.steps
        if step.validation_cost <= chosen.validation_cost and step.complexity < chosen.complexity
    ]
    said = found.solution.details["choice"]
    assert said["kind"] == chosen.family.words
    assert said["expected"]["tree"]["low"] <= said["expected"]["tree"]["mean"] <= said["expected"]["tree"]["high"]


def test_the_family_of_any_tree_begins_at_the_trees_of_all_others():
    features = np.random.default_rng(3).integers(0, 2, (200, 20)).astype(float)
    problem = Problem(features, features[:, :4].sum(axis=1) % 2, depth=1)  # parity, which no greedy tree finds
    *others, last = trace_families(problem, default_families(problem), Run(limits=Limits(nodes=20_000)), 8)
    best = [min(tree.cost + 2.0 * tree.complexity for tree in path.trees) for path in (*others, last)]
    assert best[-1] == min(best) == 2.0 * 15


def test_one_seed_gives_one_choice_on_one_thread_and_on_two(of_iris):
    """Processes are asked in `test_choice`, which takes the folds by the same lines."""
    alone, threads = of_iris, answer_of(IRIS, n_jobs=2)
    assert threads.choice.steps == alone.choice.steps
    assert threads.solution.tree == alone.solution.tree
    assert threads.solution.bound == alone.solution.bound
    assert threads.choice.expectation == alone.choice.expectation


@pytest.mark.long
def test_rows_repeated_and_rows_weighed_are_chosen_for_alike():
    features, targets, weights = IRIS.samples.features[::3, 1:], IRIS.samples.targets[::3], RNG.integers(1, 3, 50)
    weighed = answer_of(Problem(features, targets, depth=1, weights=weights))
    repeated = answer_of(Problem(np.repeat(features, weights, 0), np.repeat(targets, weights), depth=1))
    assert weighed.solution.tree == repeated.solution.tree
    assert weighed.choice.chosen == repeated.choice.chosen


CARTS = ["CART's tree, pruned", "CART's tree, pruned by impurity"]
FEW, ANY = "searched, depth 8 or less, at most 10 cuts of a feature", "searched, any depth"


@pytest.mark.parametrize(
    ("problem", "words"),
    [
        (IRIS, [*CARTS, *(f"optimal, depth {d} or less, at most 5 cuts of a feature" for d in (3, 4)), FEW, ANY]),
        (IRIS.replace(split="hyperplane"), [*CARTS, *(f"searched, depth {d} or less" for d in (1, 2, 3))]),
        (
            Problem(IRIS.samples.features, IRIS.samples.features[:, 0], depth=1, loss=SquaredError()),
            [CARTS[0], *(f"optimal, depth {d} or less, at most 10 cuts of a feature" for d in (3, 4))],
        ),
    ],
)
def test_the_families_are_those_of_the_study_of_tables(problem, words):
    assert [family.words for family in default_families(problem)] == words


def test_rows_too_few_to_choose_by_get_one_split_and_the_reason():
    found = answer_of(Problem([[0.0], [1.0]], ["a", "b"], depth=1))
    assert found.choice is None
    assert depth(found.solution.tree) == 1
    assert found.solution.details["choice"] == {"reason": "too few rows to cross-validate"}


def test_rows_for_which_there_is_no_time_are_drawn_from_and_the_leaves_are_fitted_to_all():
    rng = np.random.default_rng(2)
    features = rng.integers(0, 9, (30_000, 2)).astype(float)
    problem = Problem(features, (features.sum(axis=1) + rng.normal(size=30_000) > 8).astype(int), depth=1)
    found = solve_default(problem, Run("auto", Limits(seconds=0.0), 0))
    certify(found.problem, found.solution)
    assert found.problem.samples.n_samples == 30_000
    assert found.solution.details["choice"]["n_rows"] == found.choice.problem.samples.n_samples == FEWEST_ROWS
    assert found.solution.tree == found.problem.with_best_leaves(found.solution.tree)
    assert found.solution.bound == -math.inf
    said = choice_text(found.problem, found.solution)
    assert "1 kind of trees" in said
    assert "the time left out 5 more" in said
    assert "5,000 rows drawn at random" in said
    assert sampled(problem, 60.0, 6, 0) is None


def test_all_folds_together_have_the_seconds_of_the_whole(monkeypatch):
    given = []

    def traced(*_, seconds, **named):
        given.append(seconds)
        raise KeyboardInterrupt

    monkeypatch.setattr(choice_module, "trace_families", traced)
    monkeypatch.setattr(default_module, "sampled", lambda problem, seconds, turns, seed: given.append(seconds / turns))
    for n_jobs, turns in ((1, 6), (2, 3)):  # five folds and all rows
        solve_default(IRIS, Run("auto", Limits(seconds=6e4), 0, n_jobs=n_jobs))
        assert given[0] == choice_module.SHARE_OF_PATHS * 6e4 / turns
        assert given[1] == pytest.approx(given[0], rel=1e-3)  # less what has passed
        given.clear()


def interrupted_after(monkeypatch, n_calls):
    """Let Ctrl-C come when so many problems have their paths."""
    calls = []

    def traced(*arguments, **named):
        if len(calls) == n_calls:
            raise KeyboardInterrupt
        calls.append(1)
        return trace_families(*arguments, **named)

    monkeypatch.setattr(choice_module, "trace_families", traced)
    return answer_of(WEIGHED)


@pytest.mark.parametrize("n_calls", [0, 1])
def test_ctrl_c_before_the_end_of_a_fold_leaves_carts_tree(monkeypatch, n_calls):
    found = interrupted_after(monkeypatch, n_calls)
    assert found.solution.stop is Stop.INTERRUPTED
    assert found.solution.solver == "cart"
    assert found.choice is None


def test_ctrl_c_after_two_folds_leaves_the_choice_by_these_folds(monkeypatch):
    found = interrupted_after(monkeypatch, 3)
    assert found.solution.stop is Stop.INTERRUPTED
    assert found.solution.details["choice"]["n_folds"] == 2
    assert {step.family.words for step in found.choice.steps} == {f.words for f in default_families(WEIGHED)}
    assert found.choice.chosen.validation_cost == min(
        step.validation_cost for step in found.choice.steps if step.complexity <= found.choice.chosen.complexity
    )
    assert set(found.choice.fold.tolist()) == {-1, 0, 1}
    certify(found.problem, found.solution)


def test_a_sample_is_as_many_rows_as_its_weight_holds_units_of_its_class():
    features, targets = [[0.0], [1], [1], [2], [3]], ["b", "a", "a", "b", "a"]
    rows = counted(Problem(features, targets, depth=1, weights=[5, 2, 1, 5, 1]))
    assert rows.samples.features[:, 0].tolist() == [0, 1, 1, 1, 2, 3]
    assert rows.samples.weights.tolist() == [5, 1, 1, 1, 5, 1]
    assert counted(rows.replace(weights=[5, 2, 2, 2, 7.5, 2])).samples.weights.tolist() == [2.5] * 2 + [2] * 3 + [
        2.5
    ] * 3 + [2]
    irregular = counted(rows.replace(weights=[5, 1, 1, 1, 5 * math.pi, 1]))
    assert irregular.samples.weights.tolist() == [5, 1, 1, 1, 5 * math.pi, 1]
    assert counted(Problem(features, targets, depth=1, leaf_size=2)).samples.n_samples == 5
    weightless = counted(Problem([*features, [1e300]], [*targets, "b"], depth=1, weights=[5, 2, 1, 5, 1, 0]))
    assert weightless.samples.weights.tolist() == [5, 1, 1, 1, 5, 1, 0]


def test_the_expected_cost_is_corrected_for_the_choice():
    rng = np.random.default_rng(0)
    losses = [(rng.random((60, 40)) < 0.5).astype(float) for _ in range(3)]  # forty trees that know nothing
    trees = np.repeat(np.arange(40)[:, None], 3, axis=1)
    judged = Judged(losses, [np.ones(60)] * 3, trees, np.arange(40))
    chosen = judged.sums().means()[judged.best(Nearness(0.0))]
    expected = judged.expectation(Nearness(0.0), np.arange(40) < 5, seed=0)
    assert chosen < 0.45
    assert expected.tree.mean == pytest.approx(0.5, abs=0.03)
    assert expected.tree.low < 0.5 < expected.tree.high
    assert expected.difference.mean == pytest.approx(expected.tree.mean - expected.cart.mean)


def test_cart_beside_the_choice_is_its_pruning_of_least_cost_whatever_the_rule():
    losses = np.random.default_rng(0).permuted(np.repeat([[0.6, 0.5, 0.3], [0.5, 0.4, 0.2]], 30, axis=0), axis=0)
    judged = Judged([losses], [np.ones(60)], np.arange(3)[:, None], np.arange(3))  # simplest first
    found = judged.expectation(Nearness(99.0), np.array([False, True, True]), seed=0)
    assert (found.tree.mean, found.cart.mean) == pytest.approx((0.55, 0.25), abs=0.01)


def test_a_simpler_tree_that_errs_on_the_same_rows_must_be_nearer_than_one_that_errs_on_others():
    least = np.arange(200) < 20
    same, others = np.arange(200) < 21, (np.arange(200) >= 100) & (np.arange(200) < 121)
    trees, simplicity = np.zeros((2, 1), dtype=np.int64), np.array([1, 0])
    trees[1] = 1
    for simpler, errors in ((same, np.sqrt(1 / 200 - 1 / 200**2)), (others, np.sqrt(41 / 200 - 1 / 200**2))):
        judged = Judged([np.stack([least, simpler], axis=1) * 1.0], [np.ones(200)], trees, simplicity)
        just = 1 / np.sqrt(200 * errors**2 + 1)  # the last 1 is the row that is added
        assert judged.best(Nearness(just * 1.001, is_paired=True)) == 1
        assert judged.best(Nearness(just * 0.999, is_paired=True)) == 0


@pytest.mark.long
def test_a_class_that_weighs_a_million_times_more_is_not_given_up_for_rows_of_the_other():
    # Rows of the heavy class that were held out are all right by both trees; the deeper one saves a few light ones.
    X = np.random.default_rng(0).normal(size=(60, 2))
    y = (X[:, 0] + X[:, 1] > 0).astype(int)
    weights = np.where(y == 0, 1e6, 1.0)
    chosen = answer_of(Problem(X, y, depth=1, weights=weights)).solution.tree
    new = np.random.default_rng(1).normal(size=(2000, 2))
    assert (predict(chosen, new)[new.sum(axis=1) < 0] == 0).all()


def test_prunings_by_impurity_are_those_of_scikit_learn():
    X, y = load_iris(return_X_y=True)
    problem = Problem(X, y, depth=30)
    grown = DecisionTreeClassifier(random_state=0).fit(X, y)
    sizes = {model.get_n_leaves() for model in pruned_models(grown.cost_complexity_pruning_path(X, y).ccp_alphas, X, y)}
    found = list(priced_prunings(problem, greedy_tree(problem).tree, by_impurity=True))
    assert {n_splits(tree) + 1 for _, tree in found} <= sizes
    assert len(found) > 3
    for price, tree in found:
        model = DecisionTreeClassifier(random_state=0, ccp_alpha=(price + 1e-9) / 150).fit(X, y)
        assert (predict(tree, X) == model.predict(X)).all()


def pruned_models(prices, X, y):
    return [DecisionTreeClassifier(random_state=0, ccp_alpha=max(0.0, price)).fit(X, y) for price in prices]


def test_standard_errors_are_those_of_the_rows():
    rng = np.random.default_rng(0)
    weights = rng.random(9)
    for w, losses in ((np.ones(5), np.array([0.0, 1.0, 1.0, 0.0, 1.0])), (weights, weights * rng.random(9))):
        judged = Judged([losses[:, None]], [w], np.zeros((1, 1), dtype=np.int64), np.arange(1))
        mean = losses.sum() / w.sum()
        error = math.sqrt(((losses - mean * w) ** 2).sum()) / w.sum()
        assert judged.sums().standard_errors()[0] == pytest.approx(error)


def test_the_loss_of_a_bad_tree_says_nothing_about_two_good_ones():
    losses = np.column_stack([np.full(50, 100.0), np.full(50, 1.2), np.full(50, 1.0)])  # simplest first
    trees, simplicity = np.array([[0, 0], [1, 1], [2, 2]]), np.arange(3)
    judged = Judged([losses, losses], [np.ones(50), np.ones(50)], trees, simplicity)
    assert judged.best(RULES["paired"]) == 2  # and not the simpler one, which costs 20 % more
