"""RiskModel: by hand, at its limits, and as the same objective for every solver and the certificate."""

import math
from dataclasses import replace

import numpy as np
import pytest

from octmip import Problem, predict, solve
from octmip.errors import ProblemError
from octmip.trees.question.risk import RiskModel
from octmip.trees.tradeoff import trace_risk_frontier

LOSSES = np.array([[0.0, 0.0], [0.4, 0.2], [0.2, 0.6], [0.8, 0.8]])


def asset(n=60, seed=3):
    """Return readings of two gauges that hardly tell losses of 0 to 80 % in two regions, and the losses."""
    rng = np.random.default_rng(seed)
    losses = rng.integers(0, 5, (n, 2)) / 5
    return losses + rng.normal(0, 0.25, (n, 2)), losses


def test_the_step_fails_beyond_its_limit_and_not_at_it():
    model = RiskModel()
    assert model.failure_probability(LOSSES, 3.0).tolist() == [0, 0, 1, 1]
    assert model.failure_probability(LOSSES, 2.0).tolist() == [0, 0, 0, 0]
    assert model.expected_losses(LOSSES).tolist() == [[0, 1], [0, 1], [10, 1], [10, 1]]
    assert model.regrets(LOSSES).tolist() == [[0, 1], [0, 1], [9, 0], [9, 0]]
    assert model.is_critical(LOSSES).tolist() == [False, False, True, True]
    assert model.decision_names == ("3 g allowed", "2 g only")


@pytest.mark.parametrize("shape", ["logistic", "lognormal"])
def test_a_fragility_is_one_half_at_the_limit_and_the_step_where_its_spread_vanishes(shape):
    model = RiskModel(spread=0.1, shape=shape)
    assert model.failure_probability([[0.4]], 3.0)[0] == pytest.approx(0.5)
    rising = model.failure_probability(np.linspace(0, 1, 50)[:, None], 3.0)
    assert (np.diff(rising) >= 0).all()
    assert rising[0] < 0.02
    assert rising[-1] > 0.98
    sharp = replace(model, spread=1e-6)
    assert np.allclose(sharp.failure_probability(LOSSES[[0, 2, 3]], 3.0), [0, 1, 1])


def test_the_formulas_of_both_fragilities_at_one_place():
    assert RiskModel(spread=0.1).failure_probability([[0.5]], 3.0)[0] == pytest.approx(1 / (1 + math.exp(-1)))
    lognormal = RiskModel(spread=0.2, shape="lognormal").failure_probability([[0.5]], 3.0)[0]
    assert lognormal == pytest.approx(0.5 * (1 + math.erf(math.log(1.25) / 0.2 / math.sqrt(2))))


def test_the_cautious_decision_is_right_from_the_ratio_of_prices_on():
    model = RiskModel(spread=0.05, failure_loss=10.0, limit_losses=(0.4, 1.0))
    losses = np.linspace(0, 0.8, 81)[:, None]
    gain = model.failure_probability(losses, 3.0) - model.failure_probability(losses, 2.0)
    assert (model.decisions(losses) == (gain > 0.1)).all()


def test_a_decision_problem_weighs_each_sample_by_the_regret_of_the_wrong_decision():
    problem = RiskModel().decision_problem(np.arange(8.0).reshape(4, 2), LOSSES, depth=1)
    assert problem.samples.class_names == ("3 g allowed", "2 g only")
    assert (problem.samples.codes.tolist(), problem.samples.weights.tolist()) == ([0, 0, 1, 1], [1, 1, 9, 9])


def test_a_state_problem_adds_what_a_wrong_state_leads_to():
    states = {0: 0.0, 40: 0.4, 80: 0.8}
    problem = RiskModel().state_problem(np.arange(4.0)[:, None], [0, 40, 80, 80], states, depth=1)
    assert problem.costs.tolist() == [[0, 1, 2], [1, 0, 2], [10, 10, 0]]


def test_the_objective_of_a_decision_problem_is_the_regret_over_all_samples():
    features, losses = asset(16)
    model = RiskModel(failure_loss=6.0)
    found = solve(model.decision_problem(features, losses, depth=2))
    assert found.is_optimal
    assert model.rates(losses, predict(found.tree, features)).regret * len(losses) == found.objective


def test_rates_count_what_was_missed_and_what_was_alarmed_for_nothing():
    rates = RiskModel().rates(LOSSES, [0, 1, 0, 1])
    assert (rates.missed_critical, rates.false_alarm, rates.n_critical, rates.n_sound) == (0.5, 0.5, 2, 2)
    assert rates.regret == (0 + 1 + 9 + 0) / 4
    assert math.isnan(RiskModel().rates(LOSSES[:2], [0, 0]).missed_critical)


def test_along_the_frontier_fewer_critical_states_are_missed_and_every_point_bounds_all_trees():
    features, losses = asset(120)
    points = trace_risk_frontier(RiskModel(), features, losses, [2, 4, 11, 31], depth=2)
    assert all(point.solution.is_optimal for point in points)
    missed = [point.rates.missed_critical * point.rates.n_critical for point in points]
    alarms = [point.rates.false_alarm * point.rates.n_sound for point in points]
    assert missed == sorted(missed, reverse=True)
    assert alarms == sorted(alarms)
    assert missed[0] > missed[-1]
    for point in points:  # the line of each proof lies below every tree
        price = point.model.failure_loss - 1
        assert all(price * m + a >= point.solution.bound - 1e-9 for m, a in zip(missed, alarms, strict=True))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"load_factors": (2.0, 3.0)}, "falling"),
        ({"limit_losses": (40.0, 80.0)}, "fractions"),
        ({"limit_losses": (0.4,)}, "one for each load factor"),
        ({"caution_losses": (1.0, 2.0)}, "0 for the boldest"),
        ({"failure_loss": -1.0}, "failure_loss"),
        ({"spread": math.nan}, "spread"),
        ({"shape": "step"}, "shape"),
    ],
)
def test_a_wrong_model_is_refused(options, said):
    with pytest.raises(ProblemError, match=said):
        RiskModel(**options)


def test_wrong_losses_labels_and_decisions_are_refused():
    model = RiskModel()
    with pytest.raises(ProblemError, match="not 40 percent"):
        model.regrets([[40.0]])
    with pytest.raises(ProblemError, match="one column per region"):
        model.regrets([0.4])
    with pytest.raises(ProblemError, match="add it to the model"):
        model.failure_probability(LOSSES, 2.5)
    with pytest.raises(ProblemError, match="lacks the labels"):
        model.state_problem(np.zeros((2, 1)), [0, 20], {0: 0.0}, depth=1)
    three = RiskModel((3.0, 2.5, 2.0), (0.4, 0.6, 0.8), (0.0, 0.5, 1.0))
    with pytest.raises(ProblemError, match="use state_problem"):
        three.decision_problem(np.zeros((4, 1)), LOSSES, depth=1)
    with pytest.raises(ProblemError, match="one index below"):
        model.rates(LOSSES, [0, 1, 2, 0])


def test_three_decisions_go_through_states():
    model = RiskModel((3.0, 2.5, 2.0), (0.4, 0.6, 0.8), (0.0, 0.5, 1.0))
    states = {0: 0.0, 60: 0.6, 80: 0.8}
    problem = model.state_problem(np.arange(3.0)[:, None], [0, 60, 80], states, depth=2, error_cost=0.0)
    assert isinstance(problem, Problem)
    assert problem.costs.tolist() == [[0, 0.5, 1], [9.5, 0, 0.5], [9, 9.5, 0]]
    assert solve(problem).objective == 0


def test_a_probability_of_ones_own_takes_the_place_of_limits():
    """As a twin's, for which the second region means nothing."""
    model = RiskModel(failure=lambda losses, load: np.clip(losses[:, 0] * load / 3.0, 0.0, 1.0), failure_loss=4.0)
    states = np.array([[0.0, 0.8], [0.6, 0.0], [0.2, 0.2]])
    np.testing.assert_allclose(model.failure_probability(states, 3.0), [0.0, 0.6, 0.2])
    np.testing.assert_allclose(model.expected_losses(states), [[0.0, 1.0], [2.4, 2.6], [0.8, 1 + 4 * 0.2 * 2 / 3]])
    assert model.is_critical(states).tolist() == [False, True, False]
    for bad in (lambda losses, load: [0.5], lambda losses, load: losses[:, 0] + 0.5):
        with pytest.raises(ProblemError, match="failure gave"):
            RiskModel(failure=bad).failure_probability(states, 3.0)
