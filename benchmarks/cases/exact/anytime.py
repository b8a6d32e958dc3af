"""Incumbent and bound over time: published strains, mu2, depths 4 to 6, whole calls until proven or out of time."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from benchmarks.cpu import Stopwatch
from benchmarks.data import published
from benchmarks.tables import Line, markdown
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Progress
from octmip.trees.solver import solve

DEPTHS = (4, 5, 6)


def results(limit: float, threads: Sequence[int], depths: Sequence[int] = DEPTHS) -> Iterator[Line]:
    """Yield a line for each depth, with every change of incumbent and bound as [seconds, objective, bound]."""
    table = published("mu2", 0)
    for depth in depths:
        problem = Problem(table.features, table.labels, depth=depth)
        course: list[list[float]] = []

        def note(state: Progress, course: list[list[float]] = course) -> None:
            """Keep a state that differs from the last one."""
            if not course or [state.objective, state.bound] != course[-1][1:]:
                course.append([round(state.seconds, 3), state.objective, state.bound])

        watch = Stopwatch()
        solution = solve(problem, method="exact", limits=Limits(seconds=limit), n_jobs=max(threads), progress=note)
        cpu, wall = watch.read()
        yield {
            "size": f"mu2, depth {depth}",
            "seed": 0,
            "depth": depth,
            "threads": max(threads),
            "outcome": "proven" if solution.is_optimal else "not proven",
            "objective": solution.objective,
            "bound": solution.bound,
            "cpu_seconds": round(cpu, 2),
            "wall_seconds": round(wall, 2),
            "course": [*course, [round(wall, 3), solution.objective, solution.bound]],
        }


def picture(lines: Sequence[Line], path: Path) -> None:
    """Draw errors of the incumbent and bound against seconds, a panel for each depth."""
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    panels = figure.subplots(1, len(lines), sharey=True, squeeze=False)[0]
    for axes, line in zip(panels, lines, strict=True):
        seconds, objective, bound = zip(*line["course"], strict=True)
        at = [max(second, 0.01) for second in seconds]
        axes.step(at, objective, where="post", color="tab:blue", label="incumbent")
        axes.step(at, bound, where="post", color="tab:orange", label="bound")
        axes.set(xscale="log", xlabel="seconds", title=f"depth {line['depth']}: {line['outcome']}", ylim=(0, None))
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("errors of 1,750")
    panels[0].legend()
    with rc_context({"svg.fonttype": "none"}):
        figure.savefig(path)


def summary(lines: Sequence[Line]) -> str:
    """Return a table of what each depth came to."""
    head = ("depth", "errors", "bound", "", "CPU s", "wall s")
    keys = ("outcome", "cpu_seconds", "wall_seconds")
    rows = ([one["depth"], f"{one['objective']:g}", f"{one['bound']:g}", *(one[key] for key in keys)] for one in lines)
    return markdown(head, rows)
