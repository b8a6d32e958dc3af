"""Four-node laminated shell for flat and warped surfaces.

Rows of strain as in `quad4_rows`, integrated at 2 x 2 points; two enhanced membrane strains (rr by r, ss by s) that no
displacement has, eliminated in the element, let a side that bends contract across.

    K = sum over points of area (B' C B + DRILLING A_66 d' d),   C = [[A, B], [B, D]] and the transverse shear

Source of the enhanced strains: J. C. Simo, M. S. Rifai, Int. J. Numer. Meth. Engng 29 (1990) 1595-1638. DRILLING only
has to be more than 0: from .01 to 1 no figure of docs/wing.md moves by more than .02, but for the Raasch hook, which is
4 % off with .01.
"""

from collections.abc import Sequence

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.elements.frame import StrainOperator, batches, moduli
from femlib.elements.quad4_rows import N_DOFS, Elements
from femlib.elements.surface import GAUSS, frame, shape
from femlib.material import Laminate

N_NODES = 4
DRILLING = 0.1
"""Stiffness of the rotation about the normal against the surface's, over the membrane's shear stiffness."""


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
    matrices = np.empty((len(points), N_DOFS, N_DOFS))
    held, shear = moduli(laminates)
    for part in batches(len(points)):
        matrices[part] = _stiffness(Elements.of(points[part]), held[section[part]], shear[section[part]], axis)
    return matrices


def mass(points: FloatArray, laminates: Sequence[Laminate], section: IntArray) -> FloatArray:
    """Return the consistent mass matrices (n, 24, 24) in global axes, arguments as `stiffness`.

    The rotary inertia about the normal is that about the other axes, so that no rotation is without mass.
    """
    matrices = np.zeros((len(points), 4, 6, 4, 6))
    of_sections = np.array([[own.mass, own.mass_moment, own.rotary_inertia] for own in laminates])[section]
    for part in batches(len(points)):
        normals = Elements.of(points[part]).normals
        for r, s in GAUSS.tolist():
            area = frame(points[part], r, s, np.zeros(3)).area
            both = np.outer(shape(r, s), shape(r, s))
            whole, moment, rotary = (area[:, None, None] * of_sections[part].T[:, :, None, None]) * both
            for i in range(3):
                matrices[part, :, i, :, i] += whole
                matrices[part, :, 3 + i, :, 3 + i] += rotary
            arm = np.cross(np.eye(3)[None, None], normals[:, :, None])  # d(theta x V) / d(theta_j): (n, 4, j, i)
            pull = np.einsum("nkl,nlji->nkilj", moment, arm)
            matrices[part, :, :3, :, 3:] += pull
            matrices[part, :, 3:, :, :3] += pull.transpose(0, 3, 4, 1, 2)
    return matrices.reshape(-1, N_DOFS, N_DOFS)


def strain_operators(
    points: FloatArray,
    places: Sequence[tuple[float, float]],
    axis: FloatArray | None = None,
    sections: tuple[Sequence[Laminate], IntArray] | None = None,
) -> StrainOperator:
    """Return the strain rows of many elements with corners (n, 4, 3) [m] at natural coordinates `places`.

    The operator's arrays have leading axes: rows (n, n_places, 3, 24), axes (n, n_places, 3, 3), whose first is the
    projection of `axis`. With `sections`, laminates and the elements' index, the enhanced strains are in the rows.
    """
    direction = np.zeros(3) if axis is None else axis
    rows, axes = np.empty((len(points), len(places), 6, N_DOFS)), np.empty((len(points), len(places), 3, 3))
    for part in batches(len(points)):
        elements = Elements.of(points[part])
        for k, (r, s) in enumerate(places):
            local = frame(elements.points, r, s, direction)
            rows[part, k] = _strain_rows(elements, r, s, local.strains)
            axes[part, k] = local.axes
        if sections is not None:
            held = moduli(sections[0])[0][sections[1][part]]
            modes, work = _enhanced(elements, held, direction)[1:]
            own = np.linalg.solve(modes, work)  # minus the amplitudes
            for k, (r, s) in enumerate(places):
                rows[part, k] -= _mode_rows(elements, r, s, direction) @ own
    return StrainOperator(rows[:, :, :3], rows[:, :, 3:], axes)


def slope_rows(points: FloatArray, places: Sequence[tuple[float, float]], axis: FloatArray) -> FloatArray:
    """Return the rows (n, n_places, 2, 3, 24) of du along both axes, in global components, arguments as above.

    The normal displacement is linked to the corners' rotations: it is quadratic along a side whose ends turn apart.
    """
    rows = np.empty((len(points), len(places), 2, 3, N_DOFS))
    for part in batches(len(points)):
        elements = Elements.of(points[part])
        for k, (r, s) in enumerate(places):
            local = frame(elements.points, r, s, axis)
            rows[part, k] = np.einsum("nba,naij->nbij", local.along, elements.linked_slopes(r, s, local.axes[:, :, 2]))
    return rows


def _strain_rows(elements: Elements, r: float, s: float, turn: FloatArray) -> FloatArray:
    """Return membrane strains and curvatures (n, 6, 24) in the axes that `turn` (n, 3, 3) leads to."""
    return np.concatenate([turn @ elements.membrane(r, s), turn @ elements.curvature(r, s)], axis=1)


def _stiffness(elements: Elements, held: FloatArray, shear: FloatArray, axis: FloatArray) -> FloatArray:
    """Return the matrices (n, 24, 24)."""
    matrices, modes, work = _enhanced(elements, held, axis)
    matrices -= work.swapaxes(1, 2) @ np.linalg.solve(modes, work)
    for r, s in GAUSS.tolist():
        local = frame(elements.points, r, s, axis)
        rows = local.along @ elements.shear(r, s)
        matrices += rows.swapaxes(1, 2) @ (local.area[:, None, None] * shear) @ rows
        drill = elements.drilling(r, s, local)
        matrices += (DRILLING * held[:, 2, 2] * local.area)[:, None, None] * drill[:, :, None] * drill[:, None]
    return matrices


def _enhanced(elements: Elements, held: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return B' C B (n, 24, 24), M' C M (n, 2, 2) and M' C B (n, 2, 24), summed: B of displacements, M of modes."""
    n = len(elements.points)
    matrices, modes, work = np.zeros((n, N_DOFS, N_DOFS)), np.zeros((n, 2, 2)), np.zeros((n, 2, N_DOFS))
    for r, s in GAUSS.tolist():
        local = frame(elements.points, r, s, axis)
        rows = _strain_rows(elements, r, s, local.strains)
        own = _mode_rows(elements, r, s, axis)
        forces = local.area[:, None, None] * (held @ rows)
        matrices += rows.swapaxes(1, 2) @ forces
        work += own.swapaxes(1, 2) @ forces
        modes += own.swapaxes(1, 2) @ (local.area[:, None, None] * (held @ own))
    return matrices, modes, work


def _mode_rows(elements: Elements, r: float, s: float, axis: FloatArray) -> FloatArray:
    """Return the enhanced strains (n, 6, 2); their integrals over the area are zero, as constant strain asks."""
    middle = frame(elements.points, 0.0, 0.0, axis)
    area = frame(elements.points, r, s, axis).area
    rows = np.zeros((len(elements.points), 6, 2))
    rows[:, :3] = (middle.area / area)[:, None, None] * middle.strains[:, :, :2] * np.array([r, s])
    return rows
