"""Campaigns drawn over displays, repeats and noise: the smoke version of `python -m benchmarks.run campaigns`."""

import pickle

import numpy as np
import pytest

from benchmarks.cases.doors.campaigns import DISPLAYS, FAULTS, answered, drawn
from octmip.gap import CachedTwin, Campaign, Differences, Odds, Recorded, diagnose, function_twin, gathered
from octmip.gap.campaign.noise_estimate import estimate_noise
from tests.doors.campaigns import FORCES, NAMES, TWIN, beam, shown
from tests.test_octmip.beam_twin import remembering


@pytest.mark.parametrize("seed", range(2 * len(DISPLAYS)))
def test_a_sound_machine_is_neither_accused_nor_told_to_repair(seed: int) -> None:
    outcome, told = answered(drawn(seed))
    assert outcome in ("sound", "refused"), told


@pytest.mark.parametrize("seed", range(8, 8 + len(FAULTS)))
def test_a_faulty_channel_is_found(seed: int) -> None:
    assert answered(drawn(seed, faulty=True))[0] == "found"


def noise_of(seed: int, rho: float, repeats: int = 12) -> bool:
    """Return whether the noise of four gauges in four cells is said to remember."""
    rng = np.random.default_rng([seed, int(100 * rho)])
    series = remembering(rng, (4 * repeats, 4), rho)
    n, nan = len(series), np.full(len(series), np.nan)
    loads = np.repeat(np.arange(4.0), repeats)
    return estimate_noise(
        Campaign(("a", "b", "c", "d"), (), ("test",) * n, loads, np.zeros((n, 0)), series, nan, nan)
    ).remembers


def test_white_noise_is_not_called_correlated_and_correlated_noise_is() -> None:
    assert sum(noise_of(seed, 0.0) for seed in range(40)) <= 2
    assert sum(noise_of(seed, 0.6) for seed in range(10)) >= 9


def test_the_variance_of_few_repeats_leaves_room_for_what_they_cannot_tell() -> None:
    """The mean of true over estimated variance is 1, not d / (d - 2) with d = 6 degrees of freedom, which is 1.5."""
    n, nan = 12, np.full(12, np.nan)
    names, loads = ("a", "b"), np.repeat(np.arange(6.0), 2)
    ratios = [
        1.0 / np.diag(estimate_noise(Campaign(names, (), ("t",) * n, loads, np.zeros((n, 0)), y, nan, nan)).covariance)
        for y in np.random.default_rng(8).standard_normal((120, n, 2))
    ]
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("left", [0.5, 0.3, 0.12])
def test_the_size_of_a_stiffness_that_lost_most_of_itself_is_right(left: float) -> None:
    wide = function_twin(beam, dict.fromkeys(NAMES, "mm"), {"stiffness": (100.0, 10.0, 200.0, "N/mm")}, ["force"])
    runs = [
        gathered(wide, [Recorded(rows / share, {"force": force}) for force, rows in shown(1e-4, FORCES, 9).items()])
        for share in (left, 1.0)
    ]
    found = diagnose(runs[0], CachedTwin(wide), commissioning=runs[1]).which[0].parameters
    assert [(one.effect, one.size) for one in found] == [("stiffness", pytest.approx(100.0 * (left - 1.0), abs=2.0))]


def test_a_diagnosis_goes_to_another_process_and_back() -> None:
    blocks = shown(1e-4, FORCES, 6)
    campaign = gathered(TWIN, [Recorded(1.25 * rows, {"force": force}) for force, rows in blocks.items()])
    found = diagnose(campaign, CachedTwin(TWIN), odds=Odds(differences=Differences(constants=0.01)))
    assert [part.effect for part in found.which[0].parameters] == ["stiffness"]
    copied = pickle.loads(pickle.dumps(found))
    assert copied.which[0].probability == found.which[0].probability
    twins = [one.augmented(twin) for one, twin in ((found, TWIN), (copied, pickle.loads(pickle.dumps(TWIN))))]
    assert twins[0].predict({}, 50.0).tolist() == twins[1].predict({}, 50.0).tolist()
