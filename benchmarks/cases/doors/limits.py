"""Limits of time for tables that are large in one way: `python -m benchmarks.run limits`, a quarter of an hour.

For each shape and limit the seconds of a solve of depth three, of the default and of an estimator. Processor time is
what counts on a busy machine, where wall time also holds what others used.
"""

import re
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from benchmarks.tables import Line
from octmip import OptimalTreeClassifier, Problem
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.runs.registry import Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff.default import solve_default

SHAPES: Mapping[str, tuple[int, int, int, int]] = {
    "1,000,000 rows": (10**6, 10, 2, 0),
    "2,000 classes": (20_000, 10, 2000, 0),
    "2,000 columns": (2000, 2000, 2, 0),
    "10,000 levels": (100_000, 6, 2, 10_000),
}
"""Rows, columns, classes, and levels of a text in order, which the last column numbers."""
SECONDS = (2.0, 5.0, 20.0)
STREAM = 91


def table(n_rows: int, n_columns: int, n_classes: int, n_levels: int = 0) -> Problem:
    """Return a problem whose first two columns, and the level if there are any, tell of the class, with noise."""
    rng = np.random.default_rng([STREAM, n_rows, n_columns, n_classes])
    features = rng.normal(size=(n_rows, n_columns)).round(3)
    score = features[:, 0] + features[:, 1] + rng.normal(size=n_rows)
    if n_levels:
        features[:, -1] = rng.integers(n_levels, size=n_rows)
        score += rng.normal(size=n_levels)[features[:, -1].astype(int)]
    return Problem(features, (np.argsort(np.argsort(score)) * n_classes) // n_rows, depth=3)


def fitted(problem: Problem, run: Run) -> Solution:
    """Return the solution of an estimator of depth three; that a limit ended its proof is expected."""
    model = OptimalTreeClassifier(max_depth=3, seconds=run.limits.seconds, random_state=run.seed, n_jobs=run.n_jobs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return model.fit(problem.samples.features, problem.samples.targets).solution_


ASKED: Mapping[str, Callable[[Problem, Run], Solution]] = {
    "depth 3": solve_run,
    "default": lambda problem, run: solve_default(problem, run).solution,
    "estimator": fitted,
}


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield a line for each shape, question and limit of `SECONDS` up to `limit`; `only` is a pattern of the first."""
    for shape, size in SHAPES.items():
        if re.search(only, shape):
            problem = table(*size)
            for asked, solver in ASKED.items():
                for seconds in (s for s in SECONDS if s <= limit):
                    run = Run("auto", Limits(seconds=seconds), 0, max(threads))
                    yield {"size": shape, "asked": asked, "limit": seconds} | measured(problem, run, solver)


def measured(problem: Problem, run: Run, solver: Callable[[Problem, Run], Solution]) -> Line:
    """Return what a call used and how it ended."""
    wall, cpu = time.perf_counter(), time.process_time()
    solution = solver(problem, run)
    used = {"wall_seconds": time.perf_counter() - wall, "cpu_seconds": time.process_time() - cpu}
    return {name: round(value, 2) for name, value in used.items()} | {
        "stop": solution.stop.value,
        "objective": solution.objective,
        "bound": solution.bound,
    }


def summary(lines: Sequence[Line]) -> str:
    """Return the lines as a table."""
    names = ("size", "asked", "limit", "wall_seconds", "cpu_seconds", "stop")
    return markdown_table([{name: line[name] for name in names} for line in lines])
