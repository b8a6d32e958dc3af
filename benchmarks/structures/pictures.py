"""The pictures of the worked structures: shape under load, to scale where it says so, and what is damaged.

    python -m benchmarks.structures.pictures docs/pictures

runs the code of docs/examples/structures/*.md and draws each structure in one damage state.
"""

import argparse
import contextlib
import tempfile
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from benchmarks.main_program import run_main
from benchmarks.structures.against_calculix import PAGES, page_names
from femlib.structure.vtu import face_strains

STATE = {"panel": {"bay": 0.6, "blade": 0.6}, "tower": {"patch": 0.6, "leg": 0.6, "brace": 0.6}}
VIEW = {"panel": (-28.0, -58.0), "tower": (14.0, -38.0)}
ZOOM = {"panel": 1.2, "tower": 1.0}
AXIS = {"panel": ("along x", (1.0, 0.0, 0.0)), "tower": ("upward", (0.0, 0.0, 1.0))}
SHOWN = 0.06
"""Largest motion in a picture over the structure's size."""


def main() -> None:
    """Draw each page's structure."""
    parser = argparse.ArgumentParser(prog="benchmarks.structures.pictures", description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder.resolve()
    for name, state in STATE.items():
        with tempfile.TemporaryDirectory() as work, contextlib.chdir(work):
            names = page_names(PAGES / f"{name}.md")
        draw(name, names, state).savefig(folder / f"structure_{name}.png", dpi=110, bbox_inches="tight")


def draw(name: str, names: dict[str, Any], state: dict[str, float]) -> Any:
    """Return the picture of a page's structure in one state."""
    structure, load = names["structure"], names["load"]
    built, moved = structure.built, structure.solve(state, load)
    scale = SHOWN * built.mesh.size / np.abs(moved[:, :3]).max()
    points = built.mesh.nodes + scale * moved[:, :3]
    strain = np.mean(face_strains(structure, moved, np.array(AXIS[name][1])), axis=0)
    most = np.nanpercentile(np.abs(strain), 99)
    colours = plt.get_cmap("RdBu_r")((strain / most + 1.0) / 2.0)
    colours[np.isnan(strain)] = (0.8, 0.8, 0.8, 1.0)
    figure = plt.figure(figsize=(8.0, 6.5))
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    left = structure.stiffness_left(state)
    shells = [points[corners] for corners in (*built.mesh.quads, *built.mesh.trias)]
    edges = np.where(left[: len(shells)] < 1.0, "black", "0.85")
    axes.add_collection3d(Poly3DCollection(shells, facecolors=colours, edgecolors=list(edges), linewidths=0.4))
    if len(built.beams.ends):
        is_damaged = left[len(shells) : len(shells) + len(built.beams.ends)] < 1.0
        colours = np.where(is_damaged, "tab:orange", "0.25").tolist()
        lines = Line3DCollection(points[built.beams.ends], colors=colours, linewidths=1.8)
        along_shells = np.isin(built.beams.ends, built.mesh.quads).all(axis=1)  # they are drawn under them
        lines.set_alpha(np.where(along_shells, 0.15, 1.0).tolist())
        axes.add_collection3d(lines)
    masses = points[built.point_masses > 0.0]
    axes.scatter(*masses.T, s=90.0, color="black")
    axes.set_axis_off()
    axes.auto_scale_xyz(*points.T)
    axes.set_box_aspect(np.ptp(points, axis=0), zoom=ZOOM[name])
    axes.view_init(*VIEW[name])
    words = ", ".join(f"{key} {100 * value:.0f} % lost" for key, value in state.items())
    axes.set_title(f"{words}; motion {scale:.0f} times", y=1.04)
    shade = ScalarMappable(Normalize(-most, most), "RdBu_r")
    figure.colorbar(shade, ax=axes, shrink=0.6, label=f"strain {AXIS[name][0]}, middle surface [microstrain]")
    return figure


if __name__ == "__main__":
    run_main(main)
