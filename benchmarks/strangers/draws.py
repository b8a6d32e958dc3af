"""Draw cases of a stranger's machine, write what a user would have, and seal what is wrong.

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

from benchmarks.seals import fingerprint
from benchmarks.strangers.stranger import Fault, Numbers, Stranger
from femlib.arrays import FloatArray

SHARES = {"sound": 0.25, "single": 0.5, "outside": 0.25}
CLEAR = 8.0
"""Least d' of what is drawn: over the noise of run and campaign; of what is outside also over any pair of faults."""


class Key(TypedDict):
    """What is wrong in a case; `d_prime` is 0 where nothing is."""

    name: str
    machine: str
    stratum: str
    names: list[str]
    kind: str
    place: str
    size: float
    d_prime: float
    salt: str


def seal(folder: Path, keys: Path, seed: int, count: int, strangers: Sequence[Stranger]) -> None:
    """Write `count` cases of every machine, their seals to the folder and their answers to `keys`."""
    answers: dict[str, Key] = {}
    for number, stranger in enumerate(strangers):
        rng = np.random.default_rng([seed, number])
        strata = [s for s, share in SHARES.items() for _ in range(round(share * count))]
        rng.shuffle(strata)
        for k, stratum in enumerate(strata):
            name = f"{stranger.name}{k:03d}"
            answers[name] = _case(folder / stranger.name / name, stratum, stranger, rng)
    keys.write_text(json.dumps(answers))
    (folder / "seals.json").write_text(json.dumps({name: fingerprint(key) for name, key in answers.items()}, indent=1))


def _case(place: Path, stratum: str, stranger: Stranger, rng: np.random.Generator) -> Key:
    own = stranger.own(rng)
    fault, d_prime = _drawn(stratum, stranger, own, rng)
    place.mkdir(parents=True)
    _write(place / "run.csv", stranger, stranger.means(own), rng)
    _write(place / "campaign.csv", stranger, stranger.means(own, fault), rng)
    said = fault or Fault((), "", "", 0.0)
    return {
        "name": place.name,
        "machine": stranger.name,
        "stratum": stratum,
        "names": list(said.names),
        "kind": said.kind,
        "place": said.place,
        "size": said.size,
        "d_prime": d_prime,
        "salt": secrets.token_hex(16),
    }


def _drawn(stratum: str, stranger: Stranger, own: Numbers, rng: np.random.Generator) -> tuple[Fault | None, float]:
    """Return a fault that can be seen, and its d'."""
    while stratum != "sound":
        singles = stranger.singles(rng)
        kinds = stranger.outsiders(rng) if stratum == "outside" else _by_kind(singles, rng)
        fault = kinds[int(rng.integers(len(kinds)))]
        d_prime = _distance(stranger, own, fault, singles if stratum == "outside" else ())
        if d_prime >= CLEAR:
            return fault, d_prime
    return None, 0.0


def _by_kind(singles: Sequence[Fault], rng: np.random.Generator) -> list[Fault]:
    """Return one fault of each kind, so that a machine with many gauges is not all gauges."""
    kinds = dict.fromkeys(fault.kind for fault in singles)
    return [(same := [f for f in singles if f.kind == kind])[int(rng.integers(len(same)))] for kind in kinds]


def _distance(stranger: Stranger, own: Numbers, fault: Fault, library: Sequence[Fault]) -> float:
    """Return how far a fault moves the readings, beside the best of any pair of a library, in noise sds."""
    sd = stranger.noise * np.sqrt(2.0 / stranger.repeats)
    sound = stranger.means(own)
    moved = ((stranger.means(own, fault) - sound) / sd).ravel()
    columns = [((stranger.means(own, other) - sound) / sd).ravel() for other in library]
    left = [float(moved @ moved)]
    for pair in combinations(columns, 2):
        basis = np.linalg.qr(np.stack(pair, axis=1))[0]
        left.append(float(moved @ moved - np.sum((moved @ basis) ** 2)))
    return float(np.sqrt(max(0.0, min(left))))


def _write(path: Path, stranger: Stranger, means: FloatArray, rng: np.random.Generator) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["test", *stranger.cells[0], *stranger.offsets])
        for loads, row in zip(stranger.cells, means, strict=True):
            for noise in rng.standard_normal((stranger.repeats, len(row))):
                writer.writerow(["T1", *loads.values(), *(f"{value:.6g}" for value in row + stranger.noise * noise)])
