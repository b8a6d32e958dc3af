"""Tables in Markdown, columns aligned so that they read well as plain text too.

What stands in a cell is text: whatever Markdown or HTML would read in it as a sign of its own is escaped, and only
that, so that plain names stay as they are.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from octmip.input.names import visible

ACTIVE = re.compile(
    r"""[\\`*\[\]|~$]            # escapes, code, emphasis, links, cells, struck text, mathematics
    | (?<![^\W_])_ | _(?![^\W_]) # emphasis: an underscore that does not stand within a word
    | (?<=[A-Za-z]):(?=//)       # an address, which becomes a link by itself
    | (?<=\bwww)\.
    """,
    re.VERBOSE,
)
OPENS = re.compile(r"<(?=[A-Za-z/!?])|&(?=[#A-Za-z])")
"""What HTML reads as the beginning of a tag, comment or entity."""


def markdown_table(rows: Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> str:
    """Return rows as a Markdown table; numbers are set right, and a dash stands for None or a missing entry."""
    columns = list(columns or dict.fromkeys(name for row in rows for name in row))
    heads = [markdown_text(name) for name in columns]
    cells = [[_cell(row.get(name)) for name in columns] for row in rows]
    widths = [max(len(head), 3, *(len(row[j]) for row in cells)) for j, head in enumerate(heads)]
    right = [bool(rows) and all(isinstance(row.get(name), int | float | None) for row in rows) for name in columns]
    lines = [_line(heads, widths, right)]
    lines.append(
        "| " + " | ".join("-" * (w - 1) + (":" if r else "-") for w, r in zip(widths, right, strict=True)) + " |"
    )
    return "\n".join(lines + [_line(row, widths, right) for row in cells])


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.6g}"
    return markdown_text(value)


def markdown_text(text: Any) -> str:
    """Return a text for a cell or the middle of a line of Markdown, without effect there."""
    escaped = ACTIVE.sub(r"\\\g<0>", visible(text))
    return OPENS.sub(lambda found: "&lt;" if found[0] == "<" else "&amp;", escaped)


def code_block(text: str) -> str:
    """Return a text as a fenced block of code, its fence longer than any run of backticks in it."""
    longest = max((len(run) for run in re.findall("`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}\n{text}\n{fence}"


def _line(cells: Sequence[str], widths: Sequence[int], right: Sequence[bool]) -> str:
    padded = [c.rjust(w) if r else c.ljust(w) for c, w, r in zip(cells, widths, right, strict=True)]
    return "| " + " | ".join(padded) + " |"
