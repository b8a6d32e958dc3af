"""Discrepancy: the difference of twin and asset before any effect, as between two good models of one structure.

At load L and gauge g the asset shows f_g(z, L) + phi(L) d_g + e_g (f_g(z, L) - f_g(0, L)) where f is the twin, phi
the size of the healthy prediction relative to the greatest load, d a pattern over the gauges and e the relative error
of the change that damage makes. Without a commissioning run d has a part common to all gauges and one per gauge; with
one, d is estimated gauge by gauge from the healthy readings and its posterior covariance is propagated:

    K = (K0^-1 + Phi' V^-1 Phi)^-1,    d = K Phi' V^-1 (mean - f)

with the means of all cells stacked, V the covariance of their noise and Phi the pattern phi(L) of every gauge.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.averages import averages_of
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.twins.cached import CachedTwin

COMMON = 0.010
"""Relative sd of the part common to all gauges. Measured between two codes on one wing: 0.6 to 0.9 %."""
OWN = 0.010
"""Relative sd of the part of each gauge. Measured between two codes on one wing: 0.8 to 1.0 %."""
FLOOR = 0.003
"""Sd of the part of each gauge relative to the root mean square strain: gauges of little strain differ by more."""
OPEN = 0.05
"""Relative sd of d before a commissioning run has been read: wide, the run decides."""
DAMAGE = 0.04
"""Relative sd of the change that damage makes: on meshes of 30k degrees of freedom it is known to some per cent."""


@dataclass(frozen=True, slots=True, eq=False)
class Discrepancy:
    """The difference d between twin and healthy asset at the reference load.

    Attributes
    ----------
    mean
        (n_gauges,) [microstrain].
    covariance
        (n_gauges, n_gauges) [microstrain^2].
    reference
        root mean square healthy prediction at the reference load [microstrain].
    damage
        relative sd of the change that damage makes.
    is_calibrated
        whether a commissioning run stands behind it.
    """

    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    reference: float
    damage: float
    is_calibrated: bool

    def share(self, healthy: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
        """Return phi: the signed size of a healthy prediction relative to the one at the reference load."""
        return float(healthy @ reference / (reference @ reference))


def uncalibrated(healthy: NDArray[np.float64]) -> Discrepancy:
    """Return the difference to expect from the healthy prediction (n_gauges,) at the reference load alone."""
    rms = _rms(healthy)
    covariance = COMMON**2 * np.outer(healthy, healthy) + np.diag((OWN * healthy) ** 2 + (FLOOR * rms) ** 2)
    return Discrepancy(np.zeros(len(healthy)), covariance, rms, DAMAGE, is_calibrated=False)


def calibrated(run: Campaign, twin: CachedTwin, gauges: tuple[str, ...], load: float) -> Discrepancy:
    """Return the difference that a commissioning run shows for these gauges, at the reference load factor `load`.

    Raises
    ------
    DataError
        the run lacks a gauge of the campaign, holds an unknown state, or no load.
    """
    _check_run(run, gauges)
    order = [run.gauges.index(name) for name in gauges]
    columns = [twin.gauges.index(name) for name in gauges]
    noise = estimate_noise(run)
    reference = twin.predict({}, load)[columns]
    open_sd = OPEN * np.abs(reference) + 2 * FLOOR * _rms(reference)
    means = averages_of(run, split=False)
    average, gauge = np.nonzero(np.array([part.count[order] > 0 for part in means]))
    cells = [run.cells[part.cell] for part in means]
    predicted = np.array([twin.predict(_state(run, cell), cell.load_factor)[columns] for cell in cells])
    healthy = np.array([twin.predict({}, cell.load_factor)[columns] for cell in cells])
    share = healthy @ reference / (reference @ reference)
    weight = np.linalg.inv(noise.of_averages(means, [c.load_factor for c in cells], average, np.array(order)[gauge]))
    pattern = share[average, None] * (gauge[:, None] == np.arange(len(gauges)))
    residual = np.array([part.mean[order] for part in means])[average, gauge] - predicted[average, gauge]
    precision = np.diag(open_sd**-2) + pattern.T @ weight @ pattern
    projection = pattern.T @ weight @ residual
    if np.allclose(precision, np.diag(open_sd**-2)):
        raise DataError("the commissioning run holds readings at zero load only; expected two loads or more")
    covariance = np.asarray(np.linalg.inv(precision), dtype=np.float64)
    return Discrepancy(covariance @ projection, covariance, _rms(reference), DAMAGE, is_calibrated=True)


def _check_run(run: Campaign, gauges: tuple[str, ...]) -> None:
    missing = [name for name in gauges if name not in run.gauges]
    if missing:
        raise DataError(f"the commissioning run lacks gauge {missing[0]}; expected every gauge of the campaign")
    unknown = [cell for cell in run.cells if not cell.is_known]
    if unknown:
        raise DataError(f"the commissioning run holds an unknown state ({unknown[0].name}); give its state columns")


def _state(run: Campaign, cell: Cell) -> dict[str, float]:
    return dict(zip(run.parameters, cell.state.tolist(), strict=True))


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
