"""Names as a person sees them: nothing acts, nothing hides, different names stay different."""

import csv
import io
import json

import pytest

from octmip.input.names import html_text, shown, visible, visible_lines
from octmip.interfaces.cli import main
from tests.oracles.hostile_names import hostile_names

NAMES = [name for _, name in hostile_names(500)]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("g01", "g01"),
        ("mu\u00e9 1", "mu\u00e9 1"),
        ("\u4f60\u597d", "\u4f60\u597d"),
        ("C:\\temp", "C:\\temp"),
        ("\x1b[2J", "\\x1b[2J"),
        ("\\x1b[2J", "\\\\x1b[2J"),
        ("a\nb", "a\\x0ab"),
        ("\u202egnp.exe", "\\u202egnp.exe"),
        ("a\u200bb", "a\\u200bb"),
        ("\ud800", "\\ud800"),
        ("\U000e0001", "\\U000e0001"),
        ("\u3164", "\\u3164"),
        ("", '""'),
        (" a", '" a"'),
        ("\u05d0", "\u2068\u05d0\u2069"),
        (7, "7"),
    ],
)
def test_a_name_is_shown_as(name, words):
    assert shown(name) == words


def test_different_names_are_shown_differently_and_in_utf_8():
    assert len({shown(name) for name in NAMES}) == len(NAMES)
    assert all("\n" not in shown(name).encode().decode() for name in NAMES)


def test_what_is_visible_stays_and_isolates_must_be_closed():
    assert all(visible(shown(name)) == shown(name) for name in NAMES)
    assert visible("a\u2068b") == "a\\u2068b"
    assert visible("\u2069\u2068b\u2069") == "\\u2069\u2068b\u2069"
    assert visible_lines("a\x1b\nb\r") == "a\\x1b\nb\\x0d"
    assert html_text('<a title="\x07">') == "&lt;a title=&quot;\\x07&quot;&gt;"


def hostile_file(tmp_path, name):
    """Return a tree file whose feature and one class have this name, and a table that it can read."""
    table, tree = tmp_path / "t.csv", tmp_path / "t.json"
    table.write_text("a,y\n" + "".join(f"{k},{'low' if k < 6 else 'high'}\n" for k in range(12)))
    words = ["solve", str(table), "--label", "y", "--depth", "1", "--method", "cart", "--out", str(tree)]
    assert main(words) == 0
    content = json.loads(tree.read_text())
    content["tree"]["left"]["label"] = name
    content["class_names"] = [name if label == "low" else label for label in content["class_names"]]
    content["solution"]["solver"] = f"cart {name}"
    tree.write_text(json.dumps(content))
    return str(tree), str(table)


@pytest.mark.parametrize("name", ["\x1b[2J\x1b]0;x\x07", "\u202ea", "a\rb", "```", "\u2028"])
def test_a_terminal_meets_no_character_that_acts(tmp_path, capsys, name):
    tree, table = hostile_file(tmp_path, name)
    capsys.readouterr()
    assert main(["report", tree]) == 0
    out = capsys.readouterr().out
    assert shown(name) in out
    assert all(line.isprintable() for line in out.split("\n"))
    for kind in ("md", "html", "txt", "svg"):
        assert main(["report", tree, "--out", str(tmp_path / f"r.{kind}")]) == 0
        text = (tmp_path / f"r.{kind}").read_text(encoding="utf-8")
        assert all(line.isprintable() for line in text.split("\n"))
    assert main(["certify", tree, f"{table}\x1b[2J"]) == 2
    err = capsys.readouterr().err
    assert "\\x1b[2J" in err
    assert err.count("\n") == 1
    assert err.rstrip("\n").isprintable()


def test_predictions_are_read_back_as_the_names_that_were_trained_on(tmp_path, capsys):
    names = ["a\rb", 'q"uote', "=cmd|' /C calc'!A0", "a,b", "a\nb", "", " x ", "\x1b[0m"]
    for name in names:
        tree, table = hostile_file(tmp_path, name)
        out = tmp_path / "p.csv"
        assert main(["predict", tree, table, "--out", str(out), "--proba"]) == 0
        with out.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        assert [row[0] for row in rows[1:]] == [name] * 6 + ["high"] * 6
        assert f"share of {name}" in rows[0]


def test_half_of_a_surrogate_pair_ends_in_a_sentence(tmp_path, capsys):
    tree, table = hostile_file(tmp_path, "a\ud800")
    for words in (["predict", tree, table], ["report", tree], ["certify", tree, table]):
        capsys.readouterr()
        assert main(words) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert "ud800" in err
        assert err.count("\n") == 1
        assert err.isascii()


def test_an_output_that_cannot_show_a_name_is_one_sentence(tmp_path, capsys, monkeypatch):
    tree, _ = hostile_file(tmp_path, "\u00e9")
    monkeypatch.setattr("sys.stdout", io.TextIOWrapper(io.BytesIO(), encoding="ascii"))
    assert main(["report", tree]) == 1
    err = capsys.readouterr().err
    assert "PYTHONIOENCODING=utf-8" in err
    assert err.count("\n") == 1
