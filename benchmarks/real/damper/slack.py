"""The backlash of each test, read from its force without a model: the way that is lost at a reversal.

After a reversal the force falls from the friction of the old direction, passes zero, and rebuilds. The slack at a force
f is the displacement between the last sample above f and the first below -f (both along the old motion): within it the
band carries less than f. It is read at `FORCE` and, for the stiffness of the rebuild, at twice that; at a given force
it cannot depend on the friction level, so series of different tension can be compared.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.real.damper.cycles import halves
from benchmarks.real.damper.series import Recording

FORCE = 0.5
"""Force at which the slack is read [kip] of tests whose friction is larger by `ABOVE`.

Where the median test's is not, it is read at half of that test's friction.
"""
ABOVE = 1.25


def slack_force(tests: Sequence[Recording]) -> float:
    """Return the force [kip] at which the slack of a series is read."""
    middle = float(np.median([friction(test) for test in tests]))
    return FORCE if middle >= ABOVE * FORCE else 0.5 * middle


def friction(test: Recording) -> float:
    """Return the lower of both directions' friction [kip], the median of the second half of each half cycle."""
    sides: dict[float, list[float]] = {1.0: [], -1.0: []}
    for i, j, sign in halves(test):
        sides[sign].append(float(np.median(test.force[(i + j) // 2 : j])) * sign)
    return min((float(np.median(side)) if side else 0.0 for side in sides.values()), default=0.0)


def slack_at(test: Recording, force: float) -> float:
    """Return the median over half cycles, then the mean over directions, of the slack [in]; NaN where there is none."""
    sides: dict[float, list[float]] = {1.0: [], -1.0: []}
    for i, j, sign in halves(test):
        way = np.abs(test.displacement[i:j] - test.displacement[i])
        along = test.force[i:j] * sign
        start, end = passed(along, way, -force), passed(along, way, force)
        if np.isfinite(start) and np.isfinite(end) and end > start:
            sides[sign].append(end - start)
    told = [float(np.median(side)) for side in sides.values() if side]
    return float(np.mean(told)) if len(told) == 2 else float("nan")


def passed(along: np.ndarray, way: np.ndarray, force: float) -> float:
    """Return the way at which the force first rises above a value, between two samples; NaN if it starts above it."""
    k = int(np.argmax(along > force))
    return float(np.interp(force, along[k - 1 : k + 1], way[k - 1 : k + 1])) if k > 0 else float("nan")


def slacks(tests: Sequence[Recording], force: float) -> list[float]:
    """Return the slack of each test whose friction is clear of the force."""
    found = [slack_at(test, force) for test in tests if friction(test) >= ABOVE * force]
    return [one for one in found if np.isfinite(one)]


def stiffnesses(tests: Sequence[Recording], force: float) -> list[float]:
    """Return the stiffness of band and mount [kip/in] between a force and twice it, both sides of the reversal."""
    found = []
    for test in tests:
        if friction(test) >= 2.0 * ABOVE * force:
            more = slack_at(test, 2.0 * force) - slack_at(test, force)
            if np.isfinite(more) and more > 0.0:
                found.append(2.0 * force / more)
    return found
