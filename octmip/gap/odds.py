"""Odds: how probable causes are before any reading, for whoever knows better than the defaults."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite

from octmip.errors import DataError

MOST_EFFECTS = 3
"""Effects that the search puts together, at most."""
MOST_OFF = 0.5
"""Sd of a constant over that of its drawing, at most."""
UNKNOWN_BESIDE = 3
"""Sizes of sets of effects with which the unknown is weighed: none, one and two."""


@dataclass(frozen=True, slots=True)
class Differences:
    """How far two honest models of one structure lie apart before any effect: relative standard deviations.

    They are those of level 1; how far twin and asset lie apart is learnt from a run, kind of reading by kind of reading
    (`octmip.gap.inference.difference`). Without a run other values than the defaults are taken as they are stated, and
    twice the defaults, which is what models of a wing differ by (docs/gap/sealed.md).

    Attributes
    ----------
    common
        of what all gauges have in common.
    smooth
        of what varies along the structure.
    own
        of each gauge by itself.
    floor
        of each gauge, over the rms of its unit's readings: gauges of little strain differ by more.
    damage
        of the change that damage makes.
    constant, bend, cell, course
        of each gauge at all loads alike, as the load squared, at each load by itself and, of several loads, as a smooth
        course over them, over the rms of its unit's readings.
    constants
        of the constants of a twin with a card, over those of its drawing: a run says them, without one they are open.

    Raises
    ------
    DataError
        no positive number.

    Examples
    --------
    >>> Differences(own=0.02).own  # gauges of this model differ by 2 %, each by itself
    0.02
    """

    common: float = 0.010
    smooth: float = 0.007
    own: float = 0.007
    floor: float = 0.003
    damage: float = 0.08
    constant: float = 0.001
    bend: float = 0.001
    cell: float = 0.001
    course: float = 0.01
    constants: float = 0.08

    def __post_init__(self) -> None:
        if not self.constants <= MOST_OFF:
            raise DataError(
                f"differences constants is {self.constants}; expected at most {MOST_OFF}, a share of the drawing's: "
                "0.05 for 5 %"
            )
        for name in self.__slots__:
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise DataError(
                    f"differences {name} is {value}; expected a number above 0: a share of the readings, 0.01 for 1 %"
                )


@dataclass(frozen=True, slots=True)
class Odds:
    """Prior probabilities of a diagnosis.

    Attributes
    ----------
    count
        of no, one, two and three effects of the library, 1 to 4 entries; sets of more effects than it has are not
        looked for.
    unknown
        of something outside the library alone, beside one effect and beside two, all 3.
    wrong_run
        that a commissioning run was taken with a fault of its own, or of another asset.
    effects
        by name, how many times as probable an effect is as one that is not named here; 0 leaves it out.
    differences
        between two honest models of the structure.

    Raises
    ------
    DataError
        another number of entries, no probabilities, or a negative factor.

    Examples
    --------
    >>> Odds(effects={"gauge_bias": 5.0, "temperature": 0.0}).wrong_run
    0.02
    """

    count: tuple[float, ...] = (0.50, 0.33, 0.08, 0.01)
    unknown: tuple[float, ...] = (0.06, 0.015, 0.003)
    wrong_run: float = 0.02
    effects: Mapping[str, float] = field(default_factory=dict)
    differences: Differences = Differences()

    def __post_init__(self) -> None:
        if not 1 <= len(self.count) <= MOST_EFFECTS + 1:
            raise DataError(
                f"odds count have {len(self.count)} entries; expected 1 to {MOST_EFFECTS + 1}: of no, one, two and "
                "three effects; the search looks for no larger sets, drop the others"
            )
        if len(self.unknown) != UNKNOWN_BESIDE:
            raise DataError(
                f"odds unknown have {len(self.unknown)} entries; expected {UNKNOWN_BESIDE}: alone, beside one effect "
                "and beside two; give each, 0 for never"
            )
        self._check_numbers()

    def _check_numbers(self) -> None:
        numbers = {"count": self.count, "unknown": self.unknown, "wrong_run": (self.wrong_run,)}
        for name, values in numbers.items():
            if not all(isfinite(v) and 0.0 <= v < 1.0 for v in values) or not sum(values) <= 1.0:
                raise DataError(
                    f"odds {name} are {values}; expected probabilities below 1 whose sum is at most 1; lower them"
                )
        if not self.count[0] > 0.0:
            raise DataError(
                f"odds count are {self.count}; expected a probability above 0 that no effect acts; raise the first"
            )
        for name, factor in self.effects.items():
            if not (isfinite(factor) and factor >= 0.0):
                raise DataError(
                    f"odds of effect {name} are {factor}; expected a factor of 0 or more; 1 is as probable as one "
                    "that is not named, 0 leaves it out"
                )
