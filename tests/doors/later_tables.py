"""Tables that a tree meets later: the same column as another program writes it, or as a part of a table shows it.

Each value of a column of texts goes with one value of another column, so a tree of depth 2 makes no error, whatever
the later table holds of them.
"""

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import pandas as pd
import pytest

from tests.doors.row import Refused, Row, command
from tests.doors.texts import kept

TEXTS: dict[str, tuple[tuple[str, ...], tuple[tuple[object, ...], ...]]] = {
    "Booleans beside a word": (("True", "False", "unknown"), (("True", "False"), ("true", "false"), (True, False))),
    "Booleans in capitals": (("TRUE", "FALSE", "n. a."), (("TRUE", "FALSE"), (True, False))),
    "numbers beside a word": (("1", "2", "x"), (("1", "2"), ("1.0", "2.0"), (1, 2))),
    "codes with zeros": (("01", "02", "x"), (("01", "02"), (1.0, 2.0))),
    "accents behind letters": (("Ba\u0308r", "Wal", "Hai"), (("B\u00e4r", "Wal"),)),
    "blanks at the ends": (("steel ", "wood", "brass"), (("steel", "wood   "),)),
    "blanks of web pages at the ends": (("steel\u00a0", "wood", "brass"), (("steel", "wood\u00a0"),)),
}
"""What a column holds in training, and what may stand for its first two values later."""
OTHER = ("p", "q", "r")
Paths = tuple[Path, Path]


def written(folder: Path, name: str, frame: pd.DataFrame, **settings: bool) -> Path:
    """Write a frame as text where all of its cells are texts, as Parquet where they have types of their own."""
    if all(isinstance(cell, str) for cell in frame.to_numpy().ravel()):
        frame.to_csv(folder / f"{name}.csv", index=False)
        return folder / f"{name}.csv"
    pytest.importorskip("pyarrow")
    frame.to_parquet(folder / f"{name}.parquet", **settings)
    return folder / f"{name}.parquet"


def pair(column: str, trained: Sequence[str], later: Sequence[object], folder: Path) -> Paths:
    """Write the rows of a training, and rows with its first two values alone."""
    other = "state" if column == "x" else "x"
    frames = [pd.DataFrame({column: [*own] * 12, other: [*OTHER[: len(own)]] * 12}) for own in (trained, later)]
    return written(folder, "train", frames[0]), written(folder, "later", frames[1])


def errors(paths: Paths) -> int:
    """Return the errors of the first table's tree on the second."""
    tree = paths[0].with_name("tree.json")
    command("solve", paths[0], "--label", "state", "--depth", 2, "--out", tree)
    return int(json.loads(command("predict", tree, paths[1], "--label", "state", "--json"))["errors"])


def of(values: Sequence[object], **settings: bool) -> Callable[[Path], Path]:
    """Return what writes a table of these classes, with an index that has a name."""
    frame = pd.DataFrame({"x": range(6), "state": [*values] * 3}, index=pd.Index(range(6), name="sample"))
    return lambda folder: written(folder, "data", frame, **settings)


def named_text(folder: Path) -> Path:
    return of("ab")(folder).rename(folder / "data.csv")


def notes(path: Path) -> list[str]:
    found = json.loads(command("solve", path, "--label", "state", "--depth", 1, "--method", "cart", "--json"))["notes"]
    return [note.replace(str(path), "it") for note in found]


def in_units(trained: str, later: str, folder: Path) -> Paths:
    """Write the same rows twice, with another row of units below the names where it is not empty."""
    rows = "".join(f"{k},{'pq'[k > 5]}\n" for k in range(12))
    for name, unit in (("train", trained), ("later", later)):
        (folder / f"{name}.csv").write_text("x,state\n" + f"{unit},\n" * bool(unit) + rows)
    return folder / "train.csv", folder / "later.csv"


LEFT_OUT = ["'sample' of it names the rows, as pandas says in it, and is left out"]
NUMBERS = kept("0.5,2,state\n" + "".join(f"{k},{k},{'ab'[k > 5]}\n" for k in range(12)))
ROW = "names in line 1 are numbers; if it is a row, put a line with names above it"
ROWS = [
    Row(
        f"octmip predict, {column}", "pandas", f"{case}, then {later}", partial(pair, column, trained, later), errors, 0
    )
    for case, (trained, every) in TEXTS.items()
    for later in every
    for column in ("x", "state")
]
TRUTHS = ("TRUE", "FALSE", "NA"), ("true", "false", "missing"), ("True", "False", "None"), (True, False, None)
ROWS += [
    Row("octmip predict, x", "R, Julia, pandas", f"{one}, then {two}", partial(pair, "x", one, two), errors, 0)
    for one in TRUTHS
    for two in TRUTHS
]
NO_LABEL = partial(pair, "state", ("TRUE", "FALSE", "NA"), ("TRUE", "FALSE"))
ROWS += [
    Row("octmip solve", "R", "a label of NA", NO_LABEL, errors, Refused(("'NA' among true and false", "12 such"))),
    Row("octmip solve", "pandas", "an index with a name", of("ab", index=True), notes, LEFT_OUT),
    Row("octmip solve", "pandas", "an index without a name", of("ab", index=False), notes, []),
    Row(
        "octmip solve", "Hive", "classes of bytes", of([b"a", b"b"]), notes, Refused(("b'a'", "of type bytes", "text"))
    ),
    Row("octmip solve", "pandas", "names that are numbers", NUMBERS, notes, [ROW]),
    Row("octmip solve", "pandas", "classes of lists", of([[1], [2]]), notes, Refused(("[1]", "row 1", "a text"))),
    Row("octmip solve", "pandas", "Parquet named .csv", named_text, notes, Refused(("is a Parquet file", "rename it"))),
]
IN_UNITS: dict[tuple[str, str], object] = {
    ("mm", "mm"): 0,
    ("mm", ""): 0,
    ("microstrain", "um/m"): 0,
    ("mm", "m"): Refused(("column 'x' is in 'm'; expected 'mm'", "convert the column")),
    ("N", "mm"): Refused(("column 'x' is in 'mm'; expected 'N'",)),
}
ROWS += [
    Row("octmip predict", "a logger", f"units {a}, then {b or 'none'}", partial(in_units, a, b), errors, right)
    for (a, b), right in IN_UNITS.items()
]
