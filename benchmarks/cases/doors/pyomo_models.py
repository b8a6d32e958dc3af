"""Random Pyomo models that a user changed: `python -m benchmarks.run doors_pyomo`, some two minutes.

A problem of 5 to 7 samples and depth 2, one way of `pyomo_ways.WAYS`, one solver, in turn. All trees of the problem are
enumerated, and those that keep the change are chosen by its meaning. `solution_of` must return one of them with a bound
that none of them is below and a scope that speaks of the change, or refuse in one sentence where nothing can be said.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pyomo.environ as pyo
from pyomo.common.errors import ApplicationError
from pyomo.contrib.solver.common.factory import SolverFactory
from pyomo.contrib.solver.common.util import NoFeasibleSolutionError

from benchmarks.pyomo_ways import WAYS, Changed
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.mip.pyomo_model import model, solution_of
from octmip.trees.question.problem import Problem
from tests.oracles.heap_trees import heap_tree, heap_trees

COUNT, FIRST_SEED = 200, 91_000
PATIENCE = 30.0
"""Seconds that a solver has."""
UNSUPPORTED = (NotImplementedError, ValueError, ApplicationError)
"""What Pyomo raises where a solver does not know a kind of component."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each model."""
    solvers = [name for name, is_there in SOLVERS.items() if is_there()]
    for k in range(COUNT):
        way = list(WAYS)[k % len(WAYS)]
        yield outcome(FIRST_SEED + k, way, solvers[(k + k // len(WAYS)) % len(solvers) :] + solvers)


def outcome(seed: int, way: str, solvers: Sequence[str]) -> Line:
    """Return what `solution_of` made of a random model changed in a way, solved by the first solver that can."""
    rng = np.random.default_rng(seed)
    problem = _problem(rng)
    line: Line = {"size": f"{problem.samples.n_samples} samples", "seed": seed, "way": way}
    for solver in solvers:
        try:
            changed = WAYS[way](model(problem, "oct"), problem, np.random.default_rng(seed), _solve(solver))
        except UNSUPPORTED as error:
            line["unsupported"] = f"{solver}: {error}"[:80]
            continue
        return line | {"solver": solver} | judged(problem, changed)
    return line | {"solver": "none", "answer": "", "fault": ""}


def judged(problem: Problem, changed: Changed) -> Line:
    """Return the answer about a changed model and what is wrong with it, "" for nothing."""
    kept = min((tree.cost for tree in heap_trees(problem) if changed.keeps(tree)), default=np.inf)
    try:
        solution = solution_of(changed.model, changed.results)
    except OctmipError as error:
        is_right = changed.must_refuse or changed.may_refuse or kept == np.inf or "on one side" in str(error)
        return {"answer": f"{type(error).__name__}: {error}", "fault": "" if is_right else "refused"}
    faults = []
    if changed.must_refuse:
        faults.append("not refused")
    if solution.tree is None or not changed.keeps(heap_tree(problem, solution.tree)):
        faults.append("a tree that breaks the change")
    if solution.bound > kept + 1e-9:
        faults.append(f"bound {solution.bound:g} above {kept:g}")
    if ("keep what was added" in str(solution.details["scope"])) != changed.is_narrowed and not changed.may_refuse:
        faults.append("the scope is silent" if changed.is_narrowed else "the scope speaks of nothing")
    return {"answer": f"{solution.stop}: {solution.details['scope']}", "fault": "; ".join(faults)}


def _problem(rng: np.random.Generator) -> Problem:
    """Return a random problem whose trees can be enumerated."""
    n = int(rng.integers(5, 8))
    features = rng.integers(0, 4, (n, 2)).astype(float)
    features[:2] = [[0.0, 0.0], [1.0, 1.0]]  # two values of each feature at least
    labels = rng.integers(0, 2, n)
    labels[:2] = 0, 1
    leaf_size, penalty = int(rng.integers(1, 3)), float(rng.choice([0.0, 0.0, 1.0]))
    return Problem(features, labels, depth=2, leaf_size=leaf_size, leaf_penalty=penalty)


def _solve(name: str) -> Callable[..., Any]:
    """Return how a solver solves a model, and loads its solution unless told not to, or there is none."""

    def solve(M: Any, load: bool = True, seconds: float = PATIENCE) -> Any:
        try:
            return _once(name, M, load, seconds)
        except (NoFeasibleSolutionError, RuntimeError):
            return _once(name, M, False, seconds)

    return solve


def _once(name: str, M: Any, load: bool, seconds: float) -> Any:
    if name.startswith("new "):
        return SolverFactory(name[4:]).solve(
            M, load_solutions=load, raise_exception_on_nonoptimal_result=False, time_limit=seconds
        )
    solver = pyo.SolverFactory(name)
    if name == "appsi_highs":
        solver.highs_options = {"time_limit": seconds}
    else:
        option, value = ("tmlim", max(1, int(seconds))) if name == "glpk" else ("sec", seconds)
        solver.options[option] = value
    return solver.solve(M, load_solutions=load)


def _is_old(name: str) -> Callable[[], bool]:
    return lambda: bool(pyo.SolverFactory(name).available(exception_flag=False))


def _is_new(name: str) -> Callable[[], bool]:
    return lambda: bool(SolverFactory(name).available())


SOLVERS = {name: _is_old(name) for name in ("appsi_highs", "glpk", "cbc")}
SOLVERS |= {f"new {name}": _is_new(name) for name in ("highs", "scip_direct")}
"""Whether each solver is installed, by its name in Pyomo; "new" stands before those of `pyomo.contrib.solver`."""


def summary(lines: list[Line]) -> str:
    """Return one line of counts, and the models that are not as they ought to be."""
    refused = sum("Error: " in line["answer"] for line in lines)
    faults = [line for line in lines if line["fault"]]
    solvers = sorted({line["solver"] for line in lines})
    said = (
        f"{len(lines)} models changed in {len({line['way'] for line in lines})} ways, by {', '.join(solvers)}: "
        f"{len(faults)} wrong; {refused} refused in one sentence."
    )
    return "\n".join([said, *(f"{line}" for line in faults)])
