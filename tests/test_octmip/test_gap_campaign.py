"""Campaign files: what is wrong is said with row and column; what is merely incomplete works."""

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import diagnose, read_campaign
from octmip.gap.campaign.noise_estimate import estimate_noise, quantisation_step
from tests.test_octmip.beam_twin import Beam, measured

TWIN = Beam()


def lines_of(campaign, known=True):
    head = ["test", "load_factor", "mu1", "mu2", "time", *campaign.gauges]
    rows = [",".join(head)]
    for k, test in enumerate(campaign.test):
        state = [f"{v:g}" for v in campaign.states[k]] if known else ["", ""]
        cells = [f"{v:.1f}" if np.isfinite(v) else "" for v in campaign.readings[k]]
        rows.append(",".join([test, f"{campaign.load_factor[k]:g}", *state, f"{campaign.time[k]:g}", *cells]))
    return rows


def write(tmp_path, rows):
    path = tmp_path / "campaign.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


def small():
    return lines_of(measured(1, loads=(1.0, 2.0), repeats=4))


def with_cell(rows, row, column, text):
    cells = rows[row].split(",")
    cells[rows[0].split(",").index(column)] = text
    return [*rows[:row], ",".join(cells), *rows[row + 1 :]]


def test_a_written_campaign_comes_back(tmp_path):
    campaign = measured(1, loads=(1.0, 2.0), repeats=4)
    back = read_campaign(write(tmp_path, ["# a comment", *lines_of(campaign)]), TWIN)
    assert back.gauges == campaign.gauges
    assert back.test == campaign.test
    assert np.allclose(back.readings, campaign.readings, atol=0.051)
    assert [cell.name for cell in back.cells] == [cell.name for cell in campaign.cells]


BAD = {
    "an unknown gauge": (lambda rows: [rows[0].replace("g20", "g77"), *rows[1:]], ["row 1", "g77"]),
    "a missing load factor": (lambda rows: with_cell(rows, 3, "load_factor", ""), ["row 4", "load_factor"]),
    "no column of load factors": (
        lambda rows: [rows[0].replace("load_factor", "L"), *rows[1:]],
        ["row 1", "load_factor"],
    ),
    "text in a number": (lambda rows: with_cell(rows, 2, "g05", "broken"), ["row 3", "g05", "broken"]),
    "an infinite reading": (lambda rows: with_cell(rows, 2, "g05", "inf"), ["row 3", "g05"]),
    "a state in per cent": (lambda rows: with_cell(rows, 5, "mu1", "20"), ["row 6", "mu1", "0.2 for 20 %"]),
    "an empty test": (lambda rows: with_cell(rows, 5, "test", ""), ["row 6", "test"]),
    "a short row": (lambda rows: [*rows[:4], rows[4].rsplit(",", 2)[0], *rows[5:]], ["row 5", "cells but"]),
    "a column twice": (lambda rows: [rows[0].replace("g20", "g19"), *rows[1:]], ["row 1", "g19"]),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_file_is_refused_with_row_and_column(tmp_path, case):
    spoil, told = BAD[case]
    with pytest.raises(DataError) as error:
        read_campaign(write(tmp_path, spoil(small())), TWIN)
    assert all(word in str(error.value) for word in told), error.value


def test_a_column_of_text_is_refused_with_its_name(tmp_path):
    rows = small()
    spoiled = [rows[0] + ",remark", *(row + ",windy" for row in rows[1:])]
    with pytest.raises(DataError, match="remark"):
        read_campaign(write(tmp_path, spoiled), TWIN)


@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_units_a_thousand_times_off_are_refused(tmp_path, factor):
    campaign = measured(1, loads=(1.0, 2.0), repeats=4)
    head, *rows = lines_of(campaign)
    scaled = []
    for row in rows:
        cells = row.split(",")
        scaled.append(",".join([*cells[:5], *(repr(float(cell) * factor) for cell in cells[5:])]))
    with pytest.raises(DataError, match=r"row 2, columns g01 to g20.*microstrain"):
        read_campaign(write(tmp_path, [head, *scaled]), TWIN)


def test_equal_readings_are_refused(tmp_path):
    head, *rows = small()
    flat = [",".join([*row.split(",")[:5], *["100"] * 20]) for row in rows]
    with pytest.raises(DataError, match="all 160 readings"):
        read_campaign(write(tmp_path, [head, *flat]), TWIN)


def test_one_repeat_is_refused_alone_and_flagged_with_a_commissioning_run(tmp_path):
    campaign = read_campaign(write(tmp_path, lines_of(measured(1, repeats=1))), TWIN)
    with pytest.raises(DataError, match=r"row 2 .*repeat"):
        diagnose(campaign, TWIN)
    diagnosis = diagnose(campaign, TWIN, commissioning=measured(1000))
    assert diagnosis.is_sound
    assert any("too few repeats" in note for note in diagnosis.notes)


def test_a_thousand_rows_with_a_fifth_missing_work(tmp_path):
    campaign = measured(1, loads=(0.0, 1.0, 2.0, 3.0), repeats=250)
    readings = np.where(np.random.default_rng(0).random(campaign.readings.shape) < 0.2, np.nan, campaign.readings)
    holes = type(campaign)(
        gauges=campaign.gauges,
        parameters=campaign.parameters,
        test=campaign.test,
        load_factor=campaign.load_factor,
        states=campaign.states,
        readings=readings,
        time=campaign.time,
        temperature=campaign.temperature,
    )
    back = read_campaign(write(tmp_path, lines_of(holes)), TWIN)
    assert len(back.test) == 1000
    assert any("20 % of the readings are missing" in note for note in back.notes)
    assert diagnose(back, TWIN, commissioning=measured(1000)).is_sound


def correlated(rng, shape, load):
    steps = rng.standard_normal((shape[0] + 50, shape[1])) * 31.6
    for k in range(1, len(steps)):
        steps[k] = 0.6 * steps[k - 1] + np.sqrt(1 - 0.36) * steps[k]
    return steps[50:]


NOISES = {
    "correlated_noise": correlated,
    "heavy_tailed_noise": lambda rng, shape, load: rng.standard_t(4, shape) * 31.6 / np.sqrt(2),
    "heteroscedastic_noise": lambda rng, shape, load: rng.standard_normal(shape) * 31.6 * (0.6 + 0.3 * load),
}


@pytest.mark.parametrize("name", NOISES)
def test_strange_noise_is_reported_as_noise_and_not_as_an_effect(name):
    diagnosis = diagnose(measured(5, noise=NOISES[name]), TWIN, commissioning=measured(1000))
    assert name in diagnosis.noise.findings
    assert diagnosis.is_sound


def test_white_noise_raises_no_finding_and_its_size_is_right():
    noise = estimate_noise(measured(2))
    assert noise.findings == ()
    assert np.sqrt(np.diag(noise.covariance)) == pytest.approx(np.full(20, 31.6), rel=0.05)


def test_serial_correlation_inflates_the_variance_of_means_as_theory_says():
    noise = estimate_noise(measured(5, noise=correlated, repeats=200))
    assert noise.lag1 == pytest.approx(0.6, abs=0.05)
    assert noise.inflation == pytest.approx((1 + 0.6) / (1 - 0.6), rel=0.2)


def test_the_quantisation_step_is_found():
    values = np.random.default_rng(0).normal(0, 30, (50, 4))
    assert quantisation_step(np.round(values / 5) * 5) == pytest.approx(5.0)
    assert quantisation_step(values) == 0.0


def test_a_stuck_channel_is_reported():
    campaign = measured(5)
    readings = campaign.readings.copy()
    readings[:, 6] = 812.0
    stuck = type(campaign)(
        gauges=campaign.gauges,
        parameters=campaign.parameters,
        test=campaign.test,
        load_factor=campaign.load_factor,
        states=campaign.states,
        readings=readings,
        time=campaign.time,
        temperature=campaign.temperature,
    )
    diagnosis = diagnose(stuck, TWIN, commissioning=measured(1000))
    assert diagnosis.noise.stuck == ("g07",)
    assert not diagnosis.is_sound
