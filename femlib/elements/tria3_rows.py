"""Strain rows of the three-node shell in its plane, all exactly zero in any rigid motion.

letter = word: x, y corners in the element's axes, x_ij = x_i - x_j, A area, l_ij length of a side, zeta area
coordinates, theta rotation about the normal, b slopes of the director (b_x = theta_y, b_y = -theta_x); columns are (u,
v, w, theta_x, theta_y, theta_z) of each corner, then the bubble's two slopes.

    membrane   e = (L' / A) u + 3 / 2 sqrt(beta_0) T_e (zeta_1 Q_1 + zeta_2 Q_2 + zeta_3 Q_3) (theta - theta_0)
    curvature  k = (b_x,x ; b_y,y ; b_x,y + b_y,x),   b = sum zeta_i b_i + 27 zeta_1 zeta_2 zeta_3 b_4
    shear      tied: constant along the sides, and a part that twists, measured within `NEAR` of the middle

The membrane strains are those of Felippa's optimal triangle: two that make a rectangle have exactly a beam's energy
when they bend in their plane, whatever its length over width. A mean strain (L' / A) u carries constant strain; what a
rotation has beyond the element's own (theta_0) makes the linear rest, whose mean is zero. beta_0 depends on the
material and is `bending_factor`. The curvature and shear are those of MITC3+, with the bubble as difference from the
corners' mean.

Sources: C. A. Felippa, Comput. Methods Appl. Mech. Engng 192 (2003) 2125-2168 (OPT); Y. Lee, P.-S.
Lee, K.-J. Bathe, Computers & Structures 138 (2014) 12-23 (MITC3+). The formulas are held by the beam's energy and
the patch tests, not by equation numbers.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.elements.surface import axes_in

N_DOFS = 18
WITH_BUBBLE = N_DOFS + 2
LUMPED = 1.5
"""Share alpha_b of the rotations in the mean strain."""
LEAST_BENDING = 0.01
"""Least beta_0, so that no rotation is without stiffness."""
NEAR = 1e-4
"""Distance d of the twisting shear's points from the middle."""
CYCLES = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
SLOPES = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
"""Derivatives of the area coordinates by r = zeta_2 and s = zeta_3."""
_BETA = np.array([1.0, 2.0, 1.0, 0.0, 1.0, -1.0, -1.0, -1.0, -2.0])
_PLACES = np.array(
    [[[0, 1, 2], [3, 4, 5], [6, 7, 8]], [[8, 6, 7], [2, 0, 1], [5, 3, 4]], [[4, 5, 3], [7, 8, 6], [1, 2, 0]]]
)
PATTERN = _BETA[_PLACES]
"""Numerators of Q_1, Q_2, Q_3, rows by the sides 2-1, 3-2, 1-3."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """Triangles whose rows are asked for.

    Attributes
    ----------
    plane : FloatArray
        Corners in their axes (n, 3, 2) [m].
    axes : FloatArray
        Columns are the first axis, the second and the normal (n, 3, 3).
    area : FloatArray
        Areas (n,) [m^2].
    along : FloatArray
        d(r, s) / d(first, second axis): rows are axes (n, 2, 2) [1/m].
    """

    plane: FloatArray
    axes: FloatArray
    area: FloatArray
    along: FloatArray

    @classmethod
    def of(cls, corners: FloatArray, axis: FloatArray) -> "Triangles":
        """Return the elements with corners (n, 3, 3) [m], their first axis the projection of `axis` (3,), or a side."""
        points = corners - corners.mean(axis=1, keepdims=True)
        twice, axes = axes_in(SLOPES @ points, axis)
        plane = (points @ axes)[:, :, :2]
        return cls(plane, axes, 0.5 * twice, np.linalg.inv(SLOPES @ plane))

    def mean_membrane(self) -> FloatArray:
        """Return the rows (n, 3, 18) of the mean membrane strain."""
        rows = np.zeros((len(self.plane), 3, 3, 6))
        x, y = np.moveaxis(self.plane, -1, 0)
        for i, j, k in CYCLES:
            rows[:, 0, i, 0] = rows[:, 2, i, 1] = y[:, j] - y[:, k]
            rows[:, 1, i, 1] = rows[:, 2, i, 0] = x[:, k] - x[:, j]
            before, after = (x[:, k] - x[:, i], y[:, i] - y[:, k]), (x[:, i] - x[:, j], y[:, j] - y[:, i])
            rows[:, 0, i, 5] = LUMPED / 6.0 * (y[:, j] - y[:, k]) * (before[1] - after[1])
            rows[:, 1, i, 5] = LUMPED / 6.0 * (x[:, k] - x[:, j]) * (before[0] - after[0])
            rows[:, 2, i, 5] = LUMPED / 3.0 * (before[0] * before[1] - after[0] * after[1])
        return np.asarray(rows.reshape(-1, 3, N_DOFS) / (2.0 * self.area[:, None, None]))

    def membrane(self, zeta: FloatArray, factor: FloatArray) -> FloatArray:
        """Return the membrane rows (n, 3, 18) at area coordinates (3,), beta_0 being `factor` (n,)."""
        own = self._natural() @ (zeta @ PATTERN.reshape(3, 9)).reshape(3, 3) * (2.0 * self.area / 3.0)[:, None, None]
        linear = 1.5 * np.sqrt(factor)[:, None, None] * (own @ self._own_rotations())
        return np.asarray(self.mean_membrane() + linear)

    def curvature(self, zeta: FloatArray) -> FloatArray:
        """Return the curvature rows (n, 3, 20) at area coordinates (3,) [1/m]."""
        slopes = np.zeros((len(self.plane), 2, 4))  # of the four functions along both axes
        slopes[:, :, :3] = self.along @ SLOPES
        slopes[:, :, 3] = self.along @ _bubble_slopes(zeta)
        rows = np.zeros((len(self.plane), 3, WITH_BUBBLE))
        for k in range(4):
            for component, row in enumerate(_slope_columns(k)):
                column, sign = row
                rows[:, component, column] += sign * slopes[:, component, k]
                rows[:, 2, column] += sign * slopes[:, 1 - component, k]
        return rows

    def shear(self, zeta: FloatArray) -> FloatArray:
        """Return the transverse shear rows (xz, yz) (n, 2, 20) at area coordinates (3,)."""
        _, r, s = zeta.tolist()
        at_a, at_b, at_c = (self._shear_at(*p) for p in ((1 / 6, 2 / 3), (2 / 3, 1 / 6), (1 / 6, 1 / 6)))
        third, d = 1.0 / 3.0, NEAR
        at_d, at_e, at_f = (
            self._shear_at(*p) for p in ((third + d, third - 2 * d), (third - 2 * d, third + d), (third + d, third + d))
        )
        twist = at_f[:, 0] - at_d[:, 0] - at_f[:, 1] + at_e[:, 1]
        common = third * (at_c[:, 0] + at_c[:, 1])
        along_r = 2.0 * third * (at_b[:, 0] - 0.5 * at_b[:, 1]) + common + third * (3.0 * s - 1.0) * twist
        along_s = 2.0 * third * (at_a[:, 1] - 0.5 * at_a[:, 0]) + common + third * (1.0 - 3.0 * r) * twist
        return np.asarray(self.along @ np.stack([along_r, along_s], axis=1))

    def to_global(self, rows: FloatArray) -> FloatArray:
        """Return rows (n, k, 18) on the corners' displacements in global axes."""
        n, k = rows.shape[:2]
        turned = rows.reshape(n, 2 * k * 3, 3) @ self.axes.swapaxes(1, 2)
        return np.asarray(turned.reshape(n, k, N_DOFS))

    def _natural(self) -> FloatArray:
        """Return T_e over l^2 (n, 3, 3): strains (xx, yy, xy) from those along the sides 2-1, 3-2, 1-3, times l^2.

        The squares of the sides' lengths in T_e and in Q cancel.
        """
        rows = np.empty((len(self.plane), 3, 3))
        x, y = np.moveaxis(self.plane, -1, 0)
        for side, (i, j, k) in enumerate(CYCLES):  # the side from i to j
            rows[:, 0, side] = (y[:, j] - y[:, k]) * (y[:, i] - y[:, k])
            rows[:, 1, side] = (x[:, j] - x[:, k]) * (x[:, i] - x[:, k])
            rows[:, 2, side] = (y[:, j] - y[:, k]) * (x[:, k] - x[:, i]) + (x[:, k] - x[:, j]) * (y[:, i] - y[:, k])
        return rows / (4.0 * self.area**2)[:, None, None]

    def _own_rotations(self) -> FloatArray:
        """Return the rows (n, 3, 18) of each corner's rotation about the normal less the element's own."""
        rows = np.zeros((len(self.plane), 3, 6))
        x, y = np.moveaxis(self.plane, -1, 0)
        for i, j, k in CYCLES:
            rows[:, i, 0] = (x[:, k] - x[:, j]) / (4.0 * self.area)
            rows[:, i, 1] = (y[:, k] - y[:, j]) / (4.0 * self.area)
        every = np.repeat(rows[:, None], 3, axis=1)
        for i in range(3):
            every[:, i, i, 5] = 1.0
        return every.reshape(-1, 3, N_DOFS)

    def _shear_at(self, r: float, s: float) -> FloatArray:
        """Return (c_r, c_s) (n, 2, 20) of the displacements at a point: slope of w, and the director's."""
        zeta = np.array([1.0 - r - s, r, s])
        shares = [*zeta, 27.0 * zeta.prod()]
        sides = SLOPES @ self.plane
        rows = np.zeros((len(self.plane), 2, WITH_BUBBLE))
        rows[:, :, 2:N_DOFS:6] = SLOPES
        for k, share in enumerate(shares):
            for component, (column, sign) in enumerate(_slope_columns(k)):
                rows[:, :, column] += sign * share * sides[:, :, component]
        return rows


def bending_factor(membrane: FloatArray) -> float:
    """Return beta_0 of a membrane stiffness (3, 3): (1 - 4 nu^2) / 2 if it is isotropic.

    It makes the energy of in-plane bending, averaged over the directions, that of a beam. Source: C. A. Felippa
    (2003).
    """
    (a, b, c), (_, d, e), (_, _, g) = membrane.tolist()
    w = -6 * b**3 + 5 * a**2 * d - 5 * b**2 * d - d * (75 * c**2 + 14 * c * e + 3 * e**2)
    w += 2 * b * (7 * c**2 + 46 * c * e + 7 * e**2)
    w -= a * (5 * b**2 + 3 * c**2 - 6 * b * d - 5 * d**2 + 14 * c * e + 75 * e**2)
    w += (3 * a**2 + 82 * a * d + 3 * d**2 - 4 * (6 * b**2 + 5 * c**2 - 6 * c * e + 5 * e**2)) * g
    w += 4 * (5 * a - 6 * b + 5 * d) * g**2
    return max(float(256.0 * np.linalg.det(membrane) / w) - 1.5, LEAST_BENDING)


def _slope_columns(k: int) -> tuple[tuple[int, float], tuple[int, float]]:
    """Return column and sign of b_x and b_y of corner k, or of the bubble (3)."""
    if k == 3:
        return (N_DOFS, 1.0), (N_DOFS + 1, 1.0)
    return (6 * k + 4, 1.0), (6 * k + 3, -1.0)


def _bubble_slopes(zeta: FloatArray) -> FloatArray:
    """Return the derivatives (2,) of 27 zeta_1 zeta_2 zeta_3 by r and s."""
    first, second, third = zeta.tolist()
    return 27.0 * np.array([third * (first - second), second * (first - third)])
