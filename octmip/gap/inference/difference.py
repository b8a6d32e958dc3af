r"""What twin and asset differ by before any effect: one Gaussian process, shared by commissioning run and campaign.

    r(g, L, z) = f(z, L) + delta(g, L, z) + wander(test, g, L) + noise,      delta ~ N(0, l^2 K)

    K(i, j) = (common^2 + smooth^2 k(g_i, g_j)) h_i h_j              readings of one kind: proportional, in common
            + [g_i = g_j] t_g^2 (own^2 h_i h_j + floor^2 p_i p_j     proportional, each reading its own
                               + constant^2 s_g^2 + bend^2 b_i b_j   constant, square
                               + course^2 s_g^2 q(L_i, L_j)          of several loads, a smooth course over them
                               + cell^2 [L_i = L_j] p_i p_j)         free in every cell
            + damage^2 c_i c_j (0.3 + 0.7 [g_i = g_j]) (0.5 + 0.5 [z_i = z_j])   what damage changes

with h the healthy prediction times the level of its kind, s the scale of a reading, p = s phi(L), phi the size of the
healthy predictions of its kind beside those at the reference load, b = s phi |phi|, c what the state changes in the
prediction, l the level of the whole and t the tail of one reading. A run of the same cells measures delta: it cancels,
up to the noise of both. Level of a kind and tail of a reading are learnt from the run alone, by its evidence
(`learnt`), so a reading that is poor in the twin is known to be, and still used. Tests of a run that differ by more
than their repeats wander: that covariance is learnt from them (`wander_of`) and holds for the campaign's tests too.

Source: Kennedy and O'Hagan (2001), "Bayesian calibration of computer models", J. R. Statist. Soc. B 63 (delta as a
Gaussian process); Rasmussen and Williams (2006), "Gaussian Processes for Machine Learning", eq. 2.23 and 2.24.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from octmip.gap.inference.rows import Frame, Rows
from octmip.gap.inference.whitening import log_normal
from octmip.gap.odds import Differences

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

KIND_LEVELS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
"""Levels of the differences of one kind of reading beside what is usual, looked at with a run."""
KIND_SPREAD = 1.0
"""Standard deviation of the logarithm of that level before any reading."""
TAILS = (1.0, 4.0, 16.0)
"""Factors on the differences of one reading beside those of its kind."""
TAIL_PRIOR = (0.93, 0.05, 0.02)
ALL_GAUGES, ALL_STATES = 0.3, 0.5
"""Shares of the variance of a change by damage that all gauges, and all states of a gauge, have in common."""
LENGTH = 0.3
"""Length over which the smooth part varies, as a share of the structure's extent."""
UNLIKELY = 0.01
"""Chance of differences between tests as great as those seen, in all readings or in one, above which nothing wanders:
two tests leave one degree of freedom, whose square is often large."""
POOR = 3.0
"""Times the usual difference from which a reading is called poor in the twin."""


@dataclass(frozen=True, slots=True, eq=False)
class Difference:
    """The prior of delta and of the wander between tests.

    Attributes
    ----------
    usual
        relative standard deviations at level 1.
    frame
        sizes and kinds of the readings.
    smooth
        (n_gauges, n_gauges) correlation along the structure.
    factor, tail
        (n_gauges,) level of each reading's kind, and of the reading beside it.
    wander
        (2, n_gauges, n_gauges) covariance between tests over s_g s_h: constant and proportional to phi.
    level
        of the whole; once a run has told the levels of kinds, of what damage changes alone.
    is_learnt
        whether a run has.
    has_course
        whether readings may have a course of their own over several loads: without a run that would hide every effect.
    """

    usual: Differences
    frame: Frame
    smooth: Floats
    factor: Floats
    tail: Floats
    wander: Floats
    level: float = 1.0
    is_learnt: bool = False
    has_course: bool = False

    def covariance(self, a: Rows, b: Rows) -> Floats:
        """Return K (n_a, n_b) with the wander of tests that both hold."""
        u, g, h = self.usual, a.gauge[:, None], b.gauge[None, :]
        same = g == h
        f = self.factor
        healthy = np.outer(f[a.gauge] * a.healthy, f[b.gauge] * b.healthy)
        alike = self.frame.kind[g] == self.frame.kind[h]
        found = np.where(alike, (u.common**2 + u.smooth**2 * self.smooth[g, h]) * healthy, 0.0)
        own = f * self.tail
        part = [own[x.gauge] * self.frame.scale[x.gauge] * x.share for x in (a, b)]
        bend = [own[x.gauge] * self.frame.scale[x.gauge] * x.share * np.abs(x.share) for x in (a, b)]
        flat = [own[x.gauge] * self.frame.scale[x.gauge] for x in (a, b)]
        free = np.where(a.load[:, None] == b.load[None, :], u.floor**2 + u.cell**2, u.floor**2)
        single = free * np.outer(*part) + u.constant**2 * np.outer(*flat) + u.bend**2 * np.outer(*bend)
        single += u.own**2 * np.outer(self.tail[a.gauge], self.tail[b.gauge]) * healthy
        if self.has_course and a.applied.shape[1] > 1:
            apart = np.sum((a.applied[:, None] - b.applied[None, :]) ** 2, axis=2)
            single += u.course**2 * np.outer(*flat) * np.exp(-0.5 * apart)
        found += np.where(same, single, 0.0)
        found *= 1.0 if self.is_learnt else self.level**2
        if a.change.any() and b.change.any():
            states = ALL_STATES + (1.0 - ALL_STATES) * (a.state[:, None] == b.state[None, :])
            gauges = np.where(same, 1.0, ALL_GAUGES)
            found += (self.level * u.damage) ** 2 * np.outer(a.change, b.change) * gauges * states
        return found + self._wander(a, b) if self.wander.any() else found

    def _wander(self, a: Rows, b: Rows) -> Floats:
        g, h = a.gauge[:, None], b.gauge[None, :]
        both = self.wander[0][g, h] + self.wander[1][g, h] * np.outer(a.share, b.share)
        scale = np.outer(self.frame.scale[a.gauge], self.frame.scale[b.gauge])
        return np.asarray(np.where(a.test[:, None] == b.test[None, :], both * scale, 0.0))

    def at(self, level: float) -> "Difference":
        """Return the difference at another level of the whole."""
        return replace(self, level=level)


def usual_difference(frame: Frame, usual: Differences, has_course: bool = False) -> Difference:
    """Return the difference to expect from the twin alone."""
    n = len(frame.order)
    none = np.zeros((2, n, n))
    return Difference(usual, frame, frame.along(LENGTH), np.ones(n), np.ones(n), none, has_course=has_course)


def learnt(difference: Difference, rows: Rows, residual: Floats, noise: Floats) -> Difference:
    """Return the difference with the levels of kinds and the tails of readings that a run bears best.

    Parameters
    ----------
    rows, residual, noise
        of the run: readings less the twin's predictions (n,), and the covariance (n, n) of their noise.
    """
    found = difference
    for _ in range(2):
        found = _with_tails(_with_levels(found, rows, residual, noise), rows, residual, noise)
    return replace(found, is_learnt=True)


def _with_levels(known: Difference, rows: Rows, residual: Floats, noise: Floats) -> Difference:
    factor = known.factor.copy()
    for kind in np.unique(known.frame.kind[rows.gauge]).tolist():
        here = np.flatnonzero(known.frame.kind[rows.gauge] == kind)
        own = noise[np.ix_(here, here)]
        unit = replace(known, factor=np.ones_like(factor), wander=np.zeros_like(known.wander))
        part = unit.covariance(rows.at(here), rows.at(here))
        wander = replace(known, level=0.0).covariance(rows.at(here), rows.at(here))
        tried = [log_normal(own + wander + level**2 * part, residual[here]) for level in KIND_LEVELS]
        logs = np.array(tried) - 0.5 * (np.log(KIND_LEVELS) / KIND_SPREAD) ** 2
        share = np.exp(logs - logs.max())
        factor[known.frame.kind == kind] = np.exp(share @ np.log(KIND_LEVELS) / share.sum())
    return replace(known, factor=factor)


def _with_tails(known: Difference, rows: Rows, residual: Floats, noise: Floats) -> Difference:
    tail = np.ones_like(known.tail)
    for gauge in np.unique(rows.gauge).tolist():
        here = np.flatnonzero(rows.gauge == gauge)
        logs = []
        for size, prior in zip(TAILS, TAIL_PRIOR, strict=True):
            tail[gauge] = size
            own = replace(known, tail=tail).covariance(rows.at(here), rows.at(here))
            logs.append(log_normal(noise[np.ix_(here, here)] + own, residual[here]) + np.log(prior))
        share = np.exp(np.array(logs) - max(logs))
        tail[gauge] = float(np.exp(share @ np.log(TAILS) / share.sum()))
    return replace(known, tail=tail)


def log_at_levels(difference: Difference, rows: Rows, residual: Floats, noise: Floats) -> float:
    """Return the log evidence of a run under a noise, at the level that bears it best, readings all alike."""
    own = difference.covariance(rows, rows)
    levels = [log_normal(noise + level**2 * own, residual) - 0.5 * np.log(level) ** 2 for level in KIND_LEVELS]
    return float(max(levels))


def wander_of(difference: Difference, rows: Rows, residual: Floats, noise: Floats) -> Floats:
    """Return the covariance (2, n_gauges, n_gauges) between tests of a run, over the scales: constant and proportional.

    In every cell that several tests hold the mean over them is taken off; what is left is fitted, test by test and
    reading by reading, by a constant and, where the tests have several loads, a part proportional to phi. The
    covariance of these over the tests less that of the noise is what tests wander by; covariances between readings are
    shrunk the more, the fewer the tests.
    """
    n = len(difference.frame.scale)
    tests = np.unique(rows.test)
    if len(tests) < 2:
        return np.zeros((2, n, n))
    left = _about_mean(rows, residual / difference.frame.scale[rows.gauge])
    n_parts = 2 if len(np.unique(rows.load)) > 1 and np.ptp(rows.share) > 0.0 else 1
    coefficients, spread = np.full((n_parts, len(tests), n), np.nan), np.zeros((n_parts, n))
    for t, test in enumerate(tests.tolist()):
        for g in range(n):
            here = np.flatnonzero((rows.test == test) & (rows.gauge == g) & np.isfinite(left))
            if not len(here):
                continue
            design = np.column_stack([np.ones(len(here)), rows.share[here]])[:, :n_parts]
            inverse = np.linalg.pinv(design)
            own = noise[np.ix_(here, here)] / difference.frame.scale[g] ** 2
            coefficients[:, t, g] = inverse @ left[here]
            spread[:, g] += np.diag(inverse @ own @ inverse.T) / len(tests)
    found = np.zeros((2, n, n))
    for k in range(n_parts):
        found[k] = _between(coefficients[k], spread[k])
    return found


def _about_mean(rows: Rows, values: Floats) -> Floats:
    """Return values (n,) less their mean over the tests that share gauge, load and state; NaN where only one does."""
    key = np.stack([rows.gauge, rows.load, rows.state])
    _, number = np.unique(key, axis=1, return_inverse=True)
    number = number.ravel()
    count = np.bincount(number)
    mean = np.bincount(number, values) / count
    return np.where(count[number] > 1, values - mean[number], np.nan)


def _between(coefficients: Floats, spread: Floats) -> Floats:
    """Return the covariance (n, n) of coefficients (n_tests, n) over tests, less the variance (n,) of their noise."""
    seen = np.isfinite(coefficients).all(axis=0)
    found = np.zeros((coefficients.shape[1],) * 2)
    if not seen.any():
        return found
    c = coefficients[:, seen]
    n_free = len(c) - 1
    raw = c.T @ c / n_free
    variance = np.maximum(np.diag(raw) - spread[seen], 0.0)
    ratio = n_free * np.diag(raw) / np.maximum(spread[seen], 1e-300)
    own = chi2.sf(ratio, n_free) * len(ratio)
    variance = np.where(np.minimum(own, chi2.sf(ratio.sum(), n_free * len(ratio))) < UNLIKELY, variance, 0.0)
    shrink = n_free / (n_free + 0.5 * c.shape[1])
    sd = np.sqrt(np.maximum(np.diag(raw), 1e-300))
    correlation = shrink * raw / np.outer(sd, sd)
    np.fill_diagonal(correlation, 1.0)
    found[np.ix_(seen, seen)] = correlation * np.sqrt(np.outer(variance, variance)) * (1.0 + 1.0 / n_free)
    return found


def poor_readings(difference: Difference, gauges: Sequence[str]) -> list[str]:
    """Return the readings whose difference a run shows to be several times the usual."""
    far = difference.factor * difference.tail > POOR
    return [name for name, is_far in zip(gauges, far, strict=True) if is_far]
