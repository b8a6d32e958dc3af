"""Campaign files: what is wrong is said with row and column; what is merely incomplete works."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError, TwinError
from octmip.gap import diagnose, read_campaign
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.channels.levels import clipped_in
from octmip.interfaces.report.diagnosis.recommendation import recommend
from tests.test_octmip.beam_twin import Beam, measured, sound_readings

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


def with_cell(rows, row, column, text):
    cells = rows[row].split(",")
    cells[rows[0].split(",").index(column)] = text
    return [*rows[:row], ",".join(cells), *rows[row + 1 :]]


def test_one_repeat_is_refused_alone_and_flagged_with_a_commissioning_run(tmp_path):
    campaign = read_campaign(write(tmp_path, lines_of(measured(1, repeats=1))), TWIN)
    with pytest.raises(DataError, match=r"row 2 .*repeat"):
        diagnose(campaign, TWIN)
    diagnosis = diagnose(campaign, TWIN, commissioning=measured(1000))
    assert diagnosis.is_sound
    assert any("too few repeats" in note for note in diagnosis.notes)


def test_readings_of_which_a_fifth_is_missing_are_diagnosed():
    campaign = measured(1, loads=(0.0, 1.0, 2.0, 3.0), repeats=250)
    holes = np.where(np.random.default_rng(0).random(campaign.readings.shape) < 0.2, np.nan, campaign.readings)
    assert diagnose(replace(campaign, readings=holes), TWIN, commissioning=measured(1000)).is_sound


def jumping(rng, shape, load):
    """White noise; one gauge reads six standard deviations more from the middle of load factor 1 on."""
    since = np.arange(shape[0]) + 50.0 * load >= 75.0
    return 31.6 * (rng.standard_normal(shape) + 6.0 * np.outer(since, np.arange(shape[1]) == 8))


NOISES = {
    "heavy_tailed_noise": lambda rng, shape, load: rng.standard_t(4, shape) * 31.6 / np.sqrt(2),
    "heteroscedastic_noise": lambda rng, shape, load: rng.standard_normal(shape) * 31.6 * (0.6 + 0.3 * load),
    "outliers": lambda rng, shape, load: 31.6 * (rng.standard_normal(shape) + 10.0 * (rng.random(shape) < 0.02)),
    "jump": jumping,
}


@pytest.mark.parametrize("name", NOISES)
def test_strange_noise_is_reported_as_noise_and_not_as_an_effect(name):
    """Before: outliers accused nine of nine sound assets."""
    diagnosis = diagnose(measured(5, noise=NOISES[name]), TWIN, commissioning=measured(1000))
    assert name in diagnosis.noise.findings
    assert diagnosis.is_sound


def test_white_noise_raises_no_finding_and_its_size_is_right():
    noise = estimate_noise(measured(2))
    assert noise.findings == ()
    assert np.sqrt(np.diag(noise.covariance)) == pytest.approx(np.full(20, 31.6), rel=0.05)
    few = measured(2, repeats=6, loads=tuple(range(20)))  # too few for a memory: what gauges share is white, too
    common = 60.0 * np.random.default_rng(0).standard_normal((len(few.readings), 1))
    few = replace(few, readings=few.readings + common)
    noise = estimate_noise(few)
    once = np.where((np.arange(len(few.readings)) > 0)[:, None] & (np.arange(20) == 4), np.nan, few.readings)
    assert replace(few, readings=once).has_repeats  # of other gauges than one that was read once
    assert noise.findings == ("correlated_noise",)
    assert noise.covariance[~np.eye(20, dtype=bool)].mean() == pytest.approx(60.0**2, rel=0.15)


ROWS = lines_of(measured(1, loads=(0.0, 1.0, 2.0), repeats=6))
"""Row 1 is the header; rows 2 to 7 are at load factor 0, 8 to 13 at 1, 14 to 19 at 2."""


def changed(column, change, rows=ROWS):
    place = rows[0].split(",").index(column)
    lines = [rows[0]]
    for k, row in enumerate(rows[1:]):
        cells = row.split(",")
        cells[place] = change(k, cells[place])
        lines.append(",".join(cells))
    return lines


def scaled(factor, rows=ROWS, only=None):
    lines = list(rows)
    for name in rows[0].split(",")[5:]:
        if only is None or name == only:
            lines = changed(name, lambda k, cell: repr(float(cell) * factor), lines)
    return lines


def without(column):
    place = ROWS[0].split(",").index(column)
    return [",".join(cell for k, cell in enumerate(row.split(",")) if k != place) for row in ROWS]


def divided():
    lines = list(ROWS)
    for name in ROWS[0].split(",")[5:]:
        lines = changed(name, lambda k, cell: repr(float(cell) / max(1, k // 6)), lines)
    return lines


def text(lines):
    return "\n".join(lines) + "\n"


def load(factor):
    return changed("load_factor", lambda k, cell: f"{float(cell) * factor:g}")


REFUSED = {
    "a missing load factor": (text(with_cell(ROWS, 3, "load_factor", "")), ["row 4", "load_factor", "with #"]),
    "text in a number": (text(with_cell(ROWS, 2, "g05", "broken")), ["row 3", "g05", "broken"]),
    "an infinite reading": (text(with_cell(ROWS, 2, "g05", "inf")), ["row 3", "g05"]),
    "a state in per cent": (text(with_cell(ROWS, 5, "mu1", "20")), ["row 6", "mu1", "0.2 for 20 %"]),
    "an empty test": (text(with_cell(ROWS, 5, "test", "")), ["row 6", "test"]),
    "a gauge without its zero": (text(ROWS).replace("g05", "g5"), ["'g5'", "write 'g05'"]),
    "a load with its unit": (text(with_cell(ROWS, 3, "load_factor", "2g")), ["row 4, column load_factor", "'2g'"]),
    "a load that is no number": (text(with_cell(ROWS, 3, "load_factor", "nan")), ["row 4, column load_factor"]),
    "loads in newtons": (text(load(245.0)), ["row 8", "0.004", "at load factor 245", "no newtons"]),
    "loads in m/s2": (text(load(9.81)), ["row 8", "0.1", "load factor"]),
    "loads of the other sign": (text(load(-1.0)), ["rows 2 to 19", "compressive strain positive"]),
    "strain": (text(scaled(1e-6)), ["row 8, columns g01 to g20", "microstrain"]),
    "nanostrain": (text(scaled(1e3)), ["row 8, columns g01 to g20", "microstrain"]),
    "tension positive": (text(scaled(-1.0)), ["rows 2 to 19", "reverse the sign"]),
    "readings over load": (text(divided()), ["row 14", "1/2 of what the twin predicts", "multiply"]),
    "one gauge in nanostrain": (text(scaled(1e3, only="g05")), ["column g05", "convert this one"]),
    "one gauge in millistrain": (text(scaled(1e-3, only="g05")), ["column g05", "convert this one"]),
    "an absurd reading": (text(with_cell(ROWS, 3, "g05", "1e300")), ["row 4, column g05", "1e+300"]),
    "a column copied": (
        text(changed("g07", lambda k, cell: ROWS[k + 1].split(",")[10])),
        ["rows 2 to 19", "columns g06 and g07"],
    ),
    "no reading": (
        text([ROWS[0], *(",".join(row.split(",")[:5]) + "," * 20 for row in ROWS[1:])]),
        ["no reading at all"],
    ),
    "a state in words": (text(changed("mu1", lambda k, cell: "none")), ["row 2, column mu1", "'none'"]),
    "a negative state": (text(with_cell(ROWS, 3, "mu2", "-0.1")), ["row 4, column mu2", "-0.1; expected a fraction"]),
    "a state of 1": (text(with_cell(ROWS, 3, "mu2", "1")), ["row 4, column mu2", "expected a fraction"]),
    "a test of two states": (text(with_cell(ROWS, 3, "mu1", "0.3")), ["row 4, column mu1 is 0.3", "row 2", "'T0'"]),
    "a state given by halves": (text(with_cell(ROWS, 3, "mu1", "")), ["row 4, column mu1 is empty", "row 2"]),
    "a row of statistics": (text(with_cell(ROWS, 18, "test", "Std. Dev.:")), ["row 19", "as a statistic of the rows"]),
    "a row of a pivot table": (text(with_cell(ROWS, 18, "test", "Grand Total")), ["row 19", "delete the row"]),
    "the greatest float64": (text(changed("g05", lambda k, cell: "1.797e308")), ["row 2, column g05", "empty"]),
    "a mark of overload beside decimal commas": (
        text(with_cell(ROWS, 9, "g05", ">>>>")).replace(",", ";").replace(".", ","),
        ["row 10, column g05 is '>>>>'", "clear the cell"],
    ),
    "loads with their unit": (text(changed("load_factor", lambda k, cell: f"{cell} g")), ["load_factor [g]"]),
    "a row of units": (text([ROWS[0], ROWS[0].replace("g", "m"), *ROWS[1:]]), ["row 2, column"]),
}


def reading(tmp_path, content, encoding="utf-8"):
    path = tmp_path / "campaign.csv"
    path.write_bytes(content.encode(encoding))
    return read_campaign(path, TWIN)


@pytest.mark.parametrize("case", REFUSED)
def test_what_no_physics_explains_is_refused_with_its_place(tmp_path, case):
    content, told = REFUSED[case]
    with pytest.raises(DataError) as error:
        reading(tmp_path, content)
    assert all(word in str(error.value) for word in told), error.value


SAME = {
    "tests that look like comments": text(changed("test", lambda k, cell: "#1")),
    "gauges in another order": text([",".join(row.split(",")[:5] + row.split(",")[:4:-1]) for row in ROWS]),
    "a name over two lines": text(changed("test", lambda k, cell: '"T\n0"')),
}


@pytest.mark.parametrize("case", SAME)
def test_what_only_looks_different_is_read_as_it_is_meant(tmp_path, case):
    plain, other = reading(tmp_path, text(ROWS)), reading(tmp_path, SAME[case])
    order = [other.gauges.index(name) for name in plain.gauges]
    assert np.array_equal(other.readings[:, order], plain.readings)
    assert other.notes == plain.notes == ()


def test_what_names_the_rows_of_a_frame_is_read_as_a_column(tmp_path):
    pytest.importorskip("pyarrow")
    plain = reading(tmp_path, text(ROWS))
    pd.read_csv(tmp_path / "campaign.csv").set_index(["time", "test"]).to_parquet(tmp_path / "campaign.parquet")
    again = read_campaign(tmp_path / "campaign.parquet", TWIN)
    assert (again.test, again.time.tolist(), again.notes) == (plain.test, plain.time.tolist(), plain.notes)
    assert np.array_equal(again.readings, plain.readings)


def test_rows_keep_their_line_numbers(tmp_path):
    campaign = reading(tmp_path, text(["# first", ROWS[0], "", *ROWS[1:3], "# pause", *ROWS[3:]]))
    assert campaign.numbers[:4] == (4, 5, 7, 8)
    assert campaign.without({0}).numbers[0] == campaign.numbers[6]


WARNED = {
    "a mark for nothing": (with_cell(ROWS, 10, "g05", "-9999"), "row 11, column g05: -9999"),
    "an empty column": (changed("g05", lambda k, cell: ""), "Column g05 holds no reading"),
    "every third": (changed("g05", lambda k, cell: cell * (k % 3 > 0)), "1.7 % of the readings are missing"),
    "a bridge the wrong way round": (
        changed("g05", lambda k, cell: repr(-float(cell))),
        "Column g05 has the opposite sign",
    ),
    "time that runs back": (changed("time", lambda k, cell: str(-k)), "Row 3, column time"),
    "time with a hole": (with_cell(ROWS, 4, "time", ""), "Row 5, column time"),
    "a column that the twin lacks": (text(ROWS).replace("g20", "g77").splitlines(), "Column 'g77': the twin has no"),
    "no reading in words": (changed("g05", lambda k, cell: "N/A"), "Column g05 holds no reading"),
    "kelvin": ([ROWS[0] + ",temperature", *(row + ",293" for row in ROWS[1:])], "column temperature is 293"),
    "gauges left out": (without("g05"), "1 of the twin's gauges are not in the file (g05)"),
    "a state left out": (without("mu2"), "Some states are unknown"),
}


@pytest.mark.parametrize("case", WARNED)
def test_what_may_be_real_is_read_with_a_warning(tmp_path, case):
    lines, told = WARNED[case]
    notes = reading(tmp_path, text(lines)).notes
    assert any(told in note for note in notes), notes


@pytest.mark.long("6")
@pytest.mark.parametrize("repeats", [3, 6])
def test_few_repeats_raise_no_false_alarm(repeats):
    """Without shared degrees of freedom half of such runs were false alarms."""
    runs = [
        measured(seed, repeats=repeats, loads=(0.0,) if repeats == 6 else (0.0, 1.0, 2.0, 3.0)) for seed in range(3)
    ]
    assert all(diagnose(run, TWIN, commissioning=measured(1000)).is_sound for run in runs)


def test_clipped_gauges_are_named_and_left_out_where_they_clip():
    whole, rails = measured(5), np.where(np.isin(np.arange(20), [1, 16]), 1500.0, np.inf)
    campaign = replace(whole, readings=np.minimum(whole.readings, rails))
    diagnosis = diagnose(campaign, TWIN, commissioning=measured(1000))
    assert diagnosis.noise.clipped == {"g02": 1500.0, "g17": 1500.0}
    assert "clipping" in diagnosis.noise.findings
    assert diagnosis.is_sound
    told = "Widen the range of the channels of gauges g02 and g17: g02 ends at 1500 microstrain and g17 ends at 1500"
    assert recommend(diagnosis).startswith(told)
    assert any("column g02 stops at 1500 microstrain" in note for note in diagnosis.notes)


def test_a_gauge_that_meets_both_ends_of_its_range_is_left_out_at_both():
    whole = measured(5, loads=(-3.0, -2.0, 0.0, 2.0, 3.0))
    readings = whole.readings.copy()
    readings[:, 6] = np.clip(readings[:, 6], -900.0, 900.0)
    campaign = replace(whole, readings=readings)
    found = clipped_in(campaign, sound_readings(campaign))
    assert [(fault.gauge, fault.value) for fault in found] == [("g07", 900.0), ("g07", -900.0)]
    left_out = np.concatenate([fault.rows for fault in found])
    assert [float(c.load) for c in campaign.cells if not np.isin(c.rows, left_out).any()] == [0.0]
    assert found[1].words.startswith("Clipped: column g07 stops at -900 microstrain")


def test_no_rail_is_seen_where_there_is_none():
    plain = measured(5)
    assert clipped_in(plain, sound_readings(plain)) == []
    coarse = replace(plain, readings=np.round(plain.readings / 80.0) * 80.0)
    assert clipped_in(coarse, sound_readings(coarse)) == []


def test_a_known_noise_stands_in_for_repeats(tmp_path):
    once = measured(1, repeats=1)
    diagnosis = diagnose(once, TWIN, commissioning=None, noise_sd=31.6)
    assert diagnosis.is_sound
    assert np.sqrt(np.diag(diagnosis.noise.covariance)) == pytest.approx(np.full(20, 31.6))
    assert any("given standard deviation is taken as known" in note for note in diagnosis.notes)
    by_gauge = diagnose(once, TWIN, noise_sd=dict.fromkeys(TWIN.gauges, 31.6))
    assert by_gauge.which[0].probability == pytest.approx(diagnosis.which[0].probability)
    with pytest.raises(DataError, match=r"noise_sd of gauge g01 is -3.*positive"):
        diagnose(measured(1), TWIN, noise_sd=-3.0)
    assert any("is not used" in note for note in diagnose(measured(1), TWIN, noise_sd=31.6).notes)


def test_a_twin_that_answers_nothing_but_zeros_is_one_sentence():
    class Silent(Beam):
        def predict(self, state, load_factor):
            return np.zeros(20)

    with pytest.raises(TwinError, match=r"Silent answers 0 for each of 20 readings .*load factor 3.*not all 0"):
        diagnose(measured(1), Silent())
