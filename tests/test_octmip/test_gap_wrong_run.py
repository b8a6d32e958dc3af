"""A wrong commissioning run is doubted where it accuses a sound asset; a right one beside a real effect is not."""

from dataclasses import replace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import diagnose
from octmip.gap.inference import wrong_run
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import linearise
from octmip.gap.inference.posterior import OF_MODELS, STATED, levels_without_run
from octmip.gap.inference.wrong_run import WrongRun, corrected
from octmip.gap.odds import Differences, Odds
from tests.test_octmip.beam_twin import Beam, measured

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
    assert wrong_run.weigh_wrong_run(model).log_weight == pytest.approx(np.log(prior) - 7.0)


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
