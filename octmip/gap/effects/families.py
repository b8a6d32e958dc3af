r"""Effects as families: who it acts on x its course of time x its law over the load, each with name, size and words.

The change of a reading r of typical size s, at the time t from the start, per unit of size is weight x course x law:

| who | weight |
|---|---|
| one | 1 for the readings of one instrument |
| unit | 1 for all readings of one unit |
| along, across | -1 to 1 along the longest, the second longest axis of the structure, for all readings of one unit |

| course | factor | law | factor |
|---|---|---|---|
| steady | 1 | constant | 1, in the unit of the readings |
| linear | t / 1 h | proportional | r / 100 |
| power | (t / 1 h)^(1/3) | square | r abs(r) / 100 s |
| settling | 1 - exp(-t / 20 min) | threshold | sign(r) max(0, abs(r) - s / 2) / 100 |
| warming | temperature of the campaign above its first [10 K] | | |
| direction | 1 where the load has risen last, -1 where it has fallen | | |

The commonest cells have names of their own (`CARDS`); each of the others is `RARE` times as probable as one of these.
A cell of one unit is the rarer, the fewer of the readings are in it: a fault is as probable at each reading.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import exp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.gap.effects.chain import ChainEffect, Moment
from octmip.gap.effects.words import placed
from octmip.twin import MICROSTRAIN, PURE, Twin, channels_of, positions_of, units_of

Floats = NDArray[np.float64]
History = tuple[tuple[float, float], ...]
"""Times [s] from the start of a campaign, and what a course is then."""

COURSES: Mapping[str, Callable[[float], float]] = {
    "steady": lambda hours: 1.0,
    "linear": lambda hours: hours,
    "power": lambda hours: max(hours, 0.0) ** (1.0 / 3.0),
    "settling": lambda hours: 1.0 - exp(-3.0 * max(hours, 0.0)),
}
"""Courses that every campaign has; those of `History` are read from it."""
COURSE_WORDS = {
    "steady": "", "linear": "drifting ", "power": "creeping ", "settling": "settling ", "warming": "warming ",
    "direction": "lagging ",
}  # fmt: skip
LAW_WORDS = {
    "constant": "offset",
    "proportional": "gain",
    "square": "curvature over the load",
    "threshold": "gain beyond half of the load",
}
WHO_WORDS = {
    "one": "of one gauge",
    "unit": "common to all gauges",
    "along": "that varies along the structure",
    "across": "that varies across the structure",
}
RARE = 0.04
"""How probable a cell of the library without a name of its own is beside one that has it."""
PRIOR_SHARE = {"constant": 0.03, "proportional": 2.0, "square": 2.0, "threshold": 2.0}
"""Prior sd: of an offset over the typical reading, of the others in per cent."""
STRAIN = 1000.0
"""Typical strain [microstrain]: a bridge is balanced to 30 whatever it reads."""

CELLS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "one": (
        ("power", "constant"),
        ("settling", "constant"),
        ("warming", "constant"),
        ("linear", "proportional"),
        ("steady", "square"),
        ("steady", "threshold"),
        ("direction", "constant"),
    ),
    "unit": (
        ("steady", "constant"),
        ("linear", "constant"),
        ("power", "constant"),
        ("settling", "constant"),
        ("warming", "constant"),
        ("linear", "proportional"),
        ("power", "proportional"),
        ("settling", "proportional"),
        ("steady", "square"),
        ("steady", "threshold"),
        ("direction", "proportional"),
    ),
    "along": (
        ("steady", "constant"),
        ("linear", "constant"),
        ("warming", "constant"),
        ("steady", "proportional"),
        ("linear", "proportional"),
    ),
    "across": (("steady", "constant"), ("warming", "constant"), ("steady", "proportional")),
}
"""Courses and laws of each who; what is missing has a name of its own."""

CARDS: Mapping[tuple[str, str, str], Mapping[str, Any]] = {
    ("one", "steady", "proportional"): {
        "name": "gauge_gain",
        "parameter": "error of the gain of one gauge",
        # gauge factors are given to 0.5 to 1 %, lead wires and bonding add as much again
        "separated_by": "a misalignment or an offset of the same gauge gives the same reading in one state; "
        "a shunt calibration shows the gain",
        "words": "gain of one gauge",
        "action": "recalibrate gauge {place}",
        "says": ("it reads {size} too high", "it reads {size} too low"),
    },
    ("one", "steady", "constant"): {
        "name": "gauge_bias",
        "parameter": "offset of one gauge",
        # bridges are balanced to some ten microstrain, other channels to 3 % of the typical reading
        "separated_by": "a reading at zero load shows it alone",
        "seen_by": (),
        "words": "zero offset of one gauge",
        "action": "set gauge {place} to zero again",
        "says": ("it reads {size} too high at every load", "it reads {size} too low at every load"),
    },
    ("one", "linear", "constant"): {
        "name": "gauge_drift",
        "parameter": "drift of one gauge",
        # unprotected gauges wander by some ten microstrain in an hour, other channels by some per cent
        "separated_by": "the same load at the start and at the end of the campaign; "
        "with loads in ascending order a drift looks like a gain",
        "seen_by": (),
        "words": "drift of one gauge",
        "action": "find out why gauge {place} drifts",
        "says": ("its reading rises by {size}", "its reading falls by {size}"),
    },
    ("unit", "steady", "proportional"): {
        "name": "common_gain",
        "parameter": "error of the gain common to all gauges",
        "prior_sd": 1.0,  # amplifiers and gauge factors of one batch are good to about one per cent
        "separated_by": "strain alone cannot tell it from the load factor or a modulus: a shunt calibration does",
        "words": "gain common to all gauges",
        "action": "recalibrate the amplifier of all gauges",
        "says": ("all gauges read {size} too high", "all gauges read {size} too low"),
    },
}
"""Cells with names of their own; a gain is one effect whatever the units."""
OF_CHANNEL = {
    "gauge_bias": {"words": "offset of one channel", "action": "set {place} to zero again"},
    "gauge_drift": {"words": "drift of one channel", "action": "find out why {place} drifts"},
}
"""What these are called where no strain is read."""


AXES = ("along", "across")


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell of the library: what it changes in the readings, and where.

    Attributes
    ----------
    who, course, law
        as the tables of this module have them.
    unit
        of the readings that it acts on; "" for all.
    scale
        typical reading of the unit.
    history
        the course, where the campaign gives it.
    """

    who: str
    course: str
    law: str
    unit: str
    scale: float
    history: History = ()

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the instruments, or the whole."""
        own = self._own(twin)
        if self.who == "one":
            return tuple(
                dict.fromkeys(channel for channel, is_own in zip(channels_of(twin), own, strict=True) if is_own)
            )
        return ("",) if sum(own) > 1 or not self.unit else ()

    def change(self, moment: Moment) -> Floats:
        """Return the change of the readings (n_places, n_gauges) per unit of size."""
        return np.asarray(self._weights(moment.twin, moment.places) * self._course(moment.time) * self._law(moment))

    def _weights(self, twin: Twin, places: Sequence[str]) -> Floats:
        own = np.array(self._own(twin), dtype=np.float64)
        if self.who == "one":
            return np.asarray(own * (np.array(channels_of(twin)) == np.array(places)[:, None]))
        along = on_axis(twin, AXES.index(self.who)) if self.who in AXES else 1.0
        return np.tile(own * along, (len(places), 1))

    def _own(self, twin: Twin) -> list[bool]:
        return [self.unit in ("", unit) for unit in units_of(twin)]

    def _course(self, time: float) -> float:
        if self.course in COURSES:
            return COURSES[self.course](time / 3600.0)
        times, values = np.array(self.history).T
        return float(values[np.argmin(np.abs(times - time))])

    def _law(self, moment: Moment) -> Floats:
        if self.law == "constant":
            return np.ones(len(moment.twin.gauges))
        reading = np.asarray(moment.readings, dtype=np.float64)
        if self.law == "proportional":
            return 0.01 * reading
        if self.law == "square":
            return 0.01 * reading * np.abs(reading) / self.scale
        return 0.01 * np.sign(reading) * np.maximum(0.0, np.abs(reading) - 0.5 * self.scale)


def on_axis(twin: Twin, rank: int) -> Floats:
    """Return where each gauge lies along the longest (0) or second longest axis (n_gauges,), -1 to 1.

    0 where nobody says, or where all gauges lie on one line.
    """
    places = positions_of(twin)
    if places is None:
        return np.zeros(len(twin.gauges))
    extent = np.ptp(places, axis=0)
    axes = [int(k) for k in np.argsort(-extent, kind="stable") if extent[k] > 0.0]
    if rank >= len(axes):
        return np.zeros(len(twin.gauges))
    axis = axes[rank]
    return np.asarray(2.0 * (places[:, axis] - places[:, axis].min()) / extent[axis] - 1.0)


def families_of(twin: Twin, typical: Mapping[str, float], histories: Mapping[str, History]) -> list[ChainEffect]:
    """Return the cells for a twin's readings, given the typical reading of each unit and the campaign's own courses."""
    missing = {who for rank, who in enumerate(AXES) if not on_axis(twin, rank).any()}
    every = list(units_of(twin))
    units = list(dict.fromkeys(every))
    cells = [(who, course, law) for who, own in CELLS.items() if who not in missing for course, law in own]
    cells = [cell for cell in cells if cell[1] in COURSES or cell[1] in histories]
    found = named_families(every, typical)
    for unit in units:
        scale = typical.get(unit, 1.0) or 1.0
        share = every.count(unit) / len(every)
        found += [_family(cell, unit, scale, share, len(units) == 1, histories.get(cell[1], ())) for cell in cells]
    return found


def named_families(every: Sequence[str], typical: Mapping[str, float]) -> list[ChainEffect]:
    """Return the cells with names of their own for readings of these units (n_gauges,)."""
    units, found = list(dict.fromkeys(every)), []
    for cell in CARDS:
        if cell[2] == "proportional":
            found.append(_family(cell, "", 1.0, 1.0, is_only=True))
            continue
        for unit in units:
            scale = STRAIN if unit == MICROSTRAIN else typical.get(unit, 1.0) or 1.0
            is_plain = len(units) == 1 or unit == MICROSTRAIN
            found.append(_family(cell, unit, scale, every.count(unit) / len(every), is_plain))
    return found


def _family(
    cell: tuple[str, str, str], unit: str, typical: float, share: float, is_only: bool, history: History = ()
) -> ChainEffect:
    who, course, law = cell
    ending = "" if is_only else f"_{re.sub(r'[^a-z0-9]+', '_', unit.lower()).strip('_') or 'number'}"
    size_unit = unit if law == "constant" else "%"
    if course == "linear":
        size_unit = "1/h" if size_unit in PURE else f"{size_unit}/h"
    called = f"{COURSE_WORDS[course]}{LAW_WORDS[law]}"
    words = f"{called} {WHO_WORDS[who]}{'' if is_only else f' in {unit}'}"
    said: dict[str, Any] = {
        "name": "_".join(cell),
        "prior_sd": PRIOR_SHARE[law] * (typical if law == "constant" else 1.0),
        "words": words,
        "action": f"look for the {words}",
        "says": (f"the {called} is {{size}}", f"the {called} is -{{size}}"),
        "parameter": called,
        "separated_by": "the same load at the start and at the end of the campaign, and a shunt calibration",
        "seen_by": ("shunt_reading",),
    }
    if cell in CARDS:
        said |= CARDS[cell]
        said["prior_sd"] *= 2.0 if course == "linear" else 1.0
        if unit not in ("", MICROSTRAIN):
            said |= OF_CHANNEL[said["name"]]
            said["words"] += "" if is_only else f" in {unit}"
    said["name"] += ending
    if who == "one":
        said["words_at"] = placed(said["words"]).removesuffix(f" in {unit}")
    own = Cell(*cell, unit, typical, history)
    return ChainEffect(
        unit=size_unit,
        change=own.change,
        places_in=own.places,
        load_power=0 if law == "constant" else None,
        uses_time=course != "steady",
        is_nameless=cell not in CARDS,
        commonness=share * (1.0 if cell in CARDS else RARE),
        **said,
    )
