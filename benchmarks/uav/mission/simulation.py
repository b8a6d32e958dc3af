"""Missions flown many at a time: every step damage grows, the gauges are read, the policy decides, the wing bears."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission import course
from benchmarks.uav.mission.aircraft import NOISE_SD, WEAR, Aircraft
from benchmarks.uav.mission.capable import GUST
from benchmarks.uav.mission.histories import MOST_STEPS, Histories
from benchmarks.uav.mission.policies import OVER, Pilot

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Flights:
    """Outcomes of n missions.

    Attributes
    ----------
    is_lost
        (n,) whether the wing was asked for more than it could bear.
    steps
        (n,) to the goal, or to the loss.
    missed
        (n,) steps flown at 3 g with a damage over the limit; critical: (n,) steps with such damage.
    cautious
        (n,) steps flown at 2 g with a damage below the limit.
    excess
        (n,) most of a flown load factor over what the twin says the wing bears, as a share; below 0: never over.
    """

    is_lost: NDArray[np.bool_]
    steps: NDArray[np.int64]
    missed: NDArray[np.int64]
    critical: NDArray[np.int64]
    cautious: NDArray[np.int64]
    excess: Floats


def fly(aircraft: Aircraft, histories: Histories, pilot: Pilot, rng: np.random.Generator) -> Flights:
    """Return what becomes of missions with these histories under a policy."""
    n = histories.n
    clock, excess = np.zeros(n), np.full(n, -1.0)
    x, width, load = np.zeros(n), np.zeros(n), np.full(n, 3.0)
    is_lost, is_there = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    steps, missed, critical, cautious = (np.zeros(n, dtype=np.int64) for _ in range(4))
    for k in range(MOST_STEPS):
        truth = damage_at(histories, k, clock)
        is_on = ~is_lost & ~is_there
        # at the load of the last manoeuvre
        readings = readings_at(aircraft, histories, k, load, rng, clock)
        is_cautious = pilot.decide(readings, load, truth, x, width)
        load = np.where(is_cautious, 2.0, 3.0)
        x, width = course.advance(x, width, is_cautious)
        bears = aircraft.capable.bears(truth)
        is_critical = aircraft.capable.fails(truth, 3.0) > OVER
        steps += is_on
        missed += is_on & is_critical & ~is_cautious
        critical += is_on & is_critical
        cautious += is_on & ~is_critical & is_cautious
        excess = np.where(is_on, np.maximum(excess, load / bears - 1.0), excess)
        is_lost |= is_on & (load * (1.0 + GUST * rng.normal(size=n)) > bears)
        clock = clock + np.where(is_cautious, WEAR, 1.0)
        is_there |= is_on & ~is_lost & (x >= course.GOAL)
        if not (~is_lost & ~is_there).any():
            break
    return Flights(is_lost, steps, missed, critical, cautious, excess)


def damage_at(histories: Histories, step: int, clock: Floats | None = None) -> Floats:
    """Return the true damage (n, 2), as old as `clock` (n,) steps at 3 g, the step's number if not given."""
    age = np.full(histories.n, float(step)) if clock is None else np.minimum(clock, MOST_STEPS - 1.0)
    low, rows = np.minimum(age.astype(np.intp), MOST_STEPS - 2), np.arange(histories.n)
    share = (age - low)[:, None]
    return np.asarray((1.0 - share) * histories.damage[rows, low] + share * histories.damage[rows, low + 1])


def readings_at(
    aircraft: Aircraft,
    histories: Histories,
    step: int,
    load: Floats,
    rng: np.random.Generator,
    clock: Floats | None = None,
) -> Floats:
    """Return the noisy readings (n, n_gauges) of a step, at the load that is being flown; `clock` as `damage_at`."""
    strains = aircraft.strains(damage_at(histories, step, clock))
    readings = load[:, None] * strains + rng.normal(0.0, NOISE_SD, strains.shape)
    rows = np.flatnonzero(step >= histories.dead_from)
    readings[rows, histories.dead_gauge[rows]] = 0.0
    return np.asarray(readings)
