"""The octmip command on tables as they come: text, missing readings, names of rows, quoted names, numbers as labels."""

import gzip
import io
import json
import signal

import numpy as np
import pandas as pd
import pytest

from octmip.formats.tree_file import read_tree_file
from octmip.trees.answer.certificate import certify


@pytest.fixture
def survey(tmp_path):
    """Return a table with index, text, missing readings, a comma in a name, and a label that colour and age decide."""
    rng = np.random.default_rng(1)
    colour, age = rng.choice(["red", "green", "blue"], 80), rng.integers(20, 70, 80).astype(float)
    age[::9] = np.nan
    frame = pd.DataFrame(
        {
            "id": [f"{k:03d}" for k in range(80)],
            "colour": colour,
            "age": age,
            'x,"y"': rng.random(80).round(3),
            "when": [f"day {k}" for k in range(80)],
            "label": np.where((colour == "red") & ~(age > 40), "yes", "no"),
        }
    )
    frame.to_csv(tmp_path / "survey.csv", index=False)
    return tmp_path / "survey.csv"


SOLVE = ("--label", "label", "--depth", 2, "--index", "id", "--drop", "when")


def test_predict_reads_standard_input_and_says_what_training_had_not(survey, run, tmp_path, monkeypatch):
    run("solve", survey, *SOLVE, "--out", tmp_path / "tree.json")
    rows = "colour,age,label,name\nred,30,yes,007\nred,,,008\npink,30,no,009\n"
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(rows.encode())))
    code, out, err = run("predict", tmp_path / "tree.json", "-", "--label", "label", "--index", "name")
    assert code == 0
    assert out.splitlines() == ["name,prediction", "007,yes", "008,yes", "009,no"]
    assert "note: colour holds 'pink'" in err
    assert "0 of 2 samples wrong (0 %); 1 more row has no label" in err


def test_the_index_of_a_frame_may_name_the_rows(survey, run, tmp_path):
    pytest.importorskip("pyarrow")
    frame = pd.read_csv(survey)
    frame.set_index(frame["id"].map("r{:03}".format))[["colour", "age", "label"]].to_parquet(tmp_path / "a.parquet")
    code, *_ = run("solve", tmp_path / "a.parquet", *SOLVE[:-2], "--out", tmp_path / "tree.json")
    _, out, err = run("predict", tmp_path / "tree.json", tmp_path / "a.parquet")
    assert (code, out.splitlines()[0], out.splitlines()[1][:5]) == (0, "id,prediction", f"r{frame['id'][0]:03},")
    assert "left out" not in err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--drop", "nope,age,neither"), "no column 'nope', 'neither', which --drop names"),
        (("--drop", 'age,"x'), "cannot be read (unexpected end of data)"),
        (("--drop", "age,,id"), "leave out none"),
        (("--drop", "label"), "--drop names 'label' (the label)"),
        (("--drop", "age", "--features", "age,id"), "--features and --drop both name 'age'"),
        (("--index", "nope"), "expected the index among"),
        (("--categories", "refuse", "--drop", "when,id"), "'colour' holds text such as 'blue'"),
        (("--missing", "refuse", "--drop", "when,id"), "'age' has 9 missing cells"),
        (("--holdout", "1.5", "--drop", "when,id"), "the share held out is 1.5"),
        (("--holdout", "0.2", "--test", "x.csv"), "not allowed with"),
    ],
)
def test_wrong_words_about_columns_end_in_one_line(survey, refused, words, sentence):
    assert sentence in refused("solve", survey, "--label", "label", "--depth", 2, *words)


@pytest.mark.parametrize("word", ["", "?"])
def test_rows_without_a_label_are_refused_or_left_out(run, refused, tmp_path, word):
    path = tmp_path / "t.csv"
    path.write_text("x,y\n" + "".join(f"{k},{word if k == 7 else k // 10}\n" for k in range(20)))
    err = refused("solve", path, "--label", "y", "--depth", 1)
    assert "line 9, column 'y'" in err
    assert "--drop-unlabelled leaves such rows out" in err
    code, out, _ = run("solve", path, "--label", "y", "--depth", 1, "--drop-unlabelled", "--out", tmp_path / "t.json")
    assert code == 0
    assert "0 of 19 samples wrong" in out
    assert read_tree_file(tmp_path / "t.json").class_names == (0, 1)
    assert run("certify", tmp_path / "t.json", path)[0] == 0
    assert "1 more row has no label" in run("predict", tmp_path / "t.json", path, "--label", "y")[2]


@pytest.mark.parametrize(
    ("labels", "is_questioned"),
    [
        (range(10), False),
        (np.arange(11) / 2, True),
        (np.arange(10) / 2, False),
        (range(28), False),
        (range(31), True),
        ([f"k{k}" for k in range(40)], False),
    ],
)
def test_a_label_that_looks_like_a_quantity_is_questioned(run, tmp_path, labels, is_questioned):
    path = tmp_path / "t.csv"
    pd.DataFrame({"x": range(5 * len(labels)), "y": [*labels] * 5}).to_csv(path, index=False)
    words = ("solve", path, "--label", "y", "--depth", 1, "--method", "cart")
    code, _, err = run(*words)
    assert code == (2 if is_questioned else 0)
    assert ("is it a quantity to be estimated (a regression target)?" in err) == is_questioned
    assert run(*words, "--numbers-are-classes")[0] == 0


def test_a_share_is_held_out_and_counted_again_by_certify(survey, run, tmp_path):
    tree = tmp_path / "tree.json"
    code, out, _ = run("solve", survey, *SOLVE, "--holdout", 0.25, "--seed", 5, "--out", tree)
    assert code == 0
    assert "60 training samples  20 held out" in out
    assert "CART" in out
    answer = json.loads(run("solve", survey, *SOLVE, "--holdout", 0.25, "--seed", 5, "--json")[1])
    claim = read_tree_file(tree).held_out
    held, counts = answer["held_out"], np.array(answer["held_out"]["confusion"])
    assert held.items() >= {"n_samples": claim.n_samples, **claim.measures, "cost": claim.cost}.items()
    assert held["recall"] == (np.diag(counts) / counts.sum(axis=1)).tolist()
    assert held["precision"] == (np.diag(counts) / counts.sum(axis=0)).tolist()
    assert held["balanced_accuracy"] == pytest.approx(np.mean(held["recall"]))
    assert answer["cart"]["training"]["n_samples"] == 60
    code, out, _ = run("certify", tree, survey)
    assert code == 0
    assert f"held out: {claim.measures['errors']:.0f} of 20 samples wrong" in out
    content = json.loads(tree.read_text())
    content["held_out"]["measures"]["errors"] += 1
    tree.write_text(json.dumps(content))
    code, _, err = run("certify", tree, survey)
    assert code == 1
    assert "but recounted it is" in err


def test_another_table_tests_the_tree(survey, run, tmp_path):
    lines = survey.read_text().splitlines(keepends=True)
    (tmp_path / "test.csv.gz").write_bytes(gzip.compress("".join([lines[0], *lines[41:]]).encode()))
    survey.write_text("".join(lines[:41]))
    tree, test = tmp_path / "tree.json", tmp_path / "test.csv.gz"
    code, out, err = run("solve", survey, *SOLVE, "--test", test, "--out", tree)
    assert code == 0, err
    assert "40 training samples  40 held out" in out
    assert "of 40 samples wrong" in run("certify", tree, survey, "--test", test)[1].splitlines()[4]
    assert "give it with --test" in run("certify", tree, survey)[1]
    code, out, _ = run("compare", survey, *SOLVE, "--test", test, "--methods", "cart,exact")
    assert code == 0
    assert "errors held out" in out


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
def test_what_cannot_be_compared_is_a_sentence(folder, refused, data, tmp_path, words, said):
    (tmp_path / "none").mkdir()
    places = {"DATA": data, "EMPTY": tmp_path / "none", "TABLES": folder}
    assert said in refused("compare", *METHODS, *(places.get(word, word) for word in words))


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
