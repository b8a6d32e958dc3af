"""A gauge reads the exact strain where the field is linear, along any direction and on any side."""

import numpy as np
import pytest

from femlib.material import isotropic_plate
from femlib.sensors import StrainGauge, strain_rows
from tests.test_femlib.plates import grid_mesh, patch

THICKNESS = 2e-3


def test_a_linear_strain_field_is_read_exactly() -> None:
    mesh = grid_mesh(np.array([0.0, 0.1, 0.25, 0.4]), np.array([0.0, 0.15, 0.2, 0.4]))
    gauge = StrainGauge("s", np.array([0.17, 0.17, 0.0]), np.array([1.0, 0.0, 0.0]), ("plate",))
    x, y, _ = mesh.nodes.T
    u = np.zeros((len(x), 6))
    u[:, 0] = x + 2 * x * y  # exx = 1 + 2 y, bilinear: the elements hold it exactly
    row = strain_rows(mesh, np.full(mesh.n_elements, THICKNESS), [gauge])
    assert (row @ u.ravel())[0] == pytest.approx(1 + 2 * 0.17, rel=1e-12)


@pytest.mark.parametrize(("angle", "side"), [(0.0, 1.0), (0.7, -1.0), (2.0, 0.3)])
def test_a_gauge_on_triangles_reads_membrane_and_bending_at_any_angle_and_side(angle: float, side: float) -> None:
    shells = patch(isotropic_plate(70e9, 0.3, THICKNESS), "tria3")
    strain, curvature = np.array([[1.0, 0.3], [0.3, -0.4]]), np.array([[0.5, 0.2], [0.2, -0.1]])
    x = shells.mesh.nodes[:, :2]
    u = np.zeros((len(x), 6))
    u[:, :2] = x @ strain
    u[:, 2] = -0.5 * np.einsum("ni,ij,nj->n", x, curvature, x)
    u[:, 3], u[:, 4] = -x @ curvature[1], x @ curvature[0]
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    here = StrainGauge("s", np.array([0.52, 0.21, 0.0]), along, ("plate",), side)
    row = strain_rows(shells.mesh, np.full(shells.mesh.n_elements, THICKNESS), [here])
    exact = along[:2] @ (strain + side * THICKNESS / 2.0 * curvature) @ along[:2]
    assert (row @ u.ravel())[0] == pytest.approx(exact, rel=1e-10)
