"""Ties: what is proven of the fewest splits and sensors is said. The fuzz holds both against enumeration."""

import numpy as np
import pytest

from octmip import Leaf, Problem
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.ties import UNBROKEN
from octmip.trees.nodes.tree import n_splits


def equal(depth: int = 2, **options: object) -> Problem:
    """Return samples of which no split makes fewer errors than a leaf."""
    return Problem([[0.0], [0.0], [1.0], [1.0]], [0, 1, 0, 1], depth=depth, **options)


def test_a_tree_without_splits_takes_the_place_of_an_equal_one_with_some() -> None:
    found = branch_and_bound(equal(), break_ties=True)
    assert (found.tree, n_splits(found.tree)) == (Leaf(0), 0)
    assert found.details["ties_broken"] == UNBROKEN | dict.fromkeys(("splits", "sensors"), "fewest, proven")
    assert branch_and_bound(equal()).details["ties_broken"] == UNBROKEN


@pytest.mark.parametrize(
    ("options", "kind", "said"),
    [
        ({"weights": [0.1, 0.7, 1.3, 2.9]}, "splits", "not broken: the costs are too fine to count splits"),
        ({"sensor_cost": [1.0, 2.0], "sensor_budget": 2.0}, "sensors", "not broken: a budget of sensors of different"),
    ],
)
def test_why_ties_are_not_broken_is_said(options: dict[str, object], kind: str, said: str) -> None:
    features = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    problem = Problem(features, [0, 1, 0, 1], depth=2, **options)
    assert branch_and_bound(problem, break_ties=True).details["ties_broken"][kind].startswith(said)
