"""Consistent loads, free thermal expansion, and natural frequencies of beams and plates."""

import numpy as np
import pytest

from benchmarks.shells.case import hold, mapped
from femlib.assembly import (
    Supports,
    factorise,
    line_load,
    natural_modes,
    thermal_load,
)
from femlib.material import isotropic_plate
from femlib.mesh import dofs_of_nodes
from tests.test_femlib.plates import patch, rotation

STEEL = isotropic_plate(210e9, 0.3, 4e-3, density=7850.0, expansion=12e-6)


def test_a_line_load_is_shared_by_length() -> None:
    shells, node = mapped(lambda u, v: np.stack([u**2, v, 0 * u], axis=-1), 2, 1, STEEL)
    forces = line_load(shells.mesh, node[:, 0], np.array([0.0, 0.0, 8.0])).reshape(-1, 6)
    assert forces[node[:, 0], 2] == pytest.approx([1.0, 4.0, 3.0])


@pytest.mark.parametrize("shape", ["quad4", "tria3"])
@pytest.mark.parametrize("kind", ["warming", "gradient"])
def test_free_thermal_expansion_has_no_mechanical_strain(shape: str, kind: str) -> None:
    turn = rotation(4)
    stack = STEEL
    shells = patch(stack, shape, turn)
    mesh = shells.mesh
    n = mesh.n_elements
    rise, slope = (30.0, 0.0) if kind == "warming" else (0.0, 1000.0)
    load = thermal_load(shells, np.full(n, rise), np.full(n, slope))
    x, y, _ = (mesh.nodes @ turn).T  # in the plate's own axes
    flat = np.zeros((len(x), 6))
    if kind == "warming":
        flat[:, 0], flat[:, 1] = 12e-6 * rise * x, 12e-6 * rise * y
    else:
        flat[:, 2] = -0.5 * 12e-6 * slope * (x**2 + y**2)
        flat[:, 3], flat[:, 4] = -12e-6 * slope * y, 12e-6 * slope * x
    moved = np.concatenate([flat[:, :3] @ turn.T, flat[:, 3:] @ turn.T], axis=1).ravel()
    supports = Supports.holding(mesh, dofs_of_nodes([0]).ravel())
    solution = supports.expand(
        factorise(supports.reduce(shells.stiffness()), supports.groups).solve(load[supports.free])
    )
    assert np.abs(shells.stiffness() @ moved - load).max() < 1e-9 * np.abs(load).max()
    assert np.abs(solution - moved).max() < 1e-9 * np.abs(moved).max()  # node 0 lies at the origin


def test_a_cantilever_has_the_frequencies_of_beam_theory() -> None:
    strip = isotropic_plate(70e9, 0.0, 5e-3, 2700.0)
    shells, node = mapped(lambda u, v: np.stack([u, 0.04 * v, 0 * u], axis=-1), 40, 2, strip)
    supports = Supports.clamping(shells.mesh, node[0])
    modes = natural_modes(shells, supports, 4)
    del modes[2]  # in-plane bending, between the second and the third of these
    root = np.sqrt(70e9 * 5e-3**2 / 12.0 / 2700.0) / (2.0 * np.pi)
    exact = np.array([1.8751041, 4.6940911, 7.8547574]) ** 2 * root
    assert [mode.frequency for mode in modes] == pytest.approx(exact, rel=5e-3)
    assert modes[0].shape @ shells.mass() @ modes[0].shape == pytest.approx(1.0)


def test_a_simply_supported_plate_has_the_frequency_of_its_series() -> None:
    shells, node = mapped(lambda u, v: np.stack([u, v, 0 * u], axis=-1), 16, 16, STEEL)
    edge = np.unique(np.concatenate([node[0], node[-1], node[:, 0], node[:, -1]]))
    supports = Supports.holding(shells.mesh, np.concatenate([hold(edge, "w"), hold(node, "uvz")]))
    frequency = natural_modes(shells, supports, 1)[0].frequency
    rigidity = 210e9 * 4e-3**3 / 12.0 / 0.91
    assert frequency == pytest.approx(np.pi * np.sqrt(rigidity / (7850.0 * 4e-3)), rel=0.01)
