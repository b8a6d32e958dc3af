"""Buckling of plates beside closed forms, and of the wing."""

import numpy as np
import pytest

from femlib.arrays import FloatArray
from femlib.assembly import Shells, Supports, buckling_modes, geometric_stiffness, matrix_buckling
from femlib.material import isotropic_plate
from femlib.mesh import Mesh
from femlib.rom.buckling import ReducedBuckling
from femlib.wing import Wing, buckle, vibrate
from tests.test_femlib.plates import grid_mesh

YOUNG, POISSON, THICKNESS = 70e9, 0.3, 0.002
RIGIDITY = YOUNG * THICKNESS**3 / 12.0 / (1.0 - POISSON**2)


def plate(n: int, triangles: bool) -> tuple[Shells, Supports]:
    """Return a square plate of side 1 m, held across its plane along its edges, with n elements a side."""
    lines = np.linspace(0.0, 1.0, n + 1)
    mesh = grid_mesh(lines, lines)
    if triangles:
        corners = np.concatenate([mesh.quads[:, [0, 1, 2]], mesh.quads[:, [0, 2, 3]]])
        nothing = np.zeros((0, 4), dtype=np.int64)
        mesh = Mesh(mesh.nodes, nothing, corners, ("plate",), np.zeros(len(corners), dtype=np.int64))
    count = mesh.n_elements
    section = isotropic_plate(YOUNG, POISSON, THICKNESS)
    shells = Shells(mesh, (section,), np.zeros(count, dtype=np.int64), np.ones(count), np.array([1.0, 0.0, 0.0]))
    x, y = mesh.nodes[:, :2].T
    edge = np.flatnonzero((x == 0.0) | (x == 1.0) | (y == 0.0) | (y == 1.0))
    first, last = int(np.flatnonzero((x == 0.0) & (y == 0.0))[0]), int(np.flatnonzero((x == 1.0) & (y == 0.0))[0])
    return shells, Supports.holding(mesh, [*(6 * edge + 2), 6 * first, 6 * first + 1, 6 * last + 1])


def edge_forces(mesh: Mesh, xx: float, xy: float) -> FloatArray:
    """Return the nodal forces (n_dofs,) of a uniform stress on the edges of the plate [N/m]."""
    forces = np.zeros((len(mesh.nodes), 6))
    for axis, across, end in ((0, 1, 0.0), (0, 1, 1.0), (1, 0, 0.0), (1, 0, 1.0)):
        nodes = np.flatnonzero(mesh.nodes[:, axis] == end)
        step = 1.0 / (len(nodes) - 1)
        inside = (mesh.nodes[nodes, across] > 0.0) & (mesh.nodes[nodes, across] < 1.0)
        share = np.where(inside, step, 0.5 * step) * (1.0 if end else -1.0)
        stress = (xx, xy) if axis == 0 else (xy, 0.0)
        forces[nodes, 0] += share * stress[0]
        forces[nodes, 1] += share * stress[1]
    return forces.ravel()


def coefficients(n: int, xx: float, xy: float, triangles: bool = False) -> list[float]:
    """Return N b^2 / (pi^2 D) of the first modes."""
    shells, supports = plate(n, triangles)
    modes = buckling_modes(shells, supports, edge_forces(shells.mesh, xx, xy), 2, limit=1.0, is_refined=False)
    return [mode.factor / (np.pi**2 * RIGIDITY) for mode in modes]


@pytest.mark.parametrize(
    ("n", "xx", "xy", "triangles", "exact", "within"),
    [
        (12, -1.0, 0.0, False, [4.0, 6.25], 0.011),
        (12, 0.0, 1.0, False, [9.325, 11.55], 0.016),
        (24, -1.0, 0.0, True, [4.0, 6.25], 0.02),
        (24, 0.0, 1.0, True, [9.325, 11.55], 0.02),
    ],
)
def test_a_square_plate_buckles_at_timoshenkos_load(
    n: int, xx: float, xy: float, triangles: bool, exact: list[float], within: float
) -> None:
    np.testing.assert_allclose(coefficients(n, xx, xy, triangles), exact, rtol=within)


def test_a_plate_that_is_pulled_does_not_buckle() -> None:
    shells, supports = plate(6, triangles=False)
    moved = np.zeros((len(shells.mesh.nodes), 6))
    moved[:, :2] = 1e-4 * shells.mesh.nodes[:, :2]
    stretched = geometric_stiffness(shells, moved.ravel())
    assert matrix_buckling(shells.stiffness(), stretched, supports) == []
    assert buckling_modes(shells, supports, edge_forces(shells.mesh, 0.0, 0.0)) == []
    # a translation does no work on a stress in equilibrium with itself
    np.testing.assert_allclose(stretched @ np.tile([1.0, 2.0, 3.0, 0.0, 0.0, 0.0], len(moved)), 0.0, atol=1e-6)


@pytest.mark.parametrize(("n", "sign", "factor"), [(0, 1.0, np.inf), (1, 1.0, np.inf), (1, -1.0, 0.5)])
def test_reduced_equations_that_nothing_presses_have_no_factor(n: int, sign: float, factor: float) -> None:
    reduced = ReducedBuckling(np.zeros((1, n, n)), sign * np.full((1, n, n), 2.0), np.array([[[1.0]], [[0.0]]])[:, :n])
    assert reduced.factor(np.zeros(1), np.ones(1)) == factor


@pytest.mark.parametrize(("n", "triangles"), [(12, False), (24, True)])
def test_a_warm_plate_buckles_at_its_critical_temperature(n: int, triangles: bool) -> None:
    """N = E alpha T t / (1 - nu) both ways is 2 pi^2 D / b^2 there.

    Source: S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells (1959), section 92 (in-plane forces).
    """
    shells, supports = plate(n, triangles)
    own, edge = isotropic_plate(YOUNG, POISSON, THICKNESS, expansion=23e-6), shells.mesh.nodes[:, :2] % 1.0 == 0.0
    shells = Shells(shells.mesh, (own,), shells.section, shells.scale, shells.axis)
    nodes = np.flatnonzero(edge.any(axis=1))
    supports = Supports.holding(shells.mesh, np.concatenate([6 * nodes + k for k in range(3)]))
    warmth = np.tile([1.0, 0.0], (shells.mesh.n_elements, 1))
    nothing = np.zeros(shells.mesh.n_dofs)
    (mode,) = buckling_modes(shells, supports, nothing, limit=1.0, is_refined=False, warmth=warmth)
    critical = np.pi**2 * THICKNESS**2 / (6.0 * 23e-6 * (1.0 + POISSON))
    assert mode.factor == pytest.approx(critical, rel=0.011)
    half = np.full(shells.mesh.n_elements, 0.5)  # pushes half as much
    (softer,) = buckling_modes(shells, supports, nothing, 1, half, 1.0, is_refined=False, warmth=warmth)
    assert softer.factor == pytest.approx(mode.factor, rel=1e-6)


def test_half_the_stiffness_buckles_at_half_the_load() -> None:
    shells, supports = plate(6, triangles=False)
    half = np.full(shells.mesh.n_elements, 0.5)
    load = edge_forces(shells.mesh, -1.0, 0.0)
    factors = [buckling_modes(shells, supports, load, factor=own)[0].factor for own in (None, half)]
    assert factors[1] == pytest.approx(0.5 * factors[0], rel=1e-8)


def test_the_wing_buckles_and_vibrates_with_its_damage_load_and_masses(tiny: Wing) -> None:
    sound, damaged = (buckle(tiny, state, limit=9.0)[0] for state in ({}, {"mu1": 0.95}))
    assert 0.0 < damaged.factor != pytest.approx(sound.factor, rel=1e-3)
    assert np.abs(sound.shape.reshape(-1, 6)[:, :3]).max() == 1.0
    twice = buckle(tiny, {}, lift=2.0 * tiny.lift, limit=9.0)[0]
    assert twice.factor == pytest.approx(0.5 * sound.factor, rel=1e-6)
    first, softer, heavier = (
        vibrate(tiny, state, 1, payload)[0].frequency
        for state, payload in (({}, None), ({"mu1": 0.8}, None), ({}, {0.9: 0.1}))
    )
    assert softer < first
    assert heavier < first
