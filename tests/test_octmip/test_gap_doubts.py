"""What a diagnosis doubts: a commissioning run, a stated state, a unit."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from octmip.errors import DataError
from octmip.gap import diagnose
from octmip.gap.inference import wrong_run
from octmip.gap.inference.candidates import SCALES
from octmip.gap.inference.inputs import OF_MODELS, STATED, levels_without_run, prepare
from octmip.gap.inference.linear_model import linearise
from octmip.gap.inference.wrong_run import NODE_SPREAD
from octmip.gap.odds import Differences, Odds
from tests.test_octmip.beam_twin import Beam, measured, own_effects

TWIN = Beam()
RUN = measured(1000)
HOT = lambda state, load, time: np.full(20, -25.0)  # noqa: E731


def stated_sound(campaign):
    return replace(campaign, states=np.zeros_like(campaign.states))


def stiffer(share):
    return lambda state, load, time: share * TWIN.predict(state, load)


def crossed(campaign, one, other):
    readings = np.array(campaign.readings)
    readings[:, [one, other]] = readings[:, [other, one]]
    return replace(campaign, readings=readings)


@pytest.mark.long("damaged", "warm")
@pytest.mark.parametrize(
    ("run", "words"),
    [
        (stated_sound(measured(1001, states=((0.3, 0.0),))), "those of the state mu1 0.3"),
        (measured(1002, HOT), "temperature uniform, 10.5 K, acted while it was taken"),
        (measured(31000, stiffer(0.05)), "modulus, -5 %, acted while it was taken"),
        (crossed(measured(31001), 0, 15), "exchanged wires of gauges g01 and g16"),
    ],
    ids=["damaged", "warm", "another load cell", "crossed wires"],
)
def test_a_wrong_commissioning_run_is_doubted_and_accuses_no_sound_asset(run, words):
    """Before: with another load cell the sound asset was accused of a modulus in 12 of 12 draws."""
    diagnosis = diagnose(measured(21000), TWIN, commissioning=run)
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
    assert not diagnose(campaign, TWIN, commissioning=RUN, odds=Odds(count=(0.9,))).which[0].parameters
    with pytest.raises(DataError, match="lacks"):
        diagnose(campaign, TWIN, odds=Odds(effects={"no_such_effect": 2.0}))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"count": (0.5, 0.2, 0.1, 0.05, 0.01)}, "count have 5 entries; expected 1 to 4: of no, one, two and three"),
        ({"count": ()}, "count have 0 entries; expected 1 to 4"),
        ({"count": (0.8, 0.4)}, "sum is at most 1"),
        ({"wrong_run": -0.1}, "wrong_run"),
        ({"count": (0.0, 0.5)}, "above 0 that no effect acts; raise the first"),
        ({"unknown": (0.03, 0.01)}, "unknown have 2 entries; expected 3: alone, beside one effect and beside two"),
        ({"unknown": (0.03, 0.01, 0.002, 0.001)}, "unknown have 4 entries; expected 3"),
        ({"effects": {"gain": -1.0}}, "effect gain are -1.0; expected a factor of 0 or more; .* 0 leaves it out"),
    ],
)
def test_odds_that_no_search_can_use_are_refused(given, told):
    with pytest.raises(DataError, match=told):
        Odds(**given)


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


def test_a_run_is_trusted_by_odds_or_left_out_as_told():
    campaign, run = measured(21000), measured(31000, stiffer(0.05))
    trusted = diagnose(campaign, TWIN, commissioning=run, trust_run=True)
    assert not trusted.doubts
    assert any("modulus" in part for part in trusted.which[0].names)
    assert not diagnose(campaign, TWIN, commissioning=run, odds=Odds(wrong_run=1e-6)).doubts
    left = diagnose(campaign, TWIN, commissioning=run, trust_run=False)
    assert left.is_sound
    assert "left out, as it is not to be trusted" in left.notes[0]


def density(rest, covariance, column=0.0, mean=0.0, sds=(1.0,)):
    """Return the log density of rows with a column of a size ~ N(mean, sd^2), the mean over sds, and its size."""
    column = column * np.ones(len(rest))
    of_sd = [multivariate_normal(mean * column, covariance + sd**2 * np.outer(column, column)) for sd in sds]
    solved, precision = np.linalg.solve(covariance, column), max(sds) ** -2.0
    length = column @ solved + precision
    size = (solved @ rest + precision * mean) / length, length**-0.5
    return float(logsumexp([own.logpdf(rest) for own in of_sd])) - np.log(len(sds)), *size


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (measured(1000, stiffer(0.03)), "modulus, {:.3g} %, acted while it was taken"),
        (stated_sound(measured(1000, states=((0.1, 0.3),))), "its readings are those of the state mu1 0.10, mu2 0.31"),
    ],
    ids=["effect", "state"],
)
def test_what_was_wrong_with_a_run_weighs_what_its_definition_says(wrong, words, monkeypatch):
    """Run and campaign with an effect or a state in the run alone, or each alone where it is of another asset."""
    monkeypatch.setattr(wrong_run, "grid", lambda n: np.array([[0.0, 0.0], [0.05, 0.0], [0.1, 0.3], [1.5, 0.0]]))
    twin = Beam(effects={name: own_effects()[name] for name in ("modulus", "temperature_uniform")})
    inputs = prepare(measured(2), twin, twin.effects, wrong)[0]
    model, run, usual = linearise(inputs, np.zeros((4, 2))), inputs.run, inputs.usual
    rows, noises, n = (run.rows, model.rows), (run.noise, model.noise), len(run.rows.residual)
    rest = np.append(run.rows.residual, model.rows.measured - model.rows.predicted)

    def of_run(change):
        loads = [run.averages[k].load for k in run.rows.average]
        shown = [change(load)[k] for load, k in zip(loads, run.rows.gauge, strict=True)]
        return np.append(shown, np.zeros(model.n))

    logs, usually, sizes = {}, [], {}
    for k, difference in enumerate((inputs.difference, usual.at(1.0), usual.at(2.0))):
        blocks = [[difference.covariance(a, b) + (a is b) * noises[a is rows[1]] for b in rows] for a in rows]
        both = np.block(blocks)
        usually.append(density(rest, both, 0.0)[0])
        for effect in twin.effects.values():
            column = of_run(partial(effect.signature, twin, {}))
            log, *sizes[k, effect.name] = density(rest, both, column, 0.0, [s * effect.prior_sd for s in SCALES])
            logs[k, effect.name] = log + np.log(0.5 / 3 / 2)
        for node in ((0.05, 0.0), (0.1, 0.3)):
            damaged = dict(zip(twin.parameters, node, strict=True))
            column = of_run(lambda load, state=damaged: twin.predict(state, load) - twin.predict({}, load))
            log, *sizes[k, node] = density(rest, both, column, 1.0, [NODE_SPREAD])
            logs[k, node] = log + np.log(0.25 / 3 / 2)
    apart = [
        logsumexp([density(left, usual.at(level).covariance(own, own) + noise)[0] + np.log(p) for level, p in levels])
        for left, own, noise, levels in zip(
            (rest[:n], rest[n:]), rows, noises, ([(4.0, 0.5), (8.0, 0.5)], OF_MODELS.items()), strict=True
        )
    ]
    logs["asset"] = sum(apart) + np.log(0.25)
    found = wrong_run.weigh_wrong_run(model)
    prior = np.log(inputs.odds.wrong_run * inputs.odds.count[0])
    assert model.log_none == pytest.approx(usually[0], rel=1e-6)
    assert found.log_weight == pytest.approx(prior + logsumexp(list(logs.values())), abs=1e-6)
    assert found.log_usual == pytest.approx(max(0.0, logsumexp(usually) - np.log(3.0) - usually[0]), abs=1e-3)
    best = max(logs, key=logs.__getitem__)
    assert found.words == words.format(sizes[best][0])


def test_a_run_is_left_out_for_what_it_differs_by_and_not_for_what_is_called_usual():
    """Before: where little was called usual, a run that differs by 2 % was left out, and clear effects with it."""
    usual = Differences(common=0.003, smooth=0.003, own=0.003)
    warm = measured(21003, lambda state, load, time: np.full(20, 30.0), mesh=0.02)
    diagnosis = diagnose(warm, TWIN, commissioning=measured(31004, mesh=0.02), odds=Odds(differences=usual))
    assert not diagnosis.doubts
    assert "temperature_uniform" in diagnosis.which[0].effects
    with pytest.raises(DataError, match=r"differences own is -0\.1; expected a number above 0"):
        Differences(own=-0.1)


def test_without_a_run_models_differ_as_wings_do_unless_more_is_known():
    stiff = measured(21000, stiffer(0.06))
    inputs, _ = prepare(stiff, TWIN, TWIN.effects)
    known = Odds(differences=Differences(common=0.002))
    assert levels_without_run(inputs) == OF_MODELS
    assert levels_without_run(replace(inputs, odds=known)) == STATED
    assert diagnose(stiff, TWIN).is_sound
    assert not diagnose(stiff, TWIN, odds=known).is_sound
