"""Three-node laminated shell with discrete shear gaps.

Source: K.-U. Bletzinger, M. Bischoff, E. Ramm, Computers & Structures 75 (2000) 321-334, as in pyfe3d. Its membrane
part is the constant-strain triangle: stiff in in-plane bending, so the wing uses it only where a rib ends in a point.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.elements.frame import StrainOperator, align, element_axes, element_library, shell_property, to_global
from femlib.elements.rotations import skew
from femlib.material import Laminate, isotropic_plate

if TYPE_CHECKING:
    from pyfe3d import Tria3DSG

N_NODES = 3
N_DOFS = 18
MIDDLES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]])
"""Area coordinates of the middles of the sides."""


def stiffness(points: FloatArray, laminates: Sequence[Laminate], section: IntArray, axis: FloatArray) -> FloatArray:
    """Return the stiffness matrices (n, 18, 18) in global axes, arguments as the quadrilateral's."""
    properties = [shell_property(laminate) for laminate in laminates]
    values = np.zeros((len(points), N_DOFS * N_DOFS))
    unused = np.zeros(1, dtype=element_library().INT)
    for corners, kind, row in zip(points, section, values, strict=True):
        _placed(corners, axis).update_KC0(unused, unused, row, properties[kind], 1)
    return values.reshape(-1, N_DOFS, N_DOFS)


def mass(points: FloatArray, laminates: Sequence[Laminate], section: IntArray) -> FloatArray:
    """Return the consistent mass matrices (n, 18, 18) in global axes."""
    properties = [shell_property(laminate) for laminate in laminates]
    matrices = np.zeros((len(points), N_DOFS, N_DOFS))
    rows, columns = np.zeros(N_DOFS**2, dtype=element_library().INT), np.zeros(N_DOFS**2, dtype=element_library().INT)
    for corners, kind, matrix in zip(points, section, matrices, strict=True):
        values = np.zeros(N_DOFS**2)
        _placed(corners, np.zeros(3)).update_M(rows, columns, values, properties[kind], 0)
        np.add.at(matrix, (rows, columns), values)
    return matrices


def strain_operator(points: FloatArray) -> StrainOperator:
    """Return the strain rows, constant over the element, of one element with corners (3, 3) [m]."""
    element = _placed(points, np.zeros(3))
    probe = element.probe
    # the library fills the strain rows only while it forms a stiffness, whatever the section is
    unused = np.zeros(1, dtype=element_library().INT)
    element.update_KC0(unused, unused, np.zeros(N_DOFS**2), shell_property(isotropic_plate(1.0, 0.0, 1.0)), 1)
    axes = element_axes(element)
    membrane = np.array([probe.BLexx, probe.BLeyy, probe.BLgxy])
    curvature = np.array([probe.BLkxx, probe.BLkyy, probe.BLkxy])
    return StrainOperator(to_global(membrane, axes), to_global(curvature, axes), axes)


def slope_rows(points: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the rows (n, 3, 2, 3, 18) of du along `axes` (n, 3, 3) at the sides' middles, as the quadrilateral's."""
    flat = points @ axes[:, :, :2]
    sides = np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=1)
    shares = np.linalg.solve(sides, np.broadcast_to([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]], (len(points), 2, 3)))
    rows = np.zeros((len(points), 3, 2, 3, 3, 6))
    for i in range(3):
        rows[:, :, :, i, :, i] = shares[:, None]
    normal = axes[:, :, 2]
    turn = -skew(normal)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        # b = 4 L_i L_j / 8 (beta_j - beta_i) . (x_j - x_i) along the normal
        held = np.einsum("na,nab->nb", points[:, j] - points[:, i], turn) / 2.0
        for place, area in enumerate(MIDDLES):
            slope = area[i] * shares[:, :, j] + area[j] * shares[:, :, i]
            bubble = slope[:, :, None, None] * normal[:, None, :, None] * held[:, None, None, :]
            rows[:, place, :, :, j, 3:] += bubble
            rows[:, place, :, :, i, 3:] -= bubble
    return rows.reshape(len(points), 3, 2, 3, N_DOFS)


def _placed(corners: FloatArray, axis: FloatArray) -> "Tria3DSG":
    """Return an element that sees only its own nine coordinates."""
    library = element_library()
    element: Tria3DSG = library.Tria3DSG(library.Tria3DSGProbe())
    element.c1, element.c2, element.c3 = 0, 6, 12
    flat = np.ascontiguousarray(corners, dtype=np.float64).ravel()
    element.update_rotation_matrix(flat)
    align(element, axis)
    element.update_probe_xe(flat)
    return element
