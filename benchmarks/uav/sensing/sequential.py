"""Sensors read one after the other: what fewer readings cost in errors, with the proof, and two plans."""

from pathlib import Path
from typing import Any

from benchmarks.cpu import cpu_seconds
from benchmarks.uav.sensing.readings import LABELS, installed, problem_of, readings
from octmip.interfaces.report.markdown import markdown_table
from octmip.interfaces.report.plan import Wording, plan_text
from octmip.sensing import Group, SequentialProblem, certify_sequential, solve_sequential
from octmip.trees.solution import Limits

Row = dict[str, object]

SECONDS = 60.0
"""Limit of one proof [s]; at depth 3 mu2 reaches it."""
QUESTIONS: dict[int, tuple[dict[str, Any], ...]] = {
    2: ({}, {"price": 0.02}, {"price": 0.05}, {"price": 0.1}, {"budget": 1.0}, {"budget": 1.25}, {"budget": 1.5}),
    3: ({}, {"price": 0.02}, {"price": 0.05}, {"price": 0.1}),
}


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return the table of prices and budgets and the plans; seed 0, misclassified training samples as objective."""
    del folder, seeds
    depths = (2,) if is_smoke else (2, 3)
    rows = [
        row
        for label in LABELS
        for depth in depths
        for question in QUESTIONS[depth]
        if (row := _row(source, label, depth, question, is_smoke))
    ]
    plans = "\n\n".join(f"```text\n{plan(source, label, is_smoke)}\n```" for label in LABELS)
    return f"## Sequential sensing, {source}\n\n{markdown_table(rows)}\n\n{plans}\n"


def _row(source: str, label: str, depth: int, question: dict[str, Any], is_smoke: bool) -> Row:
    data = readings(source, 0, is_smoke)
    sequential = SequentialProblem(problem_of(data, label, depth, installed(data)), **question)
    before = cpu_seconds()
    solution = solve_sequential(sequential, limits=Limits(seconds=SECONDS))
    cpu = cpu_seconds() - before
    found = certify_sequential(sequential, solution)
    return {
        "label": label,
        "depth": depth,
        "asked": ", ".join(f"{name} {value}" for name, value in question.items()) or "cheapest optimal tree",
        "errors": found.errors,
        "expected readings": round(found.expected_readings, 3),
        "worst": found.worst_readings,
        "objective": round(found.objective, 2),
        "bound": round(found.bound, 2),
        "proven": solution.is_optimal,
        "cheapest proven": None if "budget" in question else solution.details["cheapest"] == "proven",
        "CPU s": round(cpu, 2),
    }


def plan(source: str, label: str, is_smoke: bool) -> str:
    """Return a plan with two cables, one for each row of gauges, and 80 % loss recognised within one reading."""
    data = readings(source, 0, is_smoke)
    gauges = installed(data)
    inner = tuple(name for name in gauges if int(name[1:]) <= 8)
    outer = tuple(name for name in gauges if name not in inner)
    cables = {"inner": Group(inner, 1.0), "outer": Group(outer, 1.0)}
    sequential = SequentialProblem(problem_of(data, label, 2, gauges), price=0.01, groups=cables, within={80: 1})
    return plan_text(sequential, solve_sequential(sequential), Wording("microstrain per g", label, "%"))
