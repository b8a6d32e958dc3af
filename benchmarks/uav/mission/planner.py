"""The planner: what each decision costs until the goal, by value iteration over state, growth rate and way left.

A step costs one, a loss `LOST` steps. With l the way left in steps at 2 g, k the growth rate, s the cell, a the action,

    Q_a(l, k, s) = 1 + p_a(s) LOST + (1 - p_a(s)) E[V(l - way_a, k', s') | k, s, a],    V = min over a of Q_a,

p_a(s) being the chance that the manoeuvre breaks the wing. The way left falls in every step, so one pass suffices. On
a belief the planner takes the action of least expected Q: it supposes that the state will be known from the next step
on (QMDP). With the true state and rate the same table is the full-information bound, but for the cells' width and
the way across when the aircraft changes the line (`course.SWITCH`), which it leaves out.

Source: M. L. Littman, A. R. Cassandra, L. P. Kaelbling, Proc. ICML 12 (1995) 362-370 (QMDP).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission import course
from benchmarks.uav.mission.capable import Capable, chance_of_failing
from octmip.monitor import Growth, Library

Floats = NDArray[np.float64]

LOST = 2000.0
"""Cost of the loss of an aircraft, in steps of flight: twenty missions."""
TIGHT_STEPS, WIDE_STEPS = 92, 102
LOADS = (2.0, 3.0)
WAY = (1.0, WIDE_STEPS / TIGHT_STEPS)
"""Way of a step at each load, in steps at 2 g."""
POINTS = 5
"""Points along each side of a cell over which its chance of failing is a mean."""


@dataclass(frozen=True, slots=True, eq=False)
class Planner:
    """Costs of the decisions.

    Attributes
    ----------
    fails
        (2, n_states) chance that a manoeuvre at each of LOADS breaks the wing.
    after
        (2, WIDE_STEPS + 1, n_rates, n_states) expected cost after a step at each of LOADS that the wing survives.
    """

    fails: Floats
    after: Floats

    @classmethod
    def of(cls, library: Library, growths: tuple[Growth, Growth], capable: Capable) -> "Planner":
        """Return the planner of a library's cells; `growths` are those at each of LOADS."""
        bears = cell_points(library, capable)
        fails = np.array([chance_of_failing(bears, load).mean(axis=1) for load in LOADS])
        n_rates, n_states = growths[0].n_rates, growths[0].n_states
        value = np.zeros((WIDE_STEPS + 1, n_rates, n_states))
        after = np.zeros((2, WIDE_STEPS + 1, n_rates, n_states))
        for left in range(1, WIDE_STEPS + 1):
            for action in range(2):
                after[action, left] = _expected(growths[action], _between(value, left - WAY[action]))
            value[left] = (1.0 + fails[:, None] * LOST + (1.0 - fails[:, None]) * after[:, left]).min(axis=0)
        return cls(fails, after)

    def is_cautious(self, weights: Floats, x: Floats) -> NDArray[np.bool_]:
        """Return who flies at 2 g (n,), of beliefs (n, n_rates, n_states) at places x (n,) along the course."""
        after = self.after[:, self.left(x)]
        cost = self.fails[:, None, None] * LOST + (1.0 - self.fails[:, None, None]) * after
        expected = np.einsum("anks,nks->an", cost, weights)
        return np.asarray(expected[0] < expected[1])

    def is_cautious_knowing(self, bears: Floats, rate: NDArray[np.intp], cell: NDArray[np.intp], x: Floats) -> Floats:
        """Return who flies at 2 g (n,) where the capability (n,), growth rate and cell are known."""
        fails = np.array([chance_of_failing(bears, load) for load in LOADS])
        cost = fails * LOST + (1.0 - fails) * self.after[:, self.left(x), rate, cell]
        return np.asarray(cost[0] < cost[1])

    @staticmethod
    def left(x: Floats) -> NDArray[np.intp]:
        """Return the way left (n,) in whole steps at 2 g."""
        return np.ceil(WIDE_STEPS * np.clip(1.0 - x / course.GOAL, 0.0, 1.0)).astype(np.intp)


def cell_points(library: Library, capable: Capable) -> Floats:
    """Return the capabilities (n_states, POINTS^2) at points spread over each cell [g]."""
    offsets = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    both = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2) * library.widths
    points = np.clip(library.states[:, None] + both, 0.0, None)
    return capable.bears(points.reshape(-1, 2)).reshape(len(points), -1)


def _between(value: Floats, left: float) -> Floats:
    """Return the value (n_rates, n_states) at a way left, linear between whole steps; 0 at the goal."""
    if left <= 0.0:
        return np.zeros_like(value[0])
    low = int(left)
    share = left - low
    return np.asarray((1.0 - share) * value[low] + share * value[min(low + 1, WIDE_STEPS)])


def _expected(growth: Growth, value: Floats) -> Floats:
    """Return E[value (n_rates, n_states) of the next step] by rate and state of this one."""
    moved, behind = growth.changes @ value, growth.n_states
    for table in growth.tables:
        levels = table.shape[1]
        behind //= levels
        moved = (table[:, None] @ moved.reshape(growth.n_rates, -1, levels, behind)).reshape(value.shape)
    return np.asarray(moved)
