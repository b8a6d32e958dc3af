"""Effects of the wing against direct solutions on a coarse mesh."""

import numpy as np
import pytest

from femlib.assembly import thermal_load
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import WingTwin, uav_wing
from femlib.wing.effects import wing_effects
from femlib.wing.effects.response import Response
from femlib.wing.structure import WingMaterials

WING = uav_wing(refinement=0.35)
EFFECTS = wing_effects(WING)
TWIN = WingTwin(WING, EFFECTS)
STATE = {"mu1": 0.3, "mu2": 0.5}


def signature(name, load=3.0, place=None, state=STATE):
    effect = EFFECTS[name]
    return effect.signature(TWIN, state, load, variant=effect.variants(TWIN)[0] if place is None else place)


@pytest.mark.parametrize("name", EFFECTS)
def test_the_card_is_complete_and_the_load_power_holds(name):
    effect = EFFECTS[name]
    assert effect.name == name and effect.prior_sd > 0 and effect.separated_by and effect.prior_source
    one, two = signature(name, 1.0), signature(name, 2.0)
    assert one.shape == (24,) and np.abs(one).max() > 0
    assert np.allclose(two, 2.0**effect.load_power * one, rtol=1e-6, atol=1e-9)


def test_the_adjoint_gives_the_strains_of_the_lift():
    direct = WING.strain_microstrain(STATE, 2.0)
    assert np.allclose(Response(WING).strains(STATE, 2.0 * WING.lift), direct, rtol=1e-6)


def test_a_modulus_is_the_strain_of_a_stiffer_wing():
    stiffer = uav_wing(refinement=0.35, materials=WingMaterials(modulus_scale=1.02 * WingMaterials().modulus_scale))
    exact = EFFECTS["modulus"].predict(TWIN, STATE, 3.0, 2.0, "", 0.0)
    assert np.allclose(exact, stiffer.strain_microstrain(STATE, 3.0), rtol=1e-6)


def test_a_skin_thickness_is_the_strain_of_a_wing_with_a_stiffer_skin():
    card = WingMaterials()
    thicker = uav_wing(refinement=0.35, materials=WingMaterials(skin_young=1.001 * card.skin_young))
    change = thicker.strain_microstrain(STATE, 3.0) - WING.strain_microstrain(STATE, 3.0)
    assert np.allclose(0.1 * signature("skin_thickness"), change, rtol=0.01, atol=1e-3)


def test_twenty_kelvin_of_cold_compress_the_top_skin_by_some_fifty_microstrain():
    cold = -20.0 * signature("temperature_uniform", state={})
    assert 35.0 < cold.min() and cold.max() < 75.0


def test_damaged_skin_pushes_less_when_it_is_warm():
    shells = WING.structure.shells
    n = shells.mesh.n_elements
    scale = np.ones(n)
    for component in WING.structure.components:
        scale[component.elements] = 1.0 - STATE[component.parameter]
    force = thermal_load(shells, np.ones(n), np.zeros(n))
    lost = sum(
        STATE[c.parameter] * thermal_load(shells, np.where(c.elements, 1.0, 0.0), np.zeros(n))
        for c in WING.structure.components
    )
    expected = Response(WING).strains(STATE, force - lost)
    assert np.allclose(signature("temperature_uniform"), expected, rtol=1e-9)


@pytest.mark.parametrize("place", ["linear", "toward the tip"])
def test_a_shifted_lift_keeps_its_total_and_moves_the_root_moment_by_its_size(place):
    force = EFFECTS["lift_distribution"].force({}, 1.0, place).reshape(-1, DOFS_PER_NODE)[:, 2]
    lift = WING.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    y = WING.structure.shells.mesh.nodes[:, 1]
    assert force.sum() == pytest.approx(0.0, abs=1e-9 * lift.sum())
    assert force @ y == pytest.approx(0.01 * (lift @ y))


def test_a_first_order_loss_of_stiffness_is_what_a_small_damage_of_a_region_does():
    region = WING.structure.components[0]
    pull = 0.01 * (WING.structure.shells.stiffness(region.elements) @ WING.solve({}, 3.0).ravel())
    small = WING.strain_microstrain({region.parameter: 0.01}, 3.0) - WING.strain_microstrain({}, 3.0)
    assert np.allclose(Response(WING).strains({}, pull), small, rtol=0.03, atol=0.02)


def test_a_large_deflection_relieves_by_less_than_two_per_cent_at_load_factor_three():
    relative = signature("large_deflection", state={}) / WING.strain_microstrain({}, 3.0)
    assert (relative < 0).all() and (relative > -0.02).all()


def test_a_mass_changes_nothing_outboard_of_itself():
    change = signature("payload_inertia", place="eta 0.5", state={})
    outboard = WING.gauges.eta > 0.58
    assert np.abs(change[outboard]).max() < 0.05 * np.abs(change).max()
