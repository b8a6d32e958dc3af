"""The columns of a campaign's table: matched with what the twin names, in its units, as numbers, times and tests.

A name may have a unit behind it (`g1 [mm]`, `g1 (mm)`, `Force/N`), or a row of units below the header. Numbers in
another unit of the same quantity are converted, and a note says so; others are refused.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.columns.spellings import DAYS, ISO
from octmip.formats.columns.times import (
    days_in,
    instants_of,
    past_midnight,
    plain_instants_of,
    time_form_of,
    time_forms_of,
)
from octmip.formats.columns.written import DIGITS, form_of, read_texts, words_of
from octmip.formats.table import Table, read_table
from octmip.formats.table.units import factor_between, is_unit, unit_behind
from octmip.input.cells import is_missing_word, plain_number
from octmip.input.files import PathLike
from octmip.input.messages import several, shown

Floats = NDArray[np.float64]
TIME, TEMPERATURE, TEST = "time", "temperature", "test"
OWN = {TEST: (TEST,), TIME: (TIME, "timestamp", "datetime", "zeit", "uhrzeit"), TEMPERATURE: (TEMPERATURE,)}
"""What a campaign has beside what the twin names, and how files call it, in any case."""
DAY_NAMES = ("date", "day", "datum")
"""Names of a column with the day of a time of day."""
UNIT_COLUMN = re.compile(r"(?P<name>.*[^\s_.-])[\s_.-]+(?:units?|einheit)", re.IGNORECASE)
"""The name of a column that holds the unit of another one in every row: tip_unit."""
SECONDS = 86_400
NUMBER_LIKE = re.compile(r"[-+]?\d[\d., '\u00a0\u202f]*")
SPAN = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?) ?([^\W\d]+)")
SECONDS_IN = {"ms": 1e-3, "s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0, "hr": 3600.0, "day": 86400.0}
"""Units behind each time, as MATLAB's durations have."""
GREATEST = 1e300
"""Sums of greater readings overflow; some loggers write the greatest float64 where they have none."""
FINER = {"nanoseconds": (1e17, "ns"), "microseconds": (1e14, "us"), "milliseconds": (1e11, "ms")}
"""What times since 1970 may count that are greater than a number; below 1e11 are seconds up to the year 5138."""
SERIAL = ((2e4, 8e4), (7.1e5, 7.7e5))
"""Days of spreadsheets, from 1954 to 2119, and of MATLAB, from 1943 to 2108."""


def doubt_of(seconds: Floats) -> str:
    """Return what numbers (n,) that are read as seconds may count, "days" or one of `FINER`; "" where none does."""
    known = seconds[np.isfinite(seconds)]
    most = np.abs(known).max(initial=0.0)
    if finer := next((unit for unit, (least, _) in FINER.items() if most > least), ""):
        return finer
    is_short = known.size and 0.0 < np.ptp(known) < 30.0
    return "days" if is_short and any(a < known[0] < b for a, b in SERIAL) else ""


@dataclass(frozen=True, slots=True, eq=False)
class CampaignColumns:
    """The cells of a campaign's file, by the names that the twin has for them.

    Attributes
    ----------
    table
        the file.
    place
        name in the file by the twin's name.
    units
        unit that the file gives, by the twin's name.
    notes
        sentences on how the file was read, and on columns that are not used.
    """

    table: Table
    place: Mapping[str, str]
    units: Mapping[str, str]
    notes: tuple[str, ...]

    def __contains__(self, name: str) -> bool:
        return name in self.place

    @property
    def numbers(self) -> tuple[int, ...]:
        """(n_rows,) line of each row, for a sentence: as slow as reading the file."""
        return self.table.numbers_of_rows()

    def texts(self, name: str) -> tuple[str, ...]:
        """Return the cells (n_rows,) of a column as text, spaces stripped, "" where empty."""
        return _texts_of(self.table.frame[self.place[name]])

    def floats(self, name: str, words: bool = False, infinite: bool = False) -> Floats:
        """Return the numbers (n_rows,) of a column in the file's unit, NaN where the cell is empty.

        Parameters
        ----------
        name
            of the column.
        words
            whether a word such as NA is an empty cell too.
        infinite
            whether samples may be infinite: so loggers write what lies beyond their range.

        Raises
        ------
        DataError
            a cell is no finite number.
        """
        column = self.table.frame[self.place[name]]
        if column.dtype.kind in "iuf":
            values = column.to_numpy(dtype=np.float64, na_value=np.nan)
        else:
            grouped = self._grouped(name, words)
            values = grouped if grouped is not None else self._plain(name, words)
        beyond = np.flatnonzero(np.isinf(values) | (words & (np.abs(values) > GREATEST)))
        if beyond.size and not infinite:
            raise DataError(
                f"row {self.numbers[beyond[0]]}, column {name} is {values[beyond[0]]}; expected a finite number; "
                "leave it empty if missing"
            )
        return values

    def _grouped(self, name: str, words: bool) -> Floats | None:
        """Return the numbers (n_rows,) of a column with digits in groups or decimal commas, None where it is none.

        Raises
        ------
        DataError
            a comma may do either.
        """
        texts = self.texts(name)
        there = [bool(text) and not (words and is_missing_word(text)) for text in texts]
        present = [text for text, is_there in zip(texts, there, strict=True) if is_there]
        if not present or all(plain_number(text) is not None for text in present):
            return None
        try:
            form = form_of(list(dict.fromkeys(present)))
            if form not in DIGITS:
                return None
            values = np.full(len(texts), np.nan)
            values[there] = read_texts(present, form)
        except DataError as error:
            raise DataError(f"{self.table.name}: column {name} {error}") from error
        return values

    def _plain(self, name: str, words: bool) -> Floats:
        """Return the plain numbers (n_rows,) of a column; of what is none a word is told before a mark in a number."""
        texts = self.texts(name)
        missing = ["nan" if not text or (words and is_missing_word(text)) else text for text in texts]
        values = [plain_number(text.replace("∞", "inf")) for text in missing]
        bad = [row for row, value in enumerate(values) if value is None]
        if not bad:
            return np.array(values, dtype=np.float64)
        row = next((row for row in bad if not NUMBER_LIKE.fullmatch(texts[row])), bad[0])
        cure = "clear the cell if nothing is known"
        if NUMBER_LIKE.fullmatch(texts[row]):
            cure = "write decimal points and no thousands separators"
        elif (found := re.fullmatch(r"[-+]?[\d.,]+\s*(\D+)", texts[row])) and is_unit(found[1]):
            cure = f"write the number alone, and its unit behind the name of the column: {name} [{found[1]}]"
        elif row == 0:
            cure = "begin the row with # if it holds no readings, but remarks"
        raise DataError(
            f"row {self.numbers[row]}, column {name} is {shown(texts[row])}; expected a number or nothing; {cure}"
        )

    def in_unit(self, name: str, unit: str, values: Floats) -> tuple[Floats, tuple[str, ...]]:
        """Return numbers (n_rows,) of a column in the twin's unit, and a note where they were converted.

        Raises
        ------
        DataError
            the file gives a unit of another quantity, or one that is not known.
        """
        given = self.units.get(name, "")
        if not given:
            return values, ()
        factor = factor_between(given, unit)
        if factor is None:
            raise DataError(
                f"{self.table.name}: column {name} is in {shown(given)}; expected {unit or 'a plain number'}, and the "
                "one is not known to be a multiple of the other; convert the column, or correct its unit"
            )
        return values * factor, (f"Column {name} was converted from {given} to {unit}.",) * (factor != 1.0)

    def time(self) -> tuple[Floats, tuple[str, ...]]:
        """Return the seconds (n_rows,) of each reading, NaN where there is none, and notes on how they were read.

        Raises
        ------
        DataError
            a text is no time, or one that can be read in two ways.
        """
        if TIME not in self:
            return np.full(len(self.table.frame), np.nan), ()
        column = self.table.frame[self.place[TIME]]
        if column.dtype.kind == "M":
            return self._from_first(_seconds_of(column - column.min()))
        if column.dtype.kind == "m":
            return _seconds_of(column), ()
        if (plain := plain_instants_of(column)) is not None:
            seconds = (plain[0] - plain[0].min()) * SECONDS + plain[1] / 1e9
            return self._from_first(seconds - seconds.min(), words_of(ISO).partition(", in days")[0])
        texts = self.texts(TIME)
        present = [text for text in dict.fromkeys(texts) if text and not is_missing_word(text)]
        if column.dtype.kind in "iuf" or all(plain_number(text) is not None for text in present):
            return self._counted(self.floats(TIME, words=True))
        with_unit = [SPAN.fullmatch(text) for text in present]
        if {found[2] if found else "" for found in with_unit} <= set(SECONDS_IN):
            seconds = {found[0]: float(found[1]) * SECONDS_IN[found[2]] for found in with_unit if found}
            return np.array([seconds.get(text, np.nan) for text in texts]), ()
        try:
            return self._written(texts, present)
        except DataError as error:
            raise DataError(f"{self.table.name}, column {self.place[TIME]} {error}") from error

    def _counted(self, values: Floats) -> tuple[Floats, tuple[str, ...]]:
        """Return times that are numbers; what may be days of a spreadsheet or milliseconds is said."""
        if self.units.get(TIME):
            return self.in_unit(TIME, "s", values)
        doubt = doubt_of(values)
        unit = FINER[doubt][1] if doubt in FINER else "d"
        told = f"Column time is read as seconds; it may count {doubt}: write time [{unit}] then."
        return values, (told,) * bool(doubt)

    def _written(self, texts: Sequence[str], present: Sequence[str]) -> tuple[Floats, tuple[str, ...]]:
        told, why = self._rising(texts, present)
        form = told or time_form_of(present)
        if form == DAYS and (day := self._day()) is not None:
            joined = [f"{d} {t}" if d and t else "" for d, t in zip(day, texts, strict=True)]
            return self._written(joined, [text for text in dict.fromkeys(joined) if text])
        parts = instants_of(present, form) if form else None
        if form is None or parts is None:
            odd = next((text for text in present if time_form_of([text]) is None), present[0])
            row = self.numbers[texts.index(odd)] if odd in texts else self.numbers[0]
            raise DataError(
                f"holds {shown(odd)} (row {row}); expected seconds, or times in one form such as 2025-03-14 "
                "15:09:26.5; write it so, or clear the cell"
            )
        days, rest = parts
        days = days - (0 if form == DAYS else days.min())
        at = dict(zip(present, (days * SECONDS + rest / 1e9).tolist(), strict=True))
        seconds = np.array([at.get(text, np.nan) for text in texts])
        if form == DAYS:
            words = words_of(form).replace("in days (6:00 is 0.25)", "in seconds")
            seconds, told_days = past_midnight(seconds)
            return seconds, (f"Column time is read as {words}.{told_days}",)
        return self._from_first(seconds - np.nanmin(seconds), words_of(form).partition(", in days")[0] + why)

    def _rising(self, texts: Sequence[str], present: Sequence[str]) -> tuple[str, str]:
        """Return the form of dates that may be read in two ways, and why it is taken; "" where nothing tells it.

        Readings are in the order of time: where one way keeps it and the other does not, the one is meant. Within one
        day both are the same to the second.
        """
        found: dict[str, Floats] = {}
        known = set(present)
        for form in time_forms_of(present):
            parts = instants_of([text for text in texts if text in known], form)
            assert parts is not None
            days, rest = parts
            seconds = days * SECONDS + rest / 1e9
            found[form] = seconds - seconds.min()
        rises = [form for form, seconds in found.items() if (np.diff(seconds) >= 0.0).all()]
        if len(found) < 2:
            return "", ""
        if len({tuple(seconds.tolist()) for seconds in found.values()}) == 1:
            return next(iter(found)), " (day and month may be exchanged, which changes no time here)"
        return (rises[0], ", which keeps the rows in the order of time") if len(rises) == 1 else ("", "")

    def _day(self) -> tuple[str, ...] | None:
        """Return the days (n_rows,) of times of day, None where no column has them."""
        name = next((one for one in self.table.columns if one.strip().lower() in DAY_NAMES), None)
        return None if name is None else _texts_of(self.table.frame[name])

    def _from_first(self, seconds: Floats, form: str = "dates") -> tuple[Floats, tuple[str, ...]]:
        return seconds, (f"Column {self.place[TIME]} is read as {form}; time counts in seconds from the first.",)


def _texts_of(cells: "pd.Series[Any]") -> tuple[str, ...]:
    return tuple("" if gone else str(cell).strip() for cell, gone in zip(cells, cells.isna(), strict=True))


def _seconds_of(spans: "pd.Series[pd.Timedelta]") -> Floats:
    return days_in(spans) * SECONDS


def read_columns(
    path: PathLike | Table, gauges: Sequence[str], loads: Sequence[str], parameters: Sequence[str]
) -> CampaignColumns:
    """Return the columns of a campaign's file.

    Raises
    ------
    DataError
        the file is no table, a column is missing, two columns have one meaning, or a name is nearly one of the twin's.
    """
    table = path if isinstance(path, Table) else read_table(path, as_text=TEST, keeps_names=True)
    is_empty = table.frame.isna().all(axis=1).to_numpy()
    if 0 < is_empty.sum() < len(is_empty):
        n_empty = int(is_empty.sum())
        left_out = f"{n_empty} row{'s' * (n_empty != 1)} without any cell left out."
        table = replace(table.rows(~is_empty), notes=(*table.notes, left_out))
    known = (TEST, *loads, TIME, TEMPERATURE, *gauges, *parameters)
    units = dict(table.units)
    place: dict[str, str] = {}
    given: dict[str, str] = {}
    unused = []
    for column in table.columns:
        name, unit = _known(column, known)
        if not name or (name in place and name in OWN):
            unused.append(column)
            continue
        if name in place:
            raise DataError(f"{table.name}: columns {place[name]!r} and {column!r} are both {name!r}; name it once")
        place[name], given[name] = column, unit or units.get(column, "")
    for column in unused:
        plain = {_plain(column), _plain(unit_behind(column)[0])}
        meant = next((name for name in known if name not in place and _plain(name) in plain), "")
        if meant:
            raise DataError(
                f"{table.name}: column {column!r} is no gauge, load or state of the twin, which has {meant!r}; "
                f"expected its name; write {meant!r}"
            )
    _refuse_absent(table, place, gauges, loads)
    beside = {column: name for column in unused if (name := _of_units(column, place))}
    given |= {name: _unit_in(table, column) for column, name in beside.items()}
    unused = [column for column in unused if column not in beside]
    notes = table.notes
    unused = [column for column in unused if column.strip().lower() not in DAY_NAMES]
    if unused:
        many = len(unused) != 1
        notes += (f"Column{'s' * many} {several(unused, 6)}: the twin has no such reading; not used.",)
    unchecked = [name for name in loads if given.get(name)] + [name for name in parameters if given.get(name)]
    if unchecked:
        named = ", ".join(f"{name} in {given[name]}" for name in unchecked)
        notes += (f"The twin says no unit of its loads and states, so that of the file is not checked: {named}.",)
    return CampaignColumns(table, MappingProxyType(place), MappingProxyType(given), notes)


def _of_units(column: str, place: Mapping[str, str]) -> str:
    """Return the twin's name of what a column says the unit of, "" where it says none."""
    found = UNIT_COLUMN.fullmatch(column.strip())
    return "" if found is None else next((k for k, own in place.items() if found["name"] in (k, own)), "")


def _unit_in(table: Table, column: str) -> str:
    """Return the unit that stands in all rows of a column.

    Raises
    ------
    DataError
        there are two.
    """
    found = sorted(set(_texts_of(table.frame[column])) - {""})
    if len(found) > 1:
        raise DataError(
            f"{table.name}: column {column!r} holds the units {several(found, 4)}; expected one in every row; convert "
            "the readings to it"
        )
    return next(iter(found), "")


def _known(column: str, known: Sequence[str]) -> tuple[str, str]:
    """Return the twin's name of a column and the unit behind it, "" where it has none."""
    for name, unit in ((column, ""), unit_behind(column)):
        if name in known:
            return name, unit
        own = next((own for own, names in OWN.items() if name.lower() in names), "")
        if own:
            return own, unit
    return "", ""


def _refuse_absent(table: Table, place: Mapping[str, str], gauges: Sequence[str], loads: Sequence[str]) -> None:
    for name in (TEST, *loads):
        if name not in place:
            raise DataError(
                f"{table.name}: column {name!r} is missing; got {several(table.columns, 6)}; add it to every row"
            )
    if not any(name in place for name in gauges):
        raise DataError(
            f"{table.name}: no gauge column; got {several(table.columns, 6)}; expected names such as "
            f"{several(gauges, 3)}; add the gauges"
        )


def _plain(name: str) -> str:
    """Return a name without case, marks and leading zeros: G-1 is g01."""
    letters = re.sub(r"[^a-z0-9]", "", name.lower())
    return re.sub(r"(?<!\d)0+(?=\d)", "", letters)
