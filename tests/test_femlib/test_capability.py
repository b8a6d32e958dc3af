"""The greatest load factor of damage states: the reduced model beside the full one, and what each limit does."""

from dataclasses import replace

import numpy as np
import pytest

from femlib.assembly.stresses import blocks_of, corner_strains
from femlib.errors import InputError
from femlib.rom import ReducedModel, capability
from femlib.rom.capability import Capability, full_limits, reduce_capability
from femlib.rom.zones import QUARTERS, Zones, measured_zones, zone_of_corners
from femlib.wing.strength import reactions, wing_capability, wing_limits, wing_stresses

STATES = np.array([[0.0, 0.0], [0.55, 0.0], [0.0, 0.85], [0.7, 0.3]])


@pytest.fixture(scope="module")
def capable(tiny, tiny_reduced) -> Capability:
    return wing_capability(tiny, tiny_reduced, n_states=16, n_checks=1)


@pytest.mark.long
def test_reduced_limits_are_those_of_the_full_wing_in_states_that_were_not_sampled(tiny, capable):
    limits = wing_limits(tiny)
    down = replace(limits, row=-limits.row)  # a deflection counts in either direction
    full = [
        full_limits(tiny.structure, one, tiny.lift, state)
        for one, state in zip((limits, down) * 2, STATES, strict=True)
    ]
    np.testing.assert_allclose(capable.limits(STATES), full, rtol=1e-3)
    np.testing.assert_allclose(capable.limits(STATES)[:, [0, 2]], np.array(full)[:, [0, 2]], rtol=1e-6)
    other = replace(capable, deflection=-capable.deflection)
    np.testing.assert_array_equal(other.limits(STATES), capable.limits(STATES))


@pytest.mark.long
def test_every_corner_near_failing_in_a_sampled_state_is_kept(tiny, capable):
    shells, sound = tiny.structure.shells, tiny.structure.solve(np.zeros((1, 2)), tiny.lift)[0]
    strains = corner_strains(shells, sound)
    factors = [b.factors(b.strain(strains), "max strain") for b in blocks_of(shells, wing_limits(tiny).faces)]
    near = np.concatenate(factors) <= capability.NEAR * min(own.min() for own in factors)
    assert near.sum() > 1
    kept = sum(len(block.corners) for block in capable.blocks)
    assert near.sum() <= kept <= capability.MOST_KEPT + 1
    looked_at = {height for own in wing_limits(tiny).faces for _, height in own}
    assert {block.height for block in capable.blocks} <= looked_at


def test_states_have_one_two_three_or_all_regions_damaged_in_turns():
    states = capability.drawn_states(np.random.default_rng(0), 8, 6)
    assert np.count_nonzero(states, axis=1).tolist() == [1, 2, 3, 6] * 2


@pytest.mark.long
def test_the_least_limit_counts_and_the_error_is_the_largest_of_all_that_were_checked(tiny, tiny_reduced, monkeypatch):
    checked, full = [], np.array([[1.0, 2.0, 4.0], [4.0, 0.01, 2.0], [9.0, 3.0, 0.5]])
    monkeypatch.setattr(capability, "full_limits", lambda *args: checked.append(args[3]) or full[len(checked) - 1])
    own = wing_capability(tiny, tiny_reduced, wing_limits(tiny, tip_limit=0.01), n_states=8, n_checks=3)
    least = np.minimum(own.limits(np.array(checked)), capability.FAR * full.min(axis=1, keepdims=True))
    assert own.error == pytest.approx(np.abs(least / full - 1.0).max())
    rng = np.random.default_rng(0)
    drawn = [capability.drawn_states(rng, n, 2) for n in (8, 3)]  # solved, then checked
    np.testing.assert_array_equal(checked, drawn[1])
    found = own.limits(STATES)
    np.testing.assert_allclose(own.load_factors(STATES), found.min(axis=1))
    assert (found.argmin(axis=1) == 2).all()
    moved = tiny.solve({"mu1": 0.55}, found[1, 2]).reshape(-1, 6)
    tip = tiny.grid.columns(len(tiny.grid.eta) - 1)[tiny.grid.spar_column]
    assert moved[tip, 2].mean() == pytest.approx(0.01 * tiny.span, rel=1e-5)


def test_the_ply_limit_is_the_load_factor_at_which_the_stresses_reach_the_strength(tiny, capable):
    factor = capable.limits(STATES[1:2])[0, 0]
    found = wing_stresses(tiny, {"mu1": 0.55}, factor)
    assert found.failure_factors("max strain").min() == pytest.approx(1.0, rel=1e-5)
    assert 0.0 < found.error < 0.25


def of_two(first, second, rest):
    """Return needs of the zones of two regions and of the rest."""
    return np.array([first] * QUARTERS + [second] * QUARTERS + [rest])


def test_a_zone_grows_by_what_fine_meshes_of_its_region_alone_add(tiny):
    """n = 2 (1 + mu) on the coarse mesh, 3 (1 + mu) where steps are halved without end; the rest has 1 and 1.5."""
    steps, asked = (0.2, 0.1), []

    def finer(own, damages):
        asked.append(own)
        return [np.outer(1.0 + damages[:, 0], [3.0 - step] * QUARTERS + [1.5 - step]) for step in steps]

    zones = measured_zones(tiny.structure, lambda mu: of_two(2.0 * (1.0 + mu[0]), 0.1 * (1.0 + mu[1]), 1.0), finer)
    assert asked == [(0,)]  # region 2 comes nowhere near the limit of the sound wing
    np.testing.assert_allclose(zones.grown(np.array([0.33, 0.97])), of_two(1.5, 1.0, 1.5 * 1.33))
    assert zones.error == pytest.approx(0.5 * 0.1 / 2.9)
    above = measured_zones(tiny.structure, lambda mu: of_two(2.0, 1.1, 1.0), finer)
    np.testing.assert_allclose(above.grown(np.array([0.9, 0.9]))[-1], 1.0)  # nothing is known of the rest


@pytest.mark.parametrize(("more", "error"), [(1.0, 0.02), (1.25, 0.2)])
def test_the_error_is_that_of_pairs_if_they_are_farther_off(tiny, more, error):
    """Alone regions need 1 + mu on every mesh, together `more` on the fine one; 4 % by steps."""
    asked = []

    def finer(own, damages):
        asked.append(own)
        most = (1.0 + damages.max(axis=1)) * (more if len(own) == 2 else 1.0)
        return [np.outer(share * most, np.ones(QUARTERS + 1)) for share in (0.96 / 1.04, 1.0 / 1.04)]

    zones = measured_zones(tiny.structure, lambda mu: of_two(1.0 + mu[0], 1.0 + mu[1], 1.0), finer)
    assert asked == [(0,), (1,), (0, 1)]
    assert zones.error == pytest.approx(error)


def test_each_corner_of_a_region_has_a_zone_of_its_own(tiny):
    mesh, zone = tiny.structure.shells.mesh, zone_of_corners(tiny.structure)
    node = np.concatenate([mesh.quads.ravel(), mesh.trias.ravel()])
    eta, span = mesh.nodes[:, 1] / tiny.span, tiny.regions[0]
    own = [eta[node[zone == quarter]] for quarter in range(QUARTERS)]
    for inboard, outboard in ((own[0], own[1]), (own[2], own[3])):
        assert (inboard.min(), outboard.max()) == pytest.approx((span.eta_min, span.eta_max))
        assert inboard.max() < outboard.min()
    assert set(zone) == set(range(2 * QUARTERS + 1))


def test_plies_fail_by_the_growth_of_their_zone(tiny, tiny_reduced, capable, monkeypatch):
    """Twice the need in region 1 halves the factor of its corners alone, on the full model and on the reduced one."""
    growth = np.ones((2, QUARTERS + 1, 96))
    growth[0, :QUARTERS] = 2.0
    zones = Zones(zone_of_corners(tiny.structure), growth, 1.0, 0.01)
    monkeypatch.setattr(capability, "measured_zones", lambda *_: zones)
    monkeypatch.setattr(capability, "reduce_buckling", lambda *_: capable.buckling)
    grown = wing_capability(tiny, tiny_reduced, n_states=16, n_checks=1, finer=lambda *_: tiny)
    assert (grown.mesh_error, grown.error < 1e-3) == (0.01, True)
    state = np.array([[0.85, 0.0]])
    assert grown.limits(state)[0, 0] == pytest.approx(0.5 * capable.limits(state)[0, 0], rel=1e-4)


def test_half_of_lognormal_limits_fail_at_the_load_factor_that_a_state_bears(capable):
    bears = float(capable.load_factors(STATES[1:2])[0])
    assert capable.failure_probability(STATES[1:2], bears, 0.1)[0] == pytest.approx(0.5)
    assert capable.failure_probability(STATES[1:2], bears * np.exp(0.1), 0.1)[0] == pytest.approx(0.8413, abs=1e-4)
    with pytest.raises(InputError, match="expected numbers above 0"):
        capable.failure_probability(STATES, 3.0, 0.0)


def test_the_root_holds_the_lift_and_its_moment(tiny):
    held = np.asarray(reactions(tiny, {"mu1": 0.5}, 2.0))
    lift, y = 2.0 * tiny.lift.reshape(-1, 6), tiny.structure.shells.mesh.nodes[:, 1]
    assert held[:, 2].sum() == pytest.approx(-lift[:, 2].sum(), rel=1e-9)
    z = tiny.structure.shells.mesh.nodes[:, 2]
    moments = [(own[:, 3] + y * own[:, 2] - z * own[:, 1]).sum() for own in (held, lift)]
    assert moments[0] == pytest.approx(-moments[1], rel=1e-7)
    assert not held[y > 0].any()


def test_what_cannot_be_used_is_refused(tiny, tiny_reduced, capable):
    model = tiny_reduced.model
    fields = {name: getattr(model, name) for name in ReducedModel.__dataclass_fields__ if not name.startswith("_")}
    still = ReducedModel(**fields | {"motion": None})
    with pytest.raises(InputError, match="with_motion=True"):
        reduce_capability(tiny.structure, still, wing_limits(tiny), tiny.lift)
    with pytest.raises(InputError, match="most_deflection"):
        wing_limits(tiny, tip_limit=0.0)
    with pytest.raises(InputError, match="mu1 = 1"):
        capable.limits(np.array([[1.0, 0.0]]))
