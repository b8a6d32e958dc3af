"""Real data: what the pages say of them holds. Read beside the project; skipped where they are not there."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.data import SHARED
from benchmarks.real import beam, measured, pazy
from benchmarks.real.answer import credible_set
from benchmarks.real.by_diagnosis import Named, Said
from benchmarks.real.quadrotor.flight import commands
from benchmarks.real.quadrotor.hover import NO_LOAD, PATTERNS, hover_twin
from benchmarks.real.through_gap import summary
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


@pytest.mark.long
@needs_uav
def test_the_measured_frequencies_ask_for_a_mass_near_the_node_of_the_second_mode(coarse):
    found = measured.diagnosis()
    assert found.inclusion["payload_inertia"] > 0.9
    mass = next(p for p in found.which[0].parameters if p.effect == "payload_inertia")
    assert 0.7 <= float(mass.place.removeprefix("eta ")) <= 0.85
    assert 0.25 < mass.size < 0.55


@pytest.mark.long
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


@pytest.mark.long
@needs_asset
@pytest.mark.parametrize("with_itself", [False, True])
def test_the_commissioning_run_of_the_asset_is_called_sound(wing, with_itself):
    twin, run = wing, read_campaign(RUN, wing)
    found = diagnose(run, twin, commissioning=run if with_itself else None)
    assert found.is_sound
    assert found.which[0].probability > 0.9


DATA = Path(__file__).parents[2].parent / "shared" / "real"
NOTHING = np.zeros(2)


def said_as(*rows: tuple[float, tuple[tuple[str, str], ...]]) -> list[Said]:
    size = np.array([[1.0, 0.5, 1.5]])
    return [
        Said(tuple(Named(*c, "g") for c in causes), probability, np.repeat(size, len(causes), axis=0))
        for probability, causes in rows
    ]


def test_the_set_is_the_fewest_causes_that_hold_a_pair_by_one_of_its_members():
    judged = said_as(
        (0.5, (("cut", "M1"), ("cut", "M2"))), (0.3, (("cut", "M1"),)), (0.17, ()), (0.03, (("tape", "M4"),))
    )
    assert credible_set(judged) == [["cut", "M1"], ["sound", ""]]


def test_a_beam_pinned_at_its_end_has_the_frequencies_of_the_textbook():
    """Clamped and pinned: (beta L)^2 = 15.418 and 49.965 (Blevins (1979), table 8-1)."""
    found = beam.frequencies(200e9, 1e9, (0.0, 0.0), 0.5, 0.505)
    area, inertia = beam.WIDTH * beam.THICKNESS, beam.WIDTH * beam.THICKNESS**3 / 12.0
    speed = np.sqrt(200e9 * inertia / (beam.DENSITY * area)) / (2.0 * np.pi * 0.5**2)
    assert found == pytest.approx(np.array([15.418, 49.965]) * speed, rel=0.003)


def test_what_the_twin_misses_at_told_places_is_learnt_and_nothing_in_the_sound_state():
    twin = beam.beam_twin()
    known = beam.Knowledge(twin, (NOTHING,), np.array([50.0]), ("S",), np.array([[0.01, -0.02]]))
    assert known.correction(0.0, "S")[0] == pytest.approx(NOTHING, abs=5e-4)
    missed, sd = known.correction(50.0, "S")
    assert missed == pytest.approx([0.01, -0.02], rel=0.05)
    assert (sd < 0.2 * np.array(beam.TWIN_ERROR)).all()
    assert (known.correction(50.0, "R")[1] > 2.0 * sd).all()
    assert (known.correction(300.0, "S")[1] > 0.99 * np.array(beam.TWIN_ERROR)).all()


def test_both_logs_of_a_flight_give_the_same_commands():
    rng = np.random.default_rng(0)
    thrust, roll, pitch, yaw = rng.normal([40000, 500, -900, 2000], 300, (50, 4)).T
    signs = {"m1": (-1, 1, 1), "m2": (-1, -1, -1), "m3": (1, -1, 1), "m4": (1, 1, -1)}
    log_a = pd.DataFrame({m: thrust + r * roll / 2 + p * pitch / 2 + y * yaw for m, (r, p, y) in signs.items()})
    log_b = pd.DataFrame({"cmd_thrust": thrust, "cmd_roll": roll, "cmd_pitch": pitch, "cmd_yaw": yaw})
    assert commands(log_a) == pytest.approx(commands(log_b), rel=1e-9)
    alone = pd.DataFrame({"m1": [0.0], "m2": [0.0], "m3": [65536 / 15], "m4": [0.0]})
    assert commands(alone)[0] == pytest.approx(PATTERNS["M3"] / 4.0)


def test_the_hover_twin_balances_forces_and_moments():
    twin = hover_twin()
    sound = twin.ask({}, NO_LOAD, {})

    def change(**sizes: float) -> np.ndarray:
        return twin.ask({}, NO_LOAD, {name.replace("__", " "): size for name, size in sizes.items()}) - sound

    assert change(blade_cut__M2=3.0)[:4] / change(blade_cut__M2=3.0)[0] == pytest.approx(PATTERNS["M2"])
    assert change(payload_centre__centre=4.0) == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.0])
    left = twin.ask({}, NO_LOAD, {"weight_near_rotor M3+M4": 1.0}) - sound
    assert left[1] == pytest.approx(left[0])
    assert left[2:4] == pytest.approx([0.0, 0.0])
    ways = [change(**{f"weight_on_string__{rotor}": 1.0})[4] for rotor in PATTERNS]
    assert np.sign(ways).tolist() == [-1, -1, 1, 1]


@pytest.mark.long
@pytest.mark.skipif(not DATA.exists(), reason="the real measurements are not beside this checkout")
def test_the_practice_stretches_of_the_beam_are_right():
    tests = pd.read_csv(DATA / "beam" / "tests.csv").set_index("segment")
    chosen = tests[tests.role != "blind"]
    stretches = {str(s): beam.read_stretch(DATA / "beam", str(s), r) for s, r in chosen.series.items()}
    for case, moved in (("s016", 101.0), ("s029", 51.0), ("s067", 32.0)):
        first = beam.answer(stretches[case], beam.learn_from(DATA / "beam", stretches, case)).row()["causes"][0]
        assert first["kind"] == "support_moved"
        assert first["size"] == pytest.approx(moved, abs=3.0)
        assert first["low"] - 0.5 < moved < first["high"] + 0.5
    assert beam.answer(stretches["s033"], beam.learn_from(DATA / "beam", stretches, "s033")).sound_probability > 0.9


def test_the_summary_counts_the_whole_truth_a_place_of_it_and_the_log_probability():
    cut, tape = frozenset({("cut", "M1")}), frozenset({("tape", "M1"), ("tape", "M3")})
    told = [(cut, {cut: 0.5, frozenset(): 0.2}), (tape, {cut: 0.6, tape: 0.1}), (frozenset(), {cut: 1.0})]
    expected = (np.log(0.5) + np.log(0.1) + np.log(1e-3)) / 3
    assert summary(told) == f"whole truth first 1 of 3, a place of it 2 of 2, mean log probability {expected:.2f}"
