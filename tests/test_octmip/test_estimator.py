"""OptimalTreeClassifier keeps scikit-learn's contract and says what was proven."""

import pickle

import numpy as np
import pandas as pd
import pytest
from sklearn.datasets import load_iris
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.estimator_checks import parametrize_with_checks

from octmip import predict
from octmip.errors import ProblemError
from octmip.estimator import OptimalTreeClassifier

IRIS = load_iris(return_X_y=True)


@parametrize_with_checks(
    [
        OptimalTreeClassifier(depth=2),
        OptimalTreeClassifier(depth=3, method="search"),
        OptimalTreeClassifier(depth=2, method="cart"),
        OptimalTreeClassifier(depth=2, split="hyperplane", split_size=2),
    ],
)
def test_it_passes_scikit_learns_own_checks(estimator, check):
    check(estimator)


def test_predictions_are_those_of_the_tree():
    features, labels = IRIS
    names = np.array(["setosa", "versicolor", "virginica"])[labels]
    fitted = OptimalTreeClassifier(depth=2, method="search").fit(features, names)
    assert (fitted.predict(features) == fitted.classes_[predict(fitted.tree_, features)]).all()
    assert (fitted.predict(features) != names).sum() == fitted.solution_.objective == 6
    assert fitted.bound_ == fitted.solution_.bound
    assert fitted.gap_ == fitted.solution_.gap


def test_shares_are_those_of_the_training_weight_in_the_leaf():
    fitted = OptimalTreeClassifier(depth=1, method="cart").fit([[0], [0], [1], [1]], [0, 0, 0, 1], [1, 1, 1, 3])
    assert fitted.predict_proba([[0], [1]]).tolist() == [[1, 0], [0.25, 0.75]]


def test_a_weight_of_zero_leaves_a_sample_out():
    features, labels = [[0.0], [1.0], [2.0], [9.0]], [0, 0, 1, 1]
    left_out = OptimalTreeClassifier(depth=1, method="cart").fit(features, labels, [1, 1, 0, 1])
    assert left_out.tree_.threshold == 5.0


def test_costs_weigh_the_errors():
    features, labels = [[0.0], [0.0], [0.0], [1.0]], ["a", "a", "b", "b"]
    for costs, told in ((None, "a"), ([[0, 1], [5, 0]], "b")):
        assert OptimalTreeClassifier(depth=1, method="cart", costs=costs).fit(features, labels).predict([[0]]) == [told]


def test_names_of_a_data_frame_are_the_names_of_the_features():
    frame = pd.DataFrame(IRIS[0], columns=list("abcd"))
    fitted = OptimalTreeClassifier(depth=2, method="cart").fit(frame, IRIS[1])
    assert list(fitted.feature_names_in_) == list("abcd")
    with pytest.raises(ValueError, match="feature names"):
        fitted.predict(frame.rename(columns={"a": "z"}))


def test_it_works_in_pipelines_and_grid_search():
    search = GridSearchCV(
        make_pipeline(StandardScaler(), OptimalTreeClassifier(method="cart")),
        {"optimaltreeclassifier__depth": [1, 3]},
        cv=3,
    ).fit(*IRIS)
    assert search.best_params_ == {"optimaltreeclassifier__depth": 3}
    assert search.best_score_ > 0.9


def test_it_can_be_pickled():
    fitted = OptimalTreeClassifier(depth=2, method="cart").fit(*IRIS)
    again = pickle.loads(pickle.dumps(fitted))
    assert again.tree_ == fitted.tree_
    assert (again.predict(IRIS[0]) == fitted.predict(IRIS[0])).all()


def test_what_is_not_fitted_says_so():
    for ask in (lambda e: e.predict(IRIS[0]), lambda e: e.predict_proba(IRIS[0]), lambda e: e.gap_):
        with pytest.raises(NotFittedError):
            ask(OptimalTreeClassifier())


def test_a_wrong_parameter_is_refused_when_fitting():
    with pytest.raises(ProblemError, match="depth is 0"):
        OptimalTreeClassifier(depth=0).fit(*IRIS)
