"""What a recording says in its windows, beside the definition of each number."""

from types import SimpleNamespace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.recordings.assignment import _by_name, in_unit
from octmip.recordings.averages import _edges, _rounded, _row_length, _rows, _tests
from octmip.recordings.recording import Channel, Recording
from octmip.recordings.statistics import Statistic, refuse_placeholders, statistic_of
from octmip.recordings.windows import Window, _block_means, _creeps, steady_windows


def channel(values, name="force", unit="N", step=1.0, valid=None):
    return Channel(name, unit, step * np.arange(len(values)), np.asarray(values, dtype=float), valid)


@pytest.mark.parametrize("memory", [0.8, 0.3, -0.5])
def test_a_mean_is_worth_the_samples_that_do_not_remember_one_another(memory):
    rng, values = np.random.default_rng(1), np.zeros(4000)
    for k in range(1, len(values)):
        values[k] = memory * values[k - 1] + rng.normal()
    valid = rng.random(len(values)) < 0.9
    found = statistic_of(channel(values, valid=valid), Window(100.0, 3100.0))
    inside = values[100:3100][valid[100:3100]]
    apart = inside - inside.mean()
    lag = max((apart[1:] @ apart[:-1]) / (apart @ apart), 0.0)
    assert (found.n, found.n_invalid) == (3000, 3000 - len(inside))
    assert (found.mean, found.sd) == pytest.approx((inside.mean(), inside.std(ddof=1)))
    assert found.effective == pytest.approx(len(inside) * (1.0 - lag) / (1.0 + lag))
    assert (found.effective == len(inside)) == (memory < 0.0)


def test_a_sample_is_valid_where_it_is_a_number_and_its_file_says_so():
    assert channel([1.0, np.nan, 2.0], valid=np.array([True, True, False])).is_valid.tolist() == [True, False, False]


def test_a_block_with_fewer_than_half_of_the_samples_has_no_mean():
    valid = np.array([True] * 8 + [True] + [False] * 3 + [True, False, True, True])
    found = _block_means(channel(np.arange(16.0), valid=valid), np.array([0.0, 4.0, 8.0, 12.0, 16.0]))
    assert found == pytest.approx(np.array([1.5, 5.5, np.nan, (12 + 14 + 15) / 3]), nan_ok=True)


@pytest.mark.parametrize("name", ["plateaus", "ramp", "slow ramp"])
def test_windows_lie_inside_plateaus_and_what_creeps_makes_none(name):
    plateau = np.repeat([0.0, 10.0, 20.0], 400)
    course = {"plateaus": plateau, "ramp": np.linspace(0.0, 20.0, 1200), "slow ramp": plateau}[name].copy()
    if name == "slow ramp":
        course[400:800] += np.linspace(0.0, 0.35, 400)
    load = channel(course + np.random.default_rng(0).normal(0.0, 1e-3, 1200))
    if name == "ramp":
        with pytest.raises(DataError, match="no window of at least"):
            steady_windows([load])
        return
    found, _ = steady_windows([load])
    assert [int(window.start // 400) for window in found] == ([0, 1, 2] if name == "plateaus" else [0, 2])
    for window in found:
        first = 400.0 * (window.start // 400)
        assert first + 1.0 < window.start < first + 60.0
        assert first + 340.0 < window.end < first + 399.0


@pytest.mark.parametrize(("lengths", "worth", "row"), [
    ((100.0, 100.0), (40.0, 40.0), 5.0),  # two independent samples a row
    ((100.0, 10.0), (40.0, 4.0), 100.0 / 24.0),  # four rows of the shortest, but no more than 24 of the longest
    ((100.0, 80.0), (2.0, 2.0), 20.0),
    ((100.0, 100.0), (1e6, 1e6), 100.0 / 24.0),
])  # fmt: skip
def test_a_row_is_the_mean_of_as_long_a_stretch_as_its_samples_need(lengths, worth, row):
    windows = [Window(0.0, length) for length in lengths]
    statistics = [{"a": SimpleNamespace(effective=one), "b": SimpleNamespace(effective=9e9)} for one in worth]
    assert _row_length(windows, statistics, ["a", "b"]) == pytest.approx(row)


def test_a_load_keeps_the_digits_that_its_independent_samples_bear():
    spreads = ((3.0, 1.0), (1.0, 1.0), (1.0, 100.0))
    found = [_rounded(Statistic(100, 0, 1.23456789, sd, effective)) for sd, effective in spreads]
    assert found == [1.2, 1.2, 1.23]
    assert _rounded(Statistic(100, 0, 1.23456789012, 0.0, 100.0)) == 1.23456789


def test_a_window_creeps_where_its_thirds_lie_apart_although_single_blocks_scatter():
    scattered = np.linspace(0.0, 0.3, 12) + 0.05 * (-1.0) ** np.arange(12)
    assert _creeps(scattered[None])
    assert not _creeps(scattered[None] - np.linspace(0.0, 0.3, 12))
    chance = np.array([[0.3, -0.2, 0.4, 0.1, -0.3, 0.2, 0.1, -0.4, -0.1]])  # thirds 0.3 apart, steps of 0.4
    assert not _creeps(chance)


def test_a_window_with_a_name_keeps_it_beside_a_channel_of_tests():
    series = channel(np.repeat([1.0, 2.0], 10), "group/run")
    recording = Recording("TDMS", {"group/run": lambda: series}, name="day.tdms")
    windows = [Window(0.0, 5.0), Window(10.0, 15.0, "own")]
    assert _tests(recording, windows, "group/run") == ["run 1", "own"]
    assert _tests(recording, windows, "") == ["day.tdms", "own"]
    with pytest.raises(DataError, match="has 2 numbers from 8 s to 12 s"):
        _tests(recording, [Window(8.0, 12.0)], "group/run")


def test_a_channel_is_known_by_its_name_behind_groups_and_before_a_unit():
    names = ("force", "a/strain", "a/temp [K]", "b/twice", "c/twice", "a/temperature", "b/temperature")
    recording = Recording("TDMS", dict.fromkeys(names, lambda: channel([1.0])), name="day.tdms")
    asked = ("force", "strain", "temp", "none", "temperature")
    assert [_by_name(recording, name) for name in asked] == ["force", "a/strain", "a/temp [K]", "", ""]
    with pytest.raises(DataError, match="may all be 'twice'"):
        _by_name(recording, "twice")


def test_a_channel_is_converted_into_its_unit_and_one_without_is_taken_as_it_is():
    assert in_unit(channel([1.0, 2.0], unit="kN"), "N").values.tolist() == [1000.0, 2000.0]
    bare = in_unit(channel([1.0, 2.0], unit=""), "N")
    assert (bare.values.tolist(), bare.unit) == ([1.0, 2.0], "N")
    with pytest.raises(DataError, match="is in 'V'; expected N"):
        in_unit(channel([1.0], unit="V"), "N")


@pytest.mark.parametrize(
    ("others", "is_refused"), [([-9999.0] * 2, True), ([1012.0] * 2, True), ([-9999.0], False), ([0.0, 0, 1, 2], False)]
)
def test_one_or_two_numbers_far_off_that_come_again_are_no_readings(others, is_refused):
    values = np.append(np.random.default_rng(0).normal(1000.0, 0.1, 100), others)
    check = lambda: refuse_placeholders({"g": channel(values)}, Window(0.0, 200.0))  # noqa: E731
    if is_refused:
        with pytest.raises(DataError, match=f"holds {others[0]:g} 2 times .* where g is about 1000"):
            check()
    else:
        check()


def test_a_slow_channel_has_gaps_in_the_rows_of_a_fast_one():
    channels = {"fast": channel(np.arange(100.0)), "slow": channel(np.arange(4.0), step=25.0)}
    window = Window(0.0, 100.0)
    found = {name: statistic_of(one, window) for name, one in channels.items()}
    rows = _rows(channels, found, _edges(found, window, 10.0))
    assert rows["fast"].tolist() == [10.0 * k + 4.5 for k in range(10)]
    assert rows["slow"].dropna().to_dict() == {0: 0.0, 2: 1.0, 5: 2.0, 7: 3.0}
    assert len(_rows(channels, found, _edges(found, window, 0.1))) == 100
