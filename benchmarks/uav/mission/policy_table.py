"""The policies in one table: lost aircraft, time to the goal, critical steps missed; with 95 % intervals."""

from collections.abc import Sequence

import numpy as np

from benchmarks.uav.mission.aircraft import Aircraft
from benchmarks.uav.mission.histories import KINDS, draw
from benchmarks.uav.mission.policies import POLICIES, Brain, Pilot, Policy
from benchmarks.uav.mission.simulation import Flights, fly

CHUNK = 250
"""Missions flown at once: their beliefs stay in the cache of a core."""
CELLS = 16
"""Cells of the filter in each parameter: 5 % wide, the 40 % on an edge; 10 cost the planner 0.8 steps."""
WATCHED = ("dead gauge",)
"""Missions in which the watch has something to find; elsewhere it can only raise false alarms."""
Z = 1.959964
FEW = 0.5
"""Losses up to which the steps to the goal are given."""


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
    lost, arrival, cost, missed, critical, cautious = (
        np.concatenate([getattr(flight, name) for flight in flights])
        for name in ("lost", "arrival", "cost", "missed", "critical", "cautious")
    )
    return {
        "mission": kind,
        "policy": policy.name,
        "lost %": round(100 * float(lost.mean()), 3),
        "lost +-": round(100 * Z * float(lost.std()) / np.sqrt(len(lost)), 3),
        "steps to the goal": round(float(arrival.mean()), 2) if lost.mean() < FEW else None,
        "cost in steps": round(float(cost.mean()), 2),
        "cost +-": round(Z * float(cost.std()) / np.sqrt(len(cost)), 2),
        "steps over the limit at 3 g %": round(100 * float(missed.sum() / max(1, critical.sum())), 1),
        "needless 2 g steps": round(float(cautious.mean()), 1),
        "missions": len(lost),
        "seed": seed,
    }
