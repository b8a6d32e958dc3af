"""Strain rows of the four-node shell on its displacements, all exactly zero in any rigid motion, warped or not.

letter = word: x corners, V unit normals at the corners; u, theta displacement and rotation of a corner, N shape
functions; beta = sum N theta x V slope of the director; Omega the element's own rotation, from du at its middle. Rows
are covariant, (rr, ss, 2 rs), and act on (u, theta) of the corners in global axes:

    membrane    e_ab = g_a . (u + a),b + g_b . (u + a),a
    curvature   k_ab = g_a . beta,b + g_b . beta,a + V,a . u,b + V,b . u,a
    shear       c_a  = g_a . beta + V . u,a     tied: c_r at (0, -1) and (0, 1), c_s at (-1, 0) and (1, 0)
    drilling    d    = sum N (theta - Omega) . V + (Omega - rotation of u + a) . n

a are Allman's displacements, which let a side bend in its plane: on the side from i to j of length l with normal m

    a = bubble(side) l / 8 m (p_j - p_i),   p = (theta - Omega) . V.

Allman's p is theta along one normal of the element. On a warped element that feels a bending rotation as drilling, and
a twisted strip 3,750 times as long as thick had .3 of its displacement with twelve elements; the corners' own normals,
with the element's rotation taken off so that a rigid motion has none, give it .97.

Sources: E. N. Dvorkin, K.-J. Bathe, Engineering Computations 1 (1984) 77-88 (directors, tied shear); A. Ibrahimbegovic,
R. L. Taylor, E. L. Wilson, Int. J. Numer. Meth. Engng 30 (1990) 445-457 (a, drilling; here with p).
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.elements.rotations import skew
from femlib.elements.surface import Frame, corner_normals, frame, shape, slopes, tangents

N_DOFS = 24
SIDES = ((0, 1), (1, 2), (2, 3), (3, 0))
ALONG = np.array([[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]])
"""Which sides run along r and along s (2, 4)."""
LINKED = np.sqrt(2.0)
"""More than 1, so that the geometric stiffness errs as the stiffness does, by (k h)^2 / 12 for a wave number k, and
buckling loads converge with the fourth power of the step h. A square plate's first two, compressed, with 12 elements a
side: -0.1 and -1.0 %; with 1 0.4 and 1.3 %, without rotations 1.0 and 3.7 %; in shear 0.4, 2.0 and 6.2 %."""


@dataclass(frozen=True, slots=True, eq=False)
class Elements:
    """Elements whose rows are asked for.

    Attributes
    ----------
    points, normals : FloatArray
        Corners about their mean [m], and unit normals there (n, 4, 3).
    spin : FloatArray
        Rows of Omega (n, 3, 24).
    side : FloatArray
        Rows of l / 8 m (p_j - p_i) of each side (n, 4, 3, 24).
    deviation : FloatArray
        Rows of p (n, 4, 24).
    """

    points: FloatArray
    normals: FloatArray
    spin: FloatArray
    side: FloatArray
    deviation: FloatArray

    @classmethod
    def of(cls, corners: FloatArray) -> "Elements":
        """Return the elements with corners (n, 4, 3) [m]."""
        points = corners - corners.mean(axis=1, keepdims=True)
        normals = corner_normals(points)
        middle = frame(points, 0.0, 0.0, np.zeros(3))
        spin = _spin_rows(middle, _gradient_rows(middle, _displacement_slopes(len(points), 0.0, 0.0)))
        deviation = -np.einsum("nki,nij->nkj", normals, spin)
        for k in range(4):
            deviation[:, k, 6 * k + 3 : 6 * k + 6] += normals[:, k]
        edges = np.roll(points, -1, axis=1) - points
        outward = np.cross(edges, middle.axes[:, None, :, 2]) / 8.0
        step = np.roll(deviation, -1, axis=1) - deviation
        return cls(points, normals, spin, outward[:, :, :, None] * step[:, :, None], deviation)

    def tangents(self, r: float, s: float) -> FloatArray:
        """Return g_r, g_s (n, 2, 3)."""
        return tangents(self.points, r, s)

    def membrane(self, r: float, s: float) -> FloatArray:
        """Return the membrane rows (n, 3, 24)."""
        return _symmetric(self.tangents(r, s), self.slopes(r, s))

    def curvature(self, r: float, s: float) -> FloatArray:
        """Return the curvature rows (n, 3, 24) [1/m]."""
        turned = _symmetric(self.tangents(r, s), self._director_slopes(r, s))
        return turned + _symmetric(tangents(self.normals, r, s), _displacement_slopes(len(self.points), r, s))

    def shear(self, r: float, s: float) -> FloatArray:
        """Return the transverse shear rows (c_r, c_s) (n, 2, 24)."""
        along_r = 0.5 * (1.0 - s) * self._shear_at(0.0, -1.0, 0) + 0.5 * (1.0 + s) * self._shear_at(0.0, 1.0, 0)
        along_s = 0.5 * (1.0 - r) * self._shear_at(-1.0, 0.0, 1) + 0.5 * (1.0 + r) * self._shear_at(1.0, 0.0, 1)
        return np.stack([along_r, along_s], axis=1)

    def drilling(self, r: float, s: float, local: Frame) -> FloatArray:
        """Return the rows (n, 24) of the rotation about the normal that is not the surface's own."""
        own = _normal_spin(local, _gradient_rows(local, self.slopes(r, s)))
        whole = np.einsum("ni,nij->nj", local.axes[:, :, 2], self.spin)
        return np.asarray(np.einsum("k,nkj->nj", shape(r, s), self.deviation) + whole - own)

    def slopes(self, r: float, s: float) -> FloatArray:
        """Return the rows of d(u + a) by r and by s (n, 2, 3, 24)."""
        return np.asarray(
            _displacement_slopes(len(self.points), r, s) + np.einsum("ak,nkij->naij", _bubble_slopes(r, s), self.side)
        )

    def linked_slopes(self, r: float, s: float, normal: FloatArray) -> FloatArray:
        """Return the rows of d(u + a) by r and by s (n, 2, 3, 24) with w = u . normal (n, 3) linked to the rotations.

        Between the ends of a side, w,r = (w_j - w_i) / 2 - LINKED / 4 (beta_j - beta_i) . (x_j - x_i) rho, rho from -1
        to 1: with LINKED = 1 the slope of the directors, which a thin shell's surface follows.
        """
        turn = -skew(self.normals)  # beta of a corner by its rotation
        edges = np.roll(self.points, -1, axis=1) - self.points
        rows = np.zeros((len(self.points), 4, 4, 6))
        for k, (i, j) in enumerate(SIDES):
            rows[:, k, j, 3:] += np.einsum("na,nab->nb", edges[:, k], turn[:, j])
            rows[:, k, i, 3:] -= np.einsum("na,nab->nb", edges[:, k], turn[:, i])
        along = LINKED / 8.0 * ALONG * _bubble_slopes(r, s)
        bubbles = np.einsum("ak,nkj->naj", along, rows.reshape(-1, 4, N_DOFS))
        return np.asarray(self.slopes(r, s) + normal[:, None, :, None] * bubbles[:, :, None])

    def _director_slopes(self, r: float, s: float) -> FloatArray:
        """Return the rows of d(beta) by r and by s (n, 2, 3, 24)."""
        rows = np.zeros((len(self.points), 2, 3, 4, 6))
        rows[..., 3:] = np.einsum("ak,nkij->naikj", slopes(r, s), -skew(self.normals))
        return rows.reshape(-1, 2, 3, N_DOFS)

    def _shear_at(self, r: float, s: float, direction: int) -> FloatArray:
        """Return c of one direction at a point (n, 24)."""
        along, shares = self.tangents(r, s)[:, direction], shape(r, s)
        rows = np.zeros((len(self.points), 4, 6))
        director = shares @ self.normals
        rows[..., :3] = slopes(r, s)[direction][:, None] * director[:, None]
        rows[..., 3:] = shares[:, None] * np.cross(self.normals, along[:, None])
        return rows.reshape(-1, N_DOFS)


def _symmetric(along: FloatArray, rows: FloatArray) -> FloatArray:
    """Return (a_r . b_r, a_s . b_s, a_r . b_s + a_s . b_r) of vectors (n, 2, 3) and rows (n, 2, 3, 24)."""
    product = np.einsum("nai,nbij->nabj", along, rows)
    return np.stack([product[:, 0, 0], product[:, 1, 1], product[:, 0, 1] + product[:, 1, 0]], axis=1)


def _displacement_slopes(n: int, r: float, s: float) -> FloatArray:
    """Return the rows of du by r and by s (n, 2, 3, 24)."""
    rows = np.zeros((2, 3, 4, 6))
    for i in range(3):
        rows[:, i, :, i] = slopes(r, s)
    return np.broadcast_to(rows.reshape(2, 3, N_DOFS), (n, 2, 3, N_DOFS))


def _bubble_slopes(r: float, s: float) -> FloatArray:
    """Return the derivatives (2, 4) of the sides' functions (1 - r^2)(1 - s) / 2, (1 - s^2)(1 + r) / 2, ..."""
    return np.array(
        [
            [-r * (1.0 - s), 0.5 * (1.0 - s * s), -r * (1.0 + s), -0.5 * (1.0 - s * s)],
            [-0.5 * (1.0 - r * r), -s * (1.0 + r), 0.5 * (1.0 - r * r), -s * (1.0 - r)],
        ]
    )


def _gradient_rows(local: Frame, rows: FloatArray) -> FloatArray:
    """Return derivatives along the first and second axis (n, 2, 3, 24), their components in the frame."""
    return np.asarray(np.einsum("nba,nki,nakj->nbij", local.along, local.axes, rows, optimize=True))


def _normal_spin(local: Frame, gradient: FloatArray) -> FloatArray:
    """Return the rows (n, 24) of the surface's rotation about its normal."""
    return np.asarray(0.5 * (gradient[:, 0, 1] - gradient[:, 1, 0]))


def _spin_rows(local: Frame, gradient: FloatArray) -> FloatArray:
    """Return the rows (n, 3, 24) of the surface's rotation in global axes."""
    own = np.stack([gradient[:, 1, 2], -gradient[:, 0, 2], _normal_spin(local, gradient)], axis=1)
    return np.asarray(local.axes @ own)
