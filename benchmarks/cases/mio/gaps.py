"""Bound against time: printed, strengthened, Benders and exact side by side, CPU seconds to gaps of 10 %, 1 % and 0 %.

Every method starts from the tree of a local search, which is not measured. CPU seconds are those of all threads and of
the process that HiGHS runs in; the limit is in them.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from benchmarks.cpu import cpu_seconds
from benchmarks.data import Table, first_rows, published, uci
from benchmarks.problem_options import ProblemOptions
from benchmarks.tables import Line, markdown
from octmip.trees.certificate import certify
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.mip.benders.solver import solve_benders
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.highs import highs
from octmip.trees.mip.oct import solve_oct
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Progress, Solution, relative_gap

GAPS = (0.1, 0.01, 0.0)
COLOURS = {"printed": "tab:grey", "strengthened": "tab:orange", "Benders": "tab:blue", "exact": "tab:green"}
WIDTHS = {"printed": 6.0, "strengthened": 3.5, "Benders": 1.5, "exact": 1.5}
LINES: ProblemOptions = {"depth": 2, "split": "hyperplane", "split_size": 2}
PROBLEMS: tuple[tuple[str, Callable[[], Table], ProblemOptions], ...] = (
    ("iris, depth 3", partial(uci, "iris"), {"depth": 3}),
    ("wine, depth 2, two features", partial(uci, "wine"), LINES),
    ("published mu2, 175 rows, depth 2", lambda: first_rows(published("mu2", 0), 175), {"depth": 2}),
    ("published mu1, 350 rows, depth 3", lambda: first_rows(published("mu1", 0), 350), {"depth": 3}),
)


def methods(problem: Problem) -> dict[str, Callable[..., Solution]]:
    """Return the methods for a problem, by name."""
    if problem.split == "axis":
        return {"printed": solve_oct, "strengthened": solve_flow, "Benders": solve_benders, "exact": branch_and_bound}
    return {"printed": solve_oct_h, "strengthened": solve_flow, "exact": two_feature_branch_and_bound}


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each problem and method."""
    for name, table, options in PROBLEMS:
        data = table()
        problem = Problem(data.features, data.labels, **options)
        start = local_search(problem, limits=Limits(seconds=5), seed=0).tree
        for method, solve in methods(problem).items():
            traced = _Trace(limit)
            found = solve(
                problem, incumbent=start, n_jobs=threads[0], limits=Limits(seconds=10 * limit), progress=traced
            )
            certify(problem, found)
            traced.note(found.objective, found.bound)
            yield {
                "size": name,
                "method": method,
                "seed": 0,
                "threads": threads[0],
                "limit": limit,
                "objective": found.objective,
                "bound": found.bound,
                "cpu_seconds": round(traced.seconds, 3),
                "wall_seconds": round(found.seconds, 3),
                "to_gap": {f"{gap:g}": traced.to_gap(gap) for gap in GAPS},
                "trace": traced.states,
                "version": f"HiGHS {highs.VERSION}",
            }


class _Trace:
    """The states of a run, those that differ, by CPU seconds; ends the run at a limit of these."""

    def __init__(self, limit: float) -> None:
        self._began, self._limit = cpu_seconds(), limit
        self.states: list[tuple[float, float, float]] = []

    @property
    def seconds(self) -> float:
        return cpu_seconds() - self._began

    def __call__(self, state: Progress) -> None:
        self.note(state.objective, state.bound)
        if self.seconds > self._limit:
            raise KeyboardInterrupt

    def note(self, objective: float, bound: float) -> None:
        at_least = max(bound, 0.0)
        if not self.states or self.states[-1][1:] != (objective, at_least):
            self.states.append((round(self.seconds, 3), objective, at_least))

    def to_gap(self, gap: float) -> float | None:
        """Return the seconds until tree and bound were so close, None if they were not."""
        return next((at for at, objective, bound in self.states if relative_gap(objective, bound) <= gap), None)


def picture(lines: Sequence[Line], path: Path) -> None:
    """Draw each method's bound against CPU seconds, a panel for each problem."""
    sizes = list(dict.fromkeys(line["size"] for line in lines))
    figure = Figure(figsize=(10, 2.9 * ((len(sizes) + 1) // 2)), layout="constrained")
    panels = figure.subplots((len(sizes) + 1) // 2, 2, squeeze=False).ravel()
    for axes, size in zip(panels, sizes, strict=False):
        own = [line for line in lines if line["size"] == size]
        best = min(line["objective"] for line in own)
        axes.axhline(best, color="black", linewidth=0.8, linestyle=":", label="best tree")
        for line in own:
            _draw(axes, line)
        axes.set(xscale="log", xlabel="CPU seconds", ylabel="bound (errors)", title=size)
        axes.grid(alpha=0.3)
    panels[0].legend(fontsize="small")
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "bound"}):
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def _draw(axes: Any, line: Line) -> None:
    """Draw a bound as steps, with a dot where the proof ends."""
    times = [max(at, 0.01) for at, _, _ in line["trace"]] + [max(line["cpu_seconds"], 0.01)]
    bounds = [bound for _, _, bound in line["trace"]]
    colour = COLOURS[line["method"]]
    width = WIDTHS[line["method"]]  # lines that lie on each other are all seen
    steps = [0.0, *bounds, bounds[-1]]
    axes.step([0.01, *times], steps, where="post", color=colour, linewidth=width, label=line["method"])
    if line["bound"] >= line["objective"]:
        axes.plot(times[-1], bounds[-1], "o", color=colour)


def summary(lines: list[Line]) -> str:
    """Return the table."""
    head = ["case", "method", "found", "bound", "CPU s to 10 %", "to 1 %", "to 0 %", "CPU s in all"]
    rows = []
    for line in lines:
        reached = ["-" if at is None else f"{at:.3g}" for at in line["to_gap"].values()]
        cells = [line["size"], line["method"], f"{line['objective']:g}", f"{line['bound']:g}", *reached]
        rows.append([*cells, f"{line['cpu_seconds']:.3g}"])
    return markdown(head, rows)
