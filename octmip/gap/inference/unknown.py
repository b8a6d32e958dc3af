"""The unknown: a discrepancy that no effect of the library describes, as a hypothesis with its own evidence.

The asset shows an extra field tau * s * u over the gauges, s their scales (`Difference.scale`), u ~ N(0, kernel), with
the load as L^0, L^1 or L^2, or with the time of reading in one of three courses. The kernel is white over the gauges or
smooth along the structure, one field in all tests, or white with a field of its own in each test. With the whitened
field's singular values s and the residual's components c,

    log BF = sum (c^2 q - log(1 + tau^2 s^2)) / 2,   q = tau^2 s^2 / (1 + tau^2 s^2).

Source: Kennedy and O'Hagan (2001), "Bayesian calibration of computer models", J. R. Statist. Soc. B 63 (the
discrepancy as a Gaussian process), here with a few fixed scales summed with equal weight instead of a fitted one.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.inference.difference import along
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.signature_error import with_errors
from octmip.twin import amounts_of

Floats = NDArray[np.float64]

FIELD_WORDS = {
    "rough": "a rough field",
    "smooth": "a smooth field",
    "rough in each test": "a rough field of its own in each test",
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
TIMES: Mapping[str, Callable[[Floats], Floats]] = {
    "growing with time": lambda x: x,
    "that comes and goes with time": lambda x: 4.0 * x * (1.0 - x),
    "that changes its sign with time": lambda x: 12.0 * np.sqrt(3.0) * x * (1.0 - x) * (0.5 - x),
}
"""Courses over the campaign's time, from 0 to 1: a sun, a supply, lead wires. Each is 1 at most.

Of smooth fields alone: a rough one that goes with time is what gauges do that wander each by itself."""
SIZES = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Sd of the field over the scale of the readings at the greatest load."""
OF_ONE_LOAD = ("there as soon as there is load", "growing with the root of the load")
"""Courses that need one load: of several, each has a size of its own."""
OVER_LOADS = "smooth over the loads"
LOAD_LENGTH, LEAST = 0.5, 1e-3
"""Length over which it varies, as a share of each load's range, and the least eigenvalue of its covariance."""
MOMENTS = 4
"""Averages of different times from which a course over time is told from one over the load."""
SMOOTH = 0.3
"""Length over which a smooth field varies, as a share of the structure's extent."""


Kind = tuple[str, str, float]
"""Name of the field, words for its course, and size."""


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
        the inference with that kind's covariance added to C0.
    """

    log_factor: float
    log_kinds: float
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
    over_load, over_time = _courses(model)
    fields: dict[tuple[str, str], _Field] = {}
    for name, root in _roots(model).items():
        courses = over_load | over_time if name == "smooth" else over_load
        fields |= {(name, course): field for course, field in _fields(model, root, courses)}
        if name == "rough" and (over := _over_loads(model)) is not None:
            columns = np.hstack([root * course[:, None] for course in over.T])
            fields |= {(name, OVER_LOADS): _field(model, columns)}
    kinds: list[Kind] = [(name, course, size) for name, course in fields for size in SIZES]
    values = np.array([fields[name, course].log_factor(size) for name, course, size in kinds])
    best = int(np.argmax(values))
    name, course, size = kinds[best]
    field = fields[name, course]
    return Unknown(
        float(logsumexp(values)) - float(np.log(len(kinds))),
        float(np.log(len(kinds))),
        f"{FIELD_WORDS[name]}, {course}, of about {100 * size:g} % of the readings",
        Inference(with_errors(model, field.u * (field.s * size))),
    )


def _roots(model: LinearModel) -> dict[str, Floats]:
    """Return by kind of field a root (n, r) of its covariance over all rows, at unit size and load power 0."""
    inputs, gauge = model.inputs, model.gauge
    scale = inputs.difference.scale[gauge][:, None]
    smooth = along(inputs.twin, inputs.campaign.gauges, SMOOTH) + 1e-6 * np.eye(len(inputs.order))
    rough = np.eye(len(inputs.order))
    found = {
        "rough": scale * rough[gauge],
        "smooth": scale * np.linalg.cholesky(smooth)[gauge],
    }
    tests = np.array([cell.test for cell in inputs.campaign.cells])[model.cells]
    names = list(dict.fromkeys(tests.tolist()))
    if len(names) > 1:
        own = (tests[:, None] == np.array(names)[None, :]).astype(float)
        found["rough in each test"] = np.hstack([found["rough"] * own[:, [k]] for k in range(len(names))])
    return found


def _fields(model: LinearModel, root: Floats, courses: Mapping[str, Floats]) -> Iterator[tuple[str, "_Field"]]:
    """Return the whitened field of a root by its course."""
    for course, factor in courses.items():
        yield course, _field(model, factor[:, None] * root)


def _field(model: LinearModel, root: Floats) -> _Field:
    u, s, _ = np.linalg.svd(model.whiten(root), full_matrices=False)
    return _Field(u, s, u.T @ model.whitened.residual)


def _over_loads(model: LinearModel) -> Floats | None:
    """Return a root (n, r) of the covariance over the rows of what varies smoothly with several loads; None of one."""
    applied = np.array([amounts_of(load) for load in model.loads])
    width = np.ptp(applied, axis=0)
    if np.sum(width > 0.0) < 2:
        return None
    at = applied[:, width > 0.0] / (LOAD_LENGTH * width[width > 0.0])
    cells, row = np.unique(at, axis=0, return_inverse=True)
    alike = np.exp(-0.5 * np.sum((cells[:, None] - cells[None]) ** 2, axis=2))
    s, u = np.linalg.eigh(alike)
    kept = s > LEAST * s[-1]
    return np.asarray((u[:, kept] * np.sqrt(s[kept]))[row.ravel()])


def _courses(model: LinearModel) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return the factor (n,) of every course at the model's rows: over the load, and over time if there is enough."""
    inputs = model.inputs
    moments = np.array([average.moments.mean() for average in inputs.averages])
    n_loads = len(inputs.campaign.load_names)
    chosen = {name: course for name, course in LOADS.items() if n_loads == 1 or name not in OF_ONE_LOAD}
    over_load = {name: course(model.means.rows.share) for name, course in chosen.items()}
    if len(np.unique(moments)) < MOMENTS:
        return over_load, {}
    at = (moments - moments.min()) / np.ptp(moments)
    return over_load, {name: course(at)[model.average] for name, course in TIMES.items()}
