"""The windows of a recording on its series, loads above readings, as they are before anything is diagnosed."""

import io
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from octmip.input.files import PathLike, write_bytes
from octmip.interfaces.plot.names import in_font, plain
from octmip.interfaces.plot.style import DISTINCT, INK, QUIET, Picture, quiet_frame
from octmip.recordings import Averages, Channel
from octmip.recordings.recording import Floats

PIECES = 1500
"""Pieces of a series that are drawn by their least and greatest sample: more than a figure has columns of dots."""
DOTS_PER_INCH = 120
MOST_SERIES = 12
"""Series of one picture."""


def windows_figure(averages: Averages) -> Figure:
    """Return the picture: each series by its least and greatest samples, each window a band with its mean."""
    names = list(averages.channels)[:MOST_SERIES]
    figure = Picture(figsize=(10.0, 0.6 + 1.3 * len(names)), layout="constrained")
    for k, (name, axes) in enumerate(zip(names, np.ravel(figure.subplots(len(names), 1, sharex=True)), strict=True)):
        channel = averages.channels[name]
        time, low, high = _envelope(channel)
        axes.fill_between(time, low, high, color=QUIET, linewidth=0.6, alpha=0.8)
        for window, statistic in zip(averages.windows, averages.statistics, strict=True):
            axes.axvspan(window.start, window.end, color=DISTINCT[0], alpha=0.15, linewidth=0)
            axes.plot([window.start, window.end], [statistic[name].mean] * 2, color=DISTINCT[1], linewidth=1.4)
        _labelled(axes, name, channel)
        if k == len(names) - 1:
            axes.set_xlabel("time [s]", fontsize=8, color=INK)
    return figure


def draw_windows(averages: Averages, path: PathLike) -> None:
    """Write the picture as PNG.

    Raises
    ------
    WriteError
        it cannot be written.
    """
    buffer = io.BytesIO()
    windows_figure(averages).savefig(buffer, format="png", dpi=DOTS_PER_INCH)
    write_bytes(path, buffer.getvalue())


def _labelled(axes: Any, name: str, channel: Channel) -> None:
    quiet_frame(axes)
    unit = f" [{channel.unit}]" if channel.unit else ""
    plain(axes.set_ylabel(in_font(f"{name}{unit}"), fontsize=8, color=INK))


def _envelope(channel: Channel) -> tuple[Floats, Floats, Floats]:
    """Return times (n_pieces,) and the least and greatest valid samples of the pieces, NaN in those without one."""
    values = np.where(channel.is_valid, channel.values, np.nan)
    edges = np.linspace(channel.time[0], channel.time[-1], min(PIECES, len(values)) + 1)
    place = np.minimum(np.searchsorted(channel.time, edges[:-1]), len(values) - 1)
    is_there = np.diff(np.append(place, len(values))) > 0
    low, high = (np.where(is_there, reduce.reduceat(values, place), np.nan) for reduce in (np.fmin, np.fmax))
    return edges[:-1], low, high
