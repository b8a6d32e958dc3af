"""OptimalTreeClassifier: octmip behind scikit-learn's contract, for pipelines, cross-validation and grid search."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.tree import DecisionTreeClassifier
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import _check_sample_weight, check_is_fitted

from octmip.errors import TreeError
from octmip.formats.columns.frames import series_of
from octmip.interfaces.estimator.decision_tree import sklearn_tree
from octmip.interfaces.estimator.fitted import FittedTree
from octmip.interfaces.estimator.leaf_shares import LeafShares, Smoothing
from octmip.interfaces.estimator.samples import label_name, labels_of, learn_samples, read_samples
from octmip.trees.nodes.prediction import predict
from octmip.trees.question.classes import (
    ClassWeight,
    class_order_of,
    codes_of,
    factors_of,
    in_class_order,
    words_of_order,
)
from octmip.trees.question.losses import ClassCosts
from octmip.trees.uncertainty import LeafDistribution


@dataclass(kw_only=True, eq=False, repr=False)
class OptimalTreeClassifier(FittedTree, ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """A classification tree that holds on new samples, or of least training cost, with a bound on how far that is off.

    Parameters
    ----------
    max_depth
        "auto" chooses kind, depth and leaf penalty by cross-validation (`octmip.trees.tradeoff.default`): the tree
        that holds on new samples. A number, 1 to 30, is at most so many splits on a path from the root to a leaf: the
        tree of least training cost. None is any depth, beside a `leaf_penalty` (or `max_leaf_nodes`): the tree of least
        training cost and prices.
    split
        "axis" (one feature and a threshold) or "hyperplane".
    split_size
        at most so many features in one split; None: no limit.
    min_samples_leaf
        at least so many samples in every leaf, whatever they weigh; a number below 1 is a share of all samples.
    min_weight_fraction_leaf
        at least this share of the weight of all samples in every leaf, 0 to 0.5, beside `min_samples_leaf` 1.
    max_leaf_nodes
        at most so many leaves, where `max_depth` is not "auto"; None: no limit.
    monotonic_cst
        for each column of X 1 where the prediction never falls as it rises, -1 where it never rises, 0 elsewhere, or
        a mapping from columns, where `max_depth` is not "auto"; as in scikit-learn, of any number of classes, along
        `class_order`.
    class_order
        the classes from low to high, along which `monotonic_cst` goes; None: the order of y where that is an ordered
        pandas category (polars Enum), of numbers and Booleans their own. Texts have none and need it.
    fixed_splits, path_rules
        parts that the tree must have and rules for the columns on a path, where `max_depth` is not "auto"; as
        `octmip.Problem` takes them, splits by feature and rules by column; None: none.
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
        text and pandas categories become yes/no questions, one per value ("yes-no") or one per set of at most 12 values
        ("subsets"), their rank ("order"), or are refused ("refuse"); an ordered pandas category becomes its rank.
    missing
        missing values go to whichever side of a split is better ("either-side"), or are refused ("refuse").
        Hyperplanes take none.
    takes_missing
        whether predict takes missing values where fit had none, as a fold of a cross-validation may: they go to the
        side of more training weight. A column without a value in fit is then a constant. False refuses both, unless
        some value was missing in fit.
    smoothing
        of the probabilities in each leaf. "out-of-fold" corrects the shares of the training rows, which are too high
        for fresh ones, by rows held out of ten quick refits; they run when a probability is first asked for, and take
        `seconds` at most (`octmip.trees.tradeoff.leaf_shares`). A number instead: so much training weight is added, in
        equal parts to every class; 0 leaves the shares of the training rows. Shares alone are the same for rows of
        weight 2 and for rows that come twice.
    method
        of `octmip.solve`, where `max_depth` is not "auto": "auto" proves for splits on one feature, and searches
        without a proof for hyperplanes.
    options
        of the method, for instance ``SearchOptions(restarts=20)`` (`octmip.trees.methods.options`); None: the defaults.
    seconds
        limit of wall time [s]; the best tree so far is fitted, with a ConvergenceWarning where a proof was begun.
    n_jobs
        threads: None is 1, -1 is all.
    verbose
        1 prints every two seconds how far the fit is; 0 prints nothing.
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
        the classes in each leaf, in the order of `problem_.samples.class_names`
        (`octmip.trees.uncertainty.LeafDistribution`); `made` says how they were counted.
    feature_importances_
        (n_features_in_,) share of each column of X in the training cost that the splits save.

    A sample of weight 0 is left out of the training, as if it were not there.

    Examples
    --------
    >>> tree = OptimalTreeClassifier(max_depth=2).fit([[0], [1], [2]], ["a", "b", "a"])
    >>> tree.predict([[1.2]]), tree.is_optimal_
    (array(['b'], dtype='<U1'), True)
    """

    costs: ArrayLike | None = None
    class_order: Sequence[Any] | None = None
    class_weight: ClassWeight = None
    smoothing: Smoothing = "out-of-fold"

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
        start = time.perf_counter()
        features, labels, columns = learn_samples(self, X, y)
        check_classification_targets(labels)
        given = _check_sample_weight(series_of(sample_weight), features, dtype=np.float64)
        self.classes_ = np.unique(labels)
        self.columns_ = columns
        self._label_name = label_name(y)
        classes = self.classes_.tolist()
        order = tuple(c for c in class_order_of(y, classes, self.class_order) if c in set(classes))
        self._place = codes_of(np.array(order or classes, dtype=object), classes)
        codes = np.searchsorted(self.classes_, labels)
        weights = given * factors_of(self.class_weight, classes, codes, given)[codes]
        own = {
            "loss": ClassCosts(self._costs()),
            "class_names": order or tuple(classes),
            "class_order": order,
            "takes_missing": columns.lack_numbers,
        }
        run = self._answer(features, labels, weights, start, **own)
        self._shares = LeafShares(self.problem_, self._routes, self.smoothing, self.seconds, run.seed, run.n_jobs)
        self._say_how_it_ended()
        return self

    @property
    def leaf_distribution_(self) -> LeafDistribution:
        """The classes in each leaf; `smoothing` says how they are counted, at the first use."""
        check_is_fitted(self, "solution_")
        return self._shares.distribution

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Return the class of each row of X (n_samples, n_features), shape (n_samples,)."""
        check_is_fitted(self, "solution_")
        return np.asarray(self.classes_[self._place[predict(self._routes, read_samples(self, X))]])

    def score(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> float:
        """Return the share of the weight of the rows of X (n_samples, n_features) that gets its class in y."""
        return float(super().score(X, labels_of(y), sample_weight))

    def predict_proba(self, X: ArrayLike, prior: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return the probability of each class in the leaf of each row, shape (n_samples, n_classes).

        It is the class's share of the training weight there, smoothed or corrected as `smoothing` says; with a prior
        (n_classes,) it is what that becomes where the classes come with these probabilities instead of those in
        training.
        """
        check_is_fitted(self, "solution_")
        given = in_class_order(prior, self.classes_.tolist(), "prior")
        before = None if given is None else np.asarray(given)[self._place]
        shares = np.empty_like(found := self.leaf_distribution_.predict(read_samples(self, X), before))
        shares[:, self._place] = found
        return shares

    def _costs(self) -> NDArray[np.float64] | None:
        """Return the costs with rows and columns in the order of the problem's classes."""
        n_classes = len(self.classes_)
        costs = in_class_order(self.costs, self.classes_.tolist(), "costs")
        if costs is None or np.shape(costs) != (n_classes, n_classes):  # a Problem says what is wrong with it
            return cast(NDArray[np.float64] | None, costs)
        return np.asarray(costs)[np.ix_(self._place, self._place)]

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
        if (self._place != np.arange(len(self._place))).any():
            order = words_of_order(self.problem_.samples.class_order)
            raise TreeError(
                f"a DecisionTreeClassifier sorts its classes, and the {order}; name them so that "
                "they sort in this order, such as 1 low, 2 mid, 3 high"
            )
        model = sklearn_tree(self.problem_, self.leaf_distribution_, self.classes_)
        if hasattr(self, "feature_names_in_"):
            model.feature_names_in_ = self.feature_names_in_.copy()
        return model
