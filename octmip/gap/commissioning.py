"""What a commissioning run says of the difference d of twin and asset, and of its own noise.

The run's means are f + phi d + o psi + noise, stacked over cells and gauges: d with the prior l^2 K at level l, o what
each gauge shows beside it, the same at all loads (psi = 1) or as the load squared (psi = phi^2), zero or
N(0, (t s)^2) with t among `SIZES`; the noise wanders as each of its sizes says (`octmip.gap.campaign.wandering`). All
combinations are weighed by their evidence, and d is the mixture: a walk, a temperature or a bias of that day does not
enter the calibration, in the measure in which it is probable.

    P = Phi' V^-1 Phi,   h = Phi' V^-1 r,   q = r' V^-1 r,   o integrated out of all three,
    d ~ N(Q h, Q),   Q = (P + (l^2 K)^-1)^-1,
    log p(run | l) = (h' Q h - log det(I + l^2 K P) - q - log det 2 pi V) / 2
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import chi2

from octmip.errors import DataError
from octmip.gap.campaign.averages import AveragedCell, averages_of
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise import Noise
from octmip.gap.campaign.wandering import Wander
from octmip.gap.inference.discrepancy import LEVEL_PRIOR, LEVELS, Discrepancy, spread_levels, uncalibrated
from octmip.gap.odds import Differences
from octmip.gap.twins.cached import CachedTwin
from octmip.twin import Load

Floats = NDArray[np.float64]

POWERS = (0, 2)
"""How what does not grow as the twin goes with the load."""
SIZES = (0.003, 0.01, 0.03, 0.1)
"""Its sd at each gauge over the scale of the readings at the reference load."""
UNEVEN_PRIOR = 0.03
"""Probability that there is such a part, before any reading."""
BEHIND = 12.0
"""Log units behind the best size of the walk beyond which another one is not looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class _Normal:
    """The run under one noise and one offset, as quadratic forms in d.

    Attributes
    ----------
    precision, projection
        P (n_gauges, n_gauges) and h (n_gauges,).
    constant
        -(q + log det) / 2, the prior of the offset included.
    """

    precision: Floats
    projection: Floats
    constant: float


@dataclass(frozen=True, slots=True, eq=False)
class _Kind:
    """d under one kind of run at every level.

    Attributes
    ----------
    wander
        index of the run's noise.
    is_even
        whether all grows as the twin does.
    logs
        (n_levels,) log of prior times evidence.
    mean, covariance
        (n_levels, n_gauges), (n_levels, n_gauges, n_gauges).
    """

    wander: int
    is_even: bool
    logs: Floats
    mean: Floats
    covariance: Floats


@dataclass(frozen=True, slots=True, eq=False)
class RunEvidence:
    """What a run says under every size of its walk.

    Attributes
    ----------
    prior
        the difference before the run.
    p_values
        (n_wanders,) chance of a run as far from proportional to the twin's healthy readings.
    kinds
        every combination of noise and offset.
    """

    prior: Discrepancy
    p_values: tuple[float, ...]
    kinds: tuple[_Kind, ...]

    def calibrated(self, log_wander: Floats) -> tuple[Discrepancy, float]:
        """Return the difference and the log evidence of the run, given logs (n_wanders,) of what is known of its walk.

        These are the prior times what the repeats of the run say.
        """
        logs = np.array([kind.logs + log_wander[kind.wander] for kind in self.kinds])
        total = float(logsumexp(logs))
        share = np.exp(logs - total)
        mean = np.einsum("kl,klg->g", share, np.array([kind.mean for kind in self.kinds]))
        covariance = np.zeros((len(mean), len(mean)))
        for part, kind in zip(share, self.kinds, strict=True):
            offset = kind.mean - mean
            covariance += np.einsum("l,lij->ij", part, kind.covariance) + (part[:, None] * offset).T @ offset
        levels = share.sum(axis=0)
        even = np.array([kind.is_even for kind in self.kinds])
        best = max((k for k in range(len(even)) if even[k]), key=lambda k: float(logsumexp(logs[k])))
        found = replace(
            self.prior,
            mean=mean,
            covariance=covariance,
            log_levels=spread_levels(levels),
            is_calibrated=True,
            p_value=self.p_values[self.kinds[best].wander],
            own_level=float(levels @ LEVELS),
            uneven=float(share[~even].sum()),
        )
        return found, total


def read_run(run: Campaign, twin: CachedTwin, wanders: Sequence[Wander], load: Load, usual: Differences) -> RunEvidence:
    """Return what a run says of the gauges of its noise, at the reference load `load`, under every wander.

    Raises
    ------
    DataError
        the run holds an unknown state, or no load.
    """
    _check_run(run)
    gauges = wanders[0].noise.gauges
    prior = uncalibrated(twin, gauges, load, usual)
    rows = _Rows.of(run, twin, gauges, load, prior)
    if not rows.phi.any():
        raise DataError("the commissioning run holds readings at zero load only; expected two loads or more")
    kernels = [level**2 * prior.covariance for level in LEVELS]
    white = [_Whitened.of(rows, wander.noise) for wander in wanders]
    kinds = [_kind(k, one.without(), kernels, True) for k, one in enumerate(white)]
    weights = np.array([logsumexp(k.logs) + w.log_likelihood for k, w in zip(kinds, wanders, strict=True)])
    looked_at = [k for k, w in enumerate(wanders) if weights[k] > weights.max() - BEHIND or 0 in w.sizes]
    log_prior = float(np.log(UNEVEN_PRIOR / (len(POWERS) * len(SIZES))))
    for k in looked_at:
        for power in POWERS:
            kinds += [_kind(k, n, kernels, False, log_prior) for n in white[k].beside(power, prior.scale)]
    return RunEvidence(prior, tuple(one.p_value() for one in white), tuple(kinds))


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """The means of a run: what they are, and what they leave of the twin."""

    averages: tuple[AveragedCell, ...]
    loads: tuple[Load, ...]
    average: NDArray[np.int64]
    gauge: NDArray[np.int64]
    phi: Floats
    residual: Floats

    @classmethod
    def of(cls, run: Campaign, twin: CachedTwin, gauges: Sequence[str], load: Load, prior: Discrepancy) -> "_Rows":
        """Read a run."""
        order = [run.gauges.index(name) for name in gauges]
        columns = [twin.gauges.index(name) for name in gauges]
        reference = twin.predict({}, load)[columns]
        means = tuple(part.of_gauges(order) for part in averages_of(run, split=False))
        average, gauge = np.nonzero(np.array([part.count > 0 for part in means]))
        cells = [run.cells[part.cell] for part in means]
        predicted = np.array([twin.predict(_state(run, cell), cell.load)[columns] for cell in cells])
        phi = np.array([prior.share(twin.predict({}, cell.load)[columns], reference) for cell in cells])
        residual = (np.array([part.mean for part in means]) - predicted)[average, gauge]
        loads = tuple(cell.load for cell in cells)
        return cls(means, loads, average.astype(np.int64), gauge.astype(np.int64), phi[average], residual)


@dataclass(frozen=True, slots=True, eq=False)
class _Whitened:
    """Phi, the offsets' patterns by power, and the residual in units of the noise's Cholesky factor."""

    phi: Floats
    offset: Mapping[int, Floats]
    residual: Floats
    log_root: float

    @classmethod
    def of(cls, rows: _Rows, noise: Noise) -> "_Whitened":
        """Whiten rows by a noise."""
        n = len(noise.gauges)
        root = np.linalg.cholesky(noise.of_averages(rows.averages, rows.loads, rows.average, rows.gauge))
        own = (rows.gauge[:, None] == np.arange(n)).astype(np.float64)
        columns = [rows.phi[:, None] * own, *(rows.phi[:, None] ** power * own for power in POWERS), rows.residual]
        white = linalg.solve_triangular(root, np.column_stack(columns), lower=True)
        phi, *offsets = np.split(white[:, :-1], len(POWERS) + 1, axis=1)
        log_root = float(np.log(np.diag(root)).sum())
        return cls(phi, dict(zip(POWERS, offsets, strict=True)), white[:, -1], log_root)

    def without(self) -> _Normal:
        """Return the run where all grows as the twin does."""
        squared = float(self.residual @ self.residual)
        return _Normal(self.phi.T @ self.phi, self.phi.T @ self.residual, -0.5 * squared - self.log_root)

    def beside(self, power: int, scale: Floats) -> list[_Normal]:
        """Return the run with offsets of each of `SIZES` beside d."""
        plain, columns = self.without(), self.offset[power]
        within, across = columns.T @ columns, columns.T @ np.column_stack([self.phi, self.residual])
        found = []
        for size in SIZES:
            inner = within + np.diag((size * scale) ** -2.0)
            solved = np.linalg.solve(inner, across)
            precision = plain.precision - across[:, :-1].T @ solved[:, :-1]
            log_det = float(np.linalg.slogdet(inner)[1]) + 2.0 * float(np.log(size * scale).sum())
            constant = plain.constant + 0.5 * float(across[:, -1] @ solved[:, -1]) - 0.5 * log_det
            projection = plain.projection - across[:, :-1].T @ solved[:, -1]
            found.append(_Normal(0.5 * (precision + precision.T), projection, constant))
        return found

    def p_value(self) -> float:
        """Return the chance of what the best d leaves; 1 where the run has one load only."""
        plain = self.without()
        free = len(self.residual) - int(np.linalg.matrix_rank(plain.precision))
        if free <= 0:
            return 1.0
        best = np.linalg.lstsq(plain.precision, plain.projection, rcond=None)[0]
        return float(chi2.sf(float(self.residual @ self.residual) - float(plain.projection @ best), free))


def _kind(wander: int, normal: _Normal, kernels: Sequence[Floats], is_even: bool, log_prior: float = 0.0) -> _Kind:
    """Return d at every level."""
    known = [_posterior(kernel, normal.precision, normal.projection) for kernel in kernels]
    logs = np.log(LEVEL_PRIOR) + np.array([log for _, _, log in known]) + normal.constant + log_prior
    return _Kind(wander, is_even, logs, np.array([m for m, _, _ in known]), np.array([c for _, c, _ in known]))


def _posterior(prior: Floats, precision: Floats, projection: Floats) -> tuple[Floats, Floats, float]:
    """Return mean and covariance of d under a prior covariance, and the log evidence of the run (up to a constant)."""
    grown = np.eye(len(prior)) + prior @ precision
    covariance = np.linalg.solve(grown, prior)
    covariance = 0.5 * (covariance + covariance.T)
    mean = covariance @ projection
    return mean, covariance, 0.5 * float(projection @ mean) - 0.5 * float(np.linalg.slogdet(grown)[1])


def _check_run(run: Campaign) -> None:
    unknown = [cell for cell in run.cells if not cell.is_known]
    if unknown:
        raise DataError(f"the commissioning run holds an unknown state ({unknown[0].name}); give its state columns")


def _state(run: Campaign, cell: Cell) -> dict[str, float]:
    return dict(zip(run.parameters, cell.state.tolist(), strict=True))
