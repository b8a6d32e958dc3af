"""Policies: from what is known at a step, whether the next is flown at 2 g (cautious) or at 3 g.

Each is a function of the estimates at hand. The paper's: fall back to 2 g when either estimate exceeds 40 %. A belief
allows another: fly at 3 g only while the loss that is expected of it is below the time that it gains,

    LOST * P(the wing does not bear 3 g | readings)  <  steps lost by one cautious step.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission.aircraft import CRITICAL, Aircraft
from benchmarks.uav.mission.histories import MOST_RESERVE
from octmip.monitor import Belief, Filter, Finding, ModelSelector, MonitorState, Watch, explain
from octmip.monitor.belief import share_below

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LOST = 200.0
"""Cost of the loss of an aircraft, in steps of flight: two missions."""
STEP_PRICE = 0.105
"""Steps that a cautious step costs: the wide way is so much longer (course.py)."""


@dataclass(frozen=True, slots=True)
class Policy:
    """A rule for deciding.

    Attributes
    ----------
    name
        in the table.
    estimator
        "truth", "nothing", "trees", "risk trees" or "filter".
    rule
        "paper", "loss", "always" or "never".
    has_watch
        whether an alarm, too, leads to caution, and a faulty gauge is left out.
    """

    name: str
    estimator: str
    rule: str
    has_watch: bool = False


POLICIES = (
    Policy("oracle", "truth", "paper"),
    Policy("never cautious", "nothing", "never"),
    Policy("always cautious", "nothing", "always"),
    Policy("trees, 40 % (the paper's)", "trees", "paper"),
    Policy("risk-weighted trees, 40 %", "risk trees", "paper"),
    Policy("filter, 40 %", "filter", "paper"),
    Policy("filter, expected loss", "filter", "loss"),
    Policy("filter, expected loss, watch", "filter", "loss", has_watch=True),
)


def loss_of_state(chain: Filter) -> Floats:
    """Return for every state of the filter the probability that a wing does not bear 3 g, over its reserve."""
    # the reserve is uniform from 0 to MOST_RESERVE, capability falls by 1 g for CRITICAL of damage
    library = chain.library
    width = float(library.widths[0])
    edges = np.linspace(CRITICAL, CRITICAL * (1 + MOST_RESERVE), 51)
    bears = np.zeros(library.n_states)
    for edge in edges:  # P(fails) = mean over the reserve of P(worst damage > what that reserve bears)
        bears += share_below(library.states[:, 0], width, edge) * share_below(library.states[:, 1], width, edge)
    return 1.0 - bears / len(edges)


class Pilot:
    """A policy at work on n aircraft at once."""

    def __init__(self, policy: Policy, aircraft: Aircraft, n: int, chain: Filter | None, watch: Watch | None) -> None:
        self.policy, self.aircraft, self.n = policy, aircraft, n
        self.chain = chain if policy.estimator == "filter" else None
        self.watch = watch if policy.has_watch else None
        self.belief: Belief | None = None if self.chain is None else self.chain.start(n, state=0)
        self.monitor_state: MonitorState | None = None if self.watch is None else self.watch.start(n)
        self.faulty = np.full(n, -1)
        self.is_outside = np.zeros(n, dtype=bool)
        self.findings: dict[int, Finding] = {}
        self.loss = None if self.chain is None else loss_of_state(self.chain)
        self.estimate = np.zeros((n, 2))

    def decide(self, readings: Floats, loads: Floats, truth: Floats) -> Flags:
        """Return who flies the next step at 2 g, after readings (n, n_gauges) at known loads (n,)."""
        if self.policy.rule in ("always", "never"):
            return np.full(self.n, self.policy.rule == "always")
        if self.policy.estimator == "truth":
            self.estimate = truth[:, :2]
            return np.asarray((truth > CRITICAL).any(axis=1))
        if self.belief is None:
            self.estimate = self._told(readings, loads)
            return np.asarray((self.estimate > CRITICAL).any(axis=1))
        return self._decide_by_belief(self._heard(readings, loads), loads)

    def _told(self, readings: Floats, loads: Floats) -> Floats:
        is_risk = self.policy.estimator == "risk trees"
        selector: ModelSelector = self.aircraft.risk_selector if is_risk else self.aircraft.selector
        states = selector.compiled.labels(readings / loads[:, None])
        return np.asarray(selector.library.states[states])

    def _heard(self, readings: Floats, loads: Floats) -> Floats:
        """Return the readings without faulty gauges, after the watch has looked at them."""
        if self.watch is None or self.monitor_state is None:
            return readings
        readings = self._without_faulty(readings)
        before = self.monitor_state.is_alarm
        self.monitor_state = self.watch.observe(self.monitor_state, readings, loads)
        for row in np.flatnonzero(self.monitor_state.is_alarm & ~before & ~self.is_outside):
            finding = explain(self.watch, self.monitor_state, int(row))
            self.findings[int(row)] = finding
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

    def _decide_by_belief(self, readings: Floats, loads: Floats) -> Flags:
        assert self.chain is not None
        assert self.belief is not None
        assert self.loss is not None
        self.belief = self.chain.step(self.belief, readings, loads)
        if self.policy.rule == "loss":
            return np.asarray(LOST * self.belief.expectation(self.loss) > STEP_PRICE) | self.is_outside
        self.estimate = np.column_stack([self.belief.quantile(name, 0.5) for name in ("mu1", "mu2")])
        return np.asarray((self.estimate > CRITICAL).any(axis=1)) | self.is_outside
