"""One failed gauge: what it costs, and how often it is found at 1 % false alarms.

Loss: error rate on unseen readings with one gauge failed, less the same tree's error rate with none failed; in the
mean over the 20 gauges, each as likely to fail, and of the worst one. The tree stands alone, or behind a detector, the
named gauge's reading imputed from the others.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from benchmarks.cpu import cpu_seconds
from benchmarks.uav.sensing.readings import LABELS, LEVELS, installed, problem_of, readings
from femlib.dataset import Dataset
from octmip import Problem, solve
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import FaultDetector, Imputation, power
from octmip.trees.tree import Node, predict

Floats = NDArray[np.float64]
Row = dict[str, object]
Answer = Callable[[Floats, Floats], NDArray[np.int64]]

DEPTH = 3
LOAD = 3.0
RATE = 0.01
BIASES = (50.0, 75.0, 100.0, 125.0, 150.0, 200.0, 250.0, 300.0, 500.0)
"""Faults at the gauge at 3 g [microstrain], a third of that in the features."""
FAULTS: dict[str, tuple[str, float]] = {
    "dead (reads 0)": ("stuck", 0.0),
    "drift +300": ("drift", 300.0 / LOAD),
    "drift -300": ("drift", -300.0 / LOAD),
    "drift +150": ("drift", 150.0 / LOAD),
    "noise 300": ("noise", 300.0 / LOAD),
}
DETECTORS = (
    ("25 states, one reading", 20, 1),
    ("25 states, mean of 10", 20, 10),
    ("81 states, one reading", 10, 1),
)
"""Name, steps of the library's states [percent], readings averaged."""
ROBUST = {"imputed": "detector, imputed"}


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return the tables of detection, loss and robust training, and draw the power."""
    n = 50 if is_smoke else 300
    data = readings(source, 0, is_smoke)
    detection, figure = detection_tables(data, n)
    figure.savefig(folder / "power.svg", metadata={"Date": None})
    losses = [row for label in LABELS for row in loss_rows(source, label, 1 if is_smoke else seeds, is_smoke)]
    return (
        f"## Detection of a failed gauge, {source}\n\n{detection}\n\n"
        f"## Loss of error rate [%] with one failed gauge, mean / worst over 20 gauges, {source}\n\n"
        f"{markdown_table(losses)}\n"
    )


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


@dataclass(frozen=True, slots=True, eq=False)
class Unseen:
    """Test readings and labels of the installed gauges."""

    problem: Problem
    features: Floats
    labels: NDArray[np.int64]

    def error(self, codes: NDArray[np.int64]) -> float:
        """Return the share of wrong answers."""
        return float((np.array(self.problem.class_names)[codes] != self.labels).mean())

    def with_failed(self, kind: str, size: float) -> list[Floats]:
        """Return the readings with each gauge failed in turn: stuck at a value, shifted by it, or as noisy."""
        found = []
        for gauge in range(self.problem.n_features):
            readings = self.features.astype(np.float64)
            column = readings[:, gauge]
            noise = np.random.default_rng([0, gauge + 1]).normal(0.0, max(size, 0.0), len(column))
            column[:] = {"stuck": np.full(len(column), size), "drift": column + size, "noise": column + noise}[kind]
            found.append(readings)
        return found


def unseen_of(data: Dataset, label: str) -> Unseen:
    """Return the unseen readings of one label."""
    problem = problem_of(data, label, DEPTH, installed(data))
    rows = ~data.is_train
    return Unseen(problem, data.features[rows][:, _columns(data)], getattr(data, label)[rows])


def answers(problem: Problem, tree: Node) -> dict[str, Answer]:
    """Return the ways to answer readings and the same readings without what a detector has named."""
    imputation = Imputation.fit(problem.features)
    return {
        "ordinary": lambda read, kept: predict(tree, read),
        "detector, imputed": lambda read, kept: predict(tree, imputation.impute(kept)),
    }


def losses_of(unseen: Unseen, detector: FaultDetector) -> dict[tuple[str, str], Floats]:
    """Return for each fault and way to answer the error rates beyond the ordinary tree's, (n_gauges,)."""
    tree = solve(unseen.problem).tree
    assert tree is not None
    ways = answers(unseen.problem, tree)
    base = unseen.error(predict(tree, unseen.features))
    found = {}
    for fault in ("none", *FAULTS):
        failed = [unseen.features] if fault == "none" else unseen.with_failed(*FAULTS[fault])
        kept = [detector.without_failed(read) for read in failed]
        for way, answer in ways.items():
            errors = [unseen.error(answer(*pair)) for pair in zip(failed, kept, strict=True)]
            found[fault, way] = np.array(errors) - base
    return found


def loss_rows(source: str, label: str, seeds: int, is_smoke: bool) -> list[Row]:
    """Return the losses of each fault, mean over the seeds, and the robust trees' shares of the ordinary one's."""
    drawn = [readings(source, seed, is_smoke) for seed in range(seeds)]
    found = [losses_of(unseen_of(data, label), detector_of(data)) for data in drawn]
    rows = []
    for fault in ("none", *FAULTS):
        row: Row = {"label": label, "fault": fault}
        sums = {way: _mean_and_worst([one[fault, way] for one in found]) for f, way in found[0] if f == fault}
        row |= {way: f"{100 * mean:.2f} / {100 * worst:.1f}" for way, (mean, worst) in sums.items()}
        if fault != "none":
            for name, way in ROBUST.items():
                shares = [robust / ordinary for robust, ordinary in zip(sums[way], sums["ordinary"], strict=True)]
                row[f"{name} / ordinary"] = f"{shares[0]:.2f} / {shares[1]:.2f}"
        rows.append(row)
    return rows


def _mean_and_worst(losses: list[Floats]) -> tuple[float, float]:
    return float(np.mean([loss.mean() for loss in losses])), float(np.mean([loss.max() for loss in losses]))
