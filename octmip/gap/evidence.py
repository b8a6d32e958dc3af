"""The evidence of a set of columns, in closed form from the Gram matrix of a scene.

For columns A with sizes ~ N(m, P), P diagonal, and Lambda = P^-1 + G_AA, eta = P^-1 m + b_A:

    log p(y | A) - log p(y | none) = (eta' Lambda^-1 eta - m' P^-1 m - log det(P Lambda)) / 2,
    sizes | y, A ~ N(Lambda^-1 eta, Lambda^-1);

a one-sided size multiplies the evidence by Phi(mu/s) / Phi(m0/s0), exact for one such size and, for several, as if they
were independent a posteriori. The scale mixture sums this over all combinations of `SCALES`.
Source: MacKay (1992), "Bayesian interpolation", Neural Computation 4, for the Gaussian evidence of linear models.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, logsumexp

from octmip.gap.library import SCALES
from octmip.gap.scene import Scene

Floats = NDArray[np.float64]
Members = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """What the readings say if exactly the columns `members` act.

    Attributes:
        members: ascending column indices.
        log_factor: log evidence over that of no effect, given the scene.
        size: (n_members,) posterior means, in each effect's unit.
        covariance: (n_members, n_members).
        scales: evidence with one factor on the prior sd of all members, over the mixture's, for each of `SCALES`.
    """

    members: Members
    log_factor: float
    size: Floats
    covariance: Floats
    scales: tuple[float, ...]


def fit(scene: Scene, members: Sequence[int]) -> Fit:
    """Return the exact evidence of a set, summed over the scale mixture, with the moments of the sizes."""
    index = list(members)
    prior = scene.setting.priors
    gram, pull = scene.gram[np.ix_(index, index)], scene.pull[index]
    mean, sd, one_sided = prior.mean[index], prior.sd[index], prior.one_sided[index]
    choices = list(product(*[(1.0,) if fact else SCALES for fact in prior.is_fact[index]]))
    parts = [_gaussian(gram, pull, mean, sd * np.array(choice), one_sided) for choice in choices]
    logs = np.array([part[0] for part in parts]) - np.log(len(parts))
    total = float(logsumexp(logs))
    share = np.exp(logs - total)
    size = np.einsum("k,ki->i", share, np.array([part[1] for part in parts]).reshape(len(parts), -1))
    second = sum(w * (c + np.outer(m, m)) for w, (_, m, c) in zip(share, parts, strict=True))
    free = ~prior.is_fact[index]
    alike = tuple(
        len(parts) * float(sum(s for s, c in zip(share, choices, strict=True) if (np.array(c)[free] == k).all()))
        for k in SCALES
    )
    return Fit(tuple(index), total, size, np.asarray(second) - np.outer(size, size), alike)


def _gaussian(
    gram: Floats, pull: Floats, mean: Floats, sd: Floats, one_sided: NDArray[np.bool_]
) -> tuple[float, Floats, Floats]:
    if not len(mean):
        return 0.0, mean, gram
    covariance = np.asarray(np.linalg.inv(gram + np.diag(sd**-2)), dtype=np.float64)
    eta = mean / sd**2 + pull
    size = covariance @ eta
    log_det = -np.linalg.slogdet(covariance)[1] + 2.0 * np.log(sd).sum()
    value = 0.5 * float(eta @ size - (mean**2 / sd**2).sum() - log_det)
    spread = np.sqrt(np.diag(covariance))
    if one_sided.any():
        value += float((log_ndtr(size / spread) - log_ndtr(mean / sd))[one_sided].sum())
        size, spread = _positive(size, spread, one_sided)
        ratio = spread / np.sqrt(np.diag(covariance))
        covariance = covariance * np.outer(ratio, ratio)
    return value, size, covariance


def _positive(size: Floats, spread: Floats, one_sided: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return mean and sd of normals, those that are one-sided cut to their positive half."""
    z = size / spread
    hazard = np.exp(-0.5 * z**2 - 0.5 * np.log(2 * np.pi) - log_ndtr(z))
    cut_size = size + spread * hazard
    cut_spread = spread * np.sqrt(np.maximum(1e-9, 1.0 - hazard * (hazard + z)))
    return np.where(one_sided, cut_size, size), np.where(one_sided, cut_spread, spread)


def extensions(scene: Scene, members: Members) -> Floats:
    """Return log_factor (n_columns,) of `members` with each column added in turn; -inf for those already in it.

    The sizes of `members` keep the prior of scale 1; the added one sums over the mixture. Good for choosing, not for
    reporting: `fit` is exact.
    """
    prior = scene.setting.priors
    index = list(members)
    within = scene.gram[np.ix_(index, index)] + np.diag(prior.sd[index] ** -2)
    eta = prior.mean[index] / prior.sd[index] ** 2 + scene.pull[index]
    start, variance, gain = 0.0, np.diag(scene.gram).copy(), scene.pull.copy()
    if index:
        inverse = np.linalg.inv(within)
        cross = scene.gram[index]
        variance -= np.einsum("ij,ik,kj->j", cross, inverse, cross)
        gain -= cross.T @ inverse @ eta
        log_det = np.linalg.slogdet(within)[1] + 2.0 * np.log(prior.sd[index]).sum()
        start = 0.5 * float(eta @ inverse @ eta - (prior.mean[index] ** 2 / prior.sd[index] ** 2).sum() - log_det)
    logs = []
    for scale in SCALES:
        sd = np.where(prior.is_fact, prior.sd, prior.sd * scale)
        precision = np.maximum(variance, 0.0) + sd**-2
        pulled = prior.mean / sd**2 + gain
        size, spread = pulled / precision, precision**-0.5
        value = 0.5 * (pulled**2 / precision - prior.mean**2 / sd**2 - np.log(precision * sd**2))
        logs.append(value + np.where(prior.one_sided, log_ndtr(size / spread) - log_ndtr(prior.mean / sd), 0.0))
    total = start + logsumexp(np.array(logs), axis=0) - np.log(len(SCALES))
    total[index] = -np.inf
    return np.asarray(total)
