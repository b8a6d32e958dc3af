"""Discrepancy: the difference of twin and asset before any effect, as between two good models of one structure.

At load L and gauge g the asset shows f_g(z, L) + phi(L) d_g + e_g (f_g(z, L) - f_g(0, L)) where f is the twin, phi
the size of the healthy prediction relative to the greatest load, d a pattern over the gauges and e the relative error
of the change that damage makes. How far two honest models of one structure lie apart is not known beforehand: all
relative errors share one factor, the **level**, with a prior over `LEVELS`. At level l

    d ~ N(0, l^2 K),   K = COMMON^2 f f' + SMOOTH^2 (f f') o k + OWN^2 diag(f^2) + (FLOOR s)^2

with k a correlation along the structure and s the scale of readings of one unit. A commissioning run gives d gauge by
gauge, its covariance, and the level:

    P = Phi' V^-1 Phi,   h = Phi' V^-1 (mean - f),
    d ~ N(Q h, Q),   Q = (P + (l^2 K)^-1)^-1,   log p(run | l) = (h' Q h - log det(I + l^2 K P)) / 2 + constant

with the means of all cells stacked, V the covariance of their noise and Phi the pattern phi(L) of every gauge.
Source: Kennedy and O'Hagan (2001), "Bayesian calibration of computer models", J. R. Statist. Soc. B 63, for a
discrepancy with a prior of its own; the level and its prior are this project's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import chi2

from octmip.errors import DataError
from octmip.gap.campaign.averages import averages_of
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise import Noise
from octmip.gap.twins.cached import CachedTwin
from octmip.twin import Load

Floats = NDArray[np.float64]

LEVELS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
"""Factors on all relative differences of two models."""
LEVEL_PRIOR = (0.12, 0.20, 0.25, 0.20, 0.12, 0.07, 0.04)
"""Their probabilities before any reading."""
ALIKE = 2.0
"""The level of what damage and effects change lies within this factor (one sd) of that of the healthy strains."""
COMMON = 0.010
"""Relative sd of the part common to all gauges. Measured between two codes on one wing: 0.6 to 0.9 %."""
SMOOTH = 0.007
"""Relative sd of the part that varies along the structure."""
OWN = 0.007
"""Relative sd of the part of each gauge. Measured between two codes, with the smooth part: 0.8 to 1.0 %."""
FLOOR = 0.003
"""Sd of the part of each gauge over the rms of its unit's readings: gauges of little strain differ by more."""
DAMAGE = 0.04
"""Relative sd of the change that damage makes: on meshes of 30k degrees of freedom it is known to some per cent."""
WIDE_DAMAGE = 0.25
"""Relative sd of the change that damage makes at a gauge where two models' fields have unlike slopes: a tail of its own,
not a level. Three pairs of models of one wing differ there by .13, .5 and .5."""
WIDE_OWN = 0.03
"""Relative sd of healthy readings at such a gauge."""
WIDE_SHARE = 0.05
"""Share of such gauges: 1 of 20 in each of the three pairs."""
UNEVEN = 1e-3
"""Chance below which a run is taken as not proportional to the load."""
HALF = 0.5
"""Damage of the states over which a reading of unknown unit is measured."""
LENGTH = 0.3
"""Length over which the smooth part varies, as a share of the structure's extent."""


@dataclass(frozen=True, slots=True, eq=False)
class Discrepancy:
    """The difference d between twin and healthy asset at the reference load.

    Attributes
    ----------
    mean
        (n_gauges,) in the readings' units.
    covariance
        (n_gauges, n_gauges) in their squares.
    scale
        (n_gauges,) root mean square healthy prediction at the reference load over the readings of each one's unit.
    healthy
        (n_gauges,) the twin's healthy prediction at the reference load.
    damage
        relative sd of the change that damage makes.
    level
        factor on relative differences that these numbers hold for.
    wide
        positions of the gauges whose own errors are those of `WIDE_DAMAGE` and `WIDE_OWN`.
    log_levels
        levels that are possible, each with the log of its probability.
    is_calibrated
        whether a commissioning run stands behind it.
    p_value
        chance of a commissioning run that is as far from proportional to the twin's healthy readings; 1 without a run.
    own_level
        level of the healthy readings themselves, the mean over its posterior; 1 without a run.
    """

    mean: Floats
    covariance: Floats
    scale: Floats
    healthy: Floats
    damage: float
    level: float
    log_levels: tuple[tuple[float, float], ...]
    is_calibrated: bool
    p_value: float = 1.0
    own_level: float = 1.0
    wide: tuple[int, ...] = ()

    @property
    def typical_level(self) -> float:
        """Root mean square of the levels that are possible."""
        return float(np.sqrt(sum(level**2 * np.exp(log_share) for level, log_share in self.log_levels)))

    def at(self, level: float, wide: tuple[int, ...] = ()) -> "Discrepancy":
        """Return the difference at another level, with other wide gauges; what a commissioning run measured stays."""
        if self.is_calibrated:
            return replace(self, damage=DAMAGE * level, level=level, wide=wide)
        covariance = (level / self.level) ** 2 * (self.covariance - self._own_tails(self.wide))
        covariance = covariance + self._own_tails(wide)
        return replace(self, covariance=covariance, damage=DAMAGE * level, level=level, wide=wide)

    def _own_tails(self, wide: tuple[int, ...]) -> Floats:
        """Return what wide gauges add to the covariance (n_gauges, n_gauges) of healthy readings."""
        tails = np.zeros(len(self.healthy))
        tails[list(wide)] = (WIDE_OWN * self.healthy[list(wide)]) ** 2
        return np.diag(tails)

    def damage_tails(self, gauge: NDArray[np.int64]) -> Floats:
        """Return the relative sd (n,) that what damage changes at some gauges has beyond `damage`: 0 where not wide."""
        return np.asarray(np.where(np.isin(gauge, self.wide), WIDE_DAMAGE, 0.0))

    def share(self, healthy: Floats, reference: Floats) -> float:
        """Return phi: the signed size of a healthy prediction relative to the one at the reference load."""
        relative = reference / self.scale
        return float((healthy / self.scale) @ relative / (relative @ relative))


def uncalibrated(twin: CachedTwin, gauges: Sequence[str], load: Load) -> Discrepancy:
    """Return the difference to expect at the reference load from the twin alone."""
    healthy = twin.predict({}, load)[[twin.gauges.index(name) for name in gauges]]
    prior = tuple(zip(LEVELS, np.log(LEVEL_PRIOR).tolist(), strict=True))
    scale = scale_of(twin, gauges, load)
    unit = _unit_covariance(twin, gauges, healthy, scale)
    return Discrepancy(np.zeros(len(healthy)), unit, scale, healthy, DAMAGE, 1.0, prior, False)


def calibrated(run: Campaign, twin: CachedTwin, noise: Noise, load: Load) -> Discrepancy:
    """Return the difference that a commissioning run shows for the gauges of its noise, at the reference load `load`.

    Where the run is not proportional to the twin's healthy readings (chance below `UNEVEN`), what does not grow with
    the load is fitted beside d, so that a temperature or a bias of that day does not enter the calibration.

    Raises
    ------
    DataError
        the run holds an unknown state, or no load.
    """
    _check_run(run)
    prior = uncalibrated(twin, noise.gauges, load)
    read = _Run.of(run, twin, noise, load, prior)
    if not read.precision.any():
        raise DataError("the commissioning run holds readings at zero load only; expected two loads or more")
    p_value = read.p_value()
    precision, projection = read.without_offsets(prior.scale) if p_value < UNEVEN else (read.precision, read.projection)
    known = [_posterior(prior.at(level).covariance, precision, projection) for level in LEVELS]
    logs = np.log(LEVEL_PRIOR) + np.array([log for _, _, log in known])
    share = np.exp(logs - logsumexp(logs))
    mean = np.einsum("l,lg->g", share, np.array([m for m, _, _ in known]))
    spread = np.array([c + np.outer(m - mean, m - mean) for m, c, _ in known])
    return replace(
        prior,
        mean=mean,
        covariance=np.asarray(np.einsum("l,lij->ij", share, spread)),
        log_levels=_spread(share),
        is_calibrated=True,
        p_value=p_value,
        own_level=float(share @ LEVELS),
    )


def scale_of(twin: CachedTwin, gauges: Sequence[str], load: Load) -> Floats:
    """Return the size (n_gauges,) against which readings are small: the rms prediction over those of the same unit.

    A twin that announces no units may mix several, so each reading is then measured by itself, over the sound state
    and states with half of each damage: a strain that is near zero in the sound state need not be in others.
    """
    columns = [twin.gauges.index(name) for name in gauges]
    healthy = twin.predict({}, load)[columns]
    if twin.units is None:
        states = np.vstack([np.zeros(len(twin.parameters)), HALF * np.eye(len(twin.parameters))])
        squares = np.mean(twin.predict_states(states, load)[:, columns] ** 2, axis=0)
        return np.asarray(np.maximum(np.sqrt(squares), 1e-300))
    units = np.array([twin.units[k] for k in columns])
    scale = [np.sqrt(np.mean(healthy[units == unit] ** 2)) for unit in units]
    return np.asarray(np.maximum(np.array(scale), 1e-300))


def along(twin: CachedTwin, gauges: Sequence[str], length: float) -> Floats:
    """Return a correlation (n_gauges, n_gauges) that falls along the structure, over `length` of its extent."""
    positions, columns = twin.gauge_positions, [twin.gauges.index(name) for name in gauges]
    points = np.arange(len(columns), dtype=np.float64)[:, None] if positions is None else positions[columns]
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    distance = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=2) / max(length * extent, 1e-12)
    return np.asarray(np.exp(-0.5 * distance**2))


def _unit_covariance(twin: CachedTwin, gauges: Sequence[str], healthy: Floats, scale: Floats) -> Floats:
    """Return K, the covariance of d at level 1."""
    common = COMMON**2 + SMOOTH**2 * along(twin, gauges, LENGTH)
    own = (OWN * healthy) ** 2 + (FLOOR * scale) ** 2
    return np.asarray(common * np.outer(healthy, healthy) + np.diag(own))


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    """What a commissioning run says of d and of offsets o that do not grow with the load: residual = phi d + o + noise.

    Attributes
    ----------
    precision, across, constant
        (n_gauges, n_gauges) of (d, d), (d, o) and (o, o).
    projection, offset
        (n_gauges,) of d and of o.
    squared, n
        chi-squared of the residuals and their number.
    """

    precision: Floats
    across: Floats
    constant: Floats
    projection: Floats
    offset: Floats
    squared: float
    n: int

    @classmethod
    def of(cls, run: Campaign, twin: CachedTwin, noise: Noise, load: Load, prior: "Discrepancy") -> "_Run":
        """Read a run."""
        order = [run.gauges.index(name) for name in noise.gauges]
        columns = [twin.gauges.index(name) for name in noise.gauges]
        reference = twin.predict({}, load)[columns]
        means = [part.of_gauges(order) for part in averages_of(run, split=False)]
        average, gauge = np.nonzero(np.array([part.count > 0 for part in means]))
        cells = [run.cells[part.cell] for part in means]
        predicted = np.array([twin.predict(_state(run, cell), cell.load)[columns] for cell in cells])
        phi = np.array([prior.share(twin.predict({}, cell.load)[columns], reference) for cell in cells])
        root = np.linalg.cholesky(noise.of_averages(means, [cell.load for cell in cells], average, gauge))
        offset = (gauge[:, None] == np.arange(len(order))).astype(np.float64)
        residual = (np.array([part.mean for part in means]) - predicted)[average, gauge]
        stacked = np.column_stack([phi[average, None] * offset, offset, residual])
        white = linalg.solve_triangular(root, stacked, lower=True)
        d, o, left = np.split(white, [len(order), 2 * len(order)], axis=1)
        return cls(d.T @ d, d.T @ o, o.T @ o, (d.T @ left)[:, 0], (o.T @ left)[:, 0], float(np.sum(left**2)), len(left))

    def p_value(self) -> float:
        """Return the chance of what the best d leaves; 1 where the run has one load only."""
        free = self.n - int(np.linalg.matrix_rank(self.precision))
        if free <= 0:
            return 1.0
        best = np.linalg.lstsq(self.precision, self.projection, rcond=None)[0]
        return float(chi2.sf(self.squared - float(self.projection @ best), free))

    def without_offsets(self, scale: Floats) -> tuple[Floats, Floats]:
        """Return precision and projection of d, offsets of any size up to the scale of the readings taken out."""
        inner = self.constant + np.diag(scale**-2.0)
        solved = np.linalg.solve(inner, np.column_stack([self.across.T, self.offset]))
        precision = self.precision - self.across @ solved[:, :-1]
        return 0.5 * (precision + precision.T), self.projection - self.across @ solved[:, -1]


def _posterior(prior: Floats, precision: Floats, projection: Floats) -> tuple[Floats, Floats, float]:
    """Return mean and covariance of d under a prior covariance, and the log evidence of the run (up to a constant)."""
    grown = np.eye(len(prior)) + prior @ precision
    covariance = np.linalg.solve(grown, prior)
    covariance = 0.5 * (covariance + covariance.T)
    mean = covariance @ projection
    return mean, covariance, 0.5 * float(projection @ mean) - 0.5 * float(np.linalg.slogdet(grown)[1])


def _spread(share: Floats) -> tuple[tuple[float, float], ...]:
    """Return the levels of what damage and effects change, given the shares (n_levels,) of those of healthy strains."""
    steps = np.log(np.divide.outer(LEVELS, LEVELS)) / np.log(ALIKE)
    logs = -0.5 * steps**2 + np.log(LEVEL_PRIOR)[:, None]
    logs = logs - logsumexp(logs, axis=0) + np.log(np.maximum(share, 1e-300))
    return tuple(zip(LEVELS, np.asarray(logsumexp(logs, axis=1)).tolist(), strict=True))


def _check_run(run: Campaign) -> None:
    unknown = [cell for cell in run.cells if not cell.is_known]
    if unknown:
        raise DataError(f"the commissioning run holds an unknown state ({unknown[0].name}); give its state columns")


def _state(run: Campaign, cell: Cell) -> dict[str, float]:
    return dict(zip(run.parameters, cell.state.tolist(), strict=True))
