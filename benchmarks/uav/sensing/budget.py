"""Budgets of gauges: the proven frontier of each label, and trees of both labels under one budget."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.cpu import cpu_seconds
from benchmarks.uav.sensing.readings import LABELS, installed, problem_of, readings
from octmip import Problem
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import placement_frontier, shared_budget

BUDGETS = (1, 2, 3, 4, 5)
SHARED_DEPTH = 2
Row = dict[str, object]


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return both tables; seed 0, misclassified training samples as objective."""
    del folder, seeds
    depths = (2,) if is_smoke else (2, 3)
    own = [frontier_row(source, label, depth, is_smoke) for label in LABELS for depth in depths]
    shared = shared_rows(source, is_smoke)
    return (
        f"## Budgets of each label, {source}: errors by gauges allowed\n\n{markdown_table(own)}\n\n"
        f"## mu1 and mu2 under one budget, {source}, depth {SHARED_DEPTH}\n\n{markdown_table(shared)}\n"
    )


def frontier_row(source: str, label: str, depth: int, is_smoke: bool) -> Row:
    """Return the errors for each budget, whether all are proven, and the CPU seconds of the whole frontier."""
    data = readings(source, 0, is_smoke)
    problem = problem_of(data, label, depth, installed(data))
    before = cpu_seconds()
    points = placement_frontier(problem, values=BUDGETS)
    cpu = cpu_seconds() - before
    assert points[-1].solution.tree is not None  # the exact core always returns one
    return {
        "strains": source,
        "label": label,
        "depth": depth,
        **{f"{point.value:g}": round(point.solution.objective) for point in points},
        "all proven": all(point.solution.is_optimal for point in points),
        "gauges of the last": " ".join(problem.sensors_used(points[-1].solution.tree)),
        "CPU s": f"{cpu:.2f}",
    }


def shared_rows(source: str, is_smoke: bool) -> list[Row]:
    """Return for each budget what the best baseline split and what both labels together reach."""
    data = readings(source, 0, is_smoke)
    problems = [problem_of(data, label, SHARED_DEPTH, installed(data)) for label in LABELS]
    return [_shared_row(source, problems, budget) for budget in BUDGETS]


def _shared_row(source: str, problems: Sequence[Problem], budget: int) -> Row:
    before = cpu_seconds()
    joint = shared_budget(problems, budget)
    cpu = cpu_seconds() - before
    shares = " + ".join(f"{share:.0f}" for share in joint.baseline_split.budgets)
    return {
        "strains": source,
        "budget": budget,
        "best baseline split": f"{joint.baseline_split.objective:.0f} ({shares})",
        "together": round(joint.objective),
        "bound": round(joint.bound),
        "proven": joint.is_optimal,
        "mu1, mu2": ", ".join(f"{solution.objective:.0f}" for solution in joint.solutions),
        "gauges": " ".join(joint.sensors),
        "sets branched on": joint.n_nodes,
        "CPU s": f"{cpu:.2f}",
    }
