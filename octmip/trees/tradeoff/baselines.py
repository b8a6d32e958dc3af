"""Baselines: the models that people try beside a tree, trained on the samples of a problem.

| model | what it is | missing readings |
|---|---|---|
| linear | logistic regression of scaled columns; of numbers, least squares | median |
| discriminant | linear discriminant analysis, which takes no weights | median |
| rounded | least squares to classes that are numbers, rounded to the nearest class | median |
| pruned CART | CART of any depth, its pruning chosen by five folds (`choose_tree`) | a side of each split |
| forest | random forest of 200 trees | a side of each split |
| boosting | gradient boosting of 100 trees on histograms | a side of each split |

All but pruned CART are scikit-learn's and minimise their own loss, not the costs of the problem. They read columns and
numbers that are centred and scaled, whatever their units (`Centred`, `unit_sized`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Limits
from octmip.trees.methods.cart import unit_sized
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import MAX_DEPTH
from octmip.trees.tradeoff.choice import choose_tree
from octmip.trees.tradeoff.family import Family
from octmip.trees.tradeoff.held_out import Predictor, predictor_of

FOREST_TREES = 200
MOST_ITERATIONS = 2000
"""Of logistic regression."""
CLOSE = 1e-6
"""Values of a column nearer to each other than this share of its range are ranks to a forest."""


def baselines_of(problem: Problem) -> Mapping[str, Callable[[int], Predictor]]:
    """Return by its name each baseline that a problem can have: a function that trains it for a seed.

    Training raises a ProblemError where the samples are too few for the folds of pruned CART.
    """
    is_class = problem.loss.predicts == "class"
    found = {"linear": partial(_fitted, problem, "logistic" if is_class else "least squares")}
    if is_class and (problem.samples.weights == problem.samples.weights[0]).all():
        found["discriminant"] = partial(_fitted, problem, "discriminant")
    if is_class and all(isinstance(name, int | float | np.number) for name in problem.samples.class_names):
        found["rounded"] = partial(_rounded, problem)
    found["pruned CART"] = partial(_pruned_cart, problem)
    return found | {name: partial(_fitted, problem, name) for name in ("forest", "boosting")}


def _fitted(problem: Problem, name: str, seed: int, targets: NDArray[Any] | None = None) -> Predictor:
    """Return a model of scikit-learn trained on centred columns, for the problem's targets or others (n_samples,)."""
    samples = problem.samples
    columns = Centred.of(samples.features, has_ranks=name in ("forest", "boosting"))
    is_class = problem.loss.predicts == "class" and targets is None
    model = _model(name, is_class, seed)
    weights = {} if name == "discriminant" else {"model__sample_weight": samples.weights}
    if is_class:
        model.fit(columns(samples.features), samples.codes, **weights)
        found = np.eye(samples.n_classes)[model.classes_]  # a class without samples has the share 0
        return Predictor(
            lambda features: np.asarray(model.predict(columns(features))),
            lambda features: (np.arange(len(features)), model.predict_proba(columns(features)) @ found),
        )
    numbers, centre, exponent = unit_sized(samples.codes if targets is None else targets)
    model.fit(columns(samples.features), numbers, **weights)
    return Predictor(lambda features: np.asarray(np.ldexp(model.predict(columns(features)), exponent) + centre))


def _model(name: str, is_class: bool, seed: int) -> Any:
    from sklearn import discriminant_analysis, ensemble, linear_model  # only here: they take a while
    from sklearn.impute import SimpleImputer
    from sklearn.pipeline import Pipeline
    from sklearn.preprocessing import StandardScaler

    if name == "forest":
        forest = ensemble.RandomForestClassifier if is_class else ensemble.RandomForestRegressor
        return Pipeline([("model", forest(FOREST_TREES, random_state=seed))])
    if name == "boosting":
        boosting = ensemble.HistGradientBoostingClassifier if is_class else ensemble.HistGradientBoostingRegressor
        return Pipeline([("model", boosting(early_stopping=False, random_state=seed))])
    model = {
        "logistic": partial(linear_model.LogisticRegression, max_iter=MOST_ITERATIONS),
        "discriminant": discriminant_analysis.LinearDiscriminantAnalysis,
        "least squares": linear_model.LinearRegression,
    }[name]()
    steps = [("imputer", SimpleImputer(strategy="median", keep_empty_features=True)), ("scaler", StandardScaler())]
    return Pipeline([*steps, ("model", model)])


@dataclass(frozen=True, slots=True, eq=False)
class Centred:
    """Columns from -1 to 1 around their medians, as scikit-learn's models need them; missing readings stay.

    A forest reads float32 and takes values that differ by less than 1e-7 for one; where a column holds values so close
    beside its range, it gets their ranks, and what lies between two values lies between their ranks.

    Attributes
    ----------
    columns
        of each column its median, its range on the wider side of it, and its values where they become ranks.
    """

    columns: tuple[tuple[float, float, NDArray[np.float64] | None], ...]

    @classmethod
    def of(cls, features: NDArray[np.float64], *, has_ranks: bool) -> Self:
        """Return the columns of features (n, n_features), with ranks where they are needed and allowed."""
        found = []
        for column in features.T:
            values = np.unique(column[~np.isnan(column)]).astype(np.float64)
            centre = float(values[len(values) // 2]) if len(values) else 0.0
            span = float(np.abs(values / 2 - centre / 2).max(initial=0.0)) or 1.0
            is_close = bool((np.diff((values / 2 - centre / 2) / span) < CLOSE).any())
            found.append((centre, span, values if is_close and has_ranks else None))
        return cls(tuple(found))

    def __call__(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return features (n, n_features) as the models read them."""
        made = np.empty(features.shape)
        for column, (centre, span, values), to in zip(features.T, self.columns, made.T, strict=True):
            to[:] = (column.astype(np.float64) / 2 - centre / 2) / span
            if values is not None:
                to[:] = np.where(np.isnan(column), np.nan, np.interp(column, values, np.arange(len(values))))
        return made


def _rounded(problem: Problem, seed: int) -> Predictor:
    values = np.array(problem.samples.class_names, dtype=np.float64)
    line = _fitted(problem, "least squares", seed, values[problem.samples.codes])
    return Predictor(lambda features: np.asarray(np.abs(line(features)[:, None] - values).argmin(axis=1)))


def _pruned_cart(problem: Problem, seed: int) -> Predictor:
    by = (False, True) if problem.loss.predicts == "class" else (False,)
    families = [Family(MAX_DEPTH, "cart", by_impurity=by_impurity) for by_impurity in by]
    if problem.samples.n_samples < 2:
        raise ProblemError(f"pruned CART needs folds; got {problem.samples.n_samples} samples, expected 2 or more")
    folds, no_proof = min(5, problem.samples.n_samples), Limits(seconds=0.0)  # nobody asks for a bound of a baseline
    tree = choose_tree(problem, families=families, folds=folds, limits=no_proof, seed=seed, n_jobs=1).tree
    return predictor_of(problem, tree)
