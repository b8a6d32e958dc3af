"""Missing readings: where each split sends them, chosen in the optimum, and the same by all that reads a tree."""

import json

import numpy as np
import pytest

from octmip import HyperplaneSplit, Leaf, OptimalTreeClassifier, Problem, Split, predict, solve
from octmip.errors import CertificateError, TreeError
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Solution, Stop
from octmip.trees.encoding import rank_features, rows_from_tree, tree_from_rows
from octmip.trees.evidence.proof import check_proof, checker_question
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.nodes.reached import centred, without_empty_sides
from octmip.trees.nodes.tree import condition, goes_left, splits, with_sides_for_missing
from octmip.trees.question.problem_file import data_digest, encode, question_digest
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem, with_missing

NAN = float("nan")


def problem_with_missing(seed):
    """Return a small random problem, most of them with readings missing."""
    rng = np.random.default_rng([70, seed])
    return with_missing(rng, random_problem(rng))


def test_a_missing_reading_goes_to_the_side_that_the_split_names():
    features = np.array([[0.5], [NAN], [2.5], [3.5], [NAN]])
    assert goes_left(Split(0, 2.5, Leaf(0), Leaf(1), missing="left"), features).tolist() == [1, 1, 1, 0, 1]
    assert goes_left(Split(0, 2.5, Leaf(0), Leaf(1), missing="right"), features).tolist() == [1, 0, 1, 0, 0]
    assert goes_left(Split(0, None, Leaf(0), Leaf(1), missing="left"), features).tolist() == [0, 1, 0, 0, 1]
    assert goes_left(Split(0, None, Leaf(0), Leaf(1), missing="right"), features).tolist() == [1, 0, 1, 1, 0]


def test_a_hyperplane_that_lacks_one_of_its_readings_goes_to_its_side():
    features = np.array([[1.0, NAN], [NAN, NAN], [1.0, 1.0], [1.0, -1.0], [1e308, 1e308]])
    plane = HyperplaneSplit((0, 1), (1.0, 1.0), 1.0, Leaf(0), Leaf(1), missing="left")
    assert goes_left(plane, features).tolist() == [1, 1, 0, 1, 0]


def test_a_split_without_a_side_refuses_what_is_missing():
    features = np.array([[0.5], [NAN], [2.5], [NAN]])
    with pytest.raises(TreeError, match=r"row 1 lacks its reading of feature 0 \(NaN; 2 such rows.*takes_missing=True"):
        predict(Split(0, 1.0, Leaf(0), Leaf(1)), features)
    plane = HyperplaneSplit((0, 1), (1.0, 1.0), 1.0, Leaf(0), Leaf(1))
    with pytest.raises(TreeError, match=r"row 3 lacks its reading of one of the features \(0, 1\)"):
        predict(plane, np.hstack([np.nan_to_num(features, nan=1.0), features])[[0, 0, 0, 1]])


def test_a_split_is_said_with_its_side():
    def words(**given):
        return condition(Split(0, left=Leaf(0), right=Leaf(1), **given), "x{}".format)

    assert words(threshold=1.5, missing="left") == "x0 <= 1.5 or missing"
    assert words(threshold=1.5, missing="right") == words(threshold=1.5) == "x0 <= 1.5"
    assert words(threshold=None, missing="left") == "x0 is missing"
    assert words(threshold=None, missing="right") == "x0 is not missing"


def test_where_nothing_was_missing_the_heavier_side_takes_it():
    tree = Split(0, 1.5, Leaf(0), Split(1, 0.5, Leaf(0), Leaf(1), missing="left"))
    features = np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 1.0], [4.0, NAN]])
    sided = with_sides_for_missing(tree, features, np.array([3.0, 1.0, 1.0, 1.0]))
    assert [split.missing for split in splits(sided)] == ["left", "left"]
    sided = with_sides_for_missing(tree, features, np.array([2.0, 1.0, 1.0, 1.0]))
    assert [split.missing for split in splits(sided)] == ["right", "left"]


def test_complete_data_have_no_sides_unless_asked_for():
    features, labels = [[1.0], [2.0], [3.0]], [0, 1, 1]
    assert splits(solve(Problem(features, labels, depth=1)).tree)[0].missing is None
    assert splits(solve(Problem(features, labels, depth=1, takes_missing=True)).tree)[0].missing == "right"


@pytest.mark.parametrize("method", ["oct", "flow"])
def test_a_model_of_lacking_readings_keeps_to_the_features_that_splits_may_read(method):
    rows, labels = [[0, 0], [1, 1], [0, 1], [NAN, 0]], [0, 1, 1, 0]  # the second feature alone tells all
    problem = Problem(rows, labels, depth=1, takes_missing=True, allowed_splits=[[0]])
    assert solve(problem, method).objective == 1.0


def test_a_feature_that_is_missing_everywhere_has_no_cut():
    problem = Problem([[NAN, 0.0], [NAN, 1.0]], [0, 1], depth=2)
    assert solve(problem).tree == Split(1, 0.5, Leaf(0), Leaf(1), missing="left")
    assert isinstance(solve(Problem([[NAN], [NAN]], [0, 1], depth=2)).tree, Leaf)


def test_a_tree_goes_to_columns_and_back():
    for seed in range(40):
        problem = problem_with_missing(seed)
        ranks, tree = rank_features(problem), optimum(problem).tree
        tree = without_empty_sides(tree, problem.samples.features)
        back = tree_from_rows(rows_from_tree(tree, ranks), ranks)
        np.testing.assert_array_equal(predict(back, problem.samples.features), predict(tree, problem.samples.features))
        again = centred(back, problem.samples.features)
        np.testing.assert_array_equal(predict(again, problem.samples.features), predict(tree, problem.samples.features))


def test_extremes_of_float64_have_room_for_what_is_missing():
    most = np.finfo(np.float64).max
    problem = Problem([[-most], [most], [NAN], [0.0]], [0, 1, 2, 0], depth=2)
    assert solve(problem).objective == 0


def test_a_tree_without_a_side_where_some_are_missing_has_no_certificate():
    problem = Problem([[NAN], [1.0], [2.0]], [0, 0, 1], depth=1)
    claim = Solution(Split(0, 1.5, Leaf(0), Leaf(1)), 0.0, 0.0, Stop.OPTIMAL, 0.0, 0, "hand", "1", 0)
    with pytest.raises(CertificateError, match="no side for missing readings"):
        certify(problem, claim)


def test_a_log_belongs_to_its_missing_readings(tmp_path):
    problem, log = Problem([[NAN], [1.0], [2.0]], [0, 0, 1], depth=1), tmp_path / "proof.log"
    branch_and_bound(problem, options=ExactOptions(proof=log))
    with pytest.raises(CertificateError, match=r"line 1: got .octmip-proof 3 missing., expected .octmip-proof 3."):
        check_proof(problem.replace(features=np.nan_to_num(problem.samples.features)), log)
    moved = problem.replace(features=np.array([[1.0], [NAN], [2.0]]))
    with pytest.raises(CertificateError, match="line 2: got"):
        check_proof(moved, log)
    # The same data, but its first line says that none is missing.
    log.write_text(log.read_text().replace(" missing", "", 1))
    with pytest.raises(CertificateError, match="line 1"):
        check_proof(problem, log)


def test_a_problem_file_holds_null_for_what_is_missing_and_the_checker_knows_its_digests():
    problem = Problem([[NAN, 1.0], [0.0, 2.0]], [0, 1], depth=1)
    file = json.loads(json.dumps(encode(problem), allow_nan=False))
    assert file["features"] == [[None, 1.0], [0.0, 2.0]]
    assert file["version"] == 2
    assert encode(Problem([[1.0], [0.0]], [0, 1], depth=1, takes_missing=True))["version"] == 1
    assert checker_question(problem).digests() == (data_digest(problem), question_digest(problem))


def gapped(n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(8)
    features = rng.normal(size=(n, 3)).round(1)
    features[rng.random((n, 3)) < 0.3] = NAN
    return features, (np.nan_to_num(features[:, 0], nan=1.0) > 0.2).astype(int)


def test_the_estimator_takes_missing_readings_in_fit_and_in_predict():
    features, labels = gapped()
    features[:, 2] = 0.5  # complete in training, missing later
    model = OptimalTreeClassifier(max_depth=2).fit(features, labels)
    assert model.score(features, labels) == 1.0
    assert model.n_features_in_ == 3
    assert model.problem_.samples.feature_names == ("x0", "x1", "x2")
    assert model.predict(np.full((1, 3), NAN)).tolist() == [1]


def test_a_tree_with_sides_is_the_same_as_a_tree_of_scikit_learn():
    features, labels = gapped()
    features = np.where(np.isnan(features), NAN, features.astype(np.float32))
    for depth in (1, 2, 3):
        model = OptimalTreeClassifier(max_depth=depth).fit(features, labels)
        np.testing.assert_array_equal(model.to_sklearn().predict(features), model.predict(features))
    asks = OptimalTreeClassifier(max_depth=1).fit([[NAN], [1.0], [2.0]], [1, 0, 0])
    assert asks.to_sklearn().predict([[NAN], [1.5]]).tolist() == [1, 0]
