"""Policies: from what is known at a step, whether the next is flown at 2 g (cautious) or at 3 g.

The paper's: fall back to 2 g when either tree's estimate exceeds 40 %. The twin's limit instead of 40 %: when a turn at
3 g would break the wing with more than one chance in a thousand, in the state that the trees name, or with a
probability over a level in the filter's belief. The planner weighs all later steps (`course_plan.py`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission.aircraft import CHANGE, CRITICAL, RATES, WEAR, Aircraft
from benchmarks.uav.mission.capable import Capable, chance_of_failing
from benchmarks.uav.mission.course_plan import LOADS, cell_points, course_plan, place_of
from octmip.monitor import Belief, Filter, Library, Planner, Watch, explain, steady_growth
from octmip.monitor.watch import MonitorState

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

OVER = 1e-3
"""A state is over the limit if a turn at 3 g breaks the wing with more than this chance."""
SLOW, FAST = 0, 1
"""Of a pilot's filters: damage grows as at 2 g, as at 3 g."""


@dataclass(frozen=True, slots=True)
class Policy:
    """A rule for deciding.

    Attributes
    ----------
    name
        in the table.
    estimator
        "truth", "nothing", "trees" or "filter".
    rule
        "paper", "limit", "plan", "always" or "never".
    level
        of the rule "limit": probability of a state over the limit that is borne.
    has_watch
        whether an alarm, too, leads to caution, and a faulty gauge is left out.
    """

    name: str
    estimator: str
    rule: str
    level: float = 0.5
    has_watch: bool = False


POLICIES = (
    Policy("full information", "truth", "plan"),
    Policy("always cautious", "nothing", "always"),
    Policy("never cautious", "nothing", "never"),
    Policy("trees, 40 % (the paper's)", "trees", "paper"),
    Policy("trees, the twin's limit", "trees", "limit"),
    Policy("filter, P(over limit) > 10 %", "filter", "limit", 0.1),
    Policy("filter, P(over limit) > 2 %", "filter", "limit", 0.02),
    Policy("planner", "filter", "plan"),
    Policy("planner, watch", "filter", "plan", has_watch=True),
)


@dataclass(frozen=True, slots=True, eq=False)
class Brain:
    """What all pilots of an aircraft share.

    Attributes
    ----------
    filters
        of damage that grows as at 2 g, and as at 3 g.
    planner
        over the filters' cells, for growth that is not sudden.
    informed
        over cells half as wide, for growth at one rate: what full information decides by.
    over
        (n_states,) share of each cell that is over the limit.
    """

    filters: tuple[Filter, Filter]
    planner: Planner
    informed: Planner
    over: Floats

    @classmethod
    def of(cls, aircraft: Aircraft, n_cells: int) -> "Brain":
        """Return the brain of an aircraft, with n_cells x n_cells cells."""
        slow, fast = (aircraft.filter(n_cells, wear=wear) for wear in (WEAR, 1.0))
        library = fast.library
        over = chance_of_failing(cell_points(library, aircraft.believed), 3.0) > OVER

        def plan(cells: Library, change: float, capable: Capable) -> Planner:
            growths = [steady_growth(cells, [wear * rate for rate in RATES], change=change) for wear in (WEAR, 1.0)]
            return course_plan(cells, growths, capable)

        planner = plan(library, CHANGE, aircraft.believed)
        informed = plan(aircraft.cells(2 * n_cells), 0.0, aircraft.capable)
        return cls((slow, fast), planner, informed, over.mean(axis=1))


class Pilot:
    """A policy at work on n aircraft at once; `rates` (n, 2) are their true growth rates, for the oracle alone."""

    def __init__(
        self, policy: Policy, aircraft: Aircraft, n: int, brain: Brain, watch: Watch | None, rates: Floats | None = None
    ) -> None:
        self.policy, self.aircraft, self.n, self.brain = policy, aircraft, n, brain
        self.watch = watch if policy.has_watch else None
        self.belief: Belief | None = brain.filters[FAST].start(n, state=0) if policy.estimator == "filter" else None
        self.monitor_state: MonitorState | None = None if self.watch is None else self.watch.start(n)
        self.faulty = np.full(n, -1)
        self.is_outside = np.zeros(n, dtype=bool)
        near = np.zeros((n, 2)) if rates is None else rates
        first, second = np.abs(near[:, :, None] - np.array(RATES)).argmin(axis=2).T
        self.rate = first * len(RATES) + second  # combinations of rates, the last parameter's fastest

    def decide(self, readings: Floats, loads: Floats, truth: Floats, x: Floats, width: Floats) -> Flags:
        """Return who flies the next step at 2 g, after readings (n, n_gauges) at known loads (n,), at x and width."""
        if self.policy.rule in ("always", "never"):
            return np.full(self.n, self.policy.rule == "always")
        if self.policy.estimator == "truth":
            return self._knowing(truth, place_of(x, width))
        if self.belief is None:
            return self._by_trees(readings, loads)
        self.belief = self._heard_of(self.belief, self._heard(readings, loads), loads)
        if self.policy.rule == "plan":
            chosen = self.brain.planner.choose(self.belief.weights, place_of(x, width))
            return np.asarray((chosen == 0) | self.is_outside)
        return np.asarray(self.belief.expectation(self.brain.over) > self.policy.level) | self.is_outside

    def _knowing(self, truth: Floats, places: NDArray[np.intp]) -> Flags:
        n_cells = round(np.sqrt(self.brain.informed.actions[0].growth.n_states))
        first, second = np.clip((truth / 0.8 * n_cells).astype(np.intp), 0, n_cells - 1).T
        fails = np.array([self.aircraft.capable.fails(truth, load) for load in LOADS])
        chosen = self.brain.informed.choose_knowing(fails, self.rate, first * n_cells + second, places)
        return np.asarray(chosen == 0)

    def _by_trees(self, readings: Floats, loads: Floats) -> Flags:
        selector = self.aircraft.selector
        told = np.asarray(selector.library.states[selector.compiled.labels(readings / loads[:, None])])
        if self.policy.rule == "paper":
            return np.asarray((told > CRITICAL).any(axis=1))
        return np.asarray(self.aircraft.believed.fails(told, 3.0) > OVER)

    def _heard_of(self, belief: Belief, readings: Floats, loads: Floats) -> Belief:
        """Return the belief after a step flown at `loads` (n,) and its readings."""
        weights, is_slow = belief.weights.copy(), loads < 3.0
        for chain, rows in zip(self.brain.filters, (is_slow, ~is_slow), strict=True):
            if rows.any():
                weights[rows] = chain.growth.advance(belief.weights[rows])
        return self.brain.filters[FAST].observe(Belief(belief.library, weights), readings, loads)

    def _heard(self, readings: Floats, loads: Floats) -> Floats:
        """Return the readings without faulty gauges, after the watch has looked at them."""
        if self.watch is None or self.monitor_state is None:
            return readings
        readings = self._without_faulty(readings)
        before = self.monitor_state.is_alarm
        self.monitor_state = self.watch.observe(self.monitor_state, readings, loads)
        for row in np.flatnonzero(self.monitor_state.is_alarm & ~before & ~self.is_outside):
            finding = explain(self.watch, self.monitor_state, int(row))
            if finding.kind == "gauge" and self.faulty[row] < 0:
                self.faulty[row] = self.aircraft.gauges.index(finding.name)
                self.monitor_state = self.watch.restarted(self.monitor_state, int(row))
            else:
                self.is_outside[row] = True
        return self._without_faulty(readings)

    def _without_faulty(self, readings: Floats) -> Floats:
        rows = np.flatnonzero(self.faulty >= 0)
        readings = readings.copy()
        readings[rows, self.faulty[rows]] = np.nan
        return readings
