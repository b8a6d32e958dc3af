"""LeafDistribution: the probability of every class in every leaf of a tree, and under other priors than in training.

With w_lk the training weight of class k in leaf l, `strength` m and `prior` q the smoothed share is

    P(k | l) = (w_lk + m q_k) / (sum_j w_lj + m)            m-estimate; Laplace: m = number of classes, q uniform

and where the classes come with the probabilities r_k instead of those in training, t_k, Bayes' rule says

    P'(k | l) = P(k | l) r_k / t_k  /  sum_j P(j | l) r_j / t_j

which takes that readings of a class are as they were in training, only more or fewer of them.

Source: m-estimate: B. Cestnik, Estimating probabilities: a crucial task in machine learning (1990). Priors: M.
Saerens, P. Latinne, C. Decaestecker, Adjusting the outputs of a classifier to new a priori probabilities (2002), eq.
2.4.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.input.named_arrays import as_mapping
from octmip.trees.nodes.tree import Node, leaf_index, leaves
from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]


def smoothed_shares(weights: Floats, strength: float = 0.0, prior: ArrayLike | None = None) -> Floats:
    """Return the shares of the last axis (..., k) of weights, drawn towards `prior` (k,) as by `strength` more weight.

    Without a prior it is uniform. A row without weight has the shares of the prior.

    Raises
    ------
    ProblemError
        strength is no number of 0 or more, or the prior is no distribution.
    """
    if not (math.isfinite(strength) and strength >= 0):
        raise ProblemError(f"strength is {strength}; expected a finite number of 0 or more")
    k = weights.shape[-1]
    towards = np.full(k, 1.0 / k) if prior is None else checked_prior(prior, k)
    total = weights.sum(axis=-1, keepdims=True) + strength
    shares = (weights + strength * towards) / np.where(total > 0, total, 1.0)
    return np.asarray(np.where(total > 0, shares, towards))


def posterior(log_likelihood: Floats, prior: ArrayLike | None = None) -> Floats:
    """Return the probability of each class (n, k) by Bayes' rule; without a prior (k,) all are as likely before.

    Raises
    ------
    ProblemError
        the prior is no distribution, or rules out every class that the likelihood leaves possible.
    """
    table = np.asarray(log_likelihood, dtype=np.float64)
    if prior is not None:
        with np.errstate(divide="ignore"):  # a class of probability 0 stays impossible
            table = table + np.log(checked_prior(prior, table.shape[-1]))
    highest = table.max(axis=-1, keepdims=True)
    if not np.isfinite(highest).all():
        raise ProblemError("the prior gives 0 to every class that the reading leaves possible; give those a share")
    weight = np.exp(table - highest)
    return np.asarray(weight / weight.sum(axis=-1, keepdims=True))


def checked_prior(prior: ArrayLike, n_classes: int) -> Floats:
    """Return a prior (n_classes,), scaled to 1 in all.

    Raises
    ------
    ProblemError
        it has another length, a number below 0, or nothing in all.
    """
    if isinstance(as_mapping(prior), Mapping):
        raise ProblemError(
            f"prior is a {type(prior).__name__} with names; expected {n_classes} numbers in the order of the classes"
        )
    values = np.array(prior, dtype=np.float64)
    if values.shape != (n_classes,) or not np.isfinite(values).all() or (values < 0).any() or values.sum() <= 0:
        raise ProblemError(
            f"prior is {values.tolist()}; expected {n_classes} numbers of 0 or more, one per class, not all 0"
        )
    return np.asarray(values / values.sum())


def fitted_line(shares: Floats, hits: NDArray[np.bool_], weights: Floats) -> tuple[float, float]:
    """Return intercept and slope of the share of hits over the given shares, both (n,), by weighted least squares.

    Where the shares do not differ, or hits fall with them, it is the share of hits alone.
    """
    weight = weights / weights.sum()
    mean, hit = float(weight @ shares), float(weight @ hits)
    spread = float(weight @ (shares - mean) ** 2)
    slope = float(weight @ ((shares - mean) * (hits - hit))) / spread if spread > 1e-12 else 0.0
    slope = max(slope, 0.0)
    return hit - slope * mean, slope


def corrected_shares(shares: Floats, line: tuple[float, float], prior: Floats) -> Floats:
    """Return shares (n_leaves, n_classes) whose greatest of each row follows a line (intercept, slope).

    The other classes keep their ratios, those of `prior` (n_classes,) in a leaf of one class; the greatest stays so.
    """
    out = np.array(shares)
    for row in out:
        top = int(row.argmax())
        rest = np.where(np.arange(len(row)) == top, 0.0, row if row[top] < 1.0 else prior)
        if not rest.any():  # no other class anywhere
            continue
        rest = rest / rest.sum()
        least = float(rest.max() / (1.0 + rest.max())) * (1.0 + 1e-9)  # no tie, which might fall to another class
        greatest = min(max(line[0] + line[1] * float(row[top]), least), 1.0)
        row[:] = (1.0 - greatest) * rest
        row[top] = greatest
    return out


@dataclass(frozen=True, slots=True, eq=False)
class LeafDistribution:
    """The classes in each leaf of a tree.

    Attributes
    ----------
    tree
        over the features of the samples.
    weights
        (n_leaves, n_classes) training weight of each class in each leaf, leaves from the left.
    strength
        of the smoothing, in units of weight.
    prior
        (n_classes,) towards which it draws; None: uniform.
    line
        intercept and slope that the greatest share of each leaf follows on rows that took no part in the training
        (`octmip.trees.tradeoff.leaf_shares`); None: the shares are those of the training rows.
    probabilities
        (n_leaves, n_classes), derived.
    """

    tree: Node
    weights: Floats
    strength: float = 0.0
    prior: Floats | None = None
    line: tuple[float, float] | None = None
    probabilities: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        weights = np.array(self.weights, dtype=np.float64)
        if weights.ndim != 2 or len(weights) != len(leaves(self.tree)) or (weights < 0).any():
            raise ProblemError(
                f"weights has shape {weights.shape} and the tree {len(leaves(self.tree))} leaves; "
                "expected one row per leaf, weights of 0 or more"
            )
        shares = smoothed_shares(weights, self.strength, self.prior)
        if self.line is not None:
            shares = corrected_shares(shares, self.line, smoothed_shares(weights.sum(axis=0)))
        for name, values in (("weights", weights), ("probabilities", shares)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @classmethod
    def of(
        cls,
        tree: Node,
        problem: Problem,
        *,
        strength: float = 0.0,
        prior: Floats | None = None,
        is_weighted: bool = True,
    ) -> "LeafDistribution":
        """Return the distribution of a tree over the samples of a problem.

        Parameters
        ----------
        is_weighted
            count samples by the problem's weights; False: each as one, where weights are what an error
            costs and not how often a sample comes.
        """
        samples = problem.samples
        weights = np.zeros((len(leaves(tree)), samples.n_classes))
        added = samples.weights if is_weighted else np.ones(samples.n_samples)
        np.add.at(weights, (leaf_index(tree, samples.features), samples.codes), added)
        return cls(tree, weights, strength, prior)

    @property
    def made(self) -> str:
        """How the probabilities were made, for a sentence."""
        if self.line is not None:
            return "training shares, the greatest corrected by rows held out of refits"
        return "training shares" + (f", smoothed by {self.strength:g}" if self.strength else "")

    @property
    def training_prior(self) -> Floats:
        """Share (n_classes,) of each class in the training weight."""
        return smoothed_shares(self.weights.sum(axis=0))

    def with_prior(self, prior: ArrayLike) -> Floats:
        """Return the probabilities (n_leaves, n_classes) where the classes come with these (n_classes,) instead.

        Raises
        ------
        ProblemError
            it is no distribution, or gives a share to a class that training never saw.
        """
        wanted, trained = checked_prior(prior, self.weights.shape[1]), self.training_prior
        if (wanted[trained == 0] > 0).any():
            unseen = np.flatnonzero((trained == 0) & (wanted > 0)).tolist()
            raise ProblemError(f"prior gives a share to the classes {unseen}, which training never saw; give them 0")
        with np.errstate(divide="ignore"):
            likelihood = np.log(self.probabilities) - np.log(np.where(trained > 0, trained, 1.0))
        return posterior(likelihood, wanted)

    def predict(self, features: ArrayLike, prior: ArrayLike | None = None) -> Floats:
        """Return the probability of each class (n_samples, n_classes) for features (n_samples, n_features)."""
        table = self.probabilities if prior is None else self.with_prior(prior)
        return np.asarray(table[leaf_index(self.tree, np.asarray(features, dtype=np.float64))])
