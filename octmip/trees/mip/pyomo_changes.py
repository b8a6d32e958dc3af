"""What a user changed in a Pyomo model of octmip's, and whether values keep it.

The model that was solved is compared with the rows that it was made of. A change does one of two things, or both:

* It forbids solutions: a row, a set or a logical rule is added; a variable is fixed, has narrower bounds or a narrower
  domain. A bound then speaks of the trees that keep what was added.
* It allows more: a row is taken away or has wider ends, a variable has a wider domain. A bound of the wider model holds
  for the model all the same, and values count only if they keep the rows that it was made of.

What forbids is evaluated at the values: nothing that a solver returns proves that it saw it. A row of whole variables
must hold at their nearest whole numbers; another one to `MOST_VIOLATION` of its largest coefficient.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError, needed_by
from octmip.trees.mip.model_rows import MOST_VIOLATION
from octmip.trees.mip.rows import Rows

with needed_by("a Pyomo model"):
    import pyomo.environ as pyo
    from pyomo.repn import generate_standard_repn
    from pyomo.repn.util import categorize_valid_components

ROUNDING = 1e-9
"""Share of a row of whole variables by which float64 may miss it."""
COMPARED = (pyo.Constraint, pyo.SOSConstraint, pyo.LogicalConstraint, pyo.Objective, pyo.Var, pyo.BooleanVar)
"""The kinds of components that `changes_of` reads."""
IDLE = (pyo.Param, pyo.Set, pyo.RangeSet, pyo.Expression, pyo.Block, pyo.Suffix, pyo.BuildAction, pyo.BuildCheck)
"""The kinds of components that neither forbid nor allow anything by themselves."""
Breach = Callable[[Callable[[Any], float]], float]
"""By how much the values of variables break one thing, in units of its tolerance: above 1 it is broken."""


@dataclass(frozen=True, slots=True)
class Added:
    """One thing that forbids solutions: its name, the check of it, and the range of its activity."""

    name: str
    breach: Breach
    activity: float = 0.0


@dataclass(frozen=True, slots=True)
class Changes:
    """What was changed in a model.

    Attributes
    ----------
    added
        what forbids solutions of it.
    taken
        the names of what it no longer asks.
    own
        ends and kinds of variables that are not the model's; the rows that they stand in are named.
    """

    added: tuple[Added, ...]
    taken: tuple[str, ...]
    own: tuple[Added, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of what was added."""
        return tuple(one.name for one in self.added)

    @property
    def activity(self) -> float:
        """The sum of the ranges of the added rows that have one."""
        return sum(one.activity for one in self.added if math.isfinite(one.activity))

    def broken(self, value_of: Callable[[Any], float]) -> str:
        """Return the name of what the values of variables break most, "" where they keep all."""
        every = (*self.added, *self.own)
        worst = max(((one.breach(value_of), one.name) for one in every), default=(0.0, ""))
        return worst[1] if worst[0] > 1 else ""


def changes_of(model: Any, rows: Rows, variables: list[Any]) -> Changes:
    """Return what was changed in a model that was made of rows, given its variables column by column.

    Rows outside the model count where it is a block of a larger one.

    Raises
    ------
    ProblemError
        it has another objective, or a component that nothing here can evaluate.
    """
    root = model.model()
    _, unknown = categorize_valid_components(root, active=True, valid={*COMPARED, *IDLE})
    if unknown:
        kind, found = next(iter(unknown.items()))
        raise ProblemError(
            f"the model holds {found[0].name}, a {kind.__name__}, which cannot be compared with the rows that it was "
            "made of; expected constraints; make them of it first, such as by pyo.TransformationFactory('gdp.bigm')"
        )
    _refuse_another_objective(root, rows, variables)
    column = {id(variable): j for j, variable in enumerate(variables)}
    added: list[Added] = []
    taken: list[str] = []
    for variable, low, high, whole in zip(variables, rows.lower, rows.upper, rows.is_integer, strict=True):
        _compare_variable(variable, low, high, bool(whole), added, taken)
    added += _left_out(rows, variables)
    _compare_rows(root, model, rows, variables, column, added, taken)
    added += [_set(one) for one in root.component_data_objects(pyo.SOSConstraint, active=True)]
    added += [_rule(one) for one in root.component_data_objects(pyo.LogicalConstraint, active=True)]
    others = [one for one in root.component_data_objects(pyo.Var, active=True) if id(one) not in column]
    return Changes(tuple(added), tuple(taken), tuple(_ends_kept(one) for one in others if one.value is not None))


def is_untouched(variables: list[Any]) -> bool:
    """Whether nobody gave the variables a value since the model was made: `stale`, as Pyomo calls it."""
    return all(variable.stale or variable.fixed for variable in variables)


def _refuse_another_objective(root: Any, rows: Rows, variables: list[Any]) -> None:
    """Raise a ProblemError where a model has another objective than that of its rows."""
    found = list(root.component_data_objects(pyo.Objective, active=True))
    is_own = len(found) == 1 and found[0].sense == pyo.minimize
    priced = np.flatnonzero(rows.cost)
    if not is_own or not _is_sum(found[0].expr, rows.cost[priced], [variables[j] for j in priced], rows.offset):
        raise ProblemError(
            f"the model has another objective than its own, by name {', '.join(one.name for one in found) or 'none'}; "
            "expected 'cost' alone, minimised and unchanged, as a bound speaks of it; rows may be added"
        )


def _is_sum(body: Any, coefficients: NDArray[np.float64], variables: list[Any], constant: float = 0.0) -> bool:
    """Whether an expression is that sum, variables with a fixed value counted as the number that they are."""
    expected: dict[int, float] = {}
    for number, variable in zip(coefficients.tolist(), variables, strict=True):
        if variable.fixed:
            constant += number * variable.value
        else:
            expected[id(variable)] = expected.get(id(variable), 0.0) + number
    found = generate_standard_repn(body, quadratic=False)
    terms = {id(v): float(c) for v, c in zip(found.linear_vars, found.linear_coefs, strict=True) if c}
    is_near = abs(float(found.constant) - constant) <= ROUNDING * max(1.0, abs(constant))
    return found.nonlinear_expr is None and is_near and terms == {key: c for key, c in expected.items() if c}


def _compare_variable(
    variable: Any, low: float, high: float, is_whole: bool, added: list[Added], taken: list[str]
) -> None:
    """Note what is changed in a variable's value, ends and domain."""
    least, most = _ends(variable)
    if variable.fixed:
        added.append(_held(variable, "fixed"))
        return
    if least > low or most < high:
        added.append(
            Added(
                f"{variable.name} in [{least:g}, {most:g}]",
                lambda value_of: _excess(value_of(variable), least, most) / MOST_VIOLATION,
            )
        )
    if least < low or most > high:
        taken.append(f"the ends of {variable.name}")
    if variable.is_integer() or variable.is_binary():
        if not is_whole:
            added.append(Added(f"{variable.name} whole", lambda value_of: _from_whole(value_of(variable))))
    elif not variable.is_continuous():
        domain = variable.domain
        added.append(Added(f"{variable.name} in {domain}", lambda value_of: 0.0 if value_of(variable) in domain else 2))
        taken.append(f"the domain of {variable.name}")
    elif is_whole:
        taken.append(f"{variable.name} whole")


def _ends(variable: Any) -> tuple[float, float]:
    low, high = variable.lb, variable.ub
    return -math.inf if low is None else float(low), math.inf if high is None else float(high)


def _ends_kept(variable: Any) -> Added:
    """Return the ends and kind of a variable as what they forbid."""
    least, most = _ends(variable)
    is_whole = variable.is_integer() or variable.is_binary()

    def breach(value_of: Callable[[Any], float]) -> float:
        value = value_of(variable)
        return max(_excess(value, least, most) / MOST_VIOLATION, _from_whole(value) if is_whole else 0.0)

    return Added(f"{variable.name} in [{least:g}, {most:g}]", breach)


def _from_whole(value: float) -> float:
    return abs(value - round(value)) / MOST_VIOLATION


def _held(variable: Any, how: str) -> Added:
    """Return a variable that a solver could not change as what it forbids: other values."""
    at = float(variable.value) + 0.0  # no -0
    return Added(
        f"{variable.name} {how} at {at:g}", lambda value_of: _excess(value_of(variable), at, at) / MOST_VIOLATION
    )


def _left_out(rows: Rows, variables: list[Any]) -> Iterator[Added]:
    """Yield the variables of rows that kept their value while others got one: they were fixed when it was solved.

    Where whole ones alone got a value, somebody rounded them after the solve, which makes all others stale.
    """
    by_solver = [not variable.stale for variable, whole in zip(variables, rows.is_integer, strict=True) if not whole]
    if not is_untouched(variables) and any(by_solver or [True]):
        in_rows = np.bincount(rows.matrix().indices, minlength=rows.n_columns) > 0
        yield from (
            _held(variable, "held")
            for variable, is_there in zip(variables, in_rows, strict=True)
            if is_there and variable.stale and not variable.fixed
        )


def _compare_rows(
    root: Any,
    model: Any,
    rows: Rows,
    variables: list[Any],
    column: dict[int, int],
    added: list[Added],
    taken: list[str],
) -> None:
    """Note the rows that are new, gone or changed."""
    own = dict(_own_rows(model, rows))
    matrix, (low, high), gone = rows.matrix(), rows.row_bounds, set(range(rows.n_rows))
    for row in root.component_data_objects(pyo.Constraint, active=True, descend_into=pyo.Block):
        place = own.get(id(row))
        least, most = (_end(end, sign) for end, sign in ((row.lower, -1), (row.upper, 1)))
        if place is not None:
            begin, end = matrix.indptr[place : place + 2]
            terms = [variables[j] for j in matrix.indices[begin:end]]
            if _is_sum(row.body, matrix.data[begin:end], terms):
                gone.discard(place)
                if least < low[place] or most > high[place]:
                    taken.append(f"an end of {row.name}")
                if least <= low[place] and most >= high[place]:
                    continue
        added.append(_row(row, least, most))
    names = rows.row_names() if gone else []
    taken += [names[place] for place in sorted(gone)]


def _own_rows(model: Any, rows: Rows) -> Iterator[tuple[int, int]]:
    """Yield the identity of each row of a model that it was made with, and its number."""
    places: dict[str, int] = {}
    number = 0
    for name, n_rows in rows.row_families:
        component = model.component(name)
        for _ in range(n_rows):
            i = places[name] = places.get(name, -1) + 1
            if isinstance(component, pyo.Constraint) and i in component:
                yield id(component[i]), number
            number += 1


def _end(value: Any, sign: int) -> float:
    return sign * math.inf if value is None else float(pyo.value(value))


def _row(row: Any, least: float, most: float) -> Added:
    """Return an active row as what it forbids."""
    found = generate_standard_repn(row.body, quadratic=False)
    if found.nonlinear_expr is not None:
        scale = max(1.0, *(abs(end) for end in (least, most) if math.isfinite(end)))
        return Added(row.name, lambda value_of: _excess(_value(row.body), least, most) / (MOST_VIOLATION * scale))
    terms = [(float(c), v) for c, v in zip(found.linear_coefs, found.linear_vars, strict=True) if c]
    constant = float(found.constant)
    is_whole = all(v.is_integer() or v.is_binary() for _, v in terms)
    scale = max((abs(c) for c, _ in terms), default=1.0)

    def breach(value_of: Callable[[Any], float]) -> float:
        parts = [c * (np.rint(value_of(v)) if is_whole else value_of(v)) for c, v in terms]
        size = abs(constant) + sum(abs(part) for part in parts)
        slack = ROUNDING * max(scale, size) if is_whole else MOST_VIOLATION * scale
        return _excess(constant + math.fsum(parts), least, most) / slack

    ranges = [abs(c) * (_ends(v)[1] - _ends(v)[0]) for c, v in terms]
    return Added(row.name, breach, 0.0 if least == most else math.fsum(ranges))


def _set(one: Any) -> Added:
    """Return a special ordered set as what it forbids: more than `level` values beside each other that are not 0."""

    def breach(value_of: Callable[[Any], float]) -> float:
        ordered = sorted(one.get_items(), key=lambda item: item[1])
        used = [i for i, (v, _) in enumerate(ordered) if abs(value_of(v)) > MOST_VIOLATION]
        return 2.0 if used and used[-1] - used[0] >= one.level else 0.0

    return Added(one.name, breach)


def _rule(one: Any) -> Added:
    """Return a logical rule as what it forbids."""
    return Added(one.name, lambda value_of: 0.0 if _value(one.body) == 1 else 2.0)


def _excess(value: float, least: float, most: float) -> float:
    return math.inf if math.isnan(value) else max(least - value, value - most)


def _value(expression: Any) -> float:
    """Return the value of an expression, NaN where one of its variables has none."""
    found = pyo.value(expression, exception=False)
    return math.nan if found is None else float(found)
