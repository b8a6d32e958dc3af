"""The models beside a tree: which a problem has, what they predict, and how the command shows them."""

import json

import numpy as np
import pytest
from sklearn.datasets import load_iris
from sklearn.metrics import roc_auc_score

from octmip import ClassCosts, Leaf, Problem, Split, SquaredError
from octmip.errors import ProblemError
from octmip.interfaces.cli.answer import score_json
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.nodes.tree import leaf_index
from octmip.trees.tradeoff.baselines import baselines_of
from octmip.trees.tradeoff.held_out import Samples, beside_cart, held_out_rows, score, score_of

X, Y = load_iris(return_X_y=True)
IRIS = Problem(X, Y, depth=1)


def test_every_baseline_of_classes_predicts_indices_of_classes():
    named = IRIS.replace(targets=np.array(["a", "b", "c"])[Y], class_names=None, class_order=None)
    found = baselines_of(named)
    assert set(found) == {"linear", "discriminant", "pruned CART", "forest", "boosting"}
    for name, train in found.items():
        assert score_of(named, train(0)).errors <= 6, name


def test_a_line_is_rounded_to_the_nearest_class():
    values = np.array([0.0, 20.0, 40.0])
    x = np.linspace(-0.4, 2.4, 57)
    x = x[np.abs(x % 1 - 0.5) > 0.01][:, None]
    problem = Problem(x, values[np.clip(np.round(x[:, 0]), 0, 2).astype(int)], depth=1)
    slope, offset = np.polyfit(x[:, 0], np.array(problem.samples.class_names)[problem.samples.codes], 1)
    nearest = np.abs((slope * x + offset) - values).argmin(axis=1)
    assert (baselines_of(problem)["rounded"](0)(x) == nearest).all()


def test_numbers_have_no_classes_and_weights_leave_out_what_takes_none():
    numbers = Problem(X[:, :3], X[:, 3], depth=1, loss=SquaredError())
    assert set(baselines_of(numbers)) == {"linear", "pruned CART", "forest", "boosting"}
    for name, train in baselines_of(numbers).items():
        assert score_of(numbers, train(0)).measures["rmse"] < 0.25, name
    assert "discriminant" not in baselines_of(IRIS.replace(weights=1 + Y))


@pytest.mark.long("-0.001-1e-12")
@pytest.mark.parametrize(("offset", "unit"), [(1e9, 1.0), (-1e-3, 1e-12)])
def test_offset_and_unit_of_the_numbers_change_no_baseline_and_not_cart(offset, unit):
    rows = np.arange(40.0)[:, None]
    steps = np.repeat([0.0, 1.0, 3.0, 4.0], 10)
    plain, moved = (Problem(rows, numbers, depth=2, loss=SquaredError()) for numbers in (steps, offset + unit * steps))
    leaves = [leaf_index(greedy_tree(problem).tree, rows).tolist() for problem in (plain, moved)]
    assert leaves[0] == leaves[1] == np.repeat(range(4), 10).tolist()
    for name, train in baselines_of(moved).items():
        found = (train(0)(rows) - offset) / unit
        assert found == pytest.approx(baselines_of(plain)[name](0)(rows), abs=1e-3), name


def test_weights_count():
    heavy = Problem([[0.0], [0], [0], [1]], ["a", "b", "b", "b"], depth=1, weights=[9, 1, 1, 1])
    assert baselines_of(heavy)["linear"](0)(np.zeros((1, 1))).tolist() == [0]


def test_missing_readings_are_no_error():
    features = X.copy()
    features[::7, 2] = np.nan
    lacking = Problem(features, Y, depth=1)
    for name, train in baselines_of(lacking).items():
        assert score_of(lacking, train(0)).errors < 20, name


@pytest.mark.long("False")
@pytest.mark.parametrize("as_json", [False, True])
def test_the_command_shows_them_in_training_and_on_rows_held_out(as_json, tmp_path, capsys):
    from octmip.interfaces.cli import main

    table = tmp_path / "table.csv"
    np.savetxt(table, np.column_stack([X, Y]), delimiter=",", header="a,b,c,d,y", comments="", fmt="%g")
    words = ["compare", str(table), "--label", "y", "--depth", "1", "--methods", "cart", "--holdout", "0.3"]
    assert main([*words, "--baselines", *(["--json"] if as_json else [])]) == 0
    out = capsys.readouterr().out
    if as_json:
        rows = json.loads(out)["baselines"]
        assert [row["method"] for row in rows] == [
            "linear",
            "discriminant",
            "rounded",
            "pruned CART",
            "forest",
            "boosting",
        ]
        assert all(row["n_samples"] + row["held_out"]["n_samples"] == 150 for row in rows)
        held = {row["method"]: row["held_out"] for row in rows}
        assert held["forest"]["mean_auroc"] == pytest.approx(np.mean(held["forest"]["auroc"]))
        assert "auroc" not in held["rounded"]
    else:
        assert "| pruned CART" in out
        assert "errors held out | balanced accuracy held out | AUROC held out |" in out


def test_each_class_gives_its_share_but_never_its_last_row():
    labels = np.array(["a"] * 40 + ["b"] * 10 + ["c"])
    is_held = held_out_rows(labels, 0.25, seed=3)
    assert [int(is_held[labels == name].sum()) for name in "abc"] == [10, 3, 0]
    assert (held_out_rows(labels, 0.25, seed=3) == is_held).all()
    assert (held_out_rows(labels, 0.25, seed=4) != is_held).any()
    assert held_out_rows(labels, 0.99, seed=0).sum() == 48


def test_the_rows_are_those_of_every_version():
    assert np.flatnonzero(held_out_rows(np.array([0, 1] * 6), 0.5, seed=0)).tolist() == [0, 3, 4, 7, 9, 10]


@pytest.mark.parametrize("seed", range(5))
def test_rows_of_a_table_that_the_same_seed_drew_are_held_out_whatever_they_read(seed):
    drawn = np.random.default_rng(seed).random(2000)
    held = drawn[held_out_rows(np.zeros(2000), 0.25, seed)]
    assert abs(held.mean() - 0.5) < 4 * np.sqrt(1 / 12 / len(held))


@pytest.mark.parametrize("share", [0.0, 1.0, -0.1, float("nan"), 0.01])
def test_a_share_that_holds_nothing_out_is_refused(share):
    with pytest.raises(ProblemError, match=r"share"):
        held_out_rows(np.array([0, 1] * 5), share, seed=0)


def test_tree_and_cart_are_counted_on_both_parts():
    problem = Problem([[0.0], [1.0], [2.0]], [0, 1, 1], depth=1, weights=[1, 2, 3], loss=ClassCosts([[0, 4], [5, 0]]))
    held = Samples(np.array([[0.0], [3.0], [0.4]]), np.array([1, 1, 0]), np.array([1.0, 1.0, 2.0]))
    found = beside_cart(problem, Leaf(0), held)
    assert (found.training.n_samples, found.training.errors, found.training.cost) == (3, 2, 25)
    assert found.held_out is not None
    assert (found.held_out.errors, found.held_out.cost, found.held_out.error_rate) == (2, 10, pytest.approx(2 / 3))
    assert found.cart_tree == Split(0, 0.5, Leaf(0), Leaf(1))
    assert (found.cart_training.errors, found.cart_held_out.errors, found.cart_held_out.cost) == (0, 1, 5)
    assert beside_cart(problem, Leaf(0)).held_out is None
    assert score(problem, Leaf(1), held).errors == 1


def test_the_roc_is_that_of_scikit_learn_and_equal_shares_are_one_step():
    rng = np.random.default_rng(0)
    rows, labels = rng.integers(0, 5, (300, 2)).astype(float), rng.integers(0, 3, 300)
    problem, held = Problem(rows[:200], labels[:200], depth=3), Samples(rows[200:], labels[200:], np.ones(100))
    tree = greedy_tree(problem).tree
    trained, reached = (leaf_index(tree, some) for some in (rows[:200], held.features))
    by_leaf = np.array([(labels[:200][trained == leaf][:, None] == range(3)).mean(axis=0) for leaf in reached])
    model = baselines_of(problem)["linear"](0)
    for found, shares in (
        (score(problem, tree, held), by_leaf),
        (score_of(problem, model, held), model.shares(rows[200:])[1]),
    ):
        expected = [roc_auc_score(held.codes == label, shares[:, label]) for label in range(3)]
        assert found.rank().auroc == pytest.approx(expected, abs=1e-12)
    curve = score(problem, tree, held).rank().roc(0)
    assert curve.shape == (2, len(np.unique(by_leaf[:, 0])) + 1)
    assert curve[:, [0, -1]].tolist() == [[0, 1], [0, 1]]
    alone = Samples(rows[:5], np.zeros(5, dtype=np.int64), np.ones(5))
    assert np.isnan(score(problem, tree, alone).rank().auroc).all()
    assert score_json(score(problem, tree, alone))["mean_auroc"] is None
