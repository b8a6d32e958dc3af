"""Sets of effects as hypotheses: which exist, how probable before the data, and which survive a search.

A set of k candidates has prior P(k) / C(n_effects, k) * product of their shares (`octmip.gap.odds`). Every single
candidate is weighed; the best of them are extended by every other, the best pairs again where the pairs gained enough.
Sets with a member that the others already imitate are the same explanation twice and are left out.
"""

from dataclasses import dataclass
from math import comb, inf, log

import numpy as np

from octmip.gap.inference.evidence import Members, extensions
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import Inputs
from octmip.gap.progress import Stage

HEADS = (20, 8)
"""Sets of one and of two candidates that are extended."""
KEPT = 60
"""Larger sets that are kept of each size."""
OF_ONE_NAME = 4
"""Sets of the same effects that are extended: one gauge's places must not fill the search."""
FAINT = 0.1
"""Standard deviations that an effect must be able to move all readings together; others are no explanation."""
IMITATED = 0.02
"""A candidate is imitated by others when they leave less than this share of its squared length."""
TRIPLES = 2.0
"""Log units that the best pair must weigh beyond the best single for triples to be looked at."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A set of candidates, and the log of prior times evidence over that of no effect."""

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
    """Return no effect, every single candidate and the best larger sets, with approximate weights, best first."""
    inputs = inference.model.inputs
    most = len(inputs.odds.count) - 1
    found: dict[Members, float] = {(): log_prior(inputs, ())}
    heads: list[Members] = [()]
    best = -inf
    for size in range(1, most + 1):
        longer: dict[Members, float] = {}
        inputs.progress(Stage("hypotheses, number of effects", size, most))
        inference.judge(heads)  # all at once: one by one costs several times as much
        for members in heads:
            longer |= _extended(inference, members)
        ordered = sorted(longer.items(), key=lambda item: -item[1])
        found |= dict(ordered if size == 1 else ordered[:KEPT])
        if not ordered or (size > 1 and ordered[0][1] < best + TRIPLES) or size == most:
            break
        best = ordered[0][1]
        heads = _diverse(inputs, ordered, HEADS[size - 1])
    ranked = sorted(found.items(), key=lambda item: -item[1])
    return [Hypothesis(members, weight) for members, weight in ranked]


def _extended(inference: Inference, members: Members) -> dict[Members, float]:
    """Return the sets of one more candidate with their weights, each judged under the errors of `members`."""
    model = inference.model
    inputs, prior = model.inputs, model.inputs.priors
    logs, new = extensions(model, members, inference.judge([members])[0].root if members else None)
    can_be_seen = 3.0 * np.hypot(prior.mean, prior.sd) * np.sqrt(model.whitened.lengths) > FAINT
    keep = np.flatnonzero(np.isfinite(logs) & can_be_seen & ((new > IMITATED) | (not members)))
    if members:
        keep = keep[np.argsort(-(logs + prior.log_weight)[keep], kind="stable")[:KEPT]]
    weights = logs[keep] + prior.log_weight[keep] + log_prior(inputs, members)
    weights += log_count(inputs, len(members) + 1) - log_count(inputs, len(members))
    joined = [tuple(sorted((*members, j))) for j in keep.tolist()]
    return dict(zip(joined, weights.tolist(), strict=True))


def _diverse(inputs: Inputs, ordered: list[tuple[Members, float]], most: int) -> list[Members]:
    """Return the first sets, at most a few of the same effects."""
    taken: dict[tuple[int, ...], int] = {}
    name = inputs.priors.name.tolist()
    kept: list[Members] = []
    for members, _ in ordered:
        names = tuple(sorted(name[j] for j in members))
        taken[names] = taken.get(names, 0) + 1
        if taken[names] <= OF_ONE_NAME:
            kept.append(members)
        if len(kept) == most:
            break
    return kept
