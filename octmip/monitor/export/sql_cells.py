"""How SQL asks the cells of a column, in words that mean the same in every database of docs/howto/export.md.

Numbers. A decimal literal is not read to the last bit by every database, so a number is a quotient or product of whole
numbers that float64 holds: its nearest float64 is the number. A cell is multiplied by 1, as a minus or a CAST would not
do: a minus fails before unsigned columns (Polars wraps in silence), and ClickHouse casts no NULL.

Missing cells. They are NULL, NaN, or a text that stands for nothing. NaN is asked for by its text: as a number it is
greater than all others in DuckDB and PostgreSQL, smaller or greater by its sign in DataFusion, and left out of the
statistics by which DuckDB answers comparisons on Parquet files.

Dates. A text is what all databases make of a date in the same order, and SQLite has nothing else: ISO, of UTC. The
threshold has as many digits as there can be, so a shorter text stands before it where its time does.
"""

from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from octmip.errors import TreeError
from octmip.formats.columns.cells import UNKNOWN
from octmip.formats.columns.column import Column
from octmip.formats.columns.instants import DAY, SECOND, last_instant
from octmip.formats.columns.spellings import DAYS
from octmip.formats.columns.written import is_date, words_of
from octmip.input.cells import EXACT_INTEGERS, MISSING_WORDS, plain_number
from octmip.input.names import shown
from octmip.trees.nodes.tree import Side

LARGEST = 62
"""Powers of two up to 2**62 are whole numbers of every database."""
MOST_DECIMALS = 18
"""Powers of ten up to 10**18 are whole numbers of every database, and of float64."""
WORDS = ", ".join(f"'{word}'" for word in sorted(MISSING_WORDS | {"-nan"}) if "\\" not in word)  # some escape by it
NOTHING = {"numbers": "'', '-', '?', 'na', 'n/a', 'nan', '-nan', 'none', 'null'", "texts": WORDS}
"""Texts of a missing number, by what the cells are; SQLite keeps those of a CSV file, and the empty ones, as texts."""
SPELLINGS = {False: "('false', 'f', '0', '0.0')", True: "('true', 't', '1', '1.0')"}
YEARS = (-719_528, 2_932_897)
"""Days behind 1970 where year 0 begins and year 9999 ends."""
UTC = ("", "UTC", "Etc/UTC", "Z", "+00:00", "-00:00")


@dataclass(frozen=True, slots=True)
class Cells:
    """How the cells of a column are asked.

    Attributes
    ----------
    words
        what a cell is, for the head.
    """

    column: Column
    quoted: str
    words: str

    @classmethod
    def of(cls, column: Column, quoted: str) -> "Cells":
        """Return how a column is asked whose name in quotes is given.

        Raises
        ------
        TreeError
            no wording serves all databases.
        """
        if column.kind != "number":
            return cls(column, quoted, "a text")
        if is_date(column.form):
            _check_date(column)
            return cls(column, quoted, "a date or time of UTC, or its ISO text (2025-03-14, 2025-03-14 15:09:26.5)")
        if column.form:
            is_duration = column.form == DAYS
            what = "durations, which each database writes in another way" if is_duration else words_of(column.form)
            raise TreeError(
                f"column {shown(column.name)} holds {what}; expected plain numbers, dates, Booleans or texts, which an "
                "expression can ask for in every database; train on a column of plain numbers, or export to C or ONNX"
            )
        return cls(column, quoted, "a Boolean" if column.stored == "truths" else "a number")

    @property
    def text(self) -> str:
        """The cell as text; NULL where it is NULL."""
        return f"{self.quoted} || ''"

    @property
    def missing(self) -> str:
        """Whether the cell is missing: true or false, never NULL."""
        if self.column.kind != "number":
            words = [f"'{word}'" for word in ("", UNKNOWN) if word not in self.column.values]
            is_nothing = f" OR {self.text} IN ({', '.join(words)})" if words else ""
            return f"({self.quoted} IS NULL{is_nothing})"
        is_text = self.column.stored != "numbers"
        text, nothing = (f"TRIM({self.text})", NOTHING["texts"]) if is_text else (self.text, NOTHING["numbers"])
        return f"({self.quoted} IS NULL OR LOWER({text}) IN ({nothing}))"

    @property
    def number(self) -> str:
        """The cell as a number, where it is not missing."""
        if is_date(self.column.form):
            raise TreeError(
                f"the tree adds the days of {shown(self.column.name)}; expected dates in splits on one column alone, "
                "as databases count days in different ways; export to C or ONNX, or train without linear leaves"
            )
        if self.column.stored == "truths":
            yes, no = (f"WHEN LOWER({self.text}) IN {SPELLINGS[one]} THEN {exact(float(one))}" for one in (True, False))
            return f"CASE {yes} {no} ELSE NULL END"
        if self.column.stored == "texts":
            return f"CAST(CASE WHEN {self.missing} THEN '0' ELSE TRIM({self.text}) END AS DOUBLE PRECISION)"
        return f"{self.quoted} * {exact(1.0)}"

    def beside(self, threshold: float, side: Side) -> str:
        """Return the condition that a cell that is not missing lies on a side of a threshold."""
        sign = "<=" if side == "left" else ">"
        if is_date(self.column.form):
            return f"{self._time} {sign} '{_time_text(threshold)}'"
        if self.column.stored == "truths":
            words = [SPELLINGS[one][1:-1] for one in (False, True) if (one <= threshold) == (side == "left")]
            return f"LOWER({self.text}) IN ({', '.join(words)})" if words else "1 = 0"
        return f"{self.number} {sign} {exact(threshold)}"

    @property
    def unknown(self) -> str:
        """Whether a cell that is not missing is none that the tree can compare; "" where each is one."""
        if is_date(self.column.form):
            return f"NOT {self._is_time}"
        spelled = ", ".join(words[1:-1] for words in SPELLINGS.values())
        return f"LOWER({self.text}) NOT IN ({spelled})" if self.column.stored == "truths" else ""

    def among(self, texts: tuple[str, ...]) -> str:
        """Return the condition that a cell that is not missing is one of some texts of training."""
        if not texts:
            return "1 = 0"
        if self.column.stored == "texts":
            return f"{self.text} IN ({', '.join(map(text_literal, texts))})"
        numbers = [plain_number(text) for text in texts]
        if self.column.stored == "truths" or None in numbers:
            raise TreeError(
                f"column {shown(self.column.name)} is a category of values such as {shown(texts[0])}, which databases "
                "write in different ways; expected a category of texts or numbers; train on a column of texts"
            )
        same = [f"{self.number} = {exact(number)}" for number in numbers if number is not None]
        return f"({' OR '.join(same)})"

    @property
    def _time(self) -> str:
        """The ISO text of a date or time; the zone goes where it is UTC."""
        text = f"TRIM({self.text})"
        for old, new in (("T", " "), ("Z", ""), ("+00:00", ""), ("+00", "")):
            text = f"REPLACE({text}, '{old}', '{new}')"
        return text

    @property
    def _is_time(self) -> str:
        """Whether the text is one: that of another zone has no answer."""
        time = self._time
        clock = f"{time} LIKE '____-__-__ __:__%' AND {time} NOT LIKE '%+%' AND {time} NOT LIKE '___________%-%'"
        return f"({time} LIKE '____-__-__' OR ({clock}))"


def _check_date(column: Column) -> None:
    """Refuse a date that is written in an order that texts do not have, or a time of another zone than UTC."""
    if column.zone not in UTC:
        raise TreeError(
            f"the times in column {shown(column.name)} are of the zone {shown(column.zone)}; expected UTC, as each "
            "database shows other zones in its way; store them in UTC and train again, or export to C or ONNX"
        )
    if column.stored == "texts" and column.form != "%Y-%m-%d":
        raise TreeError(
            f"column {shown(column.name)} holds {words_of(column.form)}; expected dates of the database or ISO text "
            "(2025-03-14), whose order is that of time; store them so and train again, or export to C or ONNX"
        )


def _time_text(days: float) -> str:
    """Return the last instant that has at most so many days, as ISO text to the nanosecond."""
    if not YEARS[0] <= days < YEARS[1]:
        raise TreeError(f"the tree splits at day {days:g} behind 1970; expected years 0 to 9999, which ISO text has")
    day, clock = divmod(last_instant(days), DAY)
    seconds, rest = divmod(clock, SECOND)
    return f"{np.datetime64(day, 'D')} {seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}.{rest:09d}"


def plain(text: str, what: str) -> str:
    """Return a text that may stand in quotes.

    Raises
    ------
    TreeError
        it holds a NUL character, half of a surrogate pair, or a backslash, which some database reads as an escape.
    """
    text = str(text)
    if "\0" in text or "\\" in text or any(0xD800 <= ord(character) < 0xE000 for character in text):
        found = "a NUL character" if "\0" in text else "a backslash, which ClickHouse reads as an escape,"
        found = found if "\0" in text or "\\" in text else "half of a surrogate pair, which is no character"
        raise TreeError(f"{shown(text)} holds {found}; expected text that a database takes for {what}")
    return text


def text_literal(text: str) -> str:
    """Return a text of a column or class as a literal."""
    return "'" + plain(text, "a text in quotes; rename the value").replace("'", "''") + "'"


def exact(number: float) -> str:
    """Return a number as an expression that is exact in float64."""
    sign, digits, exponent = Decimal(repr(number)).as_tuple()
    assert isinstance(exponent, int)  # finite
    whole = int("".join(map(str, digits))) * 10 ** max(0, exponent) * (-1 if sign else 1)
    if abs(whole) <= EXACT_INTEGERS and -exponent <= MOST_DECIMALS:
        if number == int(number):
            return _whole(int(number))
        return f"({_whole(whole)} / {_whole(10**-exponent)})"
    return _by_powers(number)


def _whole(number: int) -> str:
    return f"CAST({number} AS DOUBLE PRECISION)"


def _by_powers(number: float) -> str:
    """Return a number as a whole one times, or over, powers of two."""
    numerator, denominator = number.as_integer_ratio()
    shift = (numerator & -numerator).bit_length() - 1 if denominator == 1 and numerator else 0
    factors = [f" * {_whole(power)}" for power in _powers(shift)]
    factors += [f" / {_whole(power)}" for power in _powers(denominator.bit_length() - 1)]
    return f"({_whole(numerator >> shift)}{''.join(factors)})"


def _powers(exponent: int) -> list[int]:
    whole, rest = divmod(exponent, LARGEST)
    return [2**LARGEST] * whole + ([2**rest] if rest else [])
