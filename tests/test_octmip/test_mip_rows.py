"""Without a solver: rows against the Pyomo model of the paper, and trees into solutions and back."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pyomo.environ as pyo
import pytest
from pyomo.repn import generate_standard_repn

from benchmarks.oracles.paper_models import oct as paper
from benchmarks.oracles.strategies import random_problem, random_tree
from octmip.trees.certificate import first_forbidden_split
from octmip.trees.encoding import rank_features, rows_from_tree, tree_from_rows
from octmip.trees.mip import flow, oct
from octmip.trees.mip.blocks.heap import Heap, place, to_tree
from octmip.trees.mip.incumbent import canonicalise
from octmip.trees.mip.rows import Rows
from octmip.trees.tree import Leaf, Split
from tests.test_octmip.test_mip import CASES


def canonical(terms: dict[str, float], low: float, high: float) -> tuple[object, ...]:
    """Return a row without its scale: terms by name, the first coefficient 1."""
    (first, *_) = sorted(terms)
    scale = terms[first]
    low, high = (low, high) if scale > 0 else (high, low)
    named = tuple((name, round(terms[name] / scale, 9)) for name in sorted(terms))
    return named, round(low / scale, 9) + 0.0, round(high / scale, 9) + 0.0


def rows_of(rows: Rows) -> Counter:
    """Return the rows of an array model, in no order and without scale."""
    matrix, names, (low, high) = rows.matrix(), rows.column_names(), rows.row_bounds
    found = Counter()
    for i in range(rows.n_rows):
        span = slice(matrix.indptr[i], matrix.indptr[i + 1])
        terms = {names[j]: v for j, v in zip(matrix.indices[span], matrix.data[span], strict=True)}
        found[canonical(terms, low[i], high[i])] += 1
    return found


def rows_of_pyomo(model: pyo.ConcreteModel) -> Counter:
    """Return the rows of a Pyomo model, in no order and without scale."""
    found = Counter()
    for row in model.component_data_objects(pyo.Constraint):
        body = generate_standard_repn(row.body)
        terms = {v.name: c for v, c in zip(body.linear_vars, body.linear_coefs, strict=True) if c != 0}
        low = -np.inf if row.lower is None else pyo.value(row.lower) - body.constant
        high = np.inf if row.upper is None else pyo.value(row.upper) - body.constant
        found[canonical(terms, low, high)] += 1
    return found


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("case", CASES)
def test_the_rows_are_those_of_the_pyomo_model(case, closed):
    problem = CASES[case]
    model = paper.paper_model(problem, closed=closed, max_splits=2)
    rows = oct.encode(replace(problem, max_splits=2), closed=closed).rows
    assert rows_of(rows) == rows_of_pyomo(model)
    cost = generate_standard_repn(model.cost.expr)
    theirs = {v.name: c for v, c in zip(cost.linear_vars, cost.linear_coefs, strict=True) if c != 0}
    assert theirs == {n: c for n, c in zip(rows.column_names(), rows.cost, strict=True) if c != 0}
    columns = {v.name: v for v in model.component_data_objects(pyo.Var)}
    for name, low, high, whole in zip(rows.column_names(), rows.lower, rows.upper, rows.is_integer, strict=True):
        upper = np.inf if columns[name].ub is None else columns[name].ub
        assert (columns[name].lb, upper, columns[name].is_binary()) == (low, high, whole), name


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
    assert worst < 1e-9 or sizes[sizes > 0].min() < problem.leaf_size, where
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
