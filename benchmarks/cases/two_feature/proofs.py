"""Proof logs of two-feature trees: how large they are, and how long to write and to check beside the search itself."""

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.cpu import cpu_seconds
from benchmarks.tables import Line
from benchmarks.two_feature import CASES
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.problem import Problem
from octmip.trees.proof import check_proof
from octmip.trees.solution import Limits


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each table of `two_feature_trees` that is proven within the limit."""
    for (name, table), _, _ in CASES:
        data = table()
        problem = Problem(data.features, data.labels, depth=2, split="hyperplane", split_size=2)
        yield {"size": name, "seed": 0, "threads": threads[0], "limit": limit} | _line(problem, limit, threads[0])


def _line(problem: Problem, limit: float, n_threads: int) -> Line:
    start = cpu_seconds()
    solution_alone = two_feature_branch_and_bound(problem, limits=Limits(seconds=limit), n_jobs=n_threads)
    solved = cpu_seconds()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        solution = two_feature_branch_and_bound(
            problem, limits=Limits(seconds=limit), n_jobs=n_threads, options=ExactOptions(proof=path), check_log=False
        )
        written = cpu_seconds()
        report = check_proof(problem, path, bound=solution.bound, n_jobs=n_threads)
    checked = cpu_seconds()
    return {
        "objective": solution.objective,
        "bound": report.bound,
        "n_lines": report.n_lines,
        "n_bytes": report.n_bytes,
        "solve_seconds": round(solved - start, 3),
        "write_seconds": round(written - solved - (solved - start), 3),
        "check_seconds": round(checked - written, 3),
        "check_wall_seconds": round(report.seconds, 3),
        "solve_wall_seconds": round(solution_alone.seconds, 3),
    }


def summary(lines: Sequence[Line]) -> str:
    """Return the table of sizes and CPU seconds."""
    rows = [
        f"| {line['size']} | {line['bound']:g} | {line['n_lines']} | {line['n_bytes'] / 1000:.1f} "
        f"| {line['solve_seconds']:.2f} | {line['write_seconds']:.2f} | {line['check_seconds']:.2f} "
        f"| {line['check_seconds'] / max(line['solve_seconds'], 1e-3):.1f} "
        f"| {line['solve_wall_seconds']:.2f} | {line['check_wall_seconds']:.2f} |"
        for line in lines
    ]
    head = (
        "| case | proven | lines | kB | search, CPU s | log, CPU s | check, CPU s | check / search "
        "| search, wall s | check, wall s |"
    )
    return "\n".join([head, "|" + "---|" * 10, *rows])
