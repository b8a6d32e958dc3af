"""One failed gauge: how often it is found at 1 % false alarms."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from benchmarks.cpu import cpu_seconds
from benchmarks.uav.sensing.readings import LEVELS, installed, readings
from femlib.dataset import Dataset
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import FaultDetector, power

Floats = NDArray[np.float64]
Row = dict[str, object]

LOAD = 3.0
RATE = 0.01
BIASES = (50.0, 75.0, 100.0, 125.0, 150.0, 200.0, 250.0, 300.0, 500.0)
"""Faults at the gauge at 3 g [microstrain], a third of that in the features."""
DETECTORS = (
    ("25 states, one reading", 20, 1),
    ("25 states, mean of 10", 20, 10),
    ("81 states, one reading", 10, 1),
)
"""Name, steps of the library's states [percent], readings averaged."""


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return the table of detection, and draw the power; seed 0."""
    del seeds
    detection, figure = detection_tables(readings(source, 0, is_smoke), 50 if is_smoke else 300)
    figure.savefig(folder / "power.svg", metadata={"Date": None})
    return f"## Detection of a failed gauge, {source}\n\n{detection}\n"


def means_of(data: Dataset, step: int) -> Floats:
    """Return the mean features of the installed gauges at states `step` percent apart, interpolated between the 25."""
    corners = np.arange(LEVELS[0], LEVELS[-1] + 1, step)
    states = np.stack(np.meshgrid(corners, corners, indexing="ij"), axis=-1).reshape(-1, 2)
    return interpolated(data, states)


def interpolated(data: Dataset, states: NDArray[np.integer | np.floating]) -> Floats:
    """Return the mean features (n, n_gauges) at states (n, 2) in percent, linear between the library's."""
    grid = data.mean_features[:, _columns(data)].reshape(len(LEVELS), len(LEVELS), -1)
    return np.asarray(RegularGridInterpolator((LEVELS, LEVELS), grid)(states))


def _columns(data: Dataset) -> list[int]:
    return [data.gauges.index(name) for name in installed(data)]


def detector_of(data: Dataset, step: int = 20, n_averaged: int = 1) -> FaultDetector:
    """Return the detector of the installed gauges over states `step` percent apart."""
    return FaultDetector(means_of(data, step), np.array(data.noise_sd), installed(data), RATE, n_averaged)


def detection_tables(data: Dataset, n: int) -> tuple[str, Figure]:
    """Return false-alarm rate and power by size of fault, and the picture of the power."""
    rng = np.random.default_rng(1)
    rows: list[Row] = []
    figure = Figure(figsize=(5.6, 3.2), layout="tight")
    axes = figure.add_subplot()
    for name, step, n_averaged in DETECTORS:
        before = cpu_seconds()
        detector = detector_of(data, step, n_averaged)
        found, right = power(detector, [bias / LOAD for bias in BIASES], n, rng)
        row: Row = {"": name, "false alarms %": _alarms(detector, detector.draw(40 * n, rng))}
        row["between states %"] = _alarms(detector, _between(data, detector, 10 * n, rng))
        row |= {f"{bias:g}": _share(found[b]) for b, bias in enumerate(BIASES)}
        row |= {kind: _share(_special(detector, kind, n, rng)) for kind in ("stuck", "dead")}
        rows.append(row | {"CPU s": round(cpu_seconds() - before, 1)})
        named: Row = {"": f"{name}: right gauge named"}
        rows.append(named | {f"{bias:g}": f"{100 * right[b].mean():.0f}" for b, bias in enumerate(BIASES)})
        axes.plot(BIASES, 100 * found.mean(axis=1), marker="o", markersize=3, label=name)
    axes.axhline(100 * RATE, color="#9aa3ad", linewidth=0.8)
    axes.set_xlabel("bias of one gauge at 3 g [microstrain]")
    axes.set_ylabel("alarms, mean of 20 gauges [%]")
    axes.legend(frameon=False, fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    return markdown_table(rows), figure


def _alarms(detector: FaultDetector, drawn: Floats) -> float:
    return round(100 * float(detector.is_alarm(drawn).mean()), 2)


def _share(values: Floats) -> str:
    return f"{100 * values.mean():.0f} / {100 * values.min():.0f}"


def _special(detector: FaultDetector, fault: str, n: int, rng: np.random.Generator) -> Floats:
    """Return the power for a gauge that stays at its value on the sound wing, or reads 0, (n_gauges,)."""
    found = []
    for gauge in range(len(detector.gauges)):
        drawn = detector.draw(n, rng)
        drawn[:, gauge] = detector.means[0, gauge] if fault == "stuck" else 0.0
        found.append(float(detector.is_alarm(drawn).mean()))
    return np.array(found)


def _between(data: Dataset, detector: FaultDetector, n: int, rng: np.random.Generator) -> Floats:
    """Return healthy readings (n, n_gauges) at any states of up to 80 % loss, not only those of the library."""
    means = interpolated(data, rng.uniform(LEVELS[0], LEVELS[-1], (n, 2)))
    return np.asarray(means + rng.normal(size=means.shape) * detector.noise_sd)
