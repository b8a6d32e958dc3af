"""Tree files: what is written comes back the same, and what is no tree file is refused in one sentence."""

import json
import math
import pickle
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import octmip
from octmip import (
    ClassCosts,
    HyperplaneSplit,
    Leaf,
    Problem,
    Solution,
    Split,
    SquaredError,
    Stop,
    certify,
    predict,
    solve,
)
from octmip.errors import OctmipError, TreeError
from octmip.formats.tree_file import (
    columns_read,
    encode,
    read_tree_file,
    record_tree,
    tree_for,
    write_tree_file,
)
from octmip.formats.tree_schema import schema
from octmip.trees.methods.cart import greedy_tree

SCHEMA = Path(octmip.__file__).parent / "interfaces" / "schemas" / "tree.schema.json"


def full_problem() -> Problem:
    rng = np.random.default_rng(0)
    return Problem(
        rng.normal(size=(40, 3)),
        rng.choice(["low", "high"], 40),
        depth=2,
        split="hyperplane",
        split_size=2,
        leaf_size=2,
        leaf_penalty=0.25,
        weights=rng.random(40),
        loss=ClassCosts([[0, 2.5], [1, 0]]),
        sensor_of_feature=["left", "left", "right"],
        sensor_cost={"left": 1.5, "right": 2},
        sensor_budget=4,
        allowed_splits=[["a", "b"], ["c"]],
        feature_names=("a", "b", "c"),
    )


def written(tmp_path, problem=None):
    problem = problem or full_problem()
    path = tmp_path / "tree.json"
    write_tree_file(path, record_tree(problem, greedy_tree(problem), "y", "w"))
    return path


def test_everything_comes_back_the_same(tmp_path):
    problem = full_problem()
    solution = greedy_tree(problem)
    file = record_tree(problem, solution, "y", "w")
    write_tree_file(tmp_path / "t.json", file)
    back = read_tree_file(tmp_path / "t.json")
    assert encode(back) == encode(file)
    assert back.solution == solution
    assert back.target_column == "y"
    assert back.weights_column == "w"
    again = back.problem(problem.samples.features, problem.samples.targets, problem.samples.weights)
    assert again.digest() == problem.digest() == back.sha256
    assert certify(again, back.solution) == certify(problem, solution)
    assert back.leaf_counts.sum() == 40


def test_settings_cannot_be_written_and_go_to_other_processes():
    file = record_tree(full_problem(), greedy_tree(full_problem()))
    with pytest.raises(TypeError, match="does not support item assignment"):
        file.settings["depth"] = 9
    assert encode(pickle.loads(pickle.dumps(file))) == encode(file)


def test_hyperplanes_come_back_to_the_last_bit(tmp_path):
    problem = full_problem()
    tree = HyperplaneSplit((0, 1), (0.1 + 0.2, -1 / 3), 2**-40, Leaf(0), Split(2, 1e300, Leaf(0), Leaf(1)))
    solution = Solution(tree, 9.0, 1.5, Stop.TIME, 0.1, 5, "search", "1", 0)
    write_tree_file(tmp_path / "t.json", record_tree(problem, solution))
    back = read_tree_file(tmp_path / "t.json")
    assert back.tree == tree
    assert back.solution == solution
    assert columns_read(back) == ("a", "b", "c")


def test_a_tree_is_told_by_names_to_a_problem_of_another_order(tmp_path):
    problem = full_problem()
    tree = HyperplaneSplit((0, 1), (2.0, -1.0), 0.5, Leaf(0), Split(2, 0.1, Leaf(0), Leaf(1)))
    file = record_tree(problem, Solution(tree, 9.0, 1.5, Stop.TIME, 0.1, 5, "search", "1", 0))
    order = [2, 1, 0]
    turned = Problem(
        problem.samples.features[:, order],
        problem.samples.targets,
        depth=2,
        feature_names="cba",
        class_names=("low", "high"),
    )
    retold = tree_for(turned, file)
    told = np.array(problem.samples.class_names)[predict(tree, problem.samples.features)]
    assert (np.array(turned.samples.class_names)[predict(retold, turned.samples.features)] == told).all()


def test_a_solution_without_a_tree_is_not_written():
    with pytest.raises(TreeError, match="nothing to write"):
        record_tree(full_problem(), Solution(None, math.inf, 0.0, Stop.TIME, 0.0, 0, "oct", "1", 0))


LOW = {"label": "low"}


def changed(path, keys, to):
    content = json.loads(path.read_text())
    place = content
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = to
    path.write_text(json.dumps(content))
    return path


LONG = 10**29
CLASSES = [
    (("format",), "pmml", "is no tree file: format is 'pmml'"),
    (("version",), 99, "of version 99, newer than"),
    (("version",), "1", "has version '1'"),
    (("version",), True, "has version True"),
    (("version",), 2.5, "has version 2.5"),
    (("tree",), {"label": "unknown"}, "class 'unknown', which is not among"),
    (("tree",), {"feature": "z", "threshold": 1, "left": LOW, "right": LOW}, "feature 'z'"),
    (
        ("tree",),
        {"feature": "a", "threshold": "1", "left": LOW, "right": LOW},
        "no valid tree: .*tree.threshold is '1'; expected a finite number; write the file again",
    ),
    (("tree",), {"feature": "a", "threshold": 10**400, "left": LOW, "right": LOW}, "tree.threshold is a whole"),
    (("tree",), {"feature": ["a"], "threshold": 1, "left": LOW, "right": LOW}, "tree.feature is a list of 1"),
    (("tree",), {"label": "low", "feature": "a"}, "tree has the entry 'feature'; expected an object with label"),
    (
        ("tree",),
        {"features": ["a", "b"], "coefficients": [1], "offset": 1, "left": LOW, "right": LOW},
        "a node has 2 features and 1 coefficients",
    ),
    (("tree",), [], "no valid tree"),
    (("tree",), {}, "lacks the entry 'label', 'value' or 'left'"),
    (("solution",), {}, "lacks the entry"),
    (("problem",), None, "no valid tree: .*problem is None; expected an object with depth"),
    (("training", "leaf_counts"), [[1, 2]], "leaf_counts has shape"),
    (("training", "leaf_counts"), [[LONG, 1]] * 3, r"leaf_counts\[0\]\[0\] is 100000000000000000000000000000"),
    (("training", "n_samples"), 41, "leaf_counts adds up to 40; expected training.n_samples, 41"),
    (("training", "leaf_counts", 0, 0), 39, "leaf_counts adds up to .*; expected training.n_samples, 40"),
    (("problem", "loss", "costs"), [[0], [1]], r"problem.loss.costs has 2 rows; expected \(2, 2\) numbers"),
    (("problem", "loss", "costs"), [[0, -1], [1, 0]], r"costs\[0\]\[1\] is -1; expected a finite number of 0"),
    (("problem", "sensor_of_feature"), ["left"], "sensor_of_feature has 1 names; expected one for each of 3"),
    (("problem", "sensor_of_feature"), None, "problem.sensor_of_feature is None; expected a list"),
    (("solution", "details"), [], r"solution.details is \[\]; expected an object"),
    (("feature_names", 0), "b", "feature_names holds 'b' 2 times"),
    (("class_names",), ["low", "low"], "expected a list of different names"),
]
"""What no kind of a field says; that each kind refuses what its schema does, tests of `checked` say."""

NUMBERS = [
    (("tree", "left"), LOW, "names the class 'low', which is not among its 0 class names"),
    (("tree", "left", "coefficients"), [1.0], "a node has 0 features and 1 coefficients"),
    (("tree", "left", "label"), "low", "tree.left has the entry 'value'; expected an object with label"),
    (("class_names",), ["low", "high"], "class_names has 2 names but problem.loss is 'squared'"),
    (("problem", "loss"), {"name": "classes", "costs": []}, "class_names has 0 names but problem.loss is 'classes'"),
    (("problem", "loss"), {"name": "cubic"}, "problem.loss.name is 'cubic'; expected one of 'classes', 'sample"),
    (("problem", "loss"), {"name": "squared", "costs": []}, "problem.loss has the entry 'costs'"),
    (("training", "leaf_counts"), [[4, 0], [4, 0]], r"leaf_counts has shape \(2, 2\); expected \(2, 1\)"),
    (
        ("held_out",),
        {"share": None, "seed": 0, "n_samples": 2, "measures": {"errors": 1}, "cost": 1.0},
        "held_out.measures has the entries '?errors'?; expected '?mae'?(,| and) '?rmse'?",
    ),
]


def numbers_written(tmp_path):
    problem = Problem(np.arange(8.0)[:, None], np.arange(8.0), depth=1, loss=SquaredError(), feature_names=["a"])
    write_tree_file(tmp_path / "n.json", record_tree(problem, solve(problem), "y"))
    return tmp_path / "n.json"


def test_a_tree_of_numbers_comes_back_the_same_and_is_of_the_published_schema(tmp_path):
    path = numbers_written(tmp_path)
    content, file = json.loads(path.read_text()), read_tree_file(path)
    assert content["problem"]["loss"] == {"name": "squared"}
    assert content["tree"]["left"] == {"value": 1.5, "features": [], "coefficients": []}
    assert (file.leaf_counts.tolist(), file.class_names, file.loss) == ([[4], [4]], (), SquaredError())
    assert encode(file) == content
    assert jsonschema.Draft202012Validator(schema()).is_valid(content)


@pytest.mark.parametrize(
    ("kind", "keys", "to", "sentence"),
    [*((written, *row) for row in CLASSES), *((numbers_written, *row) for row in NUMBERS)],
)
def test_a_file_changed_by_hand_is_refused_with_its_place(tmp_path, kind, keys, to, sentence):
    path = changed(kind(tmp_path), keys, to)
    with pytest.raises(TreeError, match=sentence):
        read_tree_file(path)


def test_a_number_in_a_tree_of_classes_and_a_tree_that_predicts_something_else_are_refused(tmp_path):
    path = written(tmp_path)
    with pytest.raises(TreeError, match="leaves predict a class; expected a number in every leaf"):
        read_tree_file(path, "number")
    with pytest.raises(TreeError, match="leaves predict a number; expected a class in every leaf"):
        read_tree_file(numbers_written(tmp_path), "class")
    changed(path, ["tree"], {"value": 1.0, "features": [], "coefficients": []})
    with pytest.raises(TreeError, match=r"a leaf predicts the number 1\.0; expected one of the 2 classes"):
        read_tree_file(path)


def test_the_published_schema_is_the_readers(tmp_path):
    published = json.loads(SCHEMA.read_text())
    assert published == schema(), (
        "write schema() of octmip.formats.tree_schema to octmip/interfaces/schemas/tree.schema.json again"
    )
    validator = jsonschema.Draft202012Validator(published)
    jsonschema.Draft202012Validator.check_schema(published)
    content = json.loads(written(tmp_path).read_text())
    assert validator.is_valid(content)
    for entry in ("tree", "training", "version", "format"):
        assert not validator.is_valid({name: value for name, value in content.items() if name != entry})
    assert not validator.is_valid(content | {"version": 1})


def test_what_could_not_be_read_again_is_not_written(tmp_path):
    problem = Problem([[0.0], [1.0]], [0, 1], depth=1, feature_names=("a" * 1001,))
    with pytest.raises(OctmipError, match="expected a text of at most 1000 characters"):
        write_tree_file(tmp_path / "t.json", record_tree(problem, greedy_tree(problem)))
    assert not list(tmp_path.iterdir())


def test_hostile_coefficients_predict_without_a_warning():
    samples = np.array([[1e300, -1e300, 0.0], [-1e308, 1e308, 0.0]])
    tree = HyperplaneSplit((0, 1), (1e300, 1e300), 0.0, Leaf(0), Leaf(1))
    assert predict(tree, samples).tolist() == [1, 1]  # inf - inf is no number, and not at most 0
