"""Loads of the wing: resultants, moments, relief by masses, the vortex lattice against ellipse and lifting line."""

import numpy as np
import pytest

from femlib.arrays import FloatArray
from femlib.wing import Wing, bend, inertial_load, vortex_lattice
from femlib.wing.loads import EFFECTIVE_MASS, GRAVITY

HALF_WEIGHT = 0.5 * EFFECTIVE_MASS * GRAVITY


def moments(wing: Wing, forces: FloatArray, stations: FloatArray) -> FloatArray:
    """Bending moment of vertical forces outboard of each span fraction, about it [N m]."""
    y, up = wing.structure.shells.mesh.nodes[:, 1], forces.reshape(-1, 6)[:, 2]
    return np.array([np.maximum(y - eta * wing.span, 0.0) @ up for eta in stations])


def glauert(wing: Wing, stations: FloatArray, n: int = 60) -> FloatArray:
    """Bending moment over half lift and half-span of the planform by lifting-line theory, without camber.

    Source: H. Glauert, The Elements of Aerofoil and Airscrew Theory (1926), chapter 11.
    """
    theta = (np.arange(n) + 0.5) * np.pi / (2 * n)
    k = 2 * np.arange(n) + 1
    chord = wing.planform.chord(np.cos(theta))
    mu = 2.0 * np.pi * chord / (8.0 * wing.span)
    series = np.sin(np.outer(theta, k)) * (np.outer(mu, k) + np.sin(theta)[:, None])
    coefficients = np.linalg.solve(series, mu * np.sin(theta))
    eta = np.linspace(0.0, 1.0, 4001)
    local = np.sin(np.outer(np.arccos(eta), k)) @ coefficients
    return np.array([np.trapezoid(local * np.maximum(eta - s, 0.0), eta) for s in stations]) / np.trapezoid(local, eta)


def test_the_inertia_of_the_wing_is_its_mass_times_gravity_and_relieves_the_root(tiny: Wing) -> None:
    load = inertial_load(tiny)
    mass = tiny.structure.shells.mass()
    unit = np.zeros(len(load))
    unit[2::6] = 1.0
    weight = GRAVITY * float(unit @ mass @ unit)
    assert -load[2::6].sum() == pytest.approx(weight)
    assert weight == pytest.approx(2.145 * GRAVITY, rel=0.005)
    payload = inertial_load(tiny, {0.5: 0.17, 0.777: 0.13}) - load
    assert -payload[2::6].sum() == pytest.approx(0.30 * GRAVITY)
    relief = moments(tiny, payload, np.zeros(1))[0]
    assert relief == pytest.approx(-GRAVITY * tiny.span * (0.5 * 0.17 + 0.777 * 0.13), rel=1e-9)
    # the root's strain falls as its bending moment does, within what chordwise places and taper leave
    root = moments(tiny, load, np.zeros(1))[0] / moments(tiny, tiny.lift, np.zeros(1))[0]
    change = tiny.strain_microstrain({}, 3.0, tiny.lift + load) / tiny.strain_microstrain({}, 3.0) - 1.0
    assert -0.2 < root < -0.05
    assert change[0] == pytest.approx(root, abs=0.02)


class TestVortexLattice:
    """Needs AeroSandbox: pip install 'octmip[aero]'."""

    @pytest.fixture(autouse=True)
    def _installed(self) -> None:
        pytest.importorskip("aerosandbox", reason="AeroSandbox is not installed: pip install 'octmip[aero]'")

    @pytest.mark.parametrize("load_factor", [-1.0, 0.0, 2.5, 4.0])
    def test_the_resultant_is_the_weight_times_the_load_factor(self, tiny: Wing, load_factor: float) -> None:
        found = vortex_lattice(tiny, load_factor)
        x, y, z = found.forces.reshape(-1, 6)[:, :3].sum(axis=0)
        a = found.angle_of_attack
        assert z * np.cos(a) - x * np.sin(a) == pytest.approx(load_factor * HALF_WEIGHT, abs=1e-6 * HALF_WEIGHT)
        assert abs(y) < 0.02 * (1.0 + abs(load_factor)) * HALF_WEIGHT
        assert not found.forces.reshape(-1, 6)[:, 3:].any()

    def test_its_moments_are_those_of_lifting_line_theory_and_above_the_ellipse(self, tiny: Wing) -> None:
        stations = np.array([0.0, 0.25, 0.5, 0.75])
        difference = vortex_lattice(tiny, 3.0).forces - vortex_lattice(tiny, 0.0).forces  # without the camber's part
        total = difference[2::6].sum() * tiny.span
        found = moments(tiny, difference, stations) / total
        assert found == pytest.approx(glauert(tiny, stations), rel=0.05)  # no chord of its own in the theory
        ellipse = moments(tiny, tiny.lift, stations) / (HALF_WEIGHT * tiny.span)
        ratio = found / ellipse
        assert (np.diff(ratio) > 0).all()
        assert 1.0 < ratio[0] < 1.1
        assert 1.1 < ratio[3] < 1.35

    def test_the_wing_takes_it_linear_and_bent(self, tiny: Wing) -> None:
        forces = vortex_lattice(tiny, 3.0).forces + 3.0 * inertial_load(tiny)
        linear = tiny.strain_microstrain({"mu1": 0.2}, 1.0, forces)
        bent = bend(tiny, {"mu1": 0.2}, 1.0, lift=forces)
        assert bent.strain_microstrain[:16] == pytest.approx(linear[:16], rel=0.03)
        assert (linear > 0).all()
