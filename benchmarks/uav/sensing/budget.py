"""Budgets of gauges: the proven frontier of each label, and trees of both labels under one budget."""

from pathlib import Path

from benchmarks.cpu import cpu_seconds
from benchmarks.uav.sensing.readings import LABELS, installed, problem_of, readings
from octmip.report.markdown import markdown_table
from octmip.sensing import placement_frontier, shared_budget

BUDGETS = (1, 2, 3, 4, 5)
Row = dict[str, object]


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return both tables; seed 0, misclassified training samples as objective."""
    del folder, seeds
    depths = (2,) if is_smoke else (2, 3)
    own = [row for label in LABELS for depth in depths for row in frontier_rows(source, label, depth, is_smoke)]
    shared = shared_rows(source, 2, is_smoke)
    return (
        f"## Budgets of each label, {source}\n\n{markdown_table(own)}\n\n"
        f"## mu1 and mu2 under one budget, {source}\n\n{markdown_table(shared)}\n"
    )


def frontier_rows(source: str, label: str, depth: int, is_smoke: bool) -> list[Row]:
    """Return errors, bound and gauges for each budget, and the CPU seconds of the whole frontier."""
    data = readings(source, 0, is_smoke)
    problem = problem_of(data, label, depth, installed(data))
    before = cpu_seconds()
    points = placement_frontier(problem, values=BUDGETS)
    cpu = cpu_seconds() - before
    return [
        {
            "label": label,
            "depth": depth,
            "gauges allowed": int(point.value),
            "errors": round(point.solution.objective),
            "bound": round(point.solution.bound),
            "proven": point.solution.is_optimal,
            "gauges": " ".join(problem.sensors_used(point.solution.tree)) if point.solution.tree else "",
            "CPU s of the five": f"{cpu:.2f}",
        }
        for point in points
    ]


def shared_rows(source: str, depth: int, is_smoke: bool) -> list[Row]:
    """Return for each budget what the best split by hand and what both labels together reach."""
    data = readings(source, 0, is_smoke)
    problems = [problem_of(data, label, depth, installed(data)) for label in LABELS]
    rows: list[Row] = []
    for budget in BUDGETS:
        before = cpu_seconds()
        joint = shared_budget(problems, budget)
        cpu = cpu_seconds() - before
        errors = [round(solution.objective) for solution in joint.solutions]
        rows.append(
            {
                "depth": depth,
                "budget": budget,
                "best split by hand": f"{joint.hand_split.objective:.0f} "
                + "("
                + " + ".join(f"{b:.0f}" for b in joint.hand_split.budgets)
                + ")",
                "together": round(joint.objective),
                "mu1, mu2": f"{errors[0]}, {errors[1]}",
                "bound": round(joint.bound),
                "proven": joint.is_optimal,
                "gauges": " ".join(joint.sensors),
                "sets branched on": joint.n_nodes,
                "CPU s": f"{cpu:.2f}",
            }
        )
    return rows
