"""Laminates against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from femlib.material import Ply, isotropic_plate, laminate


def turned(angle: float) -> Ply:
    return Ply(140e9, 10e9, 0.3, 5e9, 5e9, 3e9, 0.125e-3, np.radians(angle), 1600.0, -0.5e-6, 30e-6)


def test_isotropic_plate_has_the_plate_stiffness_of_the_textbook() -> None:
    plate = isotropic_plate(70e9, 0.3, 2e-3, density=2700.0)
    rigidity = 70e9 * 2e-3**3 / 12.0 / (1.0 - 0.3**2)
    assert plate.bending[0, 0] == pytest.approx(rigidity, rel=1e-14)
    assert plate.bending[0, 1] == pytest.approx(0.3 * rigidity, rel=1e-14)
    assert plate.membrane[2, 2] == pytest.approx(70e9 / 2.6 * 2e-3, rel=1e-14)
    assert plate.mass == pytest.approx(5.4)
    assert plate.rotary_inertia == pytest.approx(2700 * 2e-3**3 / 12)
    assert not plate.coupling.any()


def test_symmetric_laminate_has_no_coupling_and_quasi_isotropic_has_isotropic_membrane() -> None:
    stack = laminate([turned(a) for a in (0, 45, -45, 90, 90, -45, 45, 0)])
    assert np.abs(stack.coupling).max() < 1e-9 * np.abs(stack.membrane).max() * stack.thickness
    a = stack.membrane
    assert a[0, 0] == pytest.approx(a[1, 1])
    assert a[2, 2] == pytest.approx(0.5 * (a[0, 0] - a[0, 1]))
    assert np.abs(stack.thermal_moment).max() < 1e-9


def test_shear_is_that_of_the_stresses_in_equilibrium() -> None:
    ply = Ply(25e9, 1e9, 0.25, 0.5e9, 0.5e9, 0.2e9, 1e-3, 0.4)
    assert laminate([ply] * 4).shear == pytest.approx(5.0 / 6.0 * 4e-3 * ply.transverse_shear(), rel=1e-12)
    straight, across = replace(ply, angle=0.0), replace(ply, angle=0.5 * np.pi)
    crossed = laminate([straight, across, across, straight])
    # Whitney's factors of this stack (J. Applied Mechanics 40, 1973) on the mean moduli .35 GPa
    assert np.diag(crossed.shear) / (4e-3 * 0.35e9) == pytest.approx([0.7203, 0.5952], abs=1e-4)
    uneven = [straight, replace(ply, angle=0.7, thickness=3e-3), across]
    assert laminate(uneven).shear == pytest.approx(laminate(uneven[::-1]).shear, rel=1e-9)
    core = Ply(1e6, 1e6, 0.0, 0.5e6, 0.5e6, 0.5e6, 20e-3)
    sandwich = laminate([straight, core, straight]).shear[1, 1]
    assert sandwich == pytest.approx(0.5e6 * 21e-3**2 / 20e-3, rel=0.02)  # G d^2 / c
