"""What the wrappers of the native core share: incumbents, progress, labels, logs."""

import math

import numpy as np
import pytest

from octmip import HyperplaneSplit, Leaf, Limits, Problem, Solution, Split
from octmip.errors import DataError, ProblemError
from octmip.trees.answer.solution import Progress, Stop
from octmip.trees.encoding import integer_costs
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.native_call import feasible_incumbent, native_progress, relabelled, write_log
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound

SOLVERS = (branch_and_bound, two_feature_branch_and_bound, local_search)
STAIRS = Split(0, 0.5, Leaf(0), Split(0, 1.5, Leaf(1), Leaf(0)))
NO_TREES = {
    "depth 3 but the problem allows 2": Split(0, -0.5, Leaf(1), STAIRS),
    "feature 3 but the problem has 2": Split(3, 0.5, Leaf(0), Leaf(1)),
    "class 7 but the problem has 2": Split(0, 0.5, Leaf(0), Leaf(7)),
    "holds 1 samples but leaf_size is 2": Split(0, -0.5, Leaf(0), Leaf(1)),
    "over the budget": Split(0, 0.5, Leaf(0), Split(1, 1.5, Leaf(0), Leaf(1))),
    "hyperplane but split is 'axis'": HyperplaneSplit((0,), (1.0,), 0.5, Leaf(0), Leaf(1)),
}


def problem(**changes) -> Problem:
    features = [[-1, 0], [0, 1], [0, 3], [1, 0], [1, 1], [1, 2], [1, 3], [2, 2], [2, 4]]
    given = {"depth": 2, "leaf_size": 2, "sensor_budget": 1.0} | changes
    return Problem(np.array(features, dtype=float), [1, 0, 0, 1, 1, 1, 1, 0, 0], **given)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("reason", NO_TREES)
def test_every_solver_refuses_an_incumbent_that_is_no_tree_of_the_problem(solver, reason):
    with pytest.raises(ProblemError, match=f"the incumbent is no tree of this problem: .*{reason}.*; give a tree"):
        solver(problem(), incumbent=NO_TREES[reason], limits=Limits(seconds=0.0))


@pytest.mark.parametrize("solver", SOLVERS)
def test_every_solver_starts_from_a_tree_or_a_solution_and_is_never_worse(solver):
    one = problem()
    known = Solution(STAIRS, one.objective(STAIRS), -math.inf, Stop.FINISHED, 0.0, 0, "by hand", "1", 0)
    for incumbent in (STAIRS, known):
        assert solver(one, incumbent=incumbent, limits=Limits(seconds=0.0)).objective <= known.objective
    with pytest.raises(ProblemError, match="holds no tree"):
        solver(one, incumbent=Solution(None, math.inf, 0.0, Stop.TIME, 0.0, 0, "none", "1", 0))


def test_splits_of_an_incumbent_that_part_no_samples_are_left_out():
    idle = Split(1, 99.0, STAIRS, Leaf(1))
    assert feasible_incumbent(problem(), idle) == STAIRS
    assert feasible_incumbent(problem(), None) is None


def test_progress_is_in_the_units_of_the_problem_and_goes_on_from_what_was_known():
    light = problem(weights=[0.25] * 9)
    costs, seen = integer_costs(light), []
    whole = costs.whole_objective(light, Leaf(0))
    report = native_progress(seen.append, costs.value, Progress(seconds=2.0, objective=1.5, bound=0.5, n_nodes=10))
    report(1.0, 2**63 - 1, 0, 3)
    report(1.5, whole, whole, 4)
    assert seen == [Progress(3.0, 1.5, 0.5, 13), Progress(3.5, 1.25, 1.25, 14)]
    native_progress(seen.append, costs.value)(1.0, 2**63 - 1, 0, 3)
    assert seen[-1] == Progress(1.0, math.inf, 0.0, 3)
    assert native_progress(None, costs.value)(1.0, whole, whole, 3) is None  # asked for signals alone


def test_leaves_take_the_label_of_least_cost_and_keep_theirs_where_no_sample_comes():
    wrong = Split(0, 0.5, Leaf(1), Split(0, 1.5, Leaf(0), Split(0, 9.0, Leaf(1), Leaf(1))))
    expected = Split(0, 0.5, Leaf(0), Split(0, 1.5, Leaf(1), Split(0, 9.0, Leaf(0), Leaf(1))))
    assert relabelled(problem(), wrong) == expected


def test_a_log_is_written_whole_or_not_at_all(tmp_path):
    path = tmp_path / "log"

    def refuse(draft):
        assert draft.read_text() == "second\n"
        raise ProblemError("no")

    write_log(path, "first\n")
    with pytest.raises(ProblemError, match="no"):
        write_log(path, "second\n", refuse)
    assert path.read_text() == "first\n"
    assert list(tmp_path.iterdir()) == [path]
    write_log(path, "third\n", lambda draft: None)
    assert path.read_text() == "third\n"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("solver", SOLVERS[:2])
def test_a_log_that_cannot_be_written_is_refused_before_the_search(solver, tmp_path):
    options = ExactOptions(proof=tmp_path / "none" / "log")
    with pytest.raises(DataError, match="no folder"):
        solver(problem(), options=options, progress=lambda state: pytest.fail("searched"))
