"""The tree of a fitted OptimalTreeClassifier: its nodes, importances, words, pictures, and scikit-learn's own form."""

import pickle
from html import escape
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from sklearn.datasets import load_iris
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeClassifier

from octmip import HyperplaneSplit, Leaf, OptimalTreeClassifier, Problem, Split
from octmip.errors import DataError, TreeError
from octmip.interfaces.estimator import drawing
from octmip.interfaces.estimator.importance import feature_savings
from octmip.interfaces.estimator.paths import NodeTable, leaf_nodes, node_indicator

IRIS = load_iris(return_X_y=True)
FRAME = pd.DataFrame({"dose": [1.0, np.nan, 4.0, 3.0], "<b>kind</b>": ["a", "b", "a", "c"]})
ANSWERS = ["yes", "no", "yes", "no"]
UNEVEN = Split(0, 0.5, Leaf(0), Split(1, 0.5, Split(0, 2.5, Leaf(1), Leaf(0)), Leaf(1)))


@pytest.fixture(scope="module")
def iris():
    return OptimalTreeClassifier(max_depth=3, smoothing=2.0).fit(
        load_iris(as_frame=True).data, IRIS[1], np.random.default_rng(0).integers(1, 4, 150)
    )


@pytest.fixture(scope="module")
def encoded():
    return OptimalTreeClassifier(max_depth=2).fit(FRAME, pd.Series(ANSWERS, name="animal"))


def test_nodes_are_numbered_in_preorder():
    table = NodeTable.of(UNEVEN)
    assert table.left.tolist() == [1, -1, 3, 4, -1, -1, -1]
    assert table.right.tolist() == [2, -1, 6, 5, -1, -1, -1]
    assert table.leaf_nodes.tolist() == [1, 4, 5, 6]
    samples = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [1.0, 1.0]])
    assert leaf_nodes(UNEVEN, samples).tolist() == [1, 4, 5, 6]
    paths = [node_indicator(UNEVEN, samples)[k].indices.tolist() for k in range(4)]
    assert paths == [[0, 1], [0, 2, 3, 4], [0, 2, 3, 5], [0, 2, 6]]


def test_scikit_learns_tree_has_the_same_nodes_and_predicts_the_same(iris):
    frame, model = load_iris(as_frame=True).data, iris.to_sklearn()
    assert isinstance(model, DecisionTreeClassifier)
    assert (model.predict(frame) == iris.predict(frame)).all()
    assert np.allclose(model.predict_proba(frame), iris.predict_proba(frame), rtol=1e-15)
    assert (model.apply(frame) == iris.apply(frame)).all()
    assert (model.decision_path(frame) != iris.decision_path(frame)).nnz == 0
    assert (model.get_depth(), model.get_n_leaves()) == (iris.get_depth(), iris.get_n_leaves())
    assert list(model.feature_names_in_) == list(frame.columns)
    assert model.tree_.weighted_n_node_samples[0] == iris.problem_.samples.weights.sum()
    assert model.tree_.n_node_samples[0] == 150
    assert (model.predict(frame) == pickle.loads(pickle.dumps(model)).predict(frame)).all()


def test_a_leaf_of_a_tree_without_splits_has_scikit_learns_form():
    model = OptimalTreeClassifier(3, leaf_penalty=100.0).fit(*IRIS).to_sklearn()
    assert model.get_n_leaves() == 1
    assert (model.predict(IRIS[0]) == 0).all()


def refused(message, X, y, **settings):
    model = OptimalTreeClassifier(**{"max_depth": 1} | settings).fit(X, y)
    with pytest.raises(TreeError, match=message):
        model.to_sklearn()


def test_what_scikit_learn_would_predict_otherwise_is_refused():
    near = 1e8 + np.array([[0.0], [1.0], [2.0], [3.0]])
    refused(r"float32, which takes 'x0' = 10000000\d\.0 to the other side of", near, [0, 0, 1, 1])
    refused("beyond float32", [[1e39], [0.0]], [0, 1])
    lines = [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 3.0], [3.0, 2.0], [1.0, 0.0]]
    refused("hyperplanes has no form", lines, [0, 0, 1, 1, 0, 0], split="hyperplane", split_size=2)
    refused(r"fit on columns_\.encode\(X\)", FRAME, ANSWERS)
    costs = [[0, 1], [9, 0]]
    refused(
        r"leaf 0 .* predicts .*1.*, which costs least there", [[0.0], [0.0], [0.0], [1.0]], [0, 0, 1, 1], costs=costs
    )


def test_importances_are_shares_of_the_cost_that_splits_save():
    features = np.array([[0, 0], [0, 0], [1, 0], [1, 0], [1, 0], [1, 1]], dtype=float)
    labels = [0, 0, 1, 1, 1, 0]
    model = OptimalTreeClassifier(max_depth=2).fit(features, labels)
    assert model.objective_ == 0
    assert model.feature_importances_.tolist() == pytest.approx([2 / 3, 1 / 3])
    leaf = OptimalTreeClassifier(3, leaf_penalty=9.0).fit(features, labels)
    assert leaf.feature_importances_.tolist() == [0, 0]


def test_the_saving_of_a_hyperplane_does_not_depend_on_units():
    features = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    scaled = features * [1.0, 1000.0]
    for table, coefficients in ((features, (1.0, 1.0)), (scaled, (1.0, 0.001))):
        problem = Problem(table, [0, 0, 0, 1], depth=1, split="hyperplane")
        tree = HyperplaneSplit((0, 1), coefficients, 1.5, Leaf(0), Leaf(1))
        assert feature_savings(problem, tree).tolist() == pytest.approx([0.5, 0.5])


def test_it_draws_itself_and_writes_a_page(iris, encoded, tmp_path):
    for model in (iris, encoded):
        assert model.plot(title="a title").get_axes()[0].get_title() == "a title"
        model.report(tmp_path / "page.html", seconds=0.5)
        page = (tmp_path / "page.html").read_text()
        assert page.startswith("<!doctype html>")
        assert "octmip certify" not in page
        assert "CART" in page
        assert ("animal" in page) == (model is encoded)
        assert "<b>kind" not in page
    drawn = [text.get_text() for text in encoded.plot().findobj(Text)]
    assert not [text for text in drawn if "missing below" in text or "≤ 0.5" in text]
    assert "is a?" in drawn


def test_the_page_judges_the_tree_by_samples_held_out(encoded, tmp_path):
    encoded.report(tmp_path / "page.html", FRAME.iloc[:3], ["no", "no", "yes"], seconds=0.0)
    assert "3 samples of the test set" in (tmp_path / "page.html").read_text()
    for wrong, message in ((["no", "no", "maybe"], "'maybe', which is no class"), (None, "without y_test")):
        with pytest.raises(DataError, match=message):
            encoded.report(tmp_path / "page.html", FRAME.iloc[:3], wrong)
    with pytest.raises(ValueError, match="inconsistent numbers of samples"):
        encoded.report(tmp_path / "page.html", FRAME.iloc[:3], ["no"])


def picture(html):
    """Return the texts of the drawing that stands below scikit-learn's diagram."""
    drawing = ElementTree.fromstring(html[html.rindex("<svg") : html.rindex("</svg>") + len("</svg>")])
    return [text.text for text in drawing.iter("{http://www.w3.org/2000/svg}text")]


def test_a_notebook_shows_the_tree_below_scikit_learns_diagram(iris, encoded):
    html = iris._repr_html_()
    assert picture(html) == picture(iris._repr_mimebundle_()["text/html"])
    assert html.startswith(DecisionTreeClassifier()._repr_html_()[:6])
    assert {"yes", "no", "0", "1", "2"} <= set(picture(html))
    assert {"<b>kind</b>", "is a?"} <= set(picture(encoded._repr_html_()))
    assert "samples wrong (" in html
    assert "%); objective" in html
    assert "<b>kind</b>" not in encoded._repr_html_()
    assert 'aria-label="the fitted tree"' not in OptimalTreeClassifier()._repr_html_()
    assert "OptimalTreeClassifier" in make_pipeline(StandardScaler(), iris)._repr_html_()


def test_a_tree_too_wide_for_a_picture_is_shown_as_text(iris, monkeypatch):
    monkeypatch.setattr(drawing, "MOST_LEAVES", iris.get_n_leaves() - 1)
    assert f"<pre>{escape(iris.export_text())}</pre>" in iris._repr_html_()
