"""Seal a set: campaigns and fingerprints into one folder, answers into a file that no diagnosis knows of.

`folder/<asset>/commissioning.csv` and `folder/<asset>/campaigns/*.csv` are all that a diagnosis reads.
"""

import json
import secrets
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import NotRequired, TypedDict

import numpy as np

from benchmarks.blind.assets.asset import Asset, neighbours
from benchmarks.blind.assets.families import slug
from benchmarks.blind.assets.moment import Moment
from benchmarks.blind.cases import (
    ALL_LOADS,
    REPEATS,
    Case,
    draw_cases,
    mean_readings,
    moments,
    write_campaign,
    write_run,
)
from benchmarks.blind.singles import singles
from benchmarks.blind.truths import Extra, Truth
from benchmarks.noises import VARIANCE
from benchmarks.seals import fingerprint
from femlib.arrays import FloatArray

HELD_LOAD = 2.5  # never measured: the correction is judged there
LEAST = 0.003
"""Without a commissioning run: what two models of one wing differ by at every gauge, of the mean strain."""
DAMAGE = 0.5
"""Typical size of an unknown damage."""


class Facts(TypedDict):
    """Facts of a case that the scorer needs besides the case itself.

    `d_prime` (of all truths) and `d_prime_of_parts` (of each) are by "calibrated" and "bare", with and without a
    commissioning run; so is `from_library`, of what no library holds: what the best multiple of the most alike effect
    of the library leaves. The others are (n_gauges,), `entries` by test and load.
    """

    d_prime: dict[str, float]
    d_prime_of_parts: dict[str, list[float]]
    held_change: list[float]
    entries: dict[str, list[float]]
    strain: list[float]
    gauges: list[str]
    from_library: NotRequired[dict[str, float]]


class TruthRecord(TypedDict):
    """A truth as it was sealed."""

    name: str
    size: float
    place: str
    extra: Extra


class CaseRecord(TypedDict):
    """A case as it was sealed."""

    name: str
    stratum: str
    truths: list[TruthRecord]
    states: list[list[float]]
    is_known: bool
    loads: list[float]
    noise: str
    family: str
    is_split: bool
    run: str


class Key(Facts):
    """The opened key of a case, with its mean readings (n_cells, n_gauges)."""

    case: CaseRecord
    salt: str
    means: list[list[float]]


def seal(
    folder: Path,
    keys: Path,
    seed: int,
    count: int,
    assets: Sequence[Asset],
    strata: str = "main",
) -> None:
    """Write campaigns and seals to `folder`, the answers to `keys`."""
    for asset in assets:
        place = folder / slug(asset.family)
        (place / "campaigns").mkdir(parents=True, exist_ok=True)
        (place / "runs").mkdir(exist_ok=True)
        write_run(place / "commissioning.csv", asset, seed)
    by_family = {asset.family: asset for asset in assets}
    seals: dict[str, str] = {}
    answers: dict[str, object] = {}
    for case in draw_cases(seed, count, assets, strata):
        asset = by_family[case.family]
        place = folder / slug(case.family)
        means = write_campaign(place / "campaigns" / f"{case.name}.csv", case, asset, seed)
        if case.run != "own":
            write_run(place / "runs" / f"{case.name}.csv", asset, seed, case.run)
        answer: dict[str, object] = {"case": asdict(case), "salt": secrets.token_hex(16), **facts(case, asset)}
        answer["means"] = means.tolist()
        seals[case.name] = fingerprint(answer)
        answers[case.name] = answer
    keys.write_text(json.dumps(answers))
    (folder / "seals.json").write_text(json.dumps(seals, indent=1, sort_keys=True))  # last: the set is whole


def facts(case: Case, asset: Asset) -> Facts:
    """Return what the scorer needs: how far the truths stand from the noise, and what they change."""
    cells = moments(case)
    moved = _moved(case.truths, asset, cells)
    parts = [_moved((truth,), asset, cells) for truth in case.truths]
    beside: Sequence[FloatArray | None] = parts[::-1] if len(parts) == 2 else [None] * len(parts)
    held = held_moment(case)
    names = [f"T{number} at load factor {load:g}" for number, _, load in case.cells]
    found: Facts = {
        "d_prime": {key: distance(moved, case, asset, key == "calibrated") for key in ("calibrated", "bare")},
        "d_prime_of_parts": {
            key: [distance(p, case, asset, key == "calibrated", q) for p, q in zip(parts, beside, strict=True)]
            for key in ("calibrated", "bare")
        },
        "held_change": _moved(case.truths, asset, [held])[0].tolist(),
        "entries": {name: row.tolist() for name, row in zip(names, moved, strict=True)},
        "strain": asset.strain(case.states[0]).tolist(),
        "gauges": list(asset.gauges),
    }
    if case.stratum == "outside":
        found["from_library"] = from_library(moved, case, asset)
    return found


def from_library(moved: FloatArray, case: Case, asset: Asset) -> dict[str, float]:
    """Return how far a change (n_cells, n_gauges) stands from all that a single effect of the library can make."""
    alike = [_moved((truth,), asset, moments(case)).ravel() for truth in singles(asset)]
    columns = np.column_stack([moved.ravel(), *alike])
    found = {}
    for kind in ("calibrated", "bare"):
        root = np.linalg.cholesky(mean_covariance(case, asset, kind == "calibrated"))
        own, *others = np.linalg.solve(root, columns).T
        across, length = np.array(others) @ own, np.sum(np.array(others) ** 2, axis=1)
        most = float(np.max(across**2 / np.maximum(length, 1e-300)))
        found[kind] = float(np.sqrt(max(0.0, float(own @ own) - most)))
    return found


def held_moment(case: Case) -> Moment:
    """Return the moment at which the correction is judged: after the campaign, at a load never measured."""
    end = moments(case)[-1]
    last = end.times[-1]
    return Moment(case.states[0], HELD_LOAD, np.array([last]), (*end.history, (HELD_LOAD, last - 300.0)))


def _moved(truths: Sequence[Truth], asset: Asset, cells: Sequence[Moment]) -> FloatArray:
    """Return the mean change (n_cells, n_gauges) that truths make."""
    return np.array([(mean_readings(truths, asset, m) - m.load * asset.strain(m.state)).mean(axis=0) for m in cells])


def distance(
    moved: FloatArray, case: Case, asset: Asset, is_calibrated: bool, beside: FloatArray | None = None
) -> float:
    """Return d': how many standard deviations a change (n_cells, n_gauges) stands from noise, model and damage.

    With `beside`, a change of the same shape: of the remainder after subtracting the best multiple of that.
    """
    flat = moved.ravel()
    weighed = np.linalg.solve(mean_covariance(case, asset, is_calibrated), flat)
    squared = float(flat @ weighed)
    if beside is not None:
        other = beside.ravel()
        own = float(other @ np.linalg.solve(mean_covariance(case, asset, is_calibrated), other))
        squared -= float(other @ weighed) ** 2 / own if own > 0.0 else 0.0
    return float(np.sqrt(max(0.0, squared)))


def mean_covariance(case: Case, asset: Asset, is_calibrated: bool) -> FloatArray:
    """Return the covariance (n_cells n_gauges, same) of mean readings about what the twin says."""
    loads = np.array([load for _, _, load in case.cells])
    n, noise = len(asset.gauges), VARIANCE / REPEATS
    strain = 3.0 * asset.strain(asset.states[0])
    common, own_share = asset.differs
    if is_calibrated:
        model = np.eye(n) * noise / sum((load / 3.0) ** 2 for load in ALL_LOADS)
    else:
        own = (own_share * strain) ** 2 + (LEAST * np.sqrt(np.mean(strain**2))) ** 2
        model = common**2 * np.outer(strain, strain) + np.diag(own)
    covariance = np.eye(len(loads) * n) * noise + np.kron(np.outer(loads / 3.0, loads / 3.0), model)
    if case.is_known:
        return covariance
    for number, state in enumerate(case.states):
        own = loads * [test == number for test, _, _ in case.cells]
        for near in neighbours(state):
            step = max(abs(a - b) for a, b in zip(near, state, strict=True))
            tangent = np.kron(own, (asset.strain(near) - asset.strain(state)) / step)
            covariance += DAMAGE**2 * np.outer(tangent, tangent)
    return covariance
