"""Campaign files: what is wrong is said with row and column; what is merely incomplete works."""

from dataclasses import replace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import diagnose, read_campaign
from octmip.gap.campaign.noise_estimate import estimate_noise
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
    readings = campaign.readings.copy()
    readings[1:, 4] = np.nan
    assert replace(campaign, readings=readings).has_repeats  # of other gauges than one that was read once
    assert not measured(1, loads=(1.0,), repeats=2).has_repeats


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
    holes = replace(campaign, readings=readings)
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
    few = measured(2, repeats=6, loads=tuple(range(20)))  # too few for a memory: what gauges share is white, too
    common = 60.0 * np.random.default_rng(0).standard_normal((len(few.readings), 1))
    noise = estimate_noise(replace(few, readings=few.readings + common))
    assert noise.findings == ("correlated_noise",)
    assert noise.covariance[~np.eye(20, dtype=bool)].mean() == pytest.approx(60.0**2, rel=0.15)
