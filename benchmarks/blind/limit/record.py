"""What the selector says of a case, in the form in which a diagnosis is scored."""

from collections.abc import Sequence

import numpy as np

from benchmarks.blind.answers import CauseRecord, Found, ParameterRecord
from benchmarks.blind.assets.asset import Asset
from benchmarks.blind.cases import REPEATS, Case
from benchmarks.blind.limit.selector import Selector, Told, held_change
from benchmarks.blind.noises import GROWN
from benchmarks.blind.sealing import held_moment, mean_covariance
from benchmarks.noises import VARIANCE
from femlib.arrays import FloatArray

SEPARABLE = 3.0
"""Distance after the best refit below which two changes are one cause under two names, as for the diagnosis."""
CREDIBLE = 0.95
MOST = 6


def limit(case: Case, asset: Asset, means: FloatArray, is_calibrated: bool) -> Found:
    """Return the selector's answer from the mean readings of a case (n_cells, n_gauges)."""
    covariance = mean_covariance(case, asset, is_calibrated)
    noise = VARIANCE / REPEATS * (GROWN.get(case.noise, 1.0) - 1.0)
    selector = Selector(case, asset, means, covariance + noise * np.eye(len(covariance)))
    causes = _causes(selector)
    covered = np.cumsum([probability for _, _, probability in causes])
    n = int(np.searchsorted(covered, CREDIBLE)) + 1
    unknown = sum(p for head, _, p in causes if head.names == ("outside",))
    return {
        "name": case.name,
        "calibrated": is_calibrated,
        "seconds": float("nan"),
        "which": [_cause(selector, head, probability) for head, _, probability in causes[:MOST]],
        "credible": [groups for _, groups, _ in causes[:n]],
        "names": [groups for _, groups, _ in causes[:MOST]],
        "unknown_probability": float(unknown),
        "inclusion": {},
        "findings": [],
        "doubts": [],
        "stuck": [],
        "significant": [],
        "correction": held_change(selector, causes[0][0], held_moment(case)).tolist(),
        "ranking": "",
        "residual": [],
        "lasso": None,
    }


def _causes(selector: Selector) -> list[tuple[Told, list[list[str]], float]]:
    """Return causes, most probable first: best hypothesis, names that cannot be told apart, probability."""
    of: dict[tuple[str, ...], float] = {}
    best: dict[tuple[str, ...], tuple[float, Told]] = {}
    for told, probability in zip(selector.told, selector.probability.tolist(), strict=True):
        key = tuple(sorted(told.names))
        of[key] = of.get(key, 0.0) + probability
        if key not in best or probability > best[key][0]:
            best[key] = (probability, told)
    found: list[tuple[Told, list[list[str]], float]] = []
    while of and (len(found) < MOST or sum(p for _, _, p in found) < CREDIBLE):
        head = best[max(of, key=lambda key: of[key])][1]
        groups = _groups(selector, head)
        same = [key for key in of if key == tuple(sorted(head.names)) or _is_among(groups, key)]
        found.append((head, groups, sum(of.pop(key) for key in same)))
    return sorted(found, key=lambda cause: -cause[2])


def _groups(selector: Selector, head: Told) -> list[list[str]]:
    if head.names == ("outside",):
        return [["unknown"]]
    return [_alike(selector, k, size) for k, size in zip(head.members, head.sizes, strict=True)]


def _alike(selector: Selector, member: int, size: float) -> list[str]:
    """Return the names whose best change lies less than `SEPARABLE` from a member's, its own first."""
    columns = selector.columns.first
    own = size * columns[member]
    length = np.maximum(np.einsum("ij,ij->i", columns, columns), 1e-30)
    left = own @ own - (columns @ own) ** 2 / length
    near = np.flatnonzero(left < SEPARABLE**2)
    name = selector.candidates[member].truth.name
    others = {selector.candidates[k].truth.name for k in near} - {name}
    return [name, *sorted(others)]


def _is_among(groups: Sequence[Sequence[str]], key: tuple[str, ...]) -> bool:
    """Return whether names are one of each group, in any order."""
    if len(groups) != len(key) or key == ("outside",):
        return False
    if not groups:
        return True
    first, rest = key[0], key[1:]
    return any(first in group and _is_among([*groups[:k], *groups[k + 1 :]], rest) for k, group in enumerate(groups))


def _cause(selector: Selector, head: Told, probability: float) -> CauseRecord:
    names = ["unknown"] if head.names == ("outside",) else list(head.names)
    parameters: list[ParameterRecord] = []
    if len(head.members) == 1:
        candidate = selector.candidates[head.members[0]]
        scale = candidate.scale
        low, high = sorted((scale * head.low, scale * head.high))
        parameters.append(
            {
                "effect": candidate.truth.name,
                "place": candidate.truth.place,
                "size": scale * head.sizes[0],
                "low": low,
                "high": high,
            }
        )
    return {"effects": names, "probability": float(probability), "parameters": parameters}
