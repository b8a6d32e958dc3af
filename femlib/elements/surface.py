"""The bilinear surface through four corners: shape functions, tangents, corner normals and frames, many at once.

letter = word: r, s natural coordinates in [-1, 1]; g_r, g_s tangents dx/dr, dx/ds; n unit normal.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
GAUSS = CORNERS / np.sqrt(3.0)
"""Points of the 2 x 2 rule (4, 2); the weight of each is 1."""


def shape(r: float, s: float) -> FloatArray:
    """Return the bilinear shape functions (4,)."""
    return np.asarray(0.25 * (1.0 + CORNERS[:, 0] * r) * (1.0 + CORNERS[:, 1] * s))


def slopes(r: float, s: float) -> FloatArray:
    """Return their derivatives by r and by s (2, 4)."""
    a, b = CORNERS.T
    return np.array([0.25 * a * (1.0 + b * s), 0.25 * b * (1.0 + a * r)])


def tangents(values: FloatArray, r: float, s: float) -> FloatArray:
    """Return d/dr and d/ds (n, 2, 3) of what has the `values` (n, 4, 3) at the corners."""
    return np.asarray(slopes(r, s) @ values)


def corner_normals(points: FloatArray) -> FloatArray:
    """Return the unit normals (n, 4, 3) of the surfaces at their corners (n, 4, 3)."""
    normals = np.stack([np.cross(*np.moveaxis(tangents(points, r, s), 1, 0)) for r, s in CORNERS.tolist()], axis=1)
    return np.asarray(normals / np.linalg.norm(normals, axis=2, keepdims=True))


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """Orthonormal axes at one point of each surface.

    Attributes
    ----------
    area : FloatArray
        |g_r x g_s| (n,) [m^2].
    axes : FloatArray
        Columns are the first axis, the second and the normal (n, 3, 3).
    along : FloatArray
        d(r, s) / d(first, second axis): rows are axes (n, 2, 2) [1/m].
    """

    area: FloatArray
    axes: FloatArray
    along: FloatArray

    @property
    def strains(self) -> FloatArray:
        """The matrices (n, 3, 3) that turn strains (rr, ss, 2 rs) into (xx, yy, xy) of the axes."""
        (a, b), (c, d) = np.moveaxis(self.along, 0, -1)
        rows = [[a * a, b * b, a * b], [c * c, d * d, c * d], [2.0 * a * c, 2.0 * b * d, a * d + b * c]]
        return np.moveaxis(np.array(rows), -1, 0)


def axes_in(tangents: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return |g_r x g_s| (n,) and axes (n, 3, 3) of tangents (n, 2, 3): columns are the first, the second, the normal.

    The first axis is the projection of `axis` (3,), or g_r where that is zero or normal to the surface.
    """
    normal = np.cross(tangents[:, 0], tangents[:, 1])
    area = np.linalg.norm(normal, axis=1)
    normal = normal / area[:, None]
    first = axis - normal * (normal @ axis)[:, None]
    is_seen = np.linalg.norm(first, axis=1) > 1e-10 * float(np.linalg.norm(axis))
    first = np.where(is_seen[:, None], first, tangents[:, 0])
    first /= np.linalg.norm(first, axis=1)[:, None]
    return area, np.stack([first, np.cross(normal, first), normal], axis=2)


def frame(points: FloatArray, r: float, s: float, axis: FloatArray) -> Frame:
    """Return the frames at a point of surfaces with corners (n, 4, 3), their axes as `axes_in`."""
    both = tangents(points, r, s)
    area, axes = axes_in(both, axis)
    across = axes[:, :, :2].swapaxes(1, 2) @ both.swapaxes(1, 2)
    return Frame(area, axes, np.asarray(across @ np.linalg.inv(both @ both.swapaxes(1, 2))))
