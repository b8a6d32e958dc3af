"""The steel beam on a clamp and one support: two frequencies of each decay say where the support is.

The twin is an Euler-Bernoulli beam of cubic elements on a clamp that turns a little and on a pinned support, with the
two sensors as masses. Its modulus, clamp and masses are fitted to the commissioning and practice stretches.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.linalg import eigh
from scipy.optimize import least_squares
from scipy.signal import medfilt

from benchmarks.real.answer import Answer
from benchmarks.real.evidence import Hypothesis, Named, Reference, judge
from femlib.arrays import FloatArray
from octmip.gap.doors.function import FunctionTwin, function_twin
from octmip.gap.reductions.decay import decay_of
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
    return function_twin(model, {"log_f1": "1", "log_f2": "1"}, ranges, loads=())


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
    sound
        (2,) logarithms of the frequencies of the sound state.
    scatter
        (2, 2) covariance of a test of the sound state about it.
    moved, series, missed
        movements of the support that were told (m,) [mm], in which series, and what the twin's change misses
        there (m, 2).
    """

    twin: FunctionTwin
    sound: FloatArray
    scatter: FloatArray
    moved: FloatArray
    series: tuple[str, ...]
    missed: FloatArray

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

    def change(self, sizes: FloatArray, parameter: str, series: str) -> FloatArray:
        """Return what a parameter changes of the logarithms of the frequencies (2,)."""
        allowed = self.twin.card.ranges[parameter]
        size = float(np.clip(sizes[0], allowed.low, allowed.high))
        own = self.twin.ask({}, NO_LOAD, {parameter: size}) - self.twin.ask({}, NO_LOAD, {})
        return own + self.correction(size, series)[0] if parameter == "support_moved" else own


def learn(sound: Sequence[Stretch], told: Sequence[tuple[float, Stretch]]) -> Knowledge:
    """Return the twin fitted to sound stretches and to movements [mm] that were told, and how it misses them."""
    logs = np.array([one.log for one in sound])
    mean = np.nanmedian(logs, axis=0)
    own = np.nanmean((logs - mean) ** 2, axis=0) * len(logs) / (len(logs) - 1)
    scatter = np.diag(np.maximum(own, np.square(LEAST_SCATTER)))
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
        mean,
        scatter,
        np.array([m for m, _ in told]),
        tuple(one.series for _, one in told),
        np.nan_to_num(missed).reshape(-1, 2),
    )


PRIORS = {
    "support_moved": ("support", 0.0, 60.0, 0.67), "stiffness": ("beam", 0.0, 3.0, 0.005),
    "free_length": ("beam", 0.0, 3.0, 0.005), "temperature": ("beam", 0.0, 5.0, 0.005),
    "mass_added": (f"{SENSORS[1] * 1000:.0f}", 20.0, 20.0, 0.005), "clamp_loose": ("clamp", 10.0, 15.0, 0.005),
}  # fmt: skip
"""Place, mean and standard deviation of the size, probability."""
SOUND_PRIOR, UNKNOWN_PRIOR, UNKNOWN_SD, OTHER_ERROR = 0.30, 0.005, 0.1, 0.1


def hypotheses(known: Knowledge, series: str) -> list[Hypothesis]:
    """Return no cause, each cause alone, and something unknown."""
    none, zero, two = np.zeros(0), np.zeros(2), np.zeros(2)
    found = [Hypothesis((), lambda _: zero, none, none, SOUND_PRIOR, 0.0, zero, zero)]
    for kind, (place, mean, sd, prior) in PRIORS.items():
        unit = known.twin.card.ranges[kind].unit
        error = (lambda s: known.correction(float(s[0]), series)[1]) if kind == "support_moved" else OTHER_ERROR
        found.append(
            Hypothesis(
                (Named(kind, place, unit),), partial(known.change, parameter=kind, series=series), np.array([mean]),
                np.array([sd]), prior, error, zero, zero, is_signed=mean == 0.0,
            )
        )  # fmt: skip
    unknown = (Named("unknown", "", ""),)
    spread = np.full(2, UNKNOWN_SD)
    return [*found, Hypothesis(unknown, lambda s: s, two, spread, UNKNOWN_PRIOR, 0.0, zero, zero, is_signed=True)]


def answer(stretch: Stretch, known: Knowledge) -> Answer:
    """Return what a stretch says, and how far its first cause, sized by one frequency, closes the gap of the other."""
    reference = Reference(known.sound, known.scatter + np.diag(np.nan_to_num(stretch.sd, posinf=1.0) ** 2), 1.0)
    judged = judge(stretch.log, [reference], hypotheses(known, stretch.series))
    closed = None
    if judged[0].hypothesis.causes and np.isfinite(stretch.log).all():
        alone = judge(np.array([stretch.log[0], np.nan]), [reference], [judged[0].hypothesis])[0]
        change = judged[0].hypothesis.change(alone.sizes[:, 0])[1]
        gap = float(stretch.log[1] - known.sound[1])
        closed = max(0.0, 1.0 - (gap - float(change)) ** 2 / gap**2)
    return Answer(stretch.case, tuple(judged), closed, "closed: the second frequency, with the size from the first")


def knowledge_of(folder: Path, without: str = "") -> tuple[Knowledge, list[Stretch]]:
    """Return what commissioning and practice teach, one stretch left out, and all stretches."""
    tests = pd.read_csv(folder / "tests.csv")
    stretches = {
        case: read_stretch(folder, case, series) for case, series in zip(tests.segment, tests.series, strict=True)
    }
    return learn_from(folder, stretches, without), list(stretches.values())


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


def answers(folder: Path) -> list[Answer]:
    """Return the answer of every blind stretch."""
    known, stretches = knowledge_of(folder)
    tests = pd.read_csv(folder / "tests.csv").set_index("segment")
    return [answer(one, known) for one in stretches if tests.role[one.case] == "blind"]
