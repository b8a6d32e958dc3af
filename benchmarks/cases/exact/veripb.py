"""Proofs that veripb checks: sizes, and the CPU seconds of writing and checking them."""

import re
import resource
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.cpu import cpu_seconds
from benchmarks.data import Table, first_rows, published, uci
from benchmarks.tables import Line
from octmip.methods.exact import branch_and_bound
from octmip.problem import Problem
from octmip.pseudo_boolean import check_with_veripb, formula_path

SETS = (
    "iris",
    "wine",
    "breast-cancer-wisconsin-diagnostic",
    "seeds",
    "parkinsons",
    "heart-statlog",
    "vertebral-column-2c",
    "vertebral-column-3c",
    "balance-scale",
    "teaching-assistant-evaluation",
    "planning-relax",
    "spectf-heart-train",
    "mammographic-mass",
)
ROWS = (("mu1", 175), ("mu1", 350), ("mu1", 1750), ("mu2", 175), ("mu2", 350))


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each proof; without veripb its check is left out."""
    tables = [(name, uci(name)) for name in SETS]
    tables += [(f"published {target}, {n} rows", first_rows(published(target, 0), n)) for target, n in ROWS]
    for name, table in tables:
        yield {"size": name, "seed": 0, "threads": 1, **measured(table)}


def measured(table: Table, depth: int = 2) -> Line:
    """Return the figures of one proof."""
    problem = Problem(table.features, table.labels, depth=depth)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.pbp"
        start = cpu_seconds()
        solution = branch_and_bound(problem, proof=path)
        written = cpu_seconds()
        proof = path.read_text()
        assert solution.tree is not None, "a search to its end has a tree"
        line: Line = {
            "samples": problem.n_samples,
            "features": problem.n_features,
            "objective": solution.objective,
            "formula_bytes": formula_path(path).stat().st_size,
            "proof_bytes": len(proof),
            "lemmas": max(0, proof.count("\npbc ") - 1),
            "steps": len(re.findall(r"^pol", proof, re.MULTILINE)),
            "solve_and_write_cpu_seconds": round(written - start, 3),
        }
        if shutil.which("veripb"):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            report = check_with_veripb(problem, path, solution.tree, solution.bound)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            line["bound"] = report.bound
            line["check_cpu_seconds"] = round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 3)
            line["checker"] = report.checker
    return line


def summary(lines: Sequence[Line]) -> str:
    """Return the table of sizes and seconds."""
    head = "| case, depth 2 | samples x features | optimum | formula, kB | proof, MB | lemmas | steps "
    head += "| solve and write, CPU s | check, CPU s |"
    rows = [
        f"| {line['size']} | {line['samples']} x {line['features']} | {line['objective']:g} "
        f"| {line['formula_bytes'] / 1000:.3g} | {line['proof_bytes'] / 1e6:.3g} | {line['lemmas']} "
        f"| {line['steps']:,} | {line['solve_and_write_cpu_seconds']:.3g} | {line.get('check_cpu_seconds', '')} |"
        for line in lines
    ]
    return "\n".join([head, "|---|---|---|---|---|---|---|---|---|", *rows])
