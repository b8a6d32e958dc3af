"""Shrinkage: how far the gap closes when an effect is added, on readings to which its size was not fitted.

One load level, then one test, is held out at a time (never single repeats: they share the bias). With r the residual
of a held-out entry, S theta the effect as fitted to the rest, and v the variance of noise alone,

    G0 = mean(r^2 - v),   G1 = mean((r - S theta)^2 - v),   closed = 1 - max(0, G1 - G*) / (G0 - G*),

all noise-corrected mean squares (of readings of several units, each over the variance of its noise); G* is what twin
and asset differ by before any effect (the discrepancy's variance, zero once a commissioning run is perfect). States
that are unknown are fitted to the rest under each hypothesis.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from octmip.gap.inference.confounding import ABSURD
from octmip.gap.inference.evidence import Fit
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.linear_model import OPEN_STATE, LinearModel
from octmip.twin import MICROSTRAIN, amounts_of

Floats = NDArray[np.float64]

DRAWS = 400
"""Bootstrap draws behind the interval."""
LEAST_GAP = 2.0
"""G0 must exceed G* by so many standard errors before its share means anything."""
LEAST_LEFT = 0.05
"""Share of what all readings say of a size that the others must still say where some are held out."""


@dataclass(frozen=True, slots=True)
class HeldOut:
    """One load level or test held out.

    Attributes
    ----------
    name
        what was held out.
    before, after
        root mean square gap, noise taken off.
    closed
        share of the squared gap that closed.
    """

    name: str
    before: float
    after: float
    closed: float


@dataclass(frozen=True, slots=True, eq=False)
class Shrinkage:
    """The gap before and after.

    Attributes
    ----------
    before, after, floor
        root mean square gap on held-out readings, noise taken off; the floor is the difference of twin
        and asset before any effect.
    closed
        share of the squared gap closed, NaN when there is no gap to close.
    low, high
        its 90 % interval.
    held_out
        by load and by test.
    chi2_before, chi2_after
        per entry, all readings.
    p_after
        of the chi-squared of what remains.
    unit
        of the gap.
    """

    before: float
    after: float
    floor: float
    closed: float
    low: float
    high: float
    held_out: tuple[HeldOut, ...]
    chi2_before: float
    chi2_after: float
    p_after: float
    unit: str = MICROSTRAIN


def measure_shrinkage(inference: Inference, members: Sequence[int]) -> Shrinkage:
    """Return how far the candidates `members` close the gap, the interval by a parametric bootstrap of the noise."""
    model, chosen = inference.model, tuple(members)
    allowing, own = inference.allowing(chosen).model, inference.fit(chosen)
    scale, shared = model.inputs.scale[model.gauge], model.scatter
    floor = np.diag(model.covariance) - np.diag(shared) - OPEN_STATE**2 * np.sum(model.tangents**2, axis=1)
    variances, folds = np.stack([np.diag(shared), floor]) / scale**2, _folds(model, chosen)
    left = [np.vstack([_residuals(model, chosen, held) / scale[held], variances[:, held]]) for held in folds.values()]
    whole = np.concatenate([np.zeros((4, 0)), *left], axis=1)
    rows = np.concatenate([np.zeros(0, dtype=np.int64), *folds.values()])
    closed, low, high = _closed(whole, _drawn(shared / np.outer(scale, scale))[:, rows])
    before, after, noise, known = whole
    remaining = allowing.rest(chosen, own.size)
    return Shrinkage(
        before=_rms(before, noise),
        after=_rms(after, noise),
        floor=_rms(np.sqrt(np.maximum(0.0, known)), np.zeros(len(rows))),
        closed=closed,
        low=low,
        high=high,
        held_out=tuple(_held_out(name, part) for name, part in zip(folds, left, strict=True)),
        chi2_before=float(model.left @ model.left) / model.n,
        chi2_after=float(remaining @ remaining) / model.n,
        p_after=chance_of_rest(allowing, own),
        unit=model.inputs.unit,
    )


def chance_of_rest(model: LinearModel, own: Fit) -> float:
    """Return the chance of a chi-squared as large as what the fitted candidates leave of the readings."""
    left = model.rest(own.members, own.size)
    return float(chi2.sf(float(left @ left), max(1, model.n - len(own.members))))


def _folds(model: LinearModel, members: Sequence[int]) -> dict[str, NDArray[np.int64]]:
    """Return the rows of load levels and tests that can be held out, by name.

    The rest keeps two loads or another test, and still says how large each of the candidates `members` is.
    """
    cells, words = model.inputs.campaign.cells, model.inputs.campaign.load_words
    loads, tests = model.loads, [cells[k].test for k in model.cells]
    folds = {}
    if len(set(loads)) >= 2:
        distinct = sorted(set(loads), key=amounts_of)
        folds = {words(load): np.flatnonzero([own == load for own in loads]) for load in distinct}
    open_tests = {cells[k].test for group in model.inputs.groups for k in group}
    if len(set(zip(tests, loads, strict=True))) > len(set(tests)) >= 2:  # tests of one load each are loads held out
        known = [test for test in dict.fromkeys(tests) if test not in open_tests]
        folds |= {f"test {test}": np.flatnonzero([own == test for own in tests]) for test in known}
    whole = _told(model, members, np.zeros(0, dtype=np.int64))
    return {name: held for name, held in folds.items() if np.all(_told(model, members, held) >= LEAST_LEFT * whole)}


def _told(model: LinearModel, members: Sequence[int], held: NDArray[np.int64]) -> Floats:
    """Return what the rows that are not held out say of each size (n_members,), beside the others: 1 / its variance."""
    rest = np.setdiff1d(np.arange(model.n), held)
    columns = model.signatures[rest][:, list(members)]
    gram = columns.T @ np.linalg.solve(model.covariance[np.ix_(rest, rest)], columns)
    absurd = np.diag((ABSURD * model.inputs.priors.sd[list(members)]) ** -2)
    return np.asarray(1.0 / np.diag(np.linalg.inv(gram + absurd)))


def _residuals(model: LinearModel, members: Sequence[int], held: NDArray[np.int64]) -> Floats:
    """Return residuals (2, n_held) of held-out rows without and with the effect, both fitted to the other rows."""
    rest = np.setdiff1d(np.arange(model.n), held)
    columns = model.signatures[:, list(members)]
    right = np.column_stack([columns[rest], model.residual[rest]])
    solved = np.asarray(np.linalg.solve(model.covariance[np.ix_(rest, rest)], right))
    size = _size(model, members, columns[rest], solved)
    through = OPEN_STATE**2 * model.tangents[held] @ model.tangents[rest].T
    without = model.residual[held] - through @ solved[:, -1]
    within = columns[held] @ size + through @ (solved[:, -1] - solved[:, :-1] @ size)
    return np.stack([without, model.residual[held] - within])


def _size(model: LinearModel, members: Sequence[int], columns: Floats, solved: Floats) -> Floats:
    """Return the sizes (n_members,) fitted to some rows; `solved` is C0^-1 (columns, residual) of these."""
    prior, index = model.inputs.priors, list(members)
    precision = np.diag(np.where(prior.is_discrete, prior.sd, 3.0 * prior.sd)[index] ** -2)
    gram = columns.T @ solved[:, :-1] + precision
    size = np.linalg.solve(gram, columns.T @ solved[:, -1] + precision @ prior.mean[index])
    return np.asarray(np.clip(size, *prior.bounds[:, index]))


def _square(left: Floats, noise: Floats) -> float:
    """Return the mean square of residuals, noise taken off; NaN of none."""
    return float(np.mean(left**2 - noise)) if len(left) else float("nan")


def _rms(left: Floats, noise: Floats) -> float:
    return float(np.sqrt(np.maximum(0.0, _square(left, noise))))


def _drawn(covariance: Floats) -> Floats:
    """Return draws (DRAWS, n) of noise: what wanders moves many means together."""
    values, vectors = np.linalg.eigh(covariance)
    normal = np.random.default_rng(0).standard_normal((DRAWS, len(covariance)))
    return np.asarray((normal * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)


def _held_out(name: str, left: Floats) -> HeldOut:
    """Return the gap of held-out rows (4, n), as `_closed` has them."""
    before, after, noise, floor = left
    rest, gap = (_square(part, noise) - float(floor.mean()) for part in (after, before))
    closed = 1.0 - max(0.0, rest) / gap if gap > 0.0 else np.nan
    return HeldOut(name, _rms(before, noise), _rms(after, noise), closed)


def _closed(left: Floats, draws: Floats) -> tuple[float, float, float]:
    """Return the share closed and its 90 % interval; NaN when the gap does not stand above noise and floor.

    Parameters
    ----------
    left
        (4, n) of held-out rows: residuals without and with the effect, variance of noise alone and of the floor.
    draws
        (n_draws, n) of noise.
    """
    before, after, noise, known = left
    nan = float("nan")
    if not len(before):
        return nan, nan, nan
    floor = float(known.mean())
    gap, rest = (_square(part, noise) - floor for part in (before, after))
    error = float(np.sqrt(np.mean(2 * noise**2 + 4 * noise * before**2) / len(before)))
    if gap < LEAST_GAP * error:
        return nan, nan, nan
    g0, g1 = (np.mean((part + draws) ** 2 - 2 * noise, axis=1) - floor for part in (before, after))
    low, high = np.quantile(1.0 - np.maximum(0.0, g1) / np.maximum(g0, 0.1 * gap), [0.05, 0.95])
    return 1.0 - max(0.0, rest) / gap, float(low), float(high)
