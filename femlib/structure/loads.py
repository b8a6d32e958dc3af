"""Nodal forces of loads that are named by sets: pressure, forces at nodes, along lines, gravity."""

from collections.abc import Sequence

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly import surface_load
from femlib.assembly.built_up import BuiltUp
from femlib.assembly.loads import edge_forces
from femlib.errors import InputError, frozen_floats, is_number
from femlib.mesh import DOFS_PER_NODE, shell_sides
from femlib.structure.named_mesh import NamedMesh


def pressure_load(mesh: NamedMesh, built: BuiltUp, name: str, pressure: float) -> FloatArray:
    """Return nodal forces (n_dofs,) of a pressure [Pa] toward the top sides of the shells of a set.

    Raises
    ------
    InputError
        If the set has beams alone, or a shell lies with its top side where its neighbour has its bottom side.
    """
    if not is_number(pressure):
        raise InputError(f"pressure on {name!r} is {pressure!r}; expected a number of Pa; correct it")
    elements = mesh.elements_of(name)[: mesh.n_shells]
    if not elements.any():
        raise InputError(
            f"pressure acts on {name!r}, which holds lines alone; expected shells; use line_load for a force per length"
        )
    _check_sides(mesh, elements, name)
    normals = built.mesh.area_vectors()
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return surface_load(built.mesh, np.where(elements[:, None], pressure * normals, 0.0))


def point_load(mesh: NamedMesh, name: str, force: Sequence[float], moment: Sequence[float]) -> FloatArray:
    """Return nodal forces (n_dofs,) of a force (3,) [N] and a moment (3,) [N m], shared by the nodes of a set."""
    nodes = mesh.nodes_of(name)
    both = np.concatenate([frozen_floats(force, "force", (3,)), frozen_floats(moment, "moment", (3,))])
    loads = np.zeros((len(mesh.nodes), DOFS_PER_NODE))
    loads[nodes] = both / len(nodes)
    return loads.ravel()


def line_load(mesh: NamedMesh, built: BuiltUp, name: str, force: Sequence[float]) -> FloatArray:
    """Return nodal forces and moments (n_dofs,) of a force per length (3,) [N/m] along the lines of a set.

    The lines of an element set, or the elements' edges between the nodes of a node set.

    Raises
    ------
    InputError
        If the set has no line, or its nodes are all of a shell's.
    """
    per_length = frozen_floats(force, "line force", (3,))
    return edge_forces(built.mesh, _lines(mesh, name), per_length)


def gravity_load(built: BuiltUp, acceleration: Sequence[float]) -> FloatArray:
    """Return the weight (n_dofs,) of all parts and point masses under an acceleration (3,) [m/s^2].

    Raises
    ------
    InputError
        If a section that a part has is without density.
    """
    weights = [("shell", built.section, [own.mass for own in built.laminates])]
    weights.append(("beam", built.beams.section, [own.density for own in built.beams.sections]))
    for what, section, masses in weights:
        bare = np.flatnonzero(np.array([*masses, 1.0])[section] <= 0.0)
        if bare.size:
            raise InputError(
                f"gravity acts on {what} {bare[0]} (and {bare.size - 1} more), whose section has no density; expected "
                "one of each section; give it in kg/m^3, 1e-6 to a part that weighs nothing"
            )
    field = np.zeros((len(built.mesh.nodes), DOFS_PER_NODE))
    field[:, :3] = frozen_floats(acceleration, "acceleration", (3,))
    return np.asarray(built.mass() @ field.ravel())


def _check_sides(mesh: NamedMesh, elements: BoolArray, name: str) -> None:
    """Refuse a pressure on two neighbours whose top sides face different ways."""
    ends, shells = shell_sides(mesh.quads, mesh.trias)
    kept = elements[shells]
    ends, shells = ends[kept], shells[kept]
    _, edge, count = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    forward = np.bincount(edge.ravel(), weights=ends[:, 0] < ends[:, 1], minlength=len(count))
    wrong = np.flatnonzero((count == 2) & (forward != 1.0))
    if wrong.size:
        first, second = shells[edge.ravel() == wrong[0]]
        raise InputError(
            f"pressure on {name!r} would push shells {first} and {second}, which share an edge, toward opposite sides; "
            f"expected their top sides on one side; turn them with mesh.facing_away({name!r}, point)"
        )


def _lines(mesh: NamedMesh, name: str) -> IntArray:
    """Return the ends (n, 2) of the lines that a set names; they may branch."""
    nodes = mesh.nodes_of(name)
    if name in mesh.element_sets and name not in mesh.node_sets:
        ends = mesh.lines[mesh.element_sets[name][mesh.n_shells :]]
    else:
        inside = [np.flatnonzero(np.isin(corners, nodes).all(axis=1)) for corners in (mesh.quads, mesh.trias)]
        whole = np.concatenate([inside[0], len(mesh.quads) + inside[1]])
        if whole.size:
            raise InputError(
                f"line load acts on {name!r}, which holds all corners of shell {whole[0]}, so that its edges are no "
                "curve; expected nodes along one; name an element set of lines"
            )
        sides, _ = shell_sides(mesh.quads, mesh.trias)
        every = np.unique(np.sort(np.concatenate([sides, mesh.lines]), axis=1), axis=0)
        ends = every[np.isin(every, nodes).all(axis=1)]
    if not len(ends):
        raise InputError(
            f"line load acts on {name!r}, which is no line; expected lines, or nodes along one; name the set of a curve"
        )
    return ends
