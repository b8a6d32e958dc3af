"""Forty ways to write a time and more: each is read as the instant that it means, or refused with the cure.

The instants come from Python's calendar. A table's column counts them in days since 1970-01-01 (UTC); a campaign's
`time` in seconds from the first.
"""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.formats.columns.cells import read_cells
from octmip.gap import read_campaign
from tests.doors.texts import Beam

DAY = timedelta(days=1)


def at(*parts: int, offset: float = 0.0) -> timedelta:
    """Return the time from 1970-01-01 to an instant on a clock that is ahead of UTC by hours."""
    return datetime(*parts, tzinfo=UTC) - datetime(1970, 1, 1, tzinfo=UTC) - timedelta(hours=offset)


def clock(hours: float, minutes: float = 0.0, seconds: float = 0.0, days: int = 0) -> timedelta:
    return timedelta(days=days, hours=hours, minutes=minutes, seconds=seconds)


READ = {
    "2025-03-14": at(2025, 3, 14),
    "2025-03-14 15:09": at(2025, 3, 14, 15, 9),
    "2025-03-14T15:09:26": at(2025, 3, 14, 15, 9, 26),
    "2025-03-14 15:09:26.5": at(2025, 3, 14, 15, 9, 26, 500_000),
    "2025-03-14 15:09:26,5": at(2025, 3, 14, 15, 9, 26, 500_000),
    "2025-03-14T15:09:26.123456000": at(2025, 3, 14, 15, 9, 26, 123_456),
    "2025-03-14T15:09:26Z": at(2025, 3, 14, 15, 9, 26),
    "2025-03-14T15:09:26+02:00": at(2025, 3, 14, 15, 9, 26, offset=2),
    "2025-03-14 15:09:26 -0330": at(2025, 3, 14, 15, 9, 26, offset=-3.5),
    "2025-03-14 15:09:26+01": at(2025, 3, 14, 15, 9, 26, offset=1),
    "2025-03-14 15:09:26 UTC": at(2025, 3, 14, 15, 9, 26),
    "2025-03-14 15:09:26 UTC+1": at(2025, 3, 14, 15, 9, 26, offset=1),
    "2025-03-14 24:00": at(2025, 3, 15),
    "20250314T150926Z": at(2025, 3, 14, 15, 9, 26),
    "20250314T1509": at(2025, 3, 14, 15, 9),
    "20250314_150926": at(2025, 3, 14, 15, 9, 26),
    "2025-W11-5": at(2025, 3, 14),
    "2025W115": at(2025, 3, 14),
    "2025-073": at(2025, 3, 14),
    "2025-03": at(2025, 3, 1),
    "2025Q2": at(2025, 4, 1),
    "2025/03/14 15:09:26.250": at(2025, 3, 14, 15, 9, 26, 250_000),
    "2025.03.14 15:09": at(2025, 3, 14, 15, 9),
    "14.3.2025 15:09": at(2025, 3, 14, 15, 9),
    "14.03.2025 15:09:26,25": at(2025, 3, 14, 15, 9, 26, 250_000),
    "14/03/2025": at(2025, 3, 14),
    "14-03-2025 15:09:26:250": at(2025, 3, 14, 15, 9, 26, 250_000),
    "03/14/2025 3:09:26 PM": at(2025, 3, 14, 15, 9, 26),
    "03/14/2025 12:05 AM": at(2025, 3, 14, 0, 5),
    "3/14/2025, 3:09:26\u202fPM": at(2025, 3, 14, 15, 9, 26),
    "14 Mar 2025": at(2025, 3, 14),
    "14-Mar-2025 15:09:26": at(2025, 3, 14, 15, 9, 26),
    "14MAR2025": at(2025, 3, 14),
    "14. März 2025": at(2025, 3, 14),
    "March 14, 2025 15:09": at(2025, 3, 14, 15, 9),
    "Friday, March 14, 2025 3:09:26 PM": at(2025, 3, 14, 15, 9, 26),
    "Fri, 14 Mar 2025 15:09:26 +0100": at(2025, 3, 14, 15, 9, 26, offset=1),
    "Fri Mar 14 15:09:26 2025": at(2025, 3, 14, 15, 9, 26),
    "Fri Mar 14 15:09:26 UTC 2025": at(2025, 3, 14, 15, 9, 26),
    "14/Mar/2025:15:09:26 +0000": at(2025, 3, 14, 15, 9, 26),
    "2025-Mar-14 15:09:26": at(2025, 3, 14, 15, 9, 26),
    "15:09:26 14.03.2025": at(2025, 3, 14, 15, 9, 26),
    "14.3.2025 15.09": at(2025, 3, 14, 15, 9),
    "14.3.2025 klo 15.09.26": at(2025, 3, 14, 15, 9, 26),
    "14. maaliskuuta 2025": at(2025, 3, 14),
    "14-03-2025 15.09.26": at(2025, 3, 14, 15, 9, 26),
    "14. maj 2025 kl. 15.09": at(2025, 5, 14, 15, 9),
    "2025. 03. 14. 15:09": at(2025, 3, 14, 15, 9),
    "2025. 3. 14. \uc624\ud6c4 3:09": at(2025, 3, 14, 15, 9),
    "2025-03-14 \uc624\uc804 12:09:26": at(2025, 3, 14, 0, 9, 26),
    "2025\ub144 3\uc6d4 14\uc77c": at(2025, 3, 14),
    "2025\u5e743\u670814\u65e5 15:09": at(2025, 3, 14, 15, 9),
    "14/03/2025 03:09:26 p. m.": at(2025, 3, 14, 15, 9, 26),
    "15:09:26.5": clock(15, 9, 26.5),
    "15:09": clock(15, 9),
    "3:09 PM": clock(15, 9),
    "0:05:12.3": clock(0, 5, 12.3),
    "100:00:00": clock(100),
    "1 days 02:03:04": clock(2, 3, 4, days=1),
    "-1 days +23:59:58.5": clock(0, 0, -1.5),
    "1 day, 2:03:04": clock(2, 3, 4, days=1),
    "5 days": clock(0, days=5),
    "PT5M12.3S": clock(0, 5, 12.3),
    "P1DT2H": clock(2, days=1),
}
REFUSED = {
    "03/04/2025": "either number may be the month.*write them as 2025-03-14",
    "03-04-2025 10:00": "either number may be the month",
    "03/04/25 15:09": "years have two digits.*four digits",
    "14.03.25": "years have two digits",
    "05:12.3": "minutes and seconds or hours and minutes; write 0:05:12.3",
    "2025-03-14 15:09:26 CET": r"zone is a name that may stand for two offsets; write .*\+01:00",
    "2025-03-14T15:09:26[Europe/Berlin]": "zone is a name",
}
WORDS = ("1.2.3", "2025-02-30", "25:00 PM", "Mon, 14 Mar 2025", "v1", "10:1", "2025-13-01", "14 Foo 2025")
"""No times: there is no such day, or 14 March 2025 was no Monday."""


@pytest.mark.parametrize("text", READ)
def test_a_time_is_read_as_the_instant_that_it_means_in_tables_and_in_campaigns(text: str, tmp_path: Path) -> None:
    assert read_cells(pd.Series([text, text])).numbers.tolist() == [pytest.approx(READ[text] / DAY, abs=1e-11)] * 2
    rows = "".join(f'"{text}",a,{force},{800 * force + k},{500 * force}\n' for k in range(4) for force in (1, 2))
    (tmp_path / "run.csv").write_text("time,test,force,g1,g2\n" + rows)
    read = read_campaign(tmp_path / "run.csv", Beam())
    is_span = READ[text] < 10 * DAY
    assert read.time.tolist() == [pytest.approx(READ[text].total_seconds() if is_span else 0.0, abs=1e-6)] * 8
    assert any("is read as" in note for note in read.notes)


RISING = {
    "3/9/2026 10:00,3/10/2026 10:00,4/1/2026 9:30": ([0.0, 86_400.0, 23 * 86_400.0 - 1800.0], "order of time"),
    "9/3/2026 10:00,10/3/2026 10:00,1/4/2026 9:30": ([0.0, 86_400.0, 23 * 86_400.0 - 1800.0], "order of time"),
    "3/1/2026 10:00:01,3/1/2026 10:00:02,3/1/2026 10:01:00": ([0.0, 1.0, 59.0], "which changes no time"),
    "740042.4,740042.41,740042.42": ([740042.4, 740042.41, 740042.42], "may count days: write time [d]"),
    "1772359200000000000,1772359201000000000": ([1.7723592e18, 1.772359201e18], "nanoseconds: write time [ns]"),
    "1/2/2026,2/2/2026,3/2/2026": (None, "either number may be the month"),
}
"""Readings in the order of time: one way keeps it, both are the same, or nothing tells them apart; and counts."""


@pytest.mark.parametrize("texts", RISING)
def test_a_campaign_takes_the_reading_of_dates_that_keeps_its_order_and_says_so(texts: str, tmp_path: Path) -> None:
    rows = "".join(f"{text},a,{k},{800 * k},{500 * k}\n" for k, text in enumerate(texts.split(",")))
    (tmp_path / "run.csv").write_text("Uhrzeit,test,force,g1,g2\n" + rows)
    right, said = RISING[texts]
    if right is None:
        with pytest.raises(DataError, match=said):
            read_campaign(tmp_path / "run.csv", Beam())
        return
    read = read_campaign(tmp_path / "run.csv", Beam())
    assert read.time.tolist() == pytest.approx(right)
    assert any(said in note for note in read.notes)


@pytest.mark.parametrize("text", REFUSED)
def test_a_time_that_can_be_read_in_two_ways_is_refused_with_its_cure(text: str) -> None:
    with pytest.raises(DataError, match=REFUSED[text]):
        read_cells(pd.Series([text, text]))


@pytest.mark.parametrize("text", WORDS)
def test_what_is_no_time_stays_a_word(text: str) -> None:
    assert read_cells(pd.Series([text, text])).is_text


def test_many_times_are_no_names_of_rows_but_told_what_keeps_them_from_being_read() -> None:
    texts = [f"2025-03-{k + 1:02} 10:00" for k in range(28)]
    with pytest.raises(DataError, match="'a' holds 'n/k' among times; write every time as 2025-03-14"):
        Columns.learn(pd.DataFrame({"a": ["n/k", *texts]}))
    assert Columns.learn(pd.DataFrame({"a": ["NA", *texts]})).columns[0].kind == "number"


def test_times_that_float64_would_merge_are_refused() -> None:
    with pytest.raises(DataError, match="so close together"):
        read_cells(pd.Series(["2025-03-14T15:09:26.000000001", "2025-03-14T15:09:26.000000002"]))


STAMPS = pd.Series(pd.to_datetime(["2025-03-14 15:09:26.25", None, "2025-03-15 00:00:00.00"]))
SPANS = pd.Series(pd.to_timedelta(["0:05:12.25", None, "1 days"]))


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
@pytest.mark.parametrize("zone", [None, "UTC", "Europe/Berlin"])
def test_a_frame_and_its_text_hold_the_same_days(unit: str, zone: str | None) -> None:
    stamps = STAMPS.dt.floor("s").astype(f"datetime64[{unit}]")
    stamps = stamps if zone is None else stamps.dt.tz_localize(zone)
    text = pd.Series(
        [None if gone else str(one) for one, gone in zip(stamps, stamps.isna(), strict=True)], dtype=object
    )
    np.testing.assert_array_equal(read_cells(stamps).numbers, read_cells(text).numbers)
    spans = SPANS.dt.floor("s").astype(f"timedelta64[{unit}]")
    text = pd.Series([None if gone else str(one) for one, gone in zip(spans, spans.isna(), strict=True)], dtype=object)
    np.testing.assert_array_equal(read_cells(spans).numbers, read_cells(text).numbers)
