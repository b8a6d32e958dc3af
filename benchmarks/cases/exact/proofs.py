"""Proof logs of the exact core: sizes, and the CPU seconds of solving, writing and checking."""

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.cpu import cpu_seconds
from benchmarks.data import Table, published, synthetic_uav, uci
from benchmarks.tables import Line
from octmip.methods.exact import branch_and_bound
from octmip.problem import Problem
from octmip.proof import check_proof


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each logged proof."""
    cancer = uci("breast-cancer-wisconsin-diagnostic")
    for size, table, depth in (
        ("breast cancer, depth 3", cancer, 3),
        ("breast cancer, depth 4", cancer, 4),
        ("synthetic UAV B, depth 3", synthetic_uav("B"), 3),
        ("published strains, mu1, depth 3", published("mu1", 0), 3),
        ("published strains, mu2, depth 3", published("mu2", 0), 3),
    ):
        yield {"size": size, "seed": 0, "threads": 1, **_measured(table, depth)}


def _measured(table: Table, depth: int) -> Line:
    problem = Problem(table.features, table.labels, depth=depth)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        start = cpu_seconds()
        solution = branch_and_bound(problem)
        solved = cpu_seconds()
        branch_and_bound(problem, incumbent=solution, proof=path)
        written = cpu_seconds()
        report = check_proof(problem, path, bound=solution.bound)
        checked = cpu_seconds()
    return {
        "objective": solution.objective,
        "bound": report.bound,
        "log_bytes": report.n_bytes,
        "log_lines": report.n_lines,
        "solve_cpu_seconds": round(solved - start, 4),
        "solve_and_write_cpu_seconds": round(written - solved, 4),
        "check_cpu_seconds": round(checked - written, 4),
    }


def summary(lines: Sequence[Line]) -> str:
    """Return the table of sizes and seconds."""
    head = "| case | proven | log, kB | solve, CPU s | solve again and write | check | check / solve |"
    rows = [
        f"| {line['size']} | {line['bound']:g} | {line['log_bytes'] / 1000:.3g} | {line['solve_cpu_seconds']:.3g} "
        f"| {line['solve_and_write_cpu_seconds']:.3g} | {line['check_cpu_seconds']:.3g} "
        f"| {line['check_cpu_seconds'] / max(line['solve_cpu_seconds'], 1e-6):.2g} |"
        for line in lines
    ]
    return "\n".join([head, "|---|---|---|---|---|---|---|", *rows])
