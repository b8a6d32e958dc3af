"""Effects of the wing against direct solutions on a coarse mesh."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.sparse.linalg import splu, spsolve

from femlib.assembly import thermal_load
from femlib.components import DamagedStructure
from femlib.geometry import Planform
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import WingTwin, bend, uav_wing
from femlib.wing.effects import wing_effects
from femlib.wing.effects.damage_outside_library import damage_zones
from femlib.wing.effects.lift import distributions, moved_aft
from femlib.wing.effects.planform import MANUFACTURED
from femlib.wing.effects.response import Response
from femlib.wing.effects.root_flexibility import rolled
from femlib.wing.effects.spar_skin_debond import web_edge
from femlib.wing.inertia import unit_weight
from femlib.wing.model import reshaped
from femlib.wing.planform import PLANFORM
from femlib.wing.structure import WingMaterials
from tests.test_femlib.conftest import SHARED

WING = uav_wing(refinement=0.25)
EFFECTS = wing_effects(WING)
TWIN = WingTwin(WING, EFFECTS)
STATE = {"mu1": 0.3, "mu2": 0.5}


INVISIBLE = {"root_flexibility"}


def signature(name, load=3.0, place=None, state=STATE, time=1800.0):
    effect = EFFECTS[name]
    return effect.signature(TWIN, state, load, place=effect.places(TWIN)[0] if place is None else place, time=time)


def test_a_mount_that_turns_moves_the_wing_as_a_rigid_body_with_its_tip_up():
    turned, stiffness = rolled(WING), WING.structure.shells.stiffness()
    assert np.abs(stiffness @ turned).max() < 1e-9 * (abs(stiffness) @ np.abs(turned)).max()
    assert WING.tip_row() @ turned == pytest.approx(WING.span)


@pytest.mark.parametrize("name", EFFECTS)
def test_the_card_is_complete_and_the_load_power_holds(name):
    effect = EFFECTS[name]
    assert effect.name == name
    assert effect.prior_sd > 0
    assert effect.separated_by
    assert effect.prior_source
    one, two = signature(name, 1.0), signature(name, 2.0)
    assert one.shape == (24,)
    assert (np.abs(one).max() > 0) == (name not in INVISIBLE)
    if effect.load_power is not None:
        assert np.allclose(two, 2.0**effect.load_power * one, rtol=1e-6, atol=1e-9)


def test_the_gauges_answer_any_force_in_any_state_as_a_new_factorisation_does():
    supports, rng = WING.structure.supports, np.random.default_rng(5)
    response, force = Response(WING), rng.normal(size=WING.lift.shape)  # inside the regions too
    for state in (STATE, {"mu1": 0.9}, {"mu1": 0.05, "mu2": 0.85}):
        row = np.array([state.get(name, 0.0) for name in WING.parameters])
        factors = splu(sparse.csc_array(WING.structure.stiffness(row)))
        direct = 1e6 * (WING.strain_rows @ supports.expand(factors.solve(force[supports.free])))
        for found in (response.strains(state, force), response.strains_of_fixed(state, "any", "", force)):
            assert np.abs(found - direct).max() < 1e-6 * np.abs(direct).max()


def test_a_modulus_is_the_strain_of_a_stiffer_wing():
    stiffer = uav_wing(refinement=0.25, materials=WingMaterials(modulus_scale=1.02 * WingMaterials().modulus_scale))
    exact = EFFECTS["modulus"].predict(TWIN, STATE, 3.0, 2.0, "", 0.0)
    assert np.allclose(exact, stiffer.strain_microstrain(STATE, 3.0), rtol=1e-6)


@pytest.mark.parametrize(
    "place", ["shares of harmonics 5 and 7: 0 and 0", "shares of harmonics 5 and 7: -0.4 and 0.06"]
)
def test_a_shifted_lift_keeps_its_total_and_moves_the_root_moment_by_its_size(place):
    force = distributions(WING)[place].reshape(-1, DOFS_PER_NODE)[:, 2]
    lift = WING.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    y = WING.structure.shells.mesh.nodes[:, 1]
    assert force.sum() == pytest.approx(0.0, abs=1e-9 * lift.sum())
    assert force @ y == pytest.approx(0.01 * (lift @ y))


@pytest.mark.parametrize(
    ("name", "place", "force"),
    [
        ("lift_distribution", "shares of harmonics 5 and 7: 0.2 and 0", lambda place: distributions(WING)[place]),
        ("torsion", "", lambda place: moved_aft(WING)),
        ("payload_inertia", "eta 0.6", lambda place: unit_weight(WING, 0.6)),
    ],
)
def test_an_effect_of_forces_is_the_wing_solved_with_them(name, place, force):
    solved = WING.strain_microstrain(STATE, 3.0, WING.lift + force(place)) - WING.strain_microstrain(STATE, 3.0)
    assert signature(name, place=place) == pytest.approx(solved, rel=1e-6, abs=1e-6)


def test_torsion_moves_the_resultant_aft_by_a_hundredth_of_the_chord():
    force = moved_aft(WING).reshape(-1, DOFS_PER_NODE)[:, 2]
    lift = WING.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    nodes = WING.structure.shells.mesh.nodes
    fraction = nodes[:, 0] / WING.planform.chord(nodes[:, 1] / WING.span)
    assert force.sum() == pytest.approx(0.0, abs=1e-9 * lift.sum())
    assert force @ fraction == pytest.approx(0.01 * lift.sum(), rel=1e-6)


@pytest.mark.parametrize("state", [{}, STATE])
@pytest.mark.parametrize(
    ("name", "rest", "lower"), [("temperature_uniform", 1.0, 1.0), ("temperature_gradient", 0, -0.5)]
)
def test_a_warm_wing_has_that_temperature_and_damaged_skin_pushes_less(name, rest, lower, state):
    shells, left = WING.structure.shells, WING.structure.left_in(state)
    number = {patch: k for k, patch in enumerate(shells.mesh.patches)}
    above = np.isin(shells.mesh.patch_of_element, [number[own] for own in ("top", "R1", "R2")])
    field = np.where(shells.mesh.patch_of_element == number["bottom"], lower, np.where(above, rest or 0.5, rest))
    heat = thermal_load(shells, field * left, np.zeros(len(field)))
    assert signature(name, state=state) == pytest.approx(WING.strain_microstrain(state, 1.0, heat), rel=1e-6)


@pytest.mark.parametrize("start", ["top", "web", "bottom"])
def test_damage_outside_the_library_is_the_wing_with_a_softer_zone(start):
    effect = EFFECTS["damage_outside_library"]
    place = next(p for p in effect.place_names if p.startswith(start) and "0.4" in p)
    shells = WING.structure.shells
    softer = replace(shells, scale=np.where(damage_zones(WING)[place], 0.98, 1.0) * shells.scale)
    solved = replace(WING, structure=DamagedStructure(softer, WING.structure.supports, WING.structure.components))
    change = solved.strain_microstrain({}, 3.0) - WING.strain_microstrain({}, 3.0)
    trace = 2.0 * signature("damage_outside_library", place=place)
    assert np.abs(trace - change).max() < 0.04 * np.abs(change).max()


@pytest.mark.long
def test_large_deflection_is_what_newton_finds():
    linear = WING.strain_microstrain(STATE, 3.0)
    newton = bend(WING, STATE, 3.0).strain_microstrain - linear
    assert np.abs(signature("large_deflection") - newton)[:16].max() < 1e-3 * linear.max()
    low = bend(WING, STATE, -1.0).strain_microstrain + WING.strain_microstrain(STATE, 1.0)
    assert np.abs(signature("large_deflection", -1.0) - low).max() < 0.03 * np.abs(low).max()


def test_creep_is_the_strain_of_a_wing_whose_skins_have_softened_by_that_time():
    card = WingMaterials()
    softer = uav_wing(refinement=0.25, materials=WingMaterials(skin_young=card.skin_young / 1.002))
    change = softer.strain_microstrain(STATE, 3.0) - WING.strain_microstrain(STATE, 3.0)
    assert np.allclose(0.2 * signature("creep", time=3600.0), change, rtol=0.01, atol=1e-3)
    assert (signature("creep", time=0.0) == 0.0).all()
    assert np.allclose(signature("creep", time=32 * 3600.0), 2.0 * signature("creep", time=3600.0))
    quick, slow = (signature("creep", place=f"within {words}", time=100.0) for words in ("minutes", "half an hour"))
    assert np.allclose(quick, (1.0 - np.exp(-1.0)) * signature("creep", time=3600.0))
    assert np.allclose(slow, quick * (1.0 - np.exp(-0.1)) / (1.0 - np.exp(-1.0)) / (1.0 - np.exp(-3.6)))


def test_the_planform_is_linear_between_designed_and_manufactured():
    halfway = Planform(*(0.5 * (getattr(PLANFORM, f) + getattr(MANUFACTURED, f)) for f in PLANFORM.__slots__))
    change = reshaped(WING, halfway).strain_microstrain(STATE, 3.0) - WING.strain_microstrain(STATE, 3.0)
    assert np.allclose(0.5 * signature("planform"), change, rtol=0.02, atol=0.05)
    assert MANUFACTURED.area() < PLANFORM.area()
    assert (signature("planform", state={}) > 0).all()


def test_the_manufactured_planform_is_that_of_the_published_table():
    table = SHARED / "uav" / "geometry_data.csv"
    if not table.exists():
        pytest.skip("the published geometry is not beside the project (../shared/uav/geometry_data.csv)")
    rows = [line.split(",") for line in table.read_text().splitlines()[1:]]
    for column, planform in ((1, PLANFORM), (2, MANUFACTURED)):
        lengths = (planform.span, planform.root_chord, planform.tip_chord)
        assert [1e-3 * float(row[column]) for row in rows] == pytest.approx(lengths)


@pytest.mark.parametrize("flange", ["upper", "lower"])
def test_a_debond_is_the_wing_with_its_nodes_cut_there(flange):
    shells, supports = WING.structure.shells, WING.structure.supports
    elements, nodes = web_edge(WING, flange)
    eta = shells.mesh.nodes[nodes, 1] / WING.span
    place = next(p for p in EFFECTS["spar_skin_debond"].place_names if p.startswith(f"{flange} eta 0.285-"))
    inner, outer = (float(x) for x in place.split()[2].split("-"))
    cut = nodes[(eta >= inner) & (eta <= outer)]
    assert len(cut) >= 3
    assert elements.sum() == len(WING.grid.eta) - 1
    n = shells.mesh.n_dofs
    # the web's edge gets spanwise displacements of its own, numbered after all others
    own = np.arange(n)
    own[6 * cut + 1] = n + np.arange(len(cut))
    row = sparse.coo_array(shells.stiffness(elements))
    web = sparse.coo_array((row.data, (own[row.row], own[row.col])), shape=(n + len(cut),) * 2)
    rest = sparse.coo_array(shells.stiffness(~elements))
    rest = sparse.coo_array((rest.data, (rest.row, rest.col)), shape=web.shape)
    free = np.concatenate([supports.free, n + np.arange(len(cut))])
    matrix = sparse.csc_array(web + rest)[free][:, free]
    moved = np.zeros(n + len(cut))
    moved[free] = spsolve(matrix, np.concatenate([3.0 * WING.lift, np.zeros(len(cut))])[free])
    change = 1e6 * (WING.strain_rows @ moved[:n]) - WING.strain_microstrain({}, 3.0)
    assert np.abs(change).max() > 10.0
    assert signature("spar_skin_debond", place=place) == pytest.approx(change, rel=1e-5, abs=1e-5)
