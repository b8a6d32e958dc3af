"""A simply supported cross-ply plate in three-dimensional elasticity: the state-space form of Pagano's solution.

With displacements (u cos ax sin by, v sin ax cos by, w sin ax sin by) and b = a = pi (a unit square) the state y(z) =
(u, v, w, s_xz, s_yz, s_zz) of a ply obeys y' = M y, so that a stack is a product of matrix exponentials. A pressure of
one on the top face and none below give the state at the bottom.

Sources: N. J. Pagano, J. Composite Materials 4 (1970) 20-34; the state-space form as in J. Ye, Laminated Composite
Plates and Shells: 3D Modelling (2003), chapter 3.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import expm

from femlib.arrays import FloatArray
from femlib.material import Ply


def pagano_deflection(ply: Ply, angles: Sequence[float], slenderness: float) -> float:
    """Return the deflection of the middle plane of a unit square under a pressure of amplitude 1, its plies alike.

    A ply is transversely alike: E_3 = E_2, nu_13 = nu_23 = nu_12. Angles are 0 or a right angle.
    """
    step = 1.0 / slenderness / len(angles)
    size = ply.young_2  # stresses in its unit keep the exponentials well scaled
    layers = [expm(_state_matrix(ply, abs(np.cos(angle)) > 0.5, size) * step) for angle in angles]
    whole = np.linalg.multi_dot([*layers[::-1], np.eye(6)]) if len(layers) > 1 else layers[0]
    below = np.linalg.solve(whole[3:, :3], np.array([0.0, 0.0, 1.0 / size]))
    middle = np.eye(6)
    for layer in layers[: len(layers) // 2]:
        middle = layer @ middle
    return float((middle @ np.concatenate([below, np.zeros(3)]))[2])


def _state_matrix(ply: Ply, is_along: bool, size: float) -> FloatArray:
    """Return M of a ply whose fibres run along x, or along y."""
    nu, e1, e2 = ply.poisson_12, ply.young_1, ply.young_2
    compliance = np.array([[1 / e1, -nu / e1, -nu / e1], [-nu / e1, 1 / e2, -nu / e2], [-nu / e1, -nu / e2, 1 / e2]])
    c = np.linalg.inv(compliance) / size
    g_xz, g_yz, g_xy = ply.shear_13 / size, ply.shear_23 / size, ply.shear_12 / size
    if not is_along:
        c, g_xz, g_yz = c[np.ix_([1, 0, 2], [1, 0, 2])], g_yz, g_xz
    a = np.pi
    m = np.zeros((6, 6))
    m[0, [2, 3]] = -a, 1.0 / g_xz
    m[1, [2, 4]] = -a, 1.0 / g_yz
    m[2, [0, 1, 5]] = a * c[0, 2] / c[2, 2], a * c[1, 2] / c[2, 2], 1.0 / c[2, 2]
    q = c[:2, :2] - np.outer(c[:2, 2], c[2, :2]) / c[2, 2]
    m[3, [0, 1, 5]] = a**2 * (q[0, 0] + g_xy), a**2 * (q[0, 1] + g_xy), -a * c[0, 2] / c[2, 2]
    m[4, [0, 1, 5]] = a**2 * (q[0, 1] + g_xy), a**2 * (q[1, 1] + g_xy), -a * c[1, 2] / c[2, 2]
    m[5, [3, 4]] = a, a
    return m
