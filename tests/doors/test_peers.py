"""What docs/howto/conventions.md says of other programs for trees, seen on inputs of a few rows."""

import inspect

import numpy as np
import pandas as pd
import pytest
from scipy.sparse import csr_array
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


@pytest.mark.parametrize(("text", "n_errors"), [("d", 0), ("e", 4)])
def test_streed_asks_about_the_four_texts_that_it_meets_first(text, n_errors):
    texts = pd.DataFrame({"t": np.repeat(list("abcdefgh"), 4)})
    labels = (texts["t"] == text).to_numpy(dtype=int)
    assert errors(streed(), texts, labels) == n_errors
    assert errors(streed(), texts.iloc[::-1], labels[::-1]) == 4 - n_errors


def test_two_peers_take_no_level_and_streed_counts_splits():
    for peer in (contree(), streed()):
        assert errors(peer.set_params(max_depth=0), ROWS, np.array([0, 0, 0, 1])) == 1
    for n_splits, n_errors in ((1, 1), (2, 0)):
        assert errors(streed(max_depth=2, max_num_nodes=n_splits), ROWS, np.array([0, 1, 1, 0])) == n_errors


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


def parameters(of: type) -> dict[str, object]:
    return {name: one.default for name, one in inspect.signature(of).parameters.items()}


def test_the_peers_have_the_parameters_that_the_page_names():
    greedy, peer, other = parameters(DecisionTreeClassifier), parameters(type(contree())), parameters(type(streed()))
    ours = parameters(OptimalTreeClassifier)
    assert (ours["max_depth"], ours["seconds"], greedy["max_depth"]) == ("auto", 60.0, None)
    assert {"min_samples_leaf", "min_weight_fraction_leaf", "max_leaf_nodes", "monotonic_cst", "ccp_alpha"} < set(
        greedy
    )
    assert (peer["max_depth"], peer["time_limit"]) == (other["max_depth"], other["time_limit"]) == (3, 600)
    assert {"complexity_cost", "max_gap"} < set(peer)
    assert {"min_leaf_node_size", "max_num_nodes", "cost_complexity"} < set(other)
    assert parameters(pytest.importorskip("pystreed").STreeDCostSensitiveClassifier)


ROWS = np.array([[0.0], [1.0], [2.0], [3.0]])
INPUTS = {
    "missing": (np.where(ROWS == 1.0, np.nan, ROWS), "octmip scikit-learn"),
    "infinite": (np.where(ROWS == 1.0, np.inf, ROWS), ""),
    "texts": (pd.DataFrame({"t": list("aabb")}), "octmip pystreed"),
    "sparse": (csr_array(ROWS), "scikit-learn"),
    "21 levels": (ROWS, "octmip scikit-learn"),
}


@pytest.mark.parametrize("name", INPUTS)
def test_the_four_take_and_refuse_the_inputs_that_the_page_says(name):
    depth = 21 if name == "21 levels" else 1
    models = {
        "octmip": OptimalTreeClassifier(max_depth=depth),
        "scikit-learn": DecisionTreeClassifier(max_depth=depth),
        "pycontree": contree().set_params(max_depth=depth),
        "pystreed": streed().set_params(max_depth=depth),
    }
    given, takers = INPUTS[name]
    for peer, model in models.items():
        if peer in takers:
            assert errors(model, given, np.array([0, 0, 1, 1])) == 0
        else:
            with pytest.raises((ValueError, TypeError)):
                model.fit(given, np.array([0, 0, 1, 1]))


@pytest.mark.parametrize("peer", [contree, streed])
def test_shares_of_two_peers_need_classes_from_0_and_only_streed_says_whether_it_proved(peer):
    model = peer().fit(ROWS, np.array([0, 0, 1, 1]))
    assert model.predict_proba(ROWS)[:, 1].tolist() == [0, 0, 1, 1]
    assert hasattr(model, "fit_result") == (peer is streed)
    assert peer is contree or model.fit_result.is_optimal()
    with pytest.raises(IndexError):
        peer().fit(ROWS, np.array([2, 2, 5, 5])).predict_proba(ROWS)


def test_balanced_weights_of_scikit_learn_count_rows_and_those_of_octmip_weights():
    same, labels, weights = np.zeros((4, 1)), np.array([0, 0, 0, 1]), np.array([1, 1, 1, 3])
    words = {"max_depth": 1, "class_weight": "balanced"}
    greedy = DecisionTreeClassifier(**words).fit(same, labels, sample_weight=weights)
    ours = OptimalTreeClassifier(**words, smoothing=0).fit(same, labels, sample_weight=weights)
    assert greedy.predict_proba(same[:1]).tolist() == [[0.25, 0.75]]
    assert ours.predict_proba(same[:1]).tolist() == [[0.5, 0.5]]


def test_weight_2_is_two_samples_but_counts_as_one_row_of_a_leaf():
    features, labels, weights = [[0.0], [1.0], [2.0]], [0, 1, 1], [2, 1, 1]
    one = OptimalTreeClassifier(1, min_samples_leaf=2).fit(features, labels, sample_weight=weights)
    two = OptimalTreeClassifier(1, min_samples_leaf=2).fit([[0.0], *features], [0, *labels])
    assert (one.objective_, two.objective_) == (2.0, 0.0)
    assert OptimalTreeClassifier(1).fit(features, labels, sample_weight=weights).objective_ == 0.0


def test_scikit_learn_compares_readings_in_float32_and_octmip_as_they_are():
    reading = np.array([[0.15]])
    greedy, ours = (model.fit([[0.1], [0.2]], [0, 1]) for model in (DecisionTreeClassifier(), OptimalTreeClassifier(1)))
    assert greedy.tree_.threshold[0] > 0.15
    assert greedy.predict(reading).tolist() == [1]
    assert ours.predict(reading).tolist() == [int(ours.tree_.threshold < 0.15)]
