"""Trees: the left rule, and what is counted along the paths."""

import numpy as np
import pytest

from octmip import HyperplaneSplit, Leaf, Split, ValueLeaf, predict
from octmip.errors import TreeError
from octmip.trees.nodes.reached import centred, without_empty_sides
from octmip.trees.nodes.tree import (
    complexity,
    depth,
    features_used,
    goes_left,
    leaf_index,
    leaves,
    n_splits,
    nodes,
    simplify,
)

STUMP = Split(0, 2.5, Leaf(0), Leaf(1))
TREE = Split(1, 0.0, STUMP, HyperplaneSplit((0, 2), (1.0, -1.0), 0.5, Leaf(2), Leaf(0)))
FIVE = np.array([[0.5], [1.5], [2.5], [3.5], [4.5]])


def test_a_value_equal_to_the_threshold_goes_left():
    assert goes_left(STUMP, FIVE).tolist() == [True, True, True, False, False]
    assert predict(STUMP, FIVE).tolist() == [0, 0, 0, 1, 1]


def test_a_sample_on_the_hyperplane_goes_left_and_products_are_added_from_the_first_feature_to_the_last():
    split = HyperplaneSplit((0, 1), (2.0, -1.0), 3.0, Leaf(0), Leaf(1))
    assert goes_left(split, np.array([[2.0, 1.0], [2.0, 0.9], [2.0, 1.1]])).tolist() == [True, False, True]
    split = HyperplaneSplit((0, 1, 2), (1.0, 1.0, 1.0), 0.0, Leaf(0), Leaf(1))
    # (1 + 1e16) - 1e16 is 0 in float64, while 1 + (1e16 - 1e16) would be 1 and go right
    assert goes_left(split, np.array([[1.0, 1e16, -1e16]])).tolist() == [True]


def test_a_tree_prints_its_rule_in_notebooks_too_and_shows_the_call_that_makes_it():
    tree = Split(0, 2.5, Leaf(1), ValueLeaf(3.0, (1,), (-2.0,)), missing="left")
    assert str(tree) == "if x0 <= 2.5 or missing\n    class 1\nelse\n    3 - 2 x1"
    assert tree._repr_html_().endswith(">if x0 &lt;= 2.5 or missing\n    class 1\nelse\n    3 - 2 x1</pre>")
    for one in (tree, TREE):
        assert eval(repr(one)) == one
    assert repr(Split(0, 2.5, Leaf(0), Leaf(1))) == "Split(0, 2.5, Leaf(0), Leaf(1))"


def test_leaves_are_numbered_from_the_left():
    points = np.array([[0, -1, 0], [9, -1, 0], [0, 1, 0], [9, 1, 0]], dtype=float)
    assert leaf_index(TREE, points).tolist() == [0, 1, 2, 3]
    assert [leaf.label for leaf in leaves(TREE)] == [0, 1, 2, 0]
    assert leaf_index(Leaf(1), points).tolist() == [0] * 4


def test_splits_depth_complexity_and_features_are_counted():
    assert (n_splits(TREE), depth(TREE), complexity(TREE)) == (3, 2, 4)
    assert features_used(TREE) == (0, 1, 2)
    assert len(list(nodes(TREE))) == 7
    assert (n_splits(Leaf(0)), depth(Leaf(0)), complexity(Leaf(0)), features_used(Leaf(0))) == (0, 0, 0, ())


def test_splits_whose_sides_agree_are_simplified_from_the_bottom_up():
    agreeing = Split(0, 1.0, Split(1, 1.0, Leaf(1), Leaf(1)), Leaf(1))
    assert simplify(agreeing) == Leaf(1)
    assert simplify(TREE) == TREE


def test_splits_that_send_all_samples_to_one_side_are_taken_out():
    assert without_empty_sides(Split(0, 9.0, STUMP, Leaf(2)), FIVE) == STUMP
    assert without_empty_sides(Split(0, -9.0, Leaf(2), STUMP), FIVE) == STUMP
    assert without_empty_sides(Split(0, 1.0, STUMP, Leaf(2)), FIVE) == Split(0, 1.0, Leaf(0), Leaf(2))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Leaf(-1), "leaf label is -1"),
        (lambda: Split(-1, 0.0, Leaf(0), Leaf(0)), "split feature is -1"),
        (lambda: Split(0, np.nan, Leaf(0), Leaf(0)), "threshold on feature 0 is nan"),
        (lambda: Split(0, np.inf, Leaf(0), Leaf(0)), "threshold on feature 0 is inf"),
        (lambda: Split(0, None, Leaf(0), Leaf(0)), "neither a threshold nor a side"),
        (lambda: Split(0, 1.0, Leaf(0), Leaf(0), missing="up"), "go to 'up'"),
        (lambda: HyperplaneSplit((), (), 0.0, Leaf(0), Leaf(0)), "0 features and 0 coefficients"),
        (lambda: HyperplaneSplit((0, 1), (1.0,), 0.0, Leaf(0), Leaf(0)), "2 features and 1 coefficients"),
        (lambda: HyperplaneSplit((1, 0), (1.0, 1.0), 0.0, Leaf(0), Leaf(0)), "expected ascending indices"),
        (lambda: HyperplaneSplit((0, 0), (1.0, 1.0), 0.0, Leaf(0), Leaf(0)), "expected ascending indices"),
        (lambda: HyperplaneSplit((0, 1), (1.0, 0.0), 0.0, Leaf(0), Leaf(0)), "no coefficient zero"),
        (lambda: HyperplaneSplit((0,), (np.nan,), 0.0, Leaf(0), Leaf(0)), "expected finite numbers"),
    ],
)
def test_a_malformed_node_is_refused(make, sentence):
    with pytest.raises(TreeError, match=sentence):
        make()


def test_a_centred_threshold_lies_midway_between_the_rows_of_its_own_node():
    features = np.array([[0.0, 5.0], [1.0, 9.0], [4.0, 1.0], [6.0, 2.0]])
    tree = Split(0, 1.5, Split(1, 5.5, Leaf(0), Leaf(1)), Split(0, 4.0, Leaf(0), Leaf(1)))
    found = centred(tree, features)
    assert found == Split(0, 2.5, Split(1, 7.0, Leaf(0), Leaf(1)), Split(0, 5.0, Leaf(0), Leaf(1)))
