"""Baselines: the models that people try beside a tree, trained on the samples of a problem.

| model | what it is | missing readings |
|---|---|---|
| linear | logistic regression of scaled columns; of numbers, least squares | median |
| discriminant | linear discriminant analysis, which takes no weights | median |
| rounded | least squares to classes that are numbers, rounded to the nearest class | median |
| pruned CART | CART of any depth, its pruning chosen by five folds (`choose_tree`) | a side of each split |
| forest | random forest of 200 trees | a side of each split |
| boosting | gradient boosting of 100 trees on histograms | a side of each split |

All but pruned CART are scikit-learn's and minimise their own loss, not the costs of the problem.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.problem import Problem
from octmip.trees.shape import MAX_DEPTH
from octmip.trees.solution import Limits
from octmip.trees.tradeoff.choice import choose_tree
from octmip.trees.tradeoff.family import Family
from octmip.trees.tree import predict, predict_values

Predictor = Callable[[NDArray[np.float64]], NDArray[Any]]
"""From features (n, n_features) to what `Problem.codes` holds: index of the class, or number (n,)."""
FOREST_TREES = 200
MOST_ITERATIONS = 2000
"""Of logistic regression."""


def baselines_of(problem: Problem) -> Mapping[str, Callable[[int], Predictor]]:
    """Return by its name each baseline that a problem can have: a function that trains it for a seed.

    Training raises a ProblemError where the samples are too few for the folds of pruned CART.
    """
    is_class = problem.loss.predicts == "class"
    found = {"linear": partial(_fitted, problem, "logistic" if is_class else "least squares")}
    if is_class and (problem.weights == problem.weights[0]).all():
        found["discriminant"] = partial(_fitted, problem, "discriminant")
    if is_class and all(isinstance(name, int | float | np.number) for name in problem.class_names):
        found["rounded"] = partial(_rounded, problem)
    found["pruned CART"] = partial(_pruned_cart, problem)
    return found | {name: partial(_fitted, problem, name) for name in ("forest", "boosting")}


def _fitted(problem: Problem, name: str, seed: int) -> Predictor:
    model = _model(name, problem.loss.predicts == "class", seed)
    weights = {} if name == "discriminant" else {"sample_weight": problem.weights}
    if name in ("logistic", "least squares"):
        weights = {"model__sample_weight": problem.weights}
    found: Predictor = model.fit(problem.features, problem.codes, **weights).predict
    return found


def _model(name: str, is_class: bool, seed: int) -> Any:
    from sklearn import discriminant_analysis, ensemble, linear_model  # only here: they take a while

    if name == "forest":
        forest = ensemble.RandomForestClassifier if is_class else ensemble.RandomForestRegressor
        return forest(FOREST_TREES, random_state=seed)
    if name == "boosting":
        boosting = ensemble.HistGradientBoostingClassifier if is_class else ensemble.HistGradientBoostingRegressor
        return boosting(early_stopping=False, random_state=seed)
    if name == "logistic":
        return _scaled(linear_model.LogisticRegression(max_iter=MOST_ITERATIONS))
    return _scaled(
        discriminant_analysis.LinearDiscriminantAnalysis()
        if name == "discriminant"
        else linear_model.LinearRegression()
    )


def _scaled(model: Any) -> Any:
    from sklearn.impute import SimpleImputer
    from sklearn.pipeline import Pipeline
    from sklearn.preprocessing import StandardScaler

    steps = [("imputer", SimpleImputer(strategy="median", keep_empty_features=True)), ("scaler", StandardScaler())]
    return Pipeline([*steps, ("model", model)])


def _rounded(problem: Problem, seed: int) -> Predictor:
    values = np.array(problem.class_names, dtype=np.float64)
    line = _model("least squares", False, seed)
    line.fit(problem.features, values[problem.codes], model__sample_weight=problem.weights)

    def nearest(features: NDArray[np.float64]) -> NDArray[Any]:
        return np.asarray(np.abs(line.predict(features)[:, None] - values).argmin(axis=1))

    return nearest


def _pruned_cart(problem: Problem, seed: int) -> Predictor:
    by = (False, True) if problem.loss.predicts == "class" else (False,)
    families = [Family(MAX_DEPTH, "cart", by_impurity=by_impurity) for by_impurity in by]
    if problem.n_samples < 2:
        raise ProblemError(f"pruned CART needs folds; got {problem.n_samples} samples, expected 2 or more")
    folds, no_proof = min(5, problem.n_samples), Limits(seconds=0.0)  # nobody asks for a bound of a baseline
    choice = choose_tree(problem, families=families, folds=folds, limits=no_proof, seed=seed, n_jobs=1)
    return partial(predict if problem.loss.predicts == "class" else predict_values, choice.tree)
