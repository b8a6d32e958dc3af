"""The table of the risk study, in Markdown."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.uav.risk.decisions import UNWEIGHTED, Row


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
