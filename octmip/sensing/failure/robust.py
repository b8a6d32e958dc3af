"""Trees that stay good when sensors fail: least expected objective, or least objective of the worst scenario.

Expected: the stacked problem (octmip.sensing.failure.scenarios), so any solver and its proof serve.

Worst: for shares q >= 0 that sum to 1

    min over T of sum_s q_s R(T, x^s)   <=   min over T of max over s of R(T, x^s),

so every stacked problem solved with its proof gives a lower bound, also when q leaves scenarios out, and every tree an
upper one. Another lower bound is what a tree can still do when its root is stuck
(`octmip.sensing.failure.root_bound`). Shares move towards the scenarios in which the last tree did badly
(multiplicative weights); scenarios that no tree so far has seen, because it does not read the failed sensor, are left
out until one does. Trees are not mixed, so the two bounds need not meet: the gap is stated.
Source: Y. Freund, R. E. Schapire, Adaptive game playing using multiplicative weights, Games Econ. Behav. 29 (1999).
"""

import math
import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.problem import Problem
from octmip.sensing.failure.root_bound import bound_by_stuck_roots
from octmip.sensing.failure.scenarios import FailureProblem
from octmip.solution import Limits, Solution, Stop
from octmip.solver import Method, solve
from octmip.tree import Node

Floats = NDArray[np.float64]

GRID = 256
"""Shares are multiples of 1 / GRID, so that stacked weights are whole."""


def solve_expected(
    asked: FailureProblem,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
) -> Solution:
    """Return the tree of least expected objective over the scenarios, with the bound of its solver.

    Within a limit of time a fifth of it goes to the problem without failures: no tree is returned that is worse in
    expectation than the one found there.

    Raises
    ------
    ProblemError, SolverError
        as `octmip.solve`.
    """
    stacked, scale = asked.stacked(asked.probabilities)
    start = time.perf_counter()
    usual = None
    if math.isfinite(limits.seconds):
        usual = solve(asked.problem, method, replace(limits, seconds=limits.seconds / 5), seed=seed, n_jobs=n_jobs)
    is_interrupted = usual is not None and usual.stop is Stop.INTERRUPTED
    spent = math.inf if is_interrupted else time.perf_counter() - start
    left = limits if usual is None else replace(limits, seconds=max(0.0, limits.seconds - spent))
    found = _better(stacked, solve(stacked, method, left, seed=seed, n_jobs=n_jobs), usual)
    if is_interrupted and found.stop is not Stop.OPTIMAL:
        found = replace(found, stop=Stop.INTERRUPTED)
    objective, bound = found.objective / scale, math.nextafter(found.bound / scale, -math.inf)
    tolerance = 0.0
    if found.bound == found.objective:
        bound = objective
    elif found.is_optimal:
        # Of the shares' own rounding, too: a trillionth.
        tolerance = max(found.tolerance / scale, objective - bound, 1e-12 * objective)
        tolerance = tolerance if tolerance < asked.least_saving(over_worst=False) else 0.0
    stop = Stop.NUMERICS if found.stop is Stop.OPTIMAL and bound < objective - tolerance else found.stop
    details = {**found.details, "over": "expected"}
    seconds = time.perf_counter() - start
    return replace(
        found, objective=objective, bound=bound, stop=stop, tolerance=tolerance, details=details, seconds=seconds
    )


def _better(stacked: Problem, found: Solution, usual: Solution | None) -> Solution:
    """Return the solution found, or with the tree of the problem without failures if no proof says that it is best."""
    if usual is None or usual.tree is None or found.is_optimal:
        return found
    objective = stacked.objective(usual.tree)
    return replace(found, tree=usual.tree, objective=objective) if objective < found.objective else found


def solve_worst(
    asked: FailureProblem,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    rounds: int = 12,
) -> Solution:
    """Return a tree of least objective in the worst scenario, "nothing has failed" among them, and a lower bound.

    Parameters
    ----------
    rounds
        stacked problems that are solved.

    Raises
    ------
    ProblemError
        `rounds` is below 1.
    SolverError
        as `octmip.solve`.
    """
    if rounds < 1:
        raise ProblemError(f"rounds is {rounds}; expected 1 or more; give a number of rounds")
    start = time.perf_counter()
    each = replace(limits, seconds=limits.seconds / (4 * len(asked.scenarios)))
    game = _Game(asked, bound=bound_by_stuck_roots(asked, each, n_jobs))
    for _ in range(rounds):
        spent = time.perf_counter() - start
        stacked, scale = asked.stacked(game.shares)
        # Half of what is left: the first round needs no more, and later ones are worth as much.
        left = replace(limits, seconds=max(0.0, limits.seconds - spent) / 2)
        found = solve(stacked, method, left, seed=seed, n_jobs=n_jobs)
        game.play(found, scale)
        if game.is_closed(limits.gap) or found.stop in (Stop.INTERRUPTED, Stop.TIME):
            break
    return game.solution(time.perf_counter() - start, seed)


@dataclass(slots=True)
class _Game:
    """Bounds and shares of the game between trees and scenarios."""

    asked: FailureProblem
    shares: Floats = field(init=False)
    seen: NDArray[np.bool_] = field(init=False)
    tree: Node | None = None
    worst: float = math.inf
    bound: float = -math.inf
    n_nodes: int = 0
    n_rounds: int = 0
    stop: Stop = Stop.FINISHED

    def __post_init__(self) -> None:
        n = len(self.asked.scenarios) + 1
        self.shares, self.seen = np.eye(n)[0], np.eye(n)[0] > 0

    def play(self, found: Solution, scale: float) -> None:
        """Take one solution in: both bounds, and shares for the next round."""
        assert found.tree is not None
        self.n_rounds, self.n_nodes = self.n_rounds + 1, self.n_nodes + found.n_nodes
        self.bound = max(self.bound, found.bound / scale)
        objectives = self.asked.objectives(found.tree)
        if objectives.max() < self.worst:
            self.tree, self.worst = found.tree, float(objectives.max())
        if found.stop in (Stop.INTERRUPTED, Stop.TIME):
            self.stop = found.stop
        is_new = ~self.seen & (objectives > objectives[0])
        self.seen |= is_new
        # A scenario that is new begins with the mean share of those known.
        shares = np.where(is_new, self.shares[self.shares > 0].mean(), self.shares)
        spread = float(np.ptp(objectives)) or 1.0
        regret = (objectives - objectives.max()) / spread
        shares = np.where(self.seen, shares * np.exp(2.0 / np.sqrt(self.n_rounds) * regret), 0.0)
        self.shares = on_grid(shares / shares.sum())

    def is_closed(self, gap: float) -> bool:
        return self.bound >= self.worst * (1.0 - max(gap, 1e-9))

    def solution(self, seconds: float, seed: int) -> Solution:
        details = {"over": "worst", "rounds": self.n_rounds}
        near = 1e-9 * self.worst
        tolerance = near if near < self.asked.least_saving(over_worst=True) else 0.0
        # Above the objective by rounding only: more is a wrong claim, which `certify_failures` has to see.
        bound = min(self.bound, self.worst) if self.bound <= self.worst + near else self.bound
        stop = Stop.OPTIMAL if bound >= self.worst - tolerance else self.stop
        if stop is not Stop.OPTIMAL and bound >= self.worst - near and self.stop is Stop.FINISHED:
            stop = Stop.NUMERICS
        return Solution(
            self.tree, self.worst, bound, stop, seconds, self.n_nodes, "robust", "1", seed, tolerance, details
        )


def on_grid(shares: Floats) -> Floats:
    """Return the shares as multiples of 1 / GRID that sum to 1, by largest remainders."""
    scaled = shares * GRID
    whole = np.floor(scaled)
    rest = GRID - int(whole.sum())
    whole[np.argsort(whole - scaled, kind="stable")[:rest]] += 1
    return whole / GRID
