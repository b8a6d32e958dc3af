"""Solutions and limits: derived numbers agree with the claims they derive from."""

import dataclasses
import math

import numpy as np
import pytest

from octmip import HyperplaneSplit, Leaf, Limits, Problem, Solution, Split, Stop
from octmip.errors import ProblemError, SolverError
from octmip.interfaces.report.markdown import markdown_table
from octmip.interfaces.report.text import solution_text, tree_text
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.scope import within
from octmip.trees.answer.solution import relative_gap
from octmip.trees.methods.cart import greedy_tree


def solution(objective=10.0, bound=8.0, tree=Leaf(0), **changes):  # noqa: B008 (frozen)
    return Solution(tree, objective, bound, Stop.TIME, 1.0, 5, "exact", "1", 0, **changes)


def test_the_gap_is_relative_to_the_objective():
    assert solution().gap == pytest.approx(0.2)
    assert not solution().is_optimal
    assert solution(bound=-math.inf).gap == math.inf
    assert solution(objective=0.0, bound=0.0).gap == 0
    assert solution(objective=0.0, bound=0.0).is_optimal


def test_without_a_tree_there_is_no_optimum():
    nothing = solution(objective=math.inf, bound=3.0, tree=None)
    assert nothing.gap == math.inf
    assert not nothing.is_optimal


@pytest.mark.parametrize(
    ("objective", "bound", "gap"),
    # An objective of 0 is divided by 1e-300, so that its gap is a number.
    [(10, 10, 0), (10, 12, 0), (10, 5, 0.5), (math.inf, 1, math.inf), (1, -math.inf, math.inf), (0, -1, 1e300)],
)
def test_relative_gap(objective, bound, gap):
    assert relative_gap(objective, bound) == pytest.approx(gap, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"objective": math.nan}, "NaN is no proof"),
        ({"bound": math.nan}, "NaN is no proof"),
        ({"objective": math.inf}, "expected \\+inf iff none"),
        ({"tree": None}, "expected \\+inf iff none"),
    ],
)
def test_claims_that_cannot_be_are_refused(changes, sentence):
    with pytest.raises(SolverError, match=sentence):
        solution(**changes)


@pytest.mark.parametrize("name", ["seconds", "gap", "nodes", "memory"])
@pytest.mark.parametrize("value", [-1.0, math.nan])
def test_a_negative_limit_is_refused(name, value):
    with pytest.raises(ProblemError, match=f"limit {name} is"):
        Limits(**{name: value})


def test_a_bound_that_is_known_besides_counts_up_to_the_objective_and_proves_there():
    known = [solution().with_bound(bound) for bound in (7.0, 9.0, 12.0)]
    assert [(one.bound, one.stop) for one in known] == [(8.0, Stop.TIME), (9.0, Stop.TIME), (10.0, Stop.OPTIMAL)]


def test_a_solution_prints_what_was_found_and_proven():
    tree = Split(0, 2.5, Leaf(1), HyperplaneSplit((0, 2), (1.0, -0.5), 3.0, Leaf(0), Leaf(1)))
    assert str(solution(tree=tree)).splitlines() == [
        "objective 10, bound 8: gap 20 %",
        "depth 2, 2 splits; exact 1, 1 s, stop: time",
        "",
        "if x0 <= 2.5",
        "    class 1",
        "else",
        "    if x0 - 0.5 x2 <= 3",
        "        class 0",
        "    else",
        "        class 1",
    ]
    assert str(solution(bound=10.0)).startswith("objective 10, bound 10: proven optimal\n")
    assert str(solution(bound=-math.inf)).startswith("objective 10, bound -inf: no proof\n")
    assert str(solution(objective=math.inf, bound=3.0, tree=None)).startswith("no tree found, bound 3\n")


# Reports say what the tree says


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
