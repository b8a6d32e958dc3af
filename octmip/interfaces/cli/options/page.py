"""Options of every command that writes a page: its heading, its asset, its day, and units."""

import argparse
import datetime
from collections.abc import Sequence
from typing import TYPE_CHECKING

from octmip.errors import DataError
from octmip.input.messages import shown
from octmip.interfaces.cli.arguments import rarely

if TYPE_CHECKING:
    from octmip.interfaces.report.page import Masthead

HEADINGS = ("title", "asset", "date")


def add_page_arguments(group: argparse._ActionsContainer, column: str, unit_help: str) -> None:
    """Add --unit and the options of a page's heading.

    Parameters
    ----------
    group
        the parser, or a group of it.
    column
        what has a unit, in the usage line: COL or READING.
    unit_help
        the line of help of --unit.
    """
    group.add_argument("--unit", metavar=f"[{column}=]UNIT", action="append", default=[], help=unit_help)
    rarely(group.add_argument("--title", metavar="WORDS", help="heading of the page, in place of its own"))
    rarely(group.add_argument("--asset", metavar="NAME", help="the machine that the page is about, above its heading"))
    rarely(group.add_argument("--date", metavar="YYYY-MM-DD", help="day of the page (default: today)"))


def masthead_of(arguments: argparse.Namespace, is_page: bool) -> "Masthead | None":
    """Return the heading that the options give a page; None where no page is written.

    Raises
    ------
    DataError
        an option of a page where none is written, a day that is none.
    """
    given = [name for name in HEADINGS if getattr(arguments, name) is not None]
    if given and not is_page:
        raise DataError(f"--{given[0]} is for a page; write one with --out PAGE.html, or leave --{given[0]} out")
    day = _day(arguments.date)
    if not is_page:
        return None
    from octmip.interfaces.report.page import Masthead  # slow to import, and words do without

    return Masthead(arguments.title or "", arguments.asset or "", day)


def _day(text: str | None) -> datetime.date | None:
    try:
        return None if text is None else datetime.date.fromisoformat(text)
    except ValueError:
        raise DataError(f"--date is {shown(text)}; expected a day such as 2026-03-14; write it so") from None


def units_of_options(given: Sequence[str], names: Sequence[str], of_what: str) -> dict[str, str]:
    """Return the unit of each name: `NAME=UNIT` gives it to one, `UNIT` to all.

    Raises
    ------
    DataError
        a unit is given to a name that is not among `names`.
    """
    units: dict[str, str] = {}
    for words in given:
        name, sign, unit = words.rpartition("=")
        if sign and name not in names:
            raise DataError(f"--unit names {shown(name)}, which is {of_what}")
        units |= {name: unit} if sign else dict.fromkeys(names, unit)
    return units
