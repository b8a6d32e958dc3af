"""The noise from its repeats: memory, what gauges share, walks; means and their variance hold to what was drawn."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.cases.gap_noise import Beam as Cantilever
from benchmarks.cases.gap_noise import drawn
from octmip.gap import diagnose
from octmip.gap.campaign.noise import least_moment, moves_together, sizes
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.campaign.spectrum import coefficients, fit, inflation_of
from octmip.gap.channels.checks import noise_of_run
from octmip.interfaces.report.diagnosis.words import noise_lines
from tests.test_octmip.beam_twin import ETA, SD, Beam, effect, measured, remembering, serial

TWIN = Beam()
STEP = 0.022
"""A walk of this step, in standard deviations of a reading, moves later means by twice their scatter."""


def common(rho):
    def noise(rng, shape, load):
        shared = remembering(rng, (shape[0], 1), rho)
        return SD * (rng.standard_normal(shape) + shared) / np.sqrt(2.0)

    return noise


def walking(step=STEP):
    """Return noise whose walk goes on from load to load."""
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


def test_the_covariance_of_means_that_remember_is_one_however_calm_a_load_is():
    """Before: where one load scattered less, what it shared with others was more than it had, and nothing was said."""
    campaign = measured(3, noise=serial(0.95))
    noise = replace(estimate_noise(campaign), scale={0.0: 1.0, 1.0: 0.1, 2.0: 1.0, 3.0: 1.0})
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


@pytest.fixture(scope="module")
def sound():
    return diagnose(measured(12, noise=walking()), TWIN, commissioning=measured(1012, noise=walking()))


def test_a_walk_too_slow_for_the_repeats_accuses_no_sound_asset_and_is_named_on_the_page(sound):
    """Before: something outside the library, probability over .999, in 20 of 20 draws."""
    assert "random_walk" not in estimate_noise(sound.posterior.model.inputs.campaign).findings
    assert sound.is_sound
    assert "random_walk" in sound.noise.findings
    assert sound.noise.walk_sd == pytest.approx(STEP * SD, rel=0.3)
    assert moves_together(sound.noise, sound.posterior.model.inputs.averages) == 0.0  # each gauge walks by itself
    assert any("wander: the typical gauge by" in line for line in noise_lines(sound))


def test_error_bars_know_the_walk(sound):
    model = sound.posterior.model
    variance = [np.diag(model.scatter)[model.cells == k].mean() for k in (0, 3)]
    assert variance[1] - variance[0] == pytest.approx(150 * (STEP * SD) ** 2, rel=0.6)
    assert variance[1] > 2.0 * variance[0]


def test_a_calm_run_beside_a_campaign_that_wanders():
    diagnosis = diagnose(measured(13, noise=walking()), TWIN, commissioning=measured(1013))
    assert diagnosis.is_sound
    assert not diagnosis.doubts


def test_an_effect_is_found_beside_a_walk():
    high = effect("gauge_gain", 8.0, "g05")
    diagnosis = diagnose(measured(14, high, noise=walking()), TWIN, commissioning=measured(1014, noise=walking()))
    first = diagnosis.which[0]
    assert first.effects == ("gauge_gain",)
    size = first.parameters[0]
    assert size.place == "g05"
    assert size.low < 8.0 < size.high


def test_something_unknown_is_no_walk_where_the_readings_are_calm():
    wave = lambda state, load, time: 25.0 * load * np.sin(np.arange(20.0))  # noqa: E731
    diagnosis = diagnose(measured(5, wave), TWIN, commissioning=measured(1005))
    assert diagnosis.unknown_probability > 0.9
    assert diagnosis.noise.walk_sd == 0.0


def test_sizes_hold_all_that_repeats_leave_open_and_white_readings_are_looked_at_as_white_first():
    campaign = measured(1)
    found = sizes(estimate_noise(campaign), campaign.averages(split=False))
    assert sum(np.exp(log_share) for _, log_share in found) == pytest.approx(1.0, abs=0.02)
    assert found[0][1] > np.log(0.9)
    assert found[0][0].parts[0].serial.white_probability > 0.99
    steps = [noise.walk_sd for noise, _ in found]
    assert steps[0] == 0.0
    walks = [step for step in steps if step > 0.0]
    assert len(set(walks)) == len(walks) > 1


def test_a_walk_goes_by_time_where_that_is_recorded():
    campaign = measured(1, loads=(1.0, 2.0), repeats=10)
    rows = np.random.default_rng(1).permutation(20)
    shuffled = replace(
        campaign,
        readings=campaign.readings[rows],
        load_factor=campaign.load_factor[rows],
        time=campaign.time[rows],
    )
    assert shuffled.moments.tolist() == (rows + 1.0).tolist()
    untimed = replace(shuffled, time=np.full(20, np.nan))
    assert untimed.moments.tolist() == list(range(1, 21))
    one, other = (shuffled.averages(split=False)[k].moments for k in (0, 1))
    for pair in ((one, one), (one, other), (other, one)):
        assert least_moment(*pair) == pytest.approx(np.minimum(*np.meshgrid(*pair)).mean())


def test_a_run_that_wanders_beside_a_calm_campaign_is_not_doubted():
    kind = "random walk, slow"
    assert not diagnose(drawn(kind, 0), Cantilever(), commissioning=drawn(kind, 1)).doubts


def sun(cycles, phase, size, middle, width):
    """A field over a part of the beam that comes and goes so many times in a campaign of four loads."""
    shape = size * np.exp(-(((ETA - middle) / width) ** 2))
    return lambda state, load, time: shape * np.sin(2 * np.pi * cycles * time / 1200.0 + phase)


@pytest.mark.parametrize(
    ("cycles", "phase", "size", "is_shared"), [(0.93, 0.83, 19.0, False), (1.73, 5.66, 31.0, True)]
)
def test_what_comes_and_goes_is_unexplained_and_no_sound_asset(cycles, phase, size, is_shared):
    """Before: two effects of the library (.65), and a sound asset with readings that wander (.99)."""
    campaign = measured(4001, sun(cycles, phase, size, 0.5, 0.25))
    diagnosis = diagnose(campaign, TWIN, commissioning=measured(5001))
    assert "unknown" in diagnosis.which[0].effects
    assert diagnosis.unknown_probability > 0.7
    inputs = diagnosis.posterior.model.inputs
    assert (moves_together(diagnosis.noise, inputs.averages) > 0.5) == is_shared


@pytest.mark.long("cbrt", "<lambda>0")
@pytest.mark.parametrize("course", [np.sign, np.cbrt, lambda load: np.tanh(load / 0.6), lambda load: min(load, 1.2)])
def test_joints_that_stick_are_unexplained_and_no_sound_asset(course):
    """Before: a sound asset with readings that wander (.98), whatever the way in which friction sets in."""
    rng = np.random.default_rng(4)
    held = rng.choice([-1.0, 1.0], 20) * rng.uniform(0.6, 1.4, 20)
    campaign = measured(904, lambda state, load, time: 16.0 * held * course(load) / course(3.0))
    diagnosis = diagnose(campaign, TWIN, commissioning=measured(1904))
    assert diagnosis.which[0].effects == ("unknown",)
    assert diagnosis.unknown_probability > 0.9


def stepping(height=0.5, dwell=40.0):
    """White noise with steps up and down, of each gauge by itself, which go on from load to load."""
    side = [None]

    def noise(rng, shape, load):
        start = rng.integers(2, size=shape[1]) if side[0] is None else side[0]
        sides = start + np.cumsum(rng.random(shape) < 1.0 / dwell, axis=0)
        side[0] = sides[-1]
        return SD * (rng.standard_normal(shape) + height * (-1.0) ** sides)

    return noise


def test_the_memory_of_readings_is_weighed_where_repeats_leave_it_open():
    campaign = measured(21, noise=stepping())
    found = [noise for noise, _ in sizes(estimate_noise(campaign), campaign.averages(split=False))]
    still = [noise.parts[0] for noise in found if noise.walk_sd == 0.0]
    means = [part.of_mean(50) * np.trace(part.covariance) for part in still]
    assert max(means) > 1.5 * min(means)
