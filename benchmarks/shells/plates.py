"""Flat problems: plates in bending, Cook's membrane, a laminated plate.

Sources: L. S. D. Morley, Skew Plates and Structures (1963); R. D. Cook, J. Struct. Div. ASCE 100 (1974) 1851-1863,
limit 23.96; S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells (1959), tables 8 and 35; A. Razzaque, Int.
J. Numer. Meth. Engng 6 (1973) 333-343; N. J. Pagano, J. Composite Materials 4 (1970) 20-34 (three-dimensional
elasticity; solved anew, not read from the tables).
"""

from dataclasses import replace

import numpy as np

from benchmarks.shells.case import Case, at, hold, mapped
from benchmarks.shells.elasticity import pagano_deflection
from femlib.arrays import FloatArray
from femlib.assembly import line_load, surface_load
from femlib.material import Laminate, Ply, isotropic_plate, laminate


def skew_plate(n: int, angle: float, laminate: Laminate, side: float, supported: str) -> Case:
    """Return a rhombus under uniform load: deflection of its middle. `supported`: "all" edges, or a "pair"."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        return side * np.stack([u + c * v, s * v, 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n, laminate)
    edges = [node[:, 0], node[:, -1]] if supported == "pair" else [node[0], node[-1], node[:, 0], node[:, -1]]
    held = [hold(np.unique(np.concatenate(edges)), "w"), hold(node[:1, :1], "uv"), hold(node[-1:, :1], "v")]
    load = surface_load(shells.mesh, np.tile([0.0, 0.0, 1.0], (shells.mesh.n_elements, 1)))
    read = at(shells, int(node[n // 2, n // 2]), "w")
    return Case(shells, node, np.concatenate(held), load, read, 1.0, "")


def morley_skew_plate(n: int) -> Case:
    """Simply supported 30 degree plate, side / thickness 100."""
    case = skew_plate(n, 30.0, isotropic_plate(1e5, 0.3, 1.0), 100.0, "all")
    return replace(case, reference=4.455, source="Morley 1963")


def razzaque_skew_plate(n: int) -> Case:
    """60 degree plate, side / thickness 1000, two edges free: deflection 7.945e-3 q a^4 / D."""
    case = skew_plate(n, 60.0, isotropic_plate(10.92e9, 0.31, 1e-3), 1.0, "pair")
    exact = 7.945e-3 * 12.0 * (1.0 - 0.31**2) / 10.92
    return replace(case, reference=exact, source="Razzaque 1973")


def cook_membrane(n: int) -> Case:
    """Tapered panel in shear: deflection of the loaded edge's middle."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.stack([48.0 * u, 44.0 * u + v * (44.0 - 28.0 * u), 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(1.0, 1.0 / 3.0, 1.0))
    load = line_load(shells.mesh, node[-1], np.array([0.0, 1.0 / 16.0, 0.0]))
    held = [hold(node[0], "uvz"), hold(node, "wxy")]
    read = at(shells, int(node[-1, n // 2]), "v")
    return Case(shells, node, np.concatenate(held), load, read, 23.96, "Cook 1974")


def square_plate(n: int, clamped: bool) -> Case:
    """Quarter of a thin square plate under uniform load: deflection of the middle."""
    shells, node = mapped(_quarter, n, n, isotropic_plate(10.92e9, 0.3, 1e-3))
    held = [hold(node[0], "uyz"), hold(node[:, 0], "vxz")]  # the middle lies at the first node
    for edge, along in ((node[-1], "x"), (node[:, -1], "y")):
        held.append(hold(edge, "wxy" if clamped else "w" + along))
    load = surface_load(shells.mesh, np.tile([0.0, 0.0, 1.0], (shells.mesh.n_elements, 1)))
    series = (0.00126532 if clamped else 0.00406235) / (10.92e9 * 1e-9 / 12.0 / 0.91)
    return Case(shells, node, np.concatenate(held), load, at(shells, int(node[0, 0]), "w"), series, "Timoshenko 1959")


CARBON = Ply(25e9, 1e9, 0.25, 0.5e9, 0.5e9, 0.2e9, 1.0)
CROSS_PLY = (0.0, 0.5 * np.pi, 0.5 * np.pi, 0.0)


def pagano_plate(n: int, slenderness: float, ply: Ply = CARBON, angles: tuple[float, ...] = CROSS_PLY) -> Case:
    """Quarter of a simply supported square plate, a/h = `slenderness`, its plies alike, under cos cos pressure."""
    plies = [replace(ply, thickness=1.0 / slenderness / len(angles), angle=angle) for angle in angles]
    shells, node = mapped(_quarter, n, n, laminate(plies), axis=(1.0, 0.0, 0.0))
    held = [hold(node[0], "uyz"), hold(node[:, 0], "vxz"), hold(node[-1], "vwx"), hold(node[:, -1], "uwy")]
    # the pressure is bilinear between the nodes: consistent with the shape functions, by the mass matrix of a grid
    x = np.linspace(0.0, 0.5, n + 1)
    line = (np.eye(n + 1) * 4.0 + np.eye(n + 1, k=1) + np.eye(n + 1, k=-1)) / (12.0 * n)
    line[[0, -1], [0, -1]] *= 0.5
    share = line @ np.cos(np.pi * x)
    load = np.zeros((shells.mesh.n_dofs // 6, 6))
    load[node.ravel(), 2] = np.outer(share, share).ravel()
    exact = pagano_deflection(ply, angles, slenderness)
    read = at(shells, int(node[0, 0]), "w")
    return Case(shells, node, np.concatenate(held), load.ravel(), read, exact, "Pagano 1970")


def _quarter(u: FloatArray, v: FloatArray) -> FloatArray:
    return 0.5 * np.stack([u, v, 0.0 * u], axis=-1)
