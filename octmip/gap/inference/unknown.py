"""The unknown: a broad discrepancy that no effect of the library describes, as a hypothesis with an evidence of its
own.

The asset shows an extra field tau * u over the gauges, u ~ N(0, kernel), at every state alike, with the load as L^0,
L^1 or L^2; the kernel is either white over the gauges or smooth along the structure. With the whitened field's
singular values s and the residual's components c,

    log BF = sum (c^2 q - log(1 + tau^2 s^2)) / 2,   q = tau^2 s^2 / (1 + tau^2 s^2).

Source: Kennedy and O'Hagan (2001), "Bayesian calibration of computer models", J. R. Statist. Soc. B 63 (the
discrepancy as a Gaussian process), here with a few fixed scales summed with equal weight instead of a fitted one.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.inference.linear_model import Scene
from octmip.gap.inference.signature_error import under

Floats = NDArray[np.float64]

POWERS = (0, 1, 2)
SIZES = (0.003, 0.01, 0.03, 0.1)
"""Sd of the field over the root mean square strain at the greatest load."""
SMOOTH = 0.3
"""Length over which a smooth field varies, as a share of the structure's extent."""


@dataclass(frozen=True, slots=True, eq=False)
class Unknown:
    """The evidence of the unknown in a scene.

    Attributes:
        log_factor: log evidence over that of no effect, all kinds and sizes summed.
        words: the kind that explains most.
        conditioned: the scene with that kind's covariance added to C0.
    """

    log_factor: float
    words: str
    conditioned: Scene


def weigh_unknown(scene: Scene) -> Unknown:
    """Return the evidence of an unknown field, and the scene in which it is allowed for."""
    kinds = [(name, power, size) for name in ("rough", "smooth") for power in POWERS for size in SIZES]
    roots = {name: np.array(np.linalg.cholesky(_kernel(scene, name == "smooth"))) for name in ("rough", "smooth")}
    found: dict[tuple[str, int], tuple[Floats, Floats, Floats]] = {}
    values = []
    for name, power, size in kinds:
        if (name, power) not in found:
            field = linalg.solve_triangular(scene.factor, _field(scene, roots[name], power), lower=True)
            u, s, _ = np.linalg.svd(field, full_matrices=False)
            found[name, power] = (u, s, u.T @ scene.white_residual)
        _, s, c = found[name, power]
        values.append(_log_factor(s, c, size * scene.setting.discrepancy.reference))
    best = int(np.argmax(values))
    name, power, size = kinds[best]
    u, s, _ = found[name, power]
    load = ("constant in load", "proportional to the load", "growing with the load squared")[power]
    total = float(logsumexp(values)) - float(np.log(len(kinds)))
    return Unknown(
        total,
        f"a {name} field, {load}, of about {size * scene.setting.discrepancy.reference:.0f} microstrain",
        under(scene, u * (s * size * scene.setting.discrepancy.reference)),
    )


def _kernel(scene: Scene, is_smooth: bool) -> Floats:
    order = list(scene.setting.order)
    n = len(order)
    if not is_smooth:
        return np.eye(n)
    places = scene.setting.memory.gauge_positions
    points = np.arange(n, dtype=np.float64)[:, None] if places is None else places[order]
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    distance = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=2) / max(SMOOTH * extent, 1e-12)
    return np.asarray(np.exp(-0.5 * distance**2) + 1e-6 * np.eye(n))


def _field(scene: Scene, root: Floats, power: int) -> Floats:
    loads = np.array([scene.setting.cell_of(b).load_factor for b in scene.setting.blocks])
    share = (loads / scene.setting.reference) ** power
    return np.asarray(share[scene.block][:, None] * root[scene.gauge])


def _log_factor(s: Floats, c: Floats, tau: float) -> float:
    gain = (tau * s) ** 2
    return float(0.5 * np.sum(c**2 * gain / (1.0 + gain) - np.log1p(gain)))
