"""Time to hand OCT at depth 2 on 1750 samples of 20 gauges to HiGHS: array rows beside the Pyomo model."""

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pyomo

from benchmarks.cpu import cpu_seconds
from benchmarks.data import first_rows, published
from benchmarks.oracles.paper_models import oct as paper
from benchmarks.tables import Line
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.mip import flow, oct, oct_h
from octmip.trees.mip.highs import highs, worker
from octmip.trees.problem import Problem
from octmip.trees.tree import Node

SIZES = (175, 1750)


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each way and size; limit and threads have no part in it."""
    for n in SIZES:
        table = first_rows(published("mu2", 0), n)
        problem = Problem(table.features, table.labels, depth=2)
        planes = Problem(table.features, table.labels, depth=2, split="hyperplane")
        start = greedy_tree(problem).tree
        assert start is not None
        for way, build in _ways(problem, planes, start).items():
            before = cpu_seconds()
            build()
            cpu = cpu_seconds() - before
            yield {
                "size": f"published mu2, {n} rows, depth 2",
                "seed": 0,
                "way": way,
                "cpu_seconds": round(cpu, 3),
                "version": f"HiGHS {highs.VERSION}, Pyomo {pyomo.__version__}",
            }


def _ways(problem: Problem, planes: Problem, start: Node) -> dict[str, Callable[[], object]]:
    """Return what hands each form to HiGHS, by name."""
    return {
        "oct, rows": lambda: worker.load(highs.arrays(oct.encode(problem).rows)),
        "oct, Pyomo": lambda: _through_pyomo(problem),
        "oct_h, rows": lambda: worker.load(highs.arrays(oct_h.encode(planes, 0.005).rows)),
        "flow 1, rows": lambda: worker.load(highs.arrays(flow.encode(problem, start, fix=1).rows)),
    }


def _through_pyomo(problem: Problem) -> None:
    """State OCT in Pyomo and let HiGHS read what Pyomo writes."""
    from octmip.trees.mip.highs.worker import SilentHighs

    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "oct.mps")
        paper.paper_model(problem).write(path)
        reader = SilentHighs()
        reader.readModel(path)


def summary(lines: list[Line]) -> str:
    """Return the table."""
    rows = [f"| {line['size']} | {line['way']} | {line['cpu_seconds']:.3g} |" for line in lines]
    return "\n".join(["| case | way | CPU s |", "|---|---|---|", *rows])
