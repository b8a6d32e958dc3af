"""OptimalTreeClassifier: octmip behind scikit-learn's contract, for pipelines, cross-validation and grid search."""

from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from octmip.errors import SolverError
from octmip.problem import Problem
from octmip.solution import Limits, Solution
from octmip.solver import Method, solve
from octmip.tree import Node, predict
from octmip.uncertainty import LeafDistribution


class OptimalTreeClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """A classification tree of least training cost, with the bound that says how far from it a better one can be.

    Parameters
    ----------
    depth
        levels of splits.
    split
        "axis" or "hyperplane".
    split_size
        at most so many features in one split; None: no limit.
    leaf_size
        at least so many samples in every leaf.
    leaf_penalty
        price of one feature in one split, in units of weight times cost.
    costs
        (n_classes, n_classes) cost of predicting column k for a class of row i, classes sorted; None: 0/1.
    smoothing
        of the probabilities in each leaf: so much training weight is added, in equal parts to every class.
    method
        of `octmip.solve`.
    seconds
        limit of wall time [s]; reaching it is no error, see `gap_`.
    n_jobs
        threads.
    seed
        of all random choices.

    Attributes
    ----------
    classes_
        the classes, sorted.
    n_features_in_, feature_names_in_
        as scikit-learn has them.
    solution_
        the Solution; `tree_`, `bound_` and `gap_` are its tree, bound and gap.
    leaf_distribution_
        what each leaf says of the classes (`octmip.uncertainty.LeafDistribution`).

    A sample of weight 0 is left out of the training, as if it were not there.
    """

    def __init__(
        self,
        depth: int = 3,
        *,
        split: Literal["axis", "hyperplane"] = "axis",
        split_size: int | None = None,
        leaf_size: int = 1,
        leaf_penalty: float = 0.0,
        costs: ArrayLike | None = None,
        smoothing: float = 0.0,
        method: Method = "auto",
        seconds: float = 60.0,
        n_jobs: int = 1,
        seed: int = 0,
    ) -> None:
        self.depth = depth
        self.split = split
        self.split_size = split_size
        self.leaf_size = leaf_size
        self.leaf_penalty = leaf_penalty
        self.costs = costs
        self.smoothing = smoothing
        self.method = method
        self.seconds = seconds
        self.n_jobs = n_jobs
        self.seed = seed

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Find the tree for samples X (n_samples, n_features), classes y (n_samples,), weights (n_samples,).

        Raises
        ------
        ProblemError
            parameters or samples are such that no tree can answer (also a ValueError).
        SolverError
            no tree was found.
        """
        features, labels = validate_data(self, X, y, dtype=np.float64)
        check_classification_targets(labels)
        weights = _check_sample_weight(sample_weight, features, dtype=np.float64)
        self.classes_ = np.unique(labels)
        features, labels = features[weights != 0], labels[weights != 0]
        problem = self._problem(features, labels, weights[weights != 0])
        limits = Limits(seconds=self.seconds)
        self.solution_: Solution = solve(problem, self.method, limits, seed=self.seed, n_jobs=self.n_jobs)
        if self.solution_.tree is None:
            raise SolverError(f"{self.solution_.solver} found no tree within {self.seconds} s; give it more seconds")
        self.leaf_distribution_ = LeafDistribution.of(self.solution_.tree, problem, strength=self.smoothing)
        return self

    def _problem(self, features: NDArray[np.float64], labels: NDArray[Any], weights: NDArray[np.float64]) -> Problem:
        names = getattr(self, "feature_names_in_", None)
        return Problem(
            features,
            labels,
            depth=self.depth,
            split=self.split,
            split_size=self.split_size,
            leaf_size=self.leaf_size,
            leaf_penalty=self.leaf_penalty,
            costs=self.costs,  # type: ignore[arg-type]
            weights=weights,
            class_names=tuple(self.classes_.tolist()),
            feature_names=None if names is None else tuple(names),  # type: ignore[arg-type]
        )

    @property
    def tree_(self) -> Node:
        """The tree."""
        check_is_fitted(self, "solution_")
        tree = self.solution_.tree
        assert tree is not None  # fit has seen to it
        return tree

    @property
    def bound_(self) -> float:
        """No tree of the problem has a training objective below it; -inf without a proof."""
        check_is_fitted(self, "solution_")
        return self.solution_.bound

    @property
    def gap_(self) -> float:
        """Relative gap between training objective and bound: 0 when proven optimal, +inf without a proof."""
        check_is_fitted(self, "solution_")
        return self.solution_.gap

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Return the class of each row of X (n_samples, n_features), shape (n_samples,)."""
        check_is_fitted(self, "solution_")
        features = validate_data(self, X, dtype=np.float64, reset=False)
        return np.asarray(self.classes_[predict(self.tree_, features)])

    def predict_proba(self, X: ArrayLike, prior: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return the probability of each class in the leaf of each row, shape (n_samples, n_classes).

        It is the class's share of the training weight there, smoothed; with a prior (n_classes,) it is what that
        becomes where the classes come with these probabilities instead of those in training.
        """
        check_is_fitted(self, "solution_")
        features = validate_data(self, X, dtype=np.float64, reset=False)
        return self.leaf_distribution_.predict(features, prior)
