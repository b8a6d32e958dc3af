"""Text files of other programs at the doors of tables and campaigns: one truth, written as each program writes it.

The truth is one campaign of a beam whose second gauge parts the two labels. Whatever writes it, a campaign must hold
the same tests, loads and readings, and a tree of depth 1 must ask for that gauge and make no error.
"""

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from octmip.gap import read_campaign
from tests.doors.row import Refused, Row, command

N = 24
TEST = [f"t{k // 8}" for k in range(N)]
FORCE = [float(k // 8) for k in range(N)]
G1 = [round(800.0 * (k // 8) + 0.125 * (k % 8 - 3), 3) for k in range(N)]
G2 = [round(500.0 * (k // 8) - 0.25 * (k % 5) + 0.0625, 4) for k in range(N)]
STATE = ["low" if g < 400.0 else "high" for g in G2]
SECONDS = [60.0 * (k // 8) + k % 8 for k in range(N)]
CAMPAIGN = (tuple(TEST), tuple(FORCE), tuple(G1), tuple(G2))
TREE = (0, "g2")
"""Errors of the tree, and what it asks for."""


class Beam:
    """A twin of two gauges; the truth is sound."""

    gauges, parameters, effects, loads = ("g1", "g2"), (), {}, ("force",)

    def predict(self, state, force):
        return np.array([800.0, 500.0]) * force


def campaign(path: Path) -> tuple[tuple[Any, ...], ...]:
    """Return tests, loads and readings that the door of campaigns finds."""
    read = read_campaign(path, Beam())
    order = [read.gauges.index(name) for name in ("g1", "g2")]
    readings = read.readings[:, order].T
    return read.test, tuple(read.applied[:, 0].tolist()), *(tuple(row.round(9).tolist()) for row in readings)


def tree(path: Path) -> tuple[int, str]:
    """Return errors and feature of the best tree of depth 1 by the command."""
    found = json.loads(
        command("solve", path, "--label", "state", "--features", "g1,g2", "--depth", 1, "--method", "cart", "--json")
    )
    return found["errors"], found["tree"]["feature"]


def frame() -> pd.DataFrame:
    """Return the truth as a frame."""
    return pd.DataFrame({"test": TEST, "force": FORCE, "g1": G1, "g2": G2, "state": STATE})


def text(separator: str = ",", decimal: str = ".", columns: tuple[str, ...] = (), quoted: bool = False) -> str:
    """Return the truth as text."""
    buffer = io.StringIO()
    some = frame()[list(columns)] if columns else frame()
    some.to_csv(buffer, index=False, sep=separator, decimal=decimal, lineterminator="\n", quoting=int(quoted))
    return buffer.getvalue()


NAMES = ("test", "force", "state")
LINES = text().strip().split("\n")


def lines(
    *before: str, separator: str = ",", names: str = "", units: str = "", after: str = "", decimal: str = "."
) -> str:
    """Return the truth with other lines above it, other names, units below them and words after the end."""
    header, body = text(separator, decimal).split("\n", 1)
    return "\n".join([*before, names or header, *([units] if units else []), body]) + after


def kept(content: str, encoding: str = "utf-8") -> Callable[[Path], Path]:
    """Return what writes a content into a folder."""

    def make(folder: Path) -> Path:
        (folder / "data.csv").write_bytes(content.encode(encoding))
        return folder / "data.csv"

    return make


def _polars(folder: Path) -> Path:
    polars = pytest.importorskip("polars")
    polars.DataFrame(frame().to_dict("list")).write_csv(folder / "data.csv")
    return folder / "data.csv"


def _arrow(folder: Path) -> Path:
    arrow, csv = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.csv")
    csv.write_csv(arrow.Table.from_pandas(frame(), preserve_index=False), folder / "data.csv")
    return folder / "data.csv"


def _parquet(folder: Path) -> Path:
    pytest.importorskip("pyarrow")
    frame().to_parquet(folder / "data.parquet")
    return folder / "data.parquet"


def _duckdb(folder: Path) -> Path:
    duckdb = pytest.importorskip("duckdb")
    truth = frame()
    assert len(truth)  # DuckDB finds the frame by its name
    duckdb.sql("select * from truth").write_csv(str(folder / "data.csv"))
    return folder / "data.csv"


def _savetxt(folder: Path) -> Path:
    cells = frame().astype(str).to_numpy()
    np.savetxt(folder / "data.csv", cells, fmt="%s", delimiter=",", header=",".join(frame().columns))
    return folder / "data.csv"


def _pandas(**settings: Any) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        frame().to_csv(folder / "data.csv", **settings)
        return folder / "data.csv"

    return make


def _toa5(n: int = 1) -> str:
    """Return the truth as a Campbell logger's table of TOA5, n times joined."""
    head = [
        '"TOA5","CR1000","CR1000","1031","CR1000.Std.32","CPU:Beam.CR1","4062","Strain"',
        '"TIMESTAMP","RECORD","test","force","g1","g2","state"',
        '"TS","RN","","N","microstrain","microstrain",""',
        '"","","Smp","Avg","Avg","Avg","Smp"',
    ]
    rows = [
        f'"2026-01-01 00:{s // 60:02.0f}:{s % 60:02.0f}",{k},"{t}",{f},{a},{b},"{y}"'
        for k, (s, t, f, a, b, y) in enumerate(zip(SECONDS, TEST, FORCE, G1, G2, STATE, strict=True))
    ]
    size = N // n
    return "\n".join(line for k in range(n) for line in [*head, *rows[k * size : (k + 1) * size]]) + "\n"


def _labview(decimal: str = ".") -> str:
    """Return the truth as a LabVIEW measurement file."""
    head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", f"Decimal_Separator\t{decimal}"]
    head += ["Multi_Headings\tNo", "X_Columns\tNo", "Time_Pref\tAbsolute", "Date\t2026/01/01", "Time\t10:00:00,5"]
    head += ["***End_of_Header***\t", "", "Channels\t4", "Samples\t24\t24\t24\t24", "Date\t" + "2026/01/01\t" * 4]
    head += ["X_Dimension\t" + "Time\t" * 4, "X0\t" + "0,0E+0\t" * 4, "Delta_X\t" + "1,0\t" * 4, "***End_of_Header***"]
    header, body = text("\t", decimal).split("\n", 1)
    return "\r\n".join([*head, header + "\tComment", *body.strip().split("\n")]) + "\r\n"


def _catman() -> str:
    """Return the truth as HBM's catman exports it: names, then lines about each channel, an empty line, readings."""
    head = [
        "HBM catman",
        "File: BEAM.BIN",
        "Date: 01.03.2026",
        "Operator:\tN. N.",
        "Channels: 5",
        "Length: 24",
        "Rate: 50 Hz",
    ]
    header, body = text("\t", ",").split("\n", 1)
    about = ["\t".join(["", "N", "µm/m", "µm/m", ""]), "\t".join(["-", *["Rate 50 Hz"] * 3, "-"])]
    about += ["\t".join(["none", *[f"Gauge {k}" for k in range(3)], "none"])]
    return "\n".join([*head, "", header, *about, "", body])


def _joined(units: str) -> str:
    """Return the truth as two files, the second with its columns the other way round, units under both headers."""
    top, *rows = text().strip().split("\n")
    again = [",".join(row.split(",")[::-1]) for row in (top, units, *rows[10:])]
    return "\n".join([top, units, *rows[:10], *again]) + "\n"


def _numbers(cell: str, group: str, decimal: str, separator: str) -> str:
    """Return the truth with numbers of grouped digits."""
    marks = str.maketrans({",": group, ".": decimal})
    rows = [
        separator.join([t, *(cell.format(f"{x:,.4f}".translate(marks)) for x in (f, a, b)), y])
        for t, f, a, b, y in zip(TEST, FORCE, G1, G2, STATE, strict=True)
    ]
    return "\n".join([separator.join(("test", "force", "g1", "g2", "state")), *rows]) + "\n"


R_NAMES = "\n".join(
    [" ".join(f'"{n}"' for n in frame().columns)]
    + [
        f'"{k + 1}" "{t}" {f:g} {a} {b} "{y}"'
        for k, (t, f, a, b, y) in enumerate(zip(TEST, FORCE, G1, G2, STATE, strict=True))
    ]
)
BLANKS = "\n".join(
    ["  test  force        g1        g2  state"]
    + [f"{t:>6} {f:>6.1f} {a:>9.3f} {b:>9.4f} {y:>6}" for t, f, a, b, y in zip(TEST, FORCE, G1, G2, STATE, strict=True)]
)
FORTRAN = "test,force,g1,g2,state\n" + "".join(
    f"{t},{f:.1f}D0,{a / 1e3:.7f}D+03,{b / 1e-2:.5f}d-02,{y}\n".replace("D0,", "D+00,", 1)
    for t, f, a, b, y in zip(TEST, FORCE, G1, G2, STATE, strict=True)
)
BOX = "".join(f"| {row} |\n" for row in text("|").strip().split("\n"))
BOX = "+---+---+\n" + BOX.replace("\n", "\n+---+---+\n", 1) + "+---+---+\n24 rows in set (0.01 sec)\n"
WITH_UNITS = "test,force,g1 [microstrain],g2 (µm/m),state"
DASHES = text("|").replace("\n", "\n" + "+".join("-" * 6 for _ in range(5)) + "\n", 1)
MARKDOWN = "".join(f"| {row} |\n" for row in text("|").strip().split("\n")).replace(
    "\n", "\n|:---|---:|---:|---:|:---|\n", 1
)
MADE: dict[tuple[str, str], Callable[[Path], Path]] = {
    ("pandas", "to_csv with its index"): _pandas(),
    ("pandas", "semicolons and decimal commas"): _pandas(sep=";", decimal=",", index=False),
    ("pandas", "tabs and decimal commas"): _pandas(sep="\t", decimal=",", index=False),
    ("pandas", "UTF-16"): _pandas(encoding="utf-16", index=False),
    ("pandas", "every cell quoted"): _pandas(quoting=1, index=False),
    ("pandas", "Parquet"): _parquet,
    ("polars", "write_csv"): _polars,
    ("pyarrow", "write_csv"): _arrow,
    ("DuckDB", "write_csv"): _duckdb,
    ("NumPy", "savetxt, the header a comment"): _savetxt,
    ("R 4.3, kept", "write.table, names of rows"): kept(R_NAMES),
    ("R 4.3, kept", "write.csv2, names of rows"): kept(
        '"";'
        + "\n".join(f'"{k}";{row}' if k else row for k, row in enumerate(text(";", ",").strip().split("\n")))
        + "\n"
    ),
    ("Excel, kept", "sep=; and commas at the ends of lines"): kept("sep=;\r\n" + text(";", ",").replace("\n", ";\r\n")),
    ("Excel, kept", "a title, and its line filled with commas"): kept(lines("Beam 5,,,,", "Operator,N. N.,,,")),
    ("Excel for Macintosh, kept", "carriage returns"): kept(text().replace("\n", "\r")),
    ("Campbell TOA5, kept", "four lines of header"): kept(_toa5()),
    ("Campbell TOA5, kept", "three files joined"): kept(_toa5(3)),
    ("LabVIEW 2020 LVM, kept", "two headers, a column Comment"): kept(_labview()),
    ("LabVIEW 2020 LVM, kept", "decimal commas"): kept(_labview(",")),
    ("HBM catman 5, kept", "lines about each channel"): kept(_catman(), "latin-1"),
    ("a logger, kept", "comments of four kinds"): kept(lines("# rate 100 Hz", "% x", "// y", "; z", after="# end\n")),
    ("a logger, kept", "a comment between rows"): kept(text().replace("t1,", "# pause\nt1,", 1)),
    ("a logger, kept", "title lines and empty lines"): kept(lines("Logger 7", "", "Serial 1234, Beam", "")),
    ("a logger, kept", "words at the end"): kept(lines(after="End of data\n\n")),
    ("a logger, kept", "the header again"): kept(text().replace("t1,", f"{text().split(chr(10))[0]}\nt1,", 1)),
    ("a logger, kept", "blanks as separators"): kept(BLANKS),
    ("a logger, kept", "a line of dashes under the header"): kept(DASHES),
    ("a logger, kept", "blocks of a fixed size, filled with Ctrl-Z and zeros"): kept(text() + "\x1a" + "\0" * 20),
    ("Markdown, kept", "a rule that says how columns are aligned"): kept(MARKDOWN),
    ("LibreOffice, kept", "the minus of typesetters"): kept(text(";", ",").replace(";-", ";\u2212")),
    ("a logger, kept", "CRLF and empty lines"): kept(text().replace("\n", "\r\n\r\n")),
    ("Fortran, kept", "exponents with D"): kept(FORTRAN),
    ("a logger, kept", "UTF-16 without a byte-order mark"): kept(text(), "utf-16-le"),
    ("cmd's copy, kept", "two files joined, each with a byte-order mark"): kept(
        "\ufeff" + text().replace("t1,", "\ufefft1,", 1)
    ),
    ("a logger, kept", "a row Unit with brackets"): kept(lines(units="Unit,(N),(microstrain),(um/m),")),
    ("a logger, kept", "serial numbers above the units"): kept(
        lines(units="S/N,1044,2231,2232,\nUnit,N,microstrain,um/m,")
    ),
    ("a logger, kept", "joined files, columns in another order"): kept(_joined(",N,microstrain,um/m,")),
    ("pandas", "to_string, names of rows from 0"): lambda folder: kept(frame().to_string())(folder),
    ("MySQL 8, kept", "a box of bars, and words below it"): kept(BOX),
    ("Excel, kept", "decimal commas in quotes"): kept(_numbers('"{}"', ",", ".", ",")),
    ("Excel, kept", "groups of digits and decimal commas"): kept(_numbers("{}", ".", ",", ";")),
    ("a logger, kept", "a separator at the ends of rows alone"): kept(
        text().replace("\n", ",\n").replace(",\n", "\n", 1)
    ),
    ("a logger, kept", "blanks at the ends of cells"): kept(text().replace("low\n", "low \n", 3).replace(",", " , ")),
    ("psql, kept", "columns aligned, the number of rows below"): kept(
        text("|").replace("|", " | ").replace("\n", "\n---+---+---+---+---\n", 1).replace("\nt", "\n t")
        + "(24 rows)\n\n"
    ),
    ("Graphtec GL840, kept", "settings above, NO. and Time among the units"): kept(
        lines(
            "Vendor,GRAPHTEC Corporation",
            "CH,Signal name,Input,Range,Filter,Span",
            'CH1,"force",DC,20mV,Off,2.0,0.0,N',
            "Data",
            units="NO.,N,microstrain,um/m,Time",
        )
    ),
    ("SQLite 3, kept", "columns under short lines"): kept(
        text(" ", columns=("g1", "g2", *NAMES)).replace("\n", "\n-- -- ---- ----- -----\n", 1)
    ),
    ("DuckDB's shell, kept", "a box with types"): kept(
        "\n".join(["┌──┬──┐", LINES[0], "varchar│double│double│double│varchar", "├──┼──┤", *LINES[1:], "└──┴──┘"])
        .replace(",", " │ ")
        .replace("\nt", "\n│ t")
    ),
    ("Orange 3, kept", "rows of types and roles"): kept(
        lines(units="discrete,continuous,continuous,continuous,discrete\n,,,,class")
    ),
    ("LibreOffice, kept", "Swiss groups of digits"): kept(_numbers("{}", "'", ".", ";")),
}
ROWS = [
    *(Row("octmip diagnose CAMPAIGN", *key, make, campaign, CAMPAIGN) for key, make in MADE.items()),
    *(Row("octmip solve TABLE", *key, make, tree, TREE) for key, make in MADE.items()),
]
UNITS = {
    "units behind the names": (WITH_UNITS, 1.0),
    "units over a stroke": ("test,force/N,g1/Microstrain,g2/(um/m),state", 1.0),
    "units behind dashes": ("test,force - N,g1 \u2013 microstrain,g2 - um/m,state", 1.0),
    "units behind colons and low lines": ("test,force_N,g1: microstrain,g2_um/m,state", 1.0),
    "millistrain behind a comma": ('test,force,"g1, millistrain","g2, mm/m",state', 1e-3),
    "units above the names": (",N,millistrain,mm/m,\ntest,force,g1,g2,state", 1e-3),
    "strain for microstrain": ("test,force [N],g1 [m/m],g2 [m/m],state", 1e-6),
    "per cent for microstrain": ("test,force,g1 (%),g2 (%),state", 1e-4),
}


def _scaled(names: str, factor: float) -> str:
    rows = [
        f"{t},{f},{a * factor!r},{b * factor!r},{y}" for t, f, a, b, y in zip(TEST, FORCE, G1, G2, STATE, strict=True)
    ]
    return "\n".join([names, *rows]) + "\n"


ROWS += [
    Row("octmip diagnose CAMPAIGN", "a logger, kept", case, kept(_scaled(*made)), campaign, CAMPAIGN)
    for case, made in UNITS.items()
]
REFUSED = {
    "units that change where files were joined": (
        _joined(",N,microstrain,um/m,").replace(",um/m,microstrain,N,", ",m/m,m/m,N,"),
        ("line 14", "the units of the columns are others", "its own file"),
    ),
    "another quantity": (
        _scaled("test,force,g1 [mm],g2,state", 1.0),
        ("column g1 is in 'mm'", "expected microstrain", "convert the column"),
    ),
    "an unknown unit": (_scaled("test,force,g1 [kp],g2,state", 1.0), ("column g1 is in 'kp'", "correct its unit")),
    "a row that was cut": (text()[:-8], ("line 25: 4 cells but the header has 5",)),
    "a comment that may be a row": (text().replace("t1,", "#t1,", 1), ("line 10 begins with '#t'", "delete the line")),
    "two separators": (text().replace("\n", "\n", 1) + text(";").split("\n", 1)[1], ("between semicolons",)),
    "a character of zero": (text().replace("t1", "t1\0", 1), ("line 10 holds a NUL", "write the file again")),
    "an archive under the name of a text": ("PK\x03\x04" + "\x01" * 40, ("is an archive", "export the table as CSV")),
    "JSON under the name of a text": (json.dumps(frame().to_dict("records")), ("is JSON", "export the table as CSV")),
    "a page under the name of a text": (frame().to_html(), ("is a page", "export the table as CSV")),
    "ARFF": ("% x\n@RELATION beam\n@ATTRIBUTE g1 REAL\n@DATA\n1\n", ("is ARFF", "export the table as CSV")),
    "LIBSVM": ("+1 1:0.5 3:1\n-1 2:1\n", ("sparse rows of LIBSVM", "export the table as CSV")),
    "a name with other marks": (_scaled("test,force,g(1),g2,state", 1.0), ("'g(1)'", "write 'g1'")),
    "a binary file": ("RIFF\x10\x00\x00WAVEfmt ", ("no text but a binary file", "export the table as CSV")),
    "another column than names": (
        text().replace("force,", "force,more,", 1),
        ("line 2", "5 cells but the header has 6"),
    ),
    "no header": (
        text().split("\n", 1)[1],
        ("line 1: the header is a row like those below it, 't0'", "put one above it"),
    ),
    "a statistic below the rows": (text() + "Average,1,800,500,\n", ("'Average'", "delete the row")),
    "a name nearly the twin's": (_scaled("test,force,G1,g2,state", 1.0), ("'G1'", "write 'g1'")),
    "thousands of ambiguous commas": (
        "test\tforce\tg1\tg2\n" + "".join(f"t{k}\t{k}\t1,80{k}\t500\n" for k in range(9)),
        ("column g1 holds '1,80", "may be 180", "write the numbers without marks"),
    ),
}
ROWS += [
    Row("octmip diagnose CAMPAIGN", "a logger, kept", case, kept(content), campaign, Refused(words))
    for case, (content, words) in REFUSED.items()
]
