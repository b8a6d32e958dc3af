"""Which region is taken for which: the confusion of the 28 regions by Bayes's rule and by the proven tree.

    python -m benchmarks.wing.confusion [--refinement 0.35] [--samples 6] [--seconds 120] [--tables FOLDER]
        [--picture FILE.png]

Readings, gauges and trees are those of `python -m benchmarks.wing.regions`.
"""

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from benchmarks.wing.regions import (
    DEPTH,
    N_FRESH,
    N_GAUGES,
    bayes,
    drawn,
    labels,
    placed,
    state_means,
)
from femlib.wing import uav_wing
from femlib.wing.damage import damage_library
from octmip import Limits, Problem, certify, solve
from octmip.formats.files import write_bytes
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.prediction import predict

Floats = NDArray[np.float64]
Named = Callable[[Floats], NDArray[np.int64]]
"""Readings (n, n_gauges) -> the region (n,) that a rule names."""
N_NAMES = 29
"""No damage, and each region."""
SHOWN = 0.05
"""Least share of the readings of one region for which a pair stands in the CSV file."""


def main() -> None:
    """Print and write."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.confusion", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.35)
    parser.add_argument("--samples", type=int, default=6, help="training readings of each damaged state")
    parser.add_argument("--seconds", type=float, default=120.0, help="limit of each proof")
    parser.add_argument("--tables", help="folder for the CSV file")
    parser.add_argument("--picture", help="PNG file to write")
    options = parser.parse_args()
    wing = uav_wing(candidates=True, refinement=options.refinement, regions=damage_library())
    means, names = state_means(wing), ["none", *(own.name for own in wing.regions)]
    found: dict[str, Floats] = {}
    for kind, chosen in {"installed": np.arange(N_GAUGES), "placed": placed(wing, means)}.items():
        own = means[:, chosen]
        found[f"Bayes's rule, {kind}"] = confusion(own, partial(bayes, own))
        found[f"tree, {kind}"] = confusion(own, tree_of(own, options.samples, options.seconds))
    rows = pair_rows(found, names)
    print(markdown_table(rows))
    if options.tables:
        path = Path(options.tables) / "regions-confusion.csv"
        write_bytes(path, pd.DataFrame(rows).to_csv(index=False).encode())
    if options.picture:
        picture(found, names).savefig(options.picture, dpi=100)


def confusion(means: Floats, name: Named) -> Floats:
    """Return the share (29, 29) of the fresh readings of each region (rows) that are named so (columns)."""
    region, _ = labels()
    readings, state = drawn(means, N_FRESH, 1)
    counts = np.zeros((N_NAMES, N_NAMES))
    np.add.at(counts, (region[state], name(readings)), 1.0)
    return np.asarray(counts / counts.sum(axis=1, keepdims=True))


def tree_of(means: Floats, samples: int, seconds: float) -> Named:
    """Return what the proven tree of depth 3 names."""
    region, _ = labels()
    readings, state = drawn(means, samples, 0)
    problem = Problem(readings, region[state], depth=DEPTH)
    solution = solve(problem, "exact", Limits(seconds=seconds))
    certify(problem, solution)
    tree = solution.tree
    assert tree is not None
    print(f"tree: {solution.objective:.0f} wrong in training, bound {solution.bound:.0f}", flush=True)
    return partial(predict, tree)


def pair_rows(found: dict[str, Floats], names: list[str]) -> list[dict[str, object]]:
    """Return true and named region of every pair that is frequent by some rule, with the shares [%]."""
    rows = []
    frequent = np.max(list(found.values()), axis=0) >= SHOWN
    for true, named in np.argwhere(frequent):
        row: dict[str, object] = {"true": names[true], "named": names[named]}
        rows.append(row | {f"{kind} %": round(100 * float(table[true, named]), 1) for kind, table in found.items()})
    return rows


def picture(found: dict[str, Floats], names: list[str]) -> Figure:
    """Return the four tables as pictures, a region's readings in each row."""
    figure = Figure(figsize=(13, 13), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey=True)
    for axis, (kind, table) in zip(axes.T.ravel(), found.items(), strict=True):
        image = axis.imshow(100 * table, cmap="Blues", vmin=0, vmax=100)
        axis.set(title=kind, xlabel="named", ylabel="damaged")
        axis.set_xticks(range(N_NAMES), names, rotation=90, fontsize=7)
        axis.set_yticks(range(N_NAMES), names, fontsize=7)
    figure.colorbar(image, ax=axes, shrink=0.5, label="% of a region's readings")
    return figure


if __name__ == "__main__":
    run_main(main)
