"""Call: what all solvers of one `octmip.trees.solver.solve` share, and Pause: a search in the midst of a proof.

A proof pauses for a local search where its bound does not keep up with the clock. It is not given up: it goes on in the
time that the search leaves.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from octmip.trees.answer.solution import Progress, ProgressCallback, Solution
from octmip.trees.methods.options import NO_OPTIONS, OPTIONS, Options, SearchOptions
from octmip.trees.methods.pruning import fitting
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import EXACT, NUMBERS, SHAPED, Run, solvers_of, taker

PAUSING = (EXACT, SHAPED, NUMBERS)
SOON, LATE = 0.15, 0.8
"""Shares of the time limit after which a proof may pause: of "auto", and of a method that is asked for a proof."""
RESERVE = 1.0
"""Seconds at the end, or `1 - LATE` of the limit, that are left to a search for which the proof did not pause."""
LATER = 2**40
"""A bit of the seed: restarts that were made before the proof are not made again."""


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
        solution = solvers_of(self.problem)[name].load()(
            self.problem,
            limits=replace(run.limits, seconds=share * max(0.0, run.limits.seconds - spent)),
            incumbent=tree,
            seed=run.seed,
            n_jobs=run.n_jobs,
            progress=self._shifted_progress(spent),
            options=options_for(self.problem, name, options),
        )
        return fitting(self.problem, solution) if self.problem.shape.is_shaped else solution

    def _shifted_progress(self, spent: float) -> Callable[[Progress], None] | None:
        progress = self.run.progress
        return progress and (lambda state: progress(replace(state, seconds=state.seconds + spent)))


@dataclass(slots=True)
class Pause:
    """What a proof shows its progress to.

    Attributes
    ----------
    search
        the search of a number, from a tree, which takes no more than the time that is left.
    seconds
        the time limit, by the clock of the states.
    due
        seconds before which there is no pause.
    shown
        is shown the states, with the cost of the best tree.
    found
        the best tree that is known.
    n_searches
        that were made.
    """

    search: Callable[[int, Solution | None], Solution]
    seconds: float
    due: float
    shown: ProgressCallback | None
    found: Solution | None
    n_searches: int = 0

    def __call__(self, state: Progress) -> None:
        """Show a state, and search if its bound is a smaller share of the tree than the time spent is of the limit.

        A bound that rises as fast as the clock will meet the tree in time. Between two searches the proof has as long
        as the first of them had.
        """
        objective = state.objective if self.found is None else min(state.objective, self.found.objective)
        if self.shown is not None:
            self.shown(replace(state, objective=objective))
        if state.seconds >= self.due and state.bound * self.seconds < state.seconds * objective:
            self.due = state.seconds + 2 * self.look()

    def look(self) -> float:
        """Search, and return the seconds that it took."""
        found = self.search(self.n_searches, self.found)
        self.n_searches += 1
        self.found = found
        return found.seconds

    @property
    def proof_share(self) -> float:
        """Share of the time that is the proof's."""
        return max(LATE, 1.0 - RESERVE / self.seconds) if self.seconds else LATE


def pause_of(call: Call, name: str, first: Solution | None) -> Pause | None:
    """Return the pause of an exact proof that starts from a tree, or from none; None where nothing can be searched."""
    solvers = solvers_of(call.problem)
    if solvers[name] not in PAUSING or solvers["search"].refusal(call.problem) is not None:
        return None
    limit = call.run.limits.seconds

    def search(number: int, known: Solution | None) -> Solution:
        # Restarts that were made are not made again. By no cluster: its processes are the proof's.
        seed = call.run.seed if known is None else call.run.seed ^ (number + 1) * LATER
        silent = replace(call, run=replace(call.run, progress=None, seed=seed))
        return silent.solve("search", None if known is None else known.tree, options=SearchOptions())

    due = (SOON if call.run.method == "auto" else LATE) * limit
    return Pause(search, limit, due, call.run.progress, first)


def quiet(call: Call) -> Call:
    """Return a call that shows nothing: a search knows no bound, and a proof's last one stays the one that is shown."""
    return replace(call, run=replace(call.run, progress=None))
