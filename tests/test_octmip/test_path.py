"""The penalty path: every tree is an optimum of its interval, none is missed, and what is unproven says so."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from octmip import ClassCosts, Limits, Problem, Solution, Stop, certify
from octmip.errors import ProblemError
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.methods.options import SearchOptions
from octmip.trees.nodes.tree import complexity
from octmip.trees.runs.registry import Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff import path as paths
from octmip.trees.tradeoff import trace_path
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem
from tests.test_octmip.test_mip import blobs

WEIGHTED = blobs(depth=2, weights=[1, 9, 2, 1, 1, 5, 9, 1, 3, 1, 2, 6])
FAR = np.abs(np.subtract.outer(np.arange(3), np.arange(3))) * 20.0
RNG = np.random.default_rng(1)
COSTLY = Problem(RNG.integers(0, 6, (14, 2)).astype(float), RNG.integers(0, 3, 14), depth=2, loss=ClassCosts(FAR))


@pytest.mark.parametrize("method", ["exact", "flow", "oct"])
@pytest.mark.parametrize("problem", [WEIGHTED, COSTLY], ids=["weights", "costs"])
def test_each_tree_is_the_optimum_wherever_it_is_said_to_be(method, problem):
    path = trace_path(problem, method=method)
    assert len(path.trees) >= 3
    assert path.is_whole
    for best_tree in path.trees:
        high = best_tree.penalty_high if math.isfinite(best_tree.penalty_high) else best_tree.penalty_low + 5
        for penalty in (best_tree.penalty_low, best_tree.penalty, 0.01 * best_tree.penalty_low + 0.99 * high):
            best = optimum(problem.replace(leaf_penalty=penalty)).objective
            assert best_tree.cost + penalty * best_tree.complexity == pytest.approx(best)
            assert path.bound_at(penalty) <= best + 1e-9
        assert best_tree.cost == problem.objective(best_tree.tree)
        assert best_tree.complexity == complexity(best_tree.tree)
        assert best_tree.is_proven


@pytest.mark.parametrize("seed", range(12))
def test_no_tree_that_is_best_for_some_penalty_is_missed_with_weights_costs_leaf_sizes_and_budgets(seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, max_samples=8, max_depth=2)
    path = trace_path(problem, method="exact")
    assert all(best_tree.is_proven for best_tree in path.trees)
    assert path.n_solves <= 2 * len(path.trees) + 1
    for penalty in rng.uniform(0, 1.2, 12) * problem.baseline:
        here, best = path.best_at(penalty), optimum(problem.replace(leaf_penalty=penalty))
        assert here.cost + penalty * here.complexity == pytest.approx(best.objective)
        certify(
            problem.replace(leaf_penalty=0.0),
            Solution(here.tree, here.cost, -math.inf, Stop.FINISHED, 0, 0, "", "", 0),
        )


@pytest.mark.parametrize("method", ["cart", "search"])
def test_a_search_claims_no_more_than_a_proof_shows(method):
    path = trace_path(blobs(depth=2), method=method)
    assert path.is_whole
    exact = trace_path(blobs(depth=2), method="exact")
    said, shown = ({(c.cost, c.complexity) for c in one.trees if c.is_proven} for one in (path, exact))
    assert said <= shown  # by its labels: a leaf at a price above what a split saves
    for penalty in (0.0, 0.5, 1.0, 3.0, 9.0):
        here, best = path.best_at(penalty), exact.best_at(penalty)
        assert here.cost + penalty * here.complexity >= best.cost + penalty * best.complexity
        assert path.bound_at(penalty) <= best.cost + penalty * best.complexity


def test_splits_over_several_features_are_paid_for_by_the_feature():
    for options in ({"method": "search"}, {"method": "oct_h", "most_solves": 2, "limits": Limits(seconds=5)}):
        path = trace_path(blobs(9, depth=1, split="hyperplane"), **options)
        assert [best_tree.complexity for best_tree in path.trees] == [1, 0]
        assert all(best_tree.complexity == complexity(best_tree.tree) for best_tree in path.trees)


def test_trees_that_are_known_are_not_lost():
    deep = trace_path(blobs(depth=2), method="exact")
    known = [best_tree.tree for best_tree in deep.trees]
    poor = trace_path(blobs(depth=2), method="cart", incumbents=known)
    assert [c.cost for c in poor.trees] == [c.cost for c in deep.trees]


def test_a_path_that_is_cut_short_says_so_and_proves_only_what_it_saw():
    path = trace_path(WEIGHTED, method="exact", most_solves=2)
    assert not path.is_whole
    assert path.n_solves == 2
    assert not all(best_tree.is_proven for best_tree in path.trees)
    cut = trace_path(WEIGHTED, method="flow", most_solves=1)
    assert not cut.is_whole
    assert cut.bounds == ()
    assert not any(c.is_proven for c in cut.trees)


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
def test_a_tree_is_proven_at_any_size_of_weights_only_where_its_bound_meets_it(size, monkeypatch):
    problem = blobs(depth=2).replace(weights=np.full(len(blobs(depth=2).samples.codes), size))
    assert all(best_tree.is_proven for best_tree in trace_path(problem, method="exact").trees)

    def half_proven(problem, *args):
        solution = solve_run(problem, *args)
        return replace(solution, bound=(1 - 1e-11) * solution.bound, stop=Stop.TIME)

    monkeypatch.setattr(paths, "solve_run", half_proven)
    path = trace_path(problem, method="exact")
    assert not any(best_tree.is_proven for best_tree in path.trees if best_tree.cost)


def test_ctrl_c_ends_the_path_with_what_is_known(monkeypatch):
    def interrupted(problem, *args):
        return replace(solve_run(problem, *args), stop=Stop.INTERRUPTED)

    monkeypatch.setattr(paths, "solve_run", interrupted)
    path = trace_path(WEIGHTED, method="exact")
    assert path.is_interrupted
    assert not path.is_whole
    assert path.n_solves == 1
    assert len(path.trees) == 2


@pytest.mark.parametrize(
    ("ask", "sentence"),
    [
        (lambda: trace_path(WEIGHTED, most_solves=0), "most_solves is 0"),
        (lambda: trace_path(WEIGHTED, method="magic"), "method is 'magic'"),
        (lambda: trace_path(WEIGHTED, method="cart").best_at(-1.0), r"penalty is -1\.0"),
        (lambda: trace_path(WEIGHTED, method="cart", options=SearchOptions(restarts=1)), "takes no option 'restarts'"),
    ],
)
def test_a_path_that_cannot_be_asked_for_is_refused(ask, sentence):
    with pytest.raises(ProblemError, match=sentence):
        ask()


def test_a_tree_is_proven_for_an_interval_only_where_it_is_at_both_ends(monkeypatch):
    """The proof without a penalty is whole; at the penalty of the next tree the search ended without one."""

    def solved(problem, run, start):
        solution = solve_run(problem, run, start)
        is_free = problem.shape.leaf_penalty == 0
        return solution if is_free else replace(solution, bound=0.0, stop=Stop.TIME, tolerance=0.0)

    problem = Problem([[0.0], [1.0], [2.0]], [0, 1, 1], depth=1)
    assert all(tree.is_proven for tree in trace_path(problem, method="exact").trees)
    monkeypatch.setattr(paths, "solve_run", solved)
    largest = trace_path(problem, method="exact").trees[0]
    assert (largest.penalty_low, largest.penalty_high, largest.is_proven) == (0.0, 1.0, False)


@pytest.mark.parametrize("by_impurity", [False, True])
def test_prunings_end_when_the_time_is_up(by_impurity):
    rng = np.random.default_rng(3)
    problem = Problem(rng.normal(size=(300, 3)), rng.integers(0, 2, 300), depth=30)
    grown = greedy_tree(problem)
    trace = partial(paths.trace_impurity if by_impurity else paths.trace_run, problem, grown=grown)
    whole, hurried = (trace(Run("cart", Limits(seconds=seconds))) for seconds in (math.inf, 0.0))
    assert whole.is_whole
    assert not hurried.is_whole
    assert len(hurried.trees) < len(whole.trees)
