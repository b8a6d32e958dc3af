"""One mission, step by step, as the page of missions takes it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission import course
from benchmarks.uav.mission.aircraft import CRITICAL, WEAR, Aircraft
from benchmarks.uav.mission.capable import Capable
from benchmarks.uav.mission.histories import MOST_STEPS, Histories, draw
from benchmarks.uav.mission.outside import example_signature
from benchmarks.uav.mission.planner import TIGHT_STEPS, WIDE_STEPS
from benchmarks.uav.mission.player import MissionStep
from benchmarks.uav.mission.policies import Brain, Pilot, Policy
from benchmarks.uav.mission.simulation import damage_at, readings_at
from octmip.monitor import Belief, Finding, Library, Result

Floats = NDArray[np.float64]

NAMES = ("mu1", "mu2")
POLICY = Policy("filter, 40 %, watch", "filter", "paper", has_watch=True)
"""The paper's rule on the belief, so that the path changes at about 40 %."""
TRACES = 3
"""Gauges whose strain is drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """A recorded mission.

    Attributes
    ----------
    kind, seed
        of its history.
    library
        of the filter.
    traced
        gauges whose strain is drawn.
    steps
        the mission.
    outcome
        what the decisions cost and gained, in one sentence.
    """

    kind: str
    seed: int
    library: Library
    traced: tuple[str, ...]
    steps: tuple[MissionStep, ...]
    outcome: str


def recorded(aircraft: Aircraft, kind: str, seed: int) -> Flight:
    """Return a mission of a kind."""
    rng = np.random.default_rng([seed, 9])
    read = tuple(aircraft.gauges.index(gauge) for gauge in aircraft.selector.gauges_read)
    histories = draw(kind, 1, rng, read)
    brain = Brain.of(aircraft, 16)
    pilot = Pilot(POLICY, aircraft, 1, brain, aircraft.watch())
    signature = example_signature(aircraft.gauges) if kind == "outside" else None
    steps: list[MissionStep] = []
    survived = 1.0
    x, width, load, clock = np.zeros(1), np.zeros(1), np.full(1, 3.0), np.zeros(1)
    for k in range(MOST_STEPS):
        truth = damage_at(histories, k, clock)
        readings = readings_at(aircraft, histories, k, load, rng, signature, clock)
        known = bool(pilot.findings)
        is_cautious = pilot.decide(readings, load, truth, x)
        at = (float(x[0]), float(course.height(x, width)[0]))
        steps.append(_step(k, pilot, readings[0], float(load[0]), bool(is_cautious[0]), truth[0], at, is_new=not known))
        survived *= 1.0 - float(aircraft.capable.fails(truth, 2.0 if is_cautious[0] else 3.0)[0])
        load, clock = np.where(is_cautious, 2.0, 3.0), clock + np.where(is_cautious, WEAR, 1.0)
        if x[0] >= course.GOAL:
            break
        x, width = course.advance(x, width, is_cautious)
    traced = tuple(aircraft.gauges[g] for g in _traced(aircraft, histories))
    outcome = _outcome(aircraft, histories, len(steps) - 1, survived)
    return Flight(kind, seed, brain.filters[0].library, traced, tuple(steps), outcome)


def _outcome(aircraft: Aircraft, histories: Histories, n_steps: int, survived: float) -> str:
    """Return in one sentence what the decisions of a mission cost and gained."""
    bold = [float(aircraft.capable.fails(damage_at(histories, k), 3.0)[0]) for k in range(TIGHT_STEPS)]
    lost, lost_boldly = 100.0 * (1.0 - survived), 100.0 * (1.0 - float(np.prod(1.0 - np.array(bold))))
    return (
        f"The decisions cost {n_steps - TIGHT_STEPS} steps beside 3 g throughout and saved {WIDE_STEPS - n_steps} "
        f"beside 2 g throughout; the chance of losing the aircraft was {lost:.2g} % instead of {lost_boldly:.2g} %."
    )


def _step(
    k: int,
    pilot: Pilot,
    reading: Floats,
    load: float,
    is_cautious: bool,
    truth: Floats,
    at: tuple[float, float],
    *,
    is_new: bool,
) -> MissionStep:
    """Return one step of the page; the finding of an alarm stands at the step at which it is new."""
    belief, monitor_state = pilot.belief, pilot.monitor_state
    assert belief is not None
    assert monitor_state is not None
    finding = pilot.findings.get(0)
    p_value = float(monitor_state.p_value[0])
    return MissionStep(
        result=Result(k, None, belief, None, p_value, finding if is_new else None),
        load_factor=load,
        reading=reading,
        decision="2 g, wide turns" if is_cautious else "3 g, tight turns",
        is_cautious=is_cautious,
        reason=_reason(belief, is_cautious, finding, p_value),
        truth=dict(zip(NAMES, truth.tolist(), strict=False)),
        at=at,
        figures=_figures(pilot.aircraft.capable, belief, truth, float(monitor_state.log_e[0])),
    )


def _figures(capable: Capable, belief: Belief, truth: Floats, log_e: float) -> dict[str, str]:
    believed = float(belief.expectation(capable.bears(belief.library.states))[0])
    above = float(belief.probability_above(dict.fromkeys(NAMES, CRITICAL))[0])
    return {
        "Load factor that the wing bears": f"{believed:.2f} g believed, {capable.bears(truth[None])[0]:.2f} g true",
        "Probability that a damage is over 40 %": f"{100 * above:.0f} %",
        "Evidence against the library, power of ten": f"{log_e / np.log(10.0):.1f}",
    }


def _reason(belief: Belief, is_cautious: bool, finding: Finding | None, p_value: float) -> str:
    """Return the reason for a decision in words."""
    parts, over = [], []
    for name in NAMES:
        low, high = (100 * float(end[0]) for end in belief.interval(name))
        median = float(belief.quantile(name, 0.5)[0])
        parts.append(f"{name} at {100 * median:.0f} % (90 % of the belief: {max(0.0, low):.0f} to {high:.0f} %)")
        over += [name] if median > CRITICAL else []
    if over:
        why = f"{' and '.join(over)} over 40 %: wide turns at 2 g."
    elif is_cautious:
        why = "the watch has raised the alarm: wide turns at 2 g."
    else:
        why = "both at most 40 %: tight turns at 3 g."
    seen = finding.words if finding is not None else f"The readings fit the library (p = {p_value:.2f})."
    return f"Believed: {', '.join(parts)}. Decision: {why} {seen}"


def _traced(aircraft: Aircraft, histories: Histories) -> list[int]:
    """Return the gauges that are drawn: of those that the trees read, the ones that move most; a dead one first."""
    read = [aircraft.gauges.index(gauge) for gauge in aircraft.selector.gauges_read]
    ends = aircraft.strains(np.array([[0.0, 0.0], [0.8, 0.0], [0.0, 0.8]]))
    first = [int(g) for g in histories.dead_gauge if g >= 0]
    for change in (ends[1] - ends[0], ends[2] - ends[0], ends[2] - ends[0]):
        first += [g for g in sorted(read, key=lambda g: -abs(change[g])) if g not in first][:1]
    return sorted(first[:TRACES])
