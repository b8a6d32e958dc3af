"""How far the gap closes when the effect is added, on readings that the effect's size was not fitted to.

One load level, then one test, is held out at a time (never single repeats: they share the bias). With r the residual
of a held-out entry, S theta the effect as fitted to the rest, and v the variance of noise alone,

    G0 = mean(r^2 - v),   G1 = mean((r - S theta)^2 - v),   closed = (G0 - G1) / (G0 - G*),

all noise-corrected mean squares [microstrain^2]; G* is what twin and asset differ by before any effect (the
discrepancy's variance, zero once a commissioning run is perfect). States that are unknown are fitted to the rest
under each hypothesis.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from octmip.gap.inference.evidence import Fit
from octmip.gap.inference.linear_model import OPEN_STATE, Scene
from octmip.gap.inference.signature_error import allowing, judge
from octmip.gap.location import noise_variance

Floats = NDArray[np.float64]

DRAWS = 400
"""Bootstrap draws behind the interval."""
LEAST_GAP = 2.0
"""G0 must exceed G* by so many standard errors before a share of it means anything."""


@dataclass(frozen=True, slots=True)
class HeldOut:
    """One load level or test held out.

    Attributes:
        name: what was held out.
        before, after: root mean square gap [microstrain], noise taken off.
        closed: share of the squared gap that closed.
    """

    name: str
    before: float
    after: float
    closed: float


@dataclass(frozen=True, slots=True, eq=False)
class Shrinkage:
    """The gap before and after.

    Attributes:
        before, after, floor: root mean square gap on held-out readings [microstrain], noise taken off; the floor is
        what
            twin and asset differ by before any effect.
        closed: share of the squared gap closed, NaN when there is no gap to close.
        low, high: its 90 % interval.
        held_out: by load and by test.
        chi2_before, chi2_after: per entry, all readings.
        p_after: of the chi-squared of what remains.
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


def measure_shrinkage(scene: Scene, members: Sequence[int], seed: int = 0) -> Shrinkage:
    """Return how far the columns `members` close the gap, the interval by a parametric bootstrap of the noise."""
    index = list(members)
    under_shape = allowing(scene, tuple(members))
    own = judge(scene, [tuple(members)])[0].fit
    noise = noise_variance(scene)
    parts = [(name, rows, _left(scene, index, rows)) for name, rows in _folds(scene)]
    floor = np.diag(scene.covariance) - noise - OPEN_STATE**2 * np.sum(scene.tangents**2, axis=1)
    held = [_held_out(name, scene.residual[rows], left, noise[rows], floor[rows]) for name, rows, left in parts]
    rows = np.concatenate([r for _, r, _ in parts]) if parts else np.zeros(0, dtype=np.int64)
    before = np.concatenate([left[0] for _, _, left in parts]) if parts else np.zeros(0)
    after = np.concatenate([left[1] for _, _, left in parts]) if parts else np.zeros(0)
    closed, low, high = _closed(before, after, noise[rows], floor[rows], np.random.default_rng(seed))
    squared = float(scene.white_residual @ scene.white_residual)
    remaining = under_shape.white_residual - under_shape.white[:, index] @ own.size
    left_over = float(remaining @ remaining)
    return Shrinkage(
        _rms(before, noise[rows]),
        _rms(after, noise[rows]),
        float(np.sqrt(max(0.0, float(floor[rows].mean())))) if len(rows) else float("nan"),
        closed,
        low,
        high,
        tuple(held),
        squared / scene.n,
        left_over / scene.n,
        chance_of_rest(under_shape, own),
    )


def chance_of_rest(scene: Scene, own: Fit) -> float:
    """Return the chance of a chi-squared as large as what the fitted columns leave of the readings."""
    left = scene.white_residual - scene.white[:, list(own.members)] @ own.size
    return float(chi2.sf(float(left @ left), max(1, scene.n - len(own.members))))


def _folds(scene: Scene) -> list[tuple[str, NDArray[np.int64]]]:
    """Return the rows of every load level and test that can be held out: the rest keeps two loads or another test."""
    setting = scene.setting
    cells = [setting.cell_of(b) for b in setting.blocks]
    loads = np.array([cells[b].load_factor for b in scene.block])
    tests = np.array([cells[b].test for b in scene.block])
    folds = []
    if len(set(loads.tolist())) >= 2:
        folds = [(f"load factor {load:g}", np.flatnonzero(loads == load)) for load in np.unique(loads)]
    one_load_each = len(set(zip(tests.tolist(), loads.tolist(), strict=True))) == len(set(tests.tolist()))
    open_cells = {setting.campaign.cells[k].test for group in setting.groups for k in group}
    if not one_load_each and len(set(tests.tolist())) >= 2:
        known = [test for test in dict.fromkeys(tests.tolist()) if test not in open_cells]
        folds += [(f"test {test}", np.flatnonzero(tests == test)) for test in known]
    return folds


def _left(scene: Scene, members: list[int], held: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return the held-out residuals without and with the effect, both fitted to the other rows."""
    rest = np.setdiff1d(np.arange(scene.n), held)
    covariance = scene.covariance[np.ix_(rest, rest)]
    columns = scene.signatures[:, members]
    solved = np.linalg.solve(covariance, np.column_stack([columns[rest], scene.residual[rest]]))
    effects = [scene.setting.columns[j].effect for j in members]
    precision = np.diag([(3.0 * e.prior_sd if e.prior_mean == 0.0 else e.prior_sd) ** -2 for e in effects])
    mean = np.array([e.prior_mean for e in effects])
    gram = columns[rest].T @ solved[:, :-1] + precision
    size = np.linalg.solve(gram, columns[rest].T @ solved[:, -1] + precision @ mean) if members else np.zeros(0)
    size = np.where([e.is_one_sided for e in effects], np.maximum(size, 0.0), size) if members else size
    carried = OPEN_STATE**2 * scene.tangents[held] @ scene.tangents[rest].T
    without = scene.residual[held] - carried @ solved[:, -1]
    within = columns[held] @ size + carried @ (solved[:, -1] - solved[:, :-1] @ size)
    return without, scene.residual[held] - within


def _held_out(name: str, residual: Floats, left: tuple[Floats, Floats], noise: Floats, floor: Floats) -> HeldOut:
    before, after = left
    squared = float(np.mean(before**2 - noise)), float(np.mean(after**2 - noise))
    gap = squared[0] - float(floor.mean())
    closed = (squared[0] - squared[1]) / gap if gap > 0.0 else float("nan")
    return HeldOut(name, _rms(before, noise), _rms(after, noise), closed)


def _rms(left: Floats, noise: Floats) -> float:
    return float(np.sqrt(max(0.0, float(np.mean(left**2 - noise))))) if len(left) else float("nan")


def _closed(
    before: Floats, after: Floats, noise: Floats, floor: Floats, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Return the share closed and its 90 % interval; NaN when the gap is not clear of noise and floor."""
    nan = float("nan")
    if not len(before):
        return nan, nan, nan
    first, second = float(np.mean(before**2 - noise)), float(np.mean(after**2 - noise))
    gap = first - float(floor.mean())
    error = float(np.sqrt(np.mean(2 * noise**2 + 4 * noise * before**2) / len(before)))
    if gap < LEAST_GAP * error:
        return nan, nan, nan
    draws = rng.standard_normal((DRAWS, len(before))) * np.sqrt(noise)
    g0 = np.mean((before + draws) ** 2 - 2 * noise, axis=1)
    g1 = np.mean((after + draws) ** 2 - 2 * noise, axis=1)
    shares = (g0 - g1) / np.maximum(g0 - float(floor.mean()), 0.1 * gap)
    low, high = np.quantile(shares, [0.05, 0.95])
    return (first - second) / gap, float(low), float(high)
