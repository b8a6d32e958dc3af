"""Forecast and planner: survival and costs by enumeration, lives in their bands, what an inspection is worth."""

import itertools

import numpy as np
import pytest

from octmip.errors import ProblemError
from octmip.monitor import (
    Action,
    Belief,
    Filter,
    Growth,
    Library,
    Planner,
    learnt_rates,
    remaining_life,
    steady_growth,
)
from tests.test_octmip.test_monitor_filter import WholeReading

CHAIN = Library(("mu1",), [[0.0], [0.3], [0.6]], ("a",), [[1.0], [2.0], [4.0]], 1.0)
GROWTH = steady_growth(CHAIN, (0.05, 0.2), sudden=0.02, change=0.1)
FAILS = np.array([0.0, 0.1, 0.6])
START = np.array([[[0.4, 0.1, 0.0], [0.3, 0.0, 0.2]]])


def ways(n_steps):
    """Yield every history of rates and states, with its probability from START."""
    for rates in itertools.product(range(2), repeat=n_steps + 1):
        for states in itertools.product(range(3), repeat=n_steps + 1):
            p = START[0, rates[0], states[0]]
            for k in range(n_steps):
                p *= GROWTH.transitions[rates[k], states[k], states[k + 1]] * GROWTH.changes[rates[k], rates[k + 1]]
            yield states, p


def test_survival_is_what_enumerating_all_histories_gives():
    life = remaining_life(GROWTH, Belief(CHAIN, START), FAILS, 3)
    for k in range(4):
        assert life.survival[0, k] == pytest.approx(sum(p * np.prod(1.0 - FAILS[list(s[1:])]) for s, p in ways(k)))
    assert life.quantile(0.1)[0] == np.argmax(1.0 - life.survival[0] >= 0.1)
    assert life.quantile(0.99)[0] == np.inf


def test_nine_of_ten_lives_end_within_their_bands():
    # damage grows by gamma increments at a rate between the filter's, with the scatter of its cells
    rng, width, n = np.random.default_rng(11), 0.04, 400
    slopes = np.array([200.0, -100.0])
    centres = (np.arange(25)[:, None] + 0.5) * width
    library = Library(("mu1",), centres, ("a", "b"), centres * slopes, 20.0, [width], np.tile(slopes, (25, 1, 1)))
    growth = steady_growth(library, np.geomspace(0.002, 0.03, 6))
    chain = Filter(WholeReading(library), growth)
    rates = np.exp(rng.uniform(np.log(0.002), np.log(0.03), n))
    damage = np.cumsum(rng.gamma(rates[:, None] / width, width, (n, 800)), axis=1)
    life = (damage <= 0.8).sum(axis=1) + 1.0
    belief, seen = chain.start(n, state=0), np.minimum(20, life - 1).astype(int)
    for k in range(20):
        clean = np.minimum(damage[:, k, None], 1.0) * slopes
        later = chain.step(belief, clean + rng.normal(0.0, 20.0, clean.shape), 1.0)
        belief = Belief(library, np.where((k < seen)[:, None, None], later.weights, belief.weights))
    low, high = remaining_life(growth, belief, library.states[:, 0] > 0.8, 800).interval(0.9)
    inside = (low <= life - seen) & (life - seen <= high)
    assert 0.86 <= inside.mean() <= 0.94


def test_rates_are_learnt_over_flights():
    rng = np.random.default_rng(3)
    library = Library(("mu1",), [[0.1 * k] for k in range(11)], ("a",), [[100.0 * k] for k in range(11)], 10.0)
    chain = Filter(WholeReading(library), steady_growth(library, (0.01, 0.05), change=0.0))
    rates = np.array([0.5, 0.5])
    for _ in range(3):
        belief = chain.start(20, 0, rates)
        states = np.minimum(np.cumsum(rng.random((20, 25)) < 0.5, axis=1), 10)  # all grow by 0.05
        for k in range(25):
            belief = chain.step(belief, 100.0 * states[:, k, None] + rng.normal(0.0, 10.0, (20, 1)), 1.0)
        rates = learnt_rates(rates, belief)
    assert rates[1] > 0.97
    with pytest.raises(ProblemError, match="rates has shape"):
        chain.start(1, 0, np.ones(3) / 3)


def test_the_planner_costs_what_the_best_of_all_rules_costs():
    quick = Action("quick", 1.0, FAILS, GROWTH)
    calm = Action("calm", 1.6, FAILS / 4, steady_growth(CHAIN, (0.01, 0.05), sudden=0.02, change=0.1))
    plan = Planner.of((quick, calm), failure=10.0, n_steps=3)

    def cost(left, rate, state):
        if left == 0:
            return 0.0
        return min(one(action, left, rate, state) for action in (quick, calm))

    def one(action, left, rate, state):
        later = sum(
            action.growth.changes[rate, r] * action.growth.transitions[rate, state, s] * cost(left - 1, r, s)
            for r in range(2)
            for s in range(3)
        )
        fails = action.fails[state]
        return action.cost + fails * 10.0 + (1.0 - fails) * later

    for rate, state in itertools.product(range(2), range(3)):
        sure = np.zeros((1, 2, 3))
        sure[0, rate, state] = 1.0
        expected = [one(action, 3, rate, state) for action in (quick, calm)]
        assert plan.expected(sure, np.array([3]))[0] == pytest.approx(expected)
        knowing = plan.choose_knowing(
            np.array([[quick.fails[state]], [calm.fails[state]]]), np.array([rate]), np.array([state]), np.array([3])
        )
        assert knowing[0] == plan.choose(sure, np.array([3]))[0] == np.argmin(expected)


def test_an_inspection_is_worth_more_the_later_the_state_is_known():
    doubt, sure = np.array([[[0.25, 0.0, 0.25], [0.25, 0.0, 0.25]]]), np.array([[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    still = Growth((np.eye(3)[None].repeat(2, axis=0),), np.eye(2))
    actions = (Action("quick", 1.0, (0.0, 0.0, 0.2), still), Action("calm", 1.5, (0.0, 0.0, 0.0), still))
    worth = []
    for told_after in (1, 5, 20):
        plan = Planner.of(actions, 300.0, 40, inspection=2.0, told_after=told_after)
        costs = plan.expected(doubt, np.array([40]))[0]
        worth.append(costs[:2].min() - costs[2])
        assert plan.names[plan.choose(sure, np.array([40]))[0]] == "quick"
    assert worth[0] < 0.0 < worth[2]
    assert worth == sorted(worth)
    assert plan.names[plan.choose(doubt, np.array([40]))[0]] == "inspect"


def test_a_plan_that_cannot_be_is_refused():
    quick = Action("quick", 1.0, FAILS, GROWTH)
    with pytest.raises(ProblemError, match="fails of 'quick' has shape"):
        Planner.of((Action("quick", 1.0, FAILS[:2], GROWTH),), 1.0, 3)
    with pytest.raises(ProblemError, match=r"growth of 'calm' has \(1, 3\)"):
        Planner.of((quick, Action("calm", 1.0, FAILS, steady_growth(CHAIN, 0.05))), 1.0, 3)
    with pytest.raises(ProblemError, match="place that is not lower"):
        Planner.of((Action("quick", 1.0, FAILS, GROWTH, np.eye(4)),), 1.0, 3)
    with pytest.raises(ProblemError, match=r"values from 0\.0 to 2\.0"):
        remaining_life(GROWTH, Belief(CHAIN, START), [0.0, 1.0, 2.0], 3)
