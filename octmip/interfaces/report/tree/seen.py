"""What a drawing shows of training samples: values of the feature at each split, and the spread in each leaf."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.tree import HyperplaneSplit, Node, Split, leaf_index, predict_values
from octmip.trees.question.problem import Problem

BINS = 20
"""Bars of a histogram over all values that come to its split; the threshold may part one more."""


@dataclass(frozen=True, slots=True, eq=False)
class Histogram:
    """Samples at a split by the value that it compares.

    Attributes
    ----------
    counts
        (n_bins, n_classes) samples in each bin; of numbers one column.
    n_left
        bins that go left: the threshold lies behind them.
    """

    counts: NDArray[np.int64]
    n_left: int

    def mirrored(self) -> "Histogram":
        """Return it with its sides exchanged."""
        return Histogram(self.counts[::-1], len(self.counts) - self.n_left)


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Training samples in the leaves of a tree.

    Attributes
    ----------
    problem
        whose samples they are.
    leaf_of_sample
        (n_samples,) leaves from the left.
    misses
        (n_samples,) how far each is from the answer of its leaf; empty where answers are classes.
    has_histograms
        whether histograms are asked for.
    """

    problem: Problem
    leaf_of_sample: NDArray[np.int64]
    misses: NDArray[np.float64]
    has_histograms: bool

    @classmethod
    def of(cls, problem: Problem, tree: Node, histograms: bool = False) -> "Seen":
        """Return the samples of a problem in a tree."""
        samples = problem.samples
        misses = np.empty(0)
        if not samples.n_classes:
            with np.errstate(over="ignore"):
                misses = predict_values(tree, samples.features) - samples.codes
        return cls(problem, leaf_index(tree, samples.features), misses, histograms)

    def spread(self, leaf: int) -> float | None:
        """Return the standard deviation of the samples of a leaf about its answer; None where it has no weight."""
        here = np.flatnonzero(self.leaf_of_sample == leaf)
        if not len(self.misses) or not len(here):
            return None
        misses, weights = self.misses[here], self.problem.samples.weights[here]
        largest = float(np.abs(misses).max()) or 1.0  # squares of parts of the largest do not overflow
        if not weights.any() or not np.isfinite(largest):
            return None
        return largest * float(np.sqrt(np.average((misses / largest) ** 2, weights=weights)))

    def histogram(self, split: Split | HyperplaneSplit, first: int, middle: int, end: int) -> Histogram | None:
        """Return the samples at a split whose left side has the leaves first..middle-1, and right middle..end-1."""
        here = np.flatnonzero((self.leaf_of_sample >= first) & (self.leaf_of_sample < end))
        if not self.has_histograms or not len(here):
            return None
        samples = self.problem.samples
        codes = samples.codes[here] if samples.n_classes else np.zeros(len(here), dtype=np.int64)
        counts = np.eye(samples.n_classes or 1, dtype=np.int64)[codes]
        return _histogram(*_compared(split, samples.features[here]), self.leaf_of_sample[here] < middle, counts)


def _compared(
    split: Split | HyperplaneSplit, features: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float | None]:
    """Return the value that a split compares of each sample, and with what, halved so that differences are finite."""
    if isinstance(split, Split):
        return features[:, split.feature] / 2, None if split.threshold is None else split.threshold / 2
    with np.errstate(over="ignore", invalid="ignore"):
        return features[:, split.features] @ (np.array(split.coefficients) / 2), split.offset / 2


def _histogram(
    values: NDArray[np.float64], cut: float | None, is_left: NDArray[np.bool_], counts: NDArray[np.int64]
) -> Histogram:
    """Return the bins left and right of a cut; missing values have one of their own beyond the end of their side."""
    is_known = np.isfinite(values)
    known, step, at = values[is_known], 0.0, 0.0
    if len(known):
        least, most = float(known.min()), float(known.max())
        step = (most - least) / max(1, min(BINS, len(np.unique(known)) - 1))  # whole numbers have a bin each
        beyond = np.inf if is_left[is_known].all() else -np.inf
        at = min(max(beyond if cut is None else cut, least - step / 2), most + step / 2)
    sides = []
    for on_side in (is_left, ~is_left):
        rows = is_known & on_side
        steps = np.ceil(np.abs(values[rows] - at) / (step or 1.0)) - 1  # the outmost is in the last bin
        bins = np.clip(steps, 0, BINS).astype(np.int64)
        side = np.zeros((int(bins.max()) + 1 if len(bins) else 0, counts.shape[1]), dtype=np.int64)
        np.add.at(side, bins, counts[rows])
        gone = counts[on_side & ~is_known].sum(axis=0)
        sides.append(np.vstack([side, np.zeros_like(gone), gone]) if gone.any() else side)
    return Histogram(np.vstack([sides[0][::-1], sides[1]]), len(sides[0]))
