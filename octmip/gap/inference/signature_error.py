"""Errors of the effects' own signatures: the misfit that a large effect leaves although its name is right.

A signature comes from a model: each gauge's part of it is known to some per cent, and where an effect may act anywhere
its places are samples of a continuum. Given that candidate j acts with size theta_j, the readings hold

    theta_j (S_j + E_j xi),   xi ~ N(0, I),

E_j = [e_u s_j S_j of kind u | e_g s_j S_j at gauge g, each the same at all loads, along each load and bent over it |
BETWEEN (c_k S_k - S_j) of the nearest places k], c_k the best scale. How wrong a kind and a gauge are (e: not at all,
0.3, 1 or 3 times what the effect says) is integrated: at the values that bear the readings best exactly, the others by
their evidences, as if blocks were independent (`_chosen_levels`). So a set of candidates is judged under C0 + Q Q',
Q = [theta_j E_j]_j with the sizes as fitted; what grows with the effect is no reason for a second one, and a twin that
is exact pays little for the freedom. With A = I + Q'Q in whitened coordinates

    G' = G - (Q'S)' A^-1 (Q'S),   b' = b - (Q'S)' A^-1 (Q'r),   log p0' = log p0 + ((Q'r)' A^-1 (Q'r) - log det A) / 2.

A discrete effect of the measuring chain (two wires swapped, a gauge dead) also acts on what the others change: their
signatures are propagated through it.
Source: Kennedy and O'Hagan (2001), J. R. Statist. Soc. B 63, section 2 (code inadequacy as a Gaussian of its own);
the sizes in Q are plugged in (empirical Bayes), which for a large effect is exact to the order of their relative error.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.inference.evidence import Fit, Members
from octmip.gap.inference.linear_model import OPEN_STATE, LinearModel, Whitened, open_states_of
from octmip.gap.inference.signatures import on_readings
from octmip.twin import amounts_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEVELS = (0.0, 0.3, 1.0, 3.0)
"""Factors on the error of a signature at one gauge."""
QUALITIES: Mapping[tuple[float, ...], float] = {
    (0.97, 0.02, 0.007, 0.003): 0.3,
    (0.70, 0.15, 0.10, 0.05): 0.2,
    (0.10, 0.65, 0.20, 0.05): 0.2,
    (0.05, 0.20, 0.55, 0.20): 0.2,
    (0.03, 0.12, 0.35, 0.50): 0.1,
}
"""Qualities of a twin's signatures, exact, exact at most gauges, fair, usual, poor: probabilities of the levels at each
gauge, and of the quality itself."""
BETWEEN = 0.3
"""Sd of the weight of a neighbouring place: the truth lies anywhere up to half way to it."""
ALIKE = 0.5
"""Share of its squared length that a neighbour must have in common with the place."""
NEGLIGIBLE = 0.05
"""Sum of squared standard deviations (in those of the noise) below which errors of signatures change nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """A set judged under the errors of its own signatures.

    Attributes
    ----------
    fit
        sizes and evidence over that of no effect under the same errors.
    log_shift
        what those errors change in the evidence of no effect.
    root
        (n, r) whitened Q; r is 0 where the errors are negligible.
    """

    fit: Fit
    log_shift: float
    root: Floats

    @property
    def log_factor(self) -> float:
        """Log evidence over that of no effect without errors of signatures."""
        return self.fit.log_factor + self.log_shift


@dataclass(frozen=True, slots=True, eq=False)
class SignatureError:
    """The error of one candidate's signature per unit of its size.

    Attributes
    ----------
    of_kind, local
        (n_kinds or n_gauges, n, n_courses) whitened, what the part of the signature in each kind of reading, and in
        each reading by itself, may be wrong by.
    between
        (n, r) whitened, what lies between it and its neighbouring places.
    """

    of_kind: Floats
    local: Floats
    between: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """A set's part of the linear model under errors Q.

    Attributes
    ----------
    gram
        (m, m) G'.
    projection
        (m,) b'.
    log_shift
        log p0' - log p0.
    """

    gram: Floats
    projection: Floats
    log_shift: float


def error_of(model: LinearModel, candidate: int) -> SignatureError:
    """Return the error of a candidate's signature: gauge by gauge, and between its places."""
    chosen, kind = model.inputs.candidates[candidate], model.inputs.frame.kind
    own = chosen.signature_error * model.signatures[:, candidate][:, None] * np.array(_courses(model)).T
    alone = kind.max() == 0  # one kind wrong as a whole is a wrong size
    of_kind = _blocks(model, own[:, 1:] if alone else own, kind[model.gauge], int(kind.max()) + 1)
    local = _blocks(model, own, model.gauge, len(kind))
    between = BETWEEN * _differences(model, candidate) if chosen.n_between else np.zeros((model.n, 0))
    return SignatureError(of_kind, local, between)


def _blocks(model: LinearModel, columns: Floats, group: Ints, n_groups: int) -> Floats:
    """Return whitened (n_groups, n, n_columns) what columns (n, n_columns) are in each group of rows (n,)."""
    rows = group[None, :, None] == np.arange(n_groups)[:, None, None]
    apart = np.where(rows, columns, 0.0).transpose(1, 0, 2)
    return model.whiten(apart.reshape(model.n, -1)).reshape(apart.shape).transpose(1, 0, 2)


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


def _differences(model: LinearModel, candidate: int) -> Floats:
    """Return c_k S_k - S_j whitened (n, r) of the neighbours k of a candidate j."""
    near, white = neighbours(model, candidate), model.whitened.signatures
    return np.asarray(scales_of(model, near, candidate) * white[:, near] - white[:, [candidate]])


def propagates(model: LinearModel, members: Members) -> bool:
    """Return whether some member acts on readings, so that what the others change passes through it."""
    return len(members) > 1 and any(model.inputs.candidates[j].acts_on_readings for j in members)


def weighed_errors(size: Floats, errors: Sequence[SignatureError], left: Floats, kind: Ints) -> tuple[Floats, float]:
    """Return whitened Q (n, r) of members of these sizes, and the log of what all other Q weigh beside it.

    `left` is what the members leave of the whitened residual (n,), `kind` that of each gauge. Between places first,
    then kind by kind, then gauge by gauge, each of what the one before leaves.
    """
    root, beside = np.zeros((len(left), 0)), 0.0
    if not errors:
        return root, beside
    sized = list(zip(size.tolist(), errors, strict=True))
    between = [theta * error.between for theta, error in sized]
    root = np.hstack([part for part in between if np.sum(part**2) > NEGLIGIBLE] + [root])
    for blocks, group in (
        ([theta * error.of_kind for theta, error in sized], np.arange(kind.max() + 1)),
        ([theta * error.local for theta, error in sized], kind),
    ):
        rest = left - root @ np.linalg.solve(np.eye(root.shape[1]) + root.T @ root, root.T @ left)
        found, log_others = _chosen_levels(np.concatenate(blocks, axis=2), rest, group)
        root, beside = np.hstack([root, found]), beside + log_others
    return root, beside


def _chosen_levels(blocks: Floats, left: Floats, group: Ints) -> tuple[Floats, float]:
    """Return blocks (n_blocks, n, c) at the levels that bear `left` best, side by side, and what all others weigh.

    In block g, Q_g = e_g [theta_j E_jg]_j with e_g one of `LEVELS`, each with the evidence Z_ge; blocks of one group
    share the quality q that says how probable each level is:

        p = sum_q p_q prod_g sum_e w_qe Z_ge,    log Z_ge = (c' e^2 / (1 + e^2 s) c - log det (1 + e^2 s)) / 2.
    """
    at = np.flatnonzero(np.sum(blocks**2, axis=(1, 2)) > NEGLIGIBLE)
    if not len(at):
        return np.zeros((len(left), 0)), 0.0
    blocks = blocks[at]
    s, u = np.linalg.eigh(blocks.transpose(0, 2, 1) @ blocks)
    c = np.einsum("gcr,gc->gr", u, np.einsum("gnc,n->gc", blocks, left))
    square = np.square(np.array(LEVELS))[:, None, None]
    z = 0.5 * np.sum(square * c**2 / (1.0 + square * s) - np.log1p(square * np.maximum(s, 0.0)), axis=2)
    by_quality = np.log(np.array(list(QUALITIES)))[:, :, None] + z
    at_block, prior = np.logaddexp.reduce(by_quality, axis=1), np.log(np.array(list(QUALITIES.values())))
    chosen, beside = np.zeros(len(at), dtype=np.int64), 0.0
    for one in np.unique(group[at]):
        here = np.flatnonzero(group[at] == one)
        of_quality = prior + at_block[:, here].sum(axis=1)
        chosen[here] = np.argmax(by_quality[int(np.argmax(of_quality))][:, here], axis=0)
        beside += float(np.logaddexp.reduce(of_quality)) - float(z[chosen[here], here].sum())
    scaled = np.array(LEVELS)[chosen][:, None, None] * blocks
    return np.hstack([np.zeros((len(left), 0)), *(part for part, k in zip(scaled, chosen, strict=True) if k)]), beside


def reduced(model: LinearModel, white: Floats, root: Floats) -> Reduced:
    """Return what the part of the model with signatures `white` (n, m) becomes under the errors `root` (n, r)."""
    residual = model.whitened.residual
    if not root.shape[1]:
        return Reduced(white.T @ white, white.T @ residual, 0.0)
    across, along = root.T @ white, root.T @ residual
    factor = linalg.cho_factor(np.eye(root.shape[1]) + root.T @ root, lower=True, check_finite=False)
    solved = linalg.cho_solve(factor, np.column_stack([across, along]), check_finite=False)
    log_det = 2.0 * float(np.log(np.diag(factor[0])).sum())
    gram, projection = white.T @ white - across.T @ solved[:, :-1], white.T @ residual - across.T @ solved[:, -1]
    return Reduced(gram, projection, 0.5 * float(along @ solved[:, -1]) - 0.5 * log_det)


def propagated_signatures(model: LinearModel, members: Members) -> Floats:
    """Return the members' whitened signatures (n, n_members), propagated through those that act on readings."""
    white = model.whitened.signatures[:, list(members)]
    acting = [j for j in members if model.inputs.candidates[j].acts_on_readings]
    if not acting or len(members) == len(acting):
        return white
    moved = white.copy()
    for k, j in enumerate(members):
        if j not in acting:
            moved[:, k] += model.whiten(np.sum([_change(model, j, through) for through in acting], axis=0))
    return moved


def _change(model: LinearModel, candidate: int, through: int) -> Floats:
    """Return what an effect on readings does to a signature (n,): a dead gauge hides it, a swapped one moves it."""
    inputs = model.inputs
    rows = np.zeros((len(inputs.averages), len(inputs.order)))
    rows[model.average, model.gauge] = model.signatures[:, candidate]
    chosen = inputs.candidates[through]
    moved = np.array([on_readings(inputs, chosen.effect, (chosen.place,), row)[0] for row in rows])
    return np.asarray(moved[model.average, model.gauge])


def with_propagated(model: LinearModel, members: Members) -> LinearModel:
    """Return the model with the members' signatures propagated; itself where nothing changes."""
    index = list(members)
    own = propagated_signatures(model, members)
    if np.array_equal(own, model.whitened.signatures[:, index]):
        return model
    white, signatures = model.whitened.signatures.copy(), model.signatures.copy()
    white[:, index], signatures[:, index] = own, model.factor @ own
    whitened = Whitened(white, model.whitened.residual, model.whitened.log_none)
    return replace(model, whitened=whitened, signatures=signatures)


def with_errors(model: LinearModel, root: Floats) -> LinearModel:
    """Return the model with covariance C0 + L root root' L': white vectors shrink by (I + root root')^(-1/2)."""
    u, s, _ = np.linalg.svd(root, full_matrices=False)
    shrink = 1.0 - (1.0 + s**2) ** -0.5
    open_ = OPEN_STATE**2 * model.whiten(model.tangents)
    white, residual, open_ = (
        np.asarray(x - u @ (shrink.reshape(-1, *[1] * (x.ndim - 1)) * (u.T @ x)))
        for x in (model.whitened.signatures, model.whitened.residual, open_)
    )
    found = model.whitened.residual @ model.whitened.residual - residual @ residual
    log_none = model.whitened.log_none + 0.5 * float(found) - 0.5 * float(np.log1p(s**2).sum())
    whitened = Whitened(white, residual, log_none)
    return replace(model, whitened=whitened, open_states=open_states_of(open_, whitened))
