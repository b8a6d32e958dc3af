"""The data file beside a page, from the table that a command prints: `COMMAND | python -m benchmarks.as_csv [NUMBER]`.

Commands print their tables in Markdown. This one reads them from standard input and prints the table of a number, the
first by default, as CSV. A family of `python -m benchmarks.run` prints its table on standard error: `2>&1 >/dev/null`.
"""

import csv
import re
import sys

RULE = re.compile(r"\|(?:\s*:?-+:?\s*\|)+")
"""The line between the head of a table and its rows."""

Rows = list[list[str]]


def tables_of(text: str) -> list[Rows]:
    """Return the tables of a Markdown text, each a head and its rows, without the marks of code and of emphasis."""
    lines = [line.strip() for line in text.splitlines()]
    starts = [k - 1 for k, line in enumerate(lines) if k and RULE.fullmatch(line)]
    return [[_cells(lines[start]), *map(_cells, _rows_from(lines, start + 2))] for start in starts]


def _rows_from(lines: list[str], start: int) -> list[str]:
    """Return the lines of a table from a number on, up to the first that is none."""
    end = next((k for k in range(start, len(lines)) if not lines[k].startswith("|")), len(lines))
    return lines[start:end]


def _cells(line: str) -> list[str]:
    cells = re.split(r"(?<!\\)\|", line.strip("|"))
    return [re.sub(r"[`*]", "", cell).replace("\\|", "|").strip() for cell in cells]


def main(words: list[str] | None = None) -> None:
    """Print one table of standard input as CSV.

    Raises
    ------
    SystemExit
        there is no such table.
    """
    given = sys.argv[1:] if words is None else words
    number = int(given[0]) if given else 1
    tables = tables_of(sys.stdin.read())
    if not 1 <= number <= len(tables):
        raise SystemExit(f"standard input holds {len(tables)} tables in Markdown; expected table {number}; count them")
    csv.writer(sys.stdout, lineterminator="\n").writerows(tables[number - 1])


if __name__ == "__main__":
    main()
