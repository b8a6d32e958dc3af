"""What two models of one wing may place differently: damage regions and gauge rows, as effects of the wing.

None of it was published, so femlib's places are fitted; another model of the same wing has its own. An effect's
signature is the difference of two wings, one of them with the place moved.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing import Wing, uav_wing
from femlib.wing.damage import UAV_REGIONS
from femlib.wing.gauges import GaugeSet
from femlib.wing.planform import PLANFORM, SECTION
from octmip.twin import State, Twin

STEP = 0.01
"""Fraction of span or chord by which a place is moved for its signature."""
SPAN_MM = 1e3 * PLANFORM.span


@dataclass(frozen=True)
class Moved:
    """A place of the wing moved: size in millimetres along the span, in per cent of the chord across it."""

    name: str
    parameter: str
    unit: str
    per_unit: float
    wing: Wing
    moved: Callable[[], Wing]
    prior_sd: float
    prior_mean: float = 0.0
    prior_source: str = "never published; fitted to the strains to about a centimetre"
    is_one_sided: bool = False
    separated_by: str = "a drawing, or a tape measure"
    load_power: int = 1

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the places: the whole wing."""
        return ("",)

    def signature(self, twin: Twin, state: State, load_factor: float, place: str = "", time: float = 0.0) -> FloatArray:
        """Return the change of the strains (n_gauges,) in microstrain per unit of size."""
        change = self.moved().strain_microstrain(state, load_factor) - self.wing.strain_microstrain(state, load_factor)
        return self.per_unit * change


def placing_effects(wing: Wing) -> Mapping[str, Moved]:
    """Return the effects of misplaced regions and gauge rows."""
    found = []
    for k in range(len(UAV_REGIONS)):
        for name, (low, high), along in (
            ("outboard", (STEP, STEP), "eta"),
            ("longer", (-STEP, STEP), "eta"),
            ("aft", (STEP, STEP), "chord"),
            ("wider", (-STEP, STEP), "chord"),
        ):
            moved = cache(lambda k=k, low=low, high=high, along=along: _with_region(k, along, low, high))
            found.append(_card(f"region_{k + 1}_{name}", f"region {k + 1} moved {name}", along, wing, moved))
    rows = {"row_a_inboard": slice(0, 8), "row_a_outboard": slice(8, 16), "row_b": slice(16, 24)}
    for name, part in rows.items():
        for axis, way in enumerate(("outboard", "aft")):
            moved = cache(lambda part=part, axis=axis: _with_gauges(wing, part, axis))
            along = ("eta", "chord")[axis]
            found.append(_card(f"{name}_{way}", f"gauges of {name} placed further {way}", along, wing, moved))
    return {effect.name: effect for effect in found}


def _card(name: str, words: str, along: str, wing: Wing, moved: Callable[[], Wing]) -> Moved:
    if along == "eta":
        return Moved(name, words, "mm", 1.0 / (STEP * SPAN_MM), wing, moved, prior_sd=15.0)
    return Moved(name, words, "% chord", 1.0 / (100.0 * STEP), wing, moved, prior_sd=2.0)


def _with_region(k: int, along: str, low: float, high: float) -> Wing:
    region = UAV_REGIONS[k]
    edges = {f"{along}_min": low, f"{along}_max": high}
    changed = replace(region, **{name: getattr(region, name) + step for name, step in edges.items()})
    return uav_wing(regions=tuple(changed if j == k else other for j, other in enumerate(UAV_REGIONS)))


def _with_gauges(wing: Wing, part: slice, axis: int) -> Wing:
    own = wing.gauges
    eta, chord = np.array(own.eta), np.array(own.chord_fraction)
    (eta, chord)[axis][part] += STEP
    height = PLANFORM.chord(eta) * SECTION.heights(chord)[0]
    position = np.concatenate([PLANFORM.position(eta, chord), height[:, None]], axis=1)
    return replace(wing, gauges=GaugeSet(own.names, eta, chord, position, own.regions))
