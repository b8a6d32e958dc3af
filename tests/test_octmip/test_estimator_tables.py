"""OptimalTreeClassifier on any table: text, categories, missing values, and what a column costs."""

import sys

import numpy as np
import pandas as pd
import pytest

from octmip import OptimalTreeClassifier, Problem, solve
from octmip.errors import DataError, MissingExtraError, ProblemError
from octmip.formats.columns import Columns


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
