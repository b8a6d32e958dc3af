"""Evidence of one or two changes with log-uniform sizes, by integration over the part of the sizes that matters.

Whitened, a change of size s is s a + s^2 b, and the log-likelihood over that of no change is
s u.a + s^2 (u.b - a.a / 2) - s^3 a.b - s^4 b.b / 2 for a residual u.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray

POINTS = 41
WIDE = 6.0
"""Standard deviations on both sides of the best size that are integrated over."""
NEVER = -1e9


@dataclass(frozen=True, eq=False)
class Columns:
    """Changes of readings that differ in name or place, whitened.

    Attributes
    ----------
    first, second
        (n, n_readings) a and b.
    least, most
        (n,) of the size's amount.
    is_signed
        (n,) whether the size may be negative.
    """

    first: FloatArray
    second: FloatArray
    least: FloatArray
    most: FloatArray
    is_signed: FloatArray


@dataclass(frozen=True, eq=False)
class Integral:
    """Log-evidence over that of no change (n,), and sizes: best, and bounds of the middle 90 % (n,)."""

    log: FloatArray
    size: FloatArray
    low: FloatArray
    high: FloatArray


def integrate(columns: Columns, residual: FloatArray) -> Integral:
    """Return the evidence of each change alone for a whitened residual (n_readings,)."""
    a, b = columns.first, columns.second
    ua, ub = a @ residual, b @ residual
    aa, ab, bb = (np.einsum("ij,ij->i", x, y) for x, y in ((a, a), (a, b), (b, b)))
    sides = []
    for sign in (1.0, -1.0):
        size, weight = _sizes(columns, ua, aa, sign)
        log = size * ua[:, None] + size**2 * (ub - 0.5 * aa)[:, None]
        log = log - size**3 * ab[:, None] - 0.5 * size**4 * bb[:, None]
        share = np.where(columns.is_signed > 0.5, 0.5, 1.0 if sign > 0.0 else 0.0)[:, None]
        with np.errstate(divide="ignore"):
            sides.append((size, np.maximum(log + np.log(weight * share), NEVER)))
    size, log = (np.concatenate([side[k] for side in sides], axis=1) for k in (0, 1))
    return _summed(size, log)


def _sizes(columns: Columns, ua: FloatArray, aa: FloatArray, sign: float) -> tuple[FloatArray, FloatArray]:
    """Return sizes (n, POINTS) of one sign and their prior weights: log-uniform between the least and the most."""
    sd = 1.0 / np.sqrt(np.maximum(aa, 1e-30))
    best = sign * ua / np.maximum(aa, 1e-30)
    low = np.clip(best - WIDE * sd, columns.least, columns.most)
    high = np.clip(best + WIDE * sd, columns.least, columns.most)
    narrow = high - low < 1e-9 * columns.most
    low = np.where(narrow & (low > columns.least), np.maximum(columns.least, low - WIDE * sd), low)
    high = np.where(narrow & (high < columns.most), np.minimum(columns.most, high + WIDE * sd), high)
    is_fixed = columns.most <= columns.least
    amount = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, POINTS)
    decade = np.log(np.where(is_fixed, np.e, columns.most / columns.least))
    step = np.where(is_fixed, 0.0, (high - low) / (POINTS - 1))[:, None]
    weight = step / (amount * decade[:, None])
    weight[:, [0, -1]] *= 0.5
    weight = np.where(is_fixed[:, None], 1.0 / POINTS, weight)
    return sign * amount, weight


def _summed(size: FloatArray, log: FloatArray) -> Integral:
    order = np.argsort(size, axis=1)
    size, log = np.take_along_axis(size, order, 1), np.take_along_axis(log, order, 1)
    top = log.max(axis=1, keepdims=True)
    mass = np.exp(log - top)
    total = mass.sum(axis=1, keepdims=True)
    course = np.cumsum(mass, axis=1) / total

    def at(level: float) -> FloatArray:
        return np.take_along_axis(size, (course >= level).argmax(axis=1)[:, None], 1)[:, 0]

    best = np.take_along_axis(size, log.argmax(axis=1)[:, None], 1)[:, 0]
    return Integral((top + np.log(total))[:, 0], best, at(0.05), at(0.95))


def pattern_evidence(columns: FloatArray, residual: FloatArray, sizes: FloatArray) -> float:
    """Return the log-evidence of a change whose columns (n_readings, k) each have a standard normal weight of its own.

    All are scaled by one size, which takes the values `sizes` alike.
    """
    left, value, _ = np.linalg.svd(columns, full_matrices=False)
    seen = (left.T @ residual) ** 2
    grown = np.outer(sizes**2, value**2)
    log = 0.5 * (seen * grown / (1.0 + grown) - np.log1p(grown)).sum(axis=1)
    return float(np.logaddexp.reduce(log) - np.log(len(sizes)))


def pair_gains(first: FloatArray, residual: FloatArray) -> FloatArray:
    """Return half the squared length (n, n) of a residual that two columns of (n, n_readings) fit, sizes free."""
    gram, seen = first @ first.T, first @ residual
    length = np.maximum(np.diag(gram), 1e-30)
    outer = np.outer(length, length)
    det = np.maximum(outer - gram**2, 1e-9 * outer)
    crossed = np.outer(seen, seen) * gram
    gain = 0.5 * (seen[:, None] ** 2 * length + seen**2 * length[:, None] - 2.0 * crossed) / det
    np.fill_diagonal(gain, 0.0)
    return np.asarray(gain)
