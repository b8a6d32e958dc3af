"""Draw cases of a machine, write what a user would have, and seal what is wrong.

`folder/<machine>/<case>/{run,campaign}.csv` is all that a selector reads; the answers go into another file.
"""

import csv
import json
import secrets
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import TypedDict

import numpy as np

from benchmarks.machines.machine import Fault, Machine, Numbers
from benchmarks.seals import fingerprint
from femlib.arrays import FloatArray

SHARES = {"sound": 0.2, "single": 0.4, "pair": 0.2, "outside": 0.2}
CLEAR, TWIN = 8.0, 0.03
"""Least d' of what is drawn: over the noise of run and campaign; of a pair each beside the other, of what is outside
beside any pair of faults, where a twin may be wrong by 3 % of what it changes."""
NOISES = ("white", "memory", "coarse")
"""Noise of a case: white, one that remembers (AR(1), 0.6), or a display with steps of one and a half sd."""
MEMORY, COARSE = 0.6, 1.5
MOST_DRAWS = 2000


class Key(TypedDict):
    """What is wrong in a case: kind, place, size and d' of each fault, and what makes the machine its own."""

    name: str
    machine: str
    stratum: str
    names: list[str]
    faults: list[tuple[str, str, float]]
    d_prime: list[float]
    noise: str
    own: dict[str, float]
    new: list[float]
    salt: str


def seal(folder: Path, keys: Path, seed: int, count: int, machines: Sequence[Machine]) -> None:
    """Write `count` cases of every machine, their seals to the folder and their answers to `keys`."""
    answers: dict[str, Key] = {}
    for machine in machines:
        rng = np.random.default_rng([seed, *machine.name.encode()])
        shares = {s: share for s, share in SHARES.items() if machine.outside or s != "outside"}
        strata = [s for s, share in shares.items() for _ in range(round(share * count / sum(shares.values())))]
        rng.shuffle(strata)
        for k, stratum in enumerate(strata):
            name = f"{machine.name}{k:03d}"
            answers[name] = _case(folder / machine.name / name, stratum, machine, rng)
    keys.write_text(json.dumps(answers))
    (folder / "seals.json").write_text(json.dumps({name: fingerprint(key) for name, key in answers.items()}, indent=1))


def _case(place: Path, stratum: str, machine: Machine, rng: np.random.Generator) -> Key:
    own, noise = machine.own(rng), NOISES[int(rng.integers(len(NOISES)))]
    faults, d_prime = _drawn(stratum, machine, own, noise, rng)
    place.mkdir(parents=True)
    _write(place / "run.csv", machine, machine.means(own), noise, rng)
    _write(place / "campaign.csv", machine, machine.means(own, faults), noise, rng)
    return {
        "name": place.name,
        "machine": machine.name,
        "stratum": stratum,
        "names": [name for fault in faults for name in fault.names],
        "faults": [(fault.kind, fault.place, fault.size) for fault in faults],
        "d_prime": d_prime,
        "noise": noise,
        "own": dict(own),
        "new": machine.means(own, faults, [machine.new_cell])[0].tolist(),
        "salt": secrets.token_hex(16),
    }


def _drawn(
    stratum: str, machine: Machine, own: Numbers, noise: str, rng: np.random.Generator
) -> tuple[list[Fault], list[float]]:
    """Return faults that can be seen, and their d'."""
    if stratum == "sound":
        return [], []
    for _ in range(MOST_DRAWS):
        singles = machine.singles(rng)
        kinds = machine.outsiders(rng) if stratum == "outside" else _by_kind(singles, rng)
        chosen = rng.choice(len(kinds), size=2 if stratum == "pair" else 1, replace=False)
        faults = [kinds[int(k)] for k in chosen]
        d_prime = _distances(machine, own, faults, noise, singles if stratum == "outside" else ())
        if min(d_prime) >= CLEAR:
            return faults, d_prime
    raise RuntimeError(f"{machine.name}: no {stratum} stands d' = {CLEAR} above the noise in {MOST_DRAWS} draws")


def _by_kind(singles: Sequence[Fault], rng: np.random.Generator) -> list[Fault]:
    """Return one fault of each kind, so that a machine with many gauges is not all gauges."""
    kinds = dict.fromkeys(fault.kind for fault in singles)
    return [(same := [f for f in singles if f.kind == kind])[int(rng.integers(len(same)))] for kind in kinds]


def _distances(
    machine: Machine, own: Numbers, faults: Sequence[Fault], noise: str, library: Sequence[Fault]
) -> list[float]:
    """Return how far each fault moves the readings beside the others, and beside the best pair of a library."""
    grown = (1.0 + MEMORY) / (1.0 - MEMORY) if noise == "memory" else 1.0
    sd = machine.noise * np.sqrt(2.0 * grown / machine.repeats)
    sound = machine.means(own)
    if library:
        sd = np.hypot(sd, TWIN * (machine.means(own, faults) - sound))
    moved = [((machine.means(own, [fault]) - sound) / sd).ravel() for fault in [*faults, *library]]
    of_library = [list(pair) for pair in combinations(moved[len(faults) :], 2)] or [[]]
    found = []
    for k in range(len(faults)):
        beside = [column for j, column in enumerate(moved[: len(faults)]) if j != k]
        found.append(min(_left(moved[k], [*beside, *pair]) for pair in of_library))
    return found


def _left(moved: FloatArray, columns: Sequence[FloatArray]) -> float:
    basis = np.linalg.qr(np.stack(columns, axis=1))[0] if columns else np.zeros((len(moved), 0))
    return float(np.sqrt(max(0.0, float(moved @ moved - np.sum((moved @ basis) ** 2)))))


def _write(path: Path, machine: Machine, means: FloatArray, kind: str, rng: np.random.Generator) -> None:
    before = rng.standard_normal(len(machine.noise))
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["test", *machine.cells[0], *machine.readings])
        for loads, row in zip(machine.cells, means, strict=True):
            for fresh in rng.standard_normal((machine.repeats, len(row))):
                memory = MEMORY if kind == "memory" else 0.0
                before = memory * before + np.sqrt(1.0 - memory**2) * fresh
                shown = row + machine.noise * before
                if kind == "coarse":
                    step = COARSE * machine.noise
                    shown = step * np.round(shown / step)
                writer.writerow(["T1", *loads.values(), *(f"{value:.6g}" for value in shown)])
