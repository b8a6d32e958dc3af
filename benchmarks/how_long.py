"""How long a proof takes: CPU seconds of `method="exact"` against samples, features and depth: a table and a diagram.

The data are made up and not easy: half of the features matter, they act together, and a tenth of the labels are drawn
at random, so that no tree of these depths is free of errors. Real tables are mostly quicker (docs/benchmarks.md).
A line ends where a call reaches its limit. `python -m benchmarks.how_long` prints the table and draws the diagram.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure
from sklearn.datasets import make_classification

from benchmarks.cpu import cpu_limit, cpu_seconds
from benchmarks.main_program import run_main
from benchmarks.small_svg import shrink
from octmip import Problem, solve
from octmip.interfaces.plot.style import DISTINCT, INK, quiet_frame

PICTURE = Path(__file__).parent.parent / "docs" / "pictures" / "how_long.svg"
SAMPLES = {2: (100, 300, 1000, 3000, 10_000, 30_000, 100_000), 3: (100, 300, 1000, 3000, 10_000), 4: (100, 300, 1000)}
FEATURES = (5, 20, 50)
SEED = 0


@dataclass(frozen=True, slots=True)
class Timing:
    """One call: its size, its CPU seconds, and whether the optimum was proven within the limit."""

    n_samples: int
    n_features: int
    depth: int
    seconds: float
    is_proven: bool


def problem_of(n_samples: int, n_features: int, depth: int) -> Problem:
    """Return a problem of this size, two classes, a tenth of the labels at random."""
    features, labels = make_classification(
        n_samples,
        n_features,
        n_informative=max(2, n_features // 2),
        n_redundant=0,
        n_clusters_per_class=2,
        flip_y=0.1,
        random_state=SEED,
    )
    return Problem(features, labels, depth=depth)


def timings(limit: float) -> Iterator[Timing]:
    """Yield what each size takes on one thread; after a call that ends at its limit no larger one is tried."""
    solve(problem_of(100, FEATURES[0], 2))  # what is imported at the first call is not part of a proof
    for depth, sizes in SAMPLES.items():
        for n_features in FEATURES:
            for n_samples in sizes:
                problem = problem_of(n_samples, n_features, depth)
                start = cpu_seconds()
                solution = solve(problem, method="exact", n_jobs=1, **cpu_limit(limit))
                yield Timing(n_samples, n_features, depth, cpu_seconds() - start, solution.is_optimal)
                if not solution.is_optimal:
                    break


def diagram(found: list[Timing], limit: float) -> Figure:
    """Return CPU seconds against samples, a panel for each depth and a line for each number of features."""
    figure = Figure(figsize=(8.4, 3.1), layout="constrained")
    panels = figure.subplots(1, len(SAMPLES), sharey=True)
    for axes, depth in zip(panels, SAMPLES, strict=True):
        for colour, n_features in zip(DISTINCT, FEATURES, strict=False):
            line = [t for t in found if (t.depth, t.n_features) == (depth, n_features)]
            proven = [t for t in line if t.is_proven]
            axes.plot(
                [t.n_samples for t in line],
                [t.seconds for t in line],
                color=colour,
                linewidth=1.4,
                label=f"{n_features}",
            )
            axes.scatter([t.n_samples for t in proven], [t.seconds for t in proven], color=colour, s=18, zorder=3)
            late = [t for t in line if not t.is_proven]
            axes.scatter(
                [t.n_samples for t in late], [t.seconds for t in late], s=26, facecolors="none", edgecolors=colour
            )
        axes.axhline(limit, color=INK, linewidth=0.6, linestyle=":")
        axes.set(xscale="log", yscale="log", xlabel="samples", xlim=(70, 150_000))
        axes.set_title(f"depth {depth}", fontsize=10, color=INK)
        quiet_frame(axes)
    panels[0].set_ylabel("CPU seconds to the proof")
    panels[-1].legend(title="features", frameon=False, fontsize=8, title_fontsize=8, loc="lower right")
    return figure


def main() -> None:
    """Print the table and draw the diagram."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--limit", type=float, default=6.0, help="CPU seconds of each call")
    limit = parser.parse_args().limit
    found = list(timings(limit))
    print("| depth | features | samples | CPU s | proven |\n| ---: | ---: | ---: | ---: | --- |")
    for t in found:
        words = "yes" if t.is_proven else f"no: limit of {limit:g} CPU s"
        print(f"| {t.depth} | {t.n_features} | {t.n_samples:,} | {t.seconds:.3g} | {words} |")
    with matplotlib.rc_context({"svg.hashsalt": "octmip"}):
        diagram(found, limit).savefig(PICTURE, metadata={"Date": None})
    shrink(PICTURE)


if __name__ == "__main__":
    run_main(main)
