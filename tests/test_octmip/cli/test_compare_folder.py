"""octmip compare of a folder: every method on every table of it."""

import json
import signal

import pandas as pd
import pytest

from octmip.trees.answer.certificate import certify

METHODS = ("--depth", 1, "--methods", "cart,exact,oct_h")


@pytest.fixture
def folder(tmp_path, data):
    """Return a folder with two tables whose last column is the label, one that is none, and a file of another kind."""
    tables = tmp_path / "tables"
    tables.mkdir()
    frame = pd.read_csv(data)[["a", "b", "y"]]
    frame.to_csv(tables / "one.csv", index=False)
    frame.rename(columns={"y": "state"}).to_csv(tables / "two.csv.gz", index=False)
    (tables / "empty.csv").write_text("a,y\n")
    (tables / "notes.txt").write_text("nothing")
    return tables


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("DATA", "--label", "y", "--out", "figures"), "--out is for a folder of tables"),
        (("TABLES", "--holdout", "0.2"), "--holdout is for one table"),
        (("EMPTY",), "holds no table; expected files that end with"),
        (("TABLES", "--label", "nobody"), "no table of"),
        (("TABLES", "--methods", "best"), "--methods names 'best'"),
    ],
)
def test_what_cannot_be_compared_is_a_sentence(folder, run, data, tmp_path, words, said):
    (tmp_path / "none").mkdir()
    places = {"DATA": data, "EMPTY": tmp_path / "none", "TABLES": folder}
    code, _, err = run("compare", *METHODS, *(places.get(word, word) for word in words))
    assert code == 2
    assert said in err


def test_after_a_signal_the_tables_that_are_known_are_shown(folder, run, monkeypatch):
    asked = []

    def signalled(problem, solution):
        if problem not in asked and asked:
            signal.raise_signal(signal.SIGINT)
        asked.append(problem)
        return certify(problem, solution)

    monkeypatch.setattr("octmip.interfaces.cli.compare_table.certify", signalled)
    code, out, _ = run("compare", folder, *METHODS, "--json")
    assert code == 0
    assert [one["table"] for one in json.loads(out)["tables"] if one["rows"]] == ["one.csv"]
