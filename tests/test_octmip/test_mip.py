"""Every formulation against exhaustive enumeration, known optima, and what HiGHS must not be believed."""

import re
from functools import partial

import numpy as np
import pytest
from sklearn.datasets import load_iris

from octmip import Leaf, Limits, Problem, Stop, certify
from octmip.trees.answer.certificate import first_forbidden_split
from octmip.trees.encoding import rank_features, rows_from_tree, tree_from_rows
from octmip.trees.mip import engine, flow, oct
from octmip.trees.mip.blocks.heap import place, to_tree
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.highs import highs
from octmip.trees.mip.incumbent import canonicalise
from octmip.trees.mip.oct import encode, solve_oct
from octmip.trees.question.losses import ClassCosts
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem, random_tree

SOLVERS = {"oct": solve_oct, "flow": solve_flow}


def iris(**options: object) -> Problem:
    return Problem(*load_iris(return_X_y=True), **options)


def blobs(n: int = 12, **options: object) -> Problem:
    """Return a small problem of three overlapping classes."""
    rng = np.random.default_rng(3)
    labels = np.arange(n) % 3
    return Problem(np.round(rng.normal(size=(n, 2)) + labels[:, None], 1), labels, **options)


CASES = {
    "depth 1": blobs(depth=1),
    "depth 2": blobs(depth=2),
    "weights": blobs(depth=2, weights=np.arange(12) % 4),
    "real weights": blobs(depth=2, weights=0.1 + 0.3 * np.arange(12)),
    "costs": blobs(depth=2, loss=ClassCosts(np.abs(np.subtract.outer(np.arange(3), np.arange(3))) * 20)),
    "lopsided costs": blobs(depth=2, loss=ClassCosts([[0, 5, 1], [2, 1, 9], [3, 4, 0]])),
    "leaf size": blobs(depth=2, leaf_size=3),
    "penalty": blobs(depth=2, leaf_penalty=2.0),
    "steep penalty": blobs(depth=2, leaf_penalty=50.0),
    "budget": blobs(depth=2, sensor_budget=1.0, sensor_cost={"x0": 1.0, "x1": 0.5}),
    "no budget at all": blobs(depth=2, sensor_budget=0.0),
    "one feature allowed": blobs(depth=2, allowed_splits=[["x1"]]),
    "constant feature": Problem([[1, 2], [1, 3], [1, 4], [1, 1]], [0, 1, 0, 1], depth=2),
    "duplicates that disagree": Problem([[1], [1], [1], [2], [2]], [0, 1, 1, 0, 0], depth=2),
}


@pytest.mark.parametrize("method", SOLVERS)
@pytest.mark.parametrize("case", CASES)
def test_the_optimum_is_that_of_enumeration(method, case):
    problem = CASES[case]
    solution = SOLVERS[method](problem)
    certify(problem, solution)
    assert solution.objective == pytest.approx(optimum(problem).objective, abs=1e-6)
    assert solution.stop is Stop.OPTIMAL
    assert solution.is_optimal
    assert solution.details["start"]["accepted"], solution.details["start"]


@pytest.mark.parametrize("case", CASES)
def test_the_optimum_stays_without_fixing_and_without_class_counts(case):
    problem = CASES[case]
    for fix, class_count in ((0, True), (2, False)):
        solution = engine.solver_of("flow", partial(flow.formulate, fix=fix, class_count=class_count))(problem)
        assert solution.objective == pytest.approx(optimum(problem).objective, abs=1e-6)
        assert solution.is_optimal


@pytest.mark.parametrize(("depth", "errors"), [(1, 50), (2, 6)])
def test_strengthened_rows_prove_iris(depth, errors):
    problem = iris(depth=depth)
    solution = solve_flow(problem)
    assert (solution.objective, solution.bound, certify(problem, solution).errors) == (errors, errors, errors)


def test_the_printed_form_leaks_at_unsplit_nodes_and_the_closed_form_does_not():
    problem = iris(depth=2)
    spread = {}
    for closed in (False, True):
        model = encode(problem, closed=closed)
        values = np.zeros(model.rows.n_columns)
        # Each class in a leaf of its own, no node split.
        values[model.leaves.z[np.arange(150), problem.samples.codes]] = 1
        for t in range(3):
            values[model.leaves.l[t]] = values[model.leaves.c[t, t]] = 1
            values[model.leaves.N_kt[t, t]] = values[model.leaves.N_t[t]] = 50
        assert model.rows.objective(values) == 0
        spread[closed] = model.rows.violation(values)[0]
    assert spread[False] == 0.0
    assert spread[True] > 0.005


@pytest.mark.parametrize(("costs", "said"), [
    ([[0, 1], [1, 0]], (2.0, 0.25, 1.5 / 2)),
    ([[0, 0], [1, 0]], (0.0, None, None)),
])  # fmt: skip
def test_the_form_of_bertsimas_and_dunn_is_told(costs, said):
    problem = Problem([[0.0], [1.0], [2.0], [2.0]], [0, 1, 0, 1], depth=1, loss=ClassCosts(costs), leaf_penalty=0.5)
    details = solve_oct(problem).details
    assert tuple(details[name] for name in ("baseline", "alpha", "normalised_objective")) == said


def test_a_solution_that_routing_contradicts_is_refused():
    problem = blobs(depth=2)
    decoded = engine.Decoded(price=7.0, tree=Leaf(0))
    assert "claims objective 6" in engine.refutation(problem, outcome_of(6, 6), 5, decoded)
    assert "no tree is below 8" in engine.refutation(problem, outcome_of(7, 7), 8, decoded)
    assert "claims objective 6 but its own solution has 7" in engine.refutation(problem, outcome_of(7, 6), 6, decoded)
    assert engine.refutation(problem, outcome_of(7, 7), 6, decoded) == ""


def outcome_of(objective: float, claimed: float) -> highs.Outcome:
    """Return the outcome of a run whose solution has an objective and is claimed to have one."""
    return highs.Outcome(None, objective, claimed, claimed, Stop.OPTIMAL, "kOptimal", 1, 0.0, claimed, claimed)


@pytest.mark.long
def test_what_a_leaking_model_claims_is_not_believed_and_said_with_both_numbers():
    problem = iris(depth=2)
    solution = engine.solve_formulation(
        problem, lambda *_: encode(problem, closed=False), engine.Request("oct", Limits(seconds=300))
    )
    certify(problem, solution)
    assert solution.stop is Stop.NUMERICS
    assert solution.bound == 0 < solution.objective <= 10
    assert re.search(r"claims objective .* but its tree costs", solution.details["numerics"])


def test_a_time_limit_returns_the_start_and_an_honest_bound():
    problem = iris(depth=2)
    solution = solve_oct(problem, limits=Limits(seconds=0.5))
    certify(problem, solution)
    assert solution.stop is Stop.TIME
    assert solution.bound < 6 == solution.objective


def test_any_whole_number_is_a_seed():
    assert solve_oct(iris(depth=1), seed=2**31 + 5).objective == 50


def test_a_node_limit_stops():
    solution = solve_oct(iris(depth=1), limits=Limits(nodes=2))
    assert solution.stop is Stop.NODES
    assert 0 < solution.details["build_seconds"] < solution.seconds


def test_a_gap_that_is_reached_stops_and_says_so():
    solution = solve_oct(iris(depth=1), limits=Limits(gap=0.9), incumbent=Leaf(0))
    assert solution.stop in (Stop.GAP, Stop.OPTIMAL)
    assert solution.gap <= 0.9


def test_what_progress_raises_comes_out():
    def fail(state):
        raise ValueError("no progress bar here")

    with pytest.raises(ValueError, match="no progress bar"):
        solve_oct(blobs(depth=2), limits=Limits(seconds=60), progress=fail)


def test_highs_says_nothing_on_standard_output(capfd):
    solve_oct(blobs(depth=2))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("seed", range(100, 105))
def test_fixing_never_takes_away_the_optimum_at_depth_three(seed):
    problem = random_problem(np.random.default_rng(seed), max_samples=8, max_features=2, max_depth=3)
    worst = Leaf(int(problem.class_costs().argmin()))
    for fix in (1, 2):
        solution = engine.solver_of("flow", partial(flow.formulate, fix=fix))(problem, incumbent=worst)
        certify(problem, solution)
        assert solution.objective == pytest.approx(optimum(problem).objective, rel=1e-6, abs=1e-6)
        assert solution.is_optimal


@pytest.mark.parametrize("encode", [oct.encode, lambda problem: flow.encode(problem, Leaf(0), fix=0)])
@pytest.mark.parametrize("seed", range(15))
def test_a_tree_encoded_is_feasible_costs_its_objective_and_decodes_to_itself(encode, seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, max_samples=10, max_depth=3)
    samples = problem.samples
    tree = canonicalise(problem, random_tree(rng, samples.n_features, samples.n_classes, problem.shape.depth))
    if problem.shape.sensor_cost_of(tree) > problem.shape.sensor_limit or first_forbidden_split(problem, tree):
        tree = Leaf(int(problem.class_costs().argmin()))
    ranks = rank_features(problem)
    tree = tree_from_rows(rows_from_tree(tree, ranks), ranks)  # thresholds at the midpoints of the data
    model = encode(problem)
    placed = place(tree, model.heap, problem.samples.features)
    sizes = np.bincount(placed.position)
    values = model.start(placed)
    worst, where = model.rows.violation(values)
    assert (worst < 1e-9) == (sizes[sizes > 0].min() >= problem.shape.leaf_size), where
    assert model.rows.objective(values) == pytest.approx(problem.objective(tree))
    decoded = to_tree(model.heap, model.splits(values), model.labels(values))
    assert canonicalise(problem, decoded) == tree
