"""Writes `results/uav/`: table.md, table.json, pictures (SVG and PNG) and run.json, each whole or not at all."""

import json
import platform
from collections.abc import Sequence
from importlib.metadata import version
from io import BytesIO
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from benchmarks.context import context
from benchmarks.uav.pictures import iris_picture, strain_picture, wing_picture
from benchmarks.uav.study import LABELS, Outcome, pick, problem_of
from benchmarks.uav.tables import answers, text_of
from femlib.dataset import Dataset, MeanStrains
from femlib.wing import Wing
from octmip.input.files import write_bytes
from octmip.interfaces.plot import partition_figure, tree_figure

PACKAGES = ("octmip", "numpy", "scipy", "pandas", "scikit-learn", "highspy", "pyfe3d", "matplotlib")


def write_results(
    folder: Path,
    wing: Wing,
    simulated: MeanStrains,
    published: MeanStrains | None,
    data: Dataset,
    outcomes: Sequence[Outcome],
    seconds: float,
) -> None:
    """Write everything that a run of the study has to show."""
    folder.mkdir(parents=True, exist_ok=True)
    write_bytes(folder / "table.md", text_of(outcomes, answers(outcomes)).encode())
    write_bytes(folder / "table.json", _json([outcome.row for outcome in outcomes]))
    write_bytes(folder / "run.json", _json(_run(data, outcomes, seconds)))
    for name, figure in _figures(wing, simulated, published, data, outcomes).items():
        write_figure(folder, name, figure)
        plt.close(figure)


def write_figure(folder: Path, name: str, figure: Figure) -> None:
    """Write a figure as SVG and PNG."""
    for kind in ("svg", "png"):
        buffer = BytesIO()
        figure.savefig(buffer, format=kind, dpi=150)
        write_bytes(folder / f"{name}.{kind}", buffer.getvalue())


def _figures(
    wing: Wing, simulated: MeanStrains, published: MeanStrains | None, data: Dataset, outcomes: Sequence[Outcome]
) -> dict[str, Figure]:
    figures: dict[str, Figure] = {}
    used: dict[str, Sequence[str]] = {}
    depth = max(outcome.cell.depth for outcome in outcomes if outcome.cell.task == "axis")
    for label in LABELS:
        deepest = pick(outcomes, task="axis", label=label, depth=depth, gauge_set="all")
        tree = deepest.solution.tree
        problem = problem_of(data, deepest.cell)
        used[f"gauges of the depth-{depth} tree for {label}"] = problem.shape.sensors_used(tree)
        figures[f"tree_{label}"] = tree_figure(problem, tree)
        axis = pick(outcomes, task="axis", label=label, depth=depth, gauge_set="two")
        planes = pick(outcomes, task="two features", label=label, gauge_set="two")
        for ending, outcome in (("", axis), ("_two_features", planes)):
            figures[f"partition_{label}{ending}"] = _partition(data, outcome)
            two = tree_figure(problem_of(data, outcome.cell), outcome.solution.tree)
            figures[f"tree_{label}_two_gauges{ending}"] = two
    figures["wing"] = wing_picture(wing, used)
    figures["partition_iris"] = iris_picture(data.seed)
    figures["strain"] = strain_picture(wing, simulated, published)
    return figures


def _partition(data: Dataset, outcome: Outcome) -> Figure:
    title = f"{outcome.cell.label}, loss of stiffness [%]; strain per unit of load factor [microstrain]"
    return partition_figure(problem_of(data, outcome.cell), outcome.solution.tree, title=title)


def _run(data: Dataset, outcomes: Sequence[Outcome], seconds: float) -> dict[str, object]:
    return {
        "data": data.source,
        "model_hash": data.model_hash,
        "seed": data.seed,
        "noise_sd_microstrain_per_g": data.noise_sd,
        "seconds": seconds,
        "seconds_limit": {outcome.cell.method: outcome.cell.seconds for outcome in outcomes},
        "threads_of_each_solve": 1,
        "system": platform.platform(),
        "versions": {package: version(package) for package in PACKAGES},
        **context(),
    }


def _json(content: object) -> bytes:
    return (json.dumps(content, indent=1) + "\n").encode()
