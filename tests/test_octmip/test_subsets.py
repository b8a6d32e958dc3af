"""Sets of texts in one split: proven against a list of all trees, in the words of the table, kept by files."""

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.formats.columns.column import Column
from octmip.formats.tree_file import read_tree_file
from octmip.interfaces.cli import main
from octmip.interfaces.estimator import OptimalTreeClassifier
from octmip.trees.nodes.tree import Leaf, Split

COLOURS = pd.DataFrame({"colour": ["red", "blue", "green", "blue", "grey", "red"]})
STATE = np.array(["hot", "hot", "cold", "hot", "cold", "hot"])


def test_every_set_without_the_first_value_is_a_feature_and_an_unknown_text_is_in_none():
    columns = Columns.learn(COLOURS, categories="subsets")
    assert columns.feature_names[:4] == (
        "colour in {green}",
        "colour in {grey}",
        "colour in {red}",
        "colour in {green, grey}",
    )
    assert len(columns.features) == 7
    assert set(columns.column_of_feature) == {"colour"}
    assert not columns.encode(pd.DataFrame({"colour": ["violet"]})).any()
    assert columns.unseen(pd.DataFrame({"colour": ["violet"]})) != ()
    assert columns.changes() == ("a split may ask for any set of the texts in 1 column ('colour')",)


def test_a_missing_cell_is_a_text_of_its_own():
    frame = pd.DataFrame({"c": ["a", "b", None, "b"]})
    columns = Columns.learn(frame, categories="subsets")
    assert columns.feature_names == ("c in {b}", "c in {missing}", "c in {b, missing}")
    assert columns.encode(frame)[:, 2].tolist() == [0, 1, 1, 1]


def test_a_split_is_written_by_the_shorter_set():
    columns = Columns.learn(COLOURS, categories="subsets")
    words = [columns.left_words(Split(j, 0.5, Leaf(0), Leaf(1))) for j in (0, 3, 6)]
    assert words == ["colour not in {green}", "colour in {blue, red}", "colour in {blue}"]
    assert set(columns.columns[0].questions().values()) == set(columns.feature_names)


def test_too_many_or_too_long_texts_are_refused():
    many = pd.DataFrame({"c": [f"t{k % 13}" for k in range(40)]})
    with pytest.raises(DataError, match="holds 13 different texts; expected at most 12, of which every set is tried"):
        Columns.learn(many, categories="subsets")
    with pytest.raises(DataError, match="shorten them"):
        Columns.learn(pd.DataFrame({"c": ["a" * 400, "b" * 400]}), categories="subsets")
    hostile = Column("c", "subsets", False, values=tuple(f"t{k}" for k in range(40))).to_json()
    with pytest.raises(DataError, match="sets are made of 12 texts at most"):
        Column.from_json(hostile)


def test_command_page_and_estimator_know_sets(tmp_path, capsys):
    table, tree = str(tmp_path / "t.csv"), str(tmp_path / "t.json")
    frame = pd.concat([COLOURS.assign(state=STATE)] * 4)
    frame.to_csv(table, index=False)
    words = ["--label", "state", "--depth", "1", "--categories", "subsets", "--out", tree]
    assert main(["solve", table, *words]) == 0
    assert "if colour in {blue, red}" in capsys.readouterr().out
    assert read_tree_file(tree).solution.objective == 0
    assert main(["certify", tree, table]) == 0
    page = str(tmp_path / "t.html")
    assert main(["report", tree, table, "--out", page]) == 0
    assert '"members": ["green", "grey"]' in (tmp_path / "t.html").read_text().replace('":[', '": [').replace(
        '","', '", "'
    )
    model = OptimalTreeClassifier(max_depth=1, categories="subsets").fit(frame[["colour"]], frame["state"])
    assert model.score(frame[["colour"]], frame["state"]) == 1
