"""Strains at the middles of many elements of one shape at once."""

from femlib.arrays import FloatArray
from femlib.elements import quad4, tria3
from femlib.elements.frame import StrainOperator


def middles(points: FloatArray) -> StrainOperator:
    """Return the strain rows at the middles of elements (n, 4, 3) or (n, 3, 3), all arrays with a leading axis."""
    if points.shape[1] == quad4.N_NODES:
        many = quad4.strain_operators(points, [(0.0, 0.0)])
    else:
        many = tria3.strain_operators(points, tria3.MIDDLE)
    return StrainOperator(many.membrane[:, 0], many.curvature[:, 0], many.axes[:, 0])
