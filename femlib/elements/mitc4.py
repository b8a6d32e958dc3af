"""Transverse shear of a four-node plate with tied edge strains: no locking, no hourglass mode.

letter = word: r, s natural coordinates in [-1, 1]; w deflection, r_x, r_y rotations, all in the element's axes; g shear
strain. Along an edge from node i to node j the covariant shear strain is constant,

    g_edge = (w_j - w_i) / 2 + (x_j - x_i) / 2 * mean(r_y) - (y_j - y_i) / 2 * mean(r_x),

g_r is linear in s between the edges 1-2 and 4-3, g_s linear in r between 1-4 and 2-3, and (g_xz, g_yz) = J^-1 (g_r,
g_s).

Source: K.-J. Bathe, E. N. Dvorkin, Int. J. Numer. Meth. Engng 21 (1985) 367-383, eqs 4 to 7. pyfe3d's own one-point
shear is switched off instead of added to: on a distorted patch it missed constant curvature by 69 %, and a free flat
mesh had a seventh mode without energy.
"""

import numpy as np

from femlib.arrays import FloatArray

GAUSS = 1.0 / np.sqrt(3.0)


def shear_stiffness(points: FloatArray, moduli: FloatArray) -> FloatArray:
    """Return the shear stiffness (n, 24, 24) in the elements' axes.

    Parameters
    ----------
    points : FloatArray
        Corners in the elements' axes (n, 4, 2) [m].
    moduli : FloatArray
        Shear stiffness (n, 2, 2) of the strains (xz, yz) in the elements' axes [N/m].
    """
    matrices = np.zeros((len(points), 24, 24))
    for r in (-GAUSS, GAUSS):
        for s in (-GAUSS, GAUSS):
            jacobian = _jacobian(points, r, s)
            rows = np.linalg.solve(jacobian, _covariant_rows(points, r, s))
            area = np.linalg.det(jacobian)
            matrices += np.einsum("e,eai,eab,ebj->eij", area, rows, moduli, rows, optimize=True)
    return matrices


def _jacobian(points: FloatArray, r: float, s: float) -> FloatArray:
    """Return d(x, y) / d(r, s), row r then row s (n, 2, 2)."""
    along_r = 0.25 * np.array([s - 1, 1 - s, 1 + s, -1 - s])
    along_s = 0.25 * np.array([r - 1, -1 - r, 1 + r, 1 - r])
    return np.stack([along_r, along_s]) @ points


def _covariant_rows(points: FloatArray, r: float, s: float) -> FloatArray:
    """Return the rows of (g_r, g_s) on the element's displacements (n, 2, 24)."""
    rows = np.zeros((len(points), 2, 24))
    tied = ((0, 0, 1, 0.5 * (1 - s)), (0, 3, 2, 0.5 * (1 + s)), (1, 0, 3, 0.5 * (1 - r)), (1, 1, 2, 0.5 * (1 + r)))
    for direction, start, end, weight in tied:
        edge = 0.5 * (points[:, end] - points[:, start])
        for node, sign in ((start, -1.0), (end, 1.0)):
            rows[:, direction, 6 * node + 2] += weight * 0.5 * sign
            rows[:, direction, 6 * node + 3] -= weight * 0.5 * edge[:, 1]
            rows[:, direction, 6 * node + 4] += weight * 0.5 * edge[:, 0]
    return rows
