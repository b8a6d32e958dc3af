"""Plain evidence for causes, with several tests of the sound asset.

    reading = r_k + f_h(s) + noise,    s ~ N(m_h, S_h), not below 0,    noise ~ N(0, C_k + diag(e_h(s))^2 + diag(x_h)^2)

The sound asset is one of the references r_k: a test of it, seen again (C_k small) or on another day (C_k wide). Each
hypothesis h is a cause or several. Its sizes s are found by Gauss and Newton in each reference; Laplace's integral over
them is its evidence there, exact where f_h is linear. e_h is the relative error of what the twin says, x_h how much a
cause may shift a reading by itself. Sizes and probabilities are mixtures over the references.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, logsumexp, ndtr

from femlib.arrays import BoolArray, FloatArray

N_STEPS = 8
STEP, CLOSE = 1e-3, 1e-4
"""Of a prior standard deviation: for the tangent, and by which sizes still move when they are found."""
FARTHEST = 4.0
"""Prior standard deviations within which a size is looked for."""


@dataclass(frozen=True, slots=True)
class Named:
    """A cause as the answer names it."""

    kind: str
    place: str
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A test of the sound asset: its readings (n,), how a reading scatters about it (n, n), and its weight."""

    readings: FloatArray
    covariance: FloatArray
    weight: float


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """Causes that act together.

    Attributes
    ----------
    causes
        none: the asset is sound.
    change
        what sizes (k,) change of the readings (n,).
    mean, sd
        (k,) prior of the sizes.
    prior
        probability before any reading.
    error
        standard deviation (n,) of the change at sizes (k,), or its share of the change.
    extra_mean, extra_sd
        (n,) shift of each reading that comes with the causes, whatever their sizes.
    is_signed
        whether sizes may be negative.
    """

    causes: tuple[Named, ...]
    change: Callable[[FloatArray], FloatArray]
    mean: FloatArray
    sd: FloatArray
    prior: float
    error: float | Callable[[FloatArray], FloatArray]
    extra_mean: FloatArray
    extra_sd: FloatArray
    is_signed: bool = False

    def error_at(self, sizes: FloatArray) -> FloatArray:
        """Return the standard deviation (n,) of the change at these sizes."""
        return self.error(sizes) if callable(self.error) else self.error * np.abs(self.change(sizes))


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A hypothesis with its probability, its sizes (k, 3: middle, low, high of 90 %) and its best reference."""

    hypothesis: Hypothesis
    probability: float
    sizes: FloatArray
    reference: int

    @property
    def causes(self) -> tuple[Named, ...]:
        """What acts."""
        return self.hypothesis.causes


def judge(readings: FloatArray, references: Sequence[Reference], hypotheses: Sequence[Hypothesis]) -> list[Judged]:
    """Return every hypothesis with its probability, most probable first; readings that are NaN are left out."""
    seen = np.isfinite(readings)
    weights = np.log([reference.weight for reference in references])
    rests = np.array([(readings - reference.readings)[seen] for reference in references])
    covariances = np.array([reference.covariance[np.ix_(seen, seen)] for reference in references])
    found = []
    for hypothesis in hypotheses:
        log, size, sd = _fit(seen, rests, covariances, hypothesis)
        logs = weights - logsumexp(weights) + log
        sizes = _mixed(np.exp(logs - logsumexp(logs)), size, sd)
        sizes = sizes if hypothesis.is_signed else np.maximum(sizes, 0.0)
        found.append((np.log(hypothesis.prior) + logsumexp(logs), hypothesis, sizes, int(np.argmax(logs))))
    scale = logsumexp([log for log, *_ in found])
    judged = [Judged(h, float(np.exp(log - scale)), sizes, best) for log, h, sizes, best in found]
    return sorted(judged, key=lambda one: -one.probability)


def _fit(
    seen: BoolArray, rests: FloatArray, covariances: FloatArray, hypothesis: Hypothesis
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return log evidence (m,), sizes (m, k) and their standard deviations (m, k) in each of m references."""
    rests = rests - hypothesis.extra_mean[seen]
    fixed = covariances + np.diag(hypothesis.extra_sd[seen] ** 2)
    mean, sd, n = hypothesis.mean, hypothesis.sd, rests.shape[1]
    size, precise = np.tile(mean, (len(rests), 1)), np.diag(sd**-2.0)
    limits = mean - FARTHEST * sd, mean + FARTHEST * sd
    for _ in range(N_STEPS if len(mean) else 0):
        here, tangent, whole = _linear(seen, size, fixed, hypothesis)
        weighed = np.linalg.solve(whole, tangent)
        target = rests - here + np.einsum("mnk,mk->mn", tangent, size)
        right = np.einsum("mnk,mn->mk", weighed, target) + mean / sd**2
        before = size
        size = np.linalg.solve(tangent.transpose(0, 2, 1) @ weighed + precise, right[..., None])[..., 0]
        size = np.clip(size, *limits)
        if np.all(np.abs(size - before) < CLOSE * sd):
            break
    here, tangent, whole = _linear(seen, size, fixed, hypothesis)
    left = rests - here
    log = -0.5 * np.einsum("mn,mn->m", left, np.linalg.solve(whole, left[..., None])[..., 0])
    log -= 0.5 * (np.linalg.slogdet(whole)[1] + n * np.log(2.0 * np.pi))
    spread = np.linalg.inv(tangent.transpose(0, 2, 1) @ np.linalg.solve(whole, tangent) + precise)
    own = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
    log += 0.5 * np.linalg.slogdet(spread)[1] - np.sum(0.5 * ((size - mean) / sd) ** 2 + np.log(sd), axis=1)
    if not hypothesis.is_signed:
        log += np.sum(log_ndtr(size / own) - log_ndtr(mean / sd), axis=1)
    return log, size, own


def _linear(
    seen: BoolArray, size: FloatArray, fixed: FloatArray, hypothesis: Hypothesis
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return change (m, n), tangent (m, n, k) and covariance (m, n, n) at the sizes (m, k)."""
    here = np.array([hypothesis.change(one)[seen] for one in size])
    tangent = np.zeros((*here.shape, size.shape[1]))
    for k, step in enumerate(STEP * np.diag(hypothesis.sd)):
        tangent[:, :, k] = (np.array([hypothesis.change(one + step)[seen] for one in size]) - here) / step[k]
    doubt = np.array([hypothesis.error_at(one)[seen] for one in size])
    return here, tangent, fixed + doubt[:, :, None] ** 2 * np.eye(here.shape[1])


def _mixed(share: FloatArray, middle: FloatArray, spread: FloatArray) -> FloatArray:
    """Return median, 5 % and 95 % quantile of mixtures of normal sizes (k, 3)."""
    found = []
    for mean, sd in zip(middle.T, spread.T, strict=True):
        grid = np.linspace((mean - 4.0 * sd).min(), (mean + 4.0 * sd).max(), 400)
        below = ndtr((grid[:, None] - mean) / sd) @ share
        found.append(np.interp([0.5, 0.05, 0.95], below, grid))
    return np.array(found).reshape(-1, 3)
