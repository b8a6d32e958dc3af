"""What a diagnosis doubts: a commissioning run, a stated state, a unit."""

from dataclasses import replace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import diagnose
from octmip.gap.inference import wrong_run
from octmip.gap.inference.inputs import OF_MODELS, STATED, levels_without_run, prepare
from octmip.gap.inference.linear_model import linearise
from octmip.gap.inference.wrong_run import WrongRun, corrected
from octmip.gap.odds import Differences, Odds
from tests.test_octmip.beam_twin import Beam, measured, own_effects

TWIN = Beam()
RUN = measured(1000)
HOT = lambda state, load, time: np.full(20, -25.0)  # noqa: E731


def stated_sound(campaign):
    return replace(campaign, states=np.zeros_like(campaign.states))


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (stated_sound(measured(1001, states=((0.3, 0.0),))), "those of the state mu1 0.3"),
        (measured(1002, HOT), "temperature uniform, 10.3 K, acted while it was taken"),
    ],
    ids=["damaged", "warm"],
)
def test_a_wrong_commissioning_run_is_doubted_and_accuses_no_sound_asset(run, words):
    diagnosis = diagnose(measured(2), TWIN, commissioning=run)
    assert diagnosis.is_sound
    assert words in diagnosis.doubts[0]
    assert diagnosis.notes[0] == diagnosis.doubts[0]


def test_a_run_of_an_asset_that_is_all_five_per_cent_softer_is_no_wrong_run():
    softer = lambda state, load, time: -0.05 * TWIN.predict(state, load)  # noqa: E731
    diagnosis = diagnose(measured(2, softer), TWIN, commissioning=measured(1003, softer))
    assert diagnosis.is_sound
    assert not diagnosis.doubts


def more_of_the_damage(gauge, share):
    """Return a change: one gauge shows more of what damage changes than the twin says."""
    here = np.arange(20) == gauge

    def change(state, load, time):
        return share * here * (TWIN.predict(state, load) - TWIN.predict({}, load))

    return change


def test_a_gauge_at_which_damage_acts_by_a_third_more_is_not_accused():
    campaign = measured(13, more_of_the_damage(4, 0.3), states=((0.3, 0.2),), known=False)
    diagnosis = diagnose(campaign, TWIN, commissioning=RUN)
    assert diagnosis.is_sound
    assert max(diagnosis.inclusion[name] for name in ("gauge_gain", "gauge_bias", "crosstalk")) < 0.4


def test_a_gain_that_acts_in_the_sound_state_too_is_still_named():
    gain = lambda state, load, time: 0.04 * (np.arange(20) == 4) * TWIN.predict(state, load)  # noqa: E731
    campaign = measured(12, gain, states=((0.0, 0.0), (0.3, 0.2)))
    assert diagnose(campaign, TWIN, commissioning=RUN).which[0].effects == ("gauge_gain",)


class Rescaled(Beam):
    """The beam with every second reading in a unit a thousandth as large; it says nothing of units."""

    factor = np.where(np.arange(20) % 2, 1000.0, 1.0)

    def predict(self, state, load_factor):
        return self.factor * super().predict(state, load_factor)


def test_units_change_nothing():
    campaign = measured(3, HOT)
    kinds = {name: own_effects()[name] for name in ("modulus", "lift_distribution")}  # proportional to the readings
    plain = diagnose(campaign, TWIN, kinds)
    factor = Rescaled.factor
    other = diagnose(replace(campaign, readings=factor * campaign.readings), Rescaled(), kinds)
    assert [c.effects for c in other.which] == [c.effects for c in plain.which]
    assert other.unknown_probability == pytest.approx(plain.unknown_probability, abs=1e-3)
    assert other.where.p_value == pytest.approx(plain.where.p_value, rel=1e-3)


def test_that_nothing_acts_is_less_sure_than_that_nothing_is_seen():
    diagnosis = diagnose(measured(1), TWIN)
    assert diagnosis.is_sound
    assert diagnosis.nothing_acts < diagnosis.which[0].probability


def test_odds_change_what_is_expected():
    campaign = measured(3, HOT)
    named = diagnose(campaign, TWIN, commissioning=RUN, odds=Odds(effects={"temperature_uniform": 0.0}))
    assert "temperature_uniform" not in named.inclusion
    with pytest.raises(DataError, match="lacks"):
        diagnose(campaign, TWIN, odds=Odds(effects={"no_such_effect": 2.0}))
    with pytest.raises(DataError, match="sum is at most 1"):
        Odds(count=(0.8, 0.4))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"count": (0.5, 0.2, 0.1, 0.05, 0.01)}, "count have 5 entries; expected 1 to 4: of no, one, two and three"),
        ({"count": ()}, "count have 0 entries; expected 1 to 4"),
        ({"count": (0.0, 0.5)}, "above 0 that no effect acts; raise the first"),
        ({"unknown": (0.03, 0.01)}, "unknown have 2 entries; expected 3: alone, beside one effect and beside two"),
        ({"unknown": (0.03, 0.01, 0.002, 0.001)}, "unknown have 4 entries; expected 3"),
        ({"effects": {"gain": -1.0}}, "effect gain are -1.0; expected a factor of 0 or more; .* 0 leaves it out"),
    ],
)
def test_odds_that_no_search_can_use_are_refused(given, told):
    with pytest.raises(DataError, match=told):
        Odds(**given)


def test_the_fewest_odds_of_a_count_are_used():
    assert not diagnose(measured(3, HOT), TWIN, commissioning=RUN, odds=Odds(count=(0.9,))).which[0].parameters


# A wrong commissioning run is doubted where it accuses a sound asset; a right one beside a real effect is not


TWIN = Beam()


def stiffer(share):
    return lambda state, load, time: share * TWIN.predict(state, load)


def crossed(campaign, one, other):
    readings = np.array(campaign.readings)
    readings[:, [one, other]] = readings[:, [other, one]]
    return replace(campaign, readings=readings)


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (measured(31000, stiffer(0.05)), "modulus, -5 %, acted while it was taken"),
        (crossed(measured(31001), 0, 15), "exchanged wires of gauges g01 and g16"),
    ],
    ids=["another load cell", "crossed wires"],
)
def test_a_run_of_a_wrong_load_cell_or_of_crossed_wires_is_doubted(run, words):
    """Before: with another load cell the sound asset was accused of a modulus in 12 of 12 draws."""
    diagnosis = diagnose(measured(21000), TWIN, commissioning=run)
    assert diagnosis.is_sound
    assert words in diagnosis.doubts[0]


def test_a_run_is_doubted_beside_a_channel_that_is_left_out():
    """Before: the run had a gauge more than the campaign, and an IndexError ended the diagnosis."""
    campaign = measured(21000)
    readings = np.array(campaign.readings)
    readings[:, 2] = 0.0
    diagnosis = diagnose(replace(campaign, readings=readings), TWIN, commissioning=measured(31000, stiffer(0.05)))
    assert diagnosis.noise.stuck == ("g03",)
    assert "modulus, -5 %, acted while it was taken" in diagnosis.doubts[0]


def test_a_run_that_may_be_wrong_is_mentioned():
    diagnosis = diagnose(measured(21001), TWIN, commissioning=measured(31002, stiffer(0.03)))
    assert not diagnosis.doubts
    assert any("commissioning run may have been wrong" in note for note in diagnosis.notes)


def test_an_asset_that_has_become_softer_has_a_right_run():
    diagnosis = diagnose(measured(21002, stiffer(-0.05)), TWIN, commissioning=measured(31003))
    assert not diagnosis.doubts
    assert any("modulus" in part for part in diagnosis.which[0].names)


def test_a_run_is_trusted_or_left_out_as_told():
    campaign, run = measured(21000), measured(31000, stiffer(0.05))
    trusted = diagnose(campaign, TWIN, commissioning=run, trust_run=True)
    assert not trusted.doubts
    assert any("modulus" in part for part in trusted.which[0].names)
    left = diagnose(campaign, TWIN, commissioning=run, trust_run=False)
    assert left.is_sound
    assert "left out, as it is not to be trusted" in left.notes[0]


def test_what_may_have_been_wrong_shares_one_probability(monkeypatch):
    campaign = measured(21000)
    inputs = prepare(campaign, TWIN, dict(TWIN.effects), measured(31000))[0]
    model = linearise(inputs, np.array([cell.state for cell in campaign.cells]))
    for kind in ("_by_effect", "_by_state", "_by_asset"):
        monkeypatch.setattr(wrong_run, kind, lambda *_: WrongRun(-7.0, "", None, None, None))
    prior = inputs.odds.wrong_run * inputs.odds.count[0]
    assert wrong_run.weigh_wrong_run(model, inputs.twin).log_weight == pytest.approx(np.log(prior) - 7.0)


def test_the_odds_of_a_wrong_run_are_an_argument():
    run = measured(31000, stiffer(0.05))
    assert not diagnose(measured(21000), TWIN, commissioning=run, odds=Odds(wrong_run=1e-6)).doubts
    with pytest.raises(DataError, match="wrong_run"):
        Odds(wrong_run=-0.1)


def test_a_run_is_left_out_for_what_it_differs_by_and_not_for_what_is_called_usual():
    """Before: where little was called usual, a run that differs by 2 % was left out, and clear effects with it."""
    usual = Differences(common=0.003, smooth=0.003, own=0.003)
    warm = measured(21003, lambda state, load, time: np.full(20, 30.0), mesh=0.02)
    diagnosis = diagnose(warm, TWIN, commissioning=measured(31004, mesh=0.02), odds=Odds(differences=usual))
    assert not diagnosis.doubts
    assert "temperature_uniform" in diagnosis.which[0].effects
    with pytest.raises(DataError, match=r"differences own is -0\.1; expected a number above 0"):
        Differences(own=-0.1)


def test_what_is_taken_off_a_run_is_known_gauge_by_gauge_no_better_than_a_change_by_damage():
    inputs, _ = prepare(measured(21000), TWIN, TWIN.effects, measured(31000))
    n = len(inputs.run.residual)
    correction = np.linspace(1.0, 2.0, n)
    left = corrected(inputs, WrongRun(0.0, "", correction, 0.1 * correction, 0.2 * correction)).run
    added = left.noises[0].covariance - inputs.run.noises[0].covariance
    same = inputs.run.means.gauge[:, None] == inputs.run.means.gauge
    assert added == pytest.approx((0.01 + 0.04 * same) * np.outer(correction, correction), abs=1e-9)


def test_without_a_run_models_differ_as_wings_do_unless_more_is_known():
    stiff = measured(21000, stiffer(0.06))
    inputs, _ = prepare(stiff, TWIN, TWIN.effects)
    known = Odds(differences=Differences(common=0.002))
    assert levels_without_run(inputs) == OF_MODELS
    assert levels_without_run(replace(inputs, odds=known)) == STATED
    assert diagnose(stiff, TWIN).is_sound
    assert not diagnose(stiff, TWIN, odds=known).is_sound
