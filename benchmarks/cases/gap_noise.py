"""False alarms of sound assets by kind of noise.

The asset is a beam whose 20 gauges differ from the twin by some per cent, always the same; campaign and commissioning
run (50 readings at load factors 0 to 3) are drawn anew each time, both with the same kind of noise. An alarm is a first
cause that names something.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.noises import VARIANCE, Scatter, heavy, heteroscedastic, outliers, serial, steps, walk, white
from benchmarks.tables import Line, markdown
from femlib.arrays import FloatArray
from octmip.gap import Campaign, diagnose
from octmip.twin import Effect, State

DRAWS = 100
LOADS, REPEATS, N_GAUGES = (0.0, 1.0, 2.0, 3.0), 50, 20
ALONG = np.linspace(0.2, 0.8, N_GAUGES)
HEALTHY = 900.0 * (1.0 - ALONG) ** 1.5 + 100.0
OWN = 1.0 + 0.01 * (0.5 + np.random.default_rng(12345).standard_normal(N_GAUGES))
"""What each gauge of the asset shows of the twin's healthy strain."""
SD = float(np.sqrt(VARIANCE))
SLOW, FAST, FAR, STEP, JUMP = 0.022, 0.3, 10.0, 0.5, 6.0
"""Steps of a slow and a fast walk, distance of outliers, height of steps up and down and of the one jump of one gauge,
in standard deviations of a reading."""


@dataclass(frozen=True, slots=True)
class Beam:
    """The twin: strains over the span, and one damage at the root."""

    gauges: tuple[str, ...] = tuple(f"g{k + 1:02d}" for k in range(N_GAUGES))
    parameters: tuple[str, ...] = ("root",)
    effects: dict[str, Effect] = field(default_factory=dict)

    def predict(self, state: State, load_factor: float) -> FloatArray:
        """Return the strains (n_gauges,) [microstrain]."""
        damaged = 300.0 * np.exp(-(((ALONG - 0.25) / 0.1) ** 2)) * state.get("root", 0.0)
        return load_factor * (HEALTHY + damaged)


def _common(rho: float) -> Scatter:
    def draw(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
        return np.asarray((white(rng, loads, n) + serial(rho)(rng, loads, 1)) / np.sqrt(2.0))

    return draw


def _jump(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    noise = white(rng, loads, n)
    noise[rng.integers(len(loads)) :, rng.integers(n)] += JUMP * SD
    return noise


KINDS: dict[str, Scatter] = {
    "white": white,
    "AR(1) 0.3": serial(0.3),
    "AR(1) 0.5": serial(0.5),
    "AR(1) 0.7": serial(0.7),
    "AR(1) 0.85": serial(0.85),
    "common mode": _common(0.0),
    "common mode, AR(1) 0.85": _common(0.85),
    "random walk, slow": walk(SLOW * SD),
    "random walk, fast": walk(FAST * SD),
    "one-sided outliers": outliers(FAR * SD),
    "steps up and down": steps(STEP * SD),
    "one jump": _jump,
    "heavy tails": heavy,
    "heteroscedastic": heteroscedastic,
}


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each kind of noise."""
    for kind in KINDS:
        yield alarms(kind, DRAWS)


def alarms(kind: str, draws: int) -> Line:
    """Return how many of so many sound assets are accused under a kind of noise."""
    watch, accused = Stopwatch(), 0
    for seed in range(draws):
        campaign, run = drawn(kind, 2 * seed), drawn(kind, 2 * seed + 1)
        accused += bool(diagnose(campaign, Beam(), commissioning=run).which[0].effects)
    return {"size": kind, "seed": draws, "cpu_seconds": watch.read()[0], "alarms": accused / draws}


def drawn(kind: str, seed: int) -> Campaign:
    """Return a campaign of the sound asset."""
    rng = np.random.default_rng(seed)
    load = np.repeat(LOADS, REPEATS)
    n, twin = len(load), Beam()
    mean = OWN * np.array([twin.predict({}, value) for value in load.tolist()])
    return Campaign(
        gauges=twin.gauges,
        parameters=twin.parameters,
        test=("T0",) * n,
        load_factor=load,
        states=np.zeros((n, 1)),
        readings=mean + KINDS[kind](rng, load, N_GAUGES),
        time=6.0 * np.arange(n, dtype=np.float64),
        temperature=np.full(n, np.nan),
    )


def summary(lines: Sequence[Line]) -> str:
    """Return the share of false alarms by kind of noise."""
    return markdown(["noise", "false alarms"], [(line["size"], f"{line['alarms']:.2f}") for line in lines])
