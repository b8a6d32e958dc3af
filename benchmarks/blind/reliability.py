"""Reliability: stated probability of the first cause against the share that is right, by how clear the truth is."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.blind.score import Pair, least_part, top
from benchmarks.figure import Figure, calibration

BANDS: Mapping[str, tuple[float, float]] = {"1 to 3": (1.0, 3.0), "3 to 5": (3.0, 5.0), "above 5": (5.0, np.inf)}
MUST: Mapping[str, tuple[float, float] | None] = {"1 to 3": None, "3 to 5": (-np.inf, 0.05), "above 5": (-np.inf, 0.05)}
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
