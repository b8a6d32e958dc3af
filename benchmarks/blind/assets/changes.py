"""Changes of a case's mean readings by a truth: formulae of their own, none shared with the diagnosis."""

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.blind.assets.asset import HOUR, Asset, Flaw
from benchmarks.blind.assets.moment import Moment
from benchmarks.blind.assets.outside import OUTSIDE, Change
from benchmarks.blind.truths import Truth
from femlib.arrays import FloatArray


def change(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return what a truth adds to mean readings `before` (n, n_gauges)."""
    for table in (_STRUCTURE, _CHAIN):
        if truth.name in table:
            return table[truth.name](truth, asset, moment, before) + np.zeros_like(before)
    if truth.name == "outside":
        return OUTSIDE[truth.place](truth, asset, moment, before) + np.zeros_like(before)
    return np.zeros_like(before)  # root_flexibility: a turn of the mount moves the wing as a whole


# -- structure and load ---------------------------------------------------------------------------------------------


def _field(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return truth.size * moment.load * asset.field(truth.place or truth.name, moment.state)


def _temperature(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return truth.size * asset.field(truth.name, moment.state)


def _modulus(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return before / (1.0 + 0.01 * truth.size) - before


def _skin_thickness(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    ratio = asset.stiffer(0.01 * truth.size, moment.state)
    return moment.load * asset.strain(moment.state) * (ratio - 1.0)


def _creep(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    crept = asset.crept(moment.times, moment.history)
    return 0.01 * truth.size * crept[:, None] * asset.softness(moment.state) * asset.strain(moment.state)


def _planform(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return truth.size * asset.built() * moment.load * asset.strain(moment.state)


def _large_deflection(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return truth.size * asset.bent(moment.load) * moment.load * asset.strain(moment.state)


def _flaw(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """As in the healthy wing: what a foreign flaw and the known damage do to each other is left out."""
    return moment.load * asset.flaw(Flaw(truth.name, truth.place, truth.size))


def _load_factor(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return 0.01 * truth.size * moment.load * asset.strain(moment.state)


_STRUCTURE: Mapping[str, Change] = {
    "modulus": _modulus, "skin_thickness": _skin_thickness, "temperature_uniform": _temperature,
    "temperature_gradient": _temperature, "lift_distribution": _field, "torsion": _field, "payload_inertia": _field,
    "large_deflection": _large_deflection, "creep": _creep, "planform": _planform, "damage_outside_library": _flaw,
    "spar_skin_debond": _flaw, "load_factor_error": _load_factor,
}  # fmt: skip


# -- measuring chain ------------------------------------------------------------------------------------------------


def _at(asset: Asset, gauge: str, values: FloatArray) -> FloatArray:
    column = np.zeros((len(values), len(asset.gauges)))
    column[:, asset.gauges.index(gauge)] = values
    return column


def _one_gauge(of_reading: Callable[[float, FloatArray, FloatArray], FloatArray]) -> Change:
    def apply(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
        g = asset.gauges.index(truth.place)
        return _at(asset, truth.place, of_reading(truth.size, before[:, g], moment.times))

    return apply


def _position_offset(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    g = asset.gauges.index(truth.place)
    moved = asset.slid(g, truth.size, moment, before[0])
    return _at(asset, truth.place, np.full(len(before), moved))


def _misalignment(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    g = asset.gauges.index(truth.place)
    return _at(asset, truth.place, -0.01 * asset.turned(g) * truth.size * before[:, g])


def _crosstalk(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    reader, source = truth.place.split("<")
    return _at(asset, reader, 0.01 * truth.size * before[:, asset.gauges.index(source)])


def _swapped(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    first, second = truth.place.split("/")
    gap = before[:, asset.gauges.index(second)] - before[:, asset.gauges.index(first)]
    return _at(asset, first, gap) - _at(asset, second, gap)


_CHAIN: Mapping[str, Change] = {
    "gauge_gain": _one_gauge(lambda size, reading, times: 0.01 * size * reading),
    "gauge_bias": _one_gauge(lambda size, reading, times: np.full_like(reading, size)),
    "gauge_drift": _one_gauge(lambda size, reading, times: size * times / HOUR),
    "misalignment": _misalignment,
    "dead_gauge": _one_gauge(lambda size, reading, times: -reading),
    "position_offset": _position_offset,
    "crosstalk": _crosstalk,
    "swapped_pair": _swapped,
    "common_gain": lambda truth, asset, moment, before: 0.01 * truth.size * before,
}
