"""CPU seconds of a diagnosis: the first of a twin, which makes what it and its `CachedTwin` keep, and the same again.

Six fixed campaigns (50 readings at load factors 0 to 3, with a commissioning run): three states that the file gives,
three that it does not. The readings are the twin's own with one effect, an error per gauge and noise: how well a
diagnosis does is measured by `make blind`, here only how long it takes. Single-threaded; every kind of state starts
with a twin of its own, and each campaign is diagnosed again three times.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.tables import Line
from femlib.wing import WingTwin, uav_wing
from femlib.wing.effects import wing_effects
from octmip.gap import CachedTwin, Campaign, diagnose

DEFAULT = 1.0
"""Refinement of the twin's mesh."""
LOADS, REPEATS, NOISE_SD, OWN, INTERVAL = (0.0, 1.0, 2.0, 3.0), 50, np.sqrt(1000.0), 0.008, 6.0
AGAIN = 3
"""Diagnoses of a campaign after the first, whose median is reported."""


@dataclass(frozen=True, slots=True)
class Asked:
    """One campaign: the true damage, whether the file gives it, and one effect with its place and size."""

    state: tuple[float, float]
    is_known: bool
    effect: str
    place: str
    size: float


CAMPAIGNS = (
    Asked((0.0, 0.0), True, "temperature_gradient", "", 0.0),
    Asked((0.0, 0.0), True, "temperature_gradient", "", 6.0),
    Asked((0.25, 0.45), True, "payload_inertia", "eta 0.6", 0.2),
    Asked((0.25, 0.45), False, "torsion", "", 0.0),
    Asked((0.1, 0.7), False, "temperature_uniform", "", 15.0),
    Asked((0.35, 0.1), False, "lift_distribution", "shares of harmonics 5 and 7: 0 and 0", 5.0),
)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each kind of state's twin and each campaign."""
    with threadpool_limits(1):
        yield from measured(DEFAULT, CAMPAIGNS)


def measured(refinement: float, asked: Sequence[Asked], again: int = AGAIN) -> Iterator[Line]:
    """Yield the lines of the campaigns on one mesh, known states first."""
    for is_known in sorted({one.is_known for one in asked}, reverse=True):
        begin = time.process_time()
        twin = wing_twin(refinement)
        built = time.process_time() - begin
        cached = CachedTwin(twin)
        commissioning = campaign(twin, Asked((0.0, 0.0), True, "torsion", "", 0.0), seed=99)
        for seed, one in enumerate(asked):
            if one.is_known == is_known:
                line = _line(cached, one, campaign(twin, one, seed), commissioning, again)
                yield {"size": f"refinement {refinement:g}", "seed": seed, **line, "built_cpu_seconds": round(built, 2)}
                built = 0.0


def _line(twin: CachedTwin, one: Asked, readings: Campaign, commissioning: Campaign, again: int) -> Line:
    """Return the times of the first diagnosis and of the next ones."""
    spent = []
    for _ in range(1 + again):
        begin = time.process_time()
        found = diagnose(readings, twin, commissioning=commissioning)
        spent.append(time.process_time() - begin)
    return {
        "solver": "octmip.gap",
        "version": f"octmip {version('octmip')}",
        "outcome": "measured",
        "state": "known" if one.is_known else "unknown",
        "truth": f"{one.effect} {one.size:g}" if one.size else "none",
        "found": ", ".join(found.which[0].effects) or "none",
        "first_cpu_seconds": round(spent[0], 3),
        "again_cpu_seconds": round(float(np.median(spent[1:])), 3),
    }


def wing_twin(refinement: float) -> WingTwin:
    """Return a twin that has been asked nothing yet."""
    wing = uav_wing(refinement=refinement)
    return WingTwin(wing, wing_effects(wing))


def campaign(twin: WingTwin, one: Asked, seed: int) -> Campaign:
    """Return the readings of one test at all loads."""
    rng = np.random.default_rng(seed)
    state = dict(zip(twin.parameters, one.state, strict=True))
    own = 1.0 + OWN * np.random.default_rng(7).standard_normal(len(twin.gauges))  # of the asset: the same every time
    signature = twin.effects[one.effect].signature
    means = [own * twin.predict(state, load) + one.size * signature(twin, state, load, one.place) for load in LOADS]
    n = len(LOADS) * REPEATS
    return Campaign(
        gauges=twin.gauges,
        parameters=twin.parameters,
        test=("T0",) * n,
        load_factor=np.repeat(LOADS, REPEATS),
        states=np.tile(one.state if one.is_known else (np.nan, np.nan), (n, 1)),
        readings=np.repeat(means, REPEATS, axis=0) + NOISE_SD * rng.standard_normal((n, len(twin.gauges))),
        time=INTERVAL * np.arange(n, dtype=np.float64),
        temperature=np.full(n, np.nan),
    )


def summary(lines: Sequence[Line]) -> str:
    """Return the table: a row for each campaign."""
    rows = [
        "| state | truth | found | twin built, CPU s | first diagnosis, CPU s | again, CPU s |",
        "|---|---|---|---|---|---|",
    ]
    for line in lines:
        built = f"{line['built_cpu_seconds']:.1f}" if line["built_cpu_seconds"] else "kept"
        times = f"{line['first_cpu_seconds']:.2f} | {line['again_cpu_seconds']:.2f}"
        rows.append(f"| {line['state']} | {line['truth']} | {line['found']} | {built} | {times} |")
    return "\n".join(rows)
