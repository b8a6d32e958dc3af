"""What a program adds to a table does not change it: any mixture of the habits of `texts` is read as the truth."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.formats.table import read_table
from octmip.gap import read_campaign
from tests.doors.texts import CAMPAIGN, FORCE, G1, G2, STATE, TEST, Beam, N, campaign

NAMES = ("test", "force", "g1", "g2", "state")


def written(rng: np.random.Generator) -> tuple[bytes, tuple[str, ...]]:
    """Return the truth with some habits of programs, and what the notes must say."""
    separator = str(rng.choice([",", ";", "\t", "|"]))
    decimal = "," if separator in ";\t" and rng.random() < 0.5 else "."
    end = str(rng.choice(["\n", "\r\n", "\r"]))
    order = rng.permutation(len(NAMES))
    quote = '"{}"'.format if rng.random() < 0.3 else str
    tail = separator if rng.random() < 0.3 else ""

    def line(cells: list[str]) -> str:
        return separator.join(quote(cells[k]) for k in order) + tail

    header = line(list(NAMES))
    rows = []
    for row in zip(TEST, FORCE, G1, G2, STATE, strict=True):
        rows.append(line([cell if isinstance(cell, str) else repr(cell).replace(".", decimal) for cell in row]))
    lines, told = [header], []
    if rng.random() < 0.4:
        lines.append(line(["", "N", "microstrain", "um/m", ""]))
        told.append("with the units")
    cut = int(rng.integers(1, N))
    lines += rows[:cut]
    if rng.random() < 0.4:
        lines += [*lines[: len(lines) - cut]]
        told.append("with the header again")
    lines += rows[cut:]
    if rng.random() < 0.4:
        lines = ["Logger 7", f"Serial number{separator}1234", *([""] if rng.random() < 0.5 else []), *lines]
        told.append("above the header")
    if rng.random() < 0.4:
        at = int(rng.integers(len(lines)))
        lines.insert(at, str(rng.choice(["# pause", "% pause", "// pause"])))
        told.append("of comment")
    if rng.random() < 0.3:
        lines += ["End of data", "Recorder stopped"][: int(rng.integers(1, 3))]
        told.append("after the last row")
    content = end.join([*lines, ""])
    return content.encode(str(rng.choice(["utf-8", "utf-8-sig", "utf-16", "cp1252"]))), tuple(told)


@pytest.mark.parametrize("seed", range(40))
def test_any_mixture_of_habits_is_read_as_the_truth_and_said(seed: int, tmp_path: Path) -> None:
    content, told = written(np.random.default_rng([23, seed]))
    (tmp_path / "run.csv").write_bytes(content)
    assert campaign(tmp_path / "run.csv") == CAMPAIGN
    notes = " ".join(read_campaign(tmp_path / "run.csv", Beam()).notes)
    assert [words for words in told if words not in notes] == []


@pytest.mark.parametrize("seed", range(20))
def test_a_row_that_lost_cells_is_never_left_out_in_silence(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng([24, seed])
    content, _ = written(rng)
    text = (
        content.decode("utf-8-sig", errors="replace")
        if not content.startswith(b"\xff\xfe")
        else content.decode("utf-16")
    )
    ends = [k for k in range(len(text)) if text[k] in "\r\n"]
    rows = [k for k, stop in enumerate(ends[1:]) if any(t in text[ends[k] : stop] for t in ("t0", "t1", "t2"))]
    k = int(rng.choice(rows))
    begin, stop = ends[k] + 1, ends[k + 1]
    cut = int(rng.integers(begin + 1, stop))
    (tmp_path / "run.csv").write_text(text[:cut] + text[stop:], newline="")
    try:
        found = campaign(tmp_path / "run.csv")
    except ValueError:
        return
    same = [a == b for a, b in zip(zip(*found, strict=True), zip(*CAMPAIGN, strict=True), strict=True)]
    assert len(found[0]) == N
    assert sum(same) >= N - 1


WAYS = {
    "PostgreSQL's COPY, MySQL, Hive": "\\N",
    "Excel": "#DIV/0!",
    "Excel in German": "#WERT!",
    "Excel in French": "#NOM?",
    "Excel in Spanish": "#¡VALOR!",
    "R": "NA",
    "Minitab": "*",
    "Abaqus": "NoValue",
    "HOBOware": "-----",
    "SQL Server": "NULL",
}


@pytest.mark.parametrize("word", WAYS.values(), ids=list(WAYS))
def test_a_cell_that_other_programs_leave_out_is_missing_among_numbers(word: str, tmp_path: Path) -> None:
    rows = [f"{word if k % 4 == 0 else k},{k % 2}" for k in range(40)]
    (tmp_path / "data.csv").write_text("\n".join(["a,y", *rows]), encoding="utf-8")
    frame = read_table(tmp_path / "data.csv").frame[["a"]]
    features = Columns.learn(frame).encode(frame)[:, 0]
    assert np.isnan(features).tolist() == [k % 4 == 0 for k in range(40)]


def test_a_column_of_numbers_and_many_words_is_refused_by_its_words() -> None:
    rows = [f"{'<0.1' if k % 4 == 0 else k}" for k in range(60)]
    with pytest.raises(DataError, match="holds 45 different numbers, and texts such as '<0\\.1'"):
        Columns.learn(pd.DataFrame({"a": rows}))


def test_a_comment_that_is_indented_stands_above_a_header(tmp_path: Path) -> None:
    rows = [f"{k} {k % 7} {k % 2}" for k in range(30)]
    (tmp_path / "data.txt").write_text("\n".join(["  # logger 7", "a b y", *rows, ""]))
    assert read_table(tmp_path / "data.txt").frame.shape == (30, 3)
