"""Reading plans say what to read, what that costs, and when to stop."""

import numpy as np
import pytest

from octmip import Problem
from octmip.errors import CertificateError
from octmip.interfaces.report.plan import Wording, plan_text
from octmip.sensing import Group, SequentialProblem
from octmip.trees.solution import Solution, Stop
from octmip.trees.tree import HyperplaneSplit, Leaf, Split


def asked(**options) -> tuple[SequentialProblem, Solution]:
    """Return eight samples over two gauges, a tree that reads the first twice, and what it costs."""
    features = np.column_stack([np.arange(8.0), np.arange(8.0) % 2])
    problem = Problem(features, [0, 0, 1, 1, 2, 2, 2, 3], depth=2, feature_names=("g1", "g2"))
    sequential = SequentialProblem(problem, price=0.125, groups={"root": Group(("g1",), 2.0)}, **options)
    tree = Split(0, 3.5, Split(0, 1.5, Leaf(0), Leaf(1)), Split(1, 0.5, Leaf(2), Leaf(3)))
    return sequential, Solution(tree, 1.0 + 0.125 * (8 * 3 + 4), 0.0, Stop.FINISHED, 0.0, 0, "by hand", "1", 0)


def test_the_plan_counts_each_reading_once_and_says_what_is_free():
    text = plan_text(*asked(), Wording("microstrain", "mu1", "%"))
    assert text.splitlines() == [
        "read g1 (cost 3); if g1 <= 3.5 microstrain",
        "    read g1 (already read: free); if g1 <= 1.5 microstrain",
        "        decide mu1 = 0 %    (25 % of cases, 0 of 2 wrong; 1 reading, cost 3)",
        "    else",
        "        decide mu1 = 1 %    (25 % of cases, 0 of 2 wrong; 1 reading, cost 3)",
        "else",
        "    read g2 (cost 1); if g2 <= 0.5 microstrain",
        "        decide mu1 = 2 %    (25 % of cases, 0 of 2 wrong; 2 readings, cost 4)",
        "    else",
        "        decide mu1 = 3 %    (25 % of cases, 1 of 2 wrong; 2 readings, cost 4)",
        "expected cost 3.5 (1.5 readings); worst 4 (2 readings)",
        "1 of 8 samples wrong; objective 4.5, not proven: none is below 0",
    ]


def test_a_split_over_two_gauges_reads_both():
    sequential, _ = asked()
    tree = HyperplaneSplit((0, 1), (1.0, -2.0), 3.5, Leaf(0), Leaf(2))
    problem = Problem(sequential.problem.features, sequential.problem.targets, depth=1, split="hyperplane")
    two = SequentialProblem(problem)
    line = plan_text(two, Solution(tree, 4.0, 0.0, Stop.FINISHED, 0.0, 0, "by hand", "1", 0)).splitlines()[0]
    assert line == "read x0 (cost 1), x1 (cost 1); if x0 - 2 x1 <= 3.5"


def test_a_false_claim_makes_no_plan():
    sequential, solution = asked(within={3: 1})
    with pytest.raises(CertificateError, match="class 3"):
        plan_text(sequential, solution)
