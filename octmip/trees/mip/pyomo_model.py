"""A problem's mixed-integer model in Pyomo, with the letters of the paper, and a certified Solution from its answer.

model = octmip.model(problem, "oct")          a ConcreteModel
model.mine = pyo.Constraint(...)              rows of your own, if you like
results = SolverFactory("scip").solve(model)  any solver that Pyomo knows
solution = octmip.solution_of(model, results)
"""

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError, SolverError, needed_by
from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.encoding.sample_costs import weighted_rows
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.mip.highs.claims import COARSEST_DUAL
from octmip.trees.mip.model_rows import Answer, Model, model_of, named
from octmip.trees.mip.pyomo_changes import Changes, changes_of, is_untouched
from octmip.trees.mip.pyomo_results import Report, report_of
from octmip.trees.mip.rows import Rows
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem

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
QUICK = 20
"""Restarts of the search that tries a bound, and its perturbations in a row."""


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
    >>> M = model(Problem([[0, 5], [1, 4]], ["a", "b"], depth=1), "oct")
    >>> M.root = pyo.Constraint(expr=M.a[0, 1] == 1)  # the root reads feature 0
    >>> solution_of(M, pyo.SolverFactory("appsi_highs").solve(M)).tree
    Split(0, 0.5, Leaf(0), Leaf(1))
    """
    made = model_of(problem, method, start=start, mu=mu)
    return _concrete_model(made)


def solution_of(
    model: Any, results: Any = None, *, bound: float | None = None, dual_tolerance: float = COARSEST_DUAL
) -> Solution:
    """Return the certified Solution of a model made by `model` that a solver has solved.

    Nothing is believed that can be checked: the solver's end comes first, then the model is compared with the rows that
    it was made of, then all that was added to it is evaluated at the values. The Solution's scope says what was added.
    Rows that are taken away between the solve and this call show only where they make the bound false of a tree that a
    quick search finds: leave the model as it was solved.

    Parameters
    ----------
    model
        the ConcreteModel, its variables with the solver's values.
    results
        what the solver returned: its end, bound and name are read from it; None: nothing is known of them.
    bound
        the solver's lower bound, in place of that in `results`.
    dual_tolerance
        by which the solver let reduced costs have the wrong sign: its bound is lowered by what that may have added.
        The default is the coarsest of the solvers' own. Where weights, costs or penalties are no small whole numbers
        a bound meets the tree only if the solver was given a finer one, such as 1e-9, and it is said here.

    Raises
    ------
    SolverError
        the solver has no solution; the variables have no values, or not those of `results`; these are no solution of
        the model, or break what was added to it; the bound is false.
    ProblemError
        the model is none of `model`, has another objective, or holds what cannot be evaluated.

    Examples
    --------
    >>> import pyomo.environ as pyo
    >>> M = model(Problem([[0], [1]], ["a", "b"], depth=1), "flow")
    >>> solution_of(M, pyo.SolverFactory("appsi_highs").solve(M)).objective
    0.0
    """
    made = getattr(model, MADE_OF, None)
    if not isinstance(made, Model):
        raise ProblemError(f"the model {model!r:.60} is none of octmip.model; give the ConcreteModel that it returned")
    if not 0 <= dual_tolerance < math.inf:
        raise ProblemError(f"dual_tolerance is {dual_tolerance!r}; expected a number of 0 or more, such as 1e-9")
    if bound is not None and not math.isfinite(bound):
        raise ProblemError(f"bound is {bound!r}; expected a number; leave it out where the solver states none")
    rows, report = made.formulation.rows, report_of(results)
    variables = _variables(model, rows)
    changes = changes_of(model, rows, variables)
    values = _values_of(report, made, changes, variables)
    if broken := changes.broken(_value_of):
        raise SolverError(
            f"the values of the model break {broken}, which was added to it; solve the model as it stands, then ask"
        )
    answer = Answer(
        values,
        report.bound if bound is None else bound,
        report.solver,
        report.stop,
        changes.names,
        changes.activity,
        dual_tolerance,
    )
    _check_splits(made, changes, values, variables)
    _refuse_false_bound(made, changes, answer, variables)
    return made.solution(answer)


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
    for variable in variables:
        variable.stale = True  # until a solver sets it: `pyomo_changes.is_untouched`
    object.__setattr__(M, MADE_OF, made)
    return M


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
    """Return the variables of a model, column by column.

    Raises
    ------
    ProblemError
        some are gone.
    """
    components = [model.component(letter) for letter in rows.families]
    found = [variable for component in components if isinstance(component, pyo.Var) for variable in component.values()]
    if len(found) != rows.n_columns:
        gone = [own for own, one in zip(rows.families, components, strict=True) if not isinstance(one, pyo.Var)]
        raise ProblemError(
            f"the model has {len(found)} variables {', '.join(rows.families)}; expected {rows.n_columns}"
            f"{f' (without a Var: {named(tuple(gone))})' * bool(gone)}; make the model again, give what is added other "
            "names, and fix variables in place of taking them away"
        )
    return found


def _values_of(report: Report, made: Model, changes: Changes, variables: list[Any]) -> NDArray[np.float64]:
    """Return the values (n_columns,) that a solver gave the variables of a model.

    Raises
    ------
    SolverError
        it gave none, or none of what its results speak of.
    """
    added = f" that keeps what was added to it ({named(changes.names)})" if changes.added else ""
    if report.denies:
        start = made.start()
        is_false = start is not None and not changes.broken(_values_at(start, variables))
        end = "that is false, as the tree to start from is one; ask another solver" if is_false else "take some away"
        raise SolverError(f"{report.solver} ended with '{report.condition}': no tree of the model{added}; {end}")
    values = np.array([math.nan if v.value is None else v.value for v in variables], dtype=float)
    if np.isnan(values).any():
        lacks = variables[int(np.isnan(values).argmax())].name
        raise SolverError(f"the variable {lacks} has no value; expected a solution; solve the model first")
    if report.condition and not report.is_proven and math.isnan(report.incumbent):
        raise SolverError(
            f"{report.solver} ended with '{report.condition}' and without a solution{added}: the values of the model "
            "are others; give it more time"
        )
    if is_untouched(variables):
        raise SolverError(
            "the variables have the values of the tree to start from, which no solver has set; solve the model, or "
            "load its solution: model.solutions.load_from(results), results.solution_loader.load_vars()"
        )
    price = made.formulation.rows.objective(values)
    if abs(report.incumbent - price) > 0.5:  # prices are whole
        raise SolverError(
            f"{report.solver} has a solution of objective {report.incumbent:g} but the values of the model have "
            f"{price:g}: they are not those of these results; load them, or give the results of the last solve"
        )
    return values


def _value_of(variable: Any) -> float:
    return math.nan if variable.value is None else float(variable.value)


def _check_splits(made: Model, changes: Changes, values: NDArray[np.float64], variables: list[Any]) -> None:
    """Check that a tree keeps what was added, where its solution has a split with all samples on one side.

    No tree has such a split. Without it the tree has other values, at which what was added may be broken.

    Raises
    ------
    SolverError
        it is.
    """
    if not changes.added or (own := made.read_again(values)) is None:
        return
    if broken := changes.broken(_values_at(own, variables)):
        raise SolverError(
            f"the solution keeps {broken} by a split with all samples on one side, which is none of a tree: without it "
            f"the tree breaks {broken}; ask for samples on both sides in a row, or for a price of a split "
            "(leaf_penalty), and solve the model again"
        )


def _refuse_false_bound(made: Model, changes: Changes, answer: Answer, variables: list[Any]) -> None:
    """Raise a SolverError where a bound denies a tree of the model that a quick search finds and that keeps all.

    The comparison sees the model as it is, not as it was when it was solved.
    """
    for tree in (made.known.tree, _quickly_found(made.problem)):
        values = None if tree is None else made.start(tree)
        if values is not None and not changes.broken(_values_at(values, variables)):
            made.refuse_above(made.formulation.rows.objective(values), answer)


def _quickly_found(problem: Problem) -> Node | None:
    """Return the tree of a quick search; None for costs of single samples without weighted rows, which it takes."""
    options = SearchOptions(restarts=QUICK, perturbations=QUICK)
    if problem.has_sample_costs:
        with suppress(ProblemError):
            made = weighted_rows(problem)
            return None if made is None else local_search(made.rows, limits=Limits(seconds=1.0), options=options).tree
        return None
    return local_search(problem, limits=Limits(seconds=1.0), options=options).tree


def _values_at(values: NDArray[np.float64], variables: list[Any]) -> Callable[[Any], float]:
    """Return the value of any variable when a model's own have `values` (n_columns,)."""
    own = {id(variable): value for variable, value in zip(variables, values.tolist(), strict=True)}
    return lambda variable: own.get(id(variable), _value_of(variable))


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
