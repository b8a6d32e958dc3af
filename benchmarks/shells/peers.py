"""The same cases by other programs: pyfe3d's Quad4 and Tria3DSG, CalculiX's S4 and S8R.

pyfe3d gives element matrices, which femlib's assembly and supports then take. CalculiX gets a deck of the case. S8R
stands on the nodes of the case, one of its elements for four of the case's: the nodes between become its middles, and
what a node in its centre carries goes to its eight by their shape functions.
"""

import tempfile
from pathlib import Path

import numpy as np

from benchmarks.ccx import run_deck
from benchmarks.shells.case import Case
from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Shells, Supports, assemble, factorise
from femlib.export.calculix import Deck, edges, write_deck
from femlib.export.calculix_results import read_displacements
from femlib.material import Laminate
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes


def pyfe3d_ratio(case: Case) -> float:
    """Return the ratio with pyfe3d's elements, the shape of the case's."""
    mesh, n_quads = case.shells.mesh, len(case.shells.mesh.quads)
    quads = _matrices(case.shells, mesh.quads, case.shells.section[:n_quads])
    trias = _matrices(case.shells, mesh.trias, case.shells.section[n_quads:])
    supports = case.supports
    factors = factorise(supports.reduce(assemble(mesh, quads, trias)), supports.groups)
    return case.ratio(supports.expand(factors.solve(case.load[supports.free])))


def _matrices(shells: Shells, corners: IntArray, section: IntArray) -> FloatArray:
    """Return pyfe3d's element stiffness (n, 6 k, 6 k)."""
    import pyfe3d

    n_dofs = DOFS_PER_NODE * corners.shape[1]
    values = np.zeros((len(corners), n_dofs * n_dofs))
    unused = np.zeros(1, dtype=pyfe3d.INT)
    for own, kind, row in zip(corners, section, values, strict=True):
        if corners.shape[1] == 4:
            element = pyfe3d.Quad4(pyfe3d.Quad4Probe())
            element.c1, element.c2, element.c3, element.c4 = 0, 6, 12, 18
        else:
            element = pyfe3d.Tria3DSG(pyfe3d.Tria3DSGProbe())
            element.c1, element.c2, element.c3 = 0, 6, 12
        flat = np.ascontiguousarray(shells.mesh.nodes[own]).ravel()
        element.update_rotation_matrix(flat)
        _align(element, shells.axis)
        element.update_probe_xe(flat)
        element.update_KC0(unused, unused, row, _property(shells.laminates[kind]), 1)
    return values.reshape(-1, n_dofs, n_dofs)


def _property(laminate: Laminate) -> object:
    from pyfe3d.shellprop import ShellProp

    prop = ShellProp()
    prop.h = laminate.thickness
    for letter, matrix in (("A", laminate.membrane), ("B", laminate.coupling), ("D", laminate.bending)):
        for i, j, suffix in ((0, 0, "11"), (0, 1, "12"), (0, 2, "16"), (1, 1, "22"), (1, 2, "26"), (2, 2, "66")):
            setattr(prop, letter + suffix, float(matrix[i, j]))
    prop.A44, prop.A45, prop.A55 = (float(laminate.shear[i, j]) for i, j in ((0, 0), (0, 1), (1, 1)))
    return prop


def _align(element: object, axis: FloatArray) -> None:
    """Let the laminate's axis be the projection of `axis` (3,), or the element's x.

    pyfe3d's own computation takes the root of 1 - cos^2, which rounding makes negative where the axes coincide: it then
    fails or fills the stiffness with NaN.
    """
    turn = np.array([[getattr(element, f"r{i}{j}") for j in (1, 2, 3)] for i in (1, 2, 3)])
    along_x, along_y, _ = turn.T @ axis
    length = float(np.hypot(along_x, along_y))
    if length > 1e-10 * float(np.linalg.norm(axis)):
        c, s = along_x / length, along_y / length
        for name, value in (("m11", c), ("m22", c), ("m21", s), ("m12", -s)):
            setattr(element, name, value)


def calculix_ratio(case: Case, is_quadratic: bool) -> float:
    """Return the ratio with S4 on the case's elements, or with S8R on a quarter as many.

    Where the case has an odd number of elements along a side S8R stands on the same elements, their sides straight.

    Raises
    ------
    RuntimeError
        If CalculiX stops.
    """
    n_nodes = len(case.shells.mesh.nodes)
    if is_quadratic and (np.array(case.node.shape) % 2 == 1).all():
        deck, numbers = _on_the_same_nodes(case)
    else:
        deck, numbers = Deck(case.shells, case.supports, case.load, is_quadratic), np.arange(n_nodes)
    found = _run(deck, int(numbers.max()) + 1)
    moved = np.zeros((n_nodes, DOFS_PER_NODE))
    known = numbers >= 0
    moved[known, :3] = found[numbers[known]]
    return case.ratio(moved.ravel())


def _run(deck: Deck, n_nodes: int) -> FloatArray:
    """Return the translations (n_nodes, 3) that CalculiX finds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.inp"
        write_deck(deck, path)
        run_deck(path)
        return read_displacements(path.with_suffix(".frd"), n_nodes)


def _on_the_same_nodes(case: Case) -> tuple[Deck, IntArray]:
    """Return a deck of S8R on a case's nodes, and its number of each, -1 for those in centres of elements."""
    node, nodes = case.node, case.shells.mesh.nodes
    corner = node[::2, ::2]
    kept = corner.ravel()
    number = np.arange(kept.size).reshape(corner.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    none = np.zeros((0, 3), dtype=np.int64)
    mesh = Mesh(nodes[kept], quads, none, ("shell",), np.zeros(len(quads), dtype=np.int64), case.shells.mesh.limits)
    shells = Shells(mesh, case.shells.laminates, mesh.patch_of_element, np.ones(len(quads)), case.shells.axis)
    ends = edges(mesh)[0]
    place = np.stack(np.unravel_index(kept, node.shape), axis=1)  # of the corners in the grid
    middles = node[tuple((place[ends[:, 0]] + place[ends[:, 1]]).T // 2)]
    load = case.load.reshape(-1, DOFS_PER_NODE).copy()
    _spread(load, node)
    held = case.held[np.isin(case.held // DOFS_PER_NODE, kept)]
    local = np.full(len(nodes), -1)
    local[kept] = np.arange(kept.size)
    numbers = local.copy()
    numbers[middles] = kept.size + np.arange(len(middles))
    supports = Supports.holding(mesh, dofs_of_nodes(local[held // DOFS_PER_NODE])[np.arange(len(held)), held % 6])
    deck = Deck(shells, supports, load[kept].ravel(), middles=nodes[middles], middle_load=load[middles])
    return deck, numbers


def _spread(load: FloatArray, node: IntArray) -> None:
    """Move the load (n_nodes, 6) of centres to the eight nodes around them: -1/4 to corners, 1/2 to middles."""
    centre = node[1::2, 1::2]
    for i in (0, 1, 2):
        for j in (0, 1, 2):
            share = {0: 0.0, 1: 0.5, 2: -0.25}[abs(i - 1) + abs(j - 1)]
            around = node[i : i + 2 * centre.shape[0] - 1 : 2, j : j + 2 * centre.shape[1] - 1 : 2]
            np.add.at(load, around, share * load[centre])
    load[centre] = 0.0
