"""Cases: drawn from a seed, measured on an asset, written as a test engineer would write them."""

import csv
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.blind.assets.asset import PARAMETERS, Asset
from benchmarks.blind.assets.changes import change
from benchmarks.blind.assets.moment import Moment, State
from benchmarks.blind.truths import SINGLES, TRACELESS, Truth, draw, draw_channel, draw_outside, in_order
from femlib.arrays import FloatArray

REPEATS, VARIANCE, INTERVAL = 50, 1000.0, 6.0
ALL_LOADS = (0.0, 1.0, 2.0, 3.0)
FEWER_LOADS = ((3.0,), (0.0, 3.0), (1.0, 2.0, 3.0))
SHARES = {
    "none": 0.15, "noise": 0.15, "single": 0.17, "single, damaged": 0.10, "single, unknown state": 0.12,
    "pair": 0.14, "outside": 0.14, "channel": 0.03,
}  # fmt: skip
NOISES = ("correlated", "correlated", "correlated", "heavy", "heteroscedastic", "quantised")
STEP = 40.0
"""Step of a coarse converter [microstrain]."""
CONFOUNDED = {"modulus", "load_factor_error", "common_gain"}
"""Exactly confounded: two of them are one effect to any gauge, so no pair holds two."""


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes
    ----------
    name
        file name without ending.
    stratum
        of `SHARES`.
    truths
        what is wrong.
    states
        one test for each, mu1 and mu2.
    is_known
        whether the file gives the states.
    loads
        load factors of every test.
    noise
        "white" or one of `NOISES`.
    family
        of the asset.
    """

    name: str
    stratum: str
    truths: tuple[Truth, ...]
    states: tuple[State, ...]
    is_known: bool
    loads: tuple[float, ...]
    noise: str
    family: str

    @property
    def cells(self) -> list[tuple[int, State, float]]:
        """Every test's number and state with every load, in the order of measurement."""
        return [(number, state, load) for number, state in enumerate(self.states) for load in self.loads]


def draw_cases(seed: int, count: int, assets: Sequence[Asset]) -> list[Case]:
    """Return about `count` cases: strata in their shares (at least one each), the assets in turn."""
    rng = np.random.default_rng([seed, 1])
    strata = [s for s, share in SHARES.items() for _ in range(max(1, round(share * count)))]
    rng.shuffle(strata)
    return [_draw_case(f"case{k:04d}", stratum, rng, assets[k % len(assets)]) for k, stratum in enumerate(strata)]


def _draw_case(name: str, stratum: str, rng: np.random.Generator, asset: Asset) -> Case:
    truths = _draw_truths(stratum, rng, asset)
    damaged = asset.states[1 + int(rng.integers(len(asset.states) - 1))]
    states: tuple[State, ...] = (asset.states[0],)
    known = True
    if stratum == "single, damaged":
        states = (asset.states[0], damaged)
    elif stratum == "single, unknown state" or (stratum in ("none", "outside") and rng.random() < 0.3):
        states, known = (damaged,), False
    loads = ALL_LOADS if rng.random() < 0.8 else FEWER_LOADS[int(rng.integers(3))]
    noise = str(rng.choice(NOISES)) if stratum == "noise" else "white"
    return Case(name, stratum, truths, states, known, loads, noise, asset.family)


def _draw_truths(stratum: str, rng: np.random.Generator, asset: Asset) -> tuple[Truth, ...]:
    names = [name for name in SINGLES if asset.n_places.get(name) != 0]
    if stratum.startswith("single"):
        return (draw(str(rng.choice(names)), rng, asset),)
    if stratum == "pair":
        pair = {"modulus", "common_gain"}
        while len(pair & CONFOUNDED) > 1:
            pair = set(rng.choice(names, 2, replace=False).tolist())
        return tuple(draw(name, rng, asset) for name in sorted(pair))
    if stratum == "outside":
        return (draw_outside(rng, asset),)
    if stratum == "channel":
        return (draw_channel(rng, asset),)
    is_loose = stratum == "none" and rng.random() < 0.15  # a mount that turns leaves no strain: none is right
    return (Truth(TRACELESS, float(rng.uniform(0.05, 0.3))),) if is_loose else ()


def mean_readings(truths: Sequence[Truth], asset: Asset, moment: Moment) -> FloatArray:
    """Return the readings (n_times, n_gauges) without noise."""
    reading = np.tile(moment.load * asset.strain(moment.state), (len(moment.times), 1))
    for truth in in_order(truths):
        reading = reading + change(truth, asset, moment, reading)
    return reading


def moments(case: Case) -> list[Moment]:
    """Return when and how every cell of a case is measured."""
    found: list[Moment] = []
    history: tuple[tuple[float, float], ...] = ()
    for k, (_, state, load) in enumerate(case.cells):
        start = k * REPEATS * INTERVAL
        history = (*history, (load, start))
        found.append(Moment(state, load, start + INTERVAL * np.arange(REPEATS, dtype=np.float64), history))
    return found


def scatter(kind: str, rng: np.random.Generator, shape: tuple[int, int], load: float) -> FloatArray:
    """Return noise (n_repeats, n_gauges) of variance 1000 (heteroscedastic: from half to one and a half times)."""
    white: FloatArray = rng.standard_normal(shape) * np.sqrt(VARIANCE)
    if kind == "heavy":
        return np.asarray(rng.standard_t(5, shape) * np.sqrt(VARIANCE * 3 / 5))
    if kind == "heteroscedastic":
        return np.asarray(white * np.sqrt(0.5 + load / 3.0))
    if kind == "correlated":
        for k in range(1, shape[0]):
            white[k] = 0.3 * white[k - 1] + np.sqrt(1 - 0.09) * white[k]
    return white


def recorded(case: Case, asset: Asset, readings: FloatArray) -> FloatArray:
    """Return what the channels make of readings (n_rows, n_gauges): steps, limits, a channel that stands still."""
    step = STEP if case.noise == "quantised" else 0.1
    readings = step * np.round(readings / step)
    for truth in case.truths:
        if truth.name == "stuck_gauge":
            g = asset.gauges.index(truth.place)
            readings[:, g] = readings[0, g]
        if truth.name == "clipping":
            limit = truth.size * max(case.loads) * np.abs(asset.strain(case.states[0])).max()
            readings = np.clip(readings, -limit, limit)
    return readings


def write_campaign(path: Path, case: Case, asset: Asset, seed: int) -> None:
    """Write the readings of a case."""
    rng = np.random.default_rng([seed, 2, zlib.crc32(case.name.encode())])
    parts = [
        mean_readings(case.truths, asset, moment) + scatter(case.noise, rng, (REPEATS, len(asset.gauges)), moment.load)
        for moment in moments(case)
    ]
    readings = iter(recorded(case, asset, np.concatenate(parts)).tolist())
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["test", "load_factor", *PARAMETERS, "time", *asset.gauges])
        for (number, state, load), moment in zip(case.cells, moments(case), strict=True):
            told = [f"{v:g}" for v in state] if case.is_known else ["", ""]
            for time in moment.times.tolist():
                row = [f"{value:.1f}" for value in next(readings)]
                writer.writerow([f"T{number}", f"{load:g}", *told, f"{time + INTERVAL:g}", *row])
