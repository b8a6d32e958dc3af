"""OptimalTreeRegressor: octmip's regression trees behind scikit-learn's contract."""

import time
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import Tags
from sklearn.utils.validation import _check_sample_weight, check_is_fitted

from octmip.formats.columns.frames import series_of
from octmip.interfaces.estimator.fitted import FittedTree
from octmip.interfaces.estimator.samples import label_name, learn_samples, read_samples
from octmip.trees.nodes.prediction import predict_values
from octmip.trees.question.losses import NumberLoss, number_loss
from octmip.trees.question.problem_values import numbers_of


@dataclass(kw_only=True, eq=False, repr=False)
class OptimalTreeRegressor(FittedTree, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A regression tree that holds on new samples, or of least training error, with a bound on how far that is off.

    Parameters
    ----------
    max_depth
        "auto", or at most so many splits on a path from the root to a leaf; as in `OptimalTreeClassifier`. None, beside
        a `leaf_penalty`, is searched and not proven.
    loss
        "squared" or "absolute" error, a quantile as in "quantile:0.9", or a loss such as ``QuantileError(0.9)``.
    split, split_size
        "axis" (one feature and a threshold), or "hyperplane" over at most so many features, by search.
    leaf_model, ridge
        "constant", or "linear": a ridge regression in each leaf, by search.
    min_samples_leaf
        at least so many samples in every leaf, whatever they weigh; a number below 1 is a share of all samples.
    min_weight_fraction_leaf
        at least this share of the weight of all samples in every leaf, 0 to 0.5, beside `min_samples_leaf` 1.
    max_leaf_nodes
        at most so many leaves, where `max_depth` is not "auto"; None: no limit.
    monotonic_cst
        for each column of X 1 where the prediction never falls as it rises, -1 where it never rises, 0 elsewhere, or
        a mapping from columns, where `max_depth` is not "auto"; as in scikit-learn, of any number of classes.
    leaf_penalty
        price of one feature in one split, in units of weight times error; "auto" chooses its own.
    sensor_of_feature, sensor_cost, sensor_budget, categories, missing, takes_missing
        as in `OptimalTreeClassifier`.
    method
        "auto" proves where splits read one feature and leaves hold one number, else searches; "exact", "search", or
        "cart", the greedy tree.
    options
        of the method (`octmip.trees.methods.options`); None: the defaults.
    seconds
        limit of wall time [s]; the best tree so far is fitted, with a ConvergenceWarning where a proof was begun.
    n_jobs
        threads: None is 1, -1 is all.
    verbose
        1 prints every two seconds how far the fit is; 0 prints nothing.
    random_state
        seed of the search's random choices, a RandomState to draw it from, or None for another one in every fit.

    Attributes
    ----------
    n_features_in_, feature_names_in_
        of X, as scikit-learn has them.
    columns_
        how the columns of X became features (`octmip.formats.columns.Columns`).
    problem_, solution_, certificate_
        the Problem that was solved, its Solution, and what was recounted from problem and tree alone.
    choice_
        what the tree was chosen from, as in `OptimalTreeClassifier`.

    A sample of weight 0 is left out of the training, as if it were not there.

    Examples
    --------
    >>> OptimalTreeRegressor(max_depth=1).fit([[0], [1], [2]], [5.0, 5.0, 8.0]).predict([[1.8]])
    array([8.])
    """

    loss: str | NumberLoss = "squared"
    leaf_model: Literal["constant", "linear"] = "constant"
    ridge: float = 1e-3

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan &= self.leaf_model == "constant"
        return tags

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Find the tree for samples X (n_samples, n_features), targets y (n_samples,), weights (n_samples,).

        Ctrl-C leaves the best tree so far fitted, and is raised.

        Raises
        ------
        ProblemError
            parameters or samples are such that no tree can answer, or y is no column of numbers (also a ValueError).
        DataError
            columns of X cannot become features (also a ValueError).
        """
        start = time.perf_counter()
        features, given, self.columns_ = learn_samples(self, X, y, doubled=True)
        self._label_name = label_name(y)
        targets = numbers_of(given, "y", 1)
        weights = _check_sample_weight(series_of(sample_weight), features, dtype=np.float64)
        own = {"loss": number_loss(self.loss), "leaf_model": self.leaf_model, "ridge": self.ridge}
        self._answer(features, targets, weights, start, **own)
        self._say_how_it_ended()
        return self

    def predict(self, X: ArrayLike) -> NDArray[np.float64]:
        """Return the number predicted for each row of X (n_samples, n_features), shape (n_samples,)."""
        check_is_fitted(self, "solution_")
        return predict_values(self._routes, read_samples(self, X))
