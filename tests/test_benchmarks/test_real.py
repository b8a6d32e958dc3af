"""Real data: what the pages say of them holds. Read beside the project; skipped where they are not there."""

import pytest

from benchmarks.data import SHARED
from benchmarks.real import measured, pazy
from femlib.wing import reduced_twin, tapered_wing
from femlib.wing.loads import GRAVITY
from octmip.gap import diagnose, read_campaign
from octmip.gap.twins import CachedTwin

RUN = SHARED / "asset" / "commissioning.csv"
needs_pazy = pytest.mark.skipif(not pazy.DATA.is_dir(), reason=f"{pazy.DATA} is not there: the Pazy wing's data")
needs_uav = pytest.mark.skipif(not (SHARED / "uav").is_dir(), reason=f"{SHARED / 'uav'} is not there: the UAV's data")
needs_asset = pytest.mark.skipif(not RUN.is_file(), reason=f"{RUN} is not there: the asset's commissioning run")


@pytest.fixture(scope="module")
def coarse():
    """The measured wing's twin on a coarse mesh: a quarter of the time."""
    fine, measured.REFINEMENT = measured.REFINEMENT, 0.3
    measured.measured_twin.cache_clear()
    yield measured.measured_twin()
    measured.REFINEMENT = fine
    measured.measured_twin.cache_clear()


@needs_pazy
def test_large_deflection_comes_out_of_the_pazy_wing_and_closes_the_gap():
    found = pazy.diagnosis()
    assert found.which[0].effects == ("large_deflection",)
    assert found.which[0].probability > 0.95
    assert found.inclusion["large_deflection"] > 0.95
    assert found.shrinkage.closed > 0.9


@needs_pazy
@pytest.mark.parametrize("limit", [2.0, 2.4])
def test_heavy_masses_are_predicted_from_lighter_ones(limit):
    assert pazy.held_out(limit)[2] > 0.9


@needs_uav
def test_the_measured_frequencies_ask_for_a_mass_near_the_node_of_the_second_mode(coarse):
    found = measured.diagnosis()
    assert found.inclusion["payload_inertia"] > 0.9
    mass = next(p for p in found.which[0].parameters if p.effect == "payload_inertia")
    assert 0.7 <= float(mass.place.removeprefix("eta ")) <= 0.85
    assert 0.25 < mass.size < 0.55


@needs_uav
def test_a_mount_turns_the_tip_as_a_rigid_body_does(coarse):
    """A mass m hung at the span l turns the root by c m g l, and the tip falls by l times that.

    A uniform cantilever's modes of unit mass have 2 m l^2 / (k l)^2 of moment about the root, so a mount of c changes
    all squared periods by the share 4 c EI / l, and the tip's fall by 3 c EI / l.
    """
    change = coarse.effects["root_flexibility"].signature(coarse, {}, 1.0)
    assert change[0] == pytest.approx(GRAVITY * 1.8288**2)
    share = change / coarse.predict({}, 1.0)
    assert share[2] == pytest.approx(share[1], rel=0.3)
    assert share[0] == pytest.approx(0.75 * share[1], rel=0.3)


@pytest.fixture(scope="module")
def wing():
    return CachedTwin(reduced_twin(tapered_wing(refinement=0.5)))  # the asset is that wing by another code


@needs_asset
@pytest.mark.parametrize("with_itself", [False, True])
def test_the_commissioning_run_of_the_asset_is_called_sound(wing, with_itself):
    twin, run = wing, read_campaign(RUN, wing)
    found = diagnose(run, twin, commissioning=run if with_itself else None)
    assert found.is_sound
    assert found.which[0].probability > 0.9
