"""Call: what all solvers of one `octmip.trees.solver.solve` share: problem, run and start of the clock."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from octmip.trees.answer.solution import Progress, Solution
from octmip.trees.methods.options import NO_OPTIONS, OPTIONS, Options
from octmip.trees.methods.pruning import fitting
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Run, solvers_of, taker


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
