"""How much of OCT's gap the rows of Benders at the root close, by the number of subproblems solved for them.

A line is one linear relaxation of OCT: as printed, with the rows from class counts alone (0 subproblems), and after 1,
4, 16, ... subproblems, the last once no cut is left that may be better. The gap is what the relaxation misses of the
optimum, which the exact core proves. CPU seconds are those of the rows and of the relaxation.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import highspy
from matplotlib import rc_context
from matplotlib.figure import Figure

from benchmarks.cpu import cpu_seconds
from benchmarks.data import Table, first_rows, published, uci
from benchmarks.tables import Line, markdown
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.mip import oct
from octmip.trees.mip.benders.root_rows import root_bounds
from octmip.trees.mip.highs import highs, worker
from octmip.trees.mip.prices import whole_prices
from octmip.trees.problem import Problem

STEPS = (0, 1, 16, 64, 256, 10**6)
"""Subproblems, the last number more than there are."""
PROBLEMS: tuple[tuple[str, Callable[[], Table]], ...] = (
    ("iris", partial(uci, "iris")),
    ("wine", partial(uci, "wine")),
    ("mu1, 1,750 rows", partial(published, "mu1", 0)),
    ("mu2, 175 rows", lambda: first_rows(published("mu2", 0), 175)),
    ("mu2, 1,750 rows", partial(published, "mu2", 0)),
)


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each problem and number of subproblems; a relaxation that takes over the limit has no bound."""
    for name, table in PROBLEMS:
        data = table()
        problem = Problem(data.features, data.labels, depth=2)
        best = branch_and_bound(problem).objective
        last = -1
        for step in (None, *STEPS):
            before = cpu_seconds()
            bound, n_solved = relaxation(problem, step, limit)
            if n_solved == last:  # none was left to be solved
                break
            last = -1 if n_solved is None else n_solved
            yield {
                "size": f"{name}, depth 2",
                "seed": 0,
                "subproblems": n_solved,
                "objective": best,
                "bound": bound,
                "closed": None if bound is None else bound / best,
                "cpu_seconds": round(cpu_seconds() - before, 3),
                "version": f"HiGHS {highs.VERSION}",
            }


def relaxation(problem: Problem, n_subproblems: int | None, limit: float) -> tuple[float | None, int | None]:
    """Return the value of OCT's linear relaxation, in the problem's units, and the number of subproblems solved.

    The value is None beyond the limit of seconds; `n_subproblems` is None for the rows as printed.
    """
    tree = greedy_tree(problem).tree
    assert tree is not None
    prices = whole_prices(problem, problem.objective(tree))
    root = None if n_subproblems is None else root_bounds(problem, prices, tree, n_subproblems)
    solver = worker.load(
        highs.arrays(oct.encode(problem, prices=prices, root=None if root is None else root.bounds).rows)
    )
    assert solver is not None
    solver.setOptionValue("solve_relaxation", True)
    solver.setOptionValue("time_limit", limit)
    solver.setOptionValue("solver", "ipm")
    solver.run()
    is_solved = solver.getModelStatus() == highspy.HighsModelStatus.kOptimal
    value = prices.true(solver.getInfo().objective_function_value) if is_solved else None
    return value, None if root is None else root.n_subproblems


def picture(lines: Sequence[Line], path: Path) -> None:
    """Draw the share of the optimum that the relaxation reaches against the number of subproblems."""
    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    axes = figure.add_subplot()
    for size in dict.fromkeys(line["size"] for line in lines):
        own = [line for line in lines if line["size"] == size and line["subproblems"] is not None]
        known = [line for line in own if line["closed"] is not None]
        axes.plot(
            [line["subproblems"] for line in known], [100 * line["closed"] for line in known], marker="o", label=size
        )
    axes.set_xscale("symlog", linthresh=1)
    axes.set(xlabel="subproblems solved for the rows", ylabel="relaxation / optimum [%]", ylim=(0, 105))
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", loc="lower right")
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "root"}):
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def summary(lines: list[Line]) -> str:
    """Return the table."""
    head = ["case", "subproblems", "relaxation", "optimum", "closed", "CPU s"]
    rows = []
    for line in lines:
        solved = "as printed" if line["subproblems"] is None else f"{line['subproblems']:,}"
        value = "-" if line["bound"] is None else f"{line['bound']:.4g}"
        closed = "-" if line["closed"] is None else f"{100 * line['closed']:.1f} %"
        rows.append([line["size"], solved, value, f"{line['objective']:g}", closed, f"{line['cpu_seconds']:.3g}"])
    return markdown(head, rows)
