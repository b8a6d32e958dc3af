"""Shared by the fuzz of file readers: ways to mangle the bytes, values, cells, tokens and arrays of a valid file.

Each function takes a generator and a content, and returns another content; nothing here knows who reads it.
"""

import csv
import io
import json
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")
Generator = np.random.Generator
Mangler = Callable[[Generator, bytes], bytes]
Holder = dict[str, Any] | list[Any]
"""A JSON object or array, whose entries may be anything."""

NUMBERS = ("0", "-1", "1", "1.0", "0.5", "-0.0", "1e308", "-1e308", "5e-324", "1e999", "-1e999", "9007199254740993")
LONG = ("9" * 30, "-" + "9" * 30, "9" * 400, "9" * 5000, "18446744073709551616", "9223372036854775808", "2147483648")
NAMES = ("", "x", "a" * 1001, "a" * 1_000_000, "<script>alert(1)</script>", "$\\frac{1}{$", "=cmd|' /C c'!A0", "*/ --")
MARKS = (
    "\0",
    "\x1b[2J",
    "\u202e",
    "\ufeff",
    "\u0661\u0662",
    "1\u00a0000",
    "1,000",
    "0x10",
    "1_000",
    "+1",
    "nan",
    "inf",
)
RAW = (  # JSON, and what is only almost JSON
    *NUMBERS,
    *LONG,
    *("true", "false", "null", "NaN", "Infinity", "-Infinity", "[]", "{}", "[[]]", "[1, 2]", '{"a": 1}', "[null]"),
    *(json.dumps(text) for text in (*NAMES, *MARKS)),
    *('"\\ud800"', '"\\u0000"', "[" * 100_000, "[" * 150 + "]" * 150, '{"a":' * 500 + "1" + "}" * 500, "", "'x'", "01"),
)
TOKENS = (*NUMBERS, *LONG, *MARKS, "", "-", "x" * 100_000, "R", "T", "N", "E", "end", "claim", "S")
CELLS = (*NUMBERS, *LONG, *NAMES, *MARKS, '"', '""', "'", "a\nb", "a,b", ";", "\t", "2020-01-01", "True", "1+2j", " ")


def pick(rng: Generator, values: Sequence[T]) -> T:
    """Return one of some values."""
    return values[int(rng.integers(len(values)))]


def mangled_bytes(rng: Generator, content: bytes) -> bytes:
    """Return the bytes after one to three changes that know nothing of what they mean."""
    for _ in range(int(rng.integers(1, 4))):
        content = pick(rng, (_flip, _cut, _insert, _drop, _splice, _recode))(rng, content)
    return content


def _flip(rng: Generator, content: bytes) -> bytes:
    changed = bytearray(content or b"\0")
    for _ in range(int(rng.integers(1, 5))):
        changed[int(rng.integers(len(changed)))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _cut(rng: Generator, content: bytes) -> bytes:
    return content[: int(rng.integers(len(content) + 1))]


def _insert(rng: Generator, content: bytes) -> bytes:
    at = int(rng.integers(len(content) + 1))
    return content[:at] + rng.bytes(int(rng.integers(1, 9))) + content[at:]


def _drop(rng: Generator, content: bytes) -> bytes:
    at = int(rng.integers(len(content) + 1))
    return content[:at] + content[at + int(rng.integers(1, 40)) :]


def _splice(rng: Generator, content: bytes) -> bytes:
    at, start = (int(rng.integers(len(content) + 1)) for _ in range(2))
    return content[:at] + content[start : start + int(rng.integers(1, 200))] + content[at:]


def _recode(rng: Generator, content: bytes) -> bytes:
    text = content.decode("utf-8", errors="replace")
    forms: tuple[Callable[[], bytes], ...] = (
        lambda: text.encode("utf-16"),
        lambda: b"\xef\xbb\xbf" * int(rng.integers(1, 3)) + content,
        lambda: text.replace("\n", pick(rng, ("\r\n", "\r", "\n\n", "\x85", "\x0b"))).encode(),
        lambda: content + b"\0" * int(rng.integers(1, 9)),
        lambda: content * 2,
    )
    return pick(rng, forms)()


def mangled_json(rng: Generator, content: bytes) -> bytes:
    """Return a JSON text with one to three of its values or entries changed."""
    held = json.loads(content)
    raw: dict[str, str] = {}
    for _ in range(int(rng.integers(1, 4))):
        holders = list(_holders(held))
        if holders:
            _change_entry(rng, pick(rng, holders), holders, raw)
    text = json.dumps(held)
    for mark, value in raw.items():
        text = text.replace(json.dumps(mark), value)
    return text.encode()


def _holders(value: object) -> Iterator[Holder]:
    if isinstance(value, dict | list) and value:
        yield value
        for inner in value.values() if isinstance(value, dict) else value:
            yield from _holders(inner)


def _change_entry(rng: Generator, holder: Any, holders: list[Holder], raw: dict[str, str]) -> None:
    key = pick(rng, list(holder)) if isinstance(holder, dict) else int(rng.integers(len(holder)))
    mark = f"@@{len(raw)}@@"
    action = int(rng.integers(10))
    if action < 6:
        holder[key] = mark
        raw[mark] = pick(rng, RAW)
    elif action == 6:
        del holder[key]
    elif action == 7:  # an entry that stands twice, a list with one entry more
        other = json.dumps(key) if isinstance(holder, dict) else mark
        holder.update({mark: 1}) if isinstance(holder, dict) else holder.insert(key, holder[key])
        raw[mark] = other
    elif action == 8 and isinstance(holder, dict):
        holder[pick(rng, NAMES)] = holder.pop(key)
    else:  # a value from elsewhere in the file, copied so that no circle closes
        holder[key] = json.loads(json.dumps(pick(rng, holders)))


def mangled_csv(rng: Generator, content: bytes) -> bytes:
    """Return a CSV table with one to three of its cells, columns, rows, separators or line ends changed."""
    rows = list(csv.reader(io.StringIO(content.decode("utf-8-sig"), newline="")))
    separator, end, is_quoted = ",", "\n", False
    for _ in range(int(rng.integers(1, 4))):
        action = int(rng.integers(12))
        if action < 8:
            _change_cells(rng, rows)
        elif action == 8:
            separator = pick(rng, (";", "\t", "|", " "))
        elif action == 9:
            end = pick(rng, ("\r\n", "\r", "\n\n", "\n,\n"))
        elif action == 10:
            is_quoted = True
        else:
            return _raw_cell(rng, content)
    out = io.StringIO()
    form: type[csv.Dialect] = csv.unix_dialect if is_quoted else csv.excel  # every cell quoted, or where it must be
    csv.writer(out, form, delimiter=separator, lineterminator=end).writerows(rows)
    return out.getvalue().encode("utf-8", errors="surrogatepass")


def _change_cells(rng: Generator, rows: list[list[str]]) -> None:
    row = pick(rng, rows) if rows and rng.random() < 0.8 else (rows or [[]])[0]
    action = int(rng.integers(9))
    if action < 4 and row:
        row[int(rng.integers(len(row)))] = pick(rng, CELLS)
    elif action == 4 and row:  # a column of one hostile value
        column, cell = int(rng.integers(len(row))), pick(rng, CELLS)
        for other in rows[1:]:
            other[column : column + 1] = [cell]
    elif action == 5 and row:
        del row[int(rng.integers(len(row)))]
    elif action == 6:
        row.insert(int(rng.integers(len(row) + 1)), pick(rng, CELLS))
    elif action == 7 and rows:
        del rows[int(rng.integers(len(rows)))]
    else:
        rows.insert(int(rng.integers(len(rows) + 1)), list(row))


def _raw_cell(rng: Generator, content: bytes) -> bytes:
    """Return the text with one cell overwritten as it stands, so that quoting may break."""
    cells = content.split(b",")
    cells[int(rng.integers(len(cells)))] = pick(rng, CELLS).encode("utf-8", errors="surrogatepass")
    return b",".join(cells)


def mangled_tokens(rng: Generator, content: bytes) -> bytes:
    """Return lines of tokens with one to four of them changed, most often below the header."""
    lines = content.decode("ascii", errors="replace").split("\n")
    for _ in range(int(rng.integers(1, 5))):
        first = 0 if rng.random() < 0.25 else min(5, len(lines) - 1)
        row = int(rng.integers(first, len(lines)))
        action = int(rng.integers(8))
        if action < 4:
            tokens = lines[row].split(" ")
            tokens[int(rng.integers(len(tokens)))] = pick(rng, TOKENS)
            lines[row] = " ".join(tokens)
        elif action == 4:
            lines[row : row + 1] = []
        elif action == 5:
            lines[row:row] = [lines[row]] * min(
                int(pick(rng, (1, 2, 50, 5000))), MOST_REPEATED // (1 + len(lines[row]))
            )
        elif action == 6:
            lines[row] = pick(rng, ("R 0 0", "R -1 -1", "R 1e300 0", "T 0.5", "S 0", "F 0 1", "l 0 0", "N 0 0"))
        else:
            other = int(rng.integers(first, len(lines)))
            lines[row], lines[other] = lines[other], lines[row]
        lines = lines or [""]
    return "\n".join(lines).encode()


MOST_REPEATED = 10**7
"""Characters of a line and its repetitions."""
NUMBER = re.compile(r"(?<![\w.])[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?(?![\w.])")


def mangled_numbers(rng: Generator, content: bytes) -> bytes:
    """Return a text with one to four of its numbers changed where they stand, columns kept where the new one fits."""
    text = content.decode("latin-1")
    for _ in range(int(rng.integers(1, 5))):
        found = list(NUMBER.finditer(text))
        if not found:
            return mangled_tokens(rng, content)
        old = pick(rng, found)
        new = pick(rng, (*NUMBERS, *LONG[:3], "nan", str(int(rng.integers(20))), pick(rng, found)[0], "-" + old[0]))
        text = text[: old.start()] + new.rjust(len(old[0])) + text[old.end() :]
    return text.encode("latin-1")
