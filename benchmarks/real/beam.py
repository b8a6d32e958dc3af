"""The steel beam on a clamp and one support: two frequencies of each decay say where the support is.

`python -m benchmarks.real.beam --data FOLDER` judges each stretch whose truth is told without itself. The twin is an
Euler-Bernoulli beam of cubic elements on a clamp that turns a little and on a pinned support, with the two sensors as
masses. Its modulus, clamp and masses are fitted to the commissioning and practice stretches.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.linalg import eigh
from scipy.optimize import least_squares
from scipy.signal import medfilt

from benchmarks.real.decay import decay_of
from femlib.arrays import FloatArray
from octmip.gap import Diagnosis, Odds, Recorded, diagnose, gathered
from octmip.gap.doors.function import FunctionTwin, function_twin
from octmip.twin import Loads

LENGTH, WIDTH, THICKNESS, DENSITY, SOUND = 0.501, 0.051, 0.00666, 7850.0, 48.0
"""[m], [m], [m], [kg/m^3], place of the support in the sound state [mm]."""
NO_LOAD = Loads((), ())
SENSORS = (0.34, 0.30)
"""Places of the accelerometers [m]."""
N_INSIDE, N_BEYOND = 6, 10
"""Elements between clamp and support, and beyond it."""
FIRST, SECOND = (15.0, 70.0), (145.0, 320.0)
"""Bands of the two frequencies [Hz]."""
PULSE = 6.0
"""Robust standard deviations from the running median beyond which a sample is a jump of the sensor."""
LOST = (0.03, 0.004)
"""Relative standard deviation of each frequency from which its peak is not that of a mode."""
RATE = 5000.0
"""Samples in a second."""
BEAT = (0.05, 0.04)
"""Error of the two frequencies in a stretch of one second [Hz]: the first beats with a neighbour some 0.6 Hz away."""
LEAST_SCATTER = (0.0015, 0.0015)
"""Relative scatter of the two frequencies from one stretch of the sound state to the next."""
MEND = 5
"""Samples of that median."""
TWIN_ERROR, LENGTH_SCALE = (0.009, 0.018), 40.0
"""Relative error of the twin's frequencies, and over which movement of the support it changes [mm]."""
SAME_SERIES = 0.4
"""Share of that error's variance that belongs to one series alone: the support was placed anew, weeks apart."""
PLACED = 0.02
"""Variance of what a told place teaches, over that of the twin's error: places are told in whole millimetres."""
LEAST = 1e-3
"""Probability that the truth has at least in the mean of logarithms."""
Causes = frozenset[str]
READINGS = {"log_f1": "1", "log_f2": "1"}
START = np.array([200.0, 4.0, 0.03, 0.01])
START_SD = np.array([15.0, 1.0, 0.03, 0.02])
"""Modulus [GPa], log10 of the clamp's stiffness [Nm/rad], masses of the sensors [kg]."""


def frequencies(modulus: float, clamp: float, masses: Sequence[float], support: float, length: float) -> FloatArray:
    """Return the first two frequencies [Hz] of a beam (modulus [Pa], clamp [Nm/rad], support from the clamp [m])."""
    nodes = np.concatenate([np.linspace(0.0, support, N_INSIDE + 1), np.linspace(support, length, N_BEYOND + 1)[1:]])
    stiffness, mass = np.zeros((2, 2 * len(nodes), 2 * len(nodes)))
    bending, line = modulus * WIDTH * THICKNESS**3 / 12.0, DENSITY * WIDTH * THICKNESS
    for k, h in enumerate(np.diff(nodes)):
        own = slice(2 * k, 2 * k + 4)
        turn = np.diag([1.0, h, 1.0, h])
        bent = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
        moved = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
        stiffness[own, own] += bending / h**3 * turn @ bent @ turn
        mass[own, own] += line * h / 420.0 * turn @ moved @ turn
        for place, extra in zip(SENSORS, masses, strict=True):
            if nodes[k] < place <= nodes[k + 1]:
                x = (place - nodes[k]) / h
                shape = turn @ [1 - 3 * x**2 + 2 * x**3, x * (1 - x) ** 2, x**2 * (3 - 2 * x), x**2 * (x - 1)]
                mass[own, own] += extra * np.outer(shape, shape)
    stiffness[1, 1] += clamp
    free = [k for k in range(2 * len(nodes)) if k not in (0, 2 * N_INSIDE)]
    squares = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True, subset_by_index=[0, 1])
    return np.asarray(np.sqrt(squares) / (2.0 * np.pi))


@cache
def _frequencies(modulus: float, clamp: float, light: float, heavy: float, support: float, length: float) -> FloatArray:
    return frequencies(modulus, clamp, (light, heavy), support, length)


def beam_twin(fitted: Sequence[float] = tuple(START)) -> FunctionTwin:
    """Return the twin in logarithms of the frequencies; `fitted` is modulus, clamp and masses as in `START`."""
    modulus, clamp, *masses = fitted

    def model(p: Mapping[str, float], _: Mapping[str, float]) -> FloatArray:
        stiff = modulus * 1e9 * (1.0 + p["stiffness"] / 100.0) * (1.0 - 4e-4 * p["temperature"])
        turning = 10.0**clamp * (1.0 - p["clamp_loose"] / 100.0)
        added = [*masses[:1], masses[1] + p["mass_added"] / 1000.0]
        place, length = (SOUND + p["support_moved"]) / 1000.0, LENGTH + p["free_length"] / 1000.0
        return np.log(_frequencies(stiff, turning, *added, place, length))

    ranges = {
        "support_moved": (0.0, -35.0, 240.0, "mm"), "mass_added": (0.0, 0.0, 200.0, "g"),
        "stiffness": (0.0, -20.0, 20.0, "%"), "free_length": (0.0, -20.0, 20.0, "mm"),
        "clamp_loose": (0.0, 0.0, 90.0, "%"), "temperature": (0.0, -20.0, 20.0, "K"),
    }  # fmt: skip
    return function_twin(model, READINGS, ranges, loads=())


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Logarithms of two frequencies of one stretch of record (2,) and their standard deviations (2,)."""

    case: str
    series: str
    log: FloatArray
    sd: FloatArray


def read_stretch(folder: Path, case: str, series: str) -> Stretch:
    """Return the two frequencies of a stretch: the low-g accelerometer's, jumps mended, hum and zero taken out."""
    table = pd.read_csv(folder / f"{case}.csv.gz")
    signal = table["acc_low"].to_numpy(dtype=float)
    rest = signal - medfilt(signal, MEND)
    jumps = np.abs(rest) > PULSE * 1.4826 * max(float(np.median(np.abs(rest))), 1e-6)
    signal = np.where(jumps, medfilt(signal, MEND), signal)
    found = decay_of(table["time"], signal, [FIRST, SECOND], hum=[60.0, 120.0, 180.0, 240.0], zero_degree=3)
    log, sd = np.log(found.frequencies), found.frequency_sd / found.frequencies
    beat = np.array(BEAT) / (len(signal) / RATE) / found.frequencies
    return Stretch(case, series, np.where(sd < np.array(LOST), log, np.nan), np.hypot(sd, beat))


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What commissioning and practice teach.

    Attributes
    ----------
    twin
        fitted.
    tests
        (2,) logarithms of the frequencies of each stretch of the sound state.
    moved, series, missed
        movements of the support that were told (m,) [mm], in which series, and what the twin's change misses
        there (m, 2).
    """

    twin: FunctionTwin
    tests: tuple[FloatArray, ...]
    moved: FloatArray
    series: tuple[str, ...]
    missed: FloatArray

    @property
    def sound(self) -> FloatArray:
        """(2,) their medians."""
        return np.asarray(np.nanmedian(self.tests, axis=0))

    def correction(self, moved: float, series: str) -> tuple[FloatArray, FloatArray]:
        """Return what the twin's change misses at a movement (2,) and its standard deviation: a Gaussian process.

        It is 0 in the sound state, where the readings are known.
        """
        at = np.array([0.0, 0.0, *self.moved, moved])
        own = np.array(["R", "S", *self.series, series])
        told = np.concatenate([np.zeros((2, 2)), self.missed])
        kernel = np.exp(-0.5 * ((at[:, None] - at) / LENGTH_SCALE) ** 2)
        kernel *= 1.0 - SAME_SERIES + SAME_SERIES * (own[:, None] == own)
        here, kernel = kernel[:-1, -1], kernel[:-1, :-1] + PLACED * np.eye(len(at) - 1)
        gain = np.linalg.solve(kernel, here)
        left = max(1.0 - float(gain @ here), 0.0)
        return gain @ told, np.array(TWIN_ERROR) * np.sqrt(left)

    def twin_in(self, series: str) -> FunctionTwin:
        """Return the twin with what it is known to miss in a series of places."""

        def model(p: Mapping[str, float], loads: Mapping[str, float]) -> FloatArray:
            return np.asarray(self.twin.function(p, loads) + self.correction(p["support_moved"], series)[0])

        return function_twin(model, READINGS, self.twin.card.ranges, loads=())


def learn(sound: Sequence[Stretch], told: Sequence[tuple[float, Stretch]]) -> Knowledge:
    """Return the twin fitted to sound stretches and to movements [mm] that were told, and how it misses them."""
    mean = np.nanmedian([one.log for one in sound], axis=0)
    anchors = [(0.0, mean), *((moved, one.log) for moved, one in told)]

    def misfit(fitted: FloatArray) -> FloatArray:
        twin = beam_twin(fitted.tolist())
        rest = [(twin.ask({}, NO_LOAD, {"support_moved": moved}) - log) / TWIN_ERROR for moved, log in anchors]
        return np.concatenate([np.nan_to_num(np.ravel(rest)), (fitted - START) / START_SD])

    twin = beam_twin(tuple(least_squares(misfit, START, x_scale=START_SD, diff_step=[1e-4]).x))
    own = [twin.ask({}, NO_LOAD, {"support_moved": moved}) for moved, _ in anchors]
    missed = [(log - mean) - (there - own[0]) for there, (_, log) in zip(own[1:], anchors[1:], strict=True)]
    return Knowledge(
        twin,
        tuple(one.log for one in sound),
        np.array([m for m, _ in told]),
        tuple(one.series for _, one in told),
        np.nan_to_num(missed).reshape(-1, 2),
    )


COMMON = 134.0
"""How many times as probable it is that the support has moved as anything else."""
ODDS = Odds((0.30, 0.45, 0.20), (0.03, 0.01, 0.002), effects={"support_moved": COMMON})
"""Of no, one and two effects; of something unknown alone and beside one or two."""
KNOWN_TO = (0.03, 0.06)
"""Relative error of what the support changes in each frequency: the twin is corrected at places that were told."""


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """The effect of a support that has moved, known as well as the told places say."""

    own: Any

    signature_error = KNOWN_TO

    def __getattr__(self, name: str) -> Any:
        return getattr(self.own, name)


def diagnosis_of(stretch: Stretch, known: Knowledge) -> Diagnosis:
    """Return what the two frequencies of a stretch say; each stretch of the sound state is a test of the run."""
    twin = known.twin_in(stretch.series)
    noise = np.hypot(LEAST_SCATTER, np.nan_to_num(stretch.sd, posinf=1.0)).tolist()
    effects = {**twin.effects, "support_moved": Placed(twin.effects["support_moved"])}
    run = gathered(twin, [Recorded(one, {}, f"sound_{k}") for k, one in enumerate(known.tests)])
    named = dict(zip(twin.gauges, noise, strict=True))
    return diagnose(gathered(twin, [Recorded(stretch.log)]), twin, effects, run, noise_sd=named, odds=ODDS)


def shares_of(found: Diagnosis) -> dict[Causes, float]:
    """Return the probability of each set of causes."""
    shares: dict[Causes, float] = {}
    for one in found.posterior.judged:
        causes = frozenset({"unknown"} if one.has_unknown else one.effects)
        shares[causes] = shares.get(causes, 0.0) + one.probability
    return shares


def learn_from(folder: Path, stretches: Mapping[str, Stretch], without: str = "") -> Knowledge:
    """Return what commissioning and practice teach, one stretch left out."""
    tests = pd.read_csv(folder / "tests.csv").set_index("segment")
    practice = pd.read_csv(folder / "practice.csv").set_index("segment")
    sound = [stretches[case] for case in tests.index[tests.role == "commissioning"] if case != without]
    told = [
        (float(str(row.detail).split(" mm")[0]), stretches[str(case)])
        for case, row in practice.iterrows()
        if row.condition == "support_moved" and case != without
    ]
    return learn(sound, told)


def told_stretches(folder: Path) -> Iterator[tuple[str, Causes, Diagnosis]]:
    """Yield every practice and commissioning stretch, what acted, and its diagnosis without itself."""
    tests = pd.read_csv(folder / "tests.csv", index_col="segment")
    practice = pd.read_csv(folder / "practice.csv", index_col="segment")
    chosen = tests[tests.role != "blind"]
    stretches = {str(case): read_stretch(folder, str(case), str(one)) for case, one in chosen.series.items()}
    for case, stretch in stretches.items():
        acted = case in practice.index and practice.condition[case] != "sound"
        truth = frozenset({"support_moved"} if acted else ())
        yield case, truth, diagnosis_of(stretch, learn_from(folder, stretches, case))


def summary(told: Sequence[tuple[Causes, Mapping[Causes, float]]]) -> str:
    """Return how many first causes are the truth, and the mean log probability of the truth."""
    right = sum(max(shares, key=lambda causes: shares[causes]) == truth for truth, shares in told)
    log = np.mean([np.log(max(shares.get(truth, 0.0), LEAST)) for truth, shares in told])
    return f"the truth is first in {right} of {len(told)}, its mean log probability {log:.2f}"


def folder_asked(parser: argparse.ArgumentParser, table: str) -> Path:
    """Return the folder of a set by the option --data; one without the table ends the command with a sentence."""
    parser.add_argument("--data", type=Path, required=True, help="folder of the set")
    folder = Path(parser.parse_args().data)
    if not (folder / table).is_file():
        parser.error(f"--data is {folder}, which holds no {table}; expected the folder of the set")
    return folder


def main() -> None:
    """Print a line for each stretch that is told, then what all sum to."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.beam", description=__doc__)
    folder = folder_asked(parser, "tests.csv")
    told = []
    for case, truth, found in told_stretches(folder):
        shares = shares_of(found)
        sizes = ", ".join(f"{p.size:.1f} ({p.low:.1f} to {p.high:.1f}) {p.unit}" for p in found.which[0].parameters)
        print(f"{case} {', '.join(truth) or 'sound'}: {shares.get(truth, 0.0):.3f} {sizes}")
        told.append((truth, shares))
    print(summary(told))


if __name__ == "__main__":
    main()
