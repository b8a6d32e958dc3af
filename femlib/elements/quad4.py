"""Four-node laminated shell: Allman membrane with drilling rotations, bilinear bending, tied transverse shear.

Source: A. Ibrahimbegovic, R. L. Taylor, E. L. Wilson, Int. J. Numer. Meth. Engng 30 (1990) 445-457 (membrane and
drilling) and bilinear bending, both as in pyfe3d; the transverse shear is femlib's (mitc4.py).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.elements.frame import StrainOperator, align, element_axes, element_library, shell_property, to_global
from femlib.elements.mitc4 import shear_stiffness
from femlib.material import Laminate

if TYPE_CHECKING:
    from pyfe3d import Quad4

N_NODES = 4
N_DOFS = 24
N_MASS_ENTRIES = 480


def stiffness(points: FloatArray, laminates: Sequence[Laminate], section: IntArray, axis: FloatArray) -> FloatArray:
    """Return the stiffness matrices (n, 24, 24) in global axes.

    Parameters
    ----------
    points : FloatArray
        Corners (n, 4, 3) [m].
    laminates : sequence of Laminate
        Sections that occur.
    section : IntArray
        Index into `laminates` (n,).
    axis : FloatArray
        Direction (3,) whose projection is the laminates' axis.
    """
    properties = [shell_property(laminate, with_shear=False) for laminate in laminates]
    values = np.zeros((len(points), N_DOFS * N_DOFS))
    unused = np.zeros(1, dtype=element_library().INT)
    frames, turns = np.empty((len(points), 3, 3)), np.empty((len(points), 2, 2))
    for corners, kind, row, frame, turn in zip(points, section, values, frames, turns, strict=True):
        element = _placed(corners, axis)
        element.update_KC0(unused, unused, row, properties[kind], 1)
        frame[:] = element_axes(element)
        turn[:] = [[element.m11, element.m12], [element.m21, element.m22]]
    return values.reshape(-1, N_DOFS, N_DOFS) + _shear(points, laminates, section, frames, turns)


def mass(points: FloatArray, laminates: Sequence[Laminate], section: IntArray) -> FloatArray:
    """Return the consistent mass matrices (n, 24, 24) in global axes, arguments as `stiffness`."""
    properties = [shell_property(laminate) for laminate in laminates]
    matrices = np.zeros((len(points), N_DOFS, N_DOFS))
    rows, columns = (
        np.zeros(N_MASS_ENTRIES, dtype=element_library().INT),
        np.zeros(N_MASS_ENTRIES, dtype=element_library().INT),
    )
    for corners, kind, matrix in zip(points, section, matrices, strict=True):
        values = np.zeros(N_MASS_ENTRIES)
        _placed(corners, np.zeros(3)).update_M(rows, columns, values, properties[kind], 0)
        np.add.at(matrix, (rows, columns), values)
    return matrices


def strain_operator(points: FloatArray, xi: float = 0.0, eta: float = 0.0) -> StrainOperator:
    """Return the strain rows at natural coordinates `xi`, `eta` in [-1, 1] of one element with corners (4, 3) [m]."""
    element = _placed(points, np.zeros(3))
    probe = element.probe
    probe.update_BL(xi, eta)
    axes = element_axes(element)
    membrane = np.array([probe.BLexx, probe.BLeyy, probe.BLgxy])
    curvature = np.array([probe.BLkxx, probe.BLkyy, probe.BLkxy])
    return StrainOperator(to_global(membrane, axes), to_global(curvature, axes), axes)


def strain_operators(points: FloatArray, places: Sequence[tuple[float, float]]) -> StrainOperator:
    """Return the strain rows of many elements with corners (n, 4, 3) [m] at natural coordinates `places`.

    The operator's arrays have leading axes: rows (n, n_places, 3, 24), axes (n, 3, 3).
    """
    rows = np.empty((len(points), len(places), 2, 3, N_DOFS))
    axes = np.empty((len(points), 3, 3))
    for corners, own, frame in zip(points, rows, axes, strict=True):
        element = _placed(corners, np.zeros(3))
        probe, frame[:] = element.probe, element_axes(element)
        for place, (membrane, curvature) in zip(places, own, strict=True):
            probe.update_BL(*place)
            membrane[0], membrane[1], membrane[2] = probe.BLexx, probe.BLeyy, probe.BLgxy
            curvature[0], curvature[1], curvature[2] = probe.BLkxx, probe.BLkyy, probe.BLkxy
    blocks = rows.reshape(len(points), len(places) * 2 * 3 * 2 * N_NODES, 3)  # of three dofs each
    turned = (blocks @ axes.transpose(0, 2, 1)).reshape(rows.shape)
    return StrainOperator(turned[:, :, 0], turned[:, :, 1], axes)


def shape(xi: float, eta: float) -> FloatArray:
    """Return the bilinear shape functions (4,) at natural coordinates."""
    return 0.25 * np.array([(1 - xi) * (1 - eta), (1 + xi) * (1 - eta), (1 + xi) * (1 + eta), (1 - xi) * (1 + eta)])


def _shear(
    points: FloatArray, laminates: Sequence[Laminate], section: IntArray, frames: FloatArray, turns: FloatArray
) -> FloatArray:
    """Return the transverse shear stiffness (n, 24, 24) in global axes.

    `frames` (n, 3, 3) has the elements' axes as columns, `turns` (n, 2, 2) leads from the laminates' axes to them.
    """
    local = ((points - points[:, :1]) @ frames)[:, :, :2]
    of_laminates = np.array([laminate.shear[::-1, ::-1] for laminate in laminates])  # (yz, xz) to (xz, yz)
    moduli = turns @ of_laminates[section] @ turns.transpose(0, 2, 1)
    matrices = shear_stiffness(local, moduli).reshape(-1, 8, 3, 8, 3)
    turned = np.einsum("eik,eakbl,ejl->eaibj", frames, matrices, frames, optimize=True)
    return np.asarray(turned.reshape(-1, N_DOFS, N_DOFS))


def _placed(corners: FloatArray, axis: FloatArray) -> "Quad4":
    """Return an element that sees only its own twelve coordinates."""
    library = element_library()
    element: Quad4 = library.Quad4(library.Quad4Probe())
    element.c1, element.c2, element.c3, element.c4 = 0, 6, 12, 18
    flat = np.ascontiguousarray(corners, dtype=np.float64).ravel()
    element.update_rotation_matrix(flat)
    align(element, axis)
    element.update_probe_xe(flat)
    return element
