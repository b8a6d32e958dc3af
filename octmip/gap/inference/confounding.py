"""Confounding: candidates whose contributions these readings cannot tell apart.

Two candidates a and b are d' apart when the best b leaves of a's contribution, in standard deviations of the mean
readings,

    d'^2 = size_a^2 (G_aa - G_ab^2 / G_bb)      (b's size free, of the right sign and not absurd),
    d'^2 = |size_a a - b|^2                     (b a discrete effect of size 1),

with G the Gram matrix after whatever else is open (damage tangents, calibration, the other members of the set) has been
projected out. Below 3 no test on these readings separates them. What b leaves may also be no more than what b's own
signature is wrong by, of covariance E: then d'^2 is its square under C + E less what errors leave on average, the trace
of E (C + E)^-1.
"""

from collections.abc import Callable

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.inference.evidence import Fit, Members
from octmip.gap.inference.linear_model import LinearModel

Floats = NDArray[np.float64]
Errors = Callable[[int, float], Floats | None]
"""A candidate and its size -> the covariance (n, n) of the errors of its signature; None of none."""

SEPARABLE = 3.0
"""d' below which two effects are one group."""
VISIBLE = 4.4
"""d' from its own absence below which an effect is not named: the greatest of some hundred places in sound readings.

At 4.0 two of 120 sound machines of strangers were called faulty (seed 31), one of them for a friction of d' 4.1; at 4.2
a crosstalk of d' 4.3 stood beside the right name where 15 answers stood for the twin; at 4.5 one of 24 frames with a
fault was called sound (seed 12), with a gain of d' 4.4."""
ABSURD = 9.0
"""Sizes beyond this many prior sd are no explanation (three times the widest of the scale mixture)."""
IMPOSSIBLE = 30.0
"""The limit where the signatures are one: a gain of 20 % is named beside a modulus, -100 % not beside a dead gauge."""
EXACT = 0.5
"""d' below which two signatures are one."""
MOST_LEFT = 0.7
"""Share of a faint effect's own d' that an imitation may leave: half of its square, or it imitates nothing."""
SAME = 1e-6
"""One less the cosine of two signatures that are one by construction."""
POWER = 3.3 + 1.645
"""d' that a size needs to be seen with 95 % power past a threshold corrected for some hundred places."""


def distances_from(model: LinearModel, own: Fit, member: int, errors: Errors) -> Floats:
    """Return d' (n_candidates,) of every candidate from a member of a fitted set.

    It is infinite where a candidate leaves most of what the member does. The errors of a signature count at the place
    of each other effect that leaves least.

    Parameters
    ----------
    model
        under the errors of the set's signatures.
    own
        the fit of the set.
    errors
        of the others.
    """
    size = float(own.size[own.members.index(member)])
    gram = conditional_gram(model, tuple(j for j in own.members if j != member), member)
    d_prime, needed = _distances(model, gram, member, size)
    alone = abs(size) * float(np.sqrt(gram[1][member]))
    d_prime = np.where(d_prime < MOST_LEFT * alone, d_prime, np.inf)
    name = model.inputs.priors.name
    nearest = {int(name[j]): int(j) for j in np.argsort(-d_prime, kind="stable") if name[j] != name[member]}
    for j in (j for j in nearest.values() if SEPARABLE <= d_prime[j] < np.inf):
        error = errors(j, float(needed[j]))
        if error is not None:
            left = model.signatures[:, [member, j]] @ np.array([size, -needed[j]])
            others = 3.0 * model.inputs.priors.sd[list(own.members)] * model.signatures[:, list(own.members)]
            beside = others[:, [k for k, m in enumerate(own.members) if m != member]]
            d_prime[j] = min(d_prime[j], _beyond_errors(model.covariance + beside @ beside.T, error, left))
    return np.asarray(d_prime)


def _beyond_errors(covariance: Floats, error: Floats, left: Floats) -> float:
    """Return d' of what is left (n,) under errors of a covariance too, less what these leave on average."""
    factor = linalg.cho_factor(covariance + error, lower=True, check_finite=False)
    squared = float(left @ linalg.cho_solve(factor, left, check_finite=False))
    usual = float(np.trace(linalg.cho_solve(factor, error, check_finite=False)))
    return float(np.sqrt(max(0.0, squared - usual)))


def conditional_gram(model: LinearModel, others: Members, member: int) -> tuple[Floats, Floats]:
    """Return (G_aj, G_jj) (n_candidates,) each, the free candidates `others` projected out."""
    cross, diagonal = model.gram_rows([member])[0], model.lengths.copy()
    if others:
        index = list(others)
        sd = model.inputs.priors.sd[index]
        with_others = model.gram_rows(index)
        inverse = np.linalg.inv(with_others[:, index] + np.diag((3.0 * sd) ** -2))
        cross -= with_others.T @ inverse @ with_others[:, member]
        diagonal -= np.einsum("ij,ik,kj->j", with_others, inverse, with_others)
    return cross, np.maximum(diagonal, 0.0)


def _distances(model: LinearModel, gram: tuple[Floats, Floats], member: int, size: float) -> tuple[Floats, Floats]:
    """Return d' (n_candidates,) of every candidate from a member of this size, and the size that each needs for it."""
    cross, diagonal = gram
    prior = model.inputs.priors
    discrete, mean, sd = prior.is_discrete, prior.mean, prior.sd
    safe = np.maximum(diagonal, 1e-300)
    needed = np.where(discrete, mean, size * cross / safe)
    needed = np.where(discrete, mean, np.clip(needed, *prior.bounds))
    same_signature = size**2 * (diagonal[member] - cross**2 / safe) < EXACT**2
    limit = np.where(discrete, np.abs(mean), np.where(same_signature, IMPOSSIBLE, ABSURD) * sd)
    needed = np.clip(needed, -limit, limit)
    squared = size**2 * diagonal[member] - 2 * size * needed * cross + needed**2 * diagonal
    return np.sqrt(np.maximum(squared, 0.0)), needed


def ties(model: LinearModel) -> tuple[tuple[str, ...], ...]:
    """Return groups of effects that change these readings in one proportion, so that no size of any tells them apart.

    Two effects are one where each place of either has a place of the other with the same course over the readings;
    discrete effects, whose size is known, and effects that nothing shows are left out.
    """
    priors, columns = model.inputs.priors, model.signatures / np.sqrt(np.diag(model.noise))[:, None]
    lengths = np.linalg.norm(columns, axis=0)
    kept = np.flatnonzero(~priors.is_discrete & (lengths * priors.sd > EXACT))
    unit = columns[:, kept] / lengths[kept]
    alike = np.abs(unit.T @ unit) > 1.0 - SAME
    names, first = np.unique(priors.name[kept], return_index=True)  # places of one effect lie side by side
    if not len(names):
        return ()
    within = np.logical_and.reduceat(np.logical_or.reduceat(alike, first, axis=1), first, axis=0)
    called = {int(j): candidate.name for j, candidate in zip(priors.name, model.inputs.candidates, strict=True)}
    groups = {tuple(called[int(n)] for n in names[row]) for row in (within & within.T).reshape(len(names), len(names))}
    return tuple(sorted(group for group in groups if len(group) > 1))


def detectable(model: LinearModel) -> dict[str, float]:
    """Return for every effect the size that these readings would have shown with 95 % power, at a typical place."""
    sizes: dict[str, list[float]] = {}
    for candidate, length in zip(model.inputs.candidates, np.sqrt(model.lengths), strict=True):
        sizes.setdefault(candidate.name, []).append(POWER / max(float(length), 1e-12))
    return {name: float(np.median(found)) for name, found in sizes.items()}
