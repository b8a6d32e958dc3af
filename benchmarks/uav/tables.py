"""The table of the study in Markdown and JSON, and what it says in words."""

from collections.abc import Sequence

from benchmarks.tables import markdown
from benchmarks.uav.glance import glance
from benchmarks.uav.study import CRITICAL_PERCENT, CRITICAL_WEIGHT, LABELS, Outcome, pick

METHOD_NAMES = {
    "cart": "CART",
    "search": "local search",
    "exact": "exact branch and bound",
    "oct": "OCT (HiGHS)",
    "benders": "Benders on HiGHS",
    "flow": "strengthened (HiGHS)",
    "oct_h": "OCT-H (HiGHS)",
}
HEADER = (
    *("task", "depth", "gauges", "method", "errors", "cost", "lower bound", "gap", "proven", "MAE train", "MAE test"),
    *("Bayes limit (MAE)", "paper train / test", "gauges used", "s", "limit"),
)


def text_of(outcomes: Sequence[Outcome], answers: Sequence[str]) -> str:
    """Return the whole of table.md: the answer in words, then one table a label."""
    first = outcomes[0].row
    lines = [
        "# UAV study: how far is the heuristic tree from the optimum, and what can no tree know?",
        "",
        f"Data: {first['data']}. Labels in percent loss of stiffness; errors are misclassified training samples; MAE "
        "in percent stiffness. The Bayes limit is the least MAE of any classifier with these gauges and this noise: a "
        "training MAE below it is overfitting. Every row was certified; seed "
        f"{first['seed']}, one thread per row. Tasks: axis-aligned splits; splits over two, three or all features; at "
        f"most two of the gauges; risk, where samples over {CRITICAL_PERCENT} % loss weigh {CRITICAL_WEIGHT:g}. The "
        "cost is what a method minimises and what its bound speaks of; a row that stops at its limit (last column) "
        "shows its gap.",
        "",
        *(f"* {answer}" for answer in answers),
        "",
        *glance(outcomes),
    ]
    for label in LABELS:
        rows = [o.row for o in outcomes if o.cell.label == label]
        lines += ["", f"## {label}: {rows[0]['n_train']} training samples", "", markdown(HEADER, map(_cells, rows))]
    return "\n".join(lines) + "\n"


def _cells(row: dict[str, object]) -> list[object]:
    paper = "" if row["paper_mae_train"] is None else f"{row['paper_mae_train']} / {row['paper_mae_test']}"
    bound = "-" if row["bound"] is None else f"{row['bound']:g}"
    gap = "-" if row["gap"] is None else f"{100 * float(str(row['gap'])):.1f} %"
    sensors = row["sensors"]
    assert isinstance(sensors, list)
    return [
        row["task"],
        row["depth"],
        row["n_gauges"],
        METHOD_NAMES[str(row["method"])],
        row["errors"],
        f"{row['objective']:g}",
        bound,
        gap,
        "yes" if row["is_optimal"] else "no",
        f"{row['mae_train']:.2f}",
        f"{row['mae_test']:.2f}",
        f"{row['bayes_mae']:.2f}",
        paper,
        " ".join(str(name) for name in sensors),
        f"{row['seconds']:.2f}",
        f"{row['seconds_limit']:g}",
    ]


def answers(outcomes: Sequence[Outcome]) -> list[str]:
    """Return one sentence a label and depth on the 20 gauges: greedy against the optimum, and the Bayes limit."""
    depths = sorted({o.cell.depth for o in outcomes if o.cell.task == "axis"})
    return [_answer(outcomes, label, depth) for label in LABELS for depth in depths]


def _answer(outcomes: Sequence[Outcome], label: str, depth: int) -> str:
    greedy = pick(outcomes, label=label, depth=depth, gauge_set="all", method="cart", task="axis")
    best = pick(outcomes, label=label, depth=depth, gauge_set="all", task="axis")
    bound = max(o.solution.bound for o in outcomes if _is_same_task(o, greedy))
    n = int(str(greedy.row["n_train"]))
    least = 100 * float(str(best.row["bayes_error_rate"]))
    proof = f"the proven optimum makes {best.row['errors']}"
    if bound < best.solution.objective:
        proof = f"the best tree found makes {best.row['errors']} (no tree makes fewer than {max(bound, 0):g})"
    return (
        f"{label}, depth {depth}: CART makes {greedy.row['errors']} of {n} errors, {proof}; no classifier can be "
        f"expected to make fewer than {least:.1f} % ({least * n / 100:.0f}), and the best tree's test MAE of "
        f"{best.row['mae_test']:.2f} % stands against a Bayes limit of {best.row['bayes_mae']:.2f} %."
    )


def _is_same_task(one: Outcome, other: Outcome) -> bool:
    mine, others = one.cell, other.cell
    return (mine.task, mine.label, mine.depth, mine.gauges) == (others.task, others.label, others.depth, others.gauges)
