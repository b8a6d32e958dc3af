"""What docs/howto/conventions.md says of other programs for trees, seen on inputs of a few rows."""

import numpy as np
import pandas as pd
import pytest
from sklearn.tree import DecisionTreeClassifier

from octmip import OptimalTreeClassifier

UNITS = (1.0, 1e-3, 1e-9)


def contree():
    return pytest.importorskip("pycontree").ConTree(max_depth=1)


def streed(task: str = "accuracy", **more: object):
    return pytest.importorskip("pystreed").STreeDClassifier(task, **{"max_depth": 1} | more)


def errors(model, features, labels) -> int:
    return int((np.asarray(model.fit(features, labels).predict(features)) != labels).sum())


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("peer", [DecisionTreeClassifier, contree])
def test_two_peers_merge_values_less_than_1e_7_apart_at_any_scale_and_octmip_does_not(peer, unit):
    features, labels = unit + np.array([[0.0], [0.0], [4e-8], [4e-8]]), np.array([0, 0, 1, 1])
    assert errors(peer(), features, labels) == 2
    assert errors(peer(), 1e4 * (features - unit), labels) == 0
    assert errors(OptimalTreeClassifier(max_depth=1), features, labels) == 0


@pytest.mark.parametrize("peer", [contree, streed])
def test_two_peers_cut_fractional_classes_to_whole_numbers_in_silence(peer):
    model = peer()
    model.fit(np.array([[0.0], [1.0], [2.0], [3.0]]), np.array([0.2, 0.7, 1.2, 1.9]))
    assert np.asarray(model.predict(np.array([[0.0], [3.0]]))).tolist() == [0, 1]


def test_the_texts_that_streed_asks_about_are_those_it_meets_first():
    texts = pd.DataFrame({"t": np.repeat(list("abcdefgh"), 4)})
    labels = np.isin(texts["t"], ["g", "h"]).astype(int)
    backwards = np.arange(32)[::-1]
    assert errors(streed(max_depth=2), texts, labels) == 8
    assert errors(streed(max_depth=2), texts.iloc[backwards], labels[backwards]) == 0


def test_streed_takes_numbers_and_has_balanced_accuracy():
    assert errors(streed("balanced-accuracy"), np.array([[0.5], [1.5], [2.5], [3.5]]), np.array([0, 0, 1, 1])) == 0


def test_the_regressor_of_streed_misses_an_optimum_under_its_default_bound_alone():
    rows = ["111", "011", "101", "110", "000", "110", "111", "011", "100", "010"]
    features, targets = np.array([list(row) for row in rows], dtype=float), np.array([0, 3, 3, 0, 1, 3, 2, 2, 3, 3.0])
    paid = {}
    for bound in ("kmeans", "equivalent"):
        peer = pytest.importorskip("pystreed").STreeDRegressor(max_depth=3, regression_lower_bound=bound)
        left = ((np.asarray(peer.fit(features, targets).predict(features)) - targets) ** 2).sum()
        paid[bound] = left / ((targets - targets.mean()) ** 2).sum() + 0.01 * (peer.get_n_leaves() - 1)
    assert paid == {"kmeans": pytest.approx(0.5598, abs=1e-4), "equivalent": pytest.approx(0.55)}


def test_scikit_learn_sends_missing_values_to_the_side_of_more_rows_whatever_their_weight():
    model = DecisionTreeClassifier(max_depth=1)
    model.fit([[0.0]] * 3 + [[1.0]] * 2, [0, 0, 0, 1, 1], sample_weight=[1, 1, 1, 100, 100])
    assert model.predict([[np.nan]]).tolist() == [0]
