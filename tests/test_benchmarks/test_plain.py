"""The plain selector: right about what is clear, silent about what is sound."""

import numpy as np
import pytest

from benchmarks.plain.least_squares import FITS, fits_of
from benchmarks.plain.selector import select
from octmip.gap import Recorded, function_twin, gathered
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


@pytest.mark.parametrize(("asset", "names"), [(lambda k, f: f / k, ["k"]), (lambda k, f: f / k + 0.002 * f**3, None)])
def test_least_squares_name_a_parameter_and_reject_what_no_effect_explains(asset, names):
    springs = function_twin(
        lambda p, loads: [loads["f"] / p["k"], 2.0 * loads["f"] / p["k"], loads["f"]],
        {"a": "mm", "b": "mm", "c": "N"},
        {"k": (10.0, 5.0, 14.0, "N/mm")},
        ("f",),
    )
    rng = np.random.default_rng(5)

    def read(k, of):
        rows = {f: np.array([of(k, f), 2.0 * f / k, f]) + 0.01 * rng.standard_normal((20, 3)) for f in (4.0, 8.0, 12.0)}
        return gathered(springs, [Recorded(readings, {"f": f}) for f, readings in rows.items()])

    fits = fits_of(read(8.0, asset), springs, read(10.0, lambda k, f: f / k))
    if names:
        assert [effect.name for effect, _ in fits[0].members] == names
        assert fits[0].sizes[0, 1] <= -2.0 <= fits[0].sizes[0, 2]
    assert (max(fit.chance for fit in fits) > FITS) == bool(names)
