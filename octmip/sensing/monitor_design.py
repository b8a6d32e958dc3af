"""A monitor from a twin: trees that read the state of an asset at one combination of loads, within a budget of sensors.

The library holds the states, each parameter at its levels. Readings are drawn from it, with noise, and for each
parameter a tree is solved on them: a wrong level costs as much as it is off. Under a budget the trees share their
sensors (`octmip.sensing.sensor_sets`). What the trees are off is counted on readings that no tree has seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.monitor import Library, ModelSelector, ParameterTree, grid_states, library_of
from octmip.monitor.library import Applied, default_levels
from octmip.sensing.sensor_sets import shared_budget
from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.nodes.prediction import predict
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve
from octmip.twin import Twin, state_limits_of, state_parameters

Floats = NDArray[np.float64]
PER_CENT = 100.0
"""Costs are per cent by which a level is off: whole numbers, and so exact sums, where levels are whole per cents."""
FRESH = 7
"""Seed of the fresh readings beside that of the others."""


@dataclass(frozen=True, eq=False)
class MonitorDesign:
    """Trees of one combination of loads, one for each parameter.

    Attributes
    ----------
    library
        states with what the twin predicts for them.
    problems, solutions
        one for each parameter: readings drawn from the library, and the tree.
    fresh
        (n_readings, n_gauges) other readings, as those of the problems.
    truth
        (n_readings,) index of each one's state.
    load_factor
        what readings were divided by: 1 where the loads were named.
    """

    library: Library
    problems: tuple[Problem, ...]
    solutions: tuple[Solution, ...]
    fresh: Floats
    truth: NDArray[np.int64]
    load_factor: float

    @cached_property
    def trees(self) -> tuple[ParameterTree, ...]:
        """The trees, with the values that they predict."""
        named = zip(self.library.parameters, self.problems, self.solutions, strict=True)
        return tuple(
            ParameterTree(
                name, solution.tree, tuple(map(float, problem.samples.class_names)), problem.samples.feature_names
            )
            for name, problem, solution in named
            if solution.tree is not None
        )

    @cached_property
    def selector(self) -> ModelSelector:
        """All trees as one that selects a state of the library."""
        return ModelSelector.of_trees(self.library, self.trees)

    @property
    def off_by(self) -> tuple[float, ...]:
        """What each tree is off on average on fresh readings, in the unit of its parameter."""
        return tuple(float(self.errors_of(k, one).mean()) for k, one in enumerate(self.trees))

    def errors_of(self, k: int, one: ParameterTree) -> Floats:
        """Return what a tree of parameter k is off on each fresh reading, shape (n_readings,)."""
        told = np.array(one.values)[predict(one.tree, self.fresh)]
        return np.asarray(np.abs(told - self.library.states[self.truth, k]))

    @property
    def without_readings(self) -> tuple[float, ...]:
        """The same for the best constant, the median level."""
        states = self.library.states[self.truth]
        return tuple(np.mean(np.abs(states - np.median(states, axis=0)), axis=0).tolist())

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the readings that some tree needs."""
        read = [
            p.shape.sensors_used(s.tree)
            for p, s in zip(self.problems, self.solutions, strict=True)
            if s.tree is not None
        ]
        return tuple(name for name in self.library.gauges if any(name in names for names in read))


def design_monitor(
    twin: Twin,
    load: Applied,
    noise_sd: float | Mapping[str, float],
    *,
    levels: Mapping[str, Sequence[float]] | None = None,
    depth: int = 2,
    costs: Mapping[str, float] | None = None,
    budget: float | None = None,
    n_draws: int = 40,
    seed: int = 0,
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    deployed: Sequence[ParameterTree] = (),
) -> MonitorDesign:
    """Return the trees that monitor a twin at a load.

    Parameters
    ----------
    twin
        the model; its state parameters are what is monitored.
    load
        where the asset is read. All loads by name: the trees take readings at them as they are. A number of the one
        load: the trees take readings per unit of it. They hold for its multiples where the twin is linear in its loads.
    noise_sd
        of one reading: one number, or by name of the reading.
    levels
        of each parameter; by default 0 to 0.8 of its limit in steps of 0.2.
    depth
        of each tree.
    costs
        of each sensor by name of the reading; 1 where it is left out.
    budget
        most cost of all sensors that some tree reads, each paid for once; None: no limit.
    n_draws
        readings of each state; a quarter of them, of at least 10, is drawn again to judge the trees.
    seed
        of the noise and of the solver.
    limits
        of the solver, of each tree where there is no budget.
    deployed
        trees to start from where there is no budget: a better one takes the place of each.

    Raises
    ------
    ProblemError
        the twin has no state, or levels, noise or costs name what it lacks.
    """
    names = state_parameters(twin)
    if not names:
        raise ProblemError("the twin has no state parameter, so there is nothing to monitor; name one among its states")
    if n_draws < 1:
        raise ProblemError(f"n_draws is {n_draws}; expected 1 or more readings of each state; correct it")
    given = dict(levels or {})
    _refuse_unknown("levels", given, names)
    _refuse_unknown("costs", costs or {}, twin.gauges)
    grid = [
        sorted(given.get(name, default_levels(limit))) for name, limit in zip(names, state_limits_of(twin), strict=True)
    ]
    library = library_of(twin, grid_states(grid), _noise(twin, noise_sd), load_factor=load)
    factor = library.checked_load(load)
    truth, readings = _drawn(library, n_draws, seed, factor)
    price = {name: float((costs or {}).get(name, 1.0)) for name in library.gauges}
    problems = tuple(
        Problem(
            readings,
            library.states[truth, k],
            depth=depth,
            loss=ClassCosts(np.round(PER_CENT * np.abs(np.subtract.outer(grid[k], grid[k])), 9)),
            feature_names=library.gauges,
            sensor_cost=price,
            target_name=name,
        )
        for k, name in enumerate(names)
    )
    if budget is None:
        start = {one.parameter: one.over(library.gauges).tree for one in deployed}
        solutions = tuple(
            solve(problem, limits=limits, seed=seed, incumbent=start.get(problem.samples.target_name))
            for problem in problems
        )
    else:
        joint = shared_budget(problems, budget, limits=limits, seed=seed)
        problems, solutions = joint.problems, joint.solutions
    of_fresh, fresh = _drawn(library, max(10, n_draws // 4), seed + FRESH, factor)
    return MonitorDesign(library, problems, solutions, fresh, of_fresh, factor)


def _drawn(library: Library, n_draws: int, seed: int, factor: float) -> tuple[NDArray[np.int64], Floats]:
    """Return states (n,) and readings (n, n_gauges) per unit of load factor, `n_draws` of every state."""
    rng = np.random.default_rng(seed)
    truth = np.repeat(np.arange(library.n_states), n_draws)
    noise = rng.standard_normal((len(truth), len(library.gauges))) * library.noise_sd / factor
    return truth, np.asarray(library.strains[truth] + noise)


def _noise(twin: Twin, given: float | Mapping[str, float]) -> list[float]:
    """Return the noise of each reading."""
    if not isinstance(given, Mapping):
        return [float(given)] * len(twin.gauges)
    missing = [name for name in twin.gauges if name not in given]
    _refuse_unknown("noise_sd", given, twin.gauges)
    if missing:
        raise ProblemError(f"noise_sd lacks {missing[0]!r}; expected one for each of {list(twin.gauges)}; add it")
    return [float(given[name]) for name in twin.gauges]


def _refuse_unknown(what: str, given: Mapping[str, object], known: Sequence[str]) -> None:
    unknown = [name for name in given if name not in known]
    if unknown:
        raise ProblemError(f"{what} names {unknown[0]!r}; expected among {list(known)}; correct the name")
