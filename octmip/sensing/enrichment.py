"""The loop of a monitor: readings that leave its library, where to inspect, a library that knows what was found, trees.

    watch       a sequential test of the readings against the deployed library (`octmip.monitor.watch`)
    inspect     the states of the twin that the library leaves out, most probable first
    library     every state of the old one, with the found damage at each of its levels, as the twin predicts them
    trees       solved and proven on readings drawn from it, the deployed ones as incumbents (`monitor_design`)
    change      which trees are kept, which splits changed and what that is worth on fresh readings

A deployed tree is kept where a new one is not better by more than chance: who uses it need not learn a new one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.monitor import (
    Finding,
    Library,
    ModelSelector,
    Monitor,
    ParameterTree,
    Watch,
    explain,
)
from octmip.monitor.candidates import state_candidates
from octmip.monitor.library import Applied, default_levels
from octmip.monitor.stream import Result
from octmip.sensing.monitor_design import MonitorDesign, design_monitor
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.nodes.prediction import predict
from octmip.trees.nodes.tree import Leaf, Node, condition, features_used
from octmip.trees.question.problem import Problem
from octmip.twin import (
    Load,
    State,
    Twin,
    TwinAround,
    positions_of,
    predict_states,
    state_limits_of,
    state_parameters,
    units_of,
)

Floats = NDArray[np.float64]
SIGNIFICANT = 3.0
"""Standard errors by which a new tree must be better for it to take the place of a deployed one."""

Verdict = Literal["kept", "changed", "new"]


@dataclass(frozen=True, slots=True)
class PartOf(TwinAround):
    """A twin with some of its state parameters; the others are 0.

    Attributes
    ----------
    twin
        the whole.
    kept
        names of the parameters.
    """

    twin: Twin
    kept: tuple[str, ...]

    def __post_init__(self) -> None:
        unknown = [name for name in self.kept if name not in state_parameters(self.twin)]
        if unknown:
            raise DataError(
                f"the twin has no state {unknown[0]!r}; expected among {list(state_parameters(self.twin))}; correct it"
            )

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters that are kept."""
        return self.kept

    @property
    def state_limits(self) -> dict[str, float]:
        """Up to which value each of them is looked for."""
        limits = dict(zip(state_parameters(self.twin), state_limits_of(self.twin), strict=True))
        return {name: limits[name] for name in self.kept}

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of every reading."""
        return units_of(self.twin)

    @property
    def is_linear_in_load(self) -> bool:
        """Whether readings are proportional to the loads."""
        return bool(getattr(self.twin, "is_linear_in_load", False))

    def predict(self, state: State, load_factor: Load) -> Floats:
        """Return the readings (n_gauges,)."""
        return self.twin.predict(state, load_factor)

    def predict_states(self, states: Floats, load_factor: Load) -> Floats:
        """Return the readings (n_states, n_gauges) of the parameters that are kept."""
        whole = state_parameters(self.twin)
        rows = np.zeros((len(states), len(whole)))
        rows[:, [whole.index(name) for name in self.kept]] = states
        return predict_states(self.twin, rows, load_factor)


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """The watch over the readings of one asset.

    Attributes
    ----------
    library, candidates
        what it knows, and how many damages outside it looks for.
    n_readings, n_tested
        readings that it saw, and those with gauges enough to disagree with the library.
    alarm
        number of the reading at which it was raised, from 1; None: never.
    finding
        its cause by all readings, or by those up to the alarm where only these name one; None without an alarm.
    faulty
        gauges that it left out.
    """

    library: Library
    candidates: int
    n_readings: int
    n_tested: int
    alarm: int | None
    finding: Finding | None
    faulty: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TreeChange:
    """A tree of the enriched library beside the deployed one.

    Attributes
    ----------
    parameter, verdict
        of the tree.
    splits
        those that changed, in words, the deployed one's first.
    deployed, retrained
        mean error of the two on fresh readings of the enriched library; the first is None of a new tree.
    standard_error
        of their difference; 0 of a new tree.
    objective, bound, is_optimal
        in training, of the tree that is kept or made.
    """

    parameter: str
    verdict: Verdict
    splits: tuple[str, ...]
    deployed: float | None
    retrained: float
    standard_error: float
    objective: float
    bound: float
    is_optimal: bool


@dataclass(frozen=True, slots=True, eq=False)
class Enriched:
    """A monitor that knows a damage which its library left out.

    Attributes
    ----------
    added
        name of the new parameter.
    n_before
        states of the library before.
    design
        the present trees with their library.
    changes
        one for each tree.
    told
        (n_later,) what the new tree says of each reading since the damage was there that has the gauges it reads.
    again
        the watch over those readings by the enriched library: no alarm where it explains them.
    largest_bound
        greatest bound of the twin's error over the new states [its unit, at the load factor of the readings]; None of a
        twin that states none.
    """

    added: str
    n_before: int
    design: MonitorDesign
    changes: tuple[TreeChange, ...]
    told: Floats
    again: Seen
    largest_bound: float | None


def watched(
    twin: Twin, selector: ModelSelector, readings: Floats, loads: Sequence[Applied], rate: float = 0.01
) -> Seen:
    """Return what a watch says of readings (n, n_gauges), NaN where missing, in the order of the library's gauges.

    Candidates are single gauges and the damages of the twin that the library leaves out. At most one alarm in
    1 / `rate` such series of readings is false.

    Raises
    ------
    ProblemError
        there is no reading.
    """
    library = selector.library
    candidates = state_candidates(twin, library)
    largest = max((library.checked_load(load) for load in loads), default=1.0)
    places = positions_of(twin)
    if places is not None:
        places = places[[twin.gauges.index(gauge) for gauge in library.gauges]]
    watch = Watch(library, candidates, rate, horizon=len(readings), largest_load=largest, places=places)
    rows = [[None if np.isnan(value) else value for value in row] for row in readings.tolist()]
    alarm, finding, state, start, faulty = None, None, 0, 0, tuple[str, ...]()
    for result in Monitor(selector, watch=watch).run(zip(loads, rows, strict=True)):
        if not isinstance(result, Result):
            continue
        faulty = result.left_out
        if result.finding is None:
            continue
        state = result.state or 0
        if result.finding.kind == "gauge":
            start = result.number + 1  # the watch begins again
            continue
        alarm, finding = result.number + 1, result.finding
        finding = finding if finding.together else replace(finding, since=start + finding.since)
        break
    n_tested = sum(watch.parity.can_disagree(~np.isnan(row)) for row in readings)
    if finding is not None:
        left = np.where(np.isin(library.gauges, faulty), np.nan, readings)
        later = explain(watch, watch.seen(left, loads), 0, state, finding.together)
        # Many readings of a large damage show that its signature is another beside other damages: then nothing fits
        # them. The enriched library, which knows it beside them, is tried on all of them.
        finding = finding if later.kind in ("unknown", "gauge") else later
    n_damages = len({one.name for one in candidates})
    return Seen(library, n_damages, len(readings), n_tested, alarm, finding, faulty)


def enrich(
    twin: Twin,
    selector: ModelSelector,
    deployed: Sequence[ParameterTree],
    readings: Floats,
    loads: Sequence[Applied],
    added: str,
    since: int,
    *,
    depth: int = 2,
    budget: float | None = None,
    costs: Mapping[str, float] | None = None,
    n_draws: int = 40,
    seed: int = 0,
    limits: Limits = Limits(),  # noqa: B008 (frozen)
) -> Enriched:
    """Return the monitor whose library knows one damage more.

    Parameters
    ----------
    twin
        the whole twin, which has the damage among its state parameters.
    selector, deployed
        what is at work: the library, and one tree for each of its parameters.
    readings, loads
        as for `watched`; the load of the last one is where the trees are read.
    added
        the damage, as an inspection or the watch found it.
    since
        the reading from which it was there.
    depth, budget, costs, n_draws, seed, limits
        as for `design_monitor`.

    Raises
    ------
    DataError
        the twin has no such state, or the library knows it already.
    """
    library = selector.library
    if added in library.parameters:
        raise DataError(f"the library knows {added!r} already; expected a state that it leaves out; name another")
    whole = PartOf(twin, (*library.parameters, added))
    load = loads[-1] if library.reference is None else library.reference
    design = design_monitor(
        whole,
        load,
        dict(zip(library.gauges, library.noise_sd.tolist(), strict=True)),
        levels=_levels(whole, library),
        depth=depth,
        costs=costs,
        budget=budget,
        n_draws=n_draws,
        seed=seed,
        limits=limits,
        deployed=deployed,
    )
    before = {one.parameter: one.over(library.gauges) for one in deployed}
    design, changes = _changed(design, before, may_keep=budget is None)
    for problem, solution in zip(design.problems, design.solutions, strict=True):
        certify(problem, solution)
    later, at = readings[since:], list(loads[since:])
    per_unit = np.array([row / library.checked_load(one) for row, one in zip(later, at, strict=True)])
    new = design.trees[-1]
    has_all = ~np.isnan(per_unit[:, list(features_used(new.tree))]).any(axis=1)
    told = np.array(new.values)[predict(new.tree, per_unit[has_all])] if has_all.any() else np.zeros(0)
    again = watched(twin, design.selector, later, at)
    return Enriched(added, library.n_states, design, changes, told, again, _largest_bound(whole, design))


def _levels(twin: PartOf, library: Library) -> dict[str, list[float]]:
    """Return the levels of the library's parameters, and those of the new one."""
    own = {name: np.unique(library.states[:, k]).tolist() for k, name in enumerate(library.parameters)}
    added = twin.kept[-1]
    return own | {added: default_levels(twin.state_limits[added])}


def _changed(
    design: MonitorDesign, before: Mapping[str, ParameterTree], may_keep: bool
) -> tuple[MonitorDesign, tuple[TreeChange, ...]]:
    """Return the design with the deployed trees that retrained ones do not better, and what became of each tree."""
    solutions, changes = list(design.solutions), []
    for k, (one, problem) in enumerate(zip(design.trees, design.problems, strict=True)):
        errors, old = design.errors_of(k, one), before.get(one.parameter)
        splits: tuple[str, ...] = ()
        deployed, error = None, 0.0
        verdict: Verdict = "new"
        if old is not None:
            apart = design.errors_of(k, old) - errors
            deployed, error = float(apart.mean() + errors.mean()), float(apart.std() / np.sqrt(len(apart)))
            if may_keep and apart.mean() <= SIGNIFICANT * error:
                solutions[k] = _kept(problem, solutions[k], old.tree)
            splits = tuple(_apart(old.tree, solutions[k].tree, problem.samples.feature_names, one.values))
            verdict = "changed" if splits else "kept"
        own = solutions[k]
        claims = (own.objective, own.bound, own.is_optimal)
        changes.append(TreeChange(one.parameter, verdict, splits, deployed, float(errors.mean()), error, *claims))
    return replace(design, solutions=tuple(solutions)), tuple(changes)


def _kept(problem: Problem, found: Solution, tree: Node) -> Solution:
    """Return the deployed tree as a solution, with the bound that was proven beside it."""
    objective = problem.objective(tree)
    stop = found.stop if objective == found.objective else Stop.GAP
    return replace(found, tree=tree, objective=objective, stop=stop)


def _apart(old: Node, new: Node, gauges: Sequence[str], values: Sequence[float], at: str = "root") -> list[str]:
    """Return where two trees differ, in words."""

    def words(node: Node) -> str:
        if isinstance(node, Leaf):
            return f"{values[node.label]:g}"
        return condition(node, lambda feature: gauges[feature])

    if isinstance(old, Leaf) or isinstance(new, Leaf):
        return [] if old == new else [f"{at}: {words(old)} -> {words(new)}"]
    own = [] if words(old) == words(new) else [f"{at}: {words(old)} -> {words(new)}"]
    down = "" if at == "root" else f"{at} "
    return [
        *own,
        *_apart(old.left, new.left, gauges, values, f"{down}left"),
        *_apart(old.right, new.right, gauges, values, f"{down}right"),
    ]


def _largest_bound(whole: PartOf, design: MonitorDesign) -> float | None:
    """Return the greatest bound of a reduced twin's error over the states of the library."""
    bound = getattr(whole.twin, "error_bound", None)
    if bound is None:
        return None
    names = state_parameters(whole.twin)
    rows = np.zeros((design.library.n_states, len(names)))
    rows[:, [names.index(name) for name in whole.kept]] = design.library.states
    library = design.library
    load = design.load_factor if library.reference is None else library.asked_at[0]
    return float(np.asarray(bound(rows, load)).max())
