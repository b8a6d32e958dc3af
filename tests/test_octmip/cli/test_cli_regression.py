"""octmip solve --target, and certify, predict and report of a regression tree."""

import json

import numpy as np
import pandas as pd
import pytest

from octmip.formats.tree_file import read_tree_file
from octmip.trees.question.losses import SPELLINGS, number_loss


@pytest.fixture
def houses(tmp_path):
    """Return a table with text, a name for each row, a weight, and a price that follows area and kind."""
    rng = np.random.default_rng(0)
    area, kind = rng.integers(40, 200, 60), rng.choice(["flat", "house"], 60)
    price = np.where(area > 110, 30.0, 10.0) + 5.0 * (kind == "house") + rng.integers(0, 3, 60)
    frame = pd.DataFrame({"id": [f"h{k}" for k in range(60)], "area": area, "kind": kind, "w": 1 + area % 2})
    frame.assign(price=price).to_csv(tmp_path / "houses.csv", index=False)
    return tmp_path / "houses.csv"


def solved(run, houses, *more):
    chosen = ("--features", "area,kind", "--index", "id", "--depth", 2)
    return run("solve", houses, "--target", "price", *chosen, *more)


@pytest.mark.parametrize("loss", SPELLINGS)
def test_a_tree_is_solved_certified_applied_and_shown(houses, run, tmp_path, loss):
    tree = tmp_path / "t.json"
    code, out, err = solved(run, houses, "--loss", loss, "--out", tree, "--test", houses)
    assert (code, err) == (0, "")
    assert "In training, proven optimal" in out
    assert "area <= 1" in out
    assert f"({number_loss(loss).words})" in out
    code, certified, err = run("certify", tree, houses, "--test", houses)
    assert (code, err) == (0, "")
    assert certified.startswith("certified")
    file = read_tree_file(tree)
    assert file.loss == number_loss(loss)
    assert certified.count(f"{file.solution.objective:.6g}") >= 1
    answer = json.loads(run("predict", tree, houses, "--json")[1])
    table = pd.read_csv(houses)
    assert answer["index"] == table["id"].tolist()
    assert answer["mae"] == pytest.approx(np.abs(np.array(answer["predictions"]) - table["price"]).mean())
    code, lines, _ = run("predict", tree, houses)
    assert lines.splitlines()[1] == f"h0,{answer['predictions'][0]!r}"
    assert "area <= 1" in run("report", tree)[1]
    assert "roven optimal" in run("report", tree, houses)[1]
    assert run("report", tree, "--out", tmp_path / "t.md")[0] == 0
    assert (tmp_path / "t.md").read_text().startswith("| objective |")
    log, problem = tmp_path / "p.log", tmp_path / "p.json"
    code, out, err = solved(run, houses, "--loss", loss, "--proof", log, "--write-problem", problem, "--json")
    assert json.loads(out)["loss"] == json.loads(problem.read_text())["loss"] == file.loss.spelling
    assert log.read_text().startswith(f"octmip-proof 3 regression {file.loss.spelling}\n")
    code, out, err = run("certify", tree, houses, "--proof", log)
    assert (code, err) == (0, "")
    assert "proof: no tree costs less than" in out
    log.write_text(log.read_text().replace("E\n", "", 1))
    code, _, err = run("certify", tree, houses, "--proof", log)
    assert code == 1
    assert "the proof is refused" in err


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--label", "kind"], "named by --label and --target"),
        (["--proof", "p.log", "--method", "search"], "takes no option 'proof'"),
        (["--proof", "p.log", "--leaf-model", "linear"], "have no proof log"),
        (["--write-problem", "p.json", "--leaf-model", "linear"], "of which a problem file says nothing"),
        (["--cluster", "local"], "takes no option 'cluster'"),
        (["--method", "oct"], "expected one of auto, cart, search, exact"),
        (["--leaf-model", "linear", "--method", "exact"], "use method 'cart' or 'search'"),
    ],
)
def test_what_regression_does_not_know_is_refused(houses, refused, options, sentence):
    assert sentence in solved(refused, houses, *options)


def test_a_column_of_words_is_no_target_and_a_loss_needs_one(houses, run):
    assert "is no number" in run("solve", houses, "--target", "kind", "--depth", 1)[2]
    assert "--target" in run("solve", houses, "--label", "kind", "--loss", "squared", "--depth", 1)[2]
    for loss in ("cubic", "quantile", "quantile:1.5", "squared:2"):
        assert "loss" in run("solve", houses, "--target", "price", "--loss", loss, "--depth", 1)[2]
    assert "named by no option" in run("solve", houses, "--depth", 1)[2]


def changed(tree, **training):
    content = json.loads(tree.read_text())
    content["training"] |= training
    content["solution"]["objective"] += 0.5
    tree.write_text(json.dumps(content))


def test_a_changed_file_is_refuted_or_refused(houses, run, tmp_path):
    tree, other = tmp_path / "t.json", tmp_path / "other.csv"
    solved(run, houses, "--out", tree)
    pd.read_csv(houses).iloc[1:].to_csv(other, index=False)
    assert "is not the table" in run("certify", tree, other)[2]
    assert "--proof needs the table" in run("report", tree, "--proof", "p.log")[2]
    changed(tree)
    code, out, err = run("certify", tree, houses)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert "claims objective" in err
    changed(tree, leaf_counts=[[60]])
    assert "leaf_counts has shape (1, 1)" in run("certify", tree, houses)[2]


def test_predict_gives_linear_leaves_the_columns_that_no_split_reads(run, tmp_path):
    rng = np.random.default_rng(3)
    frame = pd.DataFrame(rng.normal(size=(60, 2)).round(3), columns=["a", "b"])
    frame["y"] = np.where(frame["a"] > 0, 3 * frame["b"], 10 - 2 * frame["b"])
    frame.to_csv(tmp_path / "t.csv", index=False)
    more = ("--leaf-model", "linear", "--method", "search", "--out", tmp_path / "t.json")
    assert run("solve", tmp_path / "t.csv", "--target", "y", "--depth", 1, *more)[0] == 0
    answer = json.loads(run("predict", tmp_path / "t.json", tmp_path / "t.csv", "--json")[1])
    certified = json.loads(run("certify", tmp_path / "t.json", tmp_path / "t.csv", "--json")[1])
    assert answer["mae"] == pytest.approx(certified["mae"])
    assert answer["mae"] < 0.5


def test_a_far_target_is_solved_and_the_tolerance_of_a_proof_is_printed(run, tmp_path):
    table, tree = tmp_path / "far.csv", tmp_path / "t.json"
    table.write_text("x,w,price\n0,.1,1000000000.3\n1,.3,.1\n2,.7,.2\n3,.9,5\n")
    asked = ("solve", table, "--target", "price", "--weights", "w")
    code, out, err = run(*asked, "--depth", 2)
    assert (code, err) == (0, "")
    assert out.startswith("objective 0, bound 0: proven optimal (squared error)")
    code, out, err = run(*asked, "--depth", 1, "--out", tree)
    assert (code, err) == (0, "")
    solution = read_tree_file(tree).solution
    assert solution.is_optimal
    assert f"proven optimal within {solution.tolerance:.1g} (squared error)" in out
    assert 0 < json.loads(run(*asked, "--depth", 1, "--json")[1])["tolerance"] < 1e-8 * solution.objective


@pytest.mark.parametrize("loss", ["squared", "absolute", "quantile:0.9"])
def test_numbers_are_compared_and_have_a_frontier_by_the_measures_of_their_loss(houses, run, loss):
    words = (houses, "--target", "price", "--loss", loss, "--features", "area,kind", "--depth", 2)
    rows = json.loads(run("compare", *words, "--holdout", 0.25, "--json")[1])["rows"]
    assert all("finds no axis trees" in row["error"] for row in rows[3:])
    rows = rows[:3]
    assert [row["method"] for row in rows] == ["cart", "search", "exact"]
    assert rows[2]["is_optimal"]
    assert min(row["objective"] for row in rows) == rows[2]["objective"]
    assert all(row["held_out"]["mae"] >= 0 for row in rows)
    assert "| mae held out |" in " ".join(run("compare", *words, "--holdout", 0.25)[1].split())
    points = json.loads(run("frontier", *words, "--over", "depth", "--json")[1])["rows"]
    assert [point["depth"] for point in points] == [1, 2]
    (whole,) = json.loads(run("compare", *words, "--methods", "exact", "--json")[1])["rows"]
    assert points[1]["objective"] == whole["objective"] < points[0]["objective"]


@pytest.mark.parametrize("command", ["near-optimal", "sensors"])
def test_commands_about_classes_say_so_of_a_target_of_numbers(houses, refused, command):
    said = refused(command, houses, "--target", "price", "--depth", 1)
    assert "this command is about classes; name a column of them with --label" in said
