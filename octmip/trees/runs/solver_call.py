"""Call: what all solvers of one `octmip.trees.solver.solve` share, and Pause: a search in the midst of a proof.

A proof pauses for a local search where its bound does not keep up with the clock. It is not given up: it goes on in the
time that the search leaves.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Progress, Solution, Stop
from octmip.trees.methods.options import NO_OPTIONS, OPTIONS, ExactOptions, Options, SearchOptions
from octmip.trees.methods.pruning import fitting
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import EXACT, Run, solvers_of, taker

SEARCH_SHARE, FIRST_RESTARTS = 0.2, 4
"""Of the time before a proof, when it is limited, and so few restarts: after these a proof gains more from the time."""
AUTO_SHARE = 0.85
"""Of the time of "auto" where trees are so deep that hardly any proof ends: a search that has ended leaves it more."""
SOON, LATE = 0.15, 0.8
"""Shares of the time limit after which a proof may pause: of "auto", and of a method that is asked for a proof."""
RESERVE = 1.0
"""Seconds at the end, or `1 - LATE` of the limit, that are left to a search for which the proof did not pause."""
LATER = 2**40
"""A bit of the seed: restarts that were made before the proof are not made again."""


def search_before_proof(call: "Call") -> tuple[float, int | None]:
    """Return the share of the time that a search may take before a proof, and its restarts (None: as many as alone)."""
    if call.problem.shape.depth <= EXACT.alone_to_depth:
        return SEARCH_SHARE, 1
    if call.run.method == "auto" and math.isfinite(call.run.limits.seconds):
        return AUTO_SHARE, None
    return SEARCH_SHARE, FIRST_RESTARTS


def options_for(problem: Problem, method: str, given: Options) -> Options:
    """Return options as the class of a method, by which a problem is solved.

    Raises
    ------
    ProblemError
        one is given that the method does not take for this loss and split.
    """
    return given.of_kind(OPTIONS[method], *taker(problem, method))


@dataclass(frozen=True, slots=True)
class Call:
    """The call that all solvers of one `solve` share."""

    problem: Problem
    run: Run
    start: float

    def solve(
        self,
        name: str,
        tree: Node | None,
        *,
        share: float = 1.0,
        options: Options = NO_OPTIONS,
    ) -> Solution:
        """Return the solution of one solver within `share` of the seconds that are left."""
        run, spent = self.run, time.perf_counter() - self.start
        if isinstance(run.progress, Pause) and run.limits.seconds > 0:
            share *= max(LATE, 1.0 - RESERVE / run.limits.seconds)
        solution = solvers_of(self.problem)[name].load()(
            self.problem,
            limits=replace(run.limits, seconds=share * max(0.0, run.limits.seconds - spent)),
            incumbent=tree,
            seed=run.seed,
            n_jobs=run.n_jobs,
            progress=self._shifted_progress(spent),
            options=options_for(self.problem, name, options),
        )
        solution = fitting(self.problem, solution) if self.problem.shape.is_shaped else solution
        is_logged = isinstance(options, ExactOptions) and options.proof is not None
        solution = solution if is_logged else self._bounded(solution)
        return self._over_all_trees(solution) if solvers_of(self.problem)[name].is_mixed_integer else solution

    def _over_all_trees(self, solution: Solution) -> Solution:
        """Return a solution that is proven within a margin with a proof over all trees, where splits have two features.

        The exact core takes at most the time that the proof within the margin took. Where that is too little the
        solution stays what it is; a better tree outside the margin, which no bound closes then, takes its place.
        """
        exact = solvers_of(self.problem).get("exact")
        if not solution.scope or not solution.meets_bound or exact is None or exact.refusal(self.problem) is not None:
            return solution
        left = self.run.limits.remaining(self.start)
        short = replace(self.run, limits=replace(left, seconds=min(left.seconds, solution.seconds)), progress=None)
        try:
            whole = Call(self.problem, short, time.perf_counter()).solve("exact", solution.tree)
        except ProblemError:  # deeper, or of more features, than it proves
            return solution
        if not whole.is_optimal and whole.objective == solution.objective:
            return solution
        details = {name: value for name, value in solution.details.items() if name != "scope"}
        details |= {"bound_in_scope": solution.bound, "bound_by": whole.solver}
        found = replace(solution, tree=whole.tree, objective=whole.objective, stop=whole.stop, details=details)
        return replace(found, bound=whole.bound, tolerance=whole.tolerance)

    def _bounded(self, solution: Solution) -> Solution:
        """Return a solution with the bound by labels, which is about all trees, where its own is no higher.

        A log has no line for it.
        """
        if solution.stop is Stop.OPTIMAL and "scope" not in solution.details:
            return solution
        bound = self.problem.bound_by_labels
        if bound == 0 or bound < solution.bound:
            return solution
        details = {name: value for name, value in solution.details.items() if name != "scope"}
        return replace(solution, details={**details, "bound_by": "more classes than leaves"}).with_bound(bound)

    def _shifted_progress(self, spent: float) -> Callable[[Progress], None] | None:
        progress = self.run.progress
        return progress and (lambda state: progress(replace(state, seconds=state.seconds + spent)))


@dataclass(slots=True)
class Pause:
    """What a proof shows its progress to.

    Attributes
    ----------
    call
        the call that the proof belongs to.
    found
        the best tree that is known.
    n_searches
        that were made.
    due
        seconds, by the clock of the states, before which there is no further pause.
    """

    call: Call
    found: Solution | None
    n_searches: int = 0
    due: float = 0.0

    def __call__(self, state: Progress) -> None:
        """Show a state, and search if its bound is a smaller share of the tree than the time spent is of the limit.

        A bound that rises as fast as the clock will meet the tree in time. Between two searches the proof has as long
        as the first of them had.
        """
        run = self.call.run
        objective = state.objective if self.found is None else min(state.objective, self.found.objective)
        if run.progress is not None:
            run.progress(replace(state, objective=objective))
        soonest = max(self.due, (SOON if run.method == "auto" else LATE) * run.limits.seconds)
        if state.seconds >= soonest and state.bound * run.limits.seconds < state.seconds * objective:
            self.search()
            self.due = state.seconds + 2 * (0.0 if self.found is None else self.found.seconds)

    def search(self) -> None:
        """Search within the time that is left. Restarts that were made are not made again."""
        known, seed = self.found, self.call.run.seed
        seed = seed if known is None else seed ^ (self.n_searches + 1) * LATER
        silent = replace(self.call, run=replace(self.call.run, progress=None, seed=seed))
        # By no cluster: its processes are the proof's.
        self.found = silent.solve("search", None if known is None else known.tree, options=SearchOptions())
        self.n_searches += 1


def quiet(call: Call) -> Call:
    """Return a call that shows nothing: a search knows no bound, and a proof's last one stays the one that is shown."""
    return replace(call, run=replace(call.run, progress=None))
