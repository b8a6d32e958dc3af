"""The study at a glance: a row for each task, a column for each method, and the paper's own counts beside."""

from collections.abc import Sequence

from benchmarks.tables import markdown
from benchmarks.uav.study import LABELS, METHODS, Outcome

COLUMNS = {
    **dict(zip(METHODS, ("CART", "search", "exact", "OCT", "strengthened"), strict=True)),
    "benders": "Benders",
    "oct_h": "OCT-H",
}
# Misclassified training samples of 1,750, or their share: the paper's section on sparse sensing, OCT and OCT-H.
PAPER_ERRORS = {
    ("axis", "mu1", 3, "two"): "57",
    ("two features", "mu1", 3, "two"): "20",
    ("axis", "mu2", 3, "two"): "60.1 %",
}


def glance(outcomes: Sequence[Outcome]) -> list[str]:
    """Return the lines of the table."""
    first = outcomes[0].row
    lines = [
        "## At a glance",
        "",
        f"Errors in {first['n_train']} training rows / in {first['n_test']} new rows; the lower bound of the cost, or "
        '"proven" where it is met; seconds. The paper counts errors in training.',
        "A tree with fewer leaves than there are classes errs on the classes that it cannot name: at depth 1 and 2 "
        "this bounds the trees of every method. A bound of 0 is the value of OCT's linear relaxation as printed, which "
        "these seconds do not raise; rows of Benders at its root close the gap (`octmip solve --method oct --option "
        "root_rows=1000`).",
        "",
    ]
    table = []
    tasks = dict.fromkeys((o.cell.label, o.cell.task, o.cell.gauge_set, o.cell.depth) for o in outcomes)
    for label, task, gauge_set, depth in sorted(tasks, key=lambda one: LABELS.index(one[0])):
        rows = {
            o.cell.method: o.row
            for o in outcomes
            if (o.cell.label, o.cell.task, o.cell.gauge_set, o.cell.depth) == (label, task, gauge_set, depth)
        }
        cells = [_cell(rows[method]) if method in rows else "" for method in COLUMNS]
        name = f"{label}, {task}, {next(iter(rows.values()))['n_gauges']} gauges, depth {depth}"
        paper = PAPER_ERRORS.get((task, label, depth, gauge_set), "")
        table.append([name, *cells, paper])
    return [*lines, markdown(["task", *COLUMNS.values(), "paper"], table)]


def _cell(row: dict[str, object]) -> str:
    bound = "no bound" if row["bound"] is None else f"bound {row['bound']:g}"
    reached = "proven" if row["is_optimal"] else bound
    return f"{row['errors']} / {row['errors_test']}, {reached}, {row['seconds']:.1f} s"
