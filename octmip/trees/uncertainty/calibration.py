"""Calibration of probabilities: reliability diagram, expected calibration error, Brier score and its parts.

Samples that were given about the same probability are put into one bin; in a calibrated one the share of hits is the
mean probability. With w_b the weight of bin b, p_b its mean probability and o_b its share of hits

    ECE   = sum_b w_b |p_b - o_b|
    Brier = sum_i w_i sum_k (p_ik - [y_i = k])^2  =  reliability - resolution + uncertainty

where the parts are sums over the distinct rows of probabilities v, of weight w_v, in which the classes have shares o_v:
reliability w_v |p_v - o_v|^2, resolution w_v |o_v - o|^2, uncertainty sum_k o_k (1 - o_k). A tree gives as many rows
as it has leaves, so the decomposition is exact; bins are not needed for it.

Source: A. H. Murphy, A new vector partition of the probability score (1973). ECE: M. P. Naeini, G. F. Cooper, M.
Hauskrecht, Obtaining well calibrated probabilities using Bayesian binning (2015).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ReliabilityBin:
    """Samples of about the same probability: its mean, their share of hits, and their share of all weight."""

    probability: float
    hits: float
    weight: float


@dataclass(frozen=True, slots=True)
class Brier:
    """The Brier score and its parts; `score == reliability - resolution + uncertainty`."""

    score: float
    reliability: float
    resolution: float
    uncertainty: float


def reliability(
    probabilities: ArrayLike,
    codes: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    class_index: int | None = None,
    n_bins: int = 10,
) -> list[ReliabilityBin]:
    """Return the bins that are not empty, by rising probability.

    Parameters
    ----------
    probabilities
        (n, n_classes), 1 in all in each row.
    codes
        (n,) index of each true class.
    weights
        (n,) of the samples; None: 1 each.
    class_index
        the class whose probability is looked at; None: the most probable one of each row.
    n_bins
        of equal width between 0 and 1; a probability at an edge belongs below it.

    Raises
    ------
    ProblemError
        shapes or ranges are wrong.
    """
    table, truth, weight = _checked(probabilities, codes, weights)
    if n_bins < 1 or (class_index is not None and not 0 <= class_index < table.shape[1]):
        raise ProblemError(f"n_bins is {n_bins} and class_index {class_index}; expected 1 or more, and a class")
    chosen = table.argmax(axis=1) if class_index is None else np.full(len(table), class_index)
    given, is_hit = table[np.arange(len(table)), chosen], chosen == truth
    at = np.clip(np.ceil(given * n_bins).astype(int) - 1, 0, n_bins - 1)
    total = np.bincount(at, weight, n_bins)
    means, hits = np.bincount(at, weight * given, n_bins), np.bincount(at, weight * is_hit, n_bins)
    filled = np.flatnonzero(total > 0)
    return [ReliabilityBin(float(means[b] / total[b]), float(hits[b] / total[b]), float(total[b])) for b in filled]


def calibration_error(
    probabilities: ArrayLike,
    codes: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    class_index: int | None = None,
    n_bins: int = 10,
) -> float:
    """Return the expected calibration error; arguments as of `reliability`."""
    bins = reliability(probabilities, codes, weights=weights, class_index=class_index, n_bins=n_bins)
    return sum(b.weight * abs(b.probability - b.hits) for b in bins)


def brier_score(probabilities: ArrayLike, codes: ArrayLike, *, weights: ArrayLike | None = None) -> Brier:
    """Return the Brier score of probabilities (n, n_classes) and its exact parts."""
    table, truth, weight = _checked(probabilities, codes, weights)
    is_class = np.eye(table.shape[1])[truth]
    rows, at = np.unique(table, axis=0, return_inverse=True)
    at = at.ravel()
    total = np.bincount(at, weight)
    counts = np.stack([np.bincount(at, weight * column) for column in is_class.T], axis=1)
    shares: Floats = counts / np.where(total > 0, total, 1.0)[:, None]
    base = weight @ is_class
    return Brier(
        score=float(weight @ ((table - is_class) ** 2).sum(axis=1)),
        reliability=float(total @ ((rows - shares) ** 2).sum(axis=1)),
        resolution=float(total @ ((shares - base) ** 2).sum(axis=1)),
        uncertainty=float((base * (1.0 - base)).sum()),
    )


def _checked(
    probabilities: ArrayLike, codes: ArrayLike, weights: ArrayLike | None
) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Return probabilities, codes and weights, the weights 1 in all."""
    table, truth = np.asarray(probabilities, dtype=np.float64), np.asarray(codes)
    weight = np.ones(len(table)) if weights is None else np.asarray(weights, dtype=np.float64)
    if table.ndim != 2 or truth.shape != table.shape[:1] or weight.shape != truth.shape or not len(table):
        raise ProblemError(
            f"probabilities, codes and weights have shapes {table.shape}, {truth.shape}, {weight.shape}; expected "
            "(n, n_classes), (n,), (n,) with n of 1 or more"
        )
    if not (table >= 0).all() or not np.allclose(table.sum(axis=1), 1.0, atol=1e-9):
        raise ProblemError(
            "a row of probabilities holds a negative number or does not sum to 1; expected a distribution in each row"
        )
    if truth.dtype.kind not in "iu" or not ((truth >= 0) & (truth < table.shape[1])).all():
        raise ProblemError(
            f"codes holds a value that is no index of a class; expected whole numbers from 0 to {table.shape[1] - 1}"
        )
    if not (weight >= 0).all() or weight.sum() <= 0:
        raise ProblemError("weights holds a number below 0, or is 0 in all; expected 0 or more")
    return table, truth.astype(np.int64), weight / weight.sum()
