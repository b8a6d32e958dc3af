"""Reports say what the tree says."""

import dataclasses

import numpy as np

from octmip import HyperplaneSplit, Leaf, Problem, Split, Stop
from octmip.interfaces.report.markdown import markdown_table
from octmip.interfaces.report.text import solution_text, tree_text
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.scope import within
from octmip.trees.methods.cart import greedy_tree

TREE = Split(0, 0.5, Leaf(1), HyperplaneSplit((0, 1), (-2.0, 1.0), 1 / 3, Leaf(0), Leaf(1)))
FEATURES, CLASSES = ('a"1', "b<2"), ("no & never", "yes")


def problem() -> Problem:
    features = np.array([[0.0, 1], [1, 1], [2, 9], [3, 0]])
    return Problem(features, ["yes", "no & never", "yes", "yes"], depth=2, feature_names=FEATURES)


def test_a_tree_in_words():
    counts = np.array([[0, 3], [2, 1], [0, 1]])
    assert tree_text(TREE, ("a", "b"), ("no", "yes"), counts).splitlines() == [
        "if a <= 0.5",
        "    yes    (3 samples)",
        "else",
        "    if -2 a + b <= 0.3333333333333333",
        "        no    (3 samples, 1 wrong)",
        "    else",
        "        yes    (1 sample)",
    ]


def test_a_bound_over_some_trees_says_over_which():
    claim = dataclasses.replace(
        greedy_tree(problem()), bound=0.0, stop=Stop.OPTIMAL, details={"scope": within(problem(), "small trees")}
    )
    text = solution_text(problem(), claim, certify(problem(), claim))
    assert text.startswith("objective 0, bound 0: proven optimal among small trees, of depth 2 or less\n")


def test_a_markdown_table_is_aligned_and_shows_unknown_as_dash():
    table = markdown_table([{"method": "cart", "bound": None}, {"method": "a|b", "bound": 1.5}])
    assert table.splitlines() == [
        "| method | bound |",
        "| ------ | ----: |",
        "| cart   |     - |",
        r"| a\|b   |   1.5 |",
    ]
