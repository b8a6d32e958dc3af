"""The plain selector: right about what is clear, silent about what is sound, and exact where the sum is known."""

import numpy as np
import pytest

from benchmarks.plain.readings import readings_of
from benchmarks.plain.selector import select
from octmip.gap import CachedTwin
from tests.test_octmip.beam_twin import Beam, measured, own_gains

TWIN = Beam()
RUN = measured(1000)


def at(gauge, value):
    return value * np.eye(20)[gauge]


CLEAR = {
    "temperature_uniform": lambda state, load, time: np.full(20, -25.0),
    "gauge_gain": lambda state, load, time: at(4, 0.04) * TWIN.predict(state, load),
    "gauge_bias": lambda state, load, time: at(4, 40.0),
    "dead_gauge": lambda state, load, time: -at(4, 1.0) * own_gains() * TWIN.predict(state, load),
}


@pytest.mark.parametrize("name", CLEAR)
def test_a_clear_effect_is_named(name):
    first = select(measured(4, CLEAR[name]), TWIN, RUN).causes[0]
    assert [effect.name for effect, _ in first.members] == [name]
    assert first.probability > 0.9


def test_a_sound_asset_is_not_accused_though_each_gauge_differs_from_the_twin():
    assert not select(measured(3), TWIN, RUN).causes[0].members


def test_a_pair_is_named_and_what_is_confounded_with_a_part_is_said():
    def both(state, load, time):
        return -0.03 * TWIN.predict(state, load) + at(9, 40.0)

    names = select(measured(8, both), TWIN, RUN).causes[0].names
    assert sorted(map(sorted, names)) == [["common_gain", "load_factor_error", "modulus"], ["gauge_bias"]]


def test_the_difference_cancels_in_cells_that_run_and_campaign_share():
    read = readings_of(measured(3), CachedTwin(TWIN), RUN)
    raw = np.array([cell.mean for cell in measured(3).cells]).T - read.predicted(read.states)
    noise = np.sqrt(2.0 / 50.0) * 31.6
    assert np.sqrt(np.mean(raw[:, 3] ** 2)) > 2.5 * noise
    assert np.sqrt(np.mean(read.residual**2)) < 1.2 * noise
