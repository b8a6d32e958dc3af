"""Pictures of the wing: regions and gauges, strain over the skin, the deformed shape.

    python -m femlib.wing.export.pictures FOLDER [--refinement 1] [--mu1 0] [--mu2 0] [--load-factor 3]

writes wing_regions.png, wing_strain.png, wing_deformed.png (matplotlib) and, where pyvista is installed,
wing_render.png.
"""

import argparse
import importlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.errors import InputError, needed_by
from femlib.mesh import Mesh
from femlib.wing.bent import bend
from femlib.wing.damage import SURFACES, damage_library
from femlib.wing.export.vtu import far_shape, near_shape, write_vtu
from femlib.wing.model import Wing, uav_wing

with needed_by("a picture of the wing"):
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon

INK, QUIET, ACCENT, DAMAGE = "#222222", "#5b6670", "#c2410c", "#f2b8a0"
STRAINS = "RdBu_r"
"""Compression red, tension blue."""
TITLES = {"top": "top skin: damage regions and gauges", "bottom": "bottom skin", "web": "spar web, seen from behind"}


def region_picture(wing: Wing) -> Figure:
    """Return the planform from above, one panel per surface: damage regions with their names, gauges on the top."""
    held = [surface for surface in SURFACES if any(region.surface == surface for region in wing.regions)]
    heights = [1.0 if surface == "web" else 2.6 for surface in held]
    figure = Figure(figsize=(10, sum(heights)), layout="constrained")
    axes = figure.subplots(len(held), 1, squeeze=False, gridspec_kw={"height_ratios": heights})
    for axis, surface in zip(axes[:, 0], held, strict=True):
        if surface == "web":
            _web(axis, wing)
        else:
            draw_planform(axis, wing, surface, DAMAGE)
        if surface == "top":
            _gauges(axis, wing)
        _plan_axes(axis, TITLES[surface])
    return figure


def strain_picture(wing: Wing, strains: FloatArray, title: str) -> Figure:
    """Return the spanwise strain (n_elements,) [microstrain] over both skins, with region borders and gauges."""
    mesh = wing.structure.shells.mesh
    _check_strains(strains, mesh)
    figure = Figure(figsize=(10, 5.6), layout="constrained")
    axes = figure.subplots(2, 1)
    skins = [_skin(mesh, surface) for surface in ("top", "bottom")]
    limit = float(np.nanpercentile(np.abs(strains[np.concatenate(skins)]), 99.5))
    for axis, elements, surface in zip(axes, skins, ("top", "bottom"), strict=True):
        corners = mesh.nodes[mesh.quads[elements]]
        outlines = [_seen(quad) for quad in corners]
        cells = PolyCollection(outlines, cmap=STRAINS, edgecolors="face", linewidths=0.2)
        cells.set_array(strains[elements])
        cells.set_clim(-limit, limit)
        axis.add_collection(cells)
        draw_planform(axis, wing, surface, "none")
        if surface == "top":
            _gauges(axis, wing)
        _plan_axes(axis, f"{surface} skin")
    figure.colorbar(cells, ax=axes, label="spanwise strain of the outer face [microstrain]\ncompression positive")
    figure.suptitle(title, fontsize=11)
    return figure


def deformed_picture(wing: Wing, displacement: FloatArray, strains: FloatArray, title: str) -> Figure:
    """Return the wing seen from behind, at rest and moved by (n_nodes, 3) [m], to scale, coloured by strain."""
    mesh = wing.structure.shells.mesh
    _check_strains(strains, mesh)
    if np.shape(displacement) != (len(mesh.nodes), 3):
        raise InputError(
            f"displacement has shape {np.shape(displacement)}; expected ({len(mesh.nodes)}, 3); give translations alone"
        )
    figure = Figure(figsize=(10, 2.6), layout="constrained")
    axis = figure.subplots()
    shown = np.concatenate([_skin(mesh, "bottom"), _skin(mesh, "top")])
    after = (mesh.nodes + displacement)[mesh.quads[shown]]
    limit = float(np.nanpercentile(np.abs(strains[shown]), 99.5))
    axis.fill(*_elevation(wing), fc="none", ec=QUIET, lw=1.0, ls="--")
    cells = PolyCollection([quad[:, 1:] for quad in after], cmap=STRAINS, edgecolors="face", linewidths=0.2)
    cells.set_array(strains[shown])
    cells.set_clim(-limit, limit)
    axis.add_collection(cells)
    tip = displacement[wing.grid.upper[-1, wing.grid.spar_column]]
    place = (wing.span + tip[1], float(after[:, :, 2].max()))
    axis.annotate(f"tip {1e3 * tip[2]:.0f} mm up, {-1e3 * tip[1]:.1f} mm inboard", place, ha="right", va="bottom")
    _plan_axes(axis, title)
    figure.colorbar(cells, ax=axis, label="spanwise strain\n[microstrain]")
    return figure


def render(wing: Wing, displacement: FloatArray, strains: FloatArray, path: str | Path) -> None:
    """Write a picture of the deformed wing by VTK, off screen.

    Raises
    ------
    MissingExtraError
        If pyvista is not installed.
    """
    with needed_by("rendering"):
        pyvista = importlib.import_module("pyvista")
    mesh = wing.structure.shells.mesh
    plotter = pyvista.Plotter(off_screen=True, window_size=(1500, 700))
    grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: mesh.quads}, mesh.nodes + displacement)
    grid.cell_data["strain"] = strains[: len(mesh.quads)]
    limit = float(np.nanpercentile(np.abs(strains[_skin(mesh, "top")]), 99.5))
    bar = {
        "title": "spanwise strain [microstrain], compression positive",
        "color": "black",
        "n_labels": 5,
        "fmt": "%.0f",
    }
    plotter.add_mesh(grid, scalars="strain", cmap=STRAINS, clim=(-limit, limit), nan_color="white", scalar_bar_args=bar)
    for line in (wing.grid.upper[:, 0], wing.grid.upper[:, -1], wing.grid.upper[-1], wing.grid.lower[-1]):
        plotter.add_mesh(pyvista.lines_from_points(mesh.nodes[line]), color="grey", line_width=2)
    plotter.set_background("white")
    plotter.camera_position = [(3.2, -1.6, 1.6), (0.05, 0.93, 0.0), (0.0, 0.0, 1.0)]
    plotter.camera.zoom(1.9)
    plotter.screenshot(str(path))
    plotter.close()


def _check_strains(strains: FloatArray, mesh: Mesh) -> None:
    if np.shape(strains) != (mesh.n_elements,):
        raise InputError(
            f"strains have shape {np.shape(strains)}; expected ({mesh.n_elements},), one for each element; "
            "a gauge's strain has no place here"
        )


def _skin(mesh: Mesh, surface: str) -> IntArray:
    """Return the quadrilaterals of a skin, its damage regions included."""
    up = mesh.area_vectors()[:, 2]
    steep = np.isin(mesh.patch_of_element, [mesh.patches.index(name) for name in ("web", "ribs")])
    facing = up > 0.0 if surface == "top" else up < 0.0
    found = np.flatnonzero(facing & ~steep & (np.abs(up) > 1e-9))
    return found[found < len(mesh.quads)]


def draw_planform(axis: Axes, wing: Wing, surface: str, colour: str) -> None:
    """Draw the outline, span to the right, and the damage regions of a surface in a colour, with their names."""
    axis.add_patch(Polygon(_seen(wing.outline()), closed=True, fill=False, ec=INK, lw=1.2))
    for region in wing.regions:
        if region.surface == surface:
            corners = _seen(wing.region_outline(region))
            axis.add_patch(Polygon(corners, closed=True, fc=colour, ec=INK, lw=0.7, zorder=2))
            axis.annotate(region.parameter, corners[:4].mean(axis=0), ha="center", va="center", fontsize=7, zorder=4)


def _elevation(wing: Wing) -> tuple[FloatArray, FloatArray]:
    """Return (y, z) of the outline at rest seen from behind: highest points out, lowest points back."""
    nodes = wing.structure.shells.mesh.nodes
    y = nodes[wing.grid.upper[:, 0], 1]
    high, low = nodes[wing.grid.upper, 2].max(axis=1), nodes[wing.grid.lower, 2].min(axis=1)
    return np.concatenate([y, y[::-1]]), np.concatenate([high, low[::-1]])


def _web(axis: Axes, wing: Wing) -> None:
    """Draw the spar web seen from behind, with its damage regions."""
    nodes, column = wing.structure.shells.mesh.nodes, wing.grid.spar_column
    lower, upper = nodes[wing.grid.lower[:, column]], nodes[wing.grid.upper[:, column]]
    eta = wing.grid.eta
    axis.fill(
        np.concatenate([lower[:, 1], upper[::-1, 1]]), np.concatenate([lower[:, 2], upper[::-1, 2]]), fc="none", ec=INK
    )
    for region in wing.regions:
        if region.surface == "web":
            held = (eta >= region.eta_min - 1e-9) & (eta <= region.eta_max + 1e-9)
            corners = np.concatenate([lower[held], upper[held][::-1]])[:, 1:]
            axis.add_patch(Polygon(corners, closed=True, fc=DAMAGE, ec=INK, lw=0.7))
            axis.annotate(region.parameter, corners.mean(axis=0), ha="center", va="center", fontsize=7)


def _gauges(axis: Axes, wing: Wing) -> None:
    gauges = wing.gauges
    place, usable = _seen(gauges.position[:, :2]), gauges.is_usable
    axis.plot(*place[usable].T, "o", ms=4.5, color=ACCENT, mec="white", mew=0.6, zorder=3, label="gauge")
    axis.plot(*place[~usable].T, "x", ms=4.5, color=INK, zorder=3, label="gauge not used")
    axis.legend(loc="lower right", fontsize=7, frameon=False)


def _seen(points: FloatArray) -> FloatArray:
    """Return (y, -x): the span to the right, the leading edge up."""
    return np.column_stack([points[:, 1], -points[:, 0]])


def _plan_axes(axis: Axes, title: str) -> None:
    axis.autoscale_view()
    axis.set_aspect("equal")
    axis.set_title(title, loc="left", fontsize=10)
    axis.set_xlabel("distance from the root [m]", fontsize=8)
    axis.set_yticks([])
    axis.tick_params(labelsize=8)
    axis.spines[["top", "right", "left"]].set_visible(False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the pictures of docs/wing.md."""
    parser = argparse.ArgumentParser(prog="femlib.wing.export.pictures", description=__doc__)
    parser.add_argument("folder", type=Path)
    for name, value in (("refinement", 1.0), ("mu1", 0.0), ("mu2", 0.0), ("load-factor", 3.0)):
        parser.add_argument(f"--{name}", type=float, default=value)
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    state, load = {"mu1": options.mu1, "mu2": options.mu2}, options.load_factor
    wing = uav_wing(refinement=options.refinement)
    what = f"mu1 = {options.mu1:.0%}, mu2 = {options.mu2:.0%}, load factor {load:g}"
    library = uav_wing(refinement=0.3, regions=damage_library(), candidates=True)
    region_picture(library).savefig(options.folder / "wing_regions.png", dpi=130)
    _, strains = near_shape(wing, wing.solve(state, load))
    strain_picture(wing, strains, what).savefig(options.folder / "wing_strain.png", dpi=130)
    moved, bent = far_shape(wing, bend(wing, state, load).deflection)
    picture = deformed_picture(wing, moved, bent, f"{what}, large deflection, to scale")
    picture.savefig(options.folder / "wing_deformed.png", dpi=130)
    write_vtu(wing, options.folder / "wing.vtu", state, load)
    try:
        render(wing, moved, bent, options.folder / "wing_render.png")
    except InputError as error:
        print(error)


if __name__ == "__main__":
    main()
