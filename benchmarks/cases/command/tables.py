"""Every table of ../shared/uci by one command: what a stranger gets who prepares no file.

    octmip solve NAME.csv --label class --depth 2 --holdout 0.25 --seconds 20 --json

A table whose first command is refused is solved by the switch that the refusal names, listed in `SWITCHES`; the first
sentence is kept beside it. Nothing is asked of the tables but what the command itself found.
"""

import contextlib
import io
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from benchmarks.data import SHARED
from benchmarks.tables import Line, markdown
from octmip.formats.columns.cells import read_cells
from octmip.formats.table import read_table
from octmip.interfaces.cli import main

SWITCHES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "cylinder-bands": ("--index", "cylinder_number"),
        "echocardiogram": ("--drop-unlabelled",),
        "skin-segmentation": ("--label", "skin"),
        "splice": ("--index", "Instance_name"),
        "zoo": ("--index", "animal"),
    }
)
"""What the first refusal's own sentence names, by table."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield what became of each table; `limit` seconds for each, at most 20."""
    for path in sorted((SHARED / "uci").glob("*.csv")):
        yield outcome(path, min(limit, 20.0), max(threads))


def outcome(path: Path, seconds: float, threads: int = 1) -> Line:
    """Return what became of a table."""
    words = ["solve", str(path), "--label", "class", "--depth", "2", "--holdout", "0.25"]
    words += ["--seconds", f"{seconds:g}", "--threads", str(threads), "--json"]
    start = time.perf_counter()
    code, out, refusal = called(words)
    switches = SWITCHES.get(path.stem, ()) if code else ()
    if switches:
        code, out, _ = called([*words, *switches])
    line: Line = {"size": path.stem, "seed": 0, "limit": seconds, "switches": list(switches), **facts(path)}
    line |= {"refusal": refusal if switches or code else "", "outcome": "refused" if code else "solved"}
    if code:
        return line
    found = json.loads(out)
    return line | {
        "wall_seconds": round(time.perf_counter() - start, 2),
        "objective": found["objective"],
        "bound": found["bound"],
        "gap": found["gap"],
        "outcome": "proven" if found["is_optimal"] else "not proven",
        "version": found["version"],
        **{name: found[name] for name in ("errors", "n_samples", "held_out", "cart")},
    }


def called(words: Sequence[str]) -> tuple[int, str, str]:
    """Run a command and return its exit code, standard output and standard error."""
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        code = main(list(words))
    return code, out.getvalue(), err.getvalue().strip()


def facts(path: Path) -> Line:
    """Return rows, columns, columns of text and missing cells ("?" too) of a table, its label (the last) aside."""
    frame = read_table(path).frame
    cells = [read_cells(frame.iloc[:, k]) for k in range(frame.shape[1] - 1)]
    return {
        "rows": len(frame),
        "columns": len(cells),
        "text_columns": sum(column.is_text for column in cells),
        "missing_cells": sum(column.n_missing + int((column.words == "?").sum()) for column in cells),
    }


def summary(lines: Sequence[Line]) -> str:
    """Return what became of the tables, a row each, in Markdown."""
    head = ("table", "rows", "columns", "text", "missing", "switch", "CART → tree, training", "held out", "proven", "s")
    return markdown(head, map(_row, lines))


def _row(line: Line) -> tuple[str, ...]:
    sizes = [f"{line[name]:,}" for name in ("rows", "columns", "text_columns", "missing_cells")]
    switch = f"`{' '.join(line['switches'])}`" if line["switches"] else ""
    if line["outcome"] == "refused":
        return (line["size"], *sizes, switch, "", "", "refused", "")
    cart, held = line["cart"], line["held_out"]
    training = f"{cart['training']['errors']} → {line['errors']} of {line['n_samples']:,}"
    held_out = f"{cart['held_out']['errors']} → {held['errors']} of {held['n_samples']:,}"
    proven = "yes" if line["outcome"] == "proven" else f"gap {100 * line['gap']:.0f} %"
    return (line["size"], *sizes, switch, training, held_out, proven, f"{line['wall_seconds']:.1f}")
