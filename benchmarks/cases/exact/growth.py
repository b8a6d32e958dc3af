"""Growth of the exact core's time with samples (10^3 to 10^5) and features, on one kind of data of its own."""

import math
import resource
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from benchmarks.data import three_classes
from benchmarks.tables import Line
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits

SAMPLES = (1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000)
FEATURES = (5, 10, 20, 40, 80)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each size; a row of sizes ends where one is not proven within the limit."""
    for depth in (2, 3):
        for over, sizes in (("samples", [(n, 10) for n in SAMPLES]), ("features", [(2_000, p) for p in FEATURES])):
            for n, p in sizes:
                line = _measured(n, p, depth, limit)
                yield {
                    "size": f"{n} x {p}, depth {depth}",
                    "seed": 0,
                    "over": over,
                    "n": n,
                    "p": p,
                    "depth": depth,
                    **line,
                }
                if line["outcome"] != "proven":
                    break


def _measured(n: int, p: int, depth: int, limit: float) -> Line:
    table = three_classes(n, p)
    problem = Problem(table.features, table.labels, depth=depth)
    usage, start = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    solution = branch_and_bound(problem, limits=Limits(seconds=limit))
    after = resource.getrusage(resource.RUSAGE_SELF)
    return {
        "outcome": "proven" if solution.is_optimal else "not proven",
        "objective": solution.objective,
        "bound": solution.bound,
        "cpu_seconds": round(after.ru_utime + after.ru_stime - usage.ru_utime - usage.ru_stime, 5),
        "wall_seconds": round(time.perf_counter() - start, 5),
    }


def exponent(lines: Sequence[Line], over: str, depth: int | str) -> float:
    """Return b of seconds = a size^b, least squares on logarithms of the proven sizes."""
    key = "n" if over == "samples" else "p"
    chosen = [line for line in lines if (line["over"], line["depth"], line["outcome"]) == (over, depth, "proven")]
    if len(chosen) < 2:
        return math.nan
    logs = np.log([[line[key], max(line["cpu_seconds"], 1e-6)] for line in chosen])
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def picture(lines: Sequence[Line], path: Path) -> None:
    """Draw CPU seconds against samples and against features, both axes logarithmic, with the fitted lines."""
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    for axes, over, key in zip(figure.subplots(1, 2), ("samples", "features"), ("n", "p"), strict=True):
        for depth, colour in ((2, "tab:blue"), (3, "tab:orange")):
            chosen = [
                line for line in lines if (line["over"], line["depth"], line["outcome"]) == (over, depth, "proven")
            ]
            sizes = np.array([line[key] for line in chosen], dtype=float)
            seconds = np.array([line["cpu_seconds"] for line in chosen])
            power = exponent(lines, over, depth)
            fitted = np.exp(np.mean(np.log(seconds)) + power * (np.log(sizes) - np.mean(np.log(sizes))))
            axes.plot(sizes, seconds, "o", color=colour)
            axes.plot(sizes, fitted, color=colour, label=f"depth {depth}: {over}^{power:.2f}")
        axes.set(xscale="log", yscale="log", xlabel=over, ylabel="CPU seconds to proven optimality")
        places = SAMPLES if over == "samples" else FEATURES
        axes.set_xticks(places, [f"{place:,}" for place in places], rotation=30)
        axes.minorticks_off()
        axes.grid(alpha=0.3)
        axes.legend()
    with rc_context({"svg.fonttype": "none"}):
        figure.savefig(path)


def summary(lines: Sequence[Line]) -> str:
    """Return the table of sizes and the fitted exponents."""
    rows = [
        f"| {line['size']} | {line['objective']:g}, {line['outcome']} | {line['cpu_seconds']:.3g} |" for line in lines
    ]
    fits = [
        f"Depth {depth}: CPU seconds grow as {over}^{exponent(lines, over, depth):.2f}."
        for depth in (2, 3)
        for over in ("samples", "features")
    ]
    return "\n".join(["| size | errors | CPU s |", "|---|---|---|", *rows, "", *fits])
