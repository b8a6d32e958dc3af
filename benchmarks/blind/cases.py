"""Sealed cases: drawn from a seed, measured on the asset, written without their answers."""

import csv
import hashlib
import json
import secrets
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.blind.asset import PARAMETERS, REFINEMENT, STATES, Asset
from benchmarks.blind.truths import SINGLES, Truth, change, draw, draw_outside, parts

REPEATS, VARIANCE, INTERVAL = 50, 1000.0, 6.0
ALL_LOADS = (0.0, 1.0, 2.0, 3.0)
FEWER_LOADS = ((3.0,), (0.0, 3.0), (1.0, 2.0, 3.0))
HELD_LOAD = 2.5  # never measured: the correction is judged there
SHARES = {
    "none": 0.15, "noise": 0.15, "single": 0.17, "single, damaged": 0.10, "single, unknown state": 0.13,
    "pair": 0.15, "outside": 0.15,
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One sealed case.

    Attributes:
        name: file name without ending.
        stratum: of `SHARES`.
        truths: what is wrong.
        states: one test for each, mu1 and mu2.
        is_known: whether the file tells the states.
        loads: load factors of every test.
        noise: "white", "correlated", "heavy" or "heteroscedastic".
    """

    name: str
    stratum: str
    truths: tuple[Truth, ...]
    states: tuple
    is_known: bool
    loads: tuple
    noise: str


def draw_cases(seed, count, asset):
    """Return `count` cases, the strata in their shares, at least one each."""
    rng = np.random.default_rng([seed, 1])
    strata = [s for s, share in SHARES.items() for _ in range(max(1, round(share * count)))]
    rng.shuffle(strata)
    return [_draw_case(f"case{k:04d}", stratum, rng, asset) for k, stratum in enumerate(strata)]


def _draw_case(name, stratum, rng, asset):
    truths = ()
    if stratum.startswith("single"):
        truths = (draw(str(rng.choice(SINGLES)), rng, asset),)
    elif stratum == "pair":
        first, second = rng.choice(SINGLES, 2, replace=False)
        truths = tuple(draw(str(n), rng, asset) for n in (first, second))
    elif stratum == "outside":
        truths = (draw_outside(rng, asset),)
    healthy, damaged = STATES[0], STATES[1 + int(rng.integers(len(STATES) - 1))]
    states, known = (healthy,), True
    if stratum == "single, damaged":
        states = (healthy, damaged)
    elif stratum == "single, unknown state" or (stratum in ("none", "outside") and rng.random() < 0.3):
        states, known = (damaged,), False
    loads = ALL_LOADS if rng.random() < 0.8 else FEWER_LOADS[int(rng.integers(3))]
    noise = str(rng.choice(["correlated", "heavy", "heteroscedastic"])) if stratum == "noise" else "white"
    return Case(name, stratum, truths, states, known, loads, noise)


def mean_readings(case, asset, state, load, time):
    """Return the readings (n_gauges,) without noise."""
    before = load * asset.strain(state)
    for truth in parts(case.truths):
        before = before + change(truth, asset, state, load, time, before)
    return before


def scatter(kind, rng, shape, load):
    """Return noise (n_repeats, n_gauges) of variance 1000 (heteroscedastic: from half to one and a half times)."""
    white = rng.standard_normal(shape) * np.sqrt(VARIANCE)
    if kind == "heavy":
        return rng.standard_t(5, shape) * np.sqrt(VARIANCE * 3 / 5)
    if kind == "heteroscedastic":
        return white * np.sqrt(0.5 + load / 3.0)
    if kind == "correlated":
        for k in range(1, shape[0]):
            white[k] = 0.3 * white[k - 1] + np.sqrt(1 - 0.09) * white[k]
    return white


def write_campaign(path, case, asset, seed):
    """Write the readings of a case, as a test engineer would: rounded to a tenth of a microstrain."""
    rng = np.random.default_rng([seed, 2, int(hashlib.sha256(case.name.encode()).hexdigest()[:8], 16)])
    time = 0.0
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["test", "load_factor", *PARAMETERS, "time", *asset.gauges])
        for number, state in enumerate(case.states):
            told = [f"{v:g}" for v in state] if case.is_known else ["", ""]
            for load in case.loads:
                noise = scatter(case.noise, rng, (REPEATS, len(asset.gauges)), load)
                for k in range(REPEATS):
                    time += INTERVAL
                    reading = mean_readings(case, asset, state, load, time - INTERVAL) + noise[k]
                    writer.writerow([f"T{number}", f"{load:g}", *told, f"{time:g}", *(f"{v:.1f}" for v in reading)])


def seal(folder: Path, keys: Path, seed: int, count: int, refinement: float = REFINEMENT):
    """Write campaigns and seals to `folder`, the answers to `keys`: a diagnosis reads the folder alone."""
    asset = Asset(seed, refinement)
    (folder / "campaigns").mkdir(parents=True)
    healthy = Case("commissioning", "none", (), (STATES[0],), True, ALL_LOADS, "white")
    write_campaign(folder / "commissioning.csv", healthy, asset, seed)
    seals, answers = {}, {}
    for case in draw_cases(seed, count, asset):
        write_campaign(folder / "campaigns" / f"{case.name}.csv", case, asset, seed)
        answer = {"case": asdict(case), "salt": secrets.token_hex(16), **_facts(case, asset)}
        seals[case.name] = fingerprint(answer)
        answers[case.name] = answer
    (folder / "seals.json").write_text(json.dumps(seals, indent=1, sort_keys=True))
    keys.write_text(json.dumps(answers))


def fingerprint(answer):
    """Return the SHA-256 of a salted answer."""
    return hashlib.sha256(json.dumps(answer, sort_keys=True).encode()).hexdigest()


def _facts(case, asset):
    """Return what the scorer needs: the change at the held load and how far it stands from the noise."""
    sd = np.sqrt(VARIANCE / REPEATS)
    end = INTERVAL * REPEATS * len(case.loads) * len(case.states)
    squared = 0.0
    for state in case.states:
        for load in case.loads:
            moved = mean_readings(case, asset, state, load, end / 2) - load * asset.strain(state)
            if not case.is_known:
                moved = _without_damage(moved, asset, state, load)
            squared += float(moved @ moved) / (sd**2 * (1.0 + (load / 3.0) ** 2 * 9.0 / 14.0))
    state = case.states[0]
    held = mean_readings(case, asset, state, HELD_LOAD, end) - HELD_LOAD * asset.strain(state)
    entries = {}
    for number, state in enumerate(case.states):
        for load in case.loads:
            moved = mean_readings(case, asset, state, load, end / 2) - load * asset.strain(state)
            entries[f"T{number} at load factor {load:g}"] = (moved / sd).tolist()
    return {
        "d_prime": float(np.sqrt(squared)),
        "held_change": held.tolist(),
        "entries": entries,
        "gauges": list(asset.gauges),
    }


def _without_damage(moved, asset, state, load):
    """Return a change less what a further damage of the two regions can imitate."""
    if load == 0.0:
        return moved
    step = 0.02
    tangents = [
        (asset.strain(tuple(v + step * (k == p) for k, v in enumerate(state))) - asset.strain(state)) / step
        for p in range(len(state))
    ]
    basis, _ = np.linalg.qr(np.array(tangents).T)
    return moved - basis @ (basis.T @ moved)
