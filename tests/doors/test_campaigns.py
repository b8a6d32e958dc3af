"""Campaigns drawn over displays, repeats and noise: the smoke version of `python -m benchmarks.run campaigns`."""

import numpy as np
import pytest

from benchmarks.cases.doors.campaigns import DISPLAYS, FAULTS, answered, drawn
from octmip.gap import Campaign
from octmip.gap.campaign.noise_estimate import estimate_noise


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
    series = rng.standard_normal((4 * repeats, 4))
    for k in range(1, len(series)):
        series[k] = rho * series[k - 1] + np.sqrt(1.0 - rho**2) * series[k]
    n, nan = len(series), np.full(len(series), np.nan)
    loads = np.repeat(np.arange(4.0), repeats)
    return estimate_noise(
        Campaign(("a", "b", "c", "d"), (), ("test",) * n, loads, np.zeros((n, 0)), series, nan, nan)
    ).remembers


def test_white_noise_is_not_called_correlated_and_correlated_noise_is() -> None:
    assert sum(noise_of(seed, 0.0) for seed in range(40)) <= 2
    assert sum(noise_of(seed, 0.6) for seed in range(10)) >= 9
