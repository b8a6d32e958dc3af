"""OptimalTreeRegressor: octmip's regression trees behind scikit-learn's contract."""

from collections.abc import Mapping, Sequence
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import Tags
from sklearn.utils.validation import _check_sample_weight, check_is_fitted

from octmip.errors import DataError
from octmip.interfaces.estimator.fitted import FittedTree
from octmip.interfaces.estimator.proof import warn_unproven
from octmip.interfaces.estimator.samples import label_name, learn_samples, read_samples
from octmip.interfaces.estimator.settings import (
    AUTO,
    RandomState,
    depth_of,
    leaf_size_of,
    seed_of,
    sensors_of,
    threads_of,
)
from octmip.trees.losses import NumberLoss, number_loss
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.prediction import predict_values
from octmip.trees.problem import Problem
from octmip.trees.run import Run
from octmip.trees.solution import Limits, Stop


class OptimalTreeRegressor(FittedTree, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A regression tree that holds on new samples, or of least training error, with a bound on how far that is off.

    Parameters
    ----------
    max_depth
        "auto", or at most so many splits on a path from the root to a leaf; as in `OptimalTreeClassifier`.
    loss
        "squared" or "absolute" error, a quantile as in "quantile:0.9", or a loss such as ``QuantileError(0.9)``.
    split, split_size
        "axis" (one feature and a threshold), or "hyperplane" over at most so many features, by search.
    leaf_model, ridge
        "constant", or "linear": a ridge regression in each leaf, by search.
    min_samples_leaf
        at least so many samples in every leaf; a number below 1 is a share of all samples.
    leaf_penalty
        price of one feature in one split, in units of weight times error; "auto" chooses its own.
    sensor_of_feature, sensor_cost, sensor_budget, categories, missing
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
    """

    def __init__(
        self,
        max_depth: int | Literal["auto"] = "auto",
        *,
        loss: str | NumberLoss = "squared",
        split: Literal["axis", "hyperplane"] = "axis",
        split_size: int | None = None,
        leaf_model: Literal["constant", "linear"] = "constant",
        ridge: float = 1e-3,
        min_samples_leaf: float = 1,
        leaf_penalty: float = 0.0,
        sensor_of_feature: Mapping[str, str] | Sequence[str] | None = None,
        sensor_cost: Mapping[str, float] | Sequence[float] | None = None,
        sensor_budget: float | None = None,
        categories: Literal["yes-no", "order", "refuse"] = "yes-no",
        missing: Literal["either-side", "refuse"] = "either-side",
        method: Literal["auto", "exact", "search", "cart"] = "auto",
        options: Options | None = None,
        seconds: float = 60.0,
        n_jobs: int | None = None,
        random_state: RandomState = 0,
    ) -> None:
        self.max_depth = max_depth
        self.loss = loss
        self.split = split
        self.split_size = split_size
        self.leaf_model = leaf_model
        self.ridge = ridge
        self.min_samples_leaf = min_samples_leaf
        self.leaf_penalty = leaf_penalty
        self.sensor_of_feature = sensor_of_feature
        self.sensor_cost = sensor_cost
        self.sensor_budget = sensor_budget
        self.categories = categories
        self.missing = missing
        self.method = method
        self.options = options
        self.seconds = seconds
        self.n_jobs = n_jobs
        self.random_state = random_state

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        is_axis = self.split == "axis" and self.leaf_model == "constant"
        tags.input_tags.allow_nan = is_axis and self.missing != "refuse"
        tags.input_tags.string = tags.input_tags.categorical = self.categories != "refuse"
        return tags

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Find the tree for samples X (n_samples, n_features), targets y (n_samples,), weights (n_samples,).

        Ctrl-C leaves the best tree so far fitted, and is raised.

        Raises
        ------
        ProblemError
            parameters or samples are such that no tree can answer (also a ValueError).
        DataError
            columns of X cannot become features, or y is no column of numbers (also a ValueError).
        """
        features, given, self.columns_ = learn_samples(self, X, y, doubled=True)
        self._label_name = label_name(y)
        try:
            targets = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise DataError(f"y cannot be read as numbers ({error}); a regression tree predicts numbers") from error
        weights = _check_sample_weight(sample_weight, features, dtype=np.float64)
        kept = weights != 0
        problem = self._problem(features[kept], targets[kept], weights[kept])
        seed, threads = seed_of(self.random_state), threads_of(self.n_jobs)
        options = self.options or NO_OPTIONS
        self._answer(problem, Run(self.method, Limits(seconds=self.seconds), seed, threads, options))
        if self.solution_.stop is Stop.INTERRUPTED:
            raise KeyboardInterrupt("the best tree so far is fitted")
        if self.max_depth != AUTO:
            warn_unproven(self.solution_, self.solution_.solver == "exact", self.seconds)
        return self

    def _problem(
        self, features: NDArray[np.float64], targets: NDArray[np.float64], weights: NDArray[np.float64]
    ) -> Problem:
        return Problem(
            features,
            targets,
            depth=depth_of(self.max_depth, self.leaf_penalty, self.method, self.options),
            loss=number_loss(self.loss),
            split=self.split,
            split_size=self.split_size,
            leaf_model=self.leaf_model,
            ridge=self.ridge,
            leaf_size=leaf_size_of(self.min_samples_leaf, len(targets)),
            leaf_penalty=self.leaf_penalty,
            weights=weights,
            sensor_of_feature=sensors_of(self.columns_, self.sensor_of_feature),
            sensor_cost=self.sensor_cost,
            sensor_budget=self.sensor_budget,
            feature_names=self.columns_.feature_names,
        )

    def predict(self, X: ArrayLike) -> NDArray[np.float64]:
        """Return the number predicted for each row of X (n_samples, n_features), shape (n_samples,)."""
        check_is_fitted(self, "solution_")
        return predict_values(self.tree_, read_samples(self, X))
