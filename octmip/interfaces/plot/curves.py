"""Curves: bound and objective over time, along a frontier, what cross-validation chose from."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.interfaces.plot.names import name_entries
from octmip.interfaces.plot.style import DISTINCT, INK, Picture, quiet_frame
from octmip.trees.tradeoff import Choice, Step


def frontier_figure(values: Sequence[float], objectives: Sequence[float], bounds: Sequence[float], name: str) -> Figure:
    """Return objectives and bounds against what was varied, the gaps between them as bars; `name` is of the values.

    Raises
    ------
    ProblemError
        there is no point to draw.
    """
    if not values:
        raise ProblemError("the frontier has no points; give it at least one value")
    figure = Picture(figsize=(5.6, 3.2), layout="tight")
    axes = figure.add_subplot()
    proven = np.where(np.isfinite(bounds), bounds, np.nan)
    axes.vlines(values, proven, objectives, color=DISTINCT[0], alpha=0.35, linewidth=5)
    axes.plot(values, objectives, color=DISTINCT[1], marker="o", markersize=4, label="best tree")
    axes.plot(values, proven, color=DISTINCT[0], marker="_", linewidth=0, label="proven bound")
    axes.set_ylim(bottom=0)
    if all(value == round(value) for value in values) and len(values) < 20:
        axes.set_xticks(values)
    axes.set_xlabel(name, color=INK)
    axes.set_ylabel("objective", color=INK)
    axes.legend(frameon=False, fontsize=8)
    quiet_frame(axes)
    return figure


def benchmark_figure(
    ratios: Mapping[str, Sequence[float]], gaps: Mapping[str, Sequence[Sequence[tuple[float, float]]]]
) -> Figure:
    """Return how methods compare over several problems: their performance profile, and the mean gap over time.

    Parameters
    ----------
    ratios
        by method, for each problem that any method proves: seconds until the proof over those of the quickest, +inf
        without a proof.
    gaps
        by method, for each problem: (seconds, gap) each time that the gap became smaller. Before the first the gap is
        1, and so is one above 1.

    Source: Dolan & More (2002), Benchmarking optimization software with performance profiles.
    """
    figure = Picture(figsize=(8.4, 3.4), layout="tight")
    left, right = figure.subplots(1, 2)
    finite = [ratio for of_method in ratios.values() for ratio in of_method if np.isfinite(ratio)]
    most = 1.5 * max(finite, default=1.0)
    times = [seconds for of_method in gaps.values() for runs in of_method for seconds, _ in runs if seconds > 0]
    grid = np.geomspace(min(times, default=0.01), 1.1 * max(times, default=1.0), 400)
    for k, name in enumerate(gaps):
        style: dict[str, Any] = {"color": DISTINCT[k % len(DISTINCT)], "linewidth": 1.4, "label": "curve"}
        style["linestyle"] = "-" if k < len(DISTINCT) else "--"
        reached = np.sort([ratio for ratio in ratios[name] if np.isfinite(ratio)])
        shares = np.arange(len(reached) + 1) / max(1, len(ratios[name]))
        left.step([1, *reached, most], [*shares, shares[-1]], where="post", **style)
        right.plot(grid, 100 * np.mean([_gap_at(grid, run) for run in gaps[name]], axis=0), **style)
    left.set_xlim(1, most)
    left.set_xlabel("seconds until the proof / those of the quickest", color=INK)
    left.set_ylabel("share of problems proven", color=INK)
    right.set_xlabel("seconds", color=INK)
    right.set_ylabel("mean gap [%]", color=INK)
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_ylim(bottom=0)
        quiet_frame(axes)
    name_entries(right.legend(frameon=False, fontsize=8), list(gaps))
    return figure


def _gap_at(seconds: NDArray[np.float64], run: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
    """Return the gap of one run at some times, 1 before it was known."""
    found = np.searchsorted([at for at, _ in run], seconds, side="right")
    return np.array([1.0, *(min(1.0, gap) for _, gap in run)])[found]


def choice_figure(choice: Choice) -> Figure:
    """Return cross-validated cost against alpha, one line per depth, the choice and its standard error marked.

    >>> from octmip.trees.tradeoff import choose_tree
    >>> problem = Problem([[k] for k in range(20)], [k > 9 for k in range(20)], depth=1)
    >>> choice_figure(choose_tree(problem)).savefig("choice.svg")
    """
    figure = Picture(figsize=(5.6, 3.4), layout="tight")
    axes = figure.add_subplot()
    ends = [step.alpha_low for step in choice.steps if step.alpha_low > 0]
    last = 1.25 * max(ends, default=1.0)
    for k, path in enumerate(choice.paths):
        steps = [step for step in choice.steps if step.depth == path.problem.shape.depth]
        alphas = [*(step.alpha_low for step in steps), last]
        costs = [*(step.validation_cost for step in steps), steps[-1].validation_cost]
        colour = DISTINCT[k % len(DISTINCT)]
        axes.step(alphas, costs, where="post", color=colour, linewidth=1.4, label=f"depth {path.problem.shape.depth}")
    _mark(axes, choice.chosen)
    axes.set_xscale("symlog", linthresh=min(ends, default=1.0))
    axes.set_xlim(0, last)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("alpha: penalty of a split / baseline", color=INK)
    axes.set_ylabel("cost on the folds held out", color=INK)
    axes.legend(frameon=False, fontsize=8)
    quiet_frame(axes)
    return figure


def _mark(axes: Axes, chosen: Step) -> None:
    error = None if np.isnan(chosen.standard_error) else chosen.standard_error
    style: dict[str, Any] = {"color": INK, "marker": "o", "markersize": 5, "capsize": 3, "linestyle": "none"}
    axes.errorbar([chosen.alpha], [chosen.validation_cost], error, label="chosen", zorder=4, clip_on=False, **style)
