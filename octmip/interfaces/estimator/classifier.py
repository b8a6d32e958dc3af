"""OptimalTreeClassifier: octmip behind scikit-learn's contract, for pipelines, cross-validation and grid search."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.tree import DecisionTreeClassifier
from sklearn.utils import Tags
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import _check_sample_weight, check_is_fitted

from octmip.errors import TreeError
from octmip.interfaces.estimator.decision_tree import sklearn_tree
from octmip.interfaces.estimator.fitted import FittedTree
from octmip.interfaces.estimator.leaf_shares import LeafShares, Smoothing
from octmip.interfaces.estimator.proof import method_proves, warn_unproven
from octmip.interfaces.estimator.samples import label_name, learn_samples, read_samples
from octmip.interfaces.estimator.settings import (
    AUTO,
    ClassWeight,
    RandomState,
    class_weights,
    depth_of,
    leaf_size_of,
    seed_of,
    sensors_of,
    threads_of,
)
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.prediction import predict
from octmip.trees.problem import Problem
from octmip.trees.run import Method, Run
from octmip.trees.solution import Limits, Stop
from octmip.trees.uncertainty import LeafDistribution


class OptimalTreeClassifier(FittedTree, ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """A classification tree that holds on new samples, or of least training cost, with a bound on how far that is off.

    Parameters
    ----------
    max_depth
        "auto" chooses kind, depth and leaf penalty by cross-validation (`octmip.trees.tradeoff.default`): the tree
        that holds on new samples. A number, 1 to 30, is at most so many splits on a path from the root to a leaf: the
        tree of least training cost.
    split
        "axis" (one feature and a threshold) or "hyperplane".
    split_size
        at most so many features in one split; None: no limit.
    min_samples_leaf
        at least so many samples in every leaf; a number below 1 is a share of all samples.
    leaf_penalty
        price of one feature in one split, in units of weight times cost; "auto" chooses its own.
    costs
        (n_classes, n_classes) cost of predicting column k for a class of row i, classes sorted; None: 0/1.
    class_weight
        weight of each class by name, "balanced" (every class weighs the same in all) or None (all 1); it
        multiplies sample_weight.
    sensor_of_feature
        sensor from which a column of X is read: one name per column, or a mapping from columns (others are
        their own); None: every column is its own sensor.
    sensor_cost
        cost of each sensor, by name or in the order of their first column; None: 1 each.
    sensor_budget
        at most so much sensor cost in the whole tree; None: no limit.
    categories
        text and pandas categories become yes/no questions ("yes-no"), their rank ("order"), or are refused
        ("refuse"); an ordered pandas category becomes its rank.
    missing
        missing values go to whichever side of a split is better ("either-side"), or are refused ("refuse").
        Hyperplanes take none. Where some are missing in fit, predict takes them too, in any column.
    smoothing
        of the probabilities in each leaf. "out-of-fold" corrects the shares of the training rows, which are too high
        for fresh ones, by rows held out of ten quick refits; they run when a probability is first asked for, and take
        `seconds` at most (`octmip.trees.tradeoff.leaf_shares`). A number instead: so much training weight is added, in
        equal parts to every class; 0 leaves the shares of the training rows.
    method
        of `octmip.solve`, for a `max_depth` that is a number: "auto" proves for splits on one feature, and searches
        without a proof for hyperplanes.
    options
        of the method, for instance ``SearchOptions(restarts=20)`` (`octmip.trees.methods.options`); None: the defaults.
    seconds
        limit of wall time [s]; the best tree so far is fitted, with a ConvergenceWarning where a proof was begun.
    n_jobs
        threads: None is 1, -1 is all.
    random_state
        seed of all random choices, a RandomState to draw it from, or None for another one in every fit.

    Attributes
    ----------
    classes_
        the classes, sorted.
    n_features_in_, feature_names_in_
        of X, as scikit-learn has them.
    columns_
        how the columns of X became features (`octmip.formats.columns.Columns`).
    problem_
        the Problem that was solved: features, weights, costs. It holds the training samples.
    solution_
        the Solution; `tree_`, `objective_`, `bound_`, `gap_` and `is_optimal_` are its own.
    choice_
        with `max_depth="auto"` everything that the tree was chosen from (`octmip.trees.tradeoff.Choice`); its
        `expectation` says what it and CART cost on new samples. None where nothing was chosen.
    certificate_
        what was recomputed from problem and tree alone (`octmip.Certificate`); `sensors_` are those it names.
    leaf_distribution_
        the classes in each leaf (`octmip.trees.uncertainty.LeafDistribution`); `made` says how they were counted.
    feature_importances_
        (n_features_in_,) share of each column of X in the training cost that the splits save.

    A sample of weight 0 is left out of the training, as if it were not there.
    """

    def __init__(
        self,
        max_depth: int | Literal["auto"] = "auto",
        *,
        split: Literal["axis", "hyperplane"] = "axis",
        split_size: int | None = None,
        min_samples_leaf: float = 1,
        leaf_penalty: float = 0.0,
        costs: ArrayLike | None = None,
        class_weight: ClassWeight = None,
        sensor_of_feature: Mapping[str, str] | Sequence[str] | None = None,
        sensor_cost: Mapping[str, float] | Sequence[float] | None = None,
        sensor_budget: float | None = None,
        categories: Literal["yes-no", "order", "refuse"] = "yes-no",
        missing: Literal["either-side", "refuse"] = "either-side",
        smoothing: Smoothing = "out-of-fold",
        method: Method = "auto",
        options: Options | None = None,
        seconds: float = 60.0,
        n_jobs: int | None = None,
        random_state: RandomState = 0,
    ) -> None:
        self.max_depth = max_depth
        self.split = split
        self.split_size = split_size
        self.min_samples_leaf = min_samples_leaf
        self.leaf_penalty = leaf_penalty
        self.costs = costs
        self.class_weight = class_weight
        self.sensor_of_feature = sensor_of_feature
        self.sensor_cost = sensor_cost
        self.sensor_budget = sensor_budget
        self.categories = categories
        self.missing = missing
        self.smoothing = smoothing
        self.method = method
        self.options = options
        self.seconds = seconds
        self.n_jobs = n_jobs
        self.random_state = random_state

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = self.split == "axis" and self.missing != "refuse"
        tags.input_tags.string = tags.input_tags.categorical = self.categories != "refuse"
        return tags

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Find the tree for samples X (n_samples, n_features), classes y (n_samples,), weights (n_samples,).

        Ctrl-C leaves the best tree so far fitted, and is raised.

        Raises
        ------
        ProblemError
            parameters or samples are such that no tree can answer (also a ValueError).
        DataError
            columns of X cannot become features (also a ValueError).
        SolverError
            no tree was found.
        """
        features, labels, columns = learn_samples(self, X, y)
        check_classification_targets(labels)
        given = _check_sample_weight(sample_weight, features, dtype=np.float64)
        self.classes_ = np.unique(labels)
        self.columns_ = columns
        self._label_name = label_name(y)
        weights = class_weights(self.class_weight, self.classes_, labels, given)
        kept = weights != 0
        problem = self._problem(features[kept], labels[kept], weights[kept])
        seed, threads = seed_of(self.random_state), threads_of(self.n_jobs)
        options = self.options or NO_OPTIONS
        problem = self._answer(problem, Run(self.method, Limits(seconds=self.seconds), seed, threads, options))
        self._shares = LeafShares(problem, self.tree_, self.smoothing, self.seconds, seed, threads)
        if self.solution_.stop is Stop.INTERRUPTED:
            raise KeyboardInterrupt("the best tree so far is fitted")
        if self.max_depth != AUTO:
            warn_unproven(self.solution_, method_proves(problem, self.method), self.seconds)
        return self

    def _problem(self, features: NDArray[np.float64], labels: NDArray[Any], weights: NDArray[np.float64]) -> Problem:
        return Problem(
            features,
            labels,
            depth=depth_of(self.max_depth, self.leaf_penalty, self.method, self.options),
            split=self.split,
            split_size=self.split_size,
            leaf_size=leaf_size_of(self.min_samples_leaf, len(labels)),
            leaf_penalty=self.leaf_penalty,
            loss=ClassCosts(self.costs),
            weights=weights,
            sensor_of_feature=sensors_of(self.columns_, self.sensor_of_feature),
            sensor_cost=self.sensor_cost,
            sensor_budget=self.sensor_budget,
            class_names=tuple(self.classes_.tolist()),
            gaps=self.columns_.lack_numbers,
            feature_names=self.columns_.feature_names,
        )

    @property
    def leaf_distribution_(self) -> LeafDistribution:
        """The classes in each leaf; `smoothing` says how they are counted, at the first use."""
        check_is_fitted(self, "solution_")
        return self._shares.distribution

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Return the class of each row of X (n_samples, n_features), shape (n_samples,)."""
        check_is_fitted(self, "solution_")
        return np.asarray(self.classes_[predict(self.tree_, read_samples(self, X))])

    def predict_proba(self, X: ArrayLike, prior: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return the probability of each class in the leaf of each row, shape (n_samples, n_classes).

        It is the class's share of the training weight there, smoothed or corrected as `smoothing` says; with a prior
        (n_classes,) it is what that becomes where the classes come with these probabilities instead of those in
        training.
        """
        check_is_fitted(self, "solution_")
        return self.leaf_distribution_.predict(read_samples(self, X), prior)

    def predict_log_proba(self, X: ArrayLike) -> NDArray[np.float64]:
        """Return the logarithm of `predict_proba`, shape (n_samples, n_classes); -inf for a probability of 0."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.predict_proba(X)))

    def to_sklearn(self) -> DecisionTreeClassifier:
        """Return a fitted sklearn.tree.DecisionTreeClassifier with the same splits and probabilities.

        It predicts the same class for every training sample. New samples may differ within the rounding to float32,
        as which scikit-learn reads them.

        Raises
        ------
        TreeError
            the tree has no such form: it reads hyperplanes or encoded columns, rounding to float32 takes a training
            sample to another leaf, or costs make a leaf predict another class than the one with the greatest share.
        """
        check_is_fitted(self, "solution_")
        if not self.columns_.is_plain:
            raise TreeError(
                f"a DecisionTreeClassifier reads numbers only, and here {'; '.join(self.columns_.changes())}; fit on "
                "columns_.encode(X), whose columns are numbers, and convert that"
            )
        model = sklearn_tree(self.problem_, self.leaf_distribution_, self.classes_)
        if hasattr(self, "feature_names_in_"):
            model.feature_names_in_ = self.feature_names_in_.copy()
        return model
