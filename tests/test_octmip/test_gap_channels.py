"""What single channels do wrong is named and left out: stuck, clipped, jumped, with far-off readings."""

import dataclasses
import re

import numpy as np
import pytest

from octmip.gap import diagnose
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.channels.checks import calm, checked
from octmip.gap.channels.jumps import jumps_in
from octmip.gap.channels.levels import stuck_in
from octmip.gap.channels.outliers import robust
from tests.test_octmip.beam_twin import SD, Beam, measured, serial, sound_readings

TWIN = Beam()


def changed(change, seed=5, noise=None, **settings):
    campaign = measured(seed, noise=noise, **settings)
    readings = np.array(campaign.readings)
    change(readings)
    return dataclasses.replace(campaign, readings=readings)


def put(rows, value):
    def change(readings):
        readings[rows, 6] = value

    return change


def test_a_reading_is_compared_with_the_twins_own_whatever_the_order_of_the_columns():
    campaign = measured(5)
    turned = dataclasses.replace(campaign, gauges=campaign.gauges[::-1], readings=campaign.readings[:, ::-1])
    assert np.array_equal(checked(turned, TWIN).predicted, checked(campaign, TWIN).predicted[:, ::-1])


STUCK = {
    "at 0 always": (put(slice(None), 0.0), 200),
    "at another value always": (put(slice(None), 812.0), 200),
    "at 0 from the last load but one on": (put(slice(100, None), 0.0), 100),
    "from the middle of a load on": (put(slice(120, None), 1111.0), 80),
    "in one load": (put(slice(50, 100), 640.5), 50),
    "for a time within a load": (put(slice(60, 80), 640.5), 20),
    "at the last reading": (lambda r: r.__setitem__((slice(130, None), 6), r[129, 6]), 70),
    "at a negative value": (put(slice(None), -37.25), 200),
}


@pytest.mark.parametrize("name", STUCK)
def test_a_stuck_channel_is_named_first_and_left_out(name):
    change, count = STUCK[name]
    campaign = changed(change)
    (found,) = stuck_in(campaign, sound_readings(campaign))
    assert found.gauge == "g07"
    assert abs(len(found.rows) - count) <= 1
    checks = checked(campaign, TWIN)
    assert [(fault.kind, fault.gauge) for fault in checks.faults] == [("stuck", "g07")]
    assert checks.notes[0].startswith("Stuck: ")
    assert "g07" in checks.notes[0]
    assert ("g07" in checks.campaign.gauges) == (count < 199)


@pytest.mark.parametrize("name", ["at another value always", "from the middle of a load on", "in one load"])
def test_a_stuck_channel_leaves_the_rest_sound(name):
    """A channel stuck at 812 made 14 of 18 campaigns unexplained."""
    diagnosis = diagnose(changed(STUCK[name][0]), TWIN, commissioning=measured(1000))
    assert diagnosis.which[0].effects == ()
    assert diagnosis.noise.stuck == ("g07",)
    assert not diagnosis.is_sound
    assert diagnosis.notes[0].startswith("Stuck: ")


@pytest.mark.parametrize(("n", "found"), [(7, 0), (8, 1)])
def test_a_few_equal_readings_within_a_load_are_a_slow_channel(n, found):
    campaign = changed(put(slice(60, 60 + n), 640.5))
    assert len(stuck_in(campaign, sound_readings(campaign))) == found


@pytest.mark.parametrize(
    ("step", "gauges"), [(5.0, np.arange(20)), (40.0, np.arange(20)), (60.0, 6), (80.0, np.arange(20))]
)
def test_coarse_steps_are_not_stuck(step, gauges):
    for seed in range(2):
        coarse = changed(lambda r: r.__setitem__((slice(None), gauges), np.round(r[:, gauges] / step) * step), seed)
        assert stuck_in(coarse, sound_readings(coarse)) == []


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_clipped_channel_is_clipped_and_not_stuck(sign):
    def change(readings):
        readings *= sign
        readings[:, 1] = sign * np.minimum(sign * readings[:, 1], 900.0)

    campaign = changed(change)
    assert stuck_in(campaign, sound_readings(campaign)) == []
    assert [(f.kind, f.gauge, f.value) for f in checked(campaign, TWIN).faults] == [("clipped", "g02", sign * 900.0)]


def with_outliers(share, draw, one_sided=True):
    def noise(rng, shape, load):
        hit = rng.random(shape) < share
        sign = 1.0 if one_sided else rng.choice([-1.0, 1.0], shape)
        return SD * (rng.standard_normal(shape) + sign * hit * draw(rng, shape))

    return noise


OUTLIERS = {
    "all alike": lambda rng, shape: np.full(shape, 10.0),
    "exponential": lambda rng, shape: rng.exponential(5.0, shape),
    "half normal": lambda rng, shape: 10.0 * np.abs(rng.standard_normal(shape)),
}


def z_of(noise, seed, check=True):
    """Means less what the beam shows, in standard deviations of means of plain readings."""
    campaign = measured(seed, noise=noise, mesh=0.0)
    if check:
        campaign = dataclasses.replace(campaign, readings=robust(campaign).readings)
    return np.array([(c.mean - TWIN.predict({}, c.load_factor)) / (SD / np.sqrt(50)) for c in campaign.cells])


@pytest.mark.parametrize("name", OUTLIERS)
def test_means_withstand_outliers_to_one_side(name):
    """Plain means are 0.7 to 1.4 standard deviations too high in every gauge."""
    z = np.array([z_of(with_outliers(0.02, OUTLIERS[name]), seed) for seed in range(8)])
    assert abs(z.mean()) < 0.18
    assert z.std() < 1.08


def test_means_of_normal_noise_are_plain_means():
    z = [(z_of(None, seed), z_of(None, seed, check=False)) for seed in range(20)]
    assert np.mean([np.square(a).mean() for a, _ in z]) <= 1.05 * np.mean([np.square(b).mean() for _, b in z])


@pytest.mark.parametrize("shape_of", [16.0, 4.0, 2.0])
def test_means_of_skewed_noise_are_not_moved(shape_of):
    def noise(rng, shape, load):
        return SD * (rng.gamma(shape_of, size=shape) - shape_of) / np.sqrt(shape_of)

    z = np.array([z_of(noise, seed) for seed in range(8)])
    assert abs(z.mean()) < 0.12


def test_outliers_are_named_with_gauge_and_share():
    def noise(rng, shape, load):
        series = SD * rng.standard_normal(shape)
        series[:, 3] += 12.0 * SD * (rng.random(shape[0]) < 0.05)
        return series

    found = checked(campaign := measured(5, noise=noise), TWIN)
    assert tuple(found.outliers) == ("g04",)
    share = np.mean((campaign.readings - sound_readings(campaign))[:, 3] > 6.0 * SD)
    assert 0.7 * share < found.outliers["g04"] <= share  # some stand beside each other
    assert found.findings == ("outliers",)
    assert "g04" in found.notes[-1]


@pytest.mark.parametrize("size", [3.0, -6.0, 20.0])
@pytest.mark.parametrize("row", [20, 75, 120])
def test_a_jump_is_named_with_its_gauge_and_row(size, row):
    campaign = changed(lambda r: r.__setitem__((slice(row, None), 8), r[row:, 8] + size * SD))
    (jump,) = checked(campaign, TWIN).faults
    assert jump.gauge == "g09"
    assert abs(jump.first - row) <= (1 if abs(size) < 6.0 else 0)
    assert jump.value == pytest.approx(size * SD, rel=0.35)


def test_a_run_keeps_what_a_gauge_read_before_the_cell_of_its_jump():
    run = changed(lambda r: r.__setitem__((slice(75, None), 8), r[75:, 8] + 20.0 * SD))
    assert np.array_equal(np.flatnonzero(np.isfinite(calm(run, TWIN).readings[:, 8])), np.arange(50))


def test_a_gauge_that_jumps_in_its_only_cell_is_left_out():
    campaign = changed(lambda r: r.__setitem__((slice(25, None), 6), r[25:, 6] + 15.0 * SD), loads=(2.0,))
    diagnosis = diagnose(campaign, TWIN, commissioning=measured(1000))
    assert re.match(r"Jump: gauge g07 moves by \+[45]\d\d microstrain at row 26 \(", diagnosis.notes[0])  # 15 x 31.6
    assert "jump" in diagnosis.noise.findings
    assert "g07" not in diagnosis.noise.gauges
    assert diagnosis.is_sound


def test_slow_noise_is_no_jump():
    assert sum(len(jumps_in(measured(seed, noise=serial(0.85)))) for seed in range(6)) <= 1
    often = np.repeat([0.0, 20.0, 0.0, 20.0, 0.0, 20.0, 0.0, 0.0], 25) * SD  # one gauge, in three cells of four
    assert jumps_in(changed(lambda r: r.__setitem__((slice(None), 8), r[:, 8] + often))) == []
    assert jumps_in(changed(lambda r: r.__setitem__(slice(25, None), r[25:] + 20.0 * SD), loads=(2.0,))) == []


def test_readings_far_off_together_or_often_are_no_outliers():
    assert robust(measured(5, noise=with_outliers(0.1, OUTLIERS["all alike"]))).share == {}
    assert robust(changed(lambda r: r.__setitem__((slice(60, 70), 6), r[60:70, 6] + 9.0 * SD))).share == {}


def test_where_every_channel_is_stuck_nothing_says_how_much_they_scatter():
    campaign = measured(5)
    campaign = dataclasses.replace(campaign, readings=np.repeat(campaign.readings[::50], 50, axis=0))
    assert stuck_in(campaign, sound_readings(campaign)) == []  # refused where the noise is asked for


FINE = 5e-4
"""Standard deviation of a reading of a fibre [microstrain]."""


def in_strain(campaign):
    return dataclasses.replace(campaign, readings=1e-6 * campaign.readings, units=("strain",) * len(campaign.gauges))


@pytest.mark.parametrize("name", ["at another value always", "in one load", "for a time within a load"])
def test_a_stuck_channel_is_found_in_whatever_unit(name):
    campaign = changed(STUCK[name][0], sd=FINE)
    (one,) = stuck_in(campaign, sound_readings(campaign))
    (other,) = stuck_in(in_strain(campaign), 1e-6 * sound_readings(campaign))
    assert (one.gauge, one.rows.tolist()) == (other.gauge, other.rows.tolist())


def test_the_noise_is_the_same_in_whatever_unit():
    campaign = measured(3, repeats=20, sd=FINE)
    readings = np.round(campaign.readings / FINE) * FINE
    readings[:, 6] = 840.0
    campaign = dataclasses.replace(campaign, readings=readings)
    one, other = estimate_noise(campaign), estimate_noise(in_strain(campaign))
    assert one.findings == other.findings
    assert "quantisation" in one.findings
    assert other.step == pytest.approx(1e-6 * one.step)
    assert other.covariance == pytest.approx(1e-12 * one.covariance, rel=1e-6, abs=1e-24)
