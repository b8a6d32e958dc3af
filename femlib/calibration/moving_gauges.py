"""Strain gauges whose places depend on parameters.

A gauge reads weighted means of the strains at elements' middles (`femlib.sensors`). Only the weights change with its
place, so each element's row is made once, and the derivative by a parameter is a central difference of the weights.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.calibration.varying import Varying, VaryingRows
from femlib.errors import InputError
from femlib.kept import Kept
from femlib.mesh import Mesh, dofs_of_nodes
from femlib.sensors import StrainGauge, element_weights, point_strain_row

STEP = 2e-4
"""Half step of the central difference [m]; strain rows are linear between the elements' nodes."""


@dataclass(frozen=True, slots=True, eq=False)
class MovingGauges:
    """Gauges of one direction on one surface.

    Attributes
    ----------
    mesh : Mesh
        The shells.
    thickness : FloatArray
        Thickness of each element (n_elements,) [m].
    direction : FloatArray
        Measuring direction (3,).
    patches : tuple of str
        Patches of the surface.
    side : float
        Height over half the thickness.
    unit : float
        Factor on the strain: -1e6 gives compressive microstrain.
    """

    mesh: Mesh
    thickness: FloatArray
    direction: FloatArray
    patches: tuple[str, ...]
    side: float = 1.0
    unit: float = 1.0
    _rows: Kept[int, FloatArray] = field(init=False, repr=False, default_factory=Kept)

    def at(self, places: Varying) -> VaryingRows:
        """Return the rows (n_gauges, n_dofs) of gauges at points (n_gauges, 3) [m] on the surface.

        Raises
        ------
        InputError
            If a point lies outside the patches or off the surface.
        """
        points = np.asarray(places.value)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"gauge places have shape {points.shape}; expected ('n', 3); give x, y and z of each [m]")
        slopes = {name: self._slope(points, slope) for name, slope in places.slopes.items()}
        return VaryingRows(self._at(points), slopes)

    def _slope(self, points: FloatArray, motion: FloatArray) -> sparse.csr_array:
        """Return the derivative of the rows where gauges move by `motion` (n_gauges, 3) per unit of a parameter."""
        size = np.linalg.norm(motion, axis=1)
        moves = np.flatnonzero(size > 0.0)
        step = STEP * motion[moves] / size[moves, None]
        change = self._at(points[moves] + step) - self._at(points[moves] - step)
        spread = sparse.csr_array(
            (size[moves] / (2.0 * STEP), (moves, np.arange(len(moves)))), (len(points), len(moves))
        )
        return sparse.csr_array(spread @ change)

    def _at(self, points: FloatArray) -> sparse.csr_array:
        gauges = [StrainGauge(f"{k}", p, self.direction, self.patches, self.side) for k, p in enumerate(points)]
        rows, columns, values = [], [], []
        for number, weights in enumerate(element_weights(self.mesh, gauges)):
            for element, weight in weights.items():
                row = self._row_of(element)
                rows.append(np.full(len(row), number))
                columns.append(dofs_of_nodes(self.mesh.corners_of(element)).ravel())
                values.append(self.unit * weight * row)
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sparse.csr_array(sparse.coo_array(entries, shape=(len(points), self.mesh.n_dofs)))

    def _row_of(self, element: int) -> FloatArray:
        height = self.side * self.thickness[element] / 2.0
        corners = self.mesh.nodes[self.mesh.corners_of(element)]
        name = f"in element {element}"
        return self._rows.get(element, lambda: point_strain_row(corners, 0.0, 0.0, self.direction, height, name))
