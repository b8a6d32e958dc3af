"""Sets of effects as hypotheses: which exist, how probable before the data, and which survive a beam search.

A set of k columns has prior P(k) / C(n_effects, k) * product of the columns' shares; k is 0 to 3. The beam starts
from no effect, adds one column at a time and keeps the sets of greatest posterior weight. Sets with a member that the
others already imitate are the same explanation twice and are left out.
"""

from dataclasses import dataclass
from math import comb, log

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.evidence import Members, extensions
from octmip.gap.inference.linear_model import Scene
from octmip.gap.inference.signature_error import allowing, judge

COUNT_PRIOR = (0.48, 0.34, 0.12, 0.02)
"""Prior probability of no, one, two, three effects; what is missing to 1 belongs to the unknown."""
UNKNOWN_PRIOR = (0.03, 0.01)
"""Prior probability of the unknown alone, and of the unknown beside one effect."""
BEAM = (48, 24)
"""Sets of one and of two columns that are extended."""
TRACE = 0.1
"""Standard deviations that an effect must be able to move all readings together; others are no explanation."""
OWN_PART = 0.02
"""A column is imitated by others when less than this share of its squared length is its own."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A set of columns, with or without the unknown, and the log of prior times evidence."""

    members: Members
    has_unknown: bool
    log_weight: float


def log_prior(scene: Scene, members: Members) -> float:
    """Return the log prior probability of a set of columns."""
    shares = float(scene.setting.priors.log_weight[list(members)].sum())
    return _log_count(scene, len(members)) + shares


def _log_count(scene: Scene, k: int) -> float:
    """Return the log prior probability of each set of k effects."""
    return log(COUNT_PRIOR[k]) - log(max(comb(scene.setting.priors.n_effects, k), 1))


def candidates(scene: Scene, most: int = 3) -> list[Hypothesis]:
    """Return no effect, every single column and the best sets of up to `most` columns, with approximate weights."""
    found: dict[Members, float] = {(): log_prior(scene, ())}
    beam: list[Members] = [()]
    for size in range(1, most + 1):
        grown: dict[Members, float] = {}
        judge(scene, beam)  # all at once: one by one costs several times as much
        for members in beam:
            grown |= _grow(scene, members)
        found |= grown if size == 1 else _best(grown, 4 * BEAM[1])
        if size < most:
            beam = list(_diverse(scene, grown, BEAM[size - 1]))
    return [Hypothesis(members, False, weight) for members, weight in found.items()]


def _grow(scene: Scene, members: Members) -> dict[Members, float]:
    under_shape = allowing(scene, members)
    logs = extensions(under_shape, members) + under_shape.log_none - scene.log_none
    if members:
        logs = np.where(own_part(under_shape, members) < OWN_PART, -np.inf, logs)
    prior = scene.setting.priors
    has_trace = 3.0 * np.hypot(prior.mean, prior.sd) * np.sqrt(scene.lengths) > TRACE
    keep = np.flatnonzero(np.isfinite(logs) & has_trace)
    if members:
        keep = keep[np.argsort(-logs[keep], kind="stable")[: 2 * BEAM[0]]]
    shares = scene.setting.priors.log_weight
    weights = logs[keep] + shares[keep] + shares[list(members)].sum() + _log_count(scene, len(members) + 1)
    joined = [tuple(sorted((*members, j))) for j in keep.tolist()]
    return dict(zip(joined, weights.tolist(), strict=True))


def own_part(scene: Scene, members: Members) -> NDArray[np.float64]:
    """Return the share (n_columns,) of each column's squared whitened length that `members` cannot imitate."""
    index = list(members)
    cross = scene.products(index)
    within = cross[:, index]
    length = np.maximum(scene.lengths, 1e-300)
    imitated = np.einsum("ij,ij->j", cross, np.linalg.lstsq(within, cross, rcond=None)[0])
    return np.asarray(1.0 - imitated / length)


def _best(weights: dict[Members, float], most: int) -> dict[Members, float]:
    ordered = sorted(weights.items(), key=lambda item: -item[1])
    return dict(ordered[:most])


def _diverse(scene: Scene, weights: dict[Members, float], most: int) -> dict[Members, float]:
    """Return the best sets, at most four of the same effects: one gauge's variants must not fill the beam."""
    taken: dict[tuple[int, ...], int] = {}
    name = scene.setting.priors.name.tolist()
    kept = {}
    for members, weight in sorted(weights.items(), key=lambda item: -item[1]):
        names = tuple(sorted(name[j] for j in members))
        taken[names] = taken.get(names, 0) + 1
        if taken[names] <= 4:
            kept[members] = weight
        if len(kept) == most:
            break
    return kept
