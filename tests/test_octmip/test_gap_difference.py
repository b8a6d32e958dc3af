"""What twin and asset differ by: one Gaussian process over run and campaign, learnt from the run, used in both."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from octmip.errors import DataError, TwinError
from octmip.gap import CHAIN, CachedTwin, Campaign, diagnose
from octmip.gap.inference.difference import _with_levels, wander_of
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import OPEN_STATE, difference_at, linearise
from octmip.gap.inference.rows import Rows
from tests.test_octmip.beam_twin import HEALTHY, Beam, effect, measured

TWIN = Beam()
RUN = measured(1000)


def prepared(campaign, run=RUN):
    return prepare(campaign, TWIN, {**CHAIN, **TWIN.effects}, run)[0]


def states_of(campaign):
    return np.array([cell.state for cell in campaign.cells])


def test_a_run_may_list_its_gauges_in_another_order():
    back = replace(RUN, gauges=RUN.gauges[::-1], readings=RUN.readings[:, ::-1])
    one, other = (prepared(measured(5), run).run for run in (RUN, back))
    assert np.allclose(one.rows.residual, other.rows.residual)


def test_without_a_run_the_difference_is_what_is_usual():
    campaign = measured(3)
    inputs = prepared(campaign, None)
    model = linearise(inputs, states_of(campaign))
    expected = model.noise + inputs.difference.covariance(model.rows, model.rows)
    assert np.allclose(model.covariance, expected + OPEN_STATE**2 * model.tangents @ model.tangents.T)
    assert model.given.log_run == 0.0


def test_a_difference_is_a_covariance_and_same_cells_share_all_of_it():
    inputs = prepared(measured(3))
    rows = inputs.run.rows
    covariance = inputs.difference.covariance(rows, rows)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9 * np.linalg.eigvalsh(covariance).max()
    once = rows.at(np.arange(1))
    assert inputs.difference.covariance(once, once)[0, 0] == pytest.approx(covariance[0, 0])


def test_what_a_run_measures_is_taken_off_the_campaign():
    mean, covariance = difference_at(prepared(measured(3)), 3.0, {"mu1": 0.0, "mu2": 0.0})
    truth = 3.0 * HEALTHY * (0.01 * (0.9 + np.random.default_rng(12345).standard_normal(20)))
    assert np.abs((mean - truth) / np.sqrt(np.diag(covariance))).max() < 4.0
    assert np.sqrt(np.diag(covariance)).max() < 6.0


def poor_at(gauge, share):
    """Return a change of what one gauge reads at all times: the twin is poor there."""
    here = np.arange(20) == gauge
    return lambda state, load, time: share * here * TWIN.predict(state, load) * (1.0 + 0.2 * load)


def test_a_reading_that_is_poor_in_the_twin_is_learnt_from_the_run_said_and_used():
    run = measured(1001, poor_at(4, 0.12))
    assert diagnose(measured(5, poor_at(4, 0.12)), TWIN, commissioning=run).is_sound
    both = lambda state, load, time: (  # noqa: E731
        poor_at(4, 0.12)(state, load, time) + 0.04 * (np.arange(20) == 4) * TWIN.predict(state, load)
    )
    diagnosis = diagnose(measured(6, both), TWIN, commissioning=run)
    assert any("poor at g05" in note and "learnt from the commissioning run" in note for note in diagnosis.notes)
    assert not diagnosis.doubts
    assert "gauge_gain" in diagnosis.which[0].effects


def joined(campaigns):
    """Return campaigns as one, the tests of each named by its number."""
    names = tuple(f"day {k}" for k, one in enumerate(campaigns) for _ in one.test)
    parts = {
        name: np.concatenate([getattr(one, name) for one in campaigns])
        for name in ("load_factor", "states", "readings", "time", "temperature")
    }
    return Campaign(gauges=TWIN.gauges, parameters=TWIN.parameters, test=names, **parts)


def day(seed, sd):
    """Return a change that is another at each gauge on each day."""
    offset = sd * np.random.default_rng([seed, 7]).standard_normal(20)
    return lambda state, load, time: offset


@pytest.mark.long
def test_tests_of_a_run_that_differ_show_by_how_much_the_campaign_may():
    days = joined([measured(1100 + k, day(k, 40.0)) for k in range(8)])
    wander = prepared(measured(5), days).difference.wander
    scale = np.sqrt(np.mean((3.0 * HEALTHY) ** 2))
    assert np.sqrt(np.median(np.diag(wander[0]))) * scale == pytest.approx(40.0, rel=0.4)
    alone = diagnose(measured(5, day(99, 40.0)), TWIN, commissioning=RUN)
    assert not alone.is_sound
    beside = diagnose(measured(5, day(99, 40.0)), TWIN, commissioning=days)
    assert beside.is_sound
    assert any("differ by more than their repeats" in note for note in beside.notes)


@pytest.mark.parametrize("n", [2, 3, 9])
def test_the_wander_of_few_tests_is_their_covariance_less_that_of_the_noise_and_widened(n):
    difference = prepared(measured(5)).difference
    gauge, none = np.repeat([0, 1], n), np.zeros(2 * n, int)
    ones = np.ones(2 * n)
    numbers = {"average": none, "gauge": gauge, "load": none, "test": np.tile(np.arange(n), 2), "state": none}
    values = {"measured": ones, "predicted": ones, "healthy": ones, "change": 0.0 * ones, "share": ones}
    rows = Rows(**numbers, **values, applied=ones[:, None], constants=np.zeros((2 * n, 0)))
    offsets, scale = np.random.default_rng(n).normal(size=(2, n)), difference.frame.scale[gauge]
    found = wander_of(difference, rows, offsets.ravel() * scale, np.diag(0.02 * scale**2))[0]
    raw = np.cov(offsets)
    sd = np.sqrt(np.diag(raw) - 0.02)
    widened = 1.0 + 1.0 / (n - 1)
    assert found[[0, 1], [0, 1]] == pytest.approx(sd**2 * widened)
    assert found[0, 1] == pytest.approx((n - 1) / n * np.corrcoef(offsets)[0, 1] * sd[0] * sd[1] * widened)
    assert np.count_nonzero(found) == 4


@pytest.mark.parametrize("level", [1.0, 16.0])
def test_the_level_of_a_kind_is_by_how_much_its_readings_differ_more_than_usual(level):
    campaign = measured(5)
    inputs = prepared(campaign, None)
    rows = linearise(inputs, states_of(campaign)).rows
    usual = inputs.difference.covariance(rows, rows)
    draws = np.random.default_rng(8).multivariate_normal(np.zeros(len(usual)), level**2 * usual, 12)
    noise = 1e-4 * np.diag(np.diag(usual))
    factors = [_with_levels(inputs.difference, rows, draw, noise).factor for draw in draws]
    assert np.exp(np.mean(np.log(factors))) == pytest.approx(level, rel=0.25)


def test_a_run_tells_how_far_sound_readings_differ_so_that_the_level_is_of_what_damage_changes_alone():
    campaign = measured(3, states=((0.3, 0.2),))
    with_run, without = prepared(campaign), prepared(campaign, None)
    rows = linearise(with_run, states_of(campaign)).rows
    sound = replace(rows, change=np.zeros_like(rows.change))
    learnt, usual = with_run.difference, without.difference
    assert np.array_equal(learnt.at(4.0).covariance(sound, sound), learnt.covariance(sound, sound))
    damage = [d.covariance(rows, rows) - d.covariance(sound, sound) for d in (learnt, learnt.at(4.0))]
    assert damage[0].any()
    assert np.allclose(damage[1], 16.0 * damage[0])
    assert np.allclose(usual.at(4.0).covariance(rows, rows), 16.0 * usual.covariance(rows, rows))


SETS = [(), (0,), (3, 40), (21,), (2, 30, 60)]


@pytest.fixture(scope="module")
def model():
    campaign = measured(3, lambda state, load, time: np.full(20, -25.0))
    return linearise(prepared(campaign), states_of(campaign))


def test_nothing_of_a_linear_model_can_be_written(model):
    with pytest.raises(FrozenInstanceError):
        model.residual = model.residual
    for array in (model.states, model.residual, model.covariance, model.signatures, model.white):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_an_answer_does_not_hang_on_what_was_asked_before(model):
    asked = Inference(model)
    asked.fits(SETS)
    asked.allowing(SETS[2])
    for members in reversed(SETS):
        fresh = Inference(model)
        one, other = asked.fit(members), fresh.fit(members)
        assert one.log_factor == pytest.approx(other.log_factor, rel=1e-9, abs=1e-9)
        assert np.allclose(one.size, other.size, rtol=1e-9)
        assert asked.identifiable(members) == fresh.identifiable(members)
        assert asked.fit(members) is one
        assert asked.allowing(members) is asked.allowing(members)


@pytest.mark.parametrize("quantities", [("deflection",), ("thermal_zero", "frequency"), ()])
def test_tests_are_proposed_for_what_shows_an_effect_whatever_its_name(quantities):
    softer = replace(TWIN.effects["modulus"], name="wet_wood", seen_by=quantities)
    hidden = {name: CHAIN[name] for name in ("load_factor_error", "common_gain")}
    campaign = measured(5, effect("modulus", 2.0))
    found = diagnose(campaign, TWIN, {**hidden, softer.name: softer}, commissioning=RUN)
    proposed = {test.name for test in found.next_test if not test.is_strain_test}
    by_quantity = {"deflection": "tip_deflection", "thermal_zero": "thermal_soak", "frequency": "frequency"}
    assert proposed == {"load_cell", "shunt_calibration", *(by_quantity[q] for q in quantities)}


def test_a_twin_is_asked_once_for_each_state_and_load():
    class Counted(Beam):
        asked = 0

        def predict(self, state, load_factor):
            self.asked += 1
            return super().predict(state, load_factor)

    counted = Counted()
    cached = CachedTwin(counted)
    first = cached.predict({"mu1": 0.2, "mu2": 0.0}, 2.0)
    assert cached.predict({"mu1": 0.2}, 2.0) is first
    assert counted.asked == 1
    assert np.array_equal(cached.predict_states(np.array([[0.2, 0.0], [0.3, 0.0]]), 2.0)[0], first)
    assert counted.asked == 2


class Loaded(Beam):
    """A twin that refuses to be without load."""

    def predict(self, state, load_factor):
        if load_factor == 0:
            raise TwinError("the load is 0")
        return super().predict(state, load_factor)


@pytest.mark.parametrize(
    ("twin", "limits", "proposed"),
    [
        (Beam(), None, {"load_0", "load_3", "load_-1"}),
        (Loaded(), None, {"load_3", "load_-1"}),
        (Beam(), (0.0, 2.5), {"load_0", "load_2.5"}),
        (Beam(), (0.5, 2.0), set()),
    ],
)
def test_no_load_beyond_the_limits_is_proposed(twin, limits, proposed):
    gain = effect("gauge_gain", 6.0, "g05")
    run = measured(1000, loads=(2.0,))
    found = diagnose(measured(21, gain, loads=(2.0,)), twin, commissioning=run, load_limits=limits)
    assert {test.name for test in found.next_test if test.is_strain_test} == proposed
    assert any("if the structure allows it" in test.words for test in found.next_test) == (limits is None)


def test_limits_of_the_load_in_the_wrong_order_are_refused():
    with pytest.raises(DataError, match="the lowest first"):
        diagnose(measured(21, loads=(2.0,)), Beam(), commissioning=RUN, load_limits=(3.5, -1.0))


@pytest.mark.parametrize("level", [0.5, 4.0])
def test_columns_are_good_for_every_level(level):
    campaign = measured(3, states=((0.4, 0.2),))  # how wrong a damage is known depends on the level
    inputs, states = prepared(campaign), states_of(campaign)
    usual, made = linearise(inputs, states), linearise(inputs, states, level)
    moved = usual.under(level)
    assert moved.log_none == pytest.approx(made.log_none, abs=1e-9)
    assert np.allclose(moved.residual, made.residual)
    assert moved.log_none != pytest.approx(linearise(inputs, states).log_none, abs=1e-3)
