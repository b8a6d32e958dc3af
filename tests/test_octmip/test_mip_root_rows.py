"""Rows of Benders at the root of OCT: no best tree is lost, and all rows together close the gap."""

import highspy
import numpy as np
import pytest

from octmip import Problem, Stop, certify, solve
from octmip.trees.methods.options import OctOptions
from octmip.trees.mip import oct
from octmip.trees.mip.benders.root_rows import root_bounds
from octmip.trees.mip.blocks.heap import place
from octmip.trees.mip.highs import highs, worker
from octmip.trees.mip.prices import whole_prices
from octmip.trees.question.losses import ClassCosts
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem
from tests.test_octmip.test_mip_benders import mixed

SHAPES = [
    {"depth": 2},
    {"depth": 3},
    {"depth": 2, "leaf_size": 9},
    {"depth": 2, "leaf_penalty": 3.0},
    {"depth": 2, "sensor_budget": 1},
    {"depth": 2, "sensor_budget": 2},
    {"depth": 2, "sensor_budget": 3, "sensor_cost": [1.0, 2.0, 2.0]},
    {"depth": 2, "loss": ClassCosts([[0, 1, 2], [1, 0, 1], [2, 1, 0]])},
    {"depth": 2, "allowed_splits": [[0], [2]]},
    {"depth": 1},
    {"depth": 2, "max_splits": 2},
]

ALL = 10**6


def relaxation(problem: Problem, n_subproblems: int | None) -> float:
    """Return the value of OCT's linear relaxation, in the problem's units; as printed where `n_subproblems` is None."""
    tree = solve(problem, "cart").tree
    prices = whole_prices(problem, problem.objective(tree))
    root = None if n_subproblems is None else root_bounds(problem, prices, tree, n_subproblems).bounds
    solver = worker.load(highs.arrays(oct.encode(problem, prices=prices, root=root).rows))
    solver.setOptionValue("solve_relaxation", True)
    solver.setOptionValue("solver", "ipm")
    solver.run()
    assert solver.getModelStatus() == highspy.HighsModelStatus.kOptimal
    return prices.true(solver.getInfo().objective_function_value)


def test_oct_with_the_rows_has_the_optimum_of_enumeration():
    for seed in range(12):
        problem = random_problem(np.random.default_rng(8100 + seed), max_samples=8, max_features=2)
        if problem.shape.split != "axis":
            continue
        for n_subproblems in (0, ALL):
            found = solve(problem, "oct", options=OctOptions(root_rows=n_subproblems))
            certify(problem, found)
            assert found.objective == pytest.approx(optimum(problem).objective, rel=1e-12), seed
            assert found.bound <= found.objective


@pytest.mark.parametrize("options", SHAPES)
def test_the_best_tree_is_one_of_the_model_and_its_relaxation_lies_below(options):
    problem = mixed(40, 3, 3, 1, **options)
    best = solve(problem, "exact")
    prices = whole_prices(problem, best.objective)
    model = oct.encode(problem, prices=prices, root=root_bounds(problem, prices, best.tree, ALL).bounds)
    values = model.start(place(best.tree, model.heap, problem.samples.features))
    worst, where = model.rows.violation(values)
    assert worst < 1e-7, where
    value = relaxation(problem, ALL)
    assert value <= best.objective + 1e-6
    if "max_splits" not in options:  # the rows are about trees of any number of splits
        assert value == pytest.approx(best.objective)


def test_more_subproblems_close_more_of_the_gap():
    problem = mixed(60, 4, 3, 5, depth=2)
    values = [relaxation(problem, n_subproblems) for n_subproblems in (None, 0, 8, ALL)]
    assert values[0] == pytest.approx(0.0)
    assert values == sorted(values)
    assert values[-1] == pytest.approx(solve(problem, "exact").objective)


def test_the_subproblems_tree_is_the_start():
    problem = mixed(40, 3, 3, 19, depth=2)
    assert solve(problem, "cart").objective > solve(problem, "exact").objective  # what HiGHS would start from
    found = solve(problem, "oct", options=OctOptions(root_rows=ALL))
    assert found.stop is Stop.OPTIMAL
    assert found.details["start"]["accepted"]
    assert found.details["root_bound"] == pytest.approx(found.objective)


def test_a_root_without_a_split_is_a_tree_of_the_model():
    problem = Problem([[1.0], [2.0], [3.0]], [0, 1, 0], depth=2, leaf_penalty=2.0)
    found = solve(problem, "oct", options=OctOptions(root_rows=ALL))
    assert (found.objective, found.bound, found.stop) == (1.0, 1.0, Stop.OPTIMAL)
