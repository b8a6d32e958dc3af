"""Consistent nodal forces of surface, line and thermal loads.

Surface and line loads use the elements' bilinear and linear shape functions; they put no moments on the nodes. A
hindered thermal strain alpha (T + z T') acts like the forces

    f = integral B_m^T N_T + B_b^T M_T dA,

N_T and M_T being the laminate's thermal force and moment. Source: R. D. Cook et al., Concepts and Applications of
Finite Element Analysis (2002), section 3.11 (initial strain).
"""

from collections.abc import Sequence

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.shells import Shells
from femlib.elements import quad4, tria3
from femlib.elements.frame import StrainOperator, resultant_turn
from femlib.errors import InputError, frozen_floats, frozen_ints
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes

GAUSS = 1.0 / np.sqrt(3.0)
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def surface_load(mesh: Mesh, traction: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] of a global traction (n_elements, 3) [Pa], constant over each element."""
    pull = frozen_floats(traction, "traction", (mesh.n_elements, 3))
    loads = np.zeros((len(mesh.nodes), DOFS_PER_NODE))
    points, n_quads = mesh.nodes[mesh.quads], len(mesh.quads)
    for r, s in GAUSS * CORNERS:
        shape, area = _gauss_area(points, r, s)
        np.add.at(loads[:, :3], mesh.quads, area[:, None, None] * shape[None, :, None] * pull[:n_quads, None, :])
    third = np.linalg.norm(mesh.area_vectors()[n_quads:], axis=1) / 3.0
    np.add.at(loads[:, :3], mesh.trias, np.repeat((third[:, None] * pull[n_quads:])[:, None], 3, axis=1))
    return loads.ravel()


def line_load(mesh: Mesh, path: Sequence[int] | IntArray, force: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] of a force per length (3,) [N/m] along a path of nodes joined by edges."""
    per_length = frozen_floats(force, "line force", (3,))
    nodes = frozen_ints(path, "line load path", (-1,))
    if len(nodes) < 2 or nodes.min() < 0 or nodes.max() >= len(mesh.nodes):
        raise InputError(
            f"line load path names {len(nodes)} nodes; expected 2 or more from 0 to {len(mesh.nodes) - 1}; correct it"
        )
    half = 0.5 * np.linalg.norm(np.diff(mesh.nodes[nodes], axis=0), axis=1)
    loads = np.zeros((len(mesh.nodes), DOFS_PER_NODE))
    for ends in (nodes[:-1], nodes[1:]):
        np.add.at(loads[:, :3], ends, half[:, None] * per_length)
    return loads.ravel()


def thermal_load(shells: Shells, warming: FloatArray, gradient: FloatArray) -> FloatArray:
    """Return the nodal forces (n_dofs,) [N, N m] of hindered thermal expansion.

    Parameters
    ----------
    shells : Shells
        The structure; its laminates carry the expansion.
    warming : FloatArray
        Temperature of each element's middle above the stress-free state (n_elements,) [K].
    gradient : FloatArray
        Temperature per height toward the top side (n_elements,) [K/m].
    """
    loads = np.zeros(shells.mesh.n_dofs)
    corners_of = (shells.mesh.quads, shells.mesh.trias)
    for corners, forces in zip(corners_of, thermal_forces(shells, warming, gradient), strict=True):
        np.add.at(loads, dofs_of_nodes(corners).reshape(forces.shape), forces)
    return loads


def thermal_forces(shells: Shells, warming: FloatArray, gradient: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the same element by element: (n_quads, 24) and (n_trias, 18) in global axes before any motion."""
    mesh = shells.mesh
    warm = frozen_floats(warming, "warming", (mesh.n_elements,))
    steep = frozen_floats(gradient, "gradient", (mesh.n_elements,))
    parts = (np.zeros((len(mesh.quads), quad4.N_DOFS)), np.zeros((len(mesh.trias), tria3.N_DOFS)))
    for element in np.flatnonzero((warm != 0.0) | (steep != 0.0)):
        laminate = shells.laminates[shells.section[element]]
        force = warm[element] * laminate.thermal_force + steep[element] * laminate.gradient_force
        moment = warm[element] * laminate.thermal_moment + steep[element] * laminate.gradient_moment
        kind, row = (0, element) if element < len(mesh.quads) else (1, element - len(mesh.quads))
        for operator, area in _quadrature(mesh.nodes[mesh.corners_of(int(element))]):
            turn = resultant_turn(operator.axes, shells.axis)
            parts[kind][row] += area * ((turn @ force) @ operator.membrane + (turn @ moment) @ operator.curvature)
        parts[kind][row] *= shells.scale[element]
    return parts


def _quadrature(points: FloatArray) -> list[tuple[StrainOperator, float]]:
    """Return strain rows and areas whose sum integrates the rows over one element exactly."""
    if len(points) == tria3.N_NODES:
        area = 0.5 * float(np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0])))
        return [(tria3.strain_operator(points), area)]
    return [
        (quad4.strain_operator(points, r, s), float(_gauss_area(points[None], r, s)[1][0])) for r, s in GAUSS * CORNERS
    ]


def _gauss_area(points: FloatArray, r: float, s: float) -> tuple[FloatArray, FloatArray]:
    """Return the shape functions (4,) and the area (n,) [m^2] of a point of the 2 x 2 rule."""
    along_r = 0.25 * np.array([s - 1, 1 - s, 1 + s, -1 - s]) @ points
    along_s = 0.25 * np.array([r - 1, -1 - r, 1 + r, 1 - r]) @ points
    return quad4.shape(r, s), np.linalg.norm(np.cross(along_r, along_s), axis=1)
