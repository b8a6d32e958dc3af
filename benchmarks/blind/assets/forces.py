"""Nodal forces and temperatures of what may act on the asset beside its lift, each per unit of its size.

They stand for the diagnosis' effects of the same names, with formulae of their own: other lift shapes, another
distribution of the torsion, a mass spread over other nodes, a temperature that web and ribs do not share.
"""

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import Wing

GRAVITY = 9.80665
HOT_SPOT_WIDTH = 0.06
STEPS = 8  # a hot spot falls in so many steps: one material each in a CalculiX deck

LIFT_KINDS = ("schrenk", "washed out tip", "bell")


def vertical(force_of_node: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) that are vertical."""
    force = np.zeros((len(force_of_node), DOFS_PER_NODE))
    force[:, 2] = force_of_node
    return force.ravel()


def lift_shape(wing: Wing, kind: str) -> FloatArray:
    """Return other lift (n_dofs,) [N] of total zero that adds one per cent to the root's bending moment.

    schrenk: half-way from the ellipse to the chord (Schrenk (1940), NACA TM 948); washed out tip: grows with the square
    of the span and drops at the tip, as twist gives; bell: (1 - eta^2)^(3/2) (Prandtl (1933)), which is more inboard.
    """
    lift = wing.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    eta = wing.structure.shells.mesh.nodes[:, 1] / wing.span
    ellipse = np.sqrt(np.maximum(1.0 - eta**2, 1e-3))
    shape = (
        lift
        * {
            "schrenk": wing.planform.chord(eta) / ellipse,
            "washed out tip": eta**2 * (1.0 - 0.5 * eta**6),
            "bell": 1.0 - eta**2,
        }[kind]
    )
    shape = shape - lift * shape.sum() / lift.sum()
    return vertical(shape * (0.01 * (lift @ eta) / (shape @ eta)))


def torsion(wing: Wing) -> FloatArray:
    """Return forces (n_dofs,) that move the lift of every station aft by one per cent of its chord.

    The pressure gains a part that grows with the square of the distance from the nose.
    """
    grid = wing.grid
    lift = wing.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    shape = np.zeros_like(lift)
    for upper, lower in zip(grid.upper, grid.lower, strict=True):
        nodes = np.unique(np.concatenate([upper, lower]))
        chord = np.zeros(len(lift))
        chord[upper] = chord[lower] = grid.chord
        f, x = lift[nodes], chord[nodes]
        if f.sum() == 0.0:
            continue
        bent = f * (x**2 - f @ x**2 / f.sum())
        shape[nodes] = bent * (0.01 * f.sum() / (bent @ x))
    return vertical(shape)


def payload(wing: Wing, eta: float) -> FloatArray:
    """Return the weight (n_dofs,) of one kilogram at a span fraction on the spar, shared by the six nearest nodes."""
    nodes = wing.structure.shells.mesh.nodes
    near = np.argsort(np.linalg.norm(nodes - np.array([0.0, eta * wing.span, 0.0]), axis=1))[:6]
    force = np.zeros(len(nodes))
    force[near] = -GRAVITY / len(near)
    return vertical(force)


def warming(wing: Wing, name: str) -> FloatArray:
    """Return the temperature (n_elements,) of one kelvin of a named field."""
    mesh = wing.structure.shells.mesh
    if name == "temperature_uniform":
        return np.ones(mesh.n_elements)
    height = mesh.centroids()[:, 2]
    if name == "temperature_gradient":
        inner = np.isin(mesh.patch_of_element, [mesh.patches.index("web"), mesh.patches.index("ribs")])
        return np.where(inner, 0.0, np.where(height > 0, 0.5, -0.5))
    eta = mesh.centroids()[:, 1] / wing.span
    heat = np.exp(-(((eta - float(name.split(":")[1])) / HOT_SPOT_WIDTH) ** 2))
    return np.where(height > 0, np.round(STEPS * heat) / STEPS, 0.0)


def is_thermal(name: str) -> bool:
    """Return whether a field is one of temperature, which does not grow with the load."""
    return name.startswith(("temperature", "hot_spot"))


def force(wing: Wing, name: str) -> FloatArray:
    """Return the nodal forces (n_dofs,) at load factor 1 of a named field that is none of temperature."""
    kind, _, place = name.partition(":")
    if kind == "lift_distribution":
        return lift_shape(wing, place)
    return payload(wing, float(place)) if kind == "payload_inertia" else torsion(wing)


def foreign_patch(wing: Wing, place: str) -> BoolArray:
    """Return the elements (n_elements,) of a foreign damage: 0.1 of the span by 0.35 of the chord of the upper skin."""
    mesh = wing.structure.shells.mesh
    centre = mesh.centroids()
    eta, aft = (float(part) for part in place.split(":"))
    local = wing.planform.chord(centre[:, 1] / wing.span)
    near = (np.abs(centre[:, 1] / wing.span - eta) < 0.05) & (np.abs(centre[:, 0] / local + 0.3 - aft) < 0.175)
    return np.asarray(near & (mesh.patch_of_element == mesh.patches.index("top")))


def bond(wing: Wing, place: str) -> tuple[BoolArray, IntArray]:
    """Return the web elements (n_elements,) along a flange and the nodes at which the web slides on the skin."""
    flange, inner, outer = place.split(":")
    mesh, grid = wing.structure.shells.mesh, wing.grid
    edge = (grid.upper if flange == "upper" else grid.lower)[:, grid.spar_column]
    web = np.flatnonzero(mesh.patch_of_element == mesh.patches.index("web"))
    row = np.zeros(mesh.n_elements, dtype=bool)
    row[web] = np.isin(mesh.quads[web], edge).any(axis=1)
    eta = mesh.nodes[edge, 1] / wing.span
    return row, edge[(eta > float(inner)) & (eta < float(outer))]
