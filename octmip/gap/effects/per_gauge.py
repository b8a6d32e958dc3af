"""Faults of one gauge as formulas: the change of its reading per unit of the effect's size.

| effect | reading of gauge g with size s |
|---|---|
| misalignment | (1 - (1 + nu) s / 100) strain, s / 100 = sin^2(angle), shear left out, nu = 0.3 |
| position_offset | strain + s d(strain)/dy, the slope from the neighbouring gauges |
| dead_gauge | (1 - s) strain with s = 1: zero and noise whatever the strain |

"Strain" is the reading, whatever it measures; angle and place are asked of strain gauges alone. Gain, offset and drift
are families (`octmip.gap.effects.families`). Where one instrument gives several readings (`octmip.twin.channels_of`),
its faults act on all of them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.twin import STRAINS, Load, State, Twin, channels_of, positions_of, units_of

POISSON = 0.3
"""Transverse contraction that a turned gauge feels."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One gauge at one state and load; the twin is asked only for what a formula needs."""

    twin: Twin
    state: State
    load_factor: Load
    gauge: int

    @property
    def strains(self) -> NDArray[np.float64]:
        """(n_gauges,) of the twin."""
        return self.twin.predict(self.state, self.load_factor)

    @property
    def strain(self) -> float:
        """Of the gauge."""
        return float(self.strains[self.gauge])


@dataclass(frozen=True, slots=True)
class PerGauge:
    """An effect on one gauge; it may act on each.

    Attributes
    ----------
    formula
        change of the gauge's reading per unit of size.
    needs_positions
        whether the twin must say where its gauges lie.
    units
        of the readings that it acts on; empty: of all.

    The others are those of `octmip.twin.Effect`.
    """

    name: str
    parameter: str
    unit: str
    prior_sd: float
    prior_source: str
    separated_by: str
    formula: Callable[[Moment], float]
    prior_mean: float = 0.0
    is_one_sided: bool = False
    load_power: int | None = None
    acts_on_readings: bool = False
    needs_positions: bool = False
    units: tuple[str, ...] = ()
    seen_by: tuple[str, ...] = ()
    words: str = ""
    words_at: str = ""
    action: str = ""
    says: tuple[str, str] = ("", "")

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the gauges, or their instruments; none where positions are needed and the twin does not say them."""
        if self.needs_positions and positions_of(twin) is None:
            return ()
        found = zip(channels_of(twin), units_of(twin), strict=True)
        return tuple(dict.fromkeys(channel for channel, unit in found if not self.units or unit in self.units))

    def gauges_of(self, twin: Twin, place: str) -> tuple[str, ...]:
        """Return the gauges of a place."""
        return tuple(name for name, own in zip(twin.gauges, channels_of(twin), strict=True) if own == place)

    def signature(
        self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size."""
        change = np.zeros(len(twin.gauges))
        for gauge in (k for k, own in enumerate(channels_of(twin)) if own == place):
            change[gauge] = self.formula(Moment(twin, state, load_factor, gauge))
        return change


def _misalignment(moment: Moment) -> float:
    return -0.01 * (1.0 + POISSON) * moment.strain


def _offset(moment: Moment) -> float:
    positions, units = positions_of(moment.twin), units_of(moment.twin)
    if positions is None:
        raise TwinError(
            "the twin does not say where its gauges lie, so a gauge that lies elsewhere has no signature; expected "
            "gauge_positions (n_gauges, 2) [m]; give them"
        )
    same = [k for k, unit in enumerate(units) if unit == units[moment.gauge]]
    return 1e-3 * spanwise_slope(positions[same], moment.strains[same], same.index(moment.gauge))


def _dead(moment: Moment) -> float:
    return -moment.strain


def spanwise_slope(positions: NDArray[np.float64], strain: NDArray[np.float64], gauge: int) -> float:
    """Return d(strain)/dy [1/m] at one gauge: the best plane through it and its four nearest neighbours."""
    near = np.argsort(np.linalg.norm(positions - positions[gauge], axis=1), kind="stable")[1:5]
    offset = (positions[near] - positions[gauge])[:, :2]
    weight = 1.0 / np.linalg.norm(offset, axis=1)
    slope = np.linalg.lstsq(offset * weight[:, None], (strain[near] - strain[gauge]) * weight, rcond=None)[0]
    return float(slope[1])


MISALIGNMENT = PerGauge(
    name="misalignment",
    parameter="sin^2 of the angle by which one gauge is turned (1 % is 5.7 degrees)",
    unit="%",
    prior_sd=1.0,
    prior_source="gauges are laid to a few degrees; transverse sensitivity is of the same order",
    separated_by="it only lowers a reading, a gain goes both ways; a shunt calibration sees a gain and not an angle",
    formula=_misalignment,
    is_one_sided=True,
    units=STRAINS,
    seen_by=("gauge_placement",),
    words="angle of one gauge",
    words_at="angle of gauge {place}",
    action="check the angle of gauge {place}",
    says=("the squared sine of its error is {size}", "the squared sine of its error is {size}"),
)
"""The gauge is turned against its direction and feels the transverse contraction."""

POSITION_OFFSET = PerGauge(
    name="position_offset",
    parameter="offset of one gauge outboard",
    unit="mm",
    prior_sd=3.0,
    prior_source="gauges are placed to some millimetres",
    separated_by="in one state it equals a gain of the gauge; measuring its place on the structure separates them",
    formula=_offset,
    needs_positions=True,
    units=STRAINS,
    seen_by=("gauge_placement",),
    words="place of one gauge",
    words_at="place of gauge {place}",
    action="measure the place of gauge {place}",
    says=("it sits {size} too far outboard", "it sits {size} too far inboard"),
)
"""The gauge sits beside its place along the span and reads the strain there."""

DEAD_GAUGE = PerGauge(
    name="dead_gauge",
    parameter="part of the signal that one gauge has lost",
    unit="-",
    prior_mean=1.0,
    prior_sd=0.02,
    prior_source="a broken lead leaves nothing",
    separated_by="the reading does not move with the load",
    formula=_dead,
    is_one_sided=True,
    acts_on_readings=True,
    seen_by=("shunt_reading", "channel_order"),
    words="dead gauge",
    words_at="dead gauge {place}",
    action="repair gauge {place}",
    says=("it shows nothing of the strain", "it shows nothing of the strain"),
)
"""A broken lead: nothing but zero and noise."""
