"""Curves: bound and objective over time, and along a frontier."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from octmip.errors import ProblemError
from octmip.plot.style import DISTINCT, INK, quiet_frame
from octmip.solution import Progress


def progress_figure(progress: Sequence[Progress], title: str | None = None) -> Figure:
    """Return objective and bound over the seconds of a solver's run, the gap between them shaded.

    Raises:
        ProblemError: there is no progress to draw.
    """
    if not progress:
        raise ProblemError("no progress was recorded; give solve a progress callback that keeps what it is told")
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

    Raises:
        ProblemError: there is no point to draw.
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
