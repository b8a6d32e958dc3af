"""The plain selector: right about what is clear, silent about what is sound."""

import numpy as np
import pytest

from benchmarks.plain.selector import select
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

    shared, own = sorted(map(sorted, select(measured(8, both), TWIN, RUN).causes[0].names))
    assert own == ["gauge_bias"]
    assert {"common_gain", "modulus"} <= set(shared)
