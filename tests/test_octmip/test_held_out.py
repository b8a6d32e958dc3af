"""Held-out samples: the rows follow from labels, share and seed alone, and both trees are counted by hand."""

import numpy as np
import pytest

from octmip import ClassCosts, Leaf, Problem, Split
from octmip.errors import ProblemError
from octmip.trees.tradeoff.held_out import Samples, beside_cart, held_out_rows, score


def test_each_class_gives_its_share_but_never_its_last_row():
    labels = np.array(["a"] * 40 + ["b"] * 10 + ["c"])
    is_held = held_out_rows(labels, 0.25, seed=3)
    assert [int(is_held[labels == name].sum()) for name in "abc"] == [10, 3, 0]
    assert (held_out_rows(labels, 0.25, seed=3) == is_held).all()
    assert (held_out_rows(labels, 0.25, seed=4) != is_held).any()
    assert held_out_rows(labels, 0.99, seed=0).sum() == 48


def test_the_rows_are_those_of_every_version():
    assert np.flatnonzero(held_out_rows(np.array([0, 1] * 6), 0.5, seed=0)).tolist() == [1, 2, 3, 6, 8, 11]


@pytest.mark.parametrize("share", [0.0, 1.0, -0.1, float("nan"), 0.01])
def test_a_share_that_holds_nothing_out_is_refused(share):
    with pytest.raises(ProblemError, match=r"share"):
        held_out_rows(np.array([0, 1] * 5), share, seed=0)


def test_tree_and_cart_are_counted_on_both_parts():
    problem = Problem([[0.0], [1.0], [2.0]], [0, 1, 1], depth=1, weights=[1, 2, 3], loss=ClassCosts([[0, 4], [5, 0]]))
    held = Samples(np.array([[0.0], [3.0], [0.4]]), np.array([1, 1, 0]), np.array([1.0, 1.0, 2.0]))
    found = beside_cart(problem, Leaf(0), held)
    assert (found.training.n_samples, found.training.errors, found.training.cost) == (3, 2, 25)
    assert found.held_out is not None
    assert (found.held_out.errors, found.held_out.cost, found.held_out.error_rate) == (2, 10, pytest.approx(2 / 3))
    assert found.cart_tree == Split(0, 0.5, Leaf(0), Leaf(1))
    assert (found.cart_training.errors, found.cart_held_out.errors, found.cart_held_out.cost) == (0, 1, 5)
    assert beside_cart(problem, Leaf(0)).held_out is None
    assert score(problem, Leaf(1), held).errors == 1
