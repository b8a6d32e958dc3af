"""The rule that a person reads is the tree: every printed form, read back by a parser of its own, answers as `predict`.

The full run is `python -m benchmarks.run printed_rules`.
"""

from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.cases.doors.printed_rules import wrong_rows
from octmip import Leaf, Split
from octmip.formats.columns.cells import read_cells
from octmip.formats.columns.instants import cut_between, date_text, duration_text
from octmip.formats.columns.times import days_in, read_times
from octmip.input.names import shortened
from octmip.interfaces.report.text import tree_text
from octmip.interfaces.report.tree.words import number as page_number
from octmip.trees.nodes.digits import exact, grouped, midpoint
from tests.oracles.printed_rules import number, value_of

FLOATS = st.floats(allow_nan=False, allow_infinity=False)
BESIDE = (-1500, -1, 0, 1, 400, 1500)
"""Nanoseconds beside an instant: some have its days, which a column of both refuses."""


@pytest.mark.parametrize("first", range(1_000_000, 1_000_030, 10))
def test_printed_rules_part_their_own_rows_as_the_tree_does(first):
    for seed in range(first, first + 10):
        kind, wrong, n_rows = wrong_rows(seed)
        assert n_rows > 0
        assert not any(wrong.values()), f"seed {seed}, {kind}: {wrong}"


@given(FLOATS)
@settings(max_examples=200, deadline=None)
def test_a_number_of_a_tree_reads_back_as_itself(value):
    assert float(exact(value)) == value
    assert number(grouped(value)) == value
    assert number(page_number(value)) == value


@given(FLOATS, FLOATS)
@settings(max_examples=200, deadline=None)
def test_a_threshold_lies_between_its_neighbours_and_is_no_longer_than_their_mean(one, other):
    low, high = sorted((one, other))
    if low == high:
        return
    cut = midpoint(low, high)
    assert low <= cut < high
    mean = low / 2 + high / 2
    assert len(exact(cut)) <= len(exact(mean if low <= mean < high else low))


@pytest.mark.parametrize(("low", "high", "text"), [
    (1_700_000_960.0, 1_700_001_020.0, "1700001000"),
    (48.1234727, 48.1234737, "48.1234732"),
    (1.9, 3.0, "2.45"),
    (0.1, 0.2, "0.15"),
    (1.0, np.nextafter(1.0, 2.0), "1"),
    (1.0 + 2.0**-52, 1.0 + 2.0**-51, "1.0000000000000002"),
    (-1e-300, 1e-300, "0"),
])  # fmt: skip
def test_a_threshold_needs_few_digits(low, high, text):
    assert exact(midpoint(low, high)) == text


@pytest.mark.parametrize(("neighbours", "zone", "text"), [
    (("2024-03-01", "2024-03-02"), None, "2024-03-01"),
    (("2024-03-01 10:00:00.320", "2024-03-01 10:00:00.340"), None, "2024-03-01 10:00:00.33"),
    (("2024-03-01 07:00", "2024-03-05 19:30"), None, "2024-03-04"),
    (("2024-03-01 10:00", "2024-03-01 10:10"), "Europe/Berlin", "2024-03-01 10:05+01:00"),
    (("2024-07-01 10:00", "2024-07-01 10:10"), "-03:30", "2024-07-01 10:05-03:30"),
    (("2024-03-01 10:00:00.000001", "2024-03-01 10:00:00.000009"), None, "2024-03-01 10:00:00.000005"),
])  # fmt: skip
def test_a_cut_of_dates_is_the_date_of_fewest_fields_in_the_zone_of_its_column(neighbours, zone, text):
    stamps = pd.Series([pd.Timestamp(word) for word in neighbours], dtype="datetime64[ns]").dt.tz_localize(zone)
    cells = read_cells(stamps)
    assert date_text(cut_between(*cells.numbers.tolist(), cells.zone), cells.zone) == text


@given(st.integers(-(2**61), 2**61), st.sampled_from(["", "UTC", "Europe/Berlin", "+05:30", "-03:30"]))
@settings(max_examples=40, deadline=None)
def test_a_printed_instant_is_the_last_one_that_goes_left(instant, zone):
    around = pd.Series(pd.to_datetime([instant + k for k in BESIDE]), dtype="datetime64[ns]").dt.tz_localize("UTC")
    days = read_times(around)
    for cut in days.tolist():
        said = pd.Timestamp(date_text(cut, zone))
        said = said.tz_localize("UTC") if said.tz is None else said
        assert ((around <= said).to_numpy() == (days <= cut)).all()


@given(st.integers(-(2**61), 2**61))
@settings(max_examples=40, deadline=None)
def test_a_printed_duration_is_the_last_one_that_goes_left(span):
    around = pd.Series(pd.to_timedelta([span + k for k in BESIDE]), dtype="timedelta64[ns]")
    days = days_in(around)
    for cut in days.tolist():
        said = value_of(duration_text(cut), Fraction(0))
        assert ([Fraction(one.value, 10**9) <= said for one in around] == (days <= cut)).all()


@pytest.mark.parametrize("days", [-1e12, 1e12])
def test_what_no_calendar_reaches_is_said_in_days(days):
    assert (date_text(days, ""), duration_text(days)) == (f"day {days:.0f}", f"{days:.0f} days")


@given(st.lists(st.text("ab", min_size=1, max_size=40), min_size=2, max_size=6, unique=True), st.integers(6, 20))
@settings(max_examples=200, deadline=None)
def test_different_names_stay_different_when_they_are_cut(names, longest):
    found = shortened(names, lambda text: len(text) <= longest)
    assert len(set(found.values())) == len(names)
    assert all(len(text) <= longest for text in found.values())
    assert all(found[name] == name for name in names if len(name) <= longest)


def test_a_large_tree_fits_a_screen_in_python_and_is_whole_in_its_words():
    tree = Leaf(0)
    for k in range(148):
        tree = Split(0, float(k), Leaf(k % 2), tree)
    assert len(str(tree).splitlines()) == 51
    assert str(tree).splitlines()[-1].startswith("... ")
    assert len(repr(tree)) < 100
    assert len(tree_text(tree, ("x",), ("no", "yes")).splitlines()) == 3 * 148 + 1
