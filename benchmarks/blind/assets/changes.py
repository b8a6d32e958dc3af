"""Changes of a case's mean readings by a truth: formulae of their own, none shared with the diagnosis."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.blind.assets.asset import Asset, Flaw, State
from benchmarks.blind.truths import Truth
from femlib.arrays import FloatArray

HOUR = 3600.0
CREEP_POWER = 0.22
SUNSHINE = 1200.0
"""Half a period of the sun [s]: four loads of 50 readings."""
TRANSVERSE = 1.33
"""One and the gauge's contraction across its direction, which a turned gauge feels."""
CHORDS = ((435.61, 433.0), (261.112, 260.0))
"""Designed and manufactured chord at root and tip [mm], of the public geometry table."""
SPANS = (1828.8, 1828.0)


@dataclass(frozen=True, eq=False)
class Moment:
    """When and how the readings of one cell are taken.

    Attributes
    ----------
    state
        damage.
    load
        load factor.
    times
        (n,) of each reading since the start of the campaign [s].
    history
        (load factor, time [s]) of every change of the load until now, this cell's own last.
    """

    state: State
    load: float
    times: FloatArray
    history: tuple[tuple[float, float], ...]


Change = Callable[[Truth, Asset, Moment, FloatArray], FloatArray]
"""Change of the mean readings (n_times, n_gauges) of an asset at a moment by a truth."""


def change(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return what a truth adds to mean readings `before` (n, n_gauges)."""
    for table in (_STRUCTURE, _CHAIN):
        if truth.name in table:
            return table[truth.name](truth, asset, moment, before) + np.zeros_like(before)
    if truth.name == "outside":
        return _OUTSIDE[truth.place](truth, asset, moment, before) + np.zeros_like(before)
    return np.zeros_like(before)  # root_flexibility: a turn of the mount moves the wing as a whole


# -- structure and load ---------------------------------------------------------------------------------------------


def _field(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return truth.size * moment.load * asset.field(truth.place or truth.name, moment.state)


def _temperature(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return truth.size * asset.field(truth.name, moment.state)


def _modulus(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    return before / (1.0 + 0.01 * truth.size) - before


def _skin_thickness(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    softness = asset.softness(moment.state)
    return moment.load * asset.strain(moment.state) * (1.0 / (1.0 + 0.01 * truth.size * softness) - 1.0)


def _creep(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Boltzmann's superposition: each step of the load creeps from its own start."""
    crept = np.zeros(len(moment.times))
    last = 0.0
    for load, start in moment.history:
        crept += (load - last) * (np.maximum(moment.times - start, 0.0) / HOUR) ** CREEP_POWER
        last = load
    return 0.01 * truth.size * crept[:, None] * asset.softness(moment.state) * asset.strain(moment.state)


def _planform(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Beam theory: strain M y / (E I) goes with 1 / chord^2, the moment of one lift with the span."""
    (root, built_root), (tip, built_tip) = CHORDS
    chord = root + (tip - root) * asset.eta
    built = built_root + (built_tip - built_root) * asset.eta
    relative = (chord / built) ** 2 * (SPANS[1] / SPANS[0]) - 1.0
    return truth.size * relative * moment.load * asset.strain(moment.state)


def _large_deflection(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    first, second = asset.bending()
    relative = truth.size * (first * moment.load + second * moment.load**2)
    return np.asarray(relative * moment.load * asset.strain(moment.state))


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
    """Read the spline along the gauge's row at the place where it really is."""
    g = asset.gauges.index(truth.place)
    row = np.flatnonzero(asset.row == asset.row[g])
    line = CubicSpline(asset.eta[row], before[0, row])
    moved = line(asset.eta[g] + 1e-3 * truth.size / asset.wing.span) - before[0, g]
    return _at(asset, truth.place, np.full(len(before), moved))


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
    "misalignment": _one_gauge(lambda size, reading, times: -0.01 * TRANSVERSE * size * reading),
    "dead_gauge": _one_gauge(lambda size, reading, times: -reading),
    "position_offset": _position_offset,
    "crosstalk": _crosstalk,
    "swapped_pair": _swapped,
    "common_gain": lambda truth, asset, moment, before: 0.01 * truth.size * before,
}


# -- outside every library --------------------------------------------------------------------------------------------


def _dice(truth: Truth) -> np.random.Generator:
    return np.random.default_rng(truth.extra["seed"])


def _hot_spot(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Sun on the upper skin between two ribs."""
    return 12.0 * truth.size * asset.field(truth.extra["spot"], moment.state)


def _quadratic_gauges(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Gauges that are not straight, each in its own way."""
    signs = _dice(truth).choice([-1.0, 1.0], len(asset.gauges))
    return np.asarray(truth.size * 25.0 * (before / 2000.0) ** 2 * signs)


def _rib_field(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Ribs that hold the skin otherwise than the model's: a wave along the span."""
    return truth.size * 15.0 * moment.load / 3.0 * np.sin(24.0 * np.pi * asset.eta + _dice(truth).uniform(0, 2 * np.pi))


def _patchy_gain(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    dice = _dice(truth)
    return before * truth.size * 0.02 * dice.standard_normal(before.shape[1]) * (dice.random(before.shape[1]) < 0.6)


def _hysteresis(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Joints that stick and slip: the square root of the load, up or down at each gauge."""
    signs = _dice(truth).choice([-1.0, 1.0], len(asset.gauges))
    return np.asarray(truth.size * 15.0 * np.sqrt(np.abs(moment.load) / 3.0) * signs)


def _passing_sun(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return the strains of a sun that comes and goes on one part of the wing.

    One that only grew would look like a damage, as the loads are measured in ascending order.
    """
    course = np.sin(np.pi * moment.times[:, None] / SUNSHINE)
    return 15.0 * truth.size * course * asset.field(truth.extra["spot"], moment.state)


_OUTSIDE: Mapping[str, Change] = {
    "hot_spot": _hot_spot, "quadratic_gauges": _quadratic_gauges, "rib_field": _rib_field,
    "patchy_gain": _patchy_gain, "hysteresis": _hysteresis, "passing_sun": _passing_sun,
}  # fmt: skip
