"""Without a solver: trees into solutions and back."""

import numpy as np
import pytest

from octmip.trees.answer.certificate import first_forbidden_split
from octmip.trees.encoding import rank_features, rows_from_tree, tree_from_rows
from octmip.trees.mip import flow, oct
from octmip.trees.mip.blocks.heap import place, to_tree
from octmip.trees.mip.incumbent import canonicalise
from octmip.trees.nodes.tree import Leaf
from tests.oracles.strategies import random_problem, random_tree


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
