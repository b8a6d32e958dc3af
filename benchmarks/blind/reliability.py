"""Reliability: stated probability of the first cause against the share that is right, by how clear the truth is."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure as Drawing

from benchmarks.blind.score import Pair, least_part, top
from benchmarks.figure import Figure, calibration

BANDS: Mapping[str, tuple[float, float]] = {"1 to 3": (1.0, 3.0), "3 to 5": (3.0, 5.0), "above 5": (5.0, np.inf)}
MUST: Mapping[str, tuple[float, float] | None] = {"1 to 3": None, "3 to 5": (-np.inf, 0.05), "above 5": (-np.inf, 0.05)}
EDGES = np.linspace(0.0, 1.0, 6)
COLOURS = ("#999999", "#d98c00", "#00618f")
TOLD = ("single", "pair", "outside")


def in_band(cases: Sequence[Pair], band: str) -> list[Pair]:
    """Return the cases in which something acts, the d' of its faintest part in a band."""
    low, high = BANDS[band]
    acting = [(f, a) for f, a in cases if a["case"]["stratum"].startswith(TOLD)]
    return [(f, a) for f, a in acting if low <= least_part(f, a) < high]


def errors(cases: Sequence[Pair]) -> list[Figure]:
    """Return the expected calibration error of each band."""
    rows = []
    for band in BANDS:
        part = in_band(cases, band)
        stated, hits = [f["which"][0]["probability"] for f, _ in part], [top(f, a) for f, a in part]
        rows.append(calibration(f"expected calibration error, d' {band}", stated, hits, must=MUST[band]))
    return rows


def points(cases: Sequence[Pair]) -> list[tuple[float, float, int]]:
    """Return (mean stated probability, share right, cases) of each fifth of the probabilities that holds a case."""
    stated = np.array([f["which"][0]["probability"] for f, _ in cases])
    hits = np.array([top(f, a) for f, a in cases], dtype=float)
    place = np.clip(np.digitize(stated, EDGES) - 1, 0, len(EDGES) - 2)
    bins = [place == k for k in range(len(EDGES) - 1)]
    return [(float(stated[b].mean()), float(hits[b].mean()), int(b.sum())) for b in bins if b.any()]


def draw(path: Path, title: str, cases: Sequence[Pair]) -> None:
    """Draw the reliability diagram of the bands."""
    with matplotlib.rc_context({"svg.hashsalt": "octmip"}):
        drawing = Drawing(figsize=(4.6, 4.4), layout="constrained")
        axes = drawing.subplots()
        axes.plot([0, 1], [0, 1], color="#cccccc", linewidth=1)
        for band, colour in zip(BANDS, COLOURS, strict=True):
            found = points(in_band(cases, band))
            if found:
                stated, right, n = zip(*found, strict=True)
                label = f"d' {band}, {sum(n)} cases"
                axes.plot(stated, right, color=colour, linewidth=1, label=label)
                axes.scatter(stated, right, s=[12 + 4 * count for count in n], color=colour)
        axes.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.03), title=title)
        axes.set(xlabel="stated probability of the first cause", ylabel="share that is right")
        if axes.get_legend_handles_labels()[0]:
            axes.legend(frameon=False, loc="upper left")
        drawing.savefig(path, metadata={"Date": None})
