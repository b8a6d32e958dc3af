"""At most so many splits: exact at any depth, kept by every method, door and file, refused where unknown."""

import numpy as np
import pytest

from octmip import Leaf, Problem, Split, certify, solve
from octmip.errors import CertificateError, ProblemError
from octmip.formats.tree_file import read_tree_file, record_tree, write_tree_file
from octmip.interfaces.estimator import OptimalTreeClassifier, OptimalTreeRegressor
from octmip.trees.near_sets import near_optimal
from octmip.trees.problem_file import encode, question_digest
from octmip.trees.tree import n_splits

RNG = np.random.default_rng(3)
FEATURES, LABELS = RNG.normal(size=(40, 3)), RNG.integers(0, 2, 40)


def asked(depth: int, most: int | None) -> Problem:
    return Problem(FEATURES, LABELS, depth=depth, max_splits=most)


def test_a_certificate_refutes_one_split_too_many():
    free = solve(asked(2, None), "exact")
    with pytest.raises(CertificateError, match=r"has \d splits but max_splits is 1"):
        certify(asked(2, 1), free)


def test_a_tree_file_keeps_the_number_and_a_problem_file_says_that_it_cannot(tmp_path):
    problem = asked(3, 2)
    write_tree_file(tmp_path / "tree.json", record_tree(problem, solve(problem)))
    assert read_tree_file(tmp_path / "tree.json").settings["max_splits"] == 2
    with pytest.raises(ProblemError, match="max_splits, monotone or a part of the tree is given, of which"):
        encode(problem)
    assert len({question_digest(asked(3, most)) for most in (1, 2, 7, None)}) == 3  # 7 are no limit


def test_estimators_take_leaves():
    tree = OptimalTreeClassifier(max_depth=4, max_leaf_nodes=3).fit(FEATURES, LABELS)
    assert tree.objective_ == solve(asked(4, 2)).objective
    assert n_splits(tree.tree_) <= 2
    numbers = OptimalTreeRegressor(max_depth=3, max_leaf_nodes=2, method="search").fit(FEATURES, FEATURES[:, 1])
    assert n_splits(numbers.tree_) <= 1
    with pytest.raises(ProblemError, match="max_leaf_nodes is 0"):
        OptimalTreeClassifier(max_depth=2, max_leaf_nodes=0).fit(FEATURES, LABELS)
    with pytest.raises(ProblemError, match="max_leaf_nodes is 3 with max_depth='auto'"):
        OptimalTreeClassifier(max_leaf_nodes=3).fit(FEATURES, LABELS)
    with pytest.raises(ProblemError, match="max_leaf_nodes is 3 but split is 'hyperplane'"):
        OptimalTreeClassifier(2, split="hyperplane", max_leaf_nodes=3).fit(FEATURES, LABELS)


def test_what_goes_through_trees_level_by_level_refuses_it():
    with pytest.raises(ProblemError, match="near_optimal goes through trees level by level"):
        near_optimal(asked(2, 1), within=1)


def test_an_incumbent_of_the_shape_is_taken_and_another_refused():
    chain = Split(0, 0.0, Leaf(0), Split(1, 0.0, Leaf(1), Leaf(0)))
    assert solve(asked(3, 2), "exact", incumbent=chain).is_optimal
    with pytest.raises(ProblemError, match="has 2 splits but max_splits is 1"):
        solve(asked(3, 1), "exact", incumbent=chain)
