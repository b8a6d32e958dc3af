"""A problem's mixed-integer model in Pyomo, with the letters of the paper, and a certified Solution from its answer.

model = octmip.model(problem, "oct")          a ConcreteModel
model.mine = pyo.Constraint(...)              rows of your own, if you like
results = SolverFactory("scip").solve(model)  any solver that Pyomo knows
solution = octmip.solution_of(model, results)
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError, SolverError, needed_by
from octmip.trees.mip.highs.claims import COARSEST_DUAL
from octmip.trees.mip.model_rows import Answer, Model, model_of
from octmip.trees.mip.rows import Rows
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution
from octmip.trees.tree import Node

with needed_by("a Pyomo model"):
    import pyomo.environ as pyo
    from pyomo.core.expr.numeric_expr import LinearExpression

EQUATIONS = {
    "one_feature": "eq. 2",
    "threshold": "eq. 3",
    "parent_splits": "eq. 5",
    "leaf_used": "eq. 6",
    "leaf_size": "eq. 7",
    "one_leaf": "eq. 8",
    "left": "eq. 12",
    "right": "eq. 13",
    "class_weight": "eq. 15",
    "leaf_weight": "eq. 16",
    "one_class": "eq. 18",
    "cost_if_chosen": "eq. 20",
    "cost_at_most": "eq. 21",
}
"""Equation of Bertsimas & Dunn (2017) of each family of rows of OCT."""
MADE_OF = "_octmip_model"
"""Attribute of a ConcreteModel: the `Model` that it was made of."""


def model(
    problem: Problem,
    method: str = "oct",
    *,
    start: Node | Solution | None = None,
    mu: float | None = None,
) -> pyo.ConcreteModel:
    """Return a problem of classes as a Pyomo ConcreteModel, with the paper's letters and a tree to start from.

    Parameters
    ----------
    problem
        classes, all readings present.
    method
        "oct" or "oct_h" as Bertsimas & Dunn print them, or "flow", the strengthened form.
    start
        the tree whose values the variables have at first; None: CART's.
    mu
        strictness of hyperplanes; None: chosen from the data.

    Raises
    ------
    ProblemError
        there is no such model, or none for this problem; readings are missing.
    MissingExtraError
        Pyomo is not installed.

    Examples
    --------
    >>> import pyomo.environ as pyo
    >>> M = model(problem, "oct")
    >>> M.root = pyo.Constraint(expr=M.a[0, 1] == 1)  # the root reads feature 0
    >>> solution = solution_of(M, pyo.SolverFactory("appsi_highs").solve(M))
    """
    made = model_of(problem, method, start=start, mu=mu)
    return _concrete_model(made)


def solution_of(
    model: Any, results: Any = None, *, bound: float | None = None, dual_tolerance: float = COARSEST_DUAL
) -> Solution:
    """Return the certified Solution of a model made by `model` that a solver has solved.

    Parameters
    ----------
    model
        the ConcreteModel, its variables with the solver's values.
    results
        what the solver returned: its bound and name are read from it; None: neither is known.
    bound
        the solver's lower bound, in place of that in `results`.
    dual_tolerance
        by which the solver let reduced costs have the wrong sign: its bound is lowered by what that may have added.
        The default is the coarsest of the solvers' own. Where weights, costs or penalties are no small whole numbers
        a bound meets the tree only if the solver was given a finer one, such as 1e-9, and it is said here.

    Raises
    ------
    SolverError
        the variables have no values, or these are no solution of the model.
    ProblemError
        the model is none of `model`.
    """
    made, answer = _answer_of(model, results)
    if not 0 <= dual_tolerance < math.inf:
        raise ProblemError(f"dual_tolerance is {dual_tolerance!r}; expected a number of 0 or more, such as 1e-9")
    answer = replace(answer, dual_tolerance=dual_tolerance)
    return made.solution(answer if bound is None else replace(answer, bound=bound))


def _concrete_model(made: Model) -> pyo.ConcreteModel:
    """Return a model as Pyomo has it: a Var for each letter, a Constraint for each family of rows."""
    rows, M = made.formulation.rows, pyo.ConcreteModel(made.method)
    variables = _add_columns(M, rows)
    _add_rows(M, rows, variables)
    priced = np.flatnonzero(rows.cost)
    M.cost = pyo.Objective(expr=_sum(rows.cost[priced], priced, variables) + rows.offset)
    start = made.start()
    for variable, value in zip(variables, [] if start is None else start.tolist(), strict=False):
        variable.set_value(value, skip_validation=True)
    object.__setattr__(M, MADE_OF, made)
    return M


def _answer_of(model: Any, results: Any) -> tuple[Model, Answer]:
    """Return what a model was made of, and what a solver made of it.

    Raises
    ------
    ProblemError
        `octmip.model` did not make it.
    SolverError
        a variable of the model has no value.
    """
    made = getattr(model, MADE_OF, None)
    if not isinstance(made, Model):
        raise ProblemError(f"the model {model!r:.60} is none of octmip.model; give the ConcreteModel that it returned")
    rows = made.formulation.rows
    variables = _variables(model, rows)
    values = np.array([math.nan if v.value is None else v.value for v in variables], dtype=float)
    if np.isnan(values).any():
        lacks = variables[int(np.isnan(values).argmax())].name
        raise SolverError(f"the variable {lacks} has no value; expected a solution; solve the model first")
    if [one.name for one in model.component_data_objects(pyo.Objective, active=True)] != ["cost"]:
        raise ProblemError("the model has another objective than its own; expected 'cost' alone; rows may be added")
    return made, Answer(values, _bound_of(results), _name_of(results), _n_changes(model, rows, variables))


def _n_changes(model: Any, rows: Rows, variables: list[Any]) -> int:
    """Return how many rows were added or taken away, and how many variables were fixed or bounded anew."""
    own = {id(row) for name, _ in rows.row_families for row in model.component(name).values() if row.active}
    n_rows = sum(1 for _ in model.component_data_objects(pyo.Constraint, active=True))
    ends = zip(variables, rows.lower, rows.upper, strict=True)
    is_bound = (v.fixed or (v.lb, v.ub) != tuple(map(_end, (low, high))) for v, low, high in ends)
    n_bound: int = sum(is_bound)
    return n_rows + rows.n_rows - 2 * len(own) + n_bound


def _add_columns(M: pyo.ConcreteModel, rows: Rows) -> list[Any]:
    """Add a Var for each letter and return the variables, column by column."""
    lower, upper, whole = rows.lower, rows.upper, rows.is_integer
    found: list[Any] = []
    for letter, (index, axes) in rows.families.items():
        variable = pyo.Var(*(list(axis) for axis in axes))
        M.add_component(letter, variable)
        keys = list(np.ndindex(index.shape))
        for position, column in zip(keys, index.ravel().tolist(), strict=True):
            key = tuple(axis[i] for axis, i in zip(axes, position, strict=True))
            one = variable[key if len(key) > 1 else key[0]]
            one.setlb(_end(lower[column]))
            one.setub(_end(upper[column]))
            if whole[column]:
                one.domain = pyo.Binary if lower[column] >= 0 and upper[column] <= 1 else pyo.Integers
            found.append(one)
    return found


def _end(value: float) -> float | None:
    return None if math.isinf(value) else float(value)


def _variables(model: Any, rows: Rows) -> list[Any]:
    """Return the variables of a model, column by column."""
    return [variable for letter in rows.families for variable in model.component(letter).values()]


def _add_rows(M: pyo.ConcreteModel, rows: Rows, variables: list[Any]) -> None:
    """Add a Constraint for each family of rows, its number among the paper's equations as its doc."""
    matrix, (low, high) = rows.matrix(), rows.row_bounds
    numbers: dict[str, list[int]] = {}
    row = 0
    for name, n_rows in rows.row_families:
        numbers.setdefault(name, []).extend(range(row, row + n_rows))
        row += n_rows
    for name, places in numbers.items():
        constraint = pyo.Constraint(range(len(places)), doc=EQUATIONS.get(name))
        M.add_component(name, constraint)
        for i, place in enumerate(places):
            begin, end = matrix.indptr[place : place + 2]
            body = _sum(matrix.data[begin:end], matrix.indices[begin:end], variables)
            least, most = (_end(v) for v in (low[place], high[place]))
            constraint[i] = body == least if least == most else (least, body, most)


def _sum(numbers: NDArray[np.float64], columns: NDArray[np.integer], variables: list[Any]) -> Any:
    """Return the sum of numbers (n,) times the variables of columns (n,)."""
    return LinearExpression(linear_coefs=numbers.tolist(), linear_vars=[variables[j] for j in columns])


def _bound_of(results: Any) -> float:
    """Return the lower bound in what a solver of Pyomo returned, old interface or new; -inf without one."""
    found = getattr(results, "objective_bound", None)
    if found is None and results is not None:
        found = getattr(getattr(results, "problem", None), "lower_bound", None)
        found = getattr(found, "value", found)
    try:
        return -math.inf if found is None or math.isnan(float(found)) else float(found)
    except (TypeError, ValueError):
        return -math.inf


def _name_of(results: Any) -> str:
    """Return the name of the solver in what it returned."""
    found = getattr(results, "solver_name", None)
    if found is None:
        found = getattr(getattr(results, "solver", None), "name", None)
        found = getattr(found, "value", found)
    return "another solver" if found is None or str(found) == "<undefined>" else str(found)
