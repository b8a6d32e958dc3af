"""Benders on HiGHS alone: what it proves, with how many subproblems, beside the exact core's optimum."""

from collections.abc import Callable, Iterator
from functools import partial

from benchmarks.cpu import Stopwatch, cpu_limit
from benchmarks.data import Table, first_rows, published, uci
from benchmarks.problem_options import ProblemOptions
from benchmarks.tables import Line
from octmip.trees.certificate import certify
from octmip.trees.methods.search import local_search
from octmip.trees.mip.benders.solver import solve_benders
from octmip.trees.mip.highs import highs
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits
from octmip.trees.solver import solve

PROBLEMS: tuple[tuple[str, ProblemOptions, Callable[[], Table]], ...] = (
    ("iris, depth 2", {"depth": 2}, partial(uci, "iris")),
    ("iris, depth 3", {"depth": 3}, partial(uci, "iris")),
    ("wine, depth 2", {"depth": 2}, partial(uci, "wine")),
    ("published mu1, 175 rows, depth 2", {"depth": 2}, lambda: first_rows(published("mu1", 0), 175)),
    ("published mu1, 350 rows, depth 2", {"depth": 2}, lambda: first_rows(published("mu1", 0), 350)),
    ("published mu1, 1750 rows, depth 2", {"depth": 2}, lambda: published("mu1", 0)),
    ("published mu2, 175 rows, depth 2", {"depth": 2}, lambda: first_rows(published("mu2", 0), 175)),
    ("published mu2, 350 rows, depth 2", {"depth": 2}, lambda: first_rows(published("mu2", 0), 350)),
    ("published mu2, 1750 rows, depth 2", {"depth": 2}, lambda: published("mu2", 0)),
    ("published mu1, 350 rows, depth 3", {"depth": 3}, lambda: first_rows(published("mu1", 0), 350)),
)


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each problem and number of threads; the limit is in CPU seconds of this process."""
    for name, options, table in PROBLEMS:
        data = table()
        problem = Problem(data.features, data.labels, **options)
        start = local_search(problem, limits=Limits(seconds=5), seed=0).tree
        optimum = solve(problem, "exact", limits=Limits(seconds=60)).objective
        for n_jobs in threads:
            watch = Stopwatch()
            found = solve_benders(problem, incumbent=start, n_jobs=n_jobs, **cpu_limit(limit))
            cpu, wall = watch.read()
            certify(problem, found)
            yield {
                "size": name,
                "seed": 0,
                "threads": n_jobs,
                "optimum": optimum,
                "objective": found.objective,
                "bound": found.bound,
                "stop": str(found.stop),
                "subproblems": found.n_nodes,
                "cpu_seconds": round(cpu, 2),
                "seconds": round(wall, 2),
                "version": f"HiGHS {highs.VERSION}",
            }


def summary(lines: list[Line]) -> str:
    """Return the table."""
    head = ["case", "threads", "optimum", "found", "bound", "subproblems", "CPU s", "wall s"]
    names = ("size", "threads", "optimum", "objective", "bound", "subproblems", "cpu_seconds", "seconds")
    rows = [
        "| " + " | ".join(f"{line[name]:g}" if name != "size" else line[name] for name in names) + " |"
        for line in lines
    ]
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *rows])
