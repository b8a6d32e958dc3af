"""The tables of the risk study, in Markdown."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.uav.risk.decisions import UNWEIGHTED, Row
from benchmarks.uav.risk.leaves import Trust


def decision_table(rows: Sequence[Row]) -> str:
    """Return a line for each kind of tree, task and price, means over the seeds."""
    head = (
        "classes",
        "damage",
        "price of a failure",
        "proven optimal",
        "missed critical, train / test",
        "false alarms, train / test",
        "regret in test",
        "CPU s per tree",
    )
    lines = _head(head)
    keys = list(dict.fromkeys((row.classes, row.task, row.price) for row in rows))
    for classes, task, price in keys:
        here = [row for row in rows if (row.classes, row.task, row.price) == (classes, task, price)]
        named = "unweighted" if price == UNWEIGHTED else f"{price:g}"
        proven = sum(row.solution.is_optimal for row in here)
        lines.append(
            f"| {classes} | {task} | {named} | {proven} of {len(here)} "
            f"| {_both(here, lambda rates: rates.missed_critical)} | {_both(here, lambda rates: rates.false_alarm)} "
            f"| {np.mean([row.test.regret for row in here]):.2f} | {np.mean([row.cpu_seconds for row in here]):.2g} |"
        )
    return "\n".join(lines) + "\n"


def _head(columns: Sequence[str]) -> list[str]:
    return ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]


def _both(rows: Sequence[Row], part: Callable[..., float]) -> str:
    train, test = (np.mean([part(getattr(row, rates)) for row in rows]) for rates in ("train", "test"))
    return f"{100 * train:.1f} / {100 * test:.1f} %"


def trust_table(found: Sequence[Trust]) -> str:
    """Return a line for each label, means over the seeds."""
    head = (
        "damage",
        "ECE, plain / Laplace",
        "Brier, plain / Laplace",
        "its reliability, resolution, uncertainty (Laplace)",
        "90 % sets: coverage, states",
        "by state: coverage, states, least of a state",
        "Brier on the fleet, training / fleet's prior",
    )
    lines = _head(head)
    for label in dict.fromkeys(t.label for t in found):
        here = [t for t in found if t.label == label]

        def mean(part: Callable[[Trust], float], of: Sequence[Trust] = here) -> float:
            return float(np.mean([part(t) for t in of]))

        lines.append(
            f"| {label} | {mean(lambda t: t.raw[0]):.4f} / {mean(lambda t: t.laplace[0]):.4f} "
            f"| {mean(lambda t: t.raw[1].score):.4f} / {mean(lambda t: t.laplace[1].score):.4f} "
            f"| {mean(lambda t: t.laplace[1].reliability):.4f}, {mean(lambda t: t.laplace[1].resolution):.4f}, "
            f"{mean(lambda t: t.laplace[1].uncertainty):.4f} "
            f"| {100 * mean(lambda t: t.coverage):.1f} %, {mean(lambda t: t.size):.2f} "
            f"| {100 * mean(lambda t: t.by_class[0]):.1f} %, {mean(lambda t: t.by_class[1]):.2f}, "
            f"{100 * mean(lambda t: t.by_class[2]):.1f} % "
            f"| {mean(lambda t: t.fleet[0]):.4f} / {mean(lambda t: t.fleet[1]):.4f} |"
        )
    return "\n".join(lines) + "\n"
