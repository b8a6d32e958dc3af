"""OptimalTreeRegressor behind scikit-learn's contract."""

import sys

import numpy as np
import pandas as pd
import pytest
from sklearn.exceptions import ConvergenceWarning
from sklearn.model_selection import cross_val_score

from octmip import OptimalTreeClassifier, OptimalTreeRegressor, Problem, QuantileError, SearchOptions, certify, solve
from octmip.errors import DataError, MissingExtraError, ProblemError
from octmip.formats.columns import Columns


def samples(n=80):
    rng = np.random.default_rng(0)
    X = rng.normal(size=(n, 3))
    return X, np.where(X[:, 0] > 0, 3.0, X[:, 1] > 0.5) + rng.normal(size=n) / 10


def test_it_predicts_by_its_tree_and_says_what_is_proven():
    X, y = samples()
    fitted = OptimalTreeRegressor(max_depth=2).fit(X, y)
    assert fitted.is_optimal_
    assert fitted.gap_ == 0
    assert fitted.bound_ <= fitted.objective_ == certify(fitted.problem_, fitted.solution_).objective
    assert ((fitted.predict(X) - y) ** 2).sum() == pytest.approx(fitted.objective_)
    assert fitted.get_n_leaves() == len(np.unique(fitted.apply(X))) == 4
    assert fitted.get_depth() == 2
    assert fitted.decision_path(X).shape == (80, 7)
    assert fitted.export_text().startswith("if x0 <= ")
    assert cross_val_score(OptimalTreeRegressor(max_depth=2), X, y, cv=3).min() > 0.8


def test_a_high_quantile_lies_above_nine_tenths_of_the_targets_of_every_leaf():
    X, y = samples(200)
    fitted = OptimalTreeRegressor(max_depth=2, loss=QuantileError(0.9)).fit(X, y)
    assert fitted.is_optimal_
    assert fitted.certificate_.measures["covered"] == (y <= fitted.predict(X)).mean()
    for leaf in np.unique(fitted.apply(X)):
        own = y[fitted.apply(X) == leaf]
        assert (own <= fitted.predict(X)[fitted.apply(X) == leaf]).mean() >= 0.9
        assert (own < fitted.predict(X)[fitted.apply(X) == leaf]).mean() <= 0.9


def test_a_proof_that_ends_early_warns_and_words_are_refused():
    X, y = samples()
    with pytest.warns(ConvergenceWarning, match="the proof ended"):
        OptimalTreeRegressor(max_depth=3, seconds=0).fit(X, y)
    with pytest.raises(ProblemError, match="y cannot be read as numbers"):
        OptimalTreeRegressor().fit(X, np.where(y > 1, "a", "b"))


def test_a_regressor_has_the_picture_page_and_importances_that_a_classifier_has(tmp_path):
    rng = np.random.default_rng(8)
    X = pd.DataFrame(rng.normal(size=(80, 3)), columns=["area", "age", "noise"])
    y = pd.Series(10 * (X["area"] > 0) + 3 * (X["age"] > 0), name="price")
    found = OptimalTreeRegressor(max_depth=2, options=SearchOptions(restarts=2), method="search").fit(X, y)
    saved = found.feature_importances_
    assert saved.sum() == pytest.approx(1.0)
    assert saved.argmax() == 0
    assert saved[2] == 0
    found.report(tmp_path / "page.html", X[:20], y[:20], seconds=0.5)
    page = (tmp_path / "page.html").read_text()
    assert "A decision tree for price" in page
    assert "measured on 20 samples" in page
    assert 'aria-label="the fitted tree"' in found._repr_html_()
    assert found.plot().axes
    assert "samples)" in found.export_text()


@pytest.mark.parametrize("kind", ["timedelta64[s]", "timedelta64[ns]", "datetime64[D]"])
def test_targets_whose_numbers_depend_on_a_unit_of_time_are_refused(kind):
    with pytest.raises(ProblemError, match=r"y holds values of type .*64\[.*expected numbers"):
        OptimalTreeRegressor(max_depth=1).fit([[0.0], [1.0], [2.0]], np.arange(3).astype(kind))


# OptimalTreeClassifier on any table: text, categories, missing values, and what a column costs


def table(n=60, seed=0):
    rng = np.random.default_rng(seed)
    frame = pd.DataFrame(
        {
            "age": rng.integers(18, 80, n).astype(float),
            "colour": rng.choice(["red", "green", "blue"], n),
            "size": pd.Categorical(rng.choice(list("SML"), n), categories=list("SML"), ordered=True),
            "member": rng.random(n) < 0.5,
        }
    )
    frame.loc[rng.random(n) < 0.2, "age"] = np.nan
    frame.loc[rng.random(n) < 0.1, "colour"] = None
    return frame, np.where((frame["age"].fillna(70) > 50) & (frame["colour"] != "red"), "yes", "no")


FRAME, LABELS = table()


def fitted(X=FRAME, y=LABELS, **settings):
    return OptimalTreeClassifier(**{"max_depth": 2} | settings).fit(X, y)


def test_a_table_is_encoded_as_columns_encodes_it():
    model, columns = fitted(), Columns.learn(FRAME)
    problem = Problem(columns.encode(FRAME), LABELS, depth=2, feature_names=columns.feature_names)
    assert model.tree_ == solve(problem).tree
    assert model.columns_ == columns
    assert model.is_optimal_
    assert model.score(FRAME, LABELS) == 1
    assert list(model.feature_names_in_) == list(FRAME.columns)
    assert model.n_features_in_ == 4 < model.problem_.samples.n_features


def test_a_value_missing_only_later_is_refused_with_a_cure():
    model = fitted(FRAME[["size"]].assign(age=FRAME["age"].fillna(0)), takes_missing=False)
    with pytest.raises(DataError, match=r"'age' has .* missing cells, and had none in training; fill in"):
        model.predict(FRAME[["size", "age"]])
    with pytest.raises(DataError, match="'x0' has 1 missing cell"):
        fitted([[0.0], [1.0]], [0, 1], takes_missing=False).predict([[np.nan]])


@pytest.mark.parametrize(
    ("X", "settings", "message"),
    [
        (FRAME, {"missing": "refuse"}, r"2 of 4 columns cannot be used: 'age' .*'colour'"),
        (FRAME, {"split": "hyperplane"}, "cells are missing in 'age'; a hyperplane adds"),
        ([[np.nan]] * 60, {"split": "hyperplane"}, r"X is NaN at \[0, 0\] \(60 missing values in all\)"),
        ([[1.0], [np.nan]] * 30, {"missing": "refuse"}, r"X is NaN at \[1, 0\].* missing='either-side'"),
        ([[1j], [2.0]] * 30, {}, "Complex data not supported"),
    ],
)
def test_what_cannot_be_read_is_refused(X, settings, message):
    with pytest.raises(ValueError, match=message):
        fitted(X, **settings)


def test_a_column_that_is_read_twice_costs_once():
    frame = pd.DataFrame({"colour": list("abcd") * 6, "dose": np.arange(24.0) % 5})
    labels = frame["colour"].isin(["a", "c"]).astype(int)
    model = fitted(frame, labels, sensor_cost={"colour": 3.0, "dose": 1.0}, sensor_budget=3.0)
    assert model.objective_ == 0
    assert model.get_n_leaves() == 3
    assert model.sensors_ == ("colour",)
    assert model.certificate_.sensor_cost == 3
    assert model.feature_importances_.tolist() == [1.0, 0.0]


def test_columns_may_share_a_sensor():
    by_name = fitted(sensor_of_feature={"age": "form", "colour": "form"}, sensor_budget=1.0)
    assert by_name.objective_ == 0
    assert by_name.sensors_ == ("form",)
    assert by_name.problem_.shape.sensors == ("form", "size", "member")
    in_order = fitted(sensor_of_feature=["form", "form", "size", "member"], sensor_budget=1.0)
    assert in_order.problem_.shape.sensor_of_feature == by_name.problem_.shape.sensor_of_feature
    assert fitted(sensor_budget=1.0).objective_ > 0
    with pytest.raises(ProblemError, match=r"sensor_of_feature names \['height'\], no columns of X"):
        fitted(sensor_of_feature={"height": "form"})
    with pytest.raises(ProblemError, match="2 entries but there are 4 columns of X"):
        fitted(sensor_of_feature=["a", "b"])


def test_a_table_of_another_package_without_pyarrow_names_the_extra(monkeypatch):
    polars = pytest.importorskip("polars")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match="a DataFrame as samples needs the package pyarrow"):
        OptimalTreeClassifier(max_depth=1).fit(polars.DataFrame({"a": [0.0, 1.0]}), [0, 1])
