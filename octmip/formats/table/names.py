"""Names of columns: none twice, none longer than a page can bear."""

from collections import Counter
from collections.abc import Sequence

from octmip.errors import DataError
from octmip.input.cells import plain_number
from octmip.input.messages import MOST_NAME, shown


def check_names(source: str, header: Sequence[str]) -> None:
    """Refuse a name that stands twice, or that no page can bear.

    Raises
    ------
    DataError
        one is such.
    """
    twice, times = Counter(header).most_common(1)[0] if header else ("", 0)
    if times > 1:
        is_row = ", or, where the first line is a row, put one with names above it"
        cure = f"give each its own name{is_row if plain_number(twice) is not None else ''}"
        raise DataError(f"{source} has the column {shown(twice)} {times} times; {cure}")
    longest = max(header, key=len, default="")
    if len(longest) > MOST_NAME:
        raise DataError(
            f"{source} has a column whose name has {len(longest)} characters ({shown(longest)}); expected at most "
            f"{MOST_NAME}; rename it"
        )
