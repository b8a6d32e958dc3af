"""A friction damper through the diagnosis: cycles reduced to phase means, a twin of one line, effects as parameters.

A drum is held by a band in tension; turning it costs a friction force that grows with the tension at the tight end. The
simplest twin says force = lever times tension times the sign of the velocity. Each parameter beside the lever is what
it may lack. A test is a cell of the campaign: frequency, amplitude and tensions are its loads, its cycles the repeats.

`python -m benchmarks.real.damper --data ../shared/damper` prints what each series says.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray
from octmip.gap import Diagnosis, Differences, FunctionTwin, Odds, Recorded, diagnose, function_twin, gathered

PARTS, FINE = 24, 20
"""Parts of a cycle, and points of the twin in each."""
WHOLE = 0.8
"""Share of the longest stroke from which a cycle is whole: the ramps at both ends of a test are left out."""
SLIPPING = slice(PARTS // 4, PARTS // 2 - 1)
"""Parts of a half cycle in which the drum slips for certain."""
LEVER = 2.0
"""Force by tension of the tight end [kip / 1000 lb]: the rig's."""
NEVER = 1e-3
"""Width of the step of the friction of the simplest twin [in]."""
HARDENING = 3.0
"""Power of the displacement with which the band takes hold."""
LOADS = ("frequency", "amplitude", "tension_forward", "tension_back")
DIFFERENCES = Differences(common=0.05, smooth=0.05, own=0.05, floor=0.05, constant=0.03, cell=0.1)
"""How far one line of friction is from a band: a tenth of the force in each part of each test by itself."""
READINGS = {f"force_{part:02d}": "kip" for part in range(PARTS)}
LEAST = 0.02
"""Probability from which a cause is printed."""
PARAMETERS = {
    "lever": (LEVER, 1.0, 3.0, "kip per 1000 lb"),
    "backlash": (0.0, 0.0, 0.6, "in"),
    "wind_up": (0.0, 0.0, 0.3, "in/kip"),
    "lag": (0.0, 0.0, 0.1, "s"),
    "speed": (0.0, -0.2, 0.2, "s/in"),
    "centring": (0.0, -5.0, 5.0, "kip/in"),
    "inertia": (0.0, -0.05, 0.05, "kip s2/in"),
    "force_zero": (0.0, -2.0, 2.0, "kip"),
}
"""Nominal, lowest, highest and unit: only the lever is there in the simplest twin."""


def force(parameters: Mapping[str, float], loads: Mapping[str, float]) -> FloatArray:
    """Return the mean force in each part of a cycle (PARTS,) [kip] that begins at the lowest displacement."""
    rate, amplitude = 2.0 * np.pi * loads["frequency"], loads["amplitude"]
    phase = (np.arange(PARTS * FINE) + 0.5) / (PARTS * FINE) - parameters["lag"] * loads["frequency"]
    angle, half = 2.0 * np.pi * phase, np.floor(2.0 * phase) % 2
    since = amplitude * (1.0 - np.cos(angle % np.pi))
    tension = np.where(half == 0, loads["tension_forward"], -loads["tension_back"]) / 1000.0
    length = parameters["wind_up"] * parameters["lever"] * np.abs(tension) + NEVER
    taken = np.clip((since - parameters["backlash"]) / length, 0.0, 1.0) ** HARDENING
    position, velocity = -amplitude * np.cos(angle), amplitude * rate * np.sin(angle)
    found = parameters["lever"] * tension * taken * (1.0 + parameters["speed"] * np.abs(velocity))
    found += parameters["centring"] * position - parameters["inertia"] * rate**2 * position + parameters["force_zero"]
    return np.asarray(found.reshape(PARTS, FINE).mean(axis=1))


def damper_twin() -> FunctionTwin:
    """Return the simplest twin, with what it may lack as parameters."""
    return function_twin(force, READINGS, PARAMETERS, LOADS)


def phase_means(time: FloatArray, signal: FloatArray, period: float, start: float) -> FloatArray:
    """Return the mean of a signal over each part of each whole cycle (n_cycles, PARTS); `start` [s] of the first."""
    count = int(np.floor((time[-1] - start + np.median(np.diff(time))) / period + 1e-6))
    part = np.floor((time - start) / period * PARTS + 1e-9).astype(int)
    used = (part >= 0) & (part < count * PARTS)
    return np.asarray(np.bincount(part[used], signal[used]) / np.bincount(part[used])).reshape(count, PARTS)


def read_test(folder: Path, name: str, frequency: float) -> Recorded:
    """Return the whole cycles of a test as rows, and its loads."""
    table = pd.read_csv(folder / f"{name}.csv")
    time = table["time_s"].to_numpy(dtype=float)
    place = table["displacement_in"].to_numpy(dtype=float)
    period = 1.0 / frequency
    middle = np.abs(time - time.mean()) < period * max(1, round(0.25 * np.ptp(time) / period))
    angle = np.angle(np.exp(-2j * np.pi * frequency * time[middle]) @ place[middle])
    start = time[0] + ((0.5 - angle / (2.0 * np.pi)) / frequency - time[0]) % period
    columns = ("displacement_in", "force_kip", "tension_a_lb", "tension_b_lb")
    moved, forces, one, other = (
        phase_means(time, table[name].to_numpy(dtype=float), period, start) for name in columns
    )
    stroke = np.ptp(moved, axis=1)
    whole = stroke > WHOLE * stroke.max()
    moved, forces, one, other = (each[whole] for each in (moved, forces, one, other))
    sign = np.sign(forces[:, SLIPPING].mean())
    halves = [SLIPPING, slice(SLIPPING.start + PARTS // 2, SLIPPING.stop + PARTS // 2)]
    forward, back = (max(end[:, half].mean() for end in (one, other)) for half in halves)
    loads = (frequency, float(np.ptp(moved, axis=1).mean() / 2.0 / np.sinc(2.0 / PARTS)), float(forward), float(back))
    return Recorded(sign * forces, dict(zip(LOADS, loads, strict=True)), name)


def read_series(folder: Path) -> dict[str, list[Recorded]]:
    """Return the tests of each series."""
    found: dict[str, list[Recorded]] = {}
    for row in pd.read_csv(folder / "tests.csv").itertuples():
        found.setdefault(str(row.series), []).append(read_test(folder, str(row.test), float(str(row.frequency_hz))))
    return found


def diagnosed(tests: Sequence[Recorded], twin: FunctionTwin) -> Diagnosis:
    """Return what the simplest twin lacks, by the tests of a series."""
    return diagnose(gathered(twin, tests), twin, effects=twin.effects, odds=Odds(differences=DIFFERENCES))


def said(diagnosis: Diagnosis) -> list[str]:
    """Return the causes with sizes and 90 % intervals, and how far the first one closes the gap, as sentences."""
    lines = []
    for cause in diagnosis.which:
        if cause.probability < LEAST:
            continue
        sizes = [f"{p.effect} {p.size:.3f} {p.unit} ({p.low:.3f} to {p.high:.3f})" for p in cause.parameters]
        named = sizes + [name for name in cause.effects if name not in {p.effect for p in cause.parameters}]
        lines.append(f"{cause.probability:.2f}: {', '.join(named) or 'nothing'}")
    if diagnosis.shrinkage is not None:
        lines.append(f"closed on held-out tests: {diagnosis.shrinkage.closed:.3f} of the square")
    return lines


def main() -> None:
    """Print what each series of a folder says."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.damper", description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="tests.csv and one CSV a test")
    twin = damper_twin()
    for series, tests in read_series(parser.parse_args().data).items():
        print(f"{series}: {len(tests)} tests")
        for line in said(diagnosed(tests, twin)):
            print(f"  {line}")


if __name__ == "__main__":
    main()
