"""Loads of the wing: resultants, moments, relief by masses."""

import numpy as np
import pytest

from femlib.arrays import FloatArray
from femlib.wing import Wing, inertial_load
from femlib.wing.loads import GRAVITY


def moments(wing: Wing, forces: FloatArray, stations: FloatArray) -> FloatArray:
    """Bending moment of vertical forces outboard of each span fraction, about it [N m]."""
    y, up = wing.structure.shells.mesh.nodes[:, 1], forces.reshape(-1, 6)[:, 2]
    return np.array([np.maximum(y - eta * wing.span, 0.0) @ up for eta in stations])


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
