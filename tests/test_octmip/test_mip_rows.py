"""Without a solver: trees into solutions and back."""

import numpy as np
import pytest

from octmip.trees.certificate import first_forbidden_split
from octmip.trees.encoding import rank_features, rows_from_tree, tree_from_rows
from octmip.trees.mip import flow, oct
from octmip.trees.mip.blocks.heap import Heap, place, to_tree
from octmip.trees.mip.incumbent import canonicalise
from octmip.trees.tree import Leaf, Split
from tests.oracles.strategies import random_problem, random_tree


@pytest.mark.parametrize("encode", [oct.encode, lambda problem: flow.encode(problem, Leaf(0), fix=0)])
@pytest.mark.parametrize("seed", range(30))
def test_a_tree_encoded_is_feasible_costs_its_objective_and_decodes_to_itself(encode, seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, max_samples=10, max_depth=3)
    tree = canonicalise(problem, random_tree(rng, problem.n_features, problem.n_classes, problem.depth))
    if problem.sensor_cost_of(tree) > problem.sensor_limit or first_forbidden_split(problem, tree):
        tree = Leaf(int(problem.class_costs().argmin()))
    ranks = rank_features(problem)
    tree = tree_from_rows(rows_from_tree(tree, ranks), ranks)  # thresholds at the midpoints of the data
    model = encode(problem)
    placed = place(tree, model.heap, problem.features)
    sizes = np.bincount(placed.position)
    values = model.start(placed)
    worst, where = model.rows.violation(values)
    assert (worst < 1e-9) == (sizes[sizes > 0].min() >= problem.leaf_size), where
    assert model.rows.objective(values) == pytest.approx(problem.objective(tree))
    decoded = to_tree(model.heap, model.splits(values), model.labels(values))
    assert canonicalise(problem, decoded) == tree


def test_heap_numbers_nodes_as_pictured():
    heap = Heap(2)
    assert list(heap.branches) == [1, 2, 3]
    assert list(heap.leaves) == [4, 5, 6, 7]
    assert heap.path(6) == [(1, False), (3, True)]
    assert heap.left_ancestors(6) == [3]
    assert heap.right_ancestors(6) == [1]
    assert heap.leaves_under(3) == [2, 3]
    assert heap.leaves_under(1) == [0, 1, 2, 3]
    assert [heap.is_last_level(m) for m in heap.branches] == [False, True, True]


def test_a_leaf_above_the_last_level_sits_at_the_rightmost_leaf_below_it():
    placed = place(Split(0, 0.5, Leaf(1), Leaf(2)), Heap(2), np.array([[0.0], [1.0]]))
    assert placed.labels == {5: 1, 7: 2}
    assert placed.position.tolist() == [1, 3]
