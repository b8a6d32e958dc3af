"""Which effect, how large, how sure: campaigns of a beam whose effect is known to the test and not to the diagnosis."""

from dataclasses import replace

import numpy as np
import pytest

from octmip.gap import CHAIN, Odds, diagnose
from octmip.interfaces.report.diagnosis.words import page_of_words
from tests.test_octmip.beam_twin import HEALTHY, Beam, Field, both, effect, measured

TWIN = Beam()
COMMISSIONING = measured(1000)
CONFOUNDED = {"modulus", "load_factor_error", "common_gain"}


CASES = [
    ("temperature_uniform", -8.0, ""),
    ("lift_distribution", 4.0, ""),
    ("large_deflection", 1.5, ""),
    ("gauge_bias", 40.0, "g09"),
    ("gauge_gain", 4.0, "g05"),
    ("gauge_drift", 300.0, "g03"),
    ("swapped_pair", 1.0, "g06/g07"),
    ("dead_gauge", 1.0, "g11"),
    ("modulus", 2.0, ""),
]


# Every other effect in a known state, the rest in an unknown one.
@pytest.mark.parametrize(
    ("name", "size", "place", "known"),
    [(*case, k % 2 == 0) for k, case in enumerate(CASES)],
    ids=[f"{case[0]}-{'un' * (k % 2)}known state" for k, case in enumerate(CASES)],
)
def test_a_single_effect_is_named_with_its_size(name, size, place, known):
    states = ((0.0, 0.0),) if known else ((0.2, 0.4),)
    campaign = measured(7, effect(name, size, place), states=states, known=known)
    diagnosis = diagnose(campaign, TWIN, commissioning=COMMISSIONING)
    first = diagnosis.which[0]
    assert len(first.effects) == 1, page_of_words(diagnosis)
    assert name in first.names[0], page_of_words(diagnosis)
    if first.effects == (name,):
        low, high = first.parameters[0].low, first.parameters[0].high
        assert low - (high - low) <= size <= high + (high - low)
        assert first.parameters[0].place == place


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("calibrated", [True, False])
def test_a_sound_asset_is_called_sound(seed, calibrated):
    diagnosis = diagnose(measured(seed), TWIN, commissioning=COMMISSIONING if calibrated else None)
    assert diagnosis.is_sound
    assert CONFOUNDED in [set(group) for group in diagnosis.ties]
    assert page_of_words(diagnosis).startswith("Nothing to do")


def test_three_effects_are_all_found():
    change = both(
        effect("gauge_bias", 60.0, "g09"), effect("temperature_uniform", -10.0), effect("swapped_pair", 1.0, "g02/g04")
    )
    first = diagnose(measured(3, change), TWIN, commissioning=COMMISSIONING).which[0]
    assert set(first.effects) == {"gauge_bias", "temperature_uniform", "swapped_pair"}


def three_sizes_of(odds):
    change = both(
        effect("gauge_bias", 60.0, "g09"), effect("gauge_gain", 6.0, "g05"), effect("gauge_gain", -5.0, "g02")
    )
    return diagnose(measured(3, change), TWIN, commissioning=COMMISSIONING, odds=odds)


def test_three_sizes_are_shared_with_something_unknown_that_they_may_imitate():
    first, second = three_sizes_of(Odds()).which[:2]
    assert first.effects == ("unknown",)
    assert sorted(p.place for p in second.parameters) == ["g02", "g05", "g09"]
    assert second.probability == pytest.approx(0.01 / (0.01 + 0.3 * 0.06), rel=0.02)


def test_three_sizes_are_named_where_three_faults_are_said_to_be_common():
    first = three_sizes_of(Odds(count=(0.5, 0.2, 0.1, 0.1))).which[0]
    assert sorted(p.place for p in first.parameters) == ["g02", "g05", "g09"]


def test_a_second_fault_is_no_noise_that_repeats_hardly_allow():
    change = both(effect("gauge_bias", 60.0, "g09"), effect("gauge_gain", 6.0, "g05"))
    found = diagnose(measured(5, change, repeats=8), TWIN, commissioning=measured(1000, repeats=8))
    inputs = found.posterior.judged[0].model.inputs
    assert inputs.noise_of_means.log_share == max(one.log_share for one in inputs.noises)


@pytest.mark.parametrize("name", sorted(CONFOUNDED))
def test_exactly_confounded_effects_are_named_together_and_no_strain_test_is_said_to_help(name):
    diagnosis = diagnose(measured(5, effect(name, 2.0)), TWIN, commissioning=COMMISSIONING)
    assert set(diagnosis.ambiguity[0].effects) >= CONFOUNDED
    assert diagnosis.which[0].probability > 0.7
    assert not any(test.is_strain_test for test in diagnosis.next_test)
    assert {"load_cell", "shunt_calibration"} & {test.name for test in diagnosis.next_test}


LOADS = [(0.0, 1.0, 2.0, 3.0), (1.0, 2.0), (3.0,)]
SIZES = [-12.0, -2.0, 0.7, 4.0, 20.0]


# A sixth of all combinations: the sizes with and without a run and the loads in turn.
@pytest.mark.parametrize(
    ("size", "calibrated", "loads"),
    [(size, i % 2 == 0, LOADS[i % 3]) for i, size in enumerate(SIZES)],
)
def test_exactly_confounded_effects_are_named_together_whatever_size_and_loads(size, calibrated, loads):
    campaign = measured(int(10 + abs(size)), effect("modulus", size), loads=loads)
    diagnosis = diagnose(campaign, TWIN, commissioning=COMMISSIONING if calibrated else None)
    clear = [cause for cause in diagnosis.which if cause.is_identifiable]
    assert all(names >= CONFOUNDED for cause in clear for names in cause.names if names & CONFOUNDED)
    if abs(size) >= (4.0 if calibrated else 12.0):
        assert diagnosis.which[0].effects
        assert any(set(names) >= CONFOUNDED for names in diagnosis.which[0].names)


def test_many_free_regions_and_no_baseline_are_refused_with_the_test_that_helps():
    class Patchwork(Beam):
        """A damage of its own under every gauge."""

        def predict(self, state, load_factor):
            damage = np.array([state.get(name, 0.0) for name in self.parameters])
            return load_factor * HEALTHY * (1 + damage)

    twin = Patchwork(parameters=tuple(f"mu{k + 1:02d}" for k in range(20)))
    sound = measured(4, effect("modulus", -3.0), mesh=0.0)
    unknown = np.full((len(sound.test), 20), np.nan)
    campaign = replace(sound, parameters=twin.parameters, states=unknown)
    effects = {"modulus": TWIN.effects["modulus"], "common_gain": CHAIN["common_gain"]}
    diagnosis = diagnose(campaign, twin, effects)
    assert set(diagnosis.refused) == set(effects)
    assert all("commissioning run" in reason for reason in diagnosis.refused.values())
    assert max(diagnosis.inclusion.values()) < 0.5


def test_an_unknown_state_is_estimated_beside_the_effect():
    campaign = measured(11, effect("temperature_uniform", -8.0), states=((0.35, 0.55),), known=False)
    state = diagnose(campaign, TWIN, commissioning=COMMISSIONING).states[0]
    assert abs(state.mean["mu1"] - 0.35) < 4 * state.sd["mu1"] + 0.01
    assert abs(state.mean["mu2"] - 0.55) < 4 * state.sd["mu2"] + 0.01


def test_columns_in_another_order_give_the_same_answer():
    campaign = measured(7, effect("gauge_gain", 5.0, "g05"))
    order = np.random.default_rng(0).permutation(20)
    gauges = tuple(campaign.gauges[k] for k in order)
    shuffled = replace(campaign, gauges=gauges, readings=campaign.readings[:, order])
    one, other = (diagnose(c, TWIN, commissioning=COMMISSIONING).which[0] for c in (campaign, shuffled))
    assert one.effects == other.effects
    assert one.parameters[0].place == other.parameters[0].place
    assert one.probability == pytest.approx(other.probability, abs=0.02)


@pytest.mark.parametrize("known", [True, False], ids=["known state", "unknown state"])
def test_an_effect_without_any_signature_is_refused_and_not_named(known):
    hidden = Field("root_flexibility", np.zeros(20), 1, 0.1, "rad/(kN m)", separated_by="invisible in strain")
    twin = Beam(effects={**TWIN.effects, hidden.name: hidden})
    campaign = measured(7, effect("temperature_uniform", -8.0), known=known)
    diagnosis = diagnose(campaign, twin, commissioning=COMMISSIONING)
    assert diagnosis.refused["root_flexibility"] == "has no signature in any gauge: invisible in strain"
    assert all("root_flexibility" not in names for cause in diagnosis.which for names in cause.names)


def test_an_effect_of_expected_size_keeps_its_own_course_over_the_loads():
    """Its size is expected to be 1 and its trace grows with the square of the load: no map of the readings."""
    expected = Field("large_deflection", -3 * np.linspace(0.2, 1.0, 20), 2, 0.2, "-", prior_mean=1.0)
    asset = measured(9, change=effect("large_deflection", 1.0))
    diagnosis = diagnose(asset, TWIN, {**CHAIN, **TWIN.effects, expected.name: expected}, commissioning=COMMISSIONING)
    assert diagnosis.which[0].effects == ("large_deflection",)
    assert diagnosis.which[0].parameters[0].size == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("known", [True, False], ids=["known state", "unknown state"])
def test_every_part_of_a_likely_set_is_judged_so_that_an_idle_member_can_leave(known):
    campaign = measured(7, effect("dead_gauge", 1.0, "g11"), states=((0.2, 0.4),), known=known)
    judged = diagnose(campaign, TWIN, commissioning=COMMISSIONING).posterior.judged
    sets = {h.members for h in judged if not h.has_unknown}
    for members in [h.members for h in judged if not h.has_unknown][:10]:
        assert all(members[:k] + members[k + 1 :] in sets for k in range(len(members)))
