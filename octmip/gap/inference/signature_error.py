"""Errors of the effects' own signatures: the misfit that a large effect leaves although its name is right.

A signature comes from a model: each gauge's part of it is known to some per cent, and where an effect may act anywhere
its places are samples of a continuum. So a set of candidates j at sizes theta_j is judged under the covariance

    C = C0 + sum_j theta_j^2 (e^2 s_j^2 (A_j A_j') o R + BETWEEN^2 sum_k (c_k S_k - S_j) (c_k S_k - S_j)'),

with s_j the effect's own error, A_j the size of S_j at and about each gauge (where a signature changes its sign it is
no better known than beside), R the correlation of errors (of one gauge, smooth along the structure, and of one kind of
reading: the same at all loads, along each load and bent over it; o multiplies entry by entry), k the nearest places and
c_k the best scale. One
scalar e says how good the twin's signatures are; it is summed over `LEVELS`. What grows with an effect is thus no
reason for a second one. A discrete effect of the measuring chain (two wires swapped, a gauge dead) also acts on what
the others change: their signatures are propagated through it.
Source: Kennedy and O'Hagan (2001), J. R. Statist. Soc. B 63, section 2 (code inadequacy as a Gaussian of its own);
the sizes are plugged in (empirical Bayes), which for a large effect is exact to the order of their relative error.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.difference import along
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.signatures import on_readings
from octmip.twin import amounts_of

Floats = NDArray[np.float64]
Members = tuple[int, ...]

LEVELS: Mapping[float, float] = {0.0: 0.2, 0.3: 0.4, 1.0: 0.4}
"""Factors on the errors of all signatures of a set, with their probabilities. A twin may be exact; at 3 what no library
holds is named."""
BETWEEN = 0.3
"""Sd of the weight of a neighbouring place: the truth lies anywhere up to half way to it."""
NEARBY = 0.1
"""Length over which the size of a signature is taken, as a share of the structure's extent."""
SMOOTH = 0.5
"""Share of the variance of an error that is smooth along the structure."""
ALIKE = 0.5
"""Share of its squared length that a neighbour must have in common with the place."""


def is_uncertain(model: LinearModel, members: Members) -> bool:
    """Return whether some signature of a set may be wrong."""
    chosen = [model.inputs.candidates[j] for j in members]
    return any(one.signature_errors.any() or one.n_between > 0 for one in chosen)


def correlation(model: LinearModel) -> Floats:
    """Return R (n, n). One kind of reading alone, wrong as a whole, is a wrong size: that is left out."""
    kind, gauge = model.inputs.frame.kind, model.gauge
    first, *bent = [np.outer(course, course) for course in _courses(model)]
    over_loads = np.sum([np.zeros_like(first), *bent], axis=0)
    common = over_loads + first if kind.max() > 0 else over_loads
    same_kind = kind[gauge][:, None] == kind[gauge]
    own = np.asarray(gauge[:, None] == gauge, dtype=np.float64)
    if model.inputs.twin.gauge_positions is not None:
        own = (1.0 - SMOOTH) * own + SMOOTH * same_kind * model.inputs.difference.smooth[np.ix_(gauge, gauge)]
    return np.asarray(own * (first + over_loads) + same_kind * common)


def _courses(model: LinearModel) -> list[Floats]:
    """Return the courses (n,) of an error over the readings: the same in all, and along each load that varies."""
    applied = np.array([amounts_of(load) for load in model.loads])
    found = [np.ones(model.n)]
    for column in applied.T:
        half = np.ptp(column) / 2.0
        if half > 0.0:
            x = (column - column.min()) / half - 1.0
            found += [x, 1.5 * x**2 - 0.5] if len(np.unique(column)) > 2 else [x]
    return found


def own_error(model: LinearModel, candidate: int) -> Floats:
    """Return s_j A_j (n,): what a signature may be wrong by at each reading."""
    inputs, gauge, own = model.inputs, model.gauge, model.signatures[:, candidate]
    share = np.broadcast_to(inputs.candidates[candidate].signature_errors, len(inputs.twin.gauges))
    wrong = share[list(inputs.order)][gauge]
    if inputs.twin.gauge_positions is None or not wrong.any():
        return np.asarray(wrong * own)
    kind = inputs.frame.kind
    near = along(inputs.twin, inputs.campaign.gauges, NEARBY) * (kind[:, None] == kind)
    squares = np.zeros((len(inputs.averages), len(inputs.order)))
    squares[model.average, gauge] = own**2
    about = np.sqrt(squares @ near / near.sum(axis=0))[model.average, gauge]
    return np.asarray(wrong * np.maximum(np.abs(own), about))


def between(model: LinearModel, candidate: int) -> Floats:
    """Return BETWEEN (c_k S_k - S_j) (n, r) of the neighbours k of a candidate j."""
    if not model.inputs.candidates[candidate].n_between:
        return np.zeros((model.n, 0))
    near, own = neighbours(model, candidate), model.signatures
    return np.asarray(BETWEEN * (scales_of(model, near, candidate) * own[:, near] - own[:, [candidate]]))


def neighbours(model: LinearModel, candidate: int) -> list[int]:
    """Return the places of the same effect whose signatures are most like the candidate's, most alike first."""
    name, white = model.inputs.priors.name, model.whitened
    others = np.flatnonzero((name == name[candidate]) & (np.arange(len(name)) != candidate))
    common = white.signatures[:, others].T @ white.signatures[:, candidate]
    share = common * np.abs(common) / np.maximum(white.lengths[others] * white.lengths[candidate], 1e-300)
    near = np.argsort(-share, kind="stable")[: model.inputs.candidates[candidate].n_between]
    return [int(k) for k in others[near[share[near] > ALIKE]]]


def scales_of(model: LinearModel, near: Sequence[int], candidate: int) -> Floats:
    """Return c_k (n_near,), the best scale of each neighbour k as an imitation of a candidate."""
    white = model.whitened
    return np.asarray(white.signatures[:, near].T @ white.signatures[:, candidate] / white.lengths[near])


def propagated(model: LinearModel, members: Members) -> Floats:
    """Return the members' signatures (n, n_members), propagated through those that act on readings."""
    own = model.signatures[:, list(members)]
    acting = [j for j in members if model.inputs.candidates[j].acts_on_readings]
    if not acting or len(members) == len(acting):
        return own
    changes = [
        np.sum([_change(model, j, through) for through in acting], axis=0) if j not in acting else np.zeros(model.n)
        for j in members
    ]
    return np.asarray(own + np.array(changes).T)


def _change(model: LinearModel, candidate: int, through: int) -> Floats:
    """Return what an effect on readings does to a signature (n,): a dead gauge hides it, a swapped one moves it."""
    inputs = model.inputs
    rows = np.zeros((len(inputs.averages), len(inputs.order)))
    rows[model.average, model.gauge] = model.signatures[:, candidate]
    chosen = inputs.candidates[through]
    moved = np.array([on_readings(inputs, chosen.effect, (chosen.place,), row)[0] for row in rows])
    return np.asarray(moved[model.average, model.gauge])
