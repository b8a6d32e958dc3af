"""The wing with large deflection: the linear wing at small loads, a shorter lever at large ones."""

import numpy as np
import pytest

from femlib.assembly import surface_load, thermal_load
from femlib.wing import Wing, tapered_wing
from femlib.wing.bent import bend
from femlib.wing.model import MICRO

STATE = {"mu1": 0.4, "mu2": 0.6}


def test_small_loads_and_heat_give_the_linear_strains_of_a_damaged_wing(tiny: Wing) -> None:
    shells, left = tiny.structure.shells, tiny.structure.left_in(STATE)
    wind = surface_load(shells.mesh, np.tile([1.0, 0.0, 2.0], (len(left), 1)))
    found = bend(tiny, STATE, 1e-3, lift=wind, warming=1e-3, gradient=1e-2)
    forces = 1e-3 * wind + thermal_load(shells, 1e-3 * left, 1e-2 * left)
    linear = MICRO * tiny.structure.solve_outputs(np.array([[0.4, 0.6]]), forces, tiny.strain_rows)[0]
    assert found.strain_microstrain == pytest.approx(linear, rel=1e-4, abs=1e-6)


@pytest.mark.long
def test_load_factor_three_relieves_tip_and_strain_as_two_independent_codes_found() -> None:
    """The other codes solved the tapered wing."""
    tiny = tapered_wing(refinement=0.25)
    bent = bend(tiny, {}, 3.0)
    linear = tiny.strain_microstrain({}, 3.0)
    change = bent.strain_microstrain / linear - 1.0
    usable = tiny.gauges.is_usable
    assert (change[usable] < -0.004).all()
    assert (change[usable] > -0.018).all()
    tip = tiny.grid.upper[-1, tiny.grid.spar_column]
    assert bent.tip[2] / tiny.solve({}, 3.0)[tip, 2] == pytest.approx(0.995, abs=0.002)
    assert bent.tip[1] < -0.004  # the tip comes inboard


@pytest.mark.long
def test_load_steps_do_not_change_the_answer(tiny: Wing) -> None:
    few, usual = bend(tiny, {}, 3.0, steps=3), bend(tiny, {}, 3.0)
    assert few.strain_microstrain == pytest.approx(usual.strain_microstrain, rel=1e-6)
