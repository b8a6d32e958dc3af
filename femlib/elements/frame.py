"""Parts of both elements: the laminate as the element library takes it, and strain rows in global axes."""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import needed_by
from femlib.material import Laminate

if TYPE_CHECKING:
    from pyfe3d import Quad4, Tria3DSG
    from pyfe3d.shellprop import ShellProp


@cache
def element_library() -> Any:
    """Return pyfe3d, imported with the first element: reading a data set or a reduced model needs none.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    with needed_by("a shell element"):
        import_module("pyfe3d.shellprop")
        return import_module("pyfe3d")


@dataclass(frozen=True, slots=True, eq=False)
class StrainOperator:
    """Linear map from an element's global displacements to its strains at one point.

    Attributes
    ----------
    membrane, curvature : FloatArray
        Rows (3, n_dofs) of (xx, yy, xy) in the element's axes [-] and [1/m]; at height z strain = membrane + z
        curvature.
    axes : FloatArray
        Columns are the element's x, y and normal in global axes (3, 3).
    """

    membrane: FloatArray
    curvature: FloatArray
    axes: FloatArray


def shell_property(laminate: Laminate, with_shear: bool = True) -> "ShellProp":
    """Return the laminate in the element library's own form, transverse shear left at zero if so asked."""
    prop = element_library().shellprop.ShellProp()
    prop.h = laminate.thickness
    for letter, matrix in (("A", laminate.membrane), ("B", laminate.coupling), ("D", laminate.bending)):
        for i, j, suffix in ((0, 0, "11"), (0, 1, "12"), (0, 2, "16"), (1, 1, "22"), (1, 2, "26"), (2, 2, "66")):
            setattr(prop, letter + suffix, float(matrix[i, j]))
    if with_shear:
        prop.A44, prop.A45, prop.A55 = (float(laminate.shear[i, j]) for i, j in ((0, 0), (0, 1), (1, 1)))
    prop.intrho, prop.intrhoz, prop.intrhoz2 = laminate.mass, laminate.mass_moment, laminate.rotary_inertia
    return prop


def element_axes(element: "Quad4 | Tria3DSG") -> FloatArray:
    """Return the rotation (3, 3) whose columns are the element's axes."""
    return np.array([[getattr(element, f"r{i}{j}") for j in (1, 2, 3)] for i in (1, 2, 3)])


def align(element: "Quad4 | Tria3DSG", axis: FloatArray) -> None:
    """Let the laminate's axis be the projection of `axis` (3,), or the element's x if `axis` is zero or normal.

    The library's own computation takes the root of 1 - cos^2, which rounding makes negative where the axes coincide: it
    then fails or fills the stiffness with NaN.
    """
    along_x, along_y, _ = element_axes(element).T @ axis
    length = float(np.hypot(along_x, along_y))
    if length > 1e-10 * float(np.linalg.norm(axis)):
        element.m11 = element.m22 = along_x / length
        element.m21 = along_y / length
        element.m12 = -element.m21


def resultant_turn(axes: FloatArray, axis: FloatArray) -> FloatArray:
    """Return the matrices (..., 3, 3) that lead forces or moments (xx, yy, xy) from laminates' to elements' axes.

    `axes` (..., 3, 3) are the elements', `axis` (3,) the laminates' direction as in `align`.
    """
    along_x, along_y = axes[..., :, 0] @ axis, axes[..., :, 1] @ axis
    length = np.hypot(along_x, along_y)
    is_seen = length > 1e-10 * float(np.linalg.norm(axis))
    safe = np.where(is_seen, length, 1.0)
    c, s = np.where(is_seen, along_x / safe, 1.0), np.where(is_seen, along_y / safe, 0.0)
    rows = [[c * c, s * s, -2 * c * s], [s * s, c * c, 2 * c * s], [c * s, -c * s, c * c - s * s]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def to_global(rows: FloatArray, axes: FloatArray) -> FloatArray:
    """Turn rows (k, 6 n) that act on element displacements into rows on global displacements."""
    blocks = rows.reshape(len(rows), -1, 3)
    return np.asarray((blocks @ axes.T).reshape(rows.shape))
