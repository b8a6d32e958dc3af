"""How sound flights of one airframe differ: within a day, and from day to day with other batteries and propellers.

Standard deviations by reading, settled on the commissioning flights left out one at a time. What shakes rises and falls
together from day to day; thrust and roll commands do too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.real.evidence import Reference
from benchmarks.real.quadrotor.flight import READINGS, SHAKEN, Flight
from femlib.arrays import FloatArray

WITHIN = {"thrust": 0.07, "roll": 0.07, "pitch": 0.07, "yaw": 0.08, "yaw_way": 0.11}
ACROSS = {"thrust": 0.22, "roll": 0.22, "pitch": 0.15, "yaw": 0.20, "yaw_way": 0.14}
STEP_WITHIN, STEP_ACROSS, STEP_COMMON = 0.25, 0.35, 0.45
"""Of logarithms of the steps of commands: within a day, from day to day by itself, and all together."""
SHAKE_WITHIN, SHAKE_ACROSS, SHAKE_COMMON = 0.15, 0.18, 0.40
"""The same of what shakes."""
TIE_WITHIN, TIE_ACROSS = 0.10, 0.15
TOGETHER = 0.5
"""Correlation of thrust and roll commands from day to day."""
FAITH = 0.5
"""Weight of what shakes beside what is steady: neighbouring channels tell much the same."""
OTHER_LOG = 0.4
"""Weight of a flight of the same day that shows nothing of how this log shakes."""
ANOTHER_DAY = 0.25
"""Probability that a flight is from a day of which no reference is known."""


def covariance(within: bool) -> FloatArray:
    """Return the covariance of the readings of sound flights (n_readings, n_readings), of one day or of two."""
    names = np.array(READINGS)
    own, step_sd, shake_sd, tie_sd = (
        (WITHIN, STEP_WITHIN, SHAKE_WITHIN, TIE_WITHIN) if within else (ACROSS, STEP_ACROSS, SHAKE_ACROSS, TIE_ACROSS)
    )
    steps = np.char.startswith(names, "step_")
    shakes = np.char.startswith(names, "shake_")
    sd = np.where(steps, step_sd, np.where(shakes, shake_sd, tie_sd))
    sd[: len(own)] = list(own.values())
    found = np.diag(sd**2)
    if not within:
        found[0, 1] = found[1, 0] = TOGETHER * sd[0] * sd[1]
        found += STEP_COMMON**2 * np.outer(steps, steps)
        for channels in SHAKEN.values():
            together = np.isin(names, [f"shake_{channel}" for channel in channels])
            found += SHAKE_COMMON**2 * np.outer(together, together)
    return faithful(found)


def faithful(found: FloatArray) -> FloatArray:
    """Return a covariance with what shakes at its lower weight."""
    weight = np.where(np.arange(len(READINGS)) < len(WITHIN), 1.0, FAITH**-0.5)
    return np.asarray(found * np.outer(weight, weight))


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """A practice flight as if it were sound: its readings with what was done taken off, and how uncertain that is.

    Attributes
    ----------
    flight
        as it flew.
    steady
        (n_steady,) with the change of its causes taken off.
    doubt
        (n_steady,) standard deviation of that change.
    causes
        kind and place of each.
    """

    flight: Flight
    steady: FloatArray
    doubt: FloatArray
    causes: frozenset[tuple[str, str]]


def usual_shaking(flight: Flight, sound: Sequence[Flight]) -> FloatArray:
    """Return the mean of the readings of sound flights with the same log (n_readings,)."""
    return np.asarray(np.mean([one.readings for one in sound if one.log == flight.log], axis=0))


def references(flight: Flight, sound: Sequence[Flight], told: Sequence[Told]) -> list[Reference]:
    """Return sound flights as the one at hand may resemble: each seen again, or on another day.

    A flight with the other log lends its steady commands; what shakes is then the mean of the own log.
    """
    n = len(WITHIN)
    usual = usual_shaking(flight, sound)
    near, far = covariance(within=True), covariance(within=False)
    mixed = far.copy()
    mixed[:n, :n] = near[:n, :n]
    found = []
    for one in sound:
        if one.log == flight.log:
            found.append(Reference(one.readings, near, 1.0 - ANOTHER_DAY))
            found.append(Reference(one.readings, far, ANOTHER_DAY))
        else:
            readings = np.concatenate([one.readings[:n], usual[n:]])
            found.append(Reference(readings, mixed, OTHER_LOG * (1.0 - ANOTHER_DAY)))
            found.append(Reference(readings, far, ANOTHER_DAY))
    for known in told:
        wide = mixed.copy()
        wide[:n, :n] += np.diag(known.doubt**2)
        shaken = known.flight.readings if known.flight.log == flight.log else usual
        found.append(Reference(np.concatenate([known.steady, shaken[n:]]), wide, OTHER_LOG * (1.0 - ANOTHER_DAY)))
    return found
