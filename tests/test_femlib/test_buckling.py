"""Buckling of plates beside closed forms, and of the wing."""

import numpy as np
import pytest

from femlib.arrays import FloatArray
from femlib.assembly import Shells, Supports, buckling_modes
from femlib.material import isotropic_plate
from femlib.mesh import Mesh
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


@pytest.mark.long
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
