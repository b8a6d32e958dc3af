"""A Pyomo model of octmip's that a user changed: what comes back is true of the trees that the change leaves."""

import numpy as np
import pytest

import octmip
from octmip.errors import ProblemError, SolverError
from tests.oracles.heap_trees import heap_tree, heap_trees

pyo = pytest.importorskip("pyomo.environ")

from pyomo.contrib import appsi  # noqa: E402
from pyomo.contrib.solver.common.factory import SolverFactory  # noqa: E402

from benchmarks.cases.doors.pyomo_models import SOLVERS, outcome  # noqa: E402
from benchmarks.pyomo_ways import WAYS  # noqa: E402

STRAINS = [[1, 3], [2, 4], [3, 1], [4, 2], [5, 5], [6, 3], [2, 6], [3, 5], [5, 1], [6, 6], [4, 4], [1, 1]]
DAMAGED = [0, 0, 0, 0, 1, 1, 1, 1, 0, 1, 1, 0]
PROBLEM = octmip.Problem(STRAINS, DAMAGED, depth=1)


@pytest.mark.parametrize("way", WAYS)
def test_what_comes_back_is_a_tree_and_a_bound_that_the_change_leaves_or_one_true_sentence(way):
    solvers = [name for name in ("appsi_highs", "new scip_direct", "cbc") if SOLVERS[name]()]
    line = outcome(91_000 + list(WAYS).index(way), way, solvers)
    assert (line["fault"], line["solver"] != "none") == ("", True)


def changed(**parts):
    """Return a model of one split with further components."""
    model = octmip.model(PROBLEM, "oct")
    for name, part in parts.items():
        setattr(model, name, part(model))
    return model


def reads(feature):
    return lambda M: pyo.Constraint(expr=M.a[feature, 1] == 1)


@pytest.mark.parametrize(
    ("solve", "named"),
    [
        (appsi.solvers.Highs().solve, "another solver"),
        (SolverFactory("highs").solve, "highs"),
        (pyo.SolverFactory("appsi_highs").solve, "another solver"),
    ],
)
def test_results_of_all_three_kinds_say_bound_and_end_and_a_name_if_they_have_one(solve, named):
    model = changed(root=reads(0))
    solution = octmip.solution_of(model, solve(model))
    assert (solution.objective, solution.bound, solution.stop, solution.version) == (4, 4, "optimal", named)
    assert solution.details["scope"] == (
        "those of all axis-aligned trees that are solutions of the model 'oct' and keep what was added to it (root), "
        "of depth 1 or less"
    )
    assert octmip.certify(PROBLEM, solution).bound == 4  # one leaf of cost 6 is none of these trees


def test_an_end_without_a_solution_is_told_before_values_are_read():
    model = changed(root=reads(0), other=reads(1))
    results = pyo.SolverFactory("appsi_highs").solve(model, load_solutions=False)
    with pytest.raises(SolverError, match=r"'infeasible': no tree of the model that keeps .*\(root, other\)"):
        octmip.solution_of(model, results)


def test_whole_values_may_be_rounded_after_the_solve():
    model = octmip.model(PROBLEM)
    results = pyo.SolverFactory("appsi_highs").solve(model)
    for variable in model.component_data_objects(pyo.Var):
        if variable.is_binary():
            variable.set_value(round(variable.value))
    solution = octmip.solution_of(model, results)
    assert (solution.bound, solution.details["scope"]) == (2, "all axis-aligned trees, of depth 1 or less")


def test_a_start_that_no_solver_has_touched_is_no_answer():
    with pytest.raises(SolverError, match="which no solver has set"):
        octmip.solution_of(octmip.model(PROBLEM), bound=2)


def test_a_solver_that_calls_a_model_with_a_known_tree_infeasible_is_told_so():
    model = octmip.model(PROBLEM)
    results = pyo.SolverFactory("appsi_highs").solve(model)
    results.solver.termination_condition = pyo.TerminationCondition.infeasible
    with pytest.raises(SolverError, match="that is false, as the tree to start from is one"):
        octmip.solution_of(model, results)


@pytest.mark.parametrize("kind", ["disjunction", "bound", "a letter of the model"])
def test_what_cannot_be_evaluated_is_refused(kind):
    from pyomo.gdp import Disjunction

    model = octmip.model(PROBLEM)
    results = pyo.SolverFactory("appsi_highs").solve(model)
    if kind == "disjunction":
        model.either = Disjunction(expr=[[model.a[0, 1] == 1], [model.a[1, 1] == 1]])
    if kind.startswith("a letter"):
        model.c = pyo.Constraint(expr=model.a[0, 1] == 1)
    with pytest.raises(ProblemError, match=r"a Disjunct|expected a number|\(without a Var: c\)"):
        octmip.solution_of(model, results, bound=float("nan") if kind == "bound" else None)


def test_a_split_with_all_samples_on_one_side_keeps_no_row_of_a_tree():
    # Feature 0 cannot part these samples better than feature 1, so the root may name it and send all to one side.
    problem = octmip.Problem([[0, 0], [1, 0], [0, 1], [1, 1]], [0, 0, 1, 1], depth=2, leaf_penalty=0)
    model = octmip.model(problem, "oct")
    model.root = pyo.Constraint(expr=model.a[0, 1] == 1)
    model.idle = pyo.Constraint(expr=model.b[1] <= 0)
    results = pyo.SolverFactory("appsi_highs").solve(model)
    with pytest.raises(SolverError, match=r"keeps root by a split with all samples on one side"):
        octmip.solution_of(model, results)


def test_the_enumeration_of_heap_trees_holds_the_optimum_and_lays_trees_as_they_are():
    rng = np.random.default_rng(5)
    for _ in range(5):
        problem = octmip.Problem(rng.integers(0, 3, (6, 2)).astype(float), rng.integers(0, 2, 6), depth=2)
        solution = octmip.solve(problem, "exact")
        every = list(heap_trees(problem))
        assert min(tree.cost for tree in every) == solution.objective
        assert heap_tree(problem, solution.tree).splits in [tree.splits for tree in every]


def test_a_variable_of_ones_own_keeps_its_ends():
    model = octmip.model(PROBLEM, "oct")
    model.use = pyo.Var(domain=pyo.Binary)
    model.link = pyo.Constraint(expr=model.use >= model.a[1, 1])
    results = pyo.SolverFactory("appsi_highs").solve(model)
    assert octmip.solution_of(model, results).tree.feature == 1
    model.use.setub(0)  # not solved again
    with pytest.raises(SolverError, match=r"break use in \[0, 0\]"):
        octmip.solution_of(model, results)
