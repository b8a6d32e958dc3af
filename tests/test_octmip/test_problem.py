"""Problems: what is asked is checked once, here, and every wrong question is refused with a cure."""

import math

import numpy as np
import pandas as pd
import pytest

from octmip import HyperplaneSplit, Leaf, Problem, Split, certify, predict, solve
from octmip.errors import ProblemError
from octmip.trees.answer.certificate import first_forbidden_split
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.nodes.tree import splits
from octmip.trees.question import problem_values
from octmip.trees.question.losses import ClassCosts, SquaredError
from octmip.trees.question.problem_file import data_digest, question_digest

FEATURES = np.arange(12.0).reshape(4, 3)
LABELS = ["b", "a", "b", "a"]


def problem(**changes):
    settings = {"features": FEATURES, "targets": LABELS, "depth": 2} | changes
    features, labels = settings.pop("features"), settings.pop("targets")
    return Problem(features, labels, **settings)


def test_what_is_left_out_is_filled_in():
    p = problem()
    assert p.samples.class_names == ("a", "b")
    assert p.samples.codes.tolist() == [1, 0, 1, 0]
    assert p.samples.feature_names == ("x0", "x1", "x2") == p.shape.sensors
    assert p.shape.sensor_costs.tolist() == [1, 1, 1]
    assert p.samples.weights.tolist() == [1] * 4
    assert p.costs.tolist() == [[0, 1], [1, 0]]
    assert (p.samples.n_samples, p.samples.n_features, p.samples.n_classes, p.shape.max_split_size) == (4, 3, 2, 1)
    assert p.baseline == 2
    assert p.has_integer_costs
    assert p.shape.sensor_limit == np.inf


def test_arrays_are_copied_in_and_read_only():
    features = FEATURES.copy()
    p = problem(features=features)
    features[0, 0] = 99.0
    assert p.samples.features[0, 0] == 0.0
    for array in (p.samples.features, p.samples.weights, p.costs, p.samples.codes, p.shape.sensor_costs):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_the_objective_is_cost_times_weight_plus_penalty_for_each_feature_of_each_split():
    p = problem(weights=[1, 2, 3, 4], loss=ClassCosts([[0, 10], [1, 0]]), leaf_penalty=0.5, split="hyperplane")
    tree = Split(0, 1.0, Leaf(0), HyperplaneSplit((0, 2), (1.0, 1.0), 9.0, Leaf(1), Leaf(0)))
    assert p.objective_of(tree, np.array([0, 1, 1, 0])) == 1 * 1 + 2 * 10 + 0 + 0 + 0.5 * 3
    assert p.objective(tree) == p.objective_of(tree, predict(tree, p.samples.features))
    assert p.class_costs().tolist() == [4.0, 60.0]
    assert p.baseline == 4.0
    assert p.class_costs(np.array([1])).tolist() == [0.0, 20.0]


def test_a_sensor_is_paid_once_however_many_features_it_gives():
    p = problem(sensor_of_feature=["l", "l", "r"], sensor_cost={"r": 2, "l": 0.5}, sensor_budget=2)
    tree = Split(0, 1.0, Split(1, 1.0, Leaf(0), Leaf(1)), Leaf(1))
    assert p.shape.sensors == ("l", "r")
    assert p.shape.sensors_used(tree) == ("l",)
    assert p.shape.sensor_cost_of(tree) == 0.5
    assert p.shape.sensor_cost_of(Split(2, 1.0, tree, Leaf(0))) == 2.5 > p.shape.sensor_limit


@pytest.mark.parametrize("made", [dict, pd.Series])
def test_what_is_given_by_name_goes_by_name_in_any_order(made):
    sensors, costs = made({"x2": "r", "x1": "l", "x0": "l"}), made({"r": 2.0, "l": 0.5})
    p = problem(targets=[0, 1, 1, 0], sensor_of_feature=sensors, sensor_cost=costs, monotone=made({"x1": -1})).shape
    assert (p.sensor_of_feature, p.sensor_costs.tolist(), p.monotone) == (("l", "l", "r"), [0.5, 2.0], (0, -1, 0))
    assert problem(sensor_of_feature=made({"x1": "l"})).shape.sensor_of_feature == ("x0", "l", "x2")
    with pytest.raises(ProblemError, match=r"sensor_of_feature names \['y'\], no features; expected some of"):
        problem(sensor_of_feature=made({"y": "l"}))


def test_decimal_costs_that_add_up_to_the_budget_are_within_it():
    p = problem(sensor_cost=[0.1, 0.2, 5], sensor_budget=0.3)
    assert 0.1 + 0.2 > 0.3
    assert p.shape.sensor_cost_of(Split(0, 1.0, Split(1, 1.0, Leaf(0), Leaf(1)), Leaf(1))) <= p.shape.sensor_limit


def test_features_may_meet_only_in_allowed_groups():
    p = problem(split="hyperplane", split_size=2, allowed_splits=[["x0", 2], [1]])
    assert p.shape.is_allowed((0, 2))
    assert p.shape.is_allowed((1,))
    assert not p.shape.is_allowed((0, 1))
    assert not p.shape.is_allowed((0, 1, 2))
    assert "x1" in str(first_forbidden_split(p, HyperplaneSplit((0, 1), (1.0, 1.0), 0.0, Leaf(0), Leaf(1))))


@pytest.mark.parametrize(
    "values", [{"weights": [0.5] * 4}, {"loss": ClassCosts([[0, 0.1], [1, 0]])}, {"leaf_penalty": 0.2}]
)
def test_costs_are_integers_only_when_all_numbers_are(values):
    assert not problem(**values).has_integer_costs


def test_the_digest_knows_the_training_data_and_nothing_else():
    assert problem().digest() == problem(depth=3, leaf_penalty=1.0).digest()
    changed = FEATURES.copy()
    changed[2, 1] = np.nextafter(changed[2, 1], 99)
    others = [{"features": changed}, {"targets": ["a", "a", "b", "b"]}, {"weights": [1, 1, 1, 2]}]
    others += [{"targets": ["a", "b", "c", "b"], "class_names": names} for names in (["a", "b", "c"], ["c", "b", "a"])]
    others += [{"targets": ["a", "b", "d", "b"]}]
    others += [{"loss": ClassCosts([[0, 1]] * 3 + [last], per_sample=True)} for last in ([0, 1], [0, 2])]
    assert len({problem(**other).digest() for other in [{}, *others]}) == 9
    assert len({question_digest(problem(max_splits=most)) for most in (1, 2, 3, None)}) == 3  # 3 are no limit


WRONG = {
    "features of text": ({"features": [["x"]]}, "features cannot be read as numbers"),
    "features of one dimension": ({"features": [1, 2, 3, 4]}, "features has 1 dimensions; expected 2"),
    "no features": ({"features": np.empty((4, 0))}, r"features has shape \(4, 0\)"),
    "no samples": ({"features": np.empty((0, 3)), "targets": []}, r"features has shape \(0, 3\)"),
    "infinity": ({"features": [[np.nan, 1], [0, 0], [0, np.inf], [0, 0]]}, r"features\[2, 1\] is infinite \(1 in"),
    "too few labels": ({"targets": ["a", "b"]}, r"targets has shape \(2,\) but features has 4 rows"),
    "NaN label": ({"targets": [0.0, 1.0, np.nan, 1.0]}, r"labels\[2\] is nan"),
    "one class": ({"targets": ["a"] * 4}, "one class only"),
    "unknown class": ({"class_names": ["a", "c"]}, r"targets holds \['b'\] which class_names"),
    "an order that is a set": (
        {"class_order": {"a", "b"}},
        "class_order is a set.*which has no order; expected a list",
    ),
    "class named twice": ({"class_names": ["a", "b", "a"]}, "names twice"),
    "feature named twice": ({"feature_names": ["u", "u", "v"]}, r"feature_names has 3 entries \(2 different\)"),
    "too few names": ({"feature_names": ["u"]}, "feature_names has 1 entries"),
    "negative weight": ({"weights": [1, -1, 1, 1]}, r"weights\[1\] is -1\.0"),
    "too few weights": ({"weights": [1, 1]}, "weights has 2 entries"),
    "no weight at all": ({"weights": [0] * 4}, "all weights are 0"),
    "NaN weight": ({"weights": [1, np.nan, 1, 1]}, r"weights\[1\] is not finite"),
    "costs of wrong shape": (
        {"loss": ClassCosts([[0, 1, 2], [1, 0, 1]])},
        r"costs has shape \(2, 3\); expected \(2, 2\)",
    ),
    "negative cost": ({"loss": ClassCosts([[0, -1], [1, 0]])}, r"costs\[0, 1\] is -1\.0"),
    "depth 0": ({"depth": 0}, "depth is 0; expected a whole number from 1 to 30"),
    "depth 2.5": ({"depth": 2.5}, "depth is 2.5"),
    "depth True": ({"depth": True}, "depth is True"),
    "depth 31": ({"depth": 31}, "depth is 31"),
    "leaf size 0": ({"leaf_size": 0}, "leaf_size is 0"),
    "leaf size above n": ({"leaf_size": 5}, "leaf_size is 5; expected a whole number from 1 to 4"),
    "weight of leaves below 0": ({"leaf_weight": -1}, "leaf_weight is -1"),
    "weight of leaves above all": ({"leaf_weight": 4.5}, "leaf_weight is 4.5 but all samples together weigh 4"),
    "size and weight of leaves": ({"leaf_weight": 1, "leaf_size": 2}, "leaf_size is 2 and leaf_weight 1"),
    "weight of leaves with costs of samples": (
        {"leaf_weight": 1, "loss": ClassCosts(np.ones((4, 2)), True)},
        "leaf_weight is given with costs of single",
    ),
    "any depth without a price": ({"depth": None}, "depth is None and leaf_penalty 0.* give leaf_penalty"),
    "any depth of hyperplanes": (
        {"depth": None, "leaf_penalty": 1.0, "split": "hyperplane"},
        "depth is None but split is 'hyperplane'; give a depth",
    ),
    "a loss that is a word": ({"loss": "squared"}, "loss is 'squared'"),
    "words for numbers": ({"loss": SquaredError()}, "targets cannot be read as numbers"),
    "classes for numbers": ({"loss": SquaredError(), "targets": range(4), "class_names": (0, 1)}, "class_names is"),
    "linear leaves of classes": ({"leaf_model": "linear"}, "leaf_model is 'linear'"),
    "NaN among numbers": ({"loss": SquaredError(), "targets": [1.0, np.nan, 0.0, 0.0]}, "targets"),
    "too few numbers": ({"loss": SquaredError(), "targets": np.ones(3)}, "3 entries"),
    "numbers too far apart": ({"loss": SquaredError(), "targets": [0.0, 1e200, 0.0, 0.0]}, "scale them"),
    "splits of -1": ({"max_splits": -1}, "max_splits is -1"),
    "splits of 1.5": ({"max_splits": 1.5}, "max_splits is 1.5"),
    "negative penalty": ({"leaf_penalty": -1.0}, r"leaf_penalty is -1\.0"),
    "infinite penalty": ({"leaf_penalty": np.inf}, "leaf_penalty is inf"),
    "prices beyond float64": (
        {"depth": 1, "split": "hyperplane", "split_size": 2, "leaf_penalty": 1e308},
        "leaf_penalty, up to inf in all",
    ),
    "order of linear leaves": (
        {"monotone": [1, 0, 0], "leaf_model": "linear", "loss": SquaredError(), "targets": range(4)},
        "monotone is given but split is 'axis' and leaf_model 'linear'",
    ),
    "unknown split": ({"split": "curve"}, "split is 'curve'"),
    "split size of axis": ({"split_size": 2}, "split is 'axis'; say split='hyperplane'"),
    "split size 0": ({"split": "hyperplane", "split_size": 0}, "split_size is 0"),
    "integer normals beyond float64": (
        {"split": "hyperplane", "integer_normals": 2**53 + 1},
        "integer_normals is 9007199254740993",
    ),
    "integer normals 0": ({"split": "hyperplane", "integer_normals": 0}, "integer_normals is 0"),
    "sensors of other length": ({"sensor_of_feature": ["a"]}, "sensor_of_feature has 1 entries"),
    "sensor cost missing": ({"sensor_cost": {"x0": 1, "x1": 1}}, r"missing: \['x2'\]"),
    "sensor cost unknown": ({"sensor_cost": {"x0": 1, "x1": 1, "x2": 1, "q": 1}}, r"unknown: \['q'\]"),
    "sensor costs too few": ({"sensor_cost": [1, 2]}, "sensor_cost has 2 entries"),
    "negative sensor cost": ({"sensor_cost": [1, 2, -3]}, "sensor_cost of 'x2' is -3"),
    "negative budget": ({"sensor_budget": -1}, "sensor_budget is -1"),
    "unknown group member": ({"allowed_splits": [["x0", "q"]]}, r"allowed_splits names \['q'\]"),
    "group member out of range": ({"allowed_splits": [[3]]}, r"allowed_splits names \[3\]"),
    "empty group": ({"allowed_splits": [[]]}, "an empty group"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_question_is_refused(name):
    changes, sentence = WRONG[name]
    with pytest.raises(ProblemError, match=sentence):
        problem(**changes)


@pytest.mark.parametrize(
    ("settings", "least"),
    [
        ({}, 1.0),
        ({"weights": [3, 1e-9, 0, 2]}, 1e-9),
        ({"weights": [3, 5, 4, 2], "loss": ClassCosts([[0, 10], [7, 0]])}, 14.0),
        ({"weights": [3, 5, 4, 2], "leaf_penalty": 0.5}, 0.5),
        ({"loss": ClassCosts([[0, 0.3], [0.1 + 0.2, 0]])}, 0.3),
        ({"weights": [1, 0, 1, 0], "loss": ClassCosts([[2, 2], [0, 3]])}, math.inf),
    ],
)
def test_the_least_saving_is_that_of_one_sample_or_one_split(settings, least):
    problem = Problem(np.arange(4.0)[:, None], [0, 1, 0, 1], depth=1, **settings)
    assert problem.least_saving == least


FRAME = pd.DataFrame({"age": [1.0, 2.0, 3.0, 4.0], "dose": [0, 1, 0, 1]})


def test_a_data_frame_gives_its_names_to_features_and_sensors():
    asked = Problem(FRAME, pd.Series(["a", "b", "a", "b"], index=[4, 3, 2, 1]), depth=1)
    assert asked.samples.feature_names == asked.shape.sensors == ("age", "dose")
    assert asked.samples.targets.tolist() == ["a", "b", "a", "b"]
    assert Problem(FRAME, [0, 1, 0, 1], depth=1, feature_names=("u", "v")).samples.feature_names == ("u", "v")
    assert Problem(pd.DataFrame(FRAME.to_numpy()), [0, 1, 0, 1], depth=1).samples.feature_names == ("x0", "x1")


@pytest.mark.parametrize(
    "labels",
    [
        pd.Series([0, None, 1, None], dtype="Int64"),
        pd.Series(["a", None, "b", None]),
        pd.Series(["a", None, "b", None], dtype="category"),
        pd.to_datetime(pd.Series(["2020-01-01", None, "2020-01-02", None])),
        np.array(["a", None, "b", pd.NA], dtype=object),
    ],
)
def test_missing_labels_are_refused_with_their_number(labels):
    with pytest.raises(ProblemError, match=r"labels\[1\] is .*; 2 of 4 labels are missing"):
        Problem(FRAME, labels, depth=1)


@pytest.mark.parametrize("column", [["x", "y", "x", "y"], [1.0, np.inf, None, 3.0], [1.0, np.inf, 2.0, 3.0]])
def test_columns_of_a_data_frame_that_are_no_numbers_are_all_named(column):
    with pytest.raises(ProblemError, match="infinite values in 'kind', 'other';"):
        Problem(FRAME.assign(kind=column, other=column), [0, 1, 0, 1], depth=1)


def test_a_problem_of_some_samples_keeps_that_readings_may_be_missing():
    found = Problem([[1.0], [np.nan], [2.0]], [0, 1, 1], depth=1)
    assert found.replace(features=found.samples.features[[0, 2]], targets=[0, 1], weights=None).samples.takes_missing
    assert not problem().samples.takes_missing
    assert problem().replace(features=np.full((4, 3), np.nan)).samples.takes_missing


def test_missing_readings_have_one_digest_whatever_their_bits():
    quiet, other = np.array([[1.0], [np.nan], [2.0]]), np.array([[1.0], [-np.nan], [2.0]])
    assert quiet.tobytes() != other.tobytes()
    assert Problem(quiet, [0, 1, 1], depth=1).digest() == Problem(other, [0, 1, 1], depth=1).digest()


def test_a_problem_shows_its_size_and_settings_and_no_arrays():
    assert repr(problem()) == "Problem(4 samples, 3 features, 2 classes, depth=2, split='axis')"
    asked = problem(
        leaf_size=2, leaf_penalty=0.5, weights=[1, 2, 1, 1], loss=ClassCosts([[0, 2], [1, 0]]), sensor_budget=2
    )
    assert repr(asked).endswith("split='axis', leaf_size=2, leaf_penalty=0.5, sensor_budget=2, weighted, with costs)")
    assert "leaf_weight=2" in repr(problem(leaf_weight=2))
    lines = Problem([[1.0], [2.0], [3.0]], [1.0, 2.0, 4.0], depth=1, loss=SquaredError(), leaf_model="linear")
    assert repr(lines).endswith("split='axis', leaf_model='linear')")


def test_a_table_that_nobody_can_write_to_is_not_copied():
    table, labels = np.array([[0.0, np.nan], [1.0, 2.0]]), [0, 1]
    assert not np.shares_memory(Problem(table, labels, depth=1).samples.features, table)
    table.flags.writeable = False
    problem = Problem(table, labels, depth=1)
    assert problem.samples.features is table
    assert problem.replace(depth=2).samples.features is table
    view = Problem(table[:], labels, depth=1)
    assert not np.shares_memory(view.samples.features, table), "its base may be written to"
    odd = np.array([[0.0, -np.nan], [1.0, 2.0]])
    odd.flags.writeable = False
    assert np.array_equal(Problem(odd, labels, depth=1).samples.features.view(np.int64), table.view(np.int64))


def single(features):
    """Return the values as a float32 table that nobody can write to."""
    table = np.array(features, dtype=np.float32)
    table.flags.writeable = False
    return table


@pytest.mark.parametrize("missing", [False, True])
def test_a_float32_table_is_kept_and_stands_for_its_values_as_float64(missing):
    rng = np.random.default_rng(4)
    values = rng.normal(size=(300, 3)).astype(np.float32)
    values[:, 0] = np.repeat(np.float32(1) + np.arange(3, dtype=np.float32) * np.finfo(np.float32).eps, 100)
    values[5, 1] = np.nan if missing else 0.0
    labels = (values[:, 0] > 1) * 1 + (rng.random(300) < 0.1)
    narrow = Problem(single(values), labels, depth=2)
    wide = Problem(values.astype(np.float64), labels, depth=2)
    assert (narrow.samples.features.dtype, wide.samples.features.dtype) == (np.float32, np.float64)
    assert (narrow.digest(), data_digest(narrow)) == (wide.digest(), data_digest(wide))
    found, known = branch_and_bound(narrow), branch_and_bound(wide)
    assert (found.tree, found.objective, found.n_nodes) == (known.tree, known.objective, known.n_nodes)
    assert certify(narrow, found) == certify(wide, known)
    # between two neighbours of float32: float32 has no threshold there
    assert any(split.threshold not in values for split in splits(found.tree))


def test_only_axis_aligned_splits_and_tables_that_nobody_writes_to_keep_float32():
    table = single(FEATURES)
    assert Problem(table, LABELS, depth=2).samples.features is table
    assert Problem(table, LABELS, depth=2, split="hyperplane").samples.features.dtype == np.float64
    assert Problem(table.copy(), LABELS, depth=2).samples.features.dtype == np.float64
    assert Problem(table, range(4), depth=2, loss=SquaredError()).samples.features.dtype == np.float64
    assert Problem(FEATURES, LABELS, depth=2, weights=np.ones(4, dtype=np.float32)).samples.weights.dtype == np.float64


def test_a_table_is_read_in_blocks_of_rows(monkeypatch):
    whole = problem().digest()
    lacking = np.array([[0.0, np.nan], [1.0, 2.0], [np.nan, np.nan]])
    monkeypatch.setattr(problem_values, "BLOCK", 2)
    assert problem().digest() == whole
    p, turned = (Problem(rows, [0, 1, 1], depth=1) for rows in (lacking, lacking[[2, 0, 1]]))
    assert (p.samples.n_missing, p.samples.features_with_missing) == (3, (0, 1))
    assert turned.samples.features_with_missing == (0, 1)


@pytest.mark.parametrize(
    ("keyword", "words"),
    [("max_depth", "takes no 'max_depth'; write depth"), ("zzz", "takes no 'zzz'; expected one of depth, split, ")],
)
def test_a_keyword_that_a_problem_does_not_take_is_named_with_the_one_that_is_meant(keyword, words):
    with pytest.raises(TypeError, match=words):
        Problem([[0.0], [1.0]], [0, 1], **{keyword: 3})


@pytest.mark.parametrize(
    ("asked", "bound"),
    [
        ({"depth": 1}, 5.0),  # of 9, 4, 3 and 2 samples two classes are named
        ({"depth": 2}, 0.0),
        ({"depth": 2, "max_splits": 2}, 2.0),
        ({"depth": 2, "max_splits": 0}, 9.0),
        ({"depth": 2, "leaf_penalty": 2.5}, 7.0),  # three classes: 2 and two splits
        ({"depth": 2, "leaf_penalty": 4.0}, 2.0 + 3.0 + 4.0),
        ({"depth": 1, "weights": [3.0] * 9 + [1.0] * 9}, 5.0),
        ({"depth": 1, "weights": [0.5] * 9 + [1.0] * 9}, 5.0 * (1 - 1e-12)),
        (
            {"depth": 1, "loss": ClassCosts([[0, 1, 1, 1], [1, 0, 1, 1], [3, 1, 0, 9], [2, 9, 1, 0]])},
            6.0,
        ),  # the first and the third
        ({"depth": 1, "split": "hyperplane"}, 5.0),
    ],
)
def test_a_tree_names_no_more_classes_than_it_has_leaves(asked, bound):
    targets = np.repeat([0, 1, 2, 3], [9, 4, 3, 2])
    problem = Problem(np.arange(18.0)[:, None] % 5, targets, **asked)
    assert problem.bound_by_labels == pytest.approx(bound, rel=1e-11)
    assert problem.bound_by_labels <= solve(problem.replace(split="axis")).objective


def test_a_tree_that_meets_the_bound_of_its_labels_is_proven_whatever_found_it():
    problem = Problem([[0.0, 1.0], [0.0, 1.1], [2.0, 1.0], [2.0, 1.1], [2.0, 1.2]], [0, 0, 1, 1, 2], depth=1)
    for method in ("cart", "search", "oct_h"):
        solution = solve(problem.replace(split="hyperplane"), method)
        assert (solution.objective, solution.is_optimal) == (1.0, True)
        assert "among" not in str(solution)
