"""OptimalTreeRegressor behind scikit-learn's contract."""

import numpy as np
import pandas as pd
import pytest
from sklearn.exceptions import ConvergenceWarning
from sklearn.model_selection import cross_val_score

from octmip import OptimalTreeRegressor, QuantileError, SearchOptions, certify
from octmip.errors import ProblemError


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
