"""Sets of effects as hypotheses: which exist, how probable before the data, and which survive a beam search.

A set of k candidates has prior P(k) / C(n_effects, k) * product of their shares (`octmip.gap.odds`). The beam starts
from no effect, adds one candidate at a time and keeps the sets of greatest posterior weight. Sets with a member that
the others already imitate are the same explanation twice and are left out.
"""

from dataclasses import dataclass
from math import comb, inf, log

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.evidence import Members, extensions
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.progress import Stage

BEAM = (48, 24)
"""Sets of one and of two candidates that are extended."""
FAINT = 0.1
"""Standard deviations that an effect must be able to move all readings together; others are no explanation."""
UNEXPLAINED = 0.02
"""A candidate is imitated by others when they leave less than this share of its squared length unexplained."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A set of candidates, and the log of prior times evidence."""

    members: Members
    log_weight: float


def log_prior(inputs: Inputs, members: Members) -> float:
    """Return the log prior probability of a set of candidates."""
    shares = float(inputs.priors.log_weight[list(members)].sum())
    return log_count(inputs, len(members)) + shares


def log_count(inputs: Inputs, k: int) -> float:
    """Return the log prior probability of each set of k effects; -inf for more than the odds know of."""
    if k >= len(inputs.odds.count):
        return -inf
    return log(max(inputs.odds.count[k], 1e-300)) - log(max(comb(inputs.priors.n_effects, k), 1))


def likely_sets(inference: Inference) -> list[Hypothesis]:
    """Return no effect, every single candidate and the best larger sets, with approximate weights."""
    inputs = inference.model.inputs
    most = len(inputs.odds.count) - 1
    found: dict[Members, float] = {(): log_prior(inputs, ())}
    beam: list[Members] = [()]
    for size in range(1, most + 1):
        longer: dict[Members, float] = {}
        inputs.progress(Stage("hypotheses, number of effects", size, most))
        inference.judge(beam)  # all at once: one by one costs several times as much
        for members in beam:
            longer |= _extended(inference, members)
        found |= longer if size == 1 else _best(longer, 4 * BEAM[1])
        if size < most:
            beam = list(_diverse(inputs, longer, BEAM[size - 1]))
    return [Hypothesis(members, weight) for members, weight in found.items()]


def _extended(inference: Inference, members: Members) -> dict[Members, float]:
    """Return the sets of one more candidate with their weights, each judged under the errors of `members`."""
    inputs, model = inference.model.inputs, inference.allowing(members).model
    logs = extensions(model, members) + model.log_none - inference.model.log_none
    if members:
        logs = np.where(unexplained_share(model, members) < UNEXPLAINED, -np.inf, logs)
    prior = inputs.priors
    can_be_seen = 3.0 * np.hypot(prior.mean, prior.sd) * np.sqrt(inference.model.whitened.lengths) > FAINT
    keep = np.flatnonzero(np.isfinite(logs) & can_be_seen)
    if members:
        keep = keep[np.argsort(-logs[keep], kind="stable")[: 2 * BEAM[0]]]
    shares = prior.log_weight
    weights = logs[keep] + shares[keep] + shares[list(members)].sum() + log_count(inputs, len(members) + 1)
    joined = [tuple(sorted((*members, j))) for j in keep.tolist()]
    return dict(zip(joined, weights.tolist(), strict=True))


def unexplained_share(model: LinearModel, members: Members) -> NDArray[np.float64]:
    """Return the share (n_candidates,) of each one's squared whitened length that `members` cannot imitate."""
    index = list(members)
    cross = model.whitened.gram_rows(index)
    within = cross[:, index]
    length = np.maximum(model.whitened.lengths, 1e-300)
    imitated = np.einsum("ij,ij->j", cross, np.linalg.lstsq(within, cross, rcond=None)[0])
    return np.asarray(1.0 - imitated / length)


def _best(weights: dict[Members, float], most: int) -> dict[Members, float]:
    ordered = sorted(weights.items(), key=lambda item: -item[1])
    return dict(ordered[:most])


def _diverse(inputs: Inputs, weights: dict[Members, float], most: int) -> dict[Members, float]:
    """Return the best sets, at most four of the same effects: one gauge's places must not fill the beam."""
    taken: dict[tuple[int, ...], int] = {}
    name = inputs.priors.name.tolist()
    kept = {}
    for members, weight in sorted(weights.items(), key=lambda item: -item[1]):
        names = tuple(sorted(name[j] for j in members))
        taken[names] = taken.get(names, 0) + 1
        if taken[names] <= 4:
            kept[members] = weight
        if len(kept) == most:
            break
    return kept
