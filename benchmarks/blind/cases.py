"""Cases: drawn from a seed, measured on an asset, written as a test engineer would write them."""

import csv
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.blind.assets.asset import DAMAGED, PARAMETERS, Asset
from benchmarks.blind.assets.changes import change
from benchmarks.blind.assets.moment import Moment, State
from benchmarks.blind.noises import NOISES
from benchmarks.blind.truths import SINGLES, TRACELESS, Truth, draw, draw_channel, draw_outside, in_order
from femlib.arrays import FloatArray

REPEATS, INTERVAL = 50, 6.0
ALL_LOADS = (0.0, 1.0, 2.0, 3.0)
FEWER_LOADS = ((3.0,), (0.0, 3.0), (1.0, 2.0, 3.0))
SHARES = {
    "none": 0.15, "noise": 0.15, "single": 0.17, "single, damaged": 0.10, "single, unknown state": 0.12,
    "pair": 0.14, "outside": 0.14, "channel": 0.03,
}  # fmt: skip
SOUND = {f"noise: {kind}": 1.0 for kind in NOISES} | {
    "two tests": 1.0, "run: damaged": 1.0, "run: warm": 1.0, "run: other wing": 1.0,
}  # fmt: skip
"""Strata of assets that are sound, or would be if their commissioning run were right."""
SETS: Mapping[str, Mapping[str, float]] = {"main": SHARES, "sound": {s: n / len(SOUND) for s, n in SOUND.items()}}
WRONG_RUNS: Mapping[str, tuple[Truth, ...]] = {
    "own": (), "damaged": (), "warm": (Truth("temperature_uniform", 10.0),),
    "other wing": (Truth("outside", 0.03, "other_wing", {"seed": 0}),),
}  # fmt: skip
"""What a commissioning run was taken with besides what it says; one more is that of a damaged asset."""
MIXED_NOISES = ("AR(1) 0.3", "AR(1) 0.3", "AR(1) 0.3", "heavy", "heteroscedastic", "quantised")
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
        of `SHARES` or of `SOUND`.
    truths
        what is wrong.
    states
        one test for each, mu1 and mu2.
    is_known
        whether the file gives the states.
    loads
        load factors of every test, or of each in turn.
    noise
        one of `NOISES`.
    family
        of the asset.
    is_split
        whether each test has one load alone.
    run
        what the commissioning run was taken with, of `WRONG_RUNS`.
    """

    name: str
    stratum: str
    truths: tuple[Truth, ...]
    states: tuple[State, ...]
    is_known: bool
    loads: tuple[float, ...]
    noise: str
    family: str
    is_split: bool = False
    run: str = "own"

    @property
    def cells(self) -> list[tuple[int, State, float]]:
        """Every test's number and state with every load, in the order of measurement."""
        if self.is_split:
            return [(k, state, load) for k, (state, load) in enumerate(zip(self.states, self.loads, strict=True))]
        return [(number, state, load) for number, state in enumerate(self.states) for load in self.loads]


def draw_cases(seed: int, count: int, assets: Sequence[Asset], strata_of: str = "main") -> list[Case]:
    """Return about `count` cases of one of `SETS`: strata in their shares (at least one each), the assets in turn."""
    rng = np.random.default_rng([seed, 1])
    strata = [s for s, share in SETS[strata_of].items() for _ in range(max(1, round(share * count)))]
    rng.shuffle(strata)
    return [_draw_case(f"case{k:04d}", stratum, rng, assets[k % len(assets)]) for k, stratum in enumerate(strata)]


def _draw_case(name: str, stratum: str, rng: np.random.Generator, asset: Asset) -> Case:
    truths = _draw_truths(stratum, rng, asset)
    damaged = asset.states[1 + int(rng.integers(len(asset.states) - 1))]
    states: tuple[State, ...] = (asset.states[0],)
    known = True
    if stratum in SOUND:
        return _draw_sound(name, stratum, rng, asset)
    if stratum == "single, damaged":
        states = (asset.states[0], damaged)
    elif stratum == "single, unknown state" or (stratum in ("none", "outside") and rng.random() < 0.3):
        states, known = (damaged,), False
    loads = ALL_LOADS if rng.random() < 0.8 else FEWER_LOADS[int(rng.integers(3))]
    noise = str(rng.choice(MIXED_NOISES)) if stratum == "noise" else "white"
    return Case(name, stratum, truths, states, known, loads, noise, asset.family)


def _draw_sound(name: str, stratum: str, rng: np.random.Generator, asset: Asset) -> Case:
    """Return a sound asset under a noise, in two unknown states at one load each, or beside a wrong run."""
    kind, _, what = stratum.partition(": ")
    healthy = (asset.states[0],)
    if kind == "noise":
        return Case(name, stratum, (), healthy, True, ALL_LOADS, what, asset.family)
    if kind == "run":
        return Case(name, stratum, (), healthy, True, ALL_LOADS, "white", asset.family, run=what)
    first, second = rng.choice(len(asset.states), 2, replace=False)
    states = (asset.states[first], asset.states[second])
    return Case(name, stratum, (), states, False, (2.0, 3.0), "white", asset.family, is_split=True)


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


def write_run(path: Path, asset: Asset, seed: int, kind: str = "own") -> None:
    """Write a commissioning run: of the sound asset, or of what it says is the sound asset."""
    state = DAMAGED if kind == "damaged" else asset.states[0]
    case = Case(f"run of {path.stem}", "none", WRONG_RUNS[kind], (state,), True, ALL_LOADS, "white", asset.family)
    write_campaign(path, case, asset, seed, (asset.states[0],))


def write_campaign(path: Path, case: Case, asset: Asset, seed: int, told: Sequence[State] | None = None) -> FloatArray:
    """Write the readings of a case, with its state where it is known or that which is `told`; return their means.

    These are (n_cells, n_gauges).
    """
    rng = np.random.default_rng([seed, 2, zlib.crc32(case.name.encode())])
    means = np.concatenate([mean_readings(case.truths, asset, moment) for moment in moments(case)])
    loads = np.repeat([load for _, _, load in case.cells], REPEATS)
    noise = NOISES[case.noise](rng, loads, len(asset.gauges))
    read = recorded(case, asset, means + noise)
    readings = iter(read.tolist())
    stated = case.states if told is None else told
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["test", "load_factor", *PARAMETERS, "time", *asset.gauges])
        for (number, _, load), moment in zip(case.cells, moments(case), strict=True):
            words = [f"{v:g}" for v in stated[number]] if case.is_known else ["", ""]
            for time in moment.times.tolist():
                row = [f"{value:.1f}" for value in next(readings)]
                writer.writerow([f"T{number}", f"{load:g}", *words, f"{time + INTERVAL:g}", *row])
    return np.asarray(read.reshape(-1, REPEATS, len(asset.gauges)).mean(axis=1))
