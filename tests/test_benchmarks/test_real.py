"""Real data: what the pages say of them holds. Read beside the project; skipped where they are not there."""

import numpy as np
import pytest

from benchmarks.data import SHARED
from benchmarks.real import beam, damper, pazy
from femlib.wing import reduced_twin, tapered_wing
from octmip.gap import diagnose, read_campaign
from octmip.gap.twins import CachedTwin

RUN = SHARED / "asset" / "commissioning.csv"
needs_pazy = pytest.mark.skipif(not pazy.DATA.is_dir(), reason=f"{pazy.DATA} is not there: the Pazy wing's data")
needs_asset = pytest.mark.skipif(not RUN.is_file(), reason=f"{RUN} is not there: the asset's commissioning run")


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


DATA = SHARED / "real" / "beam"
DAMPER = SHARED / "damper"
NOTHING = np.zeros(2)


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


@pytest.mark.long
@pytest.mark.skipif(not DATA.exists(), reason="the real measurements are not beside this checkout")
def test_the_practice_stretches_of_the_beam_are_right():
    moved = {"s016": 101.0, "s029": 51.0, "s067": 32.0}
    for case, truth, found in beam.told_stretches(DATA):
        shares = beam.shares_of(found)
        assert max(shares, key=shares.get) == truth, case
        if case in moved:
            size = found.which[0].parameters[0]
            assert size.size == pytest.approx(moved[case], abs=3.0)
            assert size.low - 0.5 < moved[case] < size.high + 0.5


@pytest.mark.long
@pytest.mark.skipif(not DAMPER.exists(), reason="the real measurements are not beside this checkout")
def test_the_damper_s_backlash_comes_out_of_the_series_of_one_amplitude():
    first = damper.diagnosed(damper.read_series(DAMPER)["first"], damper.damper_twin()).which[0]
    backlash = next(p for p in first.parameters if p.effect == "backlash")
    assert first.probability > 0.9
    assert 0.2 < backlash.low < backlash.high < 0.28


def test_the_summary_counts_the_truth_and_its_log_probability():
    moved, sound = frozenset({"support_moved"}), frozenset()
    told = [(moved, {moved: 0.5, sound: 0.2}), (sound, {moved: 0.6, sound: 0.1}), (sound, {moved: 1.0})]
    expected = (np.log(0.5) + np.log(0.1) + np.log(1e-3)) / 3
    assert beam.summary(told) == f"the truth is first in 1 of 3, its mean log probability {expected:.2f}"
