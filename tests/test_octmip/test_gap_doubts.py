"""What a diagnosis doubts: a commissioning run, a stated state, a unit."""

from dataclasses import replace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import diagnose
from octmip.gap.odds import Odds
from tests.test_octmip.beam_twin import Beam, measured, own_effects

TWIN = Beam()
RUN = measured(1000)
HOT = lambda state, load, time: np.full(20, -25.0)  # noqa: E731


def stated_sound(campaign):
    return replace(campaign, states=np.zeros_like(campaign.states))


def some_rows(campaign, wanted):
    cells = enumerate(campaign.cells)
    return campaign.without({k for k, cell in cells if (cell.test, cell.load_factor) not in wanted})


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


def test_causes_are_sorted_and_the_unknown_is_no_exception():
    wave = lambda state, load, time: 8.0 * load * np.sin(np.arange(20.0))  # noqa: E731
    which = diagnose(measured(5, wave), TWIN, commissioning=RUN).which
    assert [c.probability for c in which] == sorted((c.probability for c in which), reverse=True)


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
