"""The unknown: a discrepancy that no effect of the library describes, as a hypothesis with its own evidence.

The asset shows an extra field tau s c u over the gauges: s their scales (`Frame.scale`), c a course over the load,
u ~ N(0, kernel). The kernel is white over the gauges or smooth along the structure. With the whitened field's singular
values s and the residual's components c,

    log BF = sum (c^2 q - log(1 + tau^2 s^2)) / 2,   q = tau^2 s^2 / (1 + tau^2 s^2).

Source: Kennedy and O'Hagan (2001), "Bayesian calibration of computer models", J. R. Statist. Soc. B 63 (the
discrepancy as a Gaussian process), here with a few fixed scales summed with equal weight instead of a fitted one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.inference.linear_model import LinearModel
from octmip.twin import amounts_of

Floats = NDArray[np.float64]

FIELD_WORDS = {
    "rough": "a rough field",
    "smooth": "a smooth field",
}
LOADS: Mapping[str, Callable[[Floats], Floats]] = {
    "constant in load": np.ones_like,
    "there as soon as there is load": np.sign,
    "growing with the root of the load": lambda x: np.sign(x) * np.sqrt(np.abs(x)),
    "proportional to the load": lambda x: x,
    "growing with the load squared": lambda x: x**2,
}
"""Courses over the load, as a share of the greatest one: joints that stick and slip, backlash and friction go with its
sign or with a root of it, and readings that wander took what no course described (docs/gap/noise.md)."""
SIZES = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Sd of the field over the scale of the readings at the greatest load."""
OF_ONE_LOAD = ("there as soon as there is load", "growing with the root of the load")
"""Courses that need one load: of several, each has a size of its own."""
OWN_COURSE, FEWEST_LOADS = "a rough field, with a course of its own over the loads in every reading", 4
"""A threshold or a bend along one of several loads: words, and loads from which it is looked for."""
SMOOTH = 0.3
"""Length over which a smooth field varies, as a share of the structure's extent."""


@dataclass(frozen=True, slots=True, eq=False)
class Unknown:
    """The evidence of the unknown in a linear model.

    Attributes
    ----------
    log_factor
        log evidence over that of no effect, all kinds and sizes summed.
    log_kinds
        log of the number of kinds: what naming the one that explains most costs.
    words
        that kind.
    allowing
        the model with that kind's covariance added to C0.
    """

    log_factor: float
    log_kinds: float
    words: str
    allowing: LinearModel


def weigh_unknown(model: LinearModel) -> Unknown:
    """Return the evidence of an unknown field, and the model in which it is allowed for."""
    roots = _roots(model)
    logs = {words: _logs(model, root) for words, root in roots.items()}
    words = max(logs, key=lambda name: float(logs[name].max()))
    size = SIZES[int(np.argmax(logs[words]))]
    every = np.concatenate(list(logs.values()))
    log_kinds = float(np.log(len(every)))
    said = f"{words}, of about {100 * size:g} % of the readings"
    allowing = model.with_covariance(size**2 * roots[words] @ roots[words].T)
    return Unknown(float(logsumexp(every)) - log_kinds, log_kinds, said, allowing)


def _logs(model: LinearModel, root: Floats) -> Floats:
    """Return the log evidence (n_sizes,) of a field with a root (n, r) of its covariance over that of no effect."""
    u, s, _ = np.linalg.svd(model.whiten(root), full_matrices=False)
    gain = np.square(np.outer(SIZES, s))
    return np.asarray(0.5 * np.sum((u.T @ model.left) ** 2 * gain / (1.0 + gain) - np.log1p(gain), axis=1))


def _roots(model: LinearModel) -> dict[str, Floats]:
    """Return by words for each kind of field a root (n, r) of its covariance over all rows, at unit size."""
    inputs, gauge, share = model.inputs, model.gauge, model.rows.share[:, None]
    scale = inputs.frame.scale[gauge][:, None]
    rough = scale * np.eye(len(inputs.order))[gauge]
    smooth = inputs.frame.along(SMOOTH) + 1e-6 * np.eye(len(inputs.order))
    fields = {"rough": rough, "smooth": scale * np.linalg.cholesky(smooth)[gauge]}
    n_loads = len(inputs.campaign.load_names)
    courses = {name: course(share) for name, course in LOADS.items() if n_loads == 1 or name not in OF_ONE_LOAD}
    found = {f"{FIELD_WORDS[f]}, {c}": course * root for f, root in fields.items() for c, course in courses.items()}
    if len(set(model.loads)) >= FEWEST_LOADS:
        found[OWN_COURSE] = _own_courses(model, rough)
    return found


def _own_courses(model: LinearModel, rough: Floats) -> Floats:
    """Return the root (n, n_gauges * n_loads) of a field in which each reading has a smooth course over all loads."""
    applied = np.array([amounts_of(load) for load in model.loads])
    half = np.maximum(np.ptp(applied, axis=0) / 2.0, 1e-300)
    distinct, at = np.unique(applied / half, axis=0, return_inverse=True)
    apart = np.sum((distinct[:, None] - distinct[None, :]) ** 2, axis=2)
    course = np.linalg.cholesky(np.exp(-0.5 * apart) + 1e-6 * np.eye(len(distinct)))[at.ravel()]
    return np.asarray((rough[:, :, None] * course[:, None, :]).reshape(len(rough), -1))
