"""Damage at a few neighbouring gauges, and gauges that fail: what the watch says of each, beside a plainer test.

A flight has 100 readings at 3 g, or at 2 and 3 g in turns, while mu1 and mu2 grow to at most 30 %. Damage changes a
gauge and its nearest, one to four in all, in proportion to the load, from one reading on. One to three gauges fail,
each at a reading of its own: they read too much, nothing, a multiple, or the same for ever. Only changes whose distance
d from the library is at least `LEAST` are drawn: no test finds much smaller ones (docs/results/mission.md).
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission.aircraft import NOISE_SD, Aircraft
from octmip.monitor import Series, Watch

Floats = NDArray[np.float64]
Told = tuple[bool, set[str]]
"""Whether damage was told, and the gauges that were named as faulty."""

N_READINGS = 100
LEAST = 10.0
DAMAGED, FAILED = (1, 2, 3, 4), (1, 2, 3)


def local_rows(aircraft: Aircraft, n: int, seed: int) -> Iterator[dict[str, object]]:
    """Yield one row for each number of damaged and of failed gauges: flights of n that each test gets right."""
    watch = aircraft.watch()
    alone = aircraft.watch()
    alone.neighbours[:] = False
    tests: dict[str, Callable[[Floats, Floats], Told]] = {
        "the watch": lambda readings, loads: _by_series(watch, readings, loads),
        "one gauge at a time": lambda readings, loads: _by_series(alone, readings, loads),
    }
    for what, counts in (("damaged", DAMAGED), ("failed", FAILED)):
        for count in counts:
            right = dict.fromkeys(tests, 0)
            for k in range(n):
                rng = np.random.default_rng([seed, what == "failed", count, k])
                readings, loads, gauges = _flight(aircraft, watch, rng, what, count)
                for name, test in tests.items():
                    is_damage, named = test(readings, loads)
                    single = what == "failed" or count == 1  # one gauge: the words say that either may be
                    right[name] += (not is_damage and named == gauges) if single else is_damage
            yield {"gauges": f"{count} {what}", **{name: f"{one} of {n}" for name, one in right.items()}, "seed": seed}


def _flight(
    aircraft: Aircraft, watch: Watch, rng: np.random.Generator, what: str, count: int
) -> tuple[Floats, Floats, set[str]]:
    """Return readings (n, n_gauges), loads (n,) and the names of the gauges that are damaged or fail."""
    library, places = watch.library, watch.places
    assert places is not None
    ends = rng.uniform(0.0, 0.3, 2) * np.arange(N_READINGS)[:, None] / N_READINGS
    loads = rng.choice([2.0, 3.0], N_READINGS) if rng.random() < 0.5 else np.full(N_READINGS, 3.0)
    strains = loads[:, None] * aircraft.strains(ends)
    readings = strains + rng.normal(0.0, NOISE_SD, strains.shape)
    while True:
        if what == "damaged":
            apart = np.linalg.norm(places - places[rng.integers(len(places))], axis=1)
            gauges = np.argsort(apart, kind="stable")[:count]
            changes = [_damage(rng, loads, gauges, strains.shape[1])]
        else:
            gauges = rng.choice(strains.shape[1], count, replace=False)
            changes = [_fault(rng, readings, gauge) for gauge in gauges.tolist()]
        if all(_distance(watch, change) >= LEAST for change in changes):
            return readings + sum(changes), loads, {library.gauges[gauge] for gauge in gauges.tolist()}


def _damage(rng: np.random.Generator, loads: Floats, gauges: NDArray[np.intp], n_gauges: int) -> Floats:
    """Return what damage adds to readings (n, n_gauges)."""
    size = NOISE_SD / 3.0 * np.exp(rng.uniform(np.log(1.5), np.log(10.0)))
    shape = np.zeros(n_gauges)
    shape[gauges] = size * rng.uniform(0.4, 1.0, len(gauges)) * rng.choice([-1.0, 1.0], len(gauges))
    return np.where(np.arange(len(loads)) >= rng.integers(10, 60), loads, 0.0)[:, None] * shape


def _fault(rng: np.random.Generator, readings: Floats, gauge: int) -> Floats:
    """Return what a gauge's failure adds to readings (n, n_gauges)."""
    start, kind = int(rng.integers(5, 70)), rng.integers(4)
    own = readings[start:, gauge]
    if kind == 0:
        wrong = own + rng.choice([-1.0, 1.0]) * NOISE_SD * np.exp(rng.uniform(np.log(2.0), np.log(30.0)))
    elif kind == 1:
        wrong = 0.0 * own
    elif kind == 2:
        wrong = own * (1.0 + rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.8))
    else:
        wrong = np.full(len(own), own[0])
    change = np.zeros_like(readings)
    change[start:, gauge] = wrong - own
    return change


def _distance(watch: Watch, change: Floats) -> float:
    """Return d of a change (n, n_gauges) of readings, in standard deviations."""
    every = np.ones(change.shape[1], dtype=bool)
    return float(np.linalg.norm(change / NOISE_SD @ watch.parity.projector(every)))


def _by_series(watch: Watch, readings: Floats, loads: Floats) -> Told:
    series, library = Series(watch), watch.library
    for row, load in zip(readings, loads.tolist(), strict=True):
        finding = series.observe(row, load)
        if finding is not None and finding.kind != "gauge":
            return True, set()
    return False, {library.gauges[gauge] for gauge in series.faulty}
