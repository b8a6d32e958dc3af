"""Errors of the effects' own signatures: the misfit that a large effect leaves although its name is right.

A signature comes from a model: each gauge's part of it is known to some per cent, and where an effect may act anywhere
its places are samples of a continuum. Given that candidate j acts with size theta_j, the readings hold

    theta_j (S_j + E_j xi),   xi ~ N(0, I),

E_j = [s_j diag(S_j) gauge by gauge | BETWEEN (c_k S_k - S_j) of the nearest places k], c_k the best scale. So a set of
candidates is judged under C0 + Q Q', Q = [theta_j E_j]_j with the sizes as fitted; what grows with the effect is no
reason for a second one. With A = I + Q'Q in whitened coordinates

    G' = G - (Q'S)' A^-1 (Q'S),   b' = b - (Q'S)' A^-1 (Q'r),   log p0' = log p0 + ((Q'r)' A^-1 (Q'r) - log det A) / 2.

A discrete effect of the measuring chain (two wires swapped, a gauge dead) also acts on what the others change: their
signatures are propagated through it.
Source: Kennedy and O'Hagan (2001), J. R. Statist. Soc. B 63, section 2 (code inadequacy as a Gaussian of its own);
the sizes in Q are plugged in (empirical Bayes), which for a large effect is exact to the order of their relative error.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.inference.evidence import Fit, Members
from octmip.gap.inference.linear_model import OPEN_STATE, LinearModel, Whitened, open_states_of
from octmip.gap.inference.signatures import on_readings

Floats = NDArray[np.float64]

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
    root
        (n, r) whitened E.
    squared
        sum of its squares.
    """

    root: Floats
    squared: float


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
    chosen = model.inputs.candidates[candidate]
    parts = [np.zeros((model.n, 0))]
    error = chosen.signature_error
    if error > 0.0:
        own = model.signatures[:, candidate][:, None] * (model.gauge[:, None] == np.unique(model.gauge)[None, :])
        parts.append(error * model.whiten(own[:, np.abs(own).max(axis=0) > 0.0]))
    if chosen.n_between:
        parts.append(BETWEEN * _differences(model, candidate))
    joined = np.hstack(parts)
    return SignatureError(joined, float(np.sum(joined**2)))


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


def root_of(model: LinearModel, members: Members, size: Floats, errors: Sequence[SignatureError]) -> Floats | None:
    """Return whitened Q (n, r) of members of these sizes; None where neither errors nor propagation change them."""
    pairs = list(zip(size.tolist(), errors, strict=True))
    kept = [theta * error.root for theta, error in pairs if theta**2 * error.squared > NEGLIGIBLE]
    return np.hstack([*kept, np.zeros((model.n, 0))]) if kept or propagates(model, members) else None


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
