"""Held-out samples: rows kept from training, and what a tree and CART lose on both parts.

Which rows are held out follows from the labels, a share and a seed alone, by the raw stream of PCG64, which NumPy
promises to keep: a tree file names share and seed, and its training rows are found again years later. The stream is
not that of `default_rng(seed)`, by which a user may have drawn the very table: rows of low draws would be held out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.answer.certificate import leaf_counts, shares_in_leaves
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.nodes.tree import Node, leaf_index, predict, predict_values
from octmip.trees.question.classes import distinct_labels
from octmip.trees.question.losses import Loss
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff.validation import Expected

OWN_STREAM = 0x6865_6C64
"""Entropy beside the seed of held-out rows."""
Z_95 = 1.96
"""Standard errors to either side of a mean that hold 95 % of a normal distribution."""
Shares = Callable[[NDArray[np.float64]], tuple[NDArray[np.int64], NDArray[np.float64]]]
"""From features (n, n_features) to the group (n,) of each row, and the shares of the classes (n_groups, n_classes)."""


def held_out_rows(labels: NDArray[Any], share: float, seed: int) -> NDArray[np.bool_]:
    """Return which rows are held out, shape (n_rows,): of each class its share, rounded, but never its last row.

    Raises
    ------
    ProblemError
        the share is not between 0 and 1, or so small that no row is held out.
    """
    if not 0.0 < share < 1.0:
        raise ProblemError(f"the share held out is {share}; expected more than 0 and less than 1, such as 0.25")
    _, codes = distinct_labels(labels)
    order = np.lexsort((np.random.PCG64([seed, OWN_STREAM]).random_raw(len(codes)), codes))
    is_held = np.zeros(len(codes), dtype=np.bool_)
    for rows in np.split(order, np.cumsum(np.bincount(codes))[:-1]):
        is_held[rows[: min(len(rows) - 1, int(share * len(rows) + 0.5))]] = True
    if not is_held.any():
        raise ProblemError(
            f"a share of {share:g} of {len(codes)} rows holds none out, as each class keeps a row; give a larger share"
        )
    return is_held


def strata_of(loss: Loss, targets: NDArray[Any]) -> NDArray[Any]:
    """Return what rows are held out of, a share of each: classes, or one stratum where numbers are predicted."""
    return targets if loss.predicts == "class" else np.zeros(len(targets))


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Samples that a tree is judged by.

    Attributes
    ----------
    features
        (n_samples, n_features) numbers.
    codes
        (n_samples,) target of each as in `Samples.codes`: an index of the problem's `class_names`, or a number.
    weights
        (n_samples,) risk weights.
    """

    features: NDArray[np.float64]
    codes: NDArray[Any]
    weights: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Predictor:
    """What is judged beside a tree.

    Attributes
    ----------
    codes
        from features (n, n_features) to what `Samples.codes` holds (n,): index of the class, or number.
    shares
        of the classes; None: it knows none.
    """

    codes: Callable[[NDArray[np.float64]], NDArray[Any]]
    shares: Shares | None = None

    def __call__(self, features: NDArray[np.float64]) -> NDArray[Any]:
        """Return the codes."""
        return self.codes(features)


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """Samples by the shares of the classes that a predictor gives them: a tree those of the training rows of a leaf.

    Attributes
    ----------
    counts
        (n_groups, n_classes) samples of each true class; a leaf is a group, or one sample.
    shares
        (n_groups, n_classes) that the predictor gives them.
    """

    counts: NDArray[np.int64]
    shares: NDArray[np.float64]

    def roc(self, label: int) -> NDArray[np.float64]:
        """Return the points of the curve from (0, 0) to (1, 1), shape (2, n_points): false and true positive rate.

        Each point holds for a least share of the class, so samples of equal shares make one step. NaN where the samples
        lack the class, or have no other.
        """
        _, step = np.unique(-self.shares[:, label], return_inverse=True)
        own = self.counts[:, label]
        found = [np.bincount(step, counts) for counts in (self.counts.sum(axis=1) - own, own)]
        points = np.pad(np.cumsum(found, axis=1), ((0, 0), (1, 0)))
        with np.errstate(invalid="ignore"):
            return np.asarray(points / points[:, -1:])

    @property
    def auroc(self) -> NDArray[np.float64]:
        """Area under `roc` of each class against the rest, by trapezoids, shape (n_classes,)."""
        curves = [self.roc(label) for label in range(self.shares.shape[1])]
        return np.array([float(np.diff(x) @ (y[1:] + y[:-1])) / 2 for x, y in curves])


@dataclass(frozen=True, slots=True)
class Score:
    """What a tree loses on some samples.

    Attributes
    ----------
    n_samples, measures, cost
        their number, what the tree is judged by (`Loss.measures`), and the cost (no leaf penalty).
    confusion
        (n_classes, n_classes) samples by true and predicted class; None of a tree of numbers.
    rank
        returns the samples by shares of the classes; None where there are no shares.
    """

    n_samples: int
    measures: Mapping[str, float]
    cost: float
    confusion: NDArray[np.int64] | None = field(default=None, compare=False, repr=False)
    rank: Callable[[], Ranking] | None = field(default=None, compare=False, repr=False)

    @property
    def errors(self) -> int:
        """How many of the samples are wrong, of a tree of classes."""
        return int(self.measures["errors"])

    @property
    def error_rate(self) -> float:
        """Share of the samples that are wrong."""
        return self.errors / self.n_samples

    @property
    def balanced_accuracy(self) -> float | None:
        """Mean recall of the classes that have samples; None of a tree of numbers."""
        return None if self.confusion is None else balanced_accuracy(self.confusion)


@dataclass(frozen=True, slots=True)
class Comparison:
    """A tree beside CART of the same problem, on the training samples and on those held out (None: there are none).

    `difference` is the cost per unit of weight on the samples held out, the tree's less CART's: with the interval of
    95 % that the spread of the samples gives.
    """

    training: Score
    held_out: Score | None
    cart_training: Score
    cart_held_out: Score | None
    cart_tree: Node
    difference: Expected | None


def score(problem: Problem, tree: Node, samples: Samples | None = None) -> Score:
    """Return what a tree loses on samples; on those of the problem if none are given."""
    return score_of(problem, predictor_of(problem, tree), samples)


def predictor_of(problem: Problem, tree: Node) -> Predictor:
    """Return a tree as a predictor, with the shares of the problem's samples in its leaves."""
    if problem.loss.predicts == "number":
        return Predictor(partial(predict_values, tree))
    return Predictor(partial(predict, tree), partial(_shares, problem, tree))


def _shares(
    problem: Problem, tree: Node, features: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    return leaf_index(tree, features), shares_in_leaves(leaf_counts(problem, tree))


def score_of(problem: Problem, predictor: Predictor, samples: Samples | None = None) -> Score:
    """Return what any predictor loses on samples; on those of the problem if none are given."""
    samples = samples or Samples(problem.samples.features, problem.samples.codes, problem.samples.weights)
    judged = samples.weights, samples.codes, predictor(samples.features)
    measures, cost = problem.loss.measures(*judged), problem.loss.cost(*judged, Fraction(0))
    confusion = confusion_of(*judged[1:], problem.samples.n_classes) if problem.loss.predicts == "class" else None
    rank = predictor.shares and partial(_ranked, samples, predictor.shares)
    return Score(len(samples.codes), measures, cost, confusion, rank)


def _ranked(samples: Samples, shares: Shares) -> Ranking:
    group, found = shares(samples.features)
    counts = np.zeros(found.shape, dtype=np.int64)
    np.add.at(counts, (group, samples.codes), 1)
    return Ranking(counts, found)


def confusion_of(codes: NDArray[Any], predicted: NDArray[Any], n_classes: int) -> NDArray[np.int64]:
    """Return samples by true and predicted class, shape (n_classes, n_classes)."""
    counts = np.zeros((n_classes, n_classes), dtype=np.int64)
    np.add.at(counts, (codes, predicted), 1)
    return counts


def recall_precision(confusion: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return of each class the share of its samples that are found, and of its answers that are right; NaN of none."""
    right = np.diag(confusion)
    with np.errstate(invalid="ignore"):
        return right / confusion.sum(axis=1), right / confusion.sum(axis=0)


def balanced_accuracy(confusion: NDArray[np.int64]) -> float:
    """Return the mean recall of the classes that have samples."""
    return mean_of_known(recall_precision(confusion)[0])


def mean_of_known(values: NDArray[np.float64]) -> float:
    """Return the mean of the values that are numbers; NaN of none."""
    known = values[~np.isnan(values)]
    return float(known.mean()) if known.size else np.nan


def beside_cart(problem: Problem, tree: Node, held_out: Samples | None = None, seed: int = 0) -> Comparison:
    """Return what a tree and CART, trained on the same samples, lose there and on those held out.

    Parameters
    ----------
    problem
        the tree's problem, over the training samples.
    tree
        the tree.
    held_out
        samples that neither saw.
    seed
        of CART.
    """
    cart = greedy_tree(problem, seed=seed).tree
    return Comparison(
        training=score(problem, tree),
        held_out=None if held_out is None else score(problem, tree, held_out),
        cart_training=score(problem, cart),
        cart_held_out=None if held_out is None else score(problem, cart, held_out),
        cart_tree=cart,
        difference=None if held_out is None else _difference(problem, tree, cart, held_out),
    )


def _difference(problem: Problem, tree: Node, other: Node, samples: Samples) -> Expected | None:
    """Return the mean cost of a tree less that of another, None where no sample weighs anything."""
    total = float(samples.weights.sum())
    if total == 0:
        return None
    predicted = (predictor_of(problem, one)(samples.features) for one in (tree, other))
    by_tree, by_other = (problem.loss.row_costs(samples.weights, samples.codes, values) for values in predicted)
    mean = float((by_tree - by_other).sum()) / total
    error = float(np.sqrt(((by_tree - by_other - mean * samples.weights) ** 2).sum())) / total
    return Expected(mean, mean - Z_95 * error, mean + Z_95 * error)
