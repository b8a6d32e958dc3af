"""Curves: along a frontier, and what cross-validation chose from."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from octmip.errors import ProblemError
from octmip.interfaces.plot.style import DISTINCT, INK, quiet_frame, titled
from octmip.trees.tradeoff import Choice, Step


def frontier_figure(
    values: Sequence[float], objectives: Sequence[float], bounds: Sequence[float], name: str, title: str | None = None
) -> Figure:
    """Return objectives and bounds against what was varied, the gaps between them as bars; `name` is of the values.

    Raises
    ------
    ProblemError
        there is no point to draw.
    """
    if not values:
        raise ProblemError("the frontier has no points; give it at least one value")
    figure = Figure(figsize=(5.6, 3.2), layout="tight")
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
    return titled(figure, axes, title)


def choice_figure(choice: Choice, title: str | None = None) -> Figure:
    """Return cross-validated cost against alpha, one line per depth, the choice and its standard error marked."""
    figure = Figure(figsize=(5.6, 3.4), layout="tight")
    axes = figure.add_subplot()
    ends = [step.alpha_low for step in choice.steps if step.alpha_low > 0]
    last = 1.25 * max(ends, default=1.0)
    for k, path in enumerate(choice.paths):
        steps = [step for step in choice.steps if step.depth == path.problem.depth]
        alphas = [*(step.alpha_low for step in steps), last]
        costs = [*(step.validation_cost for step in steps), steps[-1].validation_cost]
        colour = DISTINCT[k % len(DISTINCT)]
        axes.step(alphas, costs, where="post", color=colour, linewidth=1.4, label=f"depth {path.problem.depth}")
    _mark(axes, choice.chosen)
    axes.set_xscale("symlog", linthresh=min(ends, default=1.0))
    axes.set_xlim(0, last)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("alpha: penalty of a split / baseline", color=INK)
    axes.set_ylabel("cost on the folds held out", color=INK)
    axes.legend(frameon=False, fontsize=8)
    quiet_frame(axes)
    return titled(figure, axes, title)


def _mark(axes: Axes, chosen: Step) -> None:
    error = None if np.isnan(chosen.standard_error) else chosen.standard_error
    style: dict[str, Any] = {"color": INK, "marker": "o", "markersize": 5, "capsize": 3, "linestyle": "none"}
    axes.errorbar([chosen.alpha], [chosen.validation_cost], error, label="chosen", zorder=4, clip_on=False, **style)
