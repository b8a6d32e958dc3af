"""The plain selector: right about what is clear, silent about what is sound."""

import pytest

from benchmarks.plain.selector import select
from tests.test_octmip.beam_twin import Beam, both, effect, measured

TWIN = Beam()
RUN = measured(1000)


CLEAR = {"temperature_uniform": effect("temperature_uniform", 10.0), "gauge_gain": effect("gauge_gain", 4.0, "g05")}


@pytest.mark.long("temperature_uniform")
@pytest.mark.parametrize("name", CLEAR)
def test_a_clear_effect_is_named(name):
    first = select(measured(4, CLEAR[name]), TWIN, RUN).causes[0]
    assert [one.name for one, _ in first.members] == [name]
    assert first.probability > 0.9


@pytest.mark.long
def test_a_sound_asset_is_not_accused_though_each_gauge_differs_from_the_twin():
    assert not select(measured(3), TWIN, RUN).causes[0].members


@pytest.mark.long
def test_a_pair_is_named_and_what_is_confounded_with_a_part_is_said():
    pair = both(effect("modulus", 3.0), effect("gauge_bias", 40.0, "g10"))
    shared, own = sorted(map(sorted, select(measured(8, pair), TWIN, RUN).causes[0].names))
    assert own == ["gauge_bias"]
    assert {"common_gain", "modulus"} <= set(shared)
