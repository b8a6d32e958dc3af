"""Frontiers over 67 candidates: errors against the number and against the cost of gauges, each with its bound.

Axis-aligned trees are proven. Trees with two or four features per split are searched; their bound is the best of the
classes that a tree can name at all and of mixed-integer proofs on some of the samples.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from benchmarks.cpu import cpu_seconds
from benchmarks.uav.sensing.readings import clear_of_regions, installed, problem_of, readings
from femlib.dataset import Dataset
from octmip import Limits, Problem
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import placement_frontier, sample_bound
from octmip.trees.methods.options import SearchOptions
from octmip.trees.tradeoff import Point

NUMBERS = {2: (1, 2, 3, 4, 5), 3: (1, 2, 3, 4)}  # by depth
COSTS = (1, 2, 3, 4, 5, 6)  # at depth 2
AXIS_SECONDS = 120.0  # of one point
NEW_GAUGE_COST = 2.0  # one that is installed costs 1: its wires lie there
SAMPLES = (60, 2)  # rows of a block and blocks of a mixed-integer proof
MIO_SECONDS = 20.0
Row = dict[str, object]


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return the table of mu2, seed 0, misclassified training samples as objective."""
    del folder, seeds
    data = readings(source, 0, is_smoke)
    depths = (2,) if is_smoke else (2, 3)
    rows = [row for depth in depths for row in axis_rows(data, depth)]
    for depth in (1,) if is_smoke else (1, 2, 3):
        rows += hyperplane_rows(data, depth, is_smoke)
    return f"## Frontiers over {len(data.gauges)} candidates, {source}, mu2\n\n{markdown_table(rows)}\n"


def axis_rows(data: Dataset, depth: int) -> list[Row]:
    """Return the proven frontiers over number and cost, and over number without the candidates beside a region."""
    problem = _priced(problem_of(data, "mu2", depth, data.gauges), data)
    clear = problem_of(data, "mu2", depth, clear_of_regions(data))
    rows = _axis_rows(problem, "number", NUMBERS[depth])
    rows += _axis_rows(problem, "cost", COSTS) if depth == 2 else []
    return rows + _axis_rows(clear, "number", NUMBERS[depth], ", 40 mm clear")


def _axis_rows(
    problem: Problem, over: Literal["number", "cost"], values: Sequence[float], of_which: str = ""
) -> list[Row]:
    before = cpu_seconds()
    points = placement_frontier(problem, over, values, limits=Limits(seconds=AXIS_SECONDS))
    cpu = cpu_seconds() - before
    return [_row(f"1, {over}{of_which}", point, cpu) for point in points]


def hyperplane_rows(data: Dataset, depth: int, is_smoke: bool) -> list[Row]:
    """Return the searched frontier over the number of gauges, four features per split, with its bound."""
    problem = problem_of(data, "mu2", depth, data.gauges, 4)
    before = cpu_seconds()
    limits = Limits(seconds=2.0 if is_smoke else MIO_SECONDS)
    bound = sample_bound(problem, *((20, 1) if is_smoke else SAMPLES), limits=limits)
    options = SearchOptions(restarts=1, perturbations=0) if is_smoke else SearchOptions(restarts=2)
    points = placement_frontier(problem, values=(2, 4, 8), bound=bound, options=options)
    cpu = cpu_seconds() - before
    return [{**_row("4, number", point, cpu), "bound from samples": round(bound)} for point in points]


def _priced(problem: Problem, data: Dataset) -> Problem:
    there = set(installed(data))
    return replace(problem, sensor_cost={g: 1.0 if g in there else NEW_GAUGE_COST for g in problem.sensors})


def _row(kind: str, point: Point, cpu: float) -> Row:
    tree = point.solution.tree
    assert tree is not None
    return {
        "features per split, over": kind,
        "depth": point.problem.depth,
        "at most": f"{point.value:g}",
        "errors": round(point.solution.objective),
        "bound": round(point.solution.bound),
        "proven": point.solution.is_optimal,
        "gauges": " ".join(point.problem.sensors_used(tree)),
        "bound from samples": "",
        "CPU s of the frontier": f"{cpu:.1f}",
    }
