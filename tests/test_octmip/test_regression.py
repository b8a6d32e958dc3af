"""Regression trees: the optimum by enumeration, bounds that hold, limits, numerics, what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.kinds.numbers import NUMBER_KINDS
from octmip import HyperplaneSplit, Leaf, Limits, Problem, Split, Stop, ValueLeaf, certify, predict_values, solve
from octmip.errors import CertificateError, TreeError
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.options import ExactOptions, SearchOptions
from octmip.trees.question.losses import SPELLINGS, AbsoluteError, SquaredError, number_loss
from octmip.trees.regression.best_split import Samples, by_means, parts
from octmip.trees.regression.exact import exact_regression
from octmip.trees.regression.leaf_models import fitted_leaf
from tests.oracles.regression_trees import least_objective, random_problem


def smooth(n=120, p=4, seed=0):
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(n, p))
    targets = np.where(features[:, 0] > 0.3, 2 * (features[:, 1] > 0), features[:, 2] > -0.5) + rng.normal(size=n) / 2
    return features, targets


def test_a_cluster_that_begins_in_the_last_of_the_bins_of_targets_is_counted(tmp_path):
    # One far target among 31: the best leaf of it alone lies inside the last bin.
    targets = [2.65, 0.38, 3.81, 0.06, 27.99, 0.68, 2.91, 4.73, 1.63, 1.43, 0.07, 0.69, 0.34, 1, 0, 0.04]
    targets += [0.56, 1.68, 0.67, 0.11, 0.31, 0.42, 0, 0.21, 0.22, 0.26, 1.89, 0.1, 2.44, 1.89, 2.4, 1.66]
    problem = Problem(np.arange(32.0)[:, None], np.array(targets), depth=2, loss=SquaredError())
    solution = exact_regression(problem, options=ExactOptions(proof=tmp_path / "proof.log"))
    assert solution.is_optimal
    assert solution.objective == pytest.approx(33.26635)
    assert check_proof(problem, tmp_path / "proof.log").bound <= 33.26635


@pytest.mark.parametrize(("seed", "loss"), [(540, "squared"), (615, "absolute")])
def test_a_cut_that_only_rounding_makes_cheaper_than_a_leaf_is_no_split(seed, loss, tmp_path):
    problem = random_problem(np.random.default_rng([27, seed]), loss)
    solution = solve(problem)
    assert solution.is_optimal
    assert NUMBER_KINDS["numbers"].complaint(problem, solution, least_objective(problem), tmp_path / "none") == ""


@pytest.mark.parametrize("loss", SPELLINGS)
def test_whole_numbers_are_proven_without_a_tolerance_and_depth_never_harms(loss):
    features, targets = smooth()
    costs = []
    for depth in (1, 2, 3):
        problem = Problem(features, np.round(targets * 4), depth=depth, loss=number_loss(loss))
        solution = solve(problem)
        assert solution.is_optimal
        assert loss != "absolute" or (solution.tolerance == 0 and solution.bound == solution.objective)
        costs.append(solution.objective)
    assert costs == sorted(costs, reverse=True)


@pytest.mark.parametrize("loss", SPELLINGS)
@pytest.mark.parametrize("n", [60, 1200])
@pytest.mark.parametrize("n_values", [2, 8, None])
def test_buckets_find_what_scans_of_all_samples_find(n, n_values, loss):
    features, targets = smooth(n)
    features[:, 1:] = np.round(features[:, 1:], 1)
    if n_values is not None:
        edges = np.quantile(targets, np.arange(1, n_values) / n_values)
        targets = np.cumsum([0, 3, 1, 7, 2, 2, 10, 4])[np.searchsorted(edges, targets)].astype(float)
    bucketed = solve(Problem(features, targets, depth=2, loss=number_loss(loss)))
    # A sample without weight changes no error, and buckets serve no such samples.
    weights, twice = np.append(np.ones(n), 0.0), np.append(targets, targets[0])
    problem = Problem(np.vstack([features, features[:1]]), twice, weights=weights, depth=2, loss=number_loss(loss))
    scanned = solve(problem)
    assert scanned.objective == pytest.approx(bucketed.objective, rel=1e-14)
    assert scanned.is_optimal
    assert bucketed.is_optimal


@pytest.mark.parametrize("loss", ["squared", "quantile:0.9"])
def test_a_limit_gives_the_best_tree_so_far_and_a_bound_that_holds(loss):
    features, targets = smooth(200, 5)
    problem = Problem(features, targets, depth=3, loss=number_loss(loss))
    best = solve(problem)
    for nodes in (1, 30, 200):
        early = solve(problem, limits=Limits(nodes=nodes))
        certify(problem, early)
        assert early.bound <= best.objective <= early.objective
    gap = solve(problem, limits=Limits(gap=0.5))
    assert gap.stop in (Stop.GAP, Stop.OPTIMAL)
    assert gap.gap <= 0.5
    assert solve(problem, limits=Limits(seconds=0)).stop is Stop.TIME


@pytest.mark.parametrize("loss", SPELLINGS)
def test_numbers_of_any_size_are_proven_or_said_not_to_be(loss):
    features, targets = smooth(30, 3)
    for scale, offset in ((1e-90, 0.0), (1e90, 0.0), (1.0, 1e9), (1e-3, -7.3), (1 / 3, 1 / 3)):
        problem = Problem(features, targets * scale + offset, depth=2, loss=number_loss(loss))
        solution = solve(problem)
        certify(problem, solution)
        assert solution.stop in (Stop.OPTIMAL, Stop.NUMERICS)
        assert solution.gap < 1e-6
    wild = Problem(features, targets, weights=10.0 ** np.linspace(-20, 20, 30), depth=2, loss=number_loss(loss))
    certify(wild, solve(wild))


@pytest.mark.parametrize("loss", SPELLINGS)
@pytest.mark.parametrize(
    "options",
    [{}, {"split": "hyperplane", "split_size": 2}, {"leaf_model": "linear"}, {"sensor_budget": 2}, {"leaf_size": 9}],
)
def test_search_finds_trees_of_the_problem_and_none_beats_the_proof(loss, options):
    features, targets = smooth(60)
    problem = Problem(features, targets, depth=2, loss=number_loss(loss), **options)
    found = solve(problem, "search", options=SearchOptions(restarts=2))
    assert certify(problem, found).bound == -math.inf
    assert found.objective < problem.baseline
    if "leaf_model" not in options and "split" not in options:
        assert found.objective >= solve(problem).objective
    assert solve(problem, "search", options=SearchOptions(restarts=2)).tree == found.tree


def test_linear_leaves_and_planes_find_what_made_the_data():
    rng = np.random.default_rng(3)
    features = rng.normal(size=(200, 3))
    targets = np.where(features[:, 0] + features[:, 1] > 0, 3 * features[:, 2] + 1, -features[:, 2])
    problem = Problem(
        features, targets, depth=1, split="hyperplane", leaf_model="linear", ridge=1e-9, loss=SquaredError()
    )
    found = solve(problem)
    assert found.bound == -math.inf
    assert found.objective < 0.2 * solve(Problem(features, targets, depth=1, loss=SquaredError())).objective


def test_numbers_of_features_in_other_units_have_the_same_plane():
    rng = np.random.default_rng(4)
    features = rng.normal(size=(80, 4))
    targets = np.sign(features @ [1.0, -0.8, 0.6, 0.0]) + 0.1 * rng.normal(size=80)
    units = 2.0 ** np.array([9.0, -7.0, 0.0, 4.0])
    options = {"depth": 1, "split": "hyperplane", "split_size": 2, "loss": SquaredError()}
    plain, scaled = (solve(Problem(values, targets, **options), "search") for values in (features, features * units))
    assert scaled.objective == plain.objective
    assert scaled.tree.features == plain.tree.features


def test_a_linear_leaf_predicts_by_its_features_and_a_malformed_one_is_refused():
    leaf = ValueLeaf(1.0, (0, 2), (2.0, -1.0))
    assert predict_values(leaf, np.array([[1.0, 9.0, 0.5], [0.0, 0.0, 1.0]])).tolist() == [2.5, 0.0]
    for wrong in (((0,), ()), ((2, 0), (1.0, 1.0)), ((0,), (math.nan,))):
        with pytest.raises(TreeError):
            ValueLeaf(0.0, *wrong)
    with pytest.raises(TreeError, match="predicts a class"):
        predict_values(Leaf(0), np.zeros((1, 1)))


def test_a_tree_beyond_all_numbers_is_refused_in_a_sentence():
    features, targets = smooth(30)
    problem = Problem(features, targets, depth=1, loss=SquaredError())
    wild = replace(solve(problem), tree=Split(0, 0.0, ValueLeaf(1e308), ValueLeaf(-1e308)))
    with pytest.raises(CertificateError, match="than float64 holds"):
        certify(problem, wild)


def test_predictions_and_errors_beyond_float64_are_said_or_kept_finite():
    steep = Split(0, 0.5, ValueLeaf(1e200), ValueLeaf(0.0, (0,), (1e308,)))
    with pytest.raises(TreeError, match=r"the prediction for row 1 is beyond float64 \(leaf 1 from the left\)"):
        predict_values(steep, np.array([[0.0], [100.0]]))
    problem = Problem(np.arange(8.0)[:, None], np.arange(8.0), depth=1, leaf_model="linear", loss=SquaredError())
    start = Split(0, 0.5, ValueLeaf(1e200), ValueLeaf(0.0))
    assert solve(problem, incumbent=start).objective < 1


@pytest.mark.parametrize(("loss", "n_draws"), [("squared", 12), ("absolute", 3)])
def test_leaves_of_a_least_size_with_room_in_the_nodes_are_those_of_a_list_of_all_trees(loss, n_draws):
    for seed in range(n_draws):
        rng = np.random.default_rng([84, seed])
        n, depth = int(rng.integers(36, 50)), 2 + seed % 2
        features = rng.integers(0, 4, (n, 2)).astype(float)
        targets = np.where(features[:, 0] > 1, 3.0, features[:, 1]) + rng.integers(0, 9, n) * (rng.random(n) < 0.3)
        problem = Problem(features, targets, depth=depth, loss=number_loss(loss), leaf_size=2 + seed % 3)
        solution = solve(problem, "exact")
        assert solution.is_optimal
        assert solution.objective == pytest.approx(float(least_objective(problem)), rel=1e-12)


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
    targets, order = np.array([0.0, 0.0, 0.0, 1.0, 9.0]), np.arange(5.0)[:, None]
    for features in (order, -order):
        question = asked(Problem(features, targets, depth=1, leaf_size=2, loss=SquaredError()))
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
