"""Discrepancy: the difference of twin and asset before any effect, as between two good models of one structure.

At load L and gauge g the asset shows f_g(z, L) + phi(L) d_g + e_g (f_g(z, L) - f_g(0, L)) where f is the twin, phi
the size of the healthy prediction relative to the greatest load, d a pattern over the gauges and e the relative error
of the change that damage makes. How far two honest models of one structure lie apart is not known beforehand: all
relative errors share one factor, the **level**, with a prior over `LEVELS`. At level l

    d ~ N(0, l^2 K),   K = common^2 f f' + smooth^2 (f f') o k + own^2 diag(f^2) + (floor s)^2

with k a correlation along the structure, s the scale of readings of one unit, and the standard deviations those of
`octmip.gap.odds.Differences`. A commissioning run gives d gauge by gauge, its covariance, and the level
(`octmip.gap.commissioning`).

A gauge may be **wide**, with probability `wide_share`: its own error of what damage changes has the sd `wide_damage`
beyond that, and of the healthy reading, where no run has measured it, `wide_own`.
Source: Kennedy and O'Hagan (2001), "Bayesian calibration of computer models", J. R. Statist. Soc. B 63, for a
discrepancy with a prior of its own; the level and its prior are this project's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.odds import Differences
from octmip.gap.twins.cached import CachedTwin
from octmip.twin import Load

Floats = NDArray[np.float64]

LEVELS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
"""Factors on all relative differences of two models."""
LEVEL_PRIOR = (0.12, 0.20, 0.25, 0.20, 0.12, 0.07, 0.04)
"""Their probabilities before any reading."""
ALIKE = 2.0
"""The level of what damage and effects change lies within this factor (one sd) of that of the healthy strains."""
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
        positions of the gauges whose own errors are those of `wide_damage` and `wide_own`.
    usual
        what two honest models differ by at level 1.
    log_levels
        levels that are possible, each with the log of its probability.
    is_calibrated
        whether a commissioning run stands behind it.
    p_value
        chance of a commissioning run that is as far from proportional to the twin's healthy readings; 1 without a run.
    uneven
        probability that a part of the run does not grow with the load as the twin does; 0 without a run.
    own_level
        level of the healthy readings themselves, the mean over its posterior; 1 without a run.
    """

    mean: Floats
    covariance: Floats
    scale: Floats
    healthy: Floats
    damage: float
    level: float
    usual: Differences
    log_levels: tuple[tuple[float, float], ...]
    is_calibrated: bool
    p_value: float = 1.0
    own_level: float = 1.0
    wide: tuple[int, ...] = ()
    uneven: float = 0.0

    @property
    def typical_level(self) -> float:
        """Root mean square of the levels that are possible."""
        return float(np.sqrt(sum(level**2 * np.exp(log_share) for level, log_share in self.log_levels)))

    def at(self, level: float, wide: tuple[int, ...] = ()) -> "Discrepancy":
        """Return the difference at another level, with other wide gauges; what a commissioning run measured stays."""
        if self.is_calibrated:
            return replace(self, damage=self.usual.damage * level, level=level, wide=wide)
        covariance = (level / self.level) ** 2 * (self.covariance - self._own_tails(self.wide))
        covariance = covariance + self._own_tails(wide)
        return replace(self, covariance=covariance, damage=self.usual.damage * level, level=level, wide=wide)

    def _own_tails(self, wide: tuple[int, ...]) -> Floats:
        """Return what wide gauges add to the covariance (n_gauges, n_gauges) of healthy readings."""
        tails = np.zeros(len(self.healthy))
        tails[list(wide)] = (self.usual.wide_own * self.healthy[list(wide)]) ** 2
        return np.diag(tails)

    def damage_tails(self, gauge: NDArray[np.int64]) -> Floats:
        """Return the relative sd (n,) that what damage changes at some gauges has beyond `damage`: 0 where not wide."""
        return np.asarray(np.where(np.isin(gauge, self.wide), self.usual.wide_damage * self.level, 0.0))

    def share(self, healthy: Floats, reference: Floats) -> float:
        """Return phi: the signed size of a healthy prediction relative to the one at the reference load."""
        relative = reference / self.scale
        return float((healthy / self.scale) @ relative / (relative @ relative))


def uncalibrated(twin: CachedTwin, gauges: Sequence[str], load: Load, usual: Differences) -> Discrepancy:
    """Return the difference to expect at the reference load from the twin alone."""
    healthy = twin.predict({}, load)[[twin.gauges.index(name) for name in gauges]]
    prior = tuple(zip(LEVELS, np.log(LEVEL_PRIOR).tolist(), strict=True))
    scale = scale_of(twin, gauges, load)
    unit = _unit_covariance(twin, gauges, healthy, scale, usual)
    return Discrepancy(np.zeros(len(healthy)), unit, scale, healthy, usual.damage, 1.0, usual, prior, False)


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


def _unit_covariance(
    twin: CachedTwin, gauges: Sequence[str], healthy: Floats, scale: Floats, usual: Differences
) -> Floats:
    """Return K, the covariance of d at level 1."""
    common = usual.common**2 + usual.smooth**2 * along(twin, gauges, LENGTH)
    own = (usual.own * healthy) ** 2 + (usual.floor * scale) ** 2
    return np.asarray(common * np.outer(healthy, healthy) + np.diag(own))


def spread_levels(share: Floats) -> tuple[tuple[float, float], ...]:
    """Return the levels of what damage and effects change, given the shares (n_levels,) of those of healthy strains."""
    steps = np.log(np.divide.outer(LEVELS, LEVELS)) / np.log(ALIKE)
    logs = -0.5 * steps**2 + np.log(LEVEL_PRIOR)[:, None]
    logs = logs - logsumexp(logs, axis=0) + np.log(np.maximum(share, 1e-300))
    return tuple(zip(LEVELS, np.asarray(logsumexp(logs, axis=1)).tolist(), strict=True))
