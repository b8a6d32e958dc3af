"""The policies in one table: lost aircraft, time to the goal, critical steps missed; with 95 % intervals."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import binomtest

from benchmarks.uav.mission.aircraft import Aircraft
from benchmarks.uav.mission.course_plan import LOST
from benchmarks.uav.mission.histories import KINDS, draw
from benchmarks.uav.mission.policies import POLICIES, Brain, Pilot, Policy
from benchmarks.uav.mission.simulation import Flights, fly

CHUNK = 1000
"""Missions flown at once: bounds memory."""
CELLS = 10
"""Cells of the filter in each parameter: the 40 % lies on an edge, and 10^4 missions take minutes."""
WATCHED = ("dead gauge",)
"""Missions in which the watch has something to find; elsewhere it can only raise false alarms."""
Z = 1.959964


def policy_rows(aircraft: Aircraft, n: int, seed: int, kinds: Sequence[str] = KINDS) -> list[dict[str, object]]:
    """Return one row for every kind of mission and policy, n missions each, the same histories for all policies."""
    read = tuple(aircraft.gauges.index(gauge) for gauge in aircraft.selector.gauges_read)
    brain = Brain.of(aircraft, CELLS)
    watch = aircraft.watch() if set(kinds) & set(WATCHED) else None
    rows = []
    for kind in kinds:
        for policy in POLICIES:
            if policy.has_watch and kind not in WATCHED:
                continue
            flights = []
            for first in range(0, n, CHUNK):
                rng = np.random.default_rng([seed, KINDS.index(kind), first])
                histories = draw(kind, min(CHUNK, n - first), rng, read)
                pilot = Pilot(policy, aircraft, histories.n, brain, watch, histories.rates)
                flights.append(fly(aircraft, histories, pilot, rng))
            rows.append(_row(kind, policy, flights, seed))
            print(f"{kind}, {policy.name}: {rows[-1]['lost %']} % lost, cost {rows[-1]['cost in steps']}", flush=True)
    return rows


def _row(kind: str, policy: Policy, flights: Sequence[Flights], seed: int) -> dict[str, object]:
    lost, steps, missed, critical, cautious, excess = (
        np.concatenate([getattr(flight, name) for flight in flights])
        for name in ("is_lost", "steps", "missed", "critical", "cautious", "excess")
    )
    low, high = wilson(int(lost.sum()), len(lost))
    arrived = steps[~lost]
    spread = Z * arrived.std() / np.sqrt(len(arrived)) if len(arrived) else np.nan
    return {
        "mission": kind,
        "policy": policy.name,
        "lost %": round(100 * float(lost.mean()), 2),
        "95 % interval": f"{100 * low:.2f} to {100 * high:.2f}",
        "steps to the goal": round(float(arrived.mean()), 2) if len(arrived) else None,
        "+-": round(float(spread), 2) if len(arrived) else None,
        "cost in steps": round(float(np.mean(steps + LOST * lost)), 2),
        "missions over the limit %": round(100 * float((excess > 0.0).mean()), 2),
        "worst excess %": round(100 * float(excess.max()), 1),
        "steps over the limit at 3 g %": round(100 * float(missed.sum() / max(1, critical.sum())), 1),
        "needless 2 g steps": round(float(cautious.mean()), 1),
        "missions": len(lost),
        "seed": seed,
    }


def wilson(successes: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share. Source: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212."""
    found = binomtest(successes, n).proportion_ci(0.95, "wilson")
    return float(found.low), float(found.high)
