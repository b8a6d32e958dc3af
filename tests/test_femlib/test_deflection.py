"""Large deflection: exact tangents, turns without strain, the elastica, a rolled-up strip, a stretched plate strip."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from benchmarks.shells.case import hold, mapped
from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Shells, Supports, deflect, line_load, surface_load
from femlib.elements import corotational
from femlib.elements.rotations import exp_rotation
from femlib.errors import SolveError
from femlib.material import isotropic_plate
from tests.test_femlib.plates import patch

PUBLISHED = {0.25: (0.563, 3.015), 0.5: (1.604, 4.933), 0.75: (2.541, 6.031), 1.0: (3.286, 6.698)}
"""Shortening and deflection of the cantilever's tip by load fraction. Source: K. Y. Sze, X. H. Liu, S. H. Lo, Finite
Elements in Analysis and Design 40 (2004) 1551-1569, table 1."""


def strip(n: int) -> tuple[Shells, Supports, IntArray]:
    """The published cantilever: 10 x 1 x 0.1, E = 1.2e6, nu = 0."""
    shells, node = mapped(
        lambda u, v: np.stack([10 * u, v - 0.5, 0 * u], axis=-1), n, 1, isotropic_plate(1.2e6, 0.0, 0.1)
    )
    return shells, Supports.clamping(shells.mesh, node[0]), node


def elastica(load: float) -> tuple[float, float]:
    """Shortening and deflection of a tip under a dead load [EI / L^2], L = 1: theta'' = -load cos theta."""
    s = np.linspace(0.0, 1.0, 200)

    def slope(s: FloatArray, y: FloatArray) -> FloatArray:
        return np.stack([y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    def ends(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.array([a[0], b[1], a[2], a[3]])

    start = np.stack([0.5 * load * s, 0.5 * load * (1 - s), s, 0.3 * s])
    found = solve_bvp(slope, ends, s, start, tol=1e-8)
    return 1.0 - float(found.y[2, -1]), float(found.y[3, -1])


def test_a_cantilever_follows_its_published_curve_and_the_elastica() -> None:
    shells, supports, node = strip(16)
    load = line_load(shells.mesh, node[-1], np.array([0.0, 0.0, 4.0]))
    for found in deflect(shells, supports, load, tuple(PUBLISHED)):
        tip = found.displacement[node[-1]].mean(axis=0)
        assert (-tip[0], tip[2]) == pytest.approx(PUBLISHED[found.fraction], abs=2e-3)
        exact = 10.0 * np.array(elastica(4.0 * found.fraction))
        assert np.array([-tip[0], tip[2]]) == pytest.approx(exact, abs=4e-3)
        assert found.residual < 1e-8
        assert found.n_iterations < 15


def test_a_plate_strip_between_hinges_carries_its_load_by_stretching() -> None:
    """Cylindrical bending: w = q / (S k^2) (cosh k x / cosh k - 1) + q (1 - x^2) / (2 S), half-width 1, S = D k^2, and
    the middle surface must be longer by S (1 - nu^2) / (E h).

    Source: S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells (1959), chapter 1.
    """
    young, nu, h, q = 70e9, 0.3, 5e-3, 2e4
    rigidity = young * h**3 / 12.0 / (1.0 - nu**2)
    x = np.linspace(0.0, 1.0, 4001)

    def stretch(k: float) -> float:
        pull = rigidity * k**2
        slope = q / pull * (np.sinh(k * x) / (k * np.cosh(k)) - x)
        return float(np.trapezoid(0.5 * slope**2, x)) - pull * (1.0 - nu**2) / (young * h)

    k = brentq(stretch, 0.1, 200.0)
    pull = rigidity * k**2
    exact = q / pull * (0.5 + (1.0 / np.cosh(k) - 1.0) / k**2)
    linear = 5.0 * q * 2.0**4 / (384.0 * rigidity)
    assert exact < 0.1 * linear  # deep in the range where only stretching carries
    shells, node = mapped(lambda u, v: np.stack([u, 0.05 * v, 0 * u], axis=-1), 40, 1, isotropic_plate(young, nu, h))
    held = [hold(node[0], "uyz"), hold(node[-1], "uw"), hold(node, "vxz")]
    load = surface_load(shells.mesh, np.tile([0.0, 0.0, q], (40, 1)))
    found = deflect(shells, Supports.holding(shells.mesh, np.concatenate(held)), load, (0.1, 1.0))[-1]
    assert found.displacement[node[0], 2] == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("shape", ["quad4", "tria3"])
def test_the_tangent_is_the_derivative_of_the_forces(shape: str) -> None:
    rng = np.random.default_rng(0)
    shells = patch(isotropic_plate(70e9, 0.3, 5e-3), shape)
    kind = 0 if shape == "quad4" else 1
    corners, stiffness = (shells.mesh.quads, shells.mesh.trias)[kind], shells.element_stiffness[kind]
    points = shells.mesh.nodes[corners]
    m, n = corners.shape
    turn = exp_rotation(np.array([0.5, -0.8, 1.1]))
    moved = points @ turn.T - points + 5e-3 * rng.normal(size=points.shape)
    turned = exp_rotation(0.15 * rng.normal(size=(m, n, 3))) @ turn
    offset = 1e4 * rng.normal(size=(m, 6 * n))

    def pushed(node: int, dof: int, step: float) -> FloatArray:
        displacement, rotation = moved.copy(), turned.copy()
        if dof < 3:
            displacement[:, node, dof] += step
        else:
            rotation[:, node] = exp_rotation(step * np.eye(3)[dof - 3]) @ rotation[:, node]
        return corotational.forces(corotational.motion(points, displacement, rotation), stiffness, offset)

    columns = [(pushed(i, k, 1e-6) - pushed(i, k, -1e-6)).reshape(m, -1) / 2e-6 for i in range(n) for k in range(6)]
    measured = np.stack(columns, axis=2)
    measured = 0.5 * (measured + measured.transpose(0, 2, 1))
    tangent = corotational.tangent(corotational.motion(points, moved, turned), stiffness, offset)
    assert np.abs(tangent - measured).max() < 1e-8 * np.abs(measured).max()


@pytest.mark.parametrize("shape", ["quad4", "tria3"])
def test_a_large_rigid_motion_has_no_force(shape: str) -> None:
    shells = patch(isotropic_plate(70e9, 0.3, 5e-3), shape)
    kind = 0 if shape == "quad4" else 1
    points = shells.mesh.nodes[(shells.mesh.quads, shells.mesh.trias)[kind]]
    m, n = points.shape[:2]
    turn = exp_rotation(np.array([1.5, -0.8, 1.1]))
    motion = corotational.motion(points, points @ turn.T - points + 3.0, np.broadcast_to(turn, (m, n, 3, 3)))
    stiffness = shells.element_stiffness[kind]
    assert np.abs(corotational.forces(motion, stiffness, np.zeros((m, 6 * n)))).max() < 1e-12 * stiffness.max()


def test_a_load_beyond_the_limit_is_an_error_and_not_an_answer() -> None:
    shells, supports, node = strip(4)
    torn = line_load(shells.mesh, node[-1], np.array([-1e12, 3.0, 1e12]))
    with pytest.raises(SolveError, match="large deflection did not converge from load fraction"):
        deflect(shells, supports, torn)
