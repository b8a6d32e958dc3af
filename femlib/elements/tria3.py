"""Three-node laminated shell: Felippa's optimal membrane triangle with drilling rotations, MITC3+ in bending.

Rows of strain as in `tria3_rows`, integrated at six points; the bubble's two slopes are eliminated in the element.

    K = sum over points of area B' C B,   C = [[A, B], [B, D]] and the transverse shear

Source of the points: D. A. Dunavant, Int. J. Numer. Meth. Engng 21 (1985) 1129-1148, degree 4, that of the bubble's
curvatures squared.
"""

from collections.abc import Sequence

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.elements.frame import StrainOperator, batches, moduli
from femlib.elements.rotations import skew
from femlib.elements.tria3_rows import N_DOFS, WITH_BUBBLE, Triangles, bending_factor
from femlib.material import Laminate

N_NODES = 3
MIDDLE = np.full((1, 3), 1.0 / 3.0)
MIDDLES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]])
"""Area coordinates of the middle and of the sides' middles."""
_A, _B = 0.445948490915965, 0.091576213509771
POINTS = np.array([np.roll([1.0 - 2.0 * a, a, a], k) for a in (_A, _B) for k in range(3)])
WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)
"""Points of the six-point rule in area coordinates (6, 3), and their shares of the area (6,)."""


def stiffness(points: FloatArray, laminates: Sequence[Laminate], section: IntArray, axis: FloatArray) -> FloatArray:
    """Return the stiffness matrices (n, 18, 18) in global axes, arguments as the quadrilateral's."""
    matrices = np.empty((len(points), N_DOFS, N_DOFS))
    held, shear = moduli(laminates)
    factor = np.array([bending_factor(own.membrane) for own in laminates])
    for part in batches(len(points)):
        own = section[part]
        matrices[part] = _stiffness(Triangles.of(points[part], axis), held[own], shear[own], factor[own])
    return matrices


def mass(points: FloatArray, laminates: Sequence[Laminate], section: IntArray) -> FloatArray:
    """Return the consistent mass matrices (n, 18, 18) in global axes.

    The rotary inertia about the normal is that about the other axes, so that no rotation is without mass.
    """
    matrices = np.zeros((len(points), 3, 6, 3, 6))
    of_sections = np.array([[own.mass, own.mass_moment, own.rotary_inertia] for own in laminates])[section]
    triangles = Triangles.of(points, np.zeros(3))
    both = (1.0 + np.eye(3)) / 12.0
    whole, moment, rotary = (triangles.area[:, None, None] * of_sections.T[:, :, None, None]) * both
    for i in range(3):
        matrices[:, :, i, :, i] = whole
        matrices[:, :, 3 + i, :, 3 + i] = rotary
    arm = np.cross(np.eye(3)[None], triangles.axes[:, None, :, 2])  # d(theta x n) / d(theta_j): (n, j, i)
    pull = np.einsum("nkl,nji->nkilj", moment, arm)
    matrices[:, :, :3, :, 3:] += pull
    matrices[:, :, 3:, :, :3] += pull.transpose(0, 3, 4, 1, 2)
    return matrices.reshape(-1, N_DOFS, N_DOFS)


def strain_operators(
    points: FloatArray,
    places: FloatArray,
    axis: FloatArray | None = None,
    sections: tuple[Sequence[Laminate], IntArray] | None = None,
) -> StrainOperator:
    """Return the strain rows of many elements with corners (n, 3, 3) [m] at area coordinates `places` (n_places, 3).

    The operator's arrays are as the quadrilateral's: rows (n, n_places, 3, 18), axes (n, n_places, 3, 3). With
    `sections`, laminates and the elements' index, the linear part of the membrane strains is in the rows. The bubble's
    curvatures, whose mean is zero, are left out.
    """
    triangles = Triangles.of(points, np.zeros(3) if axis is None else axis)
    factor = np.zeros(len(points))
    if sections is not None:
        factor = np.array([bending_factor(own.membrane) for own in sections[0]])[sections[1]]
    curved = triangles.to_global(triangles.curvature(MIDDLE[0])[:, :, :N_DOFS])
    flat = [triangles.to_global(triangles.membrane(zeta, factor)) for zeta in places]
    n_places = len(places)
    return StrainOperator(
        np.stack(flat, axis=1),
        np.repeat(curved[:, None], n_places, axis=1),
        np.repeat(triangles.axes[:, None], n_places, axis=1),
    )


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


def _stiffness(triangles: Triangles, held: FloatArray, shear: FloatArray, factor: FloatArray) -> FloatArray:
    """Return the matrices (n, 18, 18)."""
    n = len(triangles.area)
    whole = np.zeros((n, WITH_BUBBLE, WITH_BUBBLE))
    rows = np.zeros((n, 8, WITH_BUBBLE))
    both = np.zeros((n, 8, 8))
    both[:, :6, :6], both[:, 6:, 6:] = held, shear
    for zeta, weight in zip(POINTS, WEIGHTS, strict=True):
        rows[:, :3, :N_DOFS] = triangles.membrane(zeta, factor)
        rows[:, 3:6], rows[:, 6:] = triangles.curvature(zeta), triangles.shear(zeta)
        # turned before they are squared: rounding then gives a rigid motion the square of its share of energy
        rows[:, :, :N_DOFS] = triangles.to_global(rows[:, :, :N_DOFS])
        whole += rows.swapaxes(1, 2) @ ((weight * triangles.area)[:, None, None] * both) @ rows
    bubble, corners = slice(N_DOFS, WITH_BUBBLE), slice(N_DOFS)
    work = whole[:, bubble, corners]
    return np.asarray(
        whole[:, corners, corners] - work.swapaxes(1, 2) @ np.linalg.solve(whole[:, bubble, bubble], work)
    )
