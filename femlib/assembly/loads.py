"""Consistent nodal forces of surface, line and thermal loads.

Surface loads use the elements' bilinear and linear shape functions and put no moments on the nodes. A line load does
the work of the whole motion of an edge of length l, which its ends' rotations bend by (1 - xi^2) d (`edges`): forces
f l / 2 on the ends, and moments 2 l / 3 (d d / d theta)' f, which cancel between the edges of a straight line. Without
the moments a pulled strip's corners had 1.5 times its strain.

A hindered thermal strain alpha (T + z T') acts like the forces

    f = integral B_m^T N_T + B_b^T M_T dA,

N_T and M_T being the laminate's thermal force and moment. Source: R. D. Cook et al., Concepts and Applications of
Finite Element Analysis (2002), section 3.11 (initial strain).
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.edges import bends
from femlib.assembly.shells import Shells
from femlib.elements import quad4, tria3
from femlib.elements.frame import StrainOperator
from femlib.elements.surface import shape
from femlib.errors import InputError, frozen_floats, frozen_ints
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes

GAUSS = 1.0 / np.sqrt(3.0)
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def surface_load(mesh: Mesh, traction: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] of a global traction (n_elements, 3) [Pa], constant over each element."""
    pull = frozen_floats(traction, "traction", (mesh.n_elements, 3))
    loads = np.zeros((len(mesh.nodes), DOFS_PER_NODE))
    loads[:, :3] = surface_shares(mesh) @ pull
    return loads.ravel()


def surface_shares(mesh: Mesh) -> sparse.csr_array:
    """Return the areas (n_nodes, n_elements) [m^2] of the elements that their nodes bear."""
    points, n_quads = mesh.nodes[mesh.quads], len(mesh.quads)
    areas = np.zeros(mesh.quads.shape)
    for r, s in GAUSS * CORNERS:
        shape, area = _gauss_area(points, r, s)
        areas += area[:, None] * shape
    third = np.linalg.norm(mesh.area_vectors()[n_quads:], axis=1) / 3.0
    nodes = np.concatenate([mesh.quads.ravel(), mesh.trias.ravel()])
    element = np.repeat(np.arange(mesh.n_elements), np.repeat([4, 3], [n_quads, len(mesh.trias)]))
    every = np.concatenate([areas.ravel(), np.repeat(third, 3)])
    return sparse.csr_array((every, (nodes, element)), shape=(len(mesh.nodes), mesh.n_elements))


def line_load(mesh: Mesh, path: Sequence[int] | IntArray, force: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) [N, N m] of a force per length (3,) [N/m] along a path of nodes joined by edges."""
    per_length = frozen_floats(force, "line force", (3,))
    nodes = frozen_ints(path, "line load path", (-1,))
    if len(nodes) < 2 or nodes.min() < 0 or nodes.max() >= len(mesh.nodes):
        raise InputError(
            f"line load path names {len(nodes)} nodes; expected 2 or more from 0 to {len(mesh.nodes) - 1}; correct it"
        )
    _check_edges(mesh, nodes)
    return edge_forces(mesh, np.stack([nodes[:-1], nodes[1:]], axis=1), per_length)


def edge_forces(mesh: Mesh, ends: IntArray, force: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) [N, N m] of a force per length (3,) [N/m] along edges or beams with ends (n, 2)."""
    return np.asarray(edge_shares(mesh, ends) @ np.tile(force, len(ends)))


def edge_shares(mesh: Mesh, ends: IntArray) -> sparse.csr_array:
    """Return the map (n_dofs, 3 n) from forces per length along edges or beams with ends (n, 2) to nodal forces."""
    length = np.linalg.norm(mesh.nodes[ends[:, 1]] - mesh.nodes[ends[:, 0]], axis=1)[:, None, None, None]
    straight = np.broadcast_to(0.5 * length * np.eye(3), (len(ends), 2, 3, 3))
    turned = 2.0 / 3.0 * length * bends(mesh, ends).swapaxes(2, 3)
    every = np.concatenate([straight, turned], axis=2)
    row = np.broadcast_to(dofs_of_nodes(ends)[..., None], every.shape)
    column = np.broadcast_to(np.arange(3 * len(ends)).reshape(-1, 1, 1, 3), every.shape)
    triplets = (every.ravel(), (row.ravel(), column.ravel()))
    return sparse.csr_array(sparse.coo_array(triplets, shape=(mesh.n_dofs, 3 * len(ends))))


def _check_edges(mesh: Mesh, path: IntArray) -> None:
    """Refuse a path of nodes whose neighbours are not joined by an element's edge."""
    ends = [np.stack([c, np.roll(c, -1, axis=1)], axis=-1).reshape(-1, 2) for c in (mesh.quads, mesh.trias)]
    edges = np.sort(np.concatenate(ends), axis=1) @ np.array([len(mesh.nodes), 1])
    steps = np.sort(np.stack([path[:-1], path[1:]], axis=1), axis=1) @ np.array([len(mesh.nodes), 1])
    wrong = np.flatnonzero(~np.isin(steps, edges))
    if wrong.size:
        first, second = path[wrong[0]], path[wrong[0] + 1]
        away = float(np.linalg.norm(mesh.nodes[first] - mesh.nodes[second]))
        raise InputError(
            f"line load goes from node {first} to node {second}, {away:.3g} m away, which no element's edge joins; "
            "expected neighbours along edges; name the nodes between them"
        )


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
    mesh, n_quads = shells.mesh, len(shells.mesh.quads)
    warm = frozen_floats(warming, "warming", (mesh.n_elements,))
    steep = frozen_floats(gradient, "gradient", (mesh.n_elements,))
    kept = shells.unit_thermal
    units = (kept.get("quads", lambda: _of_quads(shells)), kept.get("trias", lambda: _of_trias(shells)))
    quads, trias = (
        warm[part, None] * unit[:, 0] + steep[part, None] * unit[:, 1]
        for part, unit in zip((slice(0, n_quads), slice(n_quads, None)), units, strict=True)
    )
    return quads, trias


def hindered_forces(shells: Shells, warmth: FloatArray, factor: FloatArray) -> FloatArray:
    """Return the membrane forces N_T (n_elements, 3) [N/m] that would hold all thermal strains back.

    `warmth` (n_elements, 2) as for `thermal_load`; `factor` (n_elements,) scales each element's stiffness.
    """
    forces = np.array([[own.thermal_force, own.gradient_force] for own in shells.laminates])[shells.section]
    warm = frozen_floats(warmth, "warmth", (shells.mesh.n_elements, 2))
    return np.asarray(np.einsum("e,ek,ekc->ec", shells.scale * factor, warm, forces))


def _of_quads(shells: Shells) -> FloatArray:
    """Return the thermal forces (n_quads, 2, 24) of a unit warming and of a unit gradient."""
    points = shells.mesh.nodes[shells.mesh.quads]
    places = (GAUSS * CORNERS).tolist()
    elements = np.arange(len(points))
    sections = shells.laminates, shells.section[elements]
    operator = quad4.strain_operators(points, [(r, s) for r, s in places], shells.axis, sections)
    area = np.array([_gauss_area(points, r, s)[1] for r, s in places]).T
    return _integrated(shells, operator, area, elements)


def _of_trias(shells: Shells) -> FloatArray:
    """Return the same of the triangles (n_trias, 2, 18), of their mean strains."""
    points, first = shells.mesh.nodes[shells.mesh.trias], len(shells.mesh.quads)
    elements = first + np.arange(len(points))
    operator = tria3.strain_operators(points, tria3.MIDDLE, shells.axis)
    area = np.linalg.norm(shells.mesh.area_vectors()[first:], axis=1)[:, None]
    return _integrated(shells, operator, area, elements)


def _integrated(shells: Shells, operator: StrainOperator, area: FloatArray, elements: IntArray) -> FloatArray:
    """Return the forces (n, 2, n_dofs) of `elements` (n,) with strain rows and areas (n, n_places) of a quadrature.

    The rows' axes are the laminates'.
    """
    membrane = np.einsum("np,npci->nci", area, operator.membrane)
    curvature = np.einsum("np,npci->nci", area, operator.curvature)
    kind, unit = shells.section[elements], []
    for force, moment in (("thermal_force", "thermal_moment"), ("gradient_force", "gradient_moment")):
        pushes = np.array([getattr(laminate, force) for laminate in shells.laminates])[kind]
        turns = np.array([getattr(laminate, moment) for laminate in shells.laminates])[kind]
        unit.append(np.einsum("nd,ndi->ni", pushes, membrane) + np.einsum("nd,ndi->ni", turns, curvature))
    return np.stack(unit, axis=1) * shells.scale[elements, None, None]


def _gauss_area(points: FloatArray, r: float, s: float) -> tuple[FloatArray, FloatArray]:
    """Return the shape functions (4,) and the area (n,) [m^2] of a point of the 2 x 2 rule."""
    along_r = 0.25 * np.array([s - 1, 1 - s, 1 + s, -1 - s]) @ points
    along_s = 0.25 * np.array([r - 1, -1 - r, 1 + r, 1 - r]) @ points
    return shape(r, s), np.linalg.norm(np.cross(along_r, along_s), axis=1)
