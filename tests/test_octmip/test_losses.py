"""Every loss by the same checks: the best leaf, exact costs, and what people judge predictions by."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from octmip import AbsoluteError, Problem, certify, near_optimal, sensor_roles, solve
from octmip.errors import ProblemError
from octmip.sensing.sensor_sets import shared_budget
from octmip.trees.question.losses import SPELLINGS, ClassCosts, NumberLoss, exact_sums, loss_of, number_loss
from octmip.trees.runs.registry import lacked
from octmip.trees.tradeoff.leaf_shares import leaves_on_fresh_rows

LOSSES = {
    "classes": ClassCosts(),
    "costs": ClassCosts([[0.25, 1, 4], [3, 0, 1], [0.5, 2, 0]]),
    **{spelling: number_loss(spelling) for spelling in SPELLINGS},
}
RNG = np.random.default_rng(5)
FEATURES = RNG.integers(0, 6, (30, 2)).astype(float)
TARGETS = RNG.integers(0, 3, 30)
TARGETS[:3] = [0, 1, 2]
WEIGHTS = RNG.integers(0, 5, 30) / 8
WEIGHTS[0] = 0.125


@pytest.fixture(params=LOSSES, ids=str)
def problem(request):
    loss = LOSSES[request.param]
    targets = TARGETS if loss.predicts == "class" else TARGETS * 0.75
    return Problem(FEATURES, targets, depth=2, weights=WEIGHTS, loss=loss)


def error_of(loss, miss):
    """Return the error of a target that lies so far above its prediction."""
    if loss.name == "squared":
        return miss**2
    level = Fraction(str(loss.level)) if loss.name == "quantile" else None
    return abs(miss) if level is None else level * miss if miss > 0 else (level - 1) * miss


def costs_of(problem, value):
    """Return the cost of one leaf by the definition of the loss."""
    if problem.loss.predicts == "class":
        paid = [problem.costs[code, int(value)] for code in problem.samples.codes]
    else:
        paid = [error_of(problem.loss, Fraction(code) - Fraction(value)) for code in problem.samples.codes.tolist()]
    return sum(Fraction(w) * Fraction(c) for w, c in zip(problem.samples.weights.tolist(), paid, strict=True))


def test_no_other_value_makes_a_cheaper_leaf(problem):
    best = problem.loss.best_value(problem.samples.weights, problem.samples.codes)
    others = range(3) if problem.loss.predicts == "class" else [best - 1e-6, best + 1e-6, 0.0, 0.75, 1.5]
    assert all(costs_of(problem, best) <= costs_of(problem, other) + Fraction(1, 10**15) for other in others)


def test_a_cost_is_what_its_definition_says_in_exact_arithmetic(problem):
    value = 1 if problem.loss.predicts == "class" else 0.75
    predicted = np.full(problem.samples.n_samples, value)
    exact = problem.loss.exact_cost(problem.samples.weights, problem.samples.codes, predicted)
    assert exact == costs_of(problem, value)
    cost = problem.loss.cost(problem.samples.weights, problem.samples.codes, predicted, Fraction(1, 2))
    assert cost == pytest.approx(float(exact) + 0.5, rel=1e-15)


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("spread", [0, 30, 250])
def test_rows_summed_together_are_those_summed_one_by_one(monkeypatch, spelling, spread):
    rng, loss = np.random.default_rng(spread), number_loss(spelling)
    targets = rng.normal(size=600) * 10.0 ** rng.integers(-spread, spread + 1, 600)
    weights, values = rng.choice([0.0, 1.0, 0.1, 7e-5], 600), rng.choice(rng.normal(size=4), 600)
    found = []
    for fewest in (1, 10**9):
        monkeypatch.setattr(exact_sums, "FEWEST_ROWS", fewest)
        found.append((loss.exact_cost(weights, targets, values), loss.best_value(weights, targets)))
    assert found[0] == found[1]


def test_a_proven_tree_is_certified_and_measured(problem):
    solution = solve(problem)
    certificate = certify(problem, solution)
    assert solution.is_optimal
    predicted = problem.predictions(solution.tree)
    if problem.loss.predicts == "class":
        assert certificate.errors == int((predicted != problem.samples.codes).sum())
        return
    misses = np.abs(predicted - problem.samples.targets)
    assert certificate.measures["mae"] == pytest.approx((misses * WEIGHTS).sum() / WEIGHTS.sum())
    assert certificate.measures["rmse"] == pytest.approx(np.sqrt((misses**2 * WEIGHTS).sum() / WEIGHTS.sum()))


def test_a_problem_of_numbers_has_no_costs_of_classes():
    with pytest.raises(ProblemError, match="needs classes"):
        _ = Problem(FEATURES, TARGETS, depth=1, loss=number_loss("squared")).costs


@pytest.mark.parametrize("method", ["exact", "search"])
def test_what_no_solver_of_numbers_knows_is_refused_by_name(method):
    planes = Problem(FEATURES, TARGETS, depth=1, loss=number_loss("absolute"), split="hyperplane", integer_normals=3)
    with pytest.raises(ProblemError, match=r"integer_normals|finds no hyperplane trees"):
        solve(planes, method)


@pytest.mark.parametrize("method", ["exact", "search"])
def test_numbers_keep_to_the_features_that_splits_may_read(method):
    targets = FEATURES[:, 0] + 0.1 * FEATURES[:, 1]
    problem = Problem(FEATURES, targets, depth=2, loss=number_loss("squared"), allowed_splits=[[1]])
    alone = Problem(FEATURES[:, [1]], targets, depth=2, loss=number_loss("squared"))
    assert certify(problem, solve(problem, method)).sensors == ("x1",)
    assert solve(problem).objective == solve(alone).objective


@pytest.mark.parametrize(
    ("spelling", "sentence"),
    [
        ("cubic", "loss is 'cubic'; expected a loss of numbers, such as squared, absolute, quantile:0.9"),
        ("squared:2", "loss 'squared' takes nothing behind its name, but '2' stands there"),
        ("quantile", "level of the quantile loss is ''; expected a number between 0 and 1"),
        ("quantile:high", "level of the quantile loss is 'high'"),
        ("quantile:1/0", "level of the quantile loss is '1/0'"),
        ("quantile:1", "level of the quantile loss is 1.0"),
        ("quantile:-0.1", "level of the quantile loss is -0.1"),
        ("quantile:nan", "level of the quantile loss is 'nan'"),
        ("quantile:0.12345", "a fraction of whole numbers up to 1000"),
    ],
)
def test_a_loss_that_is_none_is_refused_by_name(spelling, sentence):
    with pytest.raises(ProblemError, match=sentence):
        number_loss(spelling)


@pytest.mark.parametrize("spelling", [*SPELLINGS, "quantile:1/3"])
def test_a_loss_is_read_again_from_its_spelling_and_its_json(spelling):
    loss = number_loss(spelling)
    assert loss == number_loss(loss) == number_loss(loss.spelling) == loss_of(loss.to_json())
    assert set(loss.measures(np.ones(2), np.zeros(2), np.ones(2))) == set(loss.measured)


@pytest.mark.parametrize(
    ("spelling", "words"),
    [("squared", "absolute error 0.5"), ("quantile:0.9", "error of the 0.9 quantile 0.45, 75 % at or below")],
)
def test_the_measures_are_said_first_the_mean_error_and_of_a_quantile_what_it_covers(spelling, words):
    loss = number_loss(spelling)
    measures = loss.measures(np.array([3.0, 1.0]), np.array([0.0, 4.0]), np.array([0.0, 2.0]))
    assert loss.short_words_of(measures, 2) == f"mean {words}"
    assert loss.words_of(measures, 2) == f"2 samples, mean {words}, root of the mean squared error 1"


def test_half_the_absolute_error_is_the_quantile_loss_of_the_middle():
    targets = TARGETS * 0.75
    middle, absolute = (
        solve(Problem(FEATURES, targets, depth=2, loss=number_loss(name))) for name in ("quantile:0.5", "absolute")
    )
    assert (2 * middle.objective, 2 * middle.bound, middle.tree) == (absolute.objective, absolute.bound, absolute.tree)


def test_the_digest_of_a_problem_tells_levels_apart():
    digests = {Problem(FEATURES, TARGETS, depth=1, loss=number_loss(name)).digest() for name in SPELLINGS}
    assert len(digests) == len(SPELLINGS)


@pytest.mark.parametrize(
    ("asked", "ask"),
    [
        ("near_optimal", lambda problem: near_optimal(problem, relative=0.1)),
        ("sensor_roles", sensor_roles),
        ("leaves_on_fresh_rows", lambda problem: leaves_on_fresh_rows(problem, problem.best_leaf())),
        ("shared_budget", lambda problem: shared_budget([problem, problem], 2.0)),
    ],
)
def test_what_is_asked_of_classes_alone_is_a_line_of_the_registry_and_refused_in_one_sentence(asked, ask):
    problem = Problem([[0.0], [1.0], [2.0]], [0.0, 1.0, 5.0], depth=1, loss=AbsoluteError())
    with pytest.raises(
        ProblemError, match=f"^{asked} is for classes, as .*; got the loss 'absolute'; sort the numbers"
    ):
        ask(problem)
    assert asked in lacked("numbers", "call")


@dataclass(frozen=True)
class Cubed(NumberLoss):
    """An error that no core has a kernel for."""

    name = "cubed"
    words = "cubed error"

    def of_misses(self, misses):
        return np.abs(misses) ** 3

    def best_value(self, weights, codes):
        return float(np.median(codes))

    def exact_cost(self, weights, codes, predicted):
        return Fraction(float(self.of_misses(codes - predicted) @ weights))


def test_a_loss_that_no_core_minimises_is_refused():
    with pytest.raises(ProblemError, match="loss 'cubed' is neither the squared error nor a SlopedError"):
        Problem(FEATURES, TARGETS, depth=1, loss=Cubed())
