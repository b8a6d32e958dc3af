"""What a user may do to a Pyomo model of octmip's before, while and after it is solved, and what trees it leaves.

Each way is a line of `WAYS`: it changes a model, may solve it, and returns the trees that keep the change, as a
predicate on `HeapTree` that is written from the change's meaning.
"""

import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyomo.environ as pyo
from pyomo.gdp import Disjunction

from octmip.trees.question.problem import Problem
from tests.oracles.heap_trees import HeapTree

Keeps = Callable[[HeapTree], bool]
Solve = Callable[..., Any]
Generator = np.random.Generator


def everything(tree: HeapTree) -> bool:
    """Keep every tree."""
    return True


@dataclass(frozen=True, slots=True)
class Changed:
    """A model after a way.

    Attributes
    ----------
    model, results
        to be given to `solution_of`.
    keeps
        which trees the change leaves.
    is_narrowed
        whether it forbids some; the scope must say so, and only then.
    must_refuse
        whether no tree and no bound can be said.
    may_refuse
        whether a true sentence may be all that can be said.
    """

    model: Any
    results: Any
    keeps: Keeps = everything
    is_narrowed: bool = False
    must_refuse: bool = False
    may_refuse: bool = False


Way = Callable[[Any, Problem, Generator, Solve], Changed]


def _reads(feature: int) -> Keeps:
    return lambda tree: tree.splits.get(1, (-1, 0))[0] == feature


def _root_row(M: Any, feature: int) -> Any:
    return pyo.Constraint(expr=M.a[feature, 1] == 1)


def _narrowed(M: Any, keeps: Keeps, solve: Solve, **more: bool) -> Changed:
    return Changed(M, solve(M), keeps, is_narrowed=True, **more)


def _row(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.root = _root_row(M, 0)
    return _narrowed(M, _reads(0), solve)


def _small_row(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.root = pyo.Constraint(expr=1e-3 * M.a[1, 1] >= 1e-3)
    return _narrowed(M, _reads(1), solve)


def _few_splits(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.few = pyo.ConstraintList()
    M.few.add(sum(M.d[m] for m in M.d) <= 1)
    return _narrowed(M, lambda tree: len(tree.splits) <= 1, solve)


def _one_leaf(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    i, k = sorted(rng.choice(problem.samples.n_samples, 2, replace=False).tolist())
    leaves = sorted({t for _, t in M.z})
    M.pair = pyo.Constraint(leaves, rule=lambda M, t: M.z[i, t] == M.z[k, t])
    return _narrowed(M, lambda tree: any({i, k} <= rows for rows, _ in tree.leaves.values()), solve)


def _set(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.siblings = pyo.SOSConstraint(var=M.d, index=[2, 3], sos=1)
    return _narrowed(M, lambda tree: not {2, 3} <= set(tree.splits), solve)


def _whole_threshold(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    m = int(rng.integers(1, 4))
    M.b[m].domain = pyo.Binary
    most = [len(np.unique(column)) - 1 for column in problem.samples.features.T]
    return _narrowed(M, lambda tree: m not in tree.splits or tree.splits[m][1] == most[tree.splits[m][0]], solve)


def _high_threshold(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.b[1].setlb(0.75)
    most = [len(np.unique(column)) - 1 for column in problem.samples.features.T]
    return _narrowed(M, lambda tree: 1 in tree.splits and tree.splits[1][1] >= 0.75 * most[tree.splits[1][0]], solve)


def _no_split_by_end(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.d[3].setub(0)
    return _narrowed(M, lambda tree: 3 not in tree.splits, solve)


def _fixed(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.d[2].fix(0)
    return _narrowed(M, lambda tree: 2 not in tree.splits, solve)


def _fixed_label(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    last, label = max(t for _, t in M.z), int(problem.class_costs().argmin())  # one leaf has it
    M.c[label, last].fix(1)
    return _narrowed(M, lambda tree: tree.leaves[last][1] == label, solve)


def _block(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.extra = pyo.Block()
    M.extra.root = _root_row(M, 1)
    return _narrowed(M, _reads(1), solve)


def _own_variable(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.count = pyo.Var(domain=pyo.NonNegativeIntegers, bounds=(0, 9))
    M.counted = pyo.Constraint(expr=M.count == sum(M.d[m] for m in M.d))
    M.most = pyo.Constraint(expr=M.count <= 2)
    return _narrowed(M, lambda tree: len(tree.splits) <= 2, solve)


def _disjunction(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.either = Disjunction(expr=[[M.a[0, 1] == 1], [M.d[2] + M.d[3] <= 0]])
    pyo.TransformationFactory(str(rng.choice(["gdp.bigm", "gdp.hull"]))).apply_to(M)
    return _narrowed(M, lambda tree: _reads(0)(tree) or not {2, 3} & set(tree.splits), solve)


def _inside(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    whole = pyo.ConcreteModel()
    whole.tree = M
    whole.root = _root_row(whole.tree, 0)
    return Changed(whole.tree, solve(whole), _reads(0), is_narrowed=True)


def _nothing(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    return Changed(M, solve(M))


def _unfixed(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.d[1].fix(0)
    M.d[1].unfix()
    return Changed(M, solve(M))


def _cloned(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    copy = M.clone()
    return Changed(copy, solve(copy))


def _pickled(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    copy = pickle.loads(pickle.dumps(M))
    copy.root = _root_row(copy, 0)
    return _narrowed(copy, _reads(0), solve)


def _same_objective(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.again = pyo.Objective(expr=M.cost.expr)
    M.cost.deactivate()
    return Changed(M, solve(M))


def _scaled_row(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.one_feature[0].set_value(2 * M.one_feature[0].body == 0)
    return Changed(M, solve(M), is_narrowed=True)


def _row_switched_off(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.leaf_size.deactivate()
    return Changed(M, solve(M), may_refuse=True)


def _row_gone(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.del_component(M.left)
    return Changed(M, solve(M), may_refuse=True)


def _wider_row(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    row = next(iter(M.leaf_used.values()))
    row.set_value((None, row.body, 5))
    return Changed(M, solve(M), may_refuse=True)


def _wider_domain(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.z.domain = pyo.UnitInterval
    return Changed(M, solve(M), may_refuse=True)


def _scaled_objective(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.cost.expr = 2 * M.cost.expr
    return Changed(M, solve(M), must_refuse=True)


def _most_cost(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.cost.sense = pyo.maximize
    for t in M.L:
        M.L[t].setub(10)
    return Changed(M, solve(M), must_refuse=True)


def _other_objective(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.cost.deactivate()
    M.splits = pyo.Objective(expr=sum(M.d[m] for m in M.d))
    return Changed(M, solve(M), must_refuse=True)


def _contradiction(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.root, M.other = _root_row(M, 0), _root_row(M, 1)
    return Changed(M, solve(M, load=False), lambda tree: False, must_refuse=True)


def _not_loaded(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.root = _root_row(M, int(rng.integers(2)))
    return Changed(M, solve(M, load=False), must_refuse=True)


def _stopped(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.root = _root_row(M, 0)
    return Changed(M, solve(M, load=False, seconds=1e-3), _reads(0), is_narrowed=True, may_refuse=True)


def _row_after(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    results = solve(M)
    M.root = _root_row(M, 0)
    return Changed(M, results, _reads(0), is_narrowed=True, may_refuse=True)


def _row_gone_after(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.root = _root_row(M, int(rng.integers(2)))
    results = solve(M)
    M.del_component(M.root)
    return Changed(M, results, may_refuse=True)


def _unfixed_after(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.d[int(rng.integers(1, 4))].fix(0)
    results = solve(M)
    M.unfix_all_vars()
    return Changed(M, results, may_refuse=True)


def _wider_after(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.d[2].setub(0)
    results = solve(M)
    M.d[2].setub(1)
    return Changed(M, results, may_refuse=True)


def _results_of_another_solve(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    M.root = pyo.Constraint(expr=sum(M.d[m] for m in M.d) <= 0)
    results = solve(M)
    M.del_component(M.root)
    solve(M)
    return Changed(M, results, may_refuse=True)


def _by_hand(M: Any, problem: Problem, rng: Generator, solve: Solve) -> Changed:
    results = solve(M)
    for m in M.d:
        M.d[m].value = 0
    return Changed(M, results, may_refuse=True)


WAYS: Mapping[str, Way] = {
    "nothing": _nothing,
    "a row": _row,
    "a row of small numbers": _small_row,
    "a list of rows": _few_splits,
    "rows for a pair of samples": _one_leaf,
    "an SOS set": _set,
    "a narrower domain": _whole_threshold,
    "a higher end": _high_threshold,
    "a lower end": _no_split_by_end,
    "a fixed split": _fixed,
    "a fixed label": _fixed_label,
    "a block with a row": _block,
    "a variable of its own": _own_variable,
    "a disjunction": _disjunction,
    "a block of a larger model": _inside,
    "fixed and unfixed": _unfixed,
    "a clone": _cloned,
    "a pickled copy": _pickled,
    "the objective by another name": _same_objective,
    "a row times two": _scaled_row,
    "rows switched off": _row_switched_off,
    "rows deleted": _row_gone,
    "a row with a wider end": _wider_row,
    "a wider domain": _wider_domain,
    "the objective times two": _scaled_objective,
    "the objective maximised": _most_cost,
    "another objective": _other_objective,
    "a contradiction": _contradiction,
    "not loaded": _not_loaded,
    "stopped": _stopped,
    "a row after the solve": _row_after,
    "a row deleted after the solve": _row_gone_after,
    "unfixed after the solve": _unfixed_after,
    "an end widened after the solve": _wider_after,
    "results of another solve": _results_of_another_solve,
    "values set by hand": _by_hand,
}
"""The ways, by name."""
