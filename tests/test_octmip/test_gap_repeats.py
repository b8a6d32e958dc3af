"""The noise from its repeats: memory, what gauges share, walks; means and their variance hold to what was drawn."""

import dataclasses

import numpy as np
import pytest

from octmip.gap import diagnose
from octmip.gap.campaign.noise import sizes
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.campaign.spectrum import coefficients, fit, inflation_of
from octmip.gap.channels.checks import noise_of_run
from tests.test_octmip.beam_twin import Beam, measured

SD = 31.6
TWIN = Beam()


def remembering(rng, shape, rho):
    """AR(1) of unit variance along the first axis."""
    series = rng.standard_normal((shape[0] + 200, *shape[1:]))
    for k in range(1, len(series)):
        series[k] = rho * series[k - 1] + np.sqrt(1.0 - rho**2) * series[k]
    return series[200:]


def serial(rho):
    return lambda rng, shape, load: SD * remembering(rng, shape, rho)


def common(rho):
    def noise(rng, shape, load):
        shared = remembering(rng, (shape[0], 1), rho)
        return SD * (rng.standard_normal(shape) + shared) / np.sqrt(2.0)

    return noise


def walking(step):
    level = [0.0]

    def noise(rng, shape, load):
        walk = level[0] + step * np.cumsum(rng.standard_normal(shape), axis=0)
        level[0] = walk[-1]
        return SD * (walk + rng.standard_normal(shape))

    return noise


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.7, 0.85, 0.9])
@pytest.mark.parametrize("n", [20, 50])
def test_the_variance_of_means_is_without_bias(rho, n):
    """The variance of batch means is .84 to .66 of the true one at rho .7 to .85 and n = 50."""
    rng = np.random.default_rng(1)
    found = [fit([coefficients(remembering(rng, (n, 96), rho))]).of_mean(n) for _ in range(20)]
    true = float(inflation_of(np.array([rho]), n)[0]) / n
    assert 0.97 < np.mean(found) / true < (1.08 if n == 50 or rho < 0.7 else 1.35)


def test_expected_cosines_are_exact():
    n, rho = 12, 0.6
    covariance = rho ** np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    basis = coefficients(np.eye(n))
    rng = np.random.default_rng(2)
    few = fit([coefficients(remembering(rng, (n, 20000), rho))])
    assert few.of_mean(n) == pytest.approx(covariance.sum() / n**2, rel=0.03)
    assert np.allclose(basis @ np.ones(n), 0.0)


@pytest.mark.parametrize("noise", [serial(0.0), serial(0.5), serial(0.85), common(0.0), common(0.8)])
def test_means_scatter_as_the_noise_says(noise):
    squares = []
    for seed in range(8):
        campaign = measured(seed, noise=noise, mesh=0.0)
        model = estimate_noise(campaign)
        own = 1 + 0.0 * np.arange(20)
        for cell in campaign.cells:
            error = cell.mean - own * TWIN.predict({}, cell.load_factor)
            squares.append(error @ np.linalg.solve(model.of_mean(cell.count, cell.load_factor), error) / 20)
    assert 0.75 < np.mean(squares) < 1.3


@pytest.mark.parametrize("noise", [serial(0.85), common(0.8), walking(0.3)])
def test_correlated_noise_is_named_and_accuses_no_sound_asset(noise):
    diagnosis = diagnose(measured(3, noise=noise), TWIN, commissioning=measured(1003, noise=noise))
    assert "correlated_noise" in diagnosis.noise.findings
    assert diagnosis.which[0].effects in ((), ("unknown",))  # a walk of a third of the noise a reading is no noise


def test_a_walk_is_named_and_carried_from_cell_to_cell():
    campaign = measured(1, noise=walking(0.3))
    noise = estimate_noise(campaign)
    assert "random_walk" in noise.findings
    averages = campaign.averages(split=False)
    index = np.arange(len(averages))
    across = noise.across(averages, index, np.zeros_like(index))
    step = (0.3 * SD) ** 2
    assert across[0, 3] == pytest.approx(25.5 * step, rel=0.4)  # the earlier cell's walk, half of its 50 readings on
    assert across[3, 3] == pytest.approx((150 + 50 / 3) * step, rel=0.4)


def test_white_noise_has_no_part_across_cells():
    campaign = measured(2)
    averages = campaign.averages(split=False)
    noise = sizes(estimate_noise(campaign), averages)[0][0]
    index = np.arange(len(averages))
    assert not noise.across(averages, index, np.zeros_like(index)).any()
    assert noise.inflation == pytest.approx(1.0, abs=0.05)


def test_the_covariance_of_means_that_remember_is_one_however_calm_a_load_is():
    """Before: where one load scattered less, what it shared with others was more than it had, and nothing was said."""
    campaign = measured(3, noise=serial(0.95))
    noise = dataclasses.replace(estimate_noise(campaign), scale={0.0: 1.0, 1.0: 0.1, 2.0: 1.0, 3.0: 1.0})
    averages = campaign.averages(split=False)
    covariance = noise.of_averages(averages, np.arange(4), np.full(4, 2))
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_halves_of_a_cell_share_what_the_noise_remembers():
    campaign = measured(3, noise=serial(0.85))
    noise = estimate_noise(campaign)
    halves = campaign.averages(split=True)[:2]
    index, gauge = np.array([0, 1]), np.array([4, 4])
    covariance = noise.of_averages(halves, index, gauge)
    whole = noise.of_mean(np.full(20, 50), 0.0)[4, 4]
    assert covariance.sum() / 4.0 == pytest.approx(whole, rel=0.02)


def test_means_of_loads_read_one_after_the_other_share_a_long_memory():
    """Before: nothing; steps up and down of a dwell of 40 readings accused 5 of 40 sound assets."""
    rng, n, rho = np.random.default_rng(7), 50, 0.95
    level = remembering(rng, (4 * n, 20), rho)
    blocks = iter(np.split(level, 4))
    noise = estimate_noise(campaign := measured(6, noise=lambda rng, shape, load: SD * next(blocks)))
    averages = campaign.averages(split=False)
    index = np.arange(len(averages))
    across = noise.across(averages, index, np.zeros_like(index))
    true = rho * ((1.0 - rho**n) / (1.0 - rho)) ** 2 / n**2 * SD**2
    assert across[0, 1] == pytest.approx(true, rel=0.5)
    assert across[0, 2] < 0.2 * across[0, 1]


def test_the_one_gauge_that_wanders_has_a_part_of_its_own():
    def noise(rng, shape, load):
        series = SD * rng.standard_normal(shape)
        series[:, 5] = SD * remembering(rng, (shape[0],), 0.95)
        return series

    campaign = measured(4, noise=noise)
    averages = campaign.averages(split=False)[:1]
    every = np.arange(20)
    of_mean = np.diag(estimate_noise(campaign).of_averages(averages, np.zeros(20, dtype=np.int64), every))
    assert of_mean[5] > 5.0 * np.median(of_mean)


def test_a_run_without_repeats_takes_the_noise_of_the_campaign():
    campaign, run = measured(1), measured(2, repeats=1)
    noise, notes = noise_of_run(run, estimate_noise(campaign))
    assert np.sqrt(np.diag(noise.covariance)) == pytest.approx(np.full(20, SD), rel=0.1)
    assert "campaign's is used" in notes[0]
    diagnosis = diagnose(campaign, TWIN, commissioning=run)
    assert any("campaign's is used" in note for note in diagnosis.notes)


def test_missing_readings_change_little():
    campaign = measured(5, noise=serial(0.7), repeats=200)
    whole = estimate_noise(campaign)
    readings = np.where(np.random.default_rng(0).random(campaign.readings.shape) < 0.05, np.nan, campaign.readings)
    holes = estimate_noise(dataclasses.replace(campaign, readings=readings))
    assert holes.inflation == pytest.approx(whole.inflation, rel=0.25)
