"""Strain gauges of the wing: 24 installed and 58 candidates, all spanwise on the top skin.

Their places were not published; they are deduced from the published strains (two rows, one pitch, a gap at mid-span)
and fitted.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.errors import frozen_floats
from femlib.geometry import Naca4, Planform
from femlib.sensors import StrainGauge
from femlib.wing.damage import DamageRegion

SPANWISE = np.array([0.0, 1.0, 0.0])
SNAPPED, SNAPPED_ETA = 30, 0.237  # c31
N_INSTALLED = 24


@dataclass(frozen=True, slots=True, eq=False)
class GaugeSet:
    """Names and places of gauges.

    Attributes
    ----------
    names : tuple of str
        Names (n,).
    eta, chord_fraction : FloatArray
        Span and chord fractions (n,).
    position : FloatArray
        Points (n, 3) on the top skin: x aft of the spar, y outboard, z up [m].
    regions : tuple of str
        Name of the damage region that holds each gauge, "" if none does (n,).
    left_out : tuple of str
        Gauges that the study leaves out although no region holds them.
    """

    names: tuple[str, ...]
    eta: FloatArray
    chord_fraction: FloatArray
    position: FloatArray
    regions: tuple[str, ...]
    left_out: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.names)
        for name, shape in (("eta", (n,)), ("chord_fraction", (n,)), ("position", (n, 3))):
            object.__setattr__(self, name, frozen_floats(getattr(self, name), f"gauge {name}", shape))

    @property
    def is_usable(self) -> BoolArray:
        """Whether each gauge lies outside every damage region and is not left out (n,)."""
        rows = zip(self.names, self.regions, strict=True)
        return np.array([region == "" and name not in self.left_out for name, region in rows])

    @property
    def places(self) -> FloatArray:
        """Span and chord fractions (n, 2)."""
        return np.stack([self.eta, self.chord_fraction], axis=1)

    def distances(self, region: DamageRegion, planform: Planform) -> FloatArray:
        """Return the distance of each gauge from a damage region in the plane of the wing [m], 0 inside (n,)."""
        along = _outside(self.eta, region.eta_min, region.eta_max) * planform.span
        across = _outside(self.chord_fraction, region.chord_min, region.chord_max) * planform.chord(self.eta)
        return np.hypot(along, across)

    def strain_gauges(self, patches: tuple[str, ...], side: float) -> list[StrainGauge]:
        """Return the gauges for `patches` of the top skin; those in a region look in the region's patch alone.

        `side` is the height at which a gauge reads over half the skin's thickness.
        """
        return [
            StrainGauge(name, point, SPANWISE, (region,) if region else patches, side)
            for name, point, region in zip(self.names, self.position, self.regions, strict=True)
        ]


def _outside(values: FloatArray, low: float, high: float) -> FloatArray:
    return np.maximum(np.maximum(low - values, values - high), 0.0)


def installed_places() -> FloatArray:
    """Return (24, 2) span and chord fractions of g01 to g24, fitted: a front row with 16, a rear row with 8, one pitch.

    The fit puts the rear row at eta 0.2983 +- 0.0018, where g18 stands 0.0007 inside region 1 and answers 3,016
    microstrain to mu1 = 80 %. The table has 37 there, so the row begins at 0.3, 0.001 outboard of the region's edge.
    """
    return pitched_places((0.28979, 0.59215), (0.3, 0.59937), 0.017157, (0.22163, 0.34586))


def tapered_places() -> FloatArray:
    """Return (24, 2) span and chord fractions of g01 to g24 on `tapered_wing`, fitted."""
    row_a = np.concatenate([np.linspace(0.26, 0.47, 8), np.linspace(0.57, 0.755, 8)])
    row_b = np.concatenate([np.linspace(0.26, 0.47, 4), np.linspace(0.57, 0.755, 4)])
    eta = np.concatenate([row_a, row_b])
    return np.stack([eta, np.repeat([0.21, 0.35], [16, 8])], axis=1)


def pitched_places(
    front: tuple[float, float], rear: tuple[float, float], pitch: float, chord: tuple[float, float]
) -> FloatArray:
    """Return (24, 2) span and chord fractions of g01 to g24 where each row has one pitch.

    Parameters
    ----------
    front, rear : (float, float)
        Span fractions at which the halves of the front row (8 gauges each) and of the rear row (4 each) begin.
    pitch : float
        Distance of the front row's gauges in span fractions; the rear row's is twice that.
    chord : (float, float)
        Chord fractions of the rows.
    """
    halves = [start + pitch * np.arange(8) for start in front] + [start + 2.0 * pitch * np.arange(4) for start in rear]
    return np.stack([np.concatenate(halves), np.repeat(chord, [16, 8])], axis=1)


def candidate_places() -> FloatArray:
    """Return (58, 2) span and chord fractions of c01 to c58, assumed: rows with 15, 15, 14 and 14 gauges.

    Eleven lie inside a damage region, none nearer than 6 mm to its edges along the span, so that 67 of the 82 gauges
    are usable, as in the paper.
    """
    rows = ((0.12, 15, 0.20, 0.80), (0.42, 15, 0.20, 0.80), (0.47, 14, 0.19, 0.79), (0.53, 14, 0.20, 0.79))
    return np.concatenate([np.stack([np.linspace(low, high, n), np.full(n, x)], axis=1) for x, n, low, high in rows])


def tapered_candidates() -> FloatArray:
    """Return (58, 2) span and chord fractions of c01 to c58 on `tapered_wing`: rows with 15, 14, 15 and 14 gauges.

    c31 would straddle the inboard edge of region 1 (2.9 thousandths of the span inside it); it sits as far outside it
    instead, so that 67 of the 82 gauges are usable, as in the paper. c41 straddles region 2 in the same way and stays:
    outside it, it would alone tell mu2 to 3.5 % MAE and leave no question of where to put gauges.
    """
    rows = [(0.12, 15), (0.26, 14), (0.42, 15), (0.52, 14)]
    places = np.concatenate([np.stack([np.linspace(0.20, 0.80, n), np.full(n, x)], axis=1) for x, n in rows])
    places[SNAPPED, 0] = SNAPPED_ETA
    return places


def gauge_set(
    planform: Planform,
    section: Naca4,
    regions: tuple[DamageRegion, ...],
    places: FloatArray,
    left_out: tuple[str, ...] = (),
) -> GaugeSet:
    """Return the gauges at `places` (24 or 82, 2), span and chord fractions: g01 to g24, then c01 to c58."""
    n_candidates = len(places) - N_INSTALLED
    names = [f"g{k:02d}" for k in range(1, N_INSTALLED + 1)] + [f"c{k:02d}" for k in range(1, n_candidates + 1)]
    eta, chord = places.T
    height = planform.chord(eta) * section.heights(chord)[0]
    position = np.concatenate([planform.position(eta, chord), height[:, None]], axis=1)
    held = [
        next((r.name for r in regions if r.surface == "top" and r.contains(np.array(e), np.array(x))), "")
        for e, x in zip(eta, chord, strict=True)
    ]
    return GaugeSet(tuple(names), eta, chord, position, tuple(held), left_out)
