"""A test bridge over one day: the level of a strain gauge and of two load cells say in which state a stretch ends.

The twin is linear: the sound course plus what is added. What one step of the support changes is not in commissioning.
Its strain is the size of the jumps within the records, which no temperature makes in minutes. Its forces are fitted to
the stretches with vehicle. So this is a demonstration.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real.answer import Answer
from benchmarks.real.evidence import Hypothesis, Named, Reference, judge
from femlib.arrays import FloatArray
from octmip.gap.doors.function import FunctionTwin, function_twin
from octmip.twin import Loads

NO_LOAD = Loads((), ())
CHANNELS = ("strain", "force_1", "force_2")
UNITS = {"strain": "um/m", "force_1": "kN", "force_2": "kN"}
STEP = np.array([30.0, -21.0, -40.0])
"""What one step of the support changes."""
PER_KELVIN = np.array([2.8, 0.0, 0.0])
"""What a kelvin of the girder changes: the strain between stretches in which nothing moved."""
LAG = 0.8
"""Warming of the girder over that of the air since the sound state: it is not as warm, and lags."""
END, EARLY = 60.0, (150.0, 220.0)
"""Last stretch of a record, and one in which the vehicle stands [s]."""
WITH_VEHICLE = (2.0, 2.5, 2.5)
"""Scatter of the sound levels from one course of the vehicle to the next: as far as they move within one."""
PRIORS = {
    (): 0.25, ("temperature",): 0.10, ("support_lowered",): 0.2, ("support_lowered", "temperature"): 0.3,
    ("support_raised", "temperature"): 0.06, ("support_raised",): 0.04, ("strain_zero",): 0.02, ("strain_drift",): 0.02,
    ("load_cell_zero",): 0.01, ("mass_added",): 0.01, ("stiffness",): 0.01,
}  # fmt: skip
"""Probability of causes before any reading; that both bearings lose force says lowered rather than raised, 5 : 1."""


def bridge_twin(sound: FloatArray, hours: float) -> FunctionTwin:
    """Return the twin of the last minute of a record that ends so many hours after the sound one."""

    def model(p: Mapping[str, float], _: Mapping[str, float]) -> FloatArray:
        moved = STEP * (p["support_lowered"] + p["support_raised"]) + PER_KELVIN * p["temperature"]
        chain = np.array([p["strain_zero"] + hours * p["strain_drift"], p["load_cell_zero"], p["load_cell_zero"]])
        weight = np.array([0.0, 0.25, 0.25]) * p["mass_added"]
        stiff = 1.0 - np.array([p["stiffness"] / 100.0, 0.0, 0.0])
        return np.asarray((sound + moved + weight) * stiff + chain)

    ranges = {
        "support_lowered": (0.0, 0.0, 6.0, "steps"), "support_raised": (0.0, 0.0, 6.0, "steps"),
        "temperature": (0.0, -20.0, 30.0, "K"), "strain_zero": (0.0, -60.0, 60.0, "um/m"),
        "strain_drift": (0.0, -10.0, 10.0, "um/m per h"), "load_cell_zero": (0.0, -60.0, 60.0, "kN"),
        "mass_added": (0.0, 0.0, 100.0, "kN"), "stiffness": (0.0, -20.0, 20.0, "%"),
    }  # fmt: skip
    return function_twin(model, UNITS, ranges, loads=())


PLACES = {
    "support_lowered": "support", "support_raised": "support", "load_cell_zero": "both", "strain_zero": "strain",
    "strain_drift": "strain",
}  # fmt: skip
SIZES = {
    "support_lowered": (1.5, 1.0), "support_raised": (1.5, 1.0), "strain_zero": (0.0, 10.0), "strain_drift": (0.0, 2.0),
    "load_cell_zero": (0.0, 10.0), "mass_added": (10.0, 10.0), "stiffness": (0.0, 5.0),
}  # fmt: skip
"""Mean and standard deviation of a size."""
ERROR = 0.1
"""Relative error of what a cause changes."""


def levels(folder: Path, case: str, begin: float | None = None, end: float | None = None) -> tuple[FloatArray, float]:
    """Return the mean of each channel (3,) in a stretch, its last minute if none is given, and the air temperature."""
    table = pd.read_csv(folder / f"{case}.csv.gz")
    time = table["time"].to_numpy(dtype=float)
    within = (time >= (time[-1] - END if begin is None else begin)) & (time <= (time[-1] if end is None else end))
    means = [
        float(table[name][within].mean()) if name in table and table[name].notna().all() else np.nan
        for name in (*CHANNELS, "air_temperature")
    ]
    return np.array(means[:3]), float(means[3])


def hypotheses(twin: FunctionTwin, warmer: float) -> list[Hypothesis]:
    """Return causes alone and together; the temperature is expected to follow the air, `warmer` [K] than when sound."""
    zero = np.zeros(3)

    def change(sizes: FloatArray, kinds: tuple[str, ...]) -> FloatArray:
        return twin.ask({}, NO_LOAD, dict(zip(kinds, sizes.tolist(), strict=True))) - twin.ask({}, NO_LOAD, {})

    sizes = {**SIZES, "temperature": (LAG * warmer, 1.0 + 0.25 * abs(warmer))}
    found = []
    for kinds, prior in PRIORS.items():
        causes = tuple(Named(kind, PLACES.get(kind, "bridge"), twin.card.ranges[kind].unit) for kind in kinds)
        mean, sd = np.array([sizes[kind] for kind in kinds]).reshape(-1, 2).T
        signed = not any(kind.startswith(("support", "mass")) for kind in kinds)
        found.append(Hypothesis(causes, partial(change, kinds=kinds), mean, sd, prior, ERROR, zero, zero, signed))
    return found


def answer(folder: Path, case: str, hours: float, sound_case: str) -> Answer:
    """Return what a record says of the state in which it ends."""
    sound, cold = levels(folder, sound_case)
    readings, air = levels(folder, case)
    references = [Reference(sound, np.diag(np.square(WITH_VEHICLE)), 1.0)]
    judged = judge(readings, references, hypotheses(bridge_twin(sound, hours), air - cold))
    closed = None
    first = judged[0].hypothesis
    if first.causes and np.isfinite(readings).all():
        early, early_sound = (levels(folder, name, *EARLY)[0] for name in (case, sound_case))
        alone = judge(early - early_sound + sound, references, [first])[0]
        gap, change = readings - sound, first.change(alone.sizes[:, 0])
        closed = max(0.0, 1.0 - float(np.sum((gap - change) ** 2) / np.sum(gap**2)))
    note = "closed: strain and forces of the last minute, with sizes from a minute in which the vehicle stands"
    return Answer(case, tuple(judged), closed, note if closed is not None else "")


def answers(folder: Path) -> list[Answer]:
    """Return the answer of every blind record."""
    tests = pd.read_csv(folder / "tests.csv")
    clock = pd.to_timedelta(tests["clock"] + ":00").dt.total_seconds().to_numpy() / 3600.0
    sound = int(np.flatnonzero(tests["role"] == "commissioning")[0])
    return [
        answer(folder, str(case), float(hour - clock[sound]), str(tests["case"][sound]))
        for case, hour, role in zip(tests["case"], clock, tests["role"], strict=True) if role == "blind"
    ]  # fmt: skip
