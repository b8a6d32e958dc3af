"""Curves: bound and objective over time, along a frontier, what cross-validation chose from, reliability."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from octmip.errors import ProblemError
from octmip.interfaces.plot.names import name_entries
from octmip.interfaces.plot.style import DISTINCT, INK, quiet_frame
from octmip.trees.solution import Progress
from octmip.trees.tradeoff import Choice, Step
from octmip.trees.uncertainty import ReliabilityBin


def progress_figure(progress: Sequence[Progress], title: str | None = None) -> Figure:
    """Return objective and bound over the seconds of a solver's run, the gap between them shaded.

    Raises
    ------
    ProblemError
        there is no progress to draw.
    """
    if not progress:
        raise ProblemError(
            "no progress was recorded; give solve a progress callback that keeps the states that it receives"
        )
    seconds = np.array([state.seconds for state in progress])
    objective = np.array([state.objective for state in progress])
    bound = np.array([state.bound for state in progress])
    figure = Figure(figsize=(5.6, 3.2), layout="tight")
    axes = figure.add_subplot()
    bound, objective = np.where(np.isfinite(bound), bound, np.nan), np.where(np.isfinite(objective), objective, np.nan)
    axes.fill_between(seconds, bound, objective, step="post", color=DISTINCT[0], alpha=0.12, linewidth=0)
    axes.step(seconds, objective, where="post", color=DISTINCT[1], label="best tree")
    axes.step(seconds, bound, where="post", color=DISTINCT[0], label="proven bound")
    axes.set_xlabel("seconds", color=INK)
    axes.set_ylabel("objective", color=INK)
    axes.legend(frameon=False, fontsize=8)
    quiet_frame(axes)
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


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
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


def reliability_figure(curves: Mapping[str, Sequence[ReliabilityBin]], title: str | None = None) -> Figure:
    """Return the share of hits against the predicted probability, one line per name; areas of points go by weight.

    Raises
    ------
    ProblemError
        there is no bin to draw.
    """
    if not any(curves.values()):
        raise ProblemError("there are no bins; give the bins of octmip.trees.uncertainty.reliability under a name")
    figure = Figure(figsize=(4.2, 4.0), layout="tight")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color=INK, linewidth=0.8, linestyle="--", label="calibrated")
    for k, bins in enumerate(curves.values()):
        colour = DISTINCT[k % len(DISTINCT)]
        predicted, hits = [b.probability for b in bins], [b.hits for b in bins]
        axes.plot(predicted, hits, color=colour, linewidth=1.2, label="curve")
        axes.scatter(predicted, hits, [200 * b.weight for b in bins], color=colour, zorder=3, clip_on=False)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.set_xlabel("predicted probability", color=INK)
    axes.set_ylabel("share of hits", color=INK)
    name_entries(axes.legend(frameon=False, fontsize=8, loc="upper left"), ["calibrated", *curves])
    quiet_frame(axes)
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


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
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


def _mark(axes: Axes, chosen: Step) -> None:
    error = None if np.isnan(chosen.standard_error) else chosen.standard_error
    style: dict[str, Any] = {"color": INK, "marker": "o", "markersize": 5, "capsize": 3, "linestyle": "none"}
    axes.errorbar([chosen.alpha], [chosen.validation_cost], error, label="chosen", zorder=4, clip_on=False, **style)
