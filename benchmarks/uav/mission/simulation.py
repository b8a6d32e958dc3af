"""Missions flown many at a time: damage grows, the gauges are read, the policy decides, the wing bears."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission import course
from benchmarks.uav.mission.aircraft import NOISE_SD, WEAR, Aircraft
from benchmarks.uav.mission.course_plan import LOST
from benchmarks.uav.mission.histories import MOST_STEPS, Histories
from benchmarks.uav.mission.policies import OVER, Pilot

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Flights:
    """Outcomes of n missions.

    Nothing is drawn of a manoeuvre's scatter: a wing flies on with the chance that it bore all before, so that losses
    of one in ten thousand show in as many missions.

    Attributes
    ----------
    lost
        (n,) chance that the wing is asked for more than it bears.
    arrival
        (n,) steps to the goal of a wing that bears all.
    cost
        (n,) expected steps flown, and `LOST` for a loss.
    missed
        (n,) steps at 3 g over the limit; critical: (n,) steps over the limit.
    cautious
        (n,) steps at 2 g below the limit.
    """

    lost: Floats
    arrival: Floats
    cost: Floats
    missed: NDArray[np.int64]
    critical: NDArray[np.int64]
    cautious: NDArray[np.int64]


def fly(aircraft: Aircraft, histories: Histories, pilot: Pilot, rng: np.random.Generator) -> Flights:
    """Return what becomes of missions with these histories under a policy."""
    n = histories.n
    clock, survived, flown = np.zeros(n), np.ones(n), np.zeros(n)
    x, width, load = np.zeros(n), np.zeros(n), np.full(n, 3.0)
    arrival, missed, critical, cautious = (np.zeros(n, dtype=np.int64) for _ in range(4))
    for k in range(MOST_STEPS):
        truth = damage_at(histories, k, clock)
        is_on = x < course.GOAL
        # at the load of the last manoeuvre
        readings = readings_at(aircraft, histories, k, load, rng, clock)
        is_cautious = pilot.decide(readings, load, truth, x, width)
        load = np.where(is_cautious, 2.0, 3.0)
        x, width = course.advance(x, width, is_cautious)
        is_critical = is_on & (aircraft.capable.fails(truth, 3.0) > OVER)
        arrival += is_on
        missed += is_critical & ~is_cautious
        critical += is_critical
        cautious += is_on & ~is_critical & is_cautious
        flown += np.where(is_on, survived, 0.0)
        survived = survived * (1.0 - np.where(is_on, aircraft.capable.fails(truth, load), 0.0))
        clock = clock + np.where(is_cautious, WEAR, 1.0)
        if not is_on.any():
            break
    lost = 1.0 - survived
    return Flights(lost, arrival.astype(np.float64), flown + LOST * lost, missed, critical, cautious)


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
