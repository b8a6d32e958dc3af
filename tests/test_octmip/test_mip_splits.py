"""`max_splits` holds for every method that takes it: in the start, in the trees found, and on every way out."""

from dataclasses import replace

import numpy as np
import pytest

from octmip import Leaf, Limits, Problem, Split, Stop, certify, solve
from octmip.errors import SolverError
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.incumbent import pruned, starting_tree
from octmip.trees.mip.oct import solve_oct
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.nodes.tree import HyperplaneSplit, Node, complexity
from octmip.trees.runs import solver_call
from tests.oracles.strategies import random_problem

METHODS = {"oct": solve_oct, "flow": solve_flow}
STAIRS = Split(0, 0.5, Leaf(0), Split(0, 1.5, Leaf(1), Split(0, 2.5, Leaf(0), Leaf(1))))


def stairs(**options: object) -> Problem:
    """Return five samples on a line, the labels of which need three splits."""
    return Problem([[0.0], [1.0], [2.0], [3.0], [3.0]], [0, 1, 0, 1, 1], depth=3, **options)


def random(seed: int, **options: object) -> Problem:
    """Return a problem whose best tree of depth 2 has three splits."""
    rng = np.random.default_rng(seed)
    labels = rng.integers(0, 3, 12)
    labels[:2] = 0, 1
    return Problem(rng.normal(size=(12, 2)), labels, depth=2, class_names=(0, 1, 2), **options)


def prunings(problem: Problem, node: Node) -> list[Node]:
    """Return every way to put leaves in place of splits."""
    cut = [Leaf(label) for label in range(problem.samples.n_classes)]
    if isinstance(node, Leaf):
        return cut
    sides = [prunings(problem, side) for side in (node.left, node.right)]
    return cut + [replace(node, left=left, right=right) for left in sides[0] for right in sides[1]]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(3))
def test_one_split_is_the_best_stump_and_two_are_two_at_most(method, seed):
    problem = random(seed)
    one = METHODS[method](problem.replace(max_splits=1))
    assert complexity(one.tree) <= 1
    assert one.objective == one.bound == solve(problem.replace(depth=1), "exact").objective
    assert one.stop is Stop.OPTIMAL
    assert one.details["scope"] == "all axis-aligned trees, of depth 2 or less, with at most 1 split"
    two = METHODS[method](problem.replace(max_splits=2))
    certify(problem, two)
    assert complexity(two.tree) <= 2
    assert two.is_optimal
    assert solve(problem, "exact").objective <= two.objective <= one.objective


@pytest.mark.parametrize("seed", range(2))
def test_features_of_hyperplanes_are_counted_one_by_one(seed):
    problem = random(seed, split="hyperplane")
    for method in ("oct_h", "flow"):
        solution = solve(problem.replace(max_splits=1), method)
        certify(problem, solution)
        assert complexity(solution.tree) <= 1
        assert solution.details["scope"].endswith("with at most 1 feature in all splits")


@pytest.mark.parametrize("seed", [*range(4), *range(5, 12)])  # the tree of seed 4 has too many prunings to list
def test_a_tree_is_pruned_to_the_best_of_all_its_prunings(seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, max_samples=9, max_depth=3)
    tree = solve(problem.replace(leaf_penalty=0.0), "exact").tree
    priced = [(complexity(t), problem.objective(t)) for t in [*prunings(problem, tree), tree]]
    for most in range(complexity(tree) + 2):
        found = pruned(problem, tree, most)
        assert complexity(found) <= most
        if most < complexity(tree):
            least = min(objective for n_splits, objective in priced if n_splits <= most)
            assert problem.objective(found) == pytest.approx(least)
        else:
            assert found is tree


def test_a_hyperplane_that_is_too_wide_goes_and_a_narrow_one_below_it_goes_with_it():
    problem = random(0).replace(split="hyperplane")
    tree = HyperplaneSplit((0, 1), (1.0, 1.0), 0.0, Split(0, 0.0, Leaf(0), Leaf(1)), Leaf(2))
    assert complexity(pruned(problem, tree, 2)) in (0, 2)
    assert pruned(problem, tree, 1) == Leaf(int(problem.class_costs().argmin()))


@pytest.mark.parametrize("given", [solve_oct, solve_flow, solve_oct_h])
def test_a_start_with_too_many_splits_is_pruned_whoever_is_called(given):
    problem = stairs(split="hyperplane" if given is solve_oct_h else "axis")
    solution = given(problem.replace(max_splits=1), incumbent=STAIRS, limits=Limits(seconds=0.0))
    certify(problem, solution)
    assert complexity(solution.tree) <= 1
    assert solution.objective == 1


def test_a_tree_of_more_splits_is_never_returned(monkeypatch):
    monkeypatch.setattr(solver_call, "fitting", lambda problem, solution: solution)
    with pytest.raises(SolverError, match="the tree has 3 splits but max_splits is 1"):
        solve(stairs().replace(max_splits=1), "search")


def test_a_start_that_does_not_pay_its_splits_is_the_best_leaf():
    dear = stairs(leaf_penalty=50.0, max_splits=3)
    leaf = Leaf(int(dear.class_costs().argmin()))
    assert starting_tree(dear, STAIRS, 0) == leaf
    assert starting_tree(stairs(), STAIRS, 0) != leaf
