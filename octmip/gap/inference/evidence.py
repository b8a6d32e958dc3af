"""The evidence of a set of candidates, in closed form from the Gram matrix of a linear model.

For candidates A with sizes ~ N(m, P), P diagonal, and Lambda = P^-1 + G_AA, eta = P^-1 m + b_A:

    log p(y | A) - log p(y | none) = (eta' Lambda^-1 eta - m' P^-1 m - log det(P Lambda)) / 2,
    sizes | y, A ~ N(Lambda^-1 eta, Lambda^-1);

a size between physical bounds [l, h] (one-sided: [0, inf)) multiplies the evidence by the share of the posterior that
lies between them over that of the prior, exact for one such size and, for several, as if they were independent a
posteriori. The scale mixture sums this over all combinations of `SCALES`.
Source: MacKay (1992), "Bayesian interpolation", Neural Computation 4, for the Gaussian evidence of linear models.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from octmip.gap.inference.candidates import SCALES, Priors
from octmip.gap.inference.linear_model import LinearModel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Members = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Evidence and sizes if exactly the candidates `members` act.

    Attributes
    ----------
    members
        ascending candidate indices.
    log_factor
        log evidence over that of no effect, given the linear model.
    size
        (n_members,) posterior means, in each effect's unit.
    covariance
        (n_members, n_members).
    level
        of the errors of the members' signatures that bears the readings best.
    """

    members: Members
    log_factor: float
    size: Floats
    covariance: Floats
    level: float = 0.0


def mixed(fits: Sequence[Fit], log_shares: Floats, levels: Sequence[float]) -> Fit:
    """Return one set's fits at several levels of error, of these log weights (n_levels,) beside their evidence, as one.

    The weights hold what each level changes in the evidence of no effect.
    """
    logs = np.array([one.log_factor for one in fits]) + log_shares
    total = float(np.logaddexp.reduce(logs))
    sizes, covariances = np.array([one.size for one in fits]), np.array([one.covariance for one in fits])
    size, covariance = mixture(np.exp(logs - total), sizes, covariances)
    return Fit(fits[0].members, total, size, covariance, levels[int(np.argmax(logs))])


def mixture(share: Floats, mean: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """Return mean (..., m) and covariance (..., m, m) of a mixture.

    Parameters
    ----------
    share, mean, covariance
        of its k parts: (..., k), (..., k, m) and (..., k, m, m).
    """
    middle = np.einsum("...k,...ki->...i", share, mean)
    away = mean - middle[..., None, :]
    spread = covariance + away[..., :, None] * away[..., None, :]
    return middle, np.einsum("...k,...kij->...ij", share, spread)


def alike(prior: Priors, sets: Sequence[Members]) -> list[list[Members]]:
    """Return the sets grouped by where they hold discrete effects: those of one group share their arrays' shape."""
    groups: dict[tuple[bool, ...], list[Members]] = {}
    for members in sets:
        groups.setdefault(tuple(prior.is_discrete[list(members)].tolist()), []).append(members)
    return list(groups.values())


def fits_of(prior: Priors, sets: Sequence[Members], gram: Floats, projection: Floats) -> list[Fit]:
    """Return the fits of sets of one group (see `alike`) from their (n_sets, m, m) Gram matrices and (n_sets, m) b."""
    discrete = prior.is_discrete[list(sets[0])]
    if not len(discrete):
        return [Fit((), 0.0, np.zeros(0), np.zeros((0, 0))) for _ in sets]
    index = np.array(sets)
    choices = np.array(list(product(*[(1.0,) if is_discrete else SCALES for is_discrete in discrete])))
    sd = prior.sd[index][:, None] * choices
    logs, sizes, covariances = _gaussians(
        gram[:, None], projection[:, None], prior.mean[index][:, None], sd, prior.bounds[:, index][:, :, None]
    )
    total = np.logaddexp.reduce(logs, axis=1) - np.log(len(choices))
    size, covariance = mixture(np.exp(logs - total[:, None]) / len(choices), sizes, covariances)
    rows = zip(sets, total.tolist(), size, covariance, strict=True)
    return [Fit(members, value, mean, spread) for members, value, mean, spread in rows]


def _gaussians(
    gram: Floats, projection: Floats, mean: Floats, sd: Floats, bounds: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return log evidence (...), sizes (..., m) and covariances (..., m, m) for Gram matrices and priors (..., m).

    The bounds are (2, ..., m), the lower ones first.
    """
    covariance = np.asarray(np.linalg.inv(gram + (sd**-2)[..., None] * np.eye(sd.shape[-1])), dtype=np.float64)
    eta = mean / sd**2 + projection
    size = np.einsum("...ij,...j->...i", covariance, eta)
    log_det = 2.0 * np.log(sd).sum(axis=-1) - np.linalg.slogdet(covariance)[1]
    value = 0.5 * ((eta * size).sum(axis=-1) - (mean**2 / sd**2).sum(axis=-1) - log_det)
    if np.isfinite(bounds).any():
        spread = np.sqrt(np.einsum("...ii->...i", covariance))
        share = log_between(size, spread, bounds) - log_between(mean, sd, bounds)
        value = value + np.where(np.isfinite(bounds).any(axis=0), share, 0.0).sum(axis=-1)
        size, cut = _between(size, spread, bounds)
        ratio = cut / spread
        covariance = covariance * ratio[..., :, None] * ratio[..., None, :]
    return value, size, covariance


def log_between(mean: Floats, sd: Floats, bounds: Floats) -> Floats:
    """Return the log of the share of normals (...) between bounds (2, ...)."""
    low, high = (bounds[0] - mean) / sd, (bounds[1] - mean) / sd
    turned = low > 0.0  # the upper tail is the lower one of the mirror image, where logs are exact
    low, high = np.where(turned, -high, low), np.where(turned, -low, high)
    above, below = log_ndtr(high), log_ndtr(low)
    return np.asarray(above + np.log1p(-np.exp(np.minimum(below - above, -1e-16))))


def _between(size: Floats, spread: Floats, bounds: Floats) -> tuple[Floats, Floats]:
    """Return mean and sd of normals cut to what lies between bounds (2, ...)."""
    log_share = log_between(size, spread, bounds)
    low, high = (bounds[0] - size) / spread, (bounds[1] - size) / spread
    at_low, at_high = (np.exp(-0.5 * z**2 - 0.5 * np.log(2 * np.pi) - log_share) for z in (low, high))
    weighted = [np.where(np.isfinite(z), z, 0.0) * height for z, height in ((low, at_low), (high, at_high))]
    shift = at_low - at_high
    variance = np.maximum(1e-9, 1.0 + weighted[0] - weighted[1] - shift**2)
    return np.clip(size + spread * shift, bounds[0], bounds[1]), spread * np.sqrt(variance)


def extensions(model: LinearModel, members: Members, among: Ints | None = None) -> tuple[Floats, Floats]:
    """Return log_factor (n_candidates,) of `members` with each candidate added, and what is new in each.

    The members have the prior of scale 1, the added candidate sums over the scale mixture. What is new is the share of
    its squared length that the members leave. Good for choosing, not for reporting: `Inference.fit` is exact. The log
    factor is -inf for the members themselves, and for all but the candidates `among` (k,) where these are given.
    """
    prior, index = model.inputs.priors, list(members)
    some = np.arange(len(prior.sd)) if among is None else among
    white = model.white if among is None else model.whiten(model.signatures[:, among])
    own, lengths = model.whiten(model.signatures[:, index]), np.einsum("ij,ij->j", white, white)
    inner, cross = own.T @ own, white.T @ own
    gram = np.empty((len(some), len(index) + 1, len(index) + 1))
    gram[:, :-1, :-1], gram[:, -1, :-1], gram[:, :-1, -1], gram[:, -1, -1] = inner, cross, cross, lengths
    gain = np.column_stack([np.tile(own.T @ model.left, (len(some), 1)), white.T @ model.left])
    total, new = np.full(len(prior.sd), -np.inf), np.zeros(len(prior.sd))
    total[some] = last_added(
        prior, np.column_stack([np.tile(np.array(index, dtype=np.int64), (len(some), 1)), some]), gram, gain
    )
    total[index] = -np.inf
    open_ = np.linalg.inv(inner + np.diag(prior.sd[index] ** -2))
    new[some] = 1.0 - np.einsum("ij,jk,ik->i", cross, open_, cross) / np.maximum(lengths, 1e-300)
    return total, new


def last_added(prior: Priors, index: Ints, gram: Floats, projection: Floats) -> Floats:
    """Return the log evidence (n,) of sets (n, m) of which the last members alone sum over the scale mixture.

    Parameters
    ----------
    gram, projection
        (n, m, m) Gram matrices and (n, m) b.
    """
    scale = np.ones((len(SCALES), index.shape[1]))
    scale[:, -1] = SCALES
    sd = prior.sd[index][:, None] * np.where(prior.is_discrete[index][:, None], 1.0, scale)
    bounds = prior.bounds[:, index][:, :, None].copy()
    bounds[..., :-1] = np.array([-np.inf, np.inf])[:, None, None, None]
    logs = _gaussians(gram[:, None], projection[:, None], prior.mean[index][:, None], sd, bounds)[0]
    return np.asarray(np.logaddexp.reduce(logs, axis=1) - np.log(len(SCALES)))
