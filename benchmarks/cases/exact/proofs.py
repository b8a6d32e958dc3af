"""Proof logs of the exact core: sizes, and the seconds of solving, writing and checking."""

import statistics
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.cpu import Stopwatch
from benchmarks.data import Table, published, synthetic_uav, uci
from benchmarks.tables import Line, markdown
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.proof import check_proof

REPEATS = 3
Seconds = tuple[float, float]
"""Of the processor, and of the clock."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each logged proof, each with medians of three runs."""
    cancer, mu1, mu2 = uci("breast-cancer-wisconsin-diagnostic"), published("mu1", 0), published("mu2", 0)
    for size, table, depth, costs in (
        ("breast cancer, depth 3", cancer, 3, _mistakes),
        ("breast cancer, depth 4", cancer, 4, _mistakes),
        ("wine, depth 3", uci("wine"), 3, _mistakes),
        ("pima-diabetes, depth 3", uci("pima-diabetes"), 3, _mistakes),
        ("vertebral-column-3c, depth 3", uci("vertebral-column-3c"), 3, _mistakes),
        ("seeds, depth 3", uci("seeds"), 3, _mistakes),
        ("synthetic UAV B, depth 3", synthetic_uav("B"), 3, _mistakes),
        ("published strains, mu1, depth 3", mu1, 3, _mistakes),
        ("published strains, mu2, depth 3", mu2, 3, _mistakes),
        ("published mu2, depth 2, distances", mu2, 2, _distances),
        ("published mu2, depth 2, risk", mu2, 2, _risks),
        ("published mu2, depth 3, risk", mu2, 3, _risks),
    ):
        problem = Problem(table.features, table.labels, depth=depth, loss=ClassCosts(costs(table)))
        yield {"size": size, "seed": 0, "threads": max(threads), **_measured(problem, max(threads))}


def _mistakes(table: Table) -> NDArray[np.float64]:
    return 1.0 - np.eye(len(np.unique(table.labels)))


def _distances(table: Table) -> NDArray[np.float64]:
    levels = np.unique(table.labels).astype(np.float64)
    return np.abs(levels[:, None] - levels)


def _risks(table: Table) -> NDArray[np.float64]:
    """Return the costs of wrong levels: 1, and 5 across the line between 40 and 60 percent."""
    is_high = np.unique(table.labels) > 50
    return np.where(np.eye(len(is_high)) > 0, 0.0, np.where(is_high[:, None] == is_high, 1.0, 5.0))


def _measured(problem: Problem, n_threads: int) -> Line:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        solution = branch_and_bound(problem)
        solve = _seconds(lambda: branch_and_bound(problem))
        solve_on_threads = _seconds(lambda: branch_and_bound(problem, n_jobs=n_threads))
        write = _seconds(lambda: branch_and_bound(problem, incumbent=solution, options=ExactOptions(proof=path)))
        report = check_proof(problem, path, bound=solution.bound)
        check = _seconds(lambda: check_proof(problem, path))
        check_on_threads = _seconds(lambda: check_proof(problem, path, n_jobs=n_threads))
    return {
        "objective": solution.objective,
        "bound": report.bound,
        "log_bytes": report.n_bytes,
        "log_lines": report.n_lines,
        "solve_cpu_seconds": solve[0],
        "solve_and_write_cpu_seconds": write[0],
        "check_cpu_seconds": check[0],
        "solve_wall_seconds_on_threads": solve_on_threads[1],
        "check_wall_seconds_on_threads": check_on_threads[1],
    }


def _seconds(work: Callable[[], object]) -> Seconds:
    runs = []
    for _ in range(REPEATS):
        watch = Stopwatch()
        work()
        runs.append(watch.read())
    cpu, wall = (round(statistics.median(kind), 4) for kind in zip(*runs, strict=True))
    return cpu, wall


def summary(lines: Sequence[Line]) -> str:
    """Return the table of sizes and seconds."""
    threads = max(line["threads"] for line in lines)
    head = ["case", "proven", "log, kB", "solve, CPU s", "solve again and write", "check", "check / solve"]
    head += [f"solve, wall s on {threads} threads", "check", "check / solve"]
    rows = []
    for line in lines:
        spent = [f"{line[f'{what}_cpu_seconds']:.3g}" for what in ("solve", "solve_and_write", "check")]
        walls = [f"{line[f'{what}_wall_seconds_on_threads']:.3g}" for what in ("solve", "check")]
        cells = [line["size"], f"{line['bound']:g}", f"{line['log_bytes'] / 1000:.3g}", *spent]
        rows.append([*cells, _ratio(line, "cpu_seconds"), *walls, _ratio(line, "wall_seconds_on_threads")])
    return markdown(head, rows)


def _ratio(line: Line, kind: str) -> str:
    return f"{line[f'check_{kind}'] / max(line[f'solve_{kind}'], 1e-6):.2g}"
