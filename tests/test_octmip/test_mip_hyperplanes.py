"""Hyperplane formulations against the enumeration of every whole-numbered hyperplane, and against each other."""

import numpy as np
import pytest

from octmip import HyperplaneSplit, Leaf, Problem, Split, certify, solve
from octmip.trees.methods.options import MipOptions
from octmip.trees.mip import flow, oct_h
from octmip.trees.mip.blocks.heap import Heap, place, to_tree
from octmip.trees.mip.blocks.hyperplanes import choose_mu, space_of
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.incumbent import canonicalise
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.nodes.tree import predict
from octmip.trees.question.losses import ClassCosts
from tests.oracles.rational import least_cost

SOLVERS = {
    "oct_h": solve_oct_h,
    "flow": solve_flow,
}


def whole(n: int = 9, p: int = 2, **options: object) -> Problem:
    """Return a small problem of decimal features, three classes, whole coefficients up to 2."""
    rng = np.random.default_rng(8)
    options = {"depth": 1, "split": "hyperplane", "integer_normals": 2} | options
    return Problem(np.round(rng.normal(size=(n, p)), 1), rng.integers(0, 3, n), class_names=(0, 1, 2), **options)


CASES = {
    "depth 1": whole(),
    "depth 2": whole(depth=2),
    "three features": whole(p=3, integer_normals=1),
    "weights": whole(weights=[1, 2, 0, 3, 1, 1, 2, 5, 1]),
    "real weights": whole(weights=0.1 + 0.3 * np.arange(9)),
    "costs": whole(loss=ClassCosts([[0, 5, 1], [2, 1, 9], [3, 4, 0]])),
    "leaf size": whole(leaf_size=3),
    "penalty": whole(leaf_penalty=0.75),
    "split size": whole(p=3, split_size=2, integer_normals=1),
    "allowed splits": whole(p=3, allowed_splits=[["x0", "x1"], ["x2"]], integer_normals=1),
    "budget": whole(p=3, sensor_budget=2.0, sensor_cost=[1.0, 1.0, 2.0], integer_normals=1),
    "budget at depth 2": whole(depth=2, sensor_budget=1.0, integer_normals=1),
    "one feature": whole(depth=2, split_size=1),
    "constant feature": Problem(
        [[1, 2], [1, 3], [1, 4], [1, 1]], [0, 1, 0, 1], depth=2, split="hyperplane", integer_normals=1
    ),
}


@pytest.mark.parametrize("method", SOLVERS)
@pytest.mark.parametrize("case", CASES)
def test_the_optimum_is_that_of_enumeration(method, case):
    problem = CASES[case]
    solution = SOLVERS[method](problem)
    certify(problem, solution)
    assert solution.objective == pytest.approx(float(least_cost(problem)), abs=1e-6)
    assert solution.is_optimal
    assert solution.details["start"]["accepted"], solution.details["start"]


TREES = [
    HyperplaneSplit((0, 1), (1.0, -2.0), 0.35, Leaf(0), Leaf(1)),
    HyperplaneSplit((0, 1), (2.0, 1.0), 0.05, Split(1, 0.15, Leaf(2), Leaf(0)), Leaf(1)),
    Split(0, -0.25, Leaf(1), HyperplaneSplit((0, 1), (1.0, 1.0), 0.25, Leaf(2), Leaf(0))),
]


@pytest.mark.parametrize("tree", TREES)
@pytest.mark.parametrize("integer_normals", [2, None])
@pytest.mark.parametrize("form", ["oct_h", "flow"])
def test_a_tree_encoded_is_feasible_costs_its_objective_and_decodes_to_the_same_sides(tree, integer_normals, form):
    problem = whole(depth=2, integer_normals=integer_normals)
    tree = canonicalise(problem, tree)
    heap = Heap(2)
    placed = place(tree, heap, problem.samples.features)
    mu = choose_mu(space_of(problem, centred=False), placed, heap)
    model = oct_h.encode(problem, mu) if form == "oct_h" else flow.encode(problem, tree)
    values = model.start(placed)
    assert model.rows.violation(values)[0] < 1e-9
    assert model.rows.objective(values) == pytest.approx(problem.objective(tree))
    decoded = to_tree(heap, model.splits(values), model.labels(values))
    assert problem.objective(decoded) == problem.objective(tree)


@pytest.mark.parametrize(("offset", "side"), [(0.5, 0), (0.0, 1)])
def test_a_normal_of_nothing_but_zeros_sends_everything_one_way(offset, side):
    problem = whole(integer_normals=None)
    model = oct_h.encode(problem, 1e-3)
    values = np.zeros(model.rows.n_columns)
    values[model.hyperplanes.d] = values[model.hyperplanes.s[0]] = 1.0
    values[model.hyperplanes.b] = offset  # the solver may choose it: 0'x + mu <= b holds for every sample, or for none
    decoded = to_tree(Heap(1), model.splits(values), {2: 0, 3: 1})
    assert (predict(decoded, problem.samples.features) == side).all()


def test_real_normals_are_no_worse_than_whole_ones_and_both_forms_agree():
    problem = whole(depth=1, integer_normals=None)
    printed, strong = solve_oct_h(problem), solve_flow(problem)
    assert printed.objective == strong.objective <= float(least_cost(whole(depth=1)))
    assert "mu-separated" in printed.details["scope"]
    assert printed.details["mu"] == strong.details["mu"]


def narrow_problem():
    """Return a problem whose best line passes between readings closer than a margin of 0.005: 2 errors, with it 3."""
    rng = np.random.default_rng(0)
    features = rng.random((12, 2))
    features[6:] = features[:6] + rng.normal(size=(6, 2)) * 2e-3
    labels = rng.integers(0, 2, 12)
    labels[:2] = 0, 1
    return Problem(features, labels, depth=1, split="hyperplane")


@pytest.mark.parametrize("solver", [solve_oct_h, solve_flow])
def test_what_is_proven_of_mu_separated_trees_stays_where_a_narrower_tree_is_better(solver):
    problem = narrow_problem()
    narrow = solve(problem, "exact")
    solution = solver(problem, incumbent=narrow.tree, options=MipOptions(mu=0.005))
    certify(problem, solution)
    assert solution.objective == solution.bound == narrow.objective == 2
    assert solution.details["bound_in_scope"] == 3
    assert "mu-separated" in solution.details["scope"]
    words = "(none of them costs less than 3; the tree found, of 2, is a better one outside)"
    assert solution.details["scope"].endswith(words)
    assert "numerics" not in solution.details


@pytest.mark.parametrize("method", ["oct_h", "flow"])
def test_a_proof_within_a_margin_is_carried_to_all_trees_where_splits_have_two_features(method):
    problem = narrow_problem()
    solution = solve(problem, method, options=MipOptions(mu=0.005))
    certify(problem, solution)
    assert solution.is_optimal
    assert solution.objective == solution.bound == 2
    assert solution.details["bound_in_scope"] == 3
    three = Problem(np.c_[problem.samples.features, np.ones(12)], problem.samples.codes, depth=1, split="hyperplane")
    assert "mu-separated" in solve(three, method, options=MipOptions(mu=0.005)).scope


def test_strictness_is_exact_for_decimal_features_and_whole_coefficients():
    assert space_of(whole()).is_exact
    rng = np.random.default_rng(0)
    fine = Problem(rng.normal(size=(9, 2)), np.arange(9) % 2, depth=1, split="hyperplane", integer_normals=2)
    assert not space_of(fine).is_exact
    solution = solve_flow(fine)
    certify(fine, solution)
    assert "mu-separated" in solution.details["scope"]
