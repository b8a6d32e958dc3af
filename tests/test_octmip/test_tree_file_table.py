"""Tree files of tables: how columns became features comes back."""

import json

import pandas as pd
import pytest

from octmip import Problem, solve
from octmip.errors import TreeError
from octmip.formats.columns import Columns
from octmip.formats.held_out import HeldOut
from octmip.formats.table.preparation import Preparation
from octmip.formats.tree_file import read_tree_file, record_tree, write_tree_file
from octmip.interfaces.report.text import tree_text
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.nodes.tree import splits

FRAME = pd.DataFrame({"colour": ["red", "blue", "red", "green"] * 3, "age": [1.0, None, 3.0, 2.0] * 3})


def written(tmp_path):
    columns = Columns.learn(FRAME)
    problem = Problem(columns.encode(FRAME), [1, 0, 1, 0] * 3, depth=1, feature_names=columns.feature_names)
    preparation = Preparation(columns, index="id", rows="labelled")
    held_out = HeldOut(share=0.25, seed=7, n_samples=4, measures={"errors": 1}, cost=2.5)
    path = tmp_path / "t.json"
    write_tree_file(path, record_tree(problem, greedy_tree(problem), "y", None, preparation, held_out))
    return path


def test_columns_and_what_is_held_out_come_back(tmp_path):
    file = read_tree_file(written(tmp_path))
    assert file.preparation == Preparation(Columns.learn(FRAME), "id", "labelled")
    assert file.columns == Columns.learn(FRAME)
    assert file.held_out == HeldOut(0.25, 7, 4, {"errors": 1}, 2.5)
    assert tree_text(file.tree, file.feature_names, file.class_names, columns=file.columns).splitlines() == [
        "if colour is not red",
        "    0",
        "else",
        "    1",
    ]


def test_a_tree_with_sides_for_missing_readings_comes_back(tmp_path):
    path = tmp_path / "t.json"
    columns = Columns.learn(FRAME[["age"]])
    problem = Problem(columns.encode(FRAME), [1, 0, 1, 0] * 3, depth=2, feature_names=("age",))
    solution = solve(problem, "exact")
    write_tree_file(path, record_tree(problem, solution, "y", None, Preparation(columns)))
    file = read_tree_file(path)
    assert file.tree == solution.tree
    assert file.preparation == Preparation(columns, None, "all", None)
    assert file.settings["takes_missing"]
    assert all(split.missing is not None for split in splits(file.tree))
    samples = problem.samples
    assert file.problem(samples.features, samples.targets, samples.weights).digest() == file.sha256
    content = json.loads(path.read_text())
    content["tree"]["missing"] = "up"
    path.write_text(json.dumps(content))
    with pytest.raises(TreeError, match=r"missing is 'up'; expected one of 'left', 'right'"):
        read_tree_file(path)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda file: file.pop("table"), "lacks the entry 'table'"),
        (lambda file: file["table"]["columns"]["columns"].pop(), "expected the same names in the same order"),
        (lambda file: file["table"]["columns"]["columns"].reverse(), "expected the same names in the same order"),
        (lambda file: file["table"].update(rows="some"), "table.rows is 'some'; expected one of"),
        (lambda file: file["held_out"].update(share=2), "held_out.share is 2; expected"),
        (lambda file: file["table"]["columns"]["columns"][1].update(least=9.0), "its range ends before it begins"),
    ],
)
def test_a_file_changed_by_hand_is_refused(tmp_path, change, sentence):
    path = written(tmp_path)
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    with pytest.raises(TreeError, match=sentence):
        read_tree_file(path)
