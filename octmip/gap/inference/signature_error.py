"""Errors of the effects' own shapes: what a large effect leaves although its name is right.

A signature comes from a model: each gauge's part of it is known to some per cent, and where an effect may act anywhere
its places are samples of a continuum. Given that column j acts with size theta_j, the readings hold

    theta_j (S_j + E_j xi),   xi ~ N(0, I),

E_j = [s_j diag(S_j) gauge by gauge | BETWEEN (c_k S_k - S_j) of the nearest places k], c_k the best scale. So a set of
columns is judged under C0 + Q Q', Q = [theta_j E_j]_j with the sizes as fitted; what grows with the effect is no reason
for a second one. With A = I + Q'Q in whitened coordinates

    G' = G - (Q'S)' A^-1 (Q'S),   b' = b - (Q'S)' A^-1 (Q'r),   log p0' = log p0 + ((Q'r)' A^-1 (Q'r) - log det A) / 2.

A fact (two wires swapped, a gauge dead) also acts on what the others change: their columns are carried through it.
Source: Kennedy and O'Hagan (2001), J. R. Statist. Soc. B 63, section 2 (code inadequacy as a Gaussian of its own);
the sizes in Q are plugged in (empirical Bayes), which for a large effect is exact to the order of their relative error.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.inference.evidence import Fit, Members, alike, fits, fits_of
from octmip.gap.inference.linear_model import OPEN_STATE, Scene, carried

Floats = NDArray[np.float64]

BETWEEN = 0.3
"""Sd of the weight of a neighbouring place: the truth lies anywhere up to half way to it."""
ALIKE = 0.5
"""Share of its squared length that a neighbour must have in common with the place."""
PASSES = 2
"""Fits of the sizes, each under the errors of the one before."""
NEGLIGIBLE = 0.05
"""Sum of squared standard deviations (in those of the noise) below which shape errors change nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Shaped:
    """A set judged under the errors of its own shapes.

    Attributes:
        fit: sizes and evidence over that of no effect under the same errors.
        log_shift: what those errors change in the evidence of no effect.
        root: (n, r) whitened Q; r is 0 where the errors are negligible.
    """

    fit: Fit
    log_shift: float
    root: Floats

    @property
    def log_factor(self) -> float:
        """Log evidence over that of no effect without errors of shape."""
        return self.fit.log_factor + self.log_shift


def judge(scene: Scene, sets: Sequence[Members]) -> list[Shaped]:
    """Return every set under the errors of its shapes; the scene keeps what was judged."""
    new = [members for members in dict.fromkeys(sets) if members not in scene.shaped]
    for members, own in zip(new, fits(scene, new), strict=True):
        scene.shaped[members] = Shaped(own, 0.0, np.zeros((scene.n, 0)))
    for _ in range(PASSES):
        large = {m: root for m in new if (root := _root(scene, m, scene.shaped[m].fit.size)) is not None}
        for group in alike(scene.setting.priors, list(large)):
            reduced = [_reduced(white_of(scene, m), scene.white_residual, large[m]) for m in group]
            gram, pull = np.array([r[0] for r in reduced]), np.array([r[1] for r in reduced])
            found = fits_of(scene.setting.priors, group, gram, pull)
            for members, own, (_, _, shift) in zip(group, found, reduced, strict=True):
                scene.shaped[members] = Shaped(own, shift, large[members])
    return [scene.shaped[members] for members in sets]


def clearness(scene: Scene, members: Members) -> Floats:
    """Return d' (n_members,) of each member from its own absence, the others refitted: `visibility` in `allowing`."""
    shaped = judge(scene, [members])[0]
    gram = _reduced(white_of(scene, members), scene.white_residual, shaped.root)[0]
    precision = np.diag((3.0 * scene.setting.priors.sd[list(members)]) ** -2)
    left = []
    for k in range(len(members)):
        others = np.arange(len(members)) != k
        cross = gram[others, k]
        within = (gram + precision)[np.ix_(others, others)]
        left.append(gram[k, k] - cross @ np.linalg.solve(within, cross))
    return np.asarray(np.abs(shaped.fit.size) * np.sqrt(np.maximum(left, 0.0)))


def allowing(scene: Scene, members: Members) -> Scene:
    """Return the scene under the errors of the shapes of `members`, their columns carried through its facts."""
    if members not in scene.allowed:
        shaped = judge(scene, [members])[0]
        own = _carried_scene(scene, members)
        scene.allowed[members] = under(own, shaped.root) if shaped.root.shape[1] else own
    return scene.allowed[members]


def under(scene: Scene, root: Floats) -> Scene:
    """Return the scene with covariance C0 + L root root' L': white vectors shrink by (I + root root')^(-1/2)."""
    u, s, _ = np.linalg.svd(root, full_matrices=False)
    shrink = 1.0 - (1.0 + s**2) ** -0.5
    open_ = OPEN_STATE**2 * linalg.solve_triangular(scene.factor, scene.tangents, lower=True, check_finite=False)
    white, residual, open_ = (
        np.asarray(x - u @ (shrink.reshape(-1, *[1] * (x.ndim - 1)) * (u.T @ x)))
        for x in (scene.white, scene.white_residual, open_)
    )
    found = scene.white_residual @ scene.white_residual - residual @ residual
    return replace(
        scene,
        white=white,
        white_residual=residual,
        lengths=np.einsum("ij,ij->j", white, white),
        pull=white.T @ residual,
        log_none=scene.log_none + 0.5 * float(found) - 0.5 * float(np.log1p(s**2).sum()),
        lean=open_.T @ white,
        lean_residual=open_.T @ residual,
        open_covariance=OPEN_STATE**2 * np.eye(open_.shape[1]) - open_.T @ open_,
    )


def white_of(scene: Scene, members: Members) -> Floats:
    """Return the members' whitened columns (n, n_members), carried through the facts among them."""
    white = scene.white[:, list(members)]
    facts = [j for j in members if scene.setting.columns[j].acts_on_readings]
    if not facts or len(members) == len(facts):
        return white
    moved = white.copy()
    for k, j in enumerate(members):
        if j not in facts:
            moved[:, k] += scene.whitened(np.sum([carried(scene, j, fact) for fact in facts], axis=0))
    return moved


def _carried_scene(scene: Scene, members: Members) -> Scene:
    index = list(members)
    own = white_of(scene, members)
    if own is scene.white or np.array_equal(own, scene.white[:, index]):
        return scene
    white, signatures = scene.white.copy(), scene.signatures.copy()
    white[:, index], signatures[:, index] = own, scene.factor @ own
    lengths = np.einsum("ij,ij->j", white, white)
    return replace(scene, white=white, signatures=signatures, lengths=lengths, pull=white.T @ scene.white_residual)


def _root(scene: Scene, members: Members, size: Floats) -> Floats | None:
    """Return whitened Q (n, r), None where it is negligible."""
    found = [(theta, *_errors(scene, j)) for j, theta in zip(members, size.tolist(), strict=True)]
    kept = [theta * errors for theta, errors, squared in found if theta**2 * squared > NEGLIGIBLE]
    carries = any(scene.setting.columns[j].acts_on_readings for j in members) and len(members) > 1
    return np.hstack([*kept, np.zeros((scene.n, 0))]) if kept or carries else None


def _errors(scene: Scene, column: int) -> tuple[Floats, float]:
    """Return whitened E (n, r) of a column and the sum of its squares; the scene keeps them."""
    if column not in scene.errors:
        chosen = scene.setting.columns[column]
        parts = [np.zeros((scene.n, 0))]
        if chosen.signature_error > 0.0:
            own = scene.signatures[:, column][:, None] * (scene.gauge[:, None] == np.unique(scene.gauge)[None, :])
            parts.append(chosen.signature_error * scene.whitened(own[:, np.abs(own).max(axis=0) > 0.0]))
        if chosen.n_between:
            parts.append(BETWEEN * _differences(scene, column))
        joined = np.hstack(parts)
        scene.errors[column] = joined, float(np.sum(joined**2))
    return scene.errors[column]


def neighbours(scene: Scene, column: int) -> list[int]:
    """Return the places of the same effect whose traces are most like the column's, most alike first."""
    name = scene.setting.priors.name
    others = np.flatnonzero((name == name[column]) & (np.arange(len(name)) != column))
    common = scene.white[:, others].T @ scene.white[:, column]
    share = common * np.abs(common) / np.maximum(scene.lengths[others] * scene.lengths[column], 1e-300)
    near = np.argsort(-share, kind="stable")[: scene.setting.columns[column].n_between]
    return [int(k) for k in others[near[share[near] > ALIKE]]]


def _differences(scene: Scene, column: int) -> Floats:
    """Return c_k S_k - S_j whitened (n, r) of the neighbours k of a column j."""
    near = neighbours(scene, column)
    scale = scene.white[:, near].T @ scene.white[:, column] / scene.lengths[near]
    return np.asarray(scale * scene.white[:, near] - scene.white[:, [column]])


def _reduced(white: Floats, residual: Floats, root: Floats) -> tuple[Floats, Floats, float]:
    """Return G', b' of the columns `white` (n, m) and the shift of log p0 under the errors `root`."""
    if not root.shape[1]:
        return white.T @ white, white.T @ residual, 0.0
    across, along = root.T @ white, root.T @ residual
    factor = linalg.cho_factor(np.eye(root.shape[1]) + root.T @ root, lower=True, check_finite=False)
    solved = linalg.cho_solve(factor, np.column_stack([across, along]), check_finite=False)
    log_det = 2.0 * float(np.log(np.diag(factor[0])).sum())
    gram, pull = white.T @ white - across.T @ solved[:, :-1], white.T @ residual - across.T @ solved[:, -1]
    return gram, pull, 0.5 * float(along @ solved[:, -1]) - 0.5 * log_det
