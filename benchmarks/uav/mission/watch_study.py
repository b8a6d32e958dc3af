"""The watch on simulated missions: false alarms in the library, and what it finds of damage in a third region.

Where the noise allows it. Let d be the length of the signature that the damage leaves in the residuals, summed over the
mission in quadrature and in standard deviations. A test that knows region, size and beginning beforehand, and only
asks whether, finds it with probability Phi(d - z(rate)): 95 % needs d >= 3.97 at a rate of 1 %. A test that must look
for all candidates and beginnings shares its rate among them: with 1 % over (candidates x readings) it needs about 6.8.
Both limits are computed here; no test that uses the same residuals passes the first.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from benchmarks.uav.mission.aircraft import NOISE_SD, Aircraft
from benchmarks.uav.mission.histories import STEPS, Histories, draw
from benchmarks.uav.mission.outside import all_signatures
from benchmarks.uav.mission.simulation import readings_at
from octmip.monitor import MonitorState, Watch, explain

Floats = NDArray[np.float64]

BEGIN = 20
POWER = 0.95


def false_alarm_row(aircraft: Aircraft, watch: Watch, n: int, seed: int) -> dict[str, object]:
    """Return false alarms of n missions of each kind within the library, half of them flown at 2 g after step 50."""
    row: dict[str, object] = {"rate %": 100 * watch.rate, "missions of each kind": n, "seed": seed}
    for number, kind in enumerate(("paper", "own rate", "sudden")):
        rng = np.random.default_rng([seed, 5, number])
        monitor_state, p_values = _watched(
            aircraft, watch, draw(kind, n, rng, (0,)), rng, np.zeros(len(aircraft.gauges))
        )[:2]
        row[f"{kind}: false alarms"] = int(monitor_state.is_alarm.sum())
        row[f"{kind}: p < 0.05 %"] = round(100 * float((p_values < 0.05).mean()), 2)
    return row


def outside_rows(aircraft: Aircraft, watch: Watch, folder: Path, n: int, seed: int) -> list[dict[str, object]]:
    """Return one row for every third region and size: the limits, how often it was found, how fast, what was named."""
    every = np.ones(len(aircraft.gauges), dtype=bool)
    projector = watch.parity.projector(every)
    loads = np.sqrt(float(np.square(_loads()[BEGIN:]).sum()))
    rows = []
    for (region, size), signature in all_signatures(folder, aircraft.gauges).items():
        length = loads * float(np.linalg.norm(signature / NOISE_SD @ projector))
        rng = np.random.default_rng([seed, 6, int(region[1:]), int(100 * size)])
        if length < told_limit(watch.rate):
            rows.append({"region": region, "damage %": round(100 * size), "d": round(length, 1)})
            continue
        monitor_state, _, at = _watched(aircraft, watch, draw("paper", n, rng, (0,)), rng, signature)
        is_found = (at >= BEGIN) & (at < STEPS)
        finding = explain(watch, monitor_state, int(np.argmax(is_found)))
        rows.append(
            {
                "region": region,
                "damage %": round(100 * size),
                "d": round(length, 1),
                "found %": round(100 * float(is_found.mean()), 1),
                "median delay": float(np.median(at[is_found] - BEGIN)) if is_found.any() else None,
                "named": finding.name or "unknown",
                "gauges": " ".join(finding.gauges[:3]),
            }
        )
    return rows


def told_limit(rate: float) -> float:
    """Return the d at which a test that knows region, size and beginning has 95 % power."""
    return float(norm.isf(rate) + norm.ppf(POWER))


def search_limit(watch: Watch) -> float:
    """Return the d at which a test that must look for all candidates and beginnings has 95 % power."""
    names = {(candidate.kind, candidate.name) for candidate, _ in watch.hypotheses}
    return float(norm.isf(watch.rate / (len(names) * watch.horizon)) + norm.ppf(POWER))


def _loads() -> Floats:
    """Return the load factors of a mission that falls back to 2 g at half time."""
    return np.where(np.arange(STEPS) < STEPS // 2, 3.0, 2.0)


def _watched(
    aircraft: Aircraft, watch: Watch, histories: Histories, rng: np.random.Generator, signature: Floats
) -> tuple[MonitorState, Floats, NDArray[np.int64]]:
    """Return the last monitor state, all p-values (STEPS, n) and the step of each alarm, STEPS: none."""
    monitor_state, p_values, at = watch.start(histories.n), [], np.full(histories.n, STEPS)
    for k, load in enumerate(_loads().tolist()):
        readings = readings_at(aircraft, histories, k, np.full(histories.n, load), rng)
        readings = readings + (load * signature if k >= BEGIN else 0.0)
        monitor_state = watch.observe(monitor_state, readings, load)
        p_values.append(monitor_state.p_value)
        at = np.where((at == STEPS) & monitor_state.is_alarm, k, at)
    return monitor_state, np.array(p_values), at
