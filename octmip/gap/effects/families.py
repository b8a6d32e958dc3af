r"""Effects as families: who it acts on x its course of time x its law over the load, each with name, size and words.

The change of a reading r of typical size s, at the time t from the start, per unit of size is weight x course x law:

| who | weight |
|---|---|
| one | 1 for the readings of one instrument |
| batch | 1 for the readings of one batch or cable: the twin names them as `batches`, a mapping to gauges |
| unit | 1 for all readings of one unit |
| along | -1 to 1 along the longest axis of the structure, for all readings of one unit |

| course | factor | law | factor |
|---|---|---|---|
| steady | 1 | constant | 1, in the unit of the readings |
| linear | t / 1 h | proportional | r / 100 |
| power | (t / 1 h)^(1/3) | square | r abs(r) / 100 s |
| settling | 1 - exp(-t / 20 min) | threshold | sign(r) max(0, abs(r) - s / 2) / 100 |

The commonest cells have names of their own (gain, offset and drift of one gauge, gain common to all). Each of the
others is `RARE` times as probable as one of these.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

from octmip.twin import PURE, Load, State, Twin, channels_of, positions_of, units_of

Floats = NDArray[np.float64]

COURSES: Mapping[str, Callable[[float], float]] = {
    "steady": lambda hours: 1.0,
    "linear": lambda hours: hours,
    "power": lambda hours: max(hours, 0.0) ** (1.0 / 3.0),
    "settling": lambda hours: 1.0 - exp(-3.0 * max(hours, 0.0)),
}
COURSE_WORDS = {"steady": "", "linear": "drifting ", "power": "creeping ", "settling": "settling "}
LAW_WORDS = {
    "constant": "offset",
    "proportional": "gain",
    "square": "curvature over the load",
    "threshold": "gain beyond half of the load",
}
WHO_WORDS = {
    "one": "of one gauge",
    "batch": "of the gauges on one cable",
    "unit": "common to all gauges",
    "along": "that varies along the structure",
}
RARE = 0.04
"""How probable a cell of the library without a name of its own is beside one that has it."""
PRIOR_SHARE = {"constant": 0.03, "proportional": 2.0, "square": 2.0, "threshold": 2.0}
"""Prior sd: of an offset over the typical reading, of the others in per cent."""


@dataclass(frozen=True, slots=True)
class Family:
    """One cell of the library of families.

    Attributes
    ----------
    who, course, law
        as the tables of this module have them.
    scale
        typical reading of the unit.
    reading_unit
        that it acts on.

    The others are those of `octmip.twin.Effect`.
    """

    name: str
    who: str
    course: str
    law: str
    unit: str
    prior_sd: float
    scale: float
    reading_unit: str
    words: str
    words_at: str
    action: str
    says: tuple[str, str]
    commonness: float = RARE
    parameter: str = ""
    prior_source: str = "instruments are good to some per cent"
    separated_by: str = "the same load at the start and at the end of the campaign, and a shunt calibration"
    prior_mean: float = 0.0
    is_one_sided: bool = False
    load_power: int | None = None
    seen_by: tuple[str, ...] = ("shunt_reading",)

    @property
    def uses_time(self) -> bool:
        """Whether the signature depends on the time."""
        return self.course != "steady"

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the instruments, the batches, or the whole."""
        own = [unit == self.reading_unit for unit in units_of(twin)]
        if self.who == "one":
            found = zip(channels_of(twin), own, strict=True)
            return tuple(dict.fromkeys(channel for channel, is_own in found if is_own))
        if self.who == "batch":
            return tuple(getattr(twin, "batches", {}))
        return ("",) if sum(own) > 1 else ()

    def gauges_of(self, twin: Twin, place: str) -> tuple[str, ...]:
        """Return the gauges of a place."""
        if self.who == "one":
            return tuple(name for name, own in zip(twin.gauges, channels_of(twin), strict=True) if own == place)
        return ()

    def signature(self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0) -> Floats:
        """Return the change of the readings (n_gauges,) per unit of size."""
        reading = np.asarray(twin.predict(state, load_factor), dtype=np.float64)
        return self._weight(twin, place) * COURSES[self.course](time / 3600.0) * self._law(reading)

    def _law(self, reading: Floats) -> Floats:
        if self.law == "constant":
            return np.ones_like(reading)
        if self.law == "proportional":
            return 0.01 * reading
        if self.law == "square":
            return 0.01 * reading * np.abs(reading) / self.scale
        return 0.01 * np.sign(reading) * np.maximum(0.0, np.abs(reading) - 0.5 * self.scale)

    def _weight(self, twin: Twin, place: str) -> Floats:
        own = np.array([unit == self.reading_unit for unit in units_of(twin)], dtype=np.float64)
        if self.who == "one":
            return np.array([name == place for name in channels_of(twin)], dtype=np.float64)
        if self.who == "batch":
            return own * np.array([name in twin.batches[place] for name in twin.gauges])  # type: ignore[attr-defined]
        return own * along_longest(twin) if self.who == "along" else own


def along_longest(twin: Twin) -> Floats:
    """Return where each gauge lies along the structure's longest axis (n_gauges,), -1 to 1; 0 where nobody says."""
    places = positions_of(twin)
    if places is None:
        return np.zeros(len(twin.gauges))
    extent = np.ptp(places, axis=0)
    axis = places[:, int(np.argmax(extent))]
    return np.asarray(2.0 * (axis - axis.min()) / max(float(extent.max()), 1e-300) - 1.0)


CELLS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "one": (
        ("power", "constant"),
        ("settling", "constant"),
        ("linear", "proportional"),
        ("steady", "square"),
        ("steady", "threshold"),
    ),
    "batch": (
        ("steady", "constant"),
        ("linear", "constant"),
        ("power", "constant"),
        ("settling", "constant"),
        ("steady", "proportional"),
        ("linear", "proportional"),
    ),
    "unit": (
        ("steady", "constant"),
        ("linear", "constant"),
        ("power", "constant"),
        ("settling", "constant"),
        ("linear", "proportional"),
        ("power", "proportional"),
        ("settling", "proportional"),
        ("steady", "square"),
        ("steady", "threshold"),
    ),
    "along": (
        ("steady", "constant"),
        ("linear", "constant"),
        ("steady", "proportional"),
        ("linear", "proportional"),
    ),
}
"""Courses and laws of each who; what is missing has a name of its own (`per_gauge`, `common_gain`)."""


def families_of(twin: Twin, typical: Mapping[str, float]) -> list[Family]:
    """Return the cells for a twin's readings, given the typical reading of each unit."""
    units = list(dict.fromkeys(units_of(twin)))
    missing = {"batch"} if not getattr(twin, "batches", {}) else set()
    missing |= {"along"} if positions_of(twin) is None else set()
    return [
        _family(who, course, law, unit, typical.get(unit, 1.0) or 1.0, is_only=len(units) == 1)
        for unit in units
        for who, cells in CELLS.items()
        if who not in missing
        for course, law in cells
    ]


def _family(who: str, course: str, law: str, unit: str, typical: float, *, is_only: bool) -> Family:
    ending = "" if is_only else f"_{re.sub(r'[^a-z0-9]+', '_', unit.lower()).strip('_') or 'number'}"
    size_unit = unit if law == "constant" else "%"
    if course == "linear":
        size_unit = "1/h" if size_unit in PURE else f"{size_unit}/h"
    prior_sd = PRIOR_SHARE[law] * (typical if law == "constant" else 1.0)
    called = f"{COURSE_WORDS[course]}{LAW_WORDS[law]}"
    words = f"{called} {WHO_WORDS[who]}{'' if is_only else f' in {unit}'}"
    place = {"one": f"{called} of gauge {{place}}", "batch": f"{called} of the gauges on cable {{place}}"}
    return Family(
        name=f"{who}_{course}_{law}{ending}",
        who=who,
        course=course,
        law=law,
        load_power=0 if law == "constant" else None,
        unit=size_unit,
        prior_sd=prior_sd,
        scale=typical,
        reading_unit=unit,
        words=words,
        words_at=place.get(who, words),
        action=f"look for the {words}",
        says=(f"the {called} is {{size}}", f"the {called} is -{{size}}"),
        parameter=called,
    )
