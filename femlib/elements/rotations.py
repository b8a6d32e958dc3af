"""Rotations in space as vectors and matrices, over arrays with any leading axes.

theta is the rotation vector (axis times angle), [a] b = a x b, and a spin w turns a matrix R into exp([w]) R. Then

    d(theta) = H(theta) w,   H = 1 - [theta] / 2 + eta [theta]^2,   eta = (1 - (t / 2) cot(t / 2)) / t^2,   t = |theta|.

Source: C. A. Felippa, B. Haugen, Comput. Methods Appl. Mech. Engng 194 (2005) 2285-2335, eqs 95 to 104.
"""

import numpy as np

from femlib.arrays import FloatArray

SMALL = 0.2
"""Below this angle [rad] the series are used: their next terms are under 1e-11, and the closed forms cancel."""


def skew(vectors: FloatArray) -> FloatArray:
    """Return the matrices (..., 3, 3) of the cross product with vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    flat = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1)
    return flat.reshape(*vectors.shape[:-1], 3, 3)


def exp_rotation(vectors: FloatArray) -> FloatArray:
    """Return the rotations (..., 3, 3) of rotation vectors (..., 3)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    matrix = skew(vectors)
    # sinc is sin(pi x) / (pi x); (1 - cos t) / t^2 = sinc^2(t / 2) / 2
    return np.asarray(
        np.eye(3) + np.sinc(angle / np.pi) * matrix + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * (matrix @ matrix)
    )


def log_rotation(matrices: FloatArray) -> FloatArray:
    """Return the rotation vectors (..., 3) of rotations (..., 3, 3) by less than half a turn."""
    m = matrices
    axis = 0.5 * np.stack([m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], -1)
    sine = np.linalg.norm(axis, axis=-1)
    cosine = 0.5 * (np.trace(m, axis1=-2, axis2=-1) - 1.0)
    angle = np.arctan2(sine, cosine)
    factor = np.where(sine < 1e-9, 1.0, angle / np.where(sine < 1e-9, 1.0, sine))
    return np.asarray(axis * factor[..., None])


def spin_to_vector(vectors: FloatArray) -> FloatArray:
    """Return H (..., 3, 3) of rotation vectors (..., 3)."""
    matrix = skew(vectors)
    return np.asarray(np.eye(3) - 0.5 * matrix + _eta(vectors)[..., None, None] * (matrix @ matrix))


def moment_variation(vectors: FloatArray, moments: FloatArray) -> FloatArray:
    """Return d(H^T m) / d(theta) (..., 3, 3) at constant moments m (..., 3)."""
    eta, mu = _eta(vectors)[..., None, None], _mu(vectors)[..., None, None]
    across = vectors[..., :, None] * moments[..., None, :]
    inner = np.sum(vectors * moments, axis=-1)[..., None, None] * np.eye(3)
    matrix = skew(vectors)
    twice = matrix @ (matrix @ moments[..., None])
    return np.asarray(
        eta * (inner + across - 2.0 * across.swapaxes(-1, -2))
        + mu * twice * vectors[..., None, :]
        - 0.5 * skew(moments)
    )


def _eta(vectors: FloatArray) -> FloatArray:
    angle = np.linalg.norm(vectors, axis=-1)
    safe = np.where(angle < SMALL, 1.0, angle)
    closed = (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2
    series = 1.0 / 12.0 + angle**2 / 720.0 + angle**4 / 30240.0 + angle**6 / 1209600.0
    return np.asarray(np.where(angle < SMALL, series, closed))


def _mu(vectors: FloatArray) -> FloatArray:
    """d(eta) / d(t) / t."""
    angle = np.linalg.norm(vectors, axis=-1)
    safe = np.where(angle < SMALL, 1.0, angle)
    half = 0.5 * safe
    closed = (safe**2 + 4.0 * np.cos(safe) + safe * np.sin(safe) - 4.0) / (4.0 * safe**4 * np.sin(half) ** 2)
    series = 1.0 / 360.0 + angle**2 / 7560.0 + angle**4 / 201600.0
    return np.asarray(np.where(angle < SMALL, series, closed))
