"""The unknown: a discrepancy that no effect of the library describes, as a hypothesis with its own evidence.

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

from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.signature_error import with_errors
from octmip.twin import MICROSTRAIN, MIXED

Floats = NDArray[np.float64]

KERNELS = ("rough", "smooth")
POWERS = (0, 1, 2)
LOAD_WORDS = ("constant in load", "proportional to the load", "growing with the load squared")
SIZES = (0.003, 0.01, 0.03, 0.1)
"""Sd of the field over the root mean square strain at the greatest load."""
SMOOTH = 0.3
"""Length over which a smooth field varies, as a share of the structure's extent."""


Kind = tuple[str, int, float]
"""Name, power of the load and size."""


@dataclass(frozen=True, slots=True, eq=False)
class Unknown:
    """The evidence of the unknown in a linear model.

    Attributes
    ----------
    log_factor
        log evidence over that of no effect, all kinds and sizes summed.
    words
        the kind that explains most.
    allowing
        the inference with that kind's covariance added to C0.
    """

    log_factor: float
    words: str
    allowing: Inference


@dataclass(frozen=True, slots=True, eq=False)
class _Field:
    """A field of unit size, whitened.

    Attributes
    ----------
    u, s
        its left singular vectors (n, r) and singular values (r,).
    c
        (r,) components of the whitened residual along u.
    """

    u: Floats
    s: Floats
    c: Floats

    def log_factor(self, tau: float) -> float:
        """Return the log evidence of a field of sd `tau` over that of no effect."""
        gain = (tau * self.s) ** 2
        return float(0.5 * np.sum(self.c**2 * gain / (1.0 + gain) - np.log1p(gain)))


def weigh_unknown(model: LinearModel) -> Unknown:
    """Return the evidence of an unknown field, and the inference in which it is allowed for."""
    unit = model.inputs.discrepancy.reference
    roots = {name: np.array(np.linalg.cholesky(_kernel(model.inputs, name == "smooth"))) for name in KERNELS}
    fields = {(name, power): _field(model, roots[name], power) for name in KERNELS for power in POWERS}
    kinds: list[Kind] = [(name, power, size) for name, power in fields for size in SIZES]
    values = [fields[name, power].log_factor(size * unit) for name, power, size in kinds]
    name, power, size = kinds[int(np.argmax(values))]
    best = fields[name, power]
    return Unknown(
        float(logsumexp(values)) - float(np.log(len(kinds))),
        f"a {name} field, {LOAD_WORDS[power]}{_of_about(model.inputs, size * unit)}",
        Inference(with_errors(model, best.u * (best.s * size * unit))),
    )


def _of_about(inputs: Inputs, size: float) -> str:
    """Return the size of a field in words, where all readings have one unit."""
    if inputs.unit == MIXED:
        return ""
    return (
        f", of about {size:.0f} {inputs.unit}" if inputs.unit == MICROSTRAIN else f", of about {size:.3g} {inputs.unit}"
    )


def _kernel(inputs: Inputs, is_smooth: bool) -> Floats:
    order = list(inputs.order)
    n = len(order)
    if not is_smooth:
        return np.eye(n)
    positions = inputs.twin.gauge_positions
    points = np.arange(n, dtype=np.float64)[:, None] if positions is None else positions[order]
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    distance = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=2) / max(SMOOTH * extent, 1e-12)
    return np.asarray(np.exp(-0.5 * distance**2) + 1e-6 * np.eye(n))


def _field(model: LinearModel, root: Floats, power: int) -> _Field:
    share = np.array([model.inputs.share_of_reference(load) for load in model.inputs.loads]) ** power
    field = share[model.average][:, None] * root[model.gauge]
    u, s, _ = np.linalg.svd(linalg.solve_triangular(model.factor, field, lower=True), full_matrices=False)
    return _Field(u, s, u.T @ model.whitened.residual)
