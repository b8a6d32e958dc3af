"""scikit-learn cuts a table into folds and draws: an estimator answers all, as a pipeline that fills in does."""

import itertools
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from sklearn.base import clone
from sklearn.calibration import CalibratedClassifierCV
from sklearn.compose import make_column_selector, make_column_transformer
from sklearn.ensemble import BaggingClassifier, VotingClassifier
from sklearn.experimental import enable_halving_search_cv  # noqa: F401 scikit-learn asks for it
from sklearn.impute import SimpleImputer
from sklearn.inspection import permutation_importance
from sklearn.model_selection import (
    GridSearchCV,
    HalvingGridSearchCV,
    cross_val_predict,
    cross_val_score,
    learning_curve,
)
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import OneHotEncoder
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor

from octmip import OptimalTreeClassifier, OptimalTreeRegressor

N_ROWS = 60


def table(case: str) -> pd.DataFrame:
    """Return numbers, and a column of a kind whose cells are missing, or whose values lie, in few rows."""
    rng = np.random.default_rng(3)
    frame = pd.DataFrame(rng.normal(size=(N_ROWS, 2)), columns=["a", "b"])
    words = pd.Series(rng.choice(["u", "v"], N_ROWS), dtype=object)
    truths = pd.Series(rng.random(N_ROWS) < 0.5)
    one, few = np.arange(N_ROWS) != 7, np.isin(np.arange(N_ROWS), [10, 11, 12])
    columns: dict[str, Any] = {
        "one number": frame["b"].where(one),
        "few numbers": frame["b"].where(few),
        "one text": words.where(one, None),
        "few texts": words.where(few, None),
        "a level of one row": words.where(one, "once"),
        "True, False and None": truths.astype(object).where(one, None),
        "boolean and NA": truths.astype("boolean").where(one),
        "Int64 and NA": pd.Series(rng.integers(0, 5, N_ROWS)).astype("Int64").where(one),
        "string and NA": words.astype("string").where(one),
        "an ordered category": words.where(one, None).astype(pd.CategoricalDtype(["u", "v"], ordered=True)),
        "texts that seldom repeat": pd.Series([f"n{k}" for k in rng.integers(0, 35, N_ROWS)]),
        "dates and NaT": pd.Series(pd.date_range("2024-03-01", periods=N_ROWS)).where(one),
    }
    return frame.assign(x=columns[case])


CASES = {
    "one number", "few numbers", "one text", "few texts", "a level of one row", "True, False and None",
    "boolean and NA", "Int64 and NA", "string and NA", "an ordered category",
    "texts that seldom repeat", "dates and NaT",
}  # fmt: skip


def targets(frame: pd.DataFrame, predicts: str) -> NDArray[Any]:
    return np.where(frame["a"] > 0.3, "p", "q") if predicts == "class" else frame["a"].to_numpy() ** 2


def filled_in(frame: pd.DataFrame, predicts: str) -> Any:
    """Return scikit-learn's own way with such a table."""
    tree = DecisionTreeClassifier if predicts == "class" else DecisionTreeRegressor
    is_number = make_column_selector(dtype_include="float64")
    questions = OneHotEncoder(handle_unknown="ignore", sparse_output=False)
    steps = make_column_transformer((SimpleImputer(), is_number), (questions, ["x"]))
    return make_pipeline(steps if frame["x"].dtype != np.float64 else SimpleImputer(), tree(random_state=0))


@pytest.mark.parametrize(
    ("case", "predicts"), [*zip(sorted(CASES), itertools.cycle(["class", "number"]), strict=False)]
)
def test_a_search_over_folds_has_as_many_finite_scores_as_a_pipeline_that_fills_in(case: str, predicts: str) -> None:
    frame, kind = table(case), OptimalTreeClassifier if predicts == "class" else OptimalTreeRegressor
    wanted, plain = targets(frame, predicts), frame["x"].astype(object)
    beside = frame if case != "string and NA" else frame.assign(x=plain.where(plain.notna(), None))  # it takes no NA
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the pipeline: a column without values
        scores = cross_val_score(filled_in(beside, predicts), beside, wanted, cv=3)
    found = GridSearchCV(kind(method="cart"), {"max_depth": [1, 2]}, cv=3).fit(frame, wanted).cv_results_
    assert np.isfinite(scores).all()
    assert all(np.isfinite(found[f"split{fold}_test_score"]).all() for fold in range(3))


Ask = Callable[[Any, pd.DataFrame, NDArray[Any]], Any]
ASKED: dict[str, Ask] = {
    "cross_val_score": lambda tree, X, y: cross_val_score(tree, X, y, cv=3, error_score="raise"),
    "cross_val_predict": lambda tree, X, y: cross_val_predict(tree, X, y, cv=3, method="predict_proba"),
    "halving": lambda tree, X, y: (
        HalvingGridSearchCV(tree, {"max_depth": [1, 2]}, cv=3, random_state=0).fit(X, y).best_score_
    ),
    "learning_curve": lambda tree, X, y: learning_curve(tree, X, y, train_sizes=[0.3, 1.0], cv=3, error_score="raise")[
        2
    ],
    "calibrated": lambda tree, X, y: CalibratedClassifierCV(tree, cv=3).fit(X, y).predict_proba(X),
    "permutation": lambda tree, X, y: permutation_importance(clone(tree).fit(X, y), X, y, n_repeats=2).importances,
    "voting": lambda tree, X, y: cross_val_score(VotingClassifier([("a", tree), ("b", clone(tree))]), X, y, cv=3),
    "bagging": lambda tree, X, y: cross_val_score(BaggingClassifier(tree, n_estimators=2, random_state=0), X, y, cv=3),
}


@pytest.mark.parametrize("asked", sorted(ASKED))
@pytest.mark.parametrize("case", ["few numbers", "one text"])
def test_whatever_draws_rows_gets_finite_numbers(asked: str, case: str) -> None:
    frame = table(case)
    tree = OptimalTreeClassifier(max_depth=1, method="cart", smoothing=1.0)
    assert np.isfinite(np.asarray(ASKED[asked](tree, frame, targets(frame, "class")), dtype=np.float64)).all()


@pytest.mark.parametrize("output", ["default", "pandas"])
def test_a_pipeline_hands_its_columns_on(output: str) -> None:
    frame = table("few numbers")
    steps = make_column_transformer(("passthrough", ["a", "x"])).set_output(transform=output)
    tree = OptimalTreeClassifier(max_depth=1)
    assert np.isfinite(cross_val_score(make_pipeline(steps, tree), frame, targets(frame, "class"))).all()


def test_a_cell_that_only_predict_lacks_goes_to_the_side_of_more_weight() -> None:
    X, y = np.array([[1.0], [2.0], [3.0]]), ["p", "q", "q"]
    for weights, side in (([1, 1, 1], "q"), ([3, 1, 1], "p")):
        tree = OptimalTreeClassifier(max_depth=1).fit(X, y, weights)
        assert tree.predict([[np.nan]]) == [side]
        assert tree.apply([[np.nan]]) == tree.apply([[1.0 if side == "p" else 3.0]])
        assert tree.predict_proba([[np.nan]]).tolist() == tree.predict_proba([[1.0 if side == "p" else 3.0]]).tolist()
        words = OptimalTreeClassifier(max_depth=1).fit(pd.DataFrame({"x": ["u", "v", "v"]}), y, weights)
        assert words.predict(pd.DataFrame({"x": [None]})) == [side]
        number = OptimalTreeRegressor(max_depth=1).fit(X, [0.0, 1.0, 1.0], weights)
        assert number.predict([[np.nan]]) == [float(side == "q")]
