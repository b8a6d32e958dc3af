"""Patch tests, rigid motions and turns in space: what any shell element must pass."""

import numpy as np
import pytest

from femlib.arrays import FloatArray
from femlib.assembly import Supports, factorise
from femlib.elements import quad4
from femlib.material import Ply, isotropic_plate, laminate
from femlib.mesh import dofs_of_nodes
from femlib.sensors import middle_operators
from tests.test_femlib.plates import DISTORTED, patch, rotation

PLATE = isotropic_plate(70e9, 0.3, 5e-3, density=2700.0)
CROSSED = laminate([Ply(140e9, 10e9, 0.3, 5e9, 5e9, 3e9, 1e-3, a, 1600.0) for a in (0.3, 1.2, -0.5)])
SHAPES = ["quad4", "tria3"]


def imposed(membrane: FloatArray, curvature: FloatArray) -> FloatArray:
    """Displacements (8, 6) of constant membrane strains and curvatures (xx, yy, xy) without transverse shear."""
    x, y = DISTORTED.T
    exx, eyy, gxy = membrane
    kxx, kyy, kxy = curvature
    w = -0.5 * (kxx * x**2 + kyy * y**2 + kxy * x * y)
    slope_x, slope_y = -(kxx * x + 0.5 * kxy * y), -(kyy * y + 0.5 * kxy * x)
    zero = np.zeros_like(x)
    return np.stack([exx * x + 0.5 * gxy * y, eyy * y + 0.5 * gxy * x, w, slope_y, -slope_x, zero], axis=1)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("state", ["membrane", "bending"])
def test_a_distorted_patch_holds_a_constant_strain_exactly(shape: str, state: str) -> None:
    strain = 1e-3 * np.array([1.0, -0.4, 0.7])
    zero = np.zeros(3)
    exact = imposed(strain, zero) if state == "membrane" else imposed(zero, strain)
    shells = patch(PLATE, shape)
    held = dofs_of_nodes(np.arange(4)).ravel()
    supports = Supports.holding(shells.mesh, held)
    matrix = shells.stiffness()
    right = -(matrix[supports.free][:, held] @ exact[:4].ravel())
    free = factorise(supports.reduce(matrix), supports.groups).solve(right)
    inner = free.reshape(4, 6)
    assert np.abs(inner - exact[4:]).max() < 1e-9 * np.abs(exact).max()
    for element, operator in middle_operators(shells.mesh, np.arange(shells.mesh.n_elements)).items():
        local = operator.membrane if state == "membrane" else operator.curvature
        c, s = operator.axes[0, 0], operator.axes[1, 0]
        turn = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
        got = local @ exact[shells.mesh.corners_of(element)].ravel()
        assert got == pytest.approx(turn @ strain, abs=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("stack", [PLATE, CROSSED])
def test_a_free_patch_has_six_rigid_motions_and_no_other_mode_without_energy(shape: str, stack: object) -> None:
    shells = patch(stack, shape, rotation(3))
    values = np.linalg.eigvalsh(shells.stiffness().toarray())
    assert np.abs(values[:6]).max() < 1e-10 * values[-1]
    assert values[6] > 1e-9 * values[-1]


@pytest.mark.parametrize("shape", SHAPES)
def test_the_mass_matrix_carries_the_mass_of_the_plate(shape: str) -> None:
    shells = patch(PLATE, shape)
    moved = np.zeros((8, 6))
    moved[:, 1] = 1.0
    assert moved.ravel() @ shells.mass() @ moved.ravel() == pytest.approx(PLATE.mass * 0.5, rel=1e-12)


def test_a_rigid_motion_of_a_warped_element_has_no_force_and_no_strain() -> None:
    rng = np.random.default_rng(8)
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) + rng.uniform(-0.3, 0.3, (20, 4, 3))
    spin = np.array([0.3, -0.2, 0.5])
    moved = np.concatenate([np.array([1.0, 2.0, 3.0]) + np.cross(spin, corners), np.tile(spin, (20, 4, 1))], axis=2)
    flat = moved.reshape(20, 24)
    matrices = quad4.stiffness(corners, (CROSSED,), np.zeros(20, dtype=np.int64), np.array([1.0, 0.2, 0.0]))
    assert np.abs(np.einsum("eij,ej->ei", matrices, flat)).max() < 1e-12 * np.abs(matrices).max()
    operator = quad4.strain_operators(corners, [(0.0, 0.0), (0.5, -0.7)])
    assert np.abs(np.einsum("epci,ei->epc", operator.membrane, flat)).max() < 1e-12
    assert np.abs(np.einsum("epci,ei->epc", operator.curvature, flat)).max() < 1e-11
    values = np.linalg.eigvalsh(matrices)
    assert (np.abs(values[:, :6]).max(axis=1) < 1e-10 * values[:, -1]).all()
    assert (values[:, 6] > 1e-8 * values[:, -1]).all()
