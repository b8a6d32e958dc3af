"""octmip certify, predict and report: a tree file recounted, refuted, applied and shown."""

import json

import pandas as pd
import pytest

from octmip import Problem
from tests.oracles.proof_log import proof_log


def broken(tree, change):
    content = json.loads(tree.read_text())
    change(content)
    tree.write_text(json.dumps(content))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda file: file["solution"].update(objective=0.0), "claims objective 0.0 but the tree's own"),
        (lambda file: file["problem"].update(leaf_size=15), "leaf_size is 15"),
        (lambda file: file["training"].update(sha256="0" * 64), "is not the table"),
    ],
)
def test_certify_refutes_a_file_changed_by_hand(data, run, tree, change, sentence):
    broken(tree, change)
    code, out, err = run("certify", tree, data)
    assert code == 1
    assert out == ""
    assert sentence in err
    assert err.count("\n") == 1


def test_certify_checks_a_proof_log_of_the_tree(data, run, tree, tmp_path):
    frame = pd.read_csv(data)
    names = ("a", "b")
    problem = Problem(frame[list(names)].to_numpy(), frame["y"].to_numpy(), depth=1, feature_names=names)
    broken(tree, lambda file: file["solution"].update(bound=1.0, stop="optimal"))
    log = tmp_path / "proof.log"
    log.write_text(proof_log(problem))
    code, out, err = run("certify", tree, data, "--proof", log)
    assert code == 0, err
    assert "proof: no tree costs less than 1; " in out
    assert json.loads(run("certify", tree, data, "--proof", log, "--json")[1])["proof"]["bound"] == 1
    log.write_text(proof_log(problem)[:-20])
    code, out, err = run("certify", tree, data, "--proof", log)
    assert code == 1
    assert out == ""
    assert "proof is refused" in err
    assert err.count("\n") == 1
    code, _, err = run("certify", tree, data, "--proof", tmp_path / "none.log")
    assert code == 2
    assert "none.log cannot be read" in err


def test_predict_writes_one_line_for_each_row(data, run, tree, tmp_path):
    code, out, err = run("predict", tree, data)
    assert code == 0
    assert out.splitlines() == ["prediction"] + ["low"] * 12 + ["high"] * 18
    assert err == ""
    code, out, err = run("predict", tree, data, "--label", "y", "--out", tmp_path / "p.csv", "--proba")
    assert code == 0
    assert out == ""
    assert "1 of 30 samples wrong" in err
    shares = pd.read_csv(tmp_path / "p.csv")
    assert list(shares.columns) == ["prediction", "share of high", "share of low"]
    assert shares.iloc[-1, 1] == pytest.approx(17 / 18)
    answer = json.loads(run("predict", tree, data, "--label", "y", "--json")[1])
    assert answer["errors"] == 1
    assert len(answer["predictions"]) == 30
    assert "probabilities_made" not in answer


def test_predict_needs_only_the_features_that_the_tree_reads(run, tree, tmp_path):
    (tmp_path / "new.csv").write_text("a\n3\n20\n")
    assert run("predict", tree, tmp_path / "new.csv")[1].split() == ["prediction", "low", "high"]
    (tmp_path / "new.csv").write_text("b\n3\n")
    code, _, err = run("predict", tree, tmp_path / "new.csv")
    assert code == 2
    assert "'a' is not in the table" in err


@pytest.mark.parametrize("command", ["certify", "predict", "report"])
@pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "pmml"}', '{"format": "octmip-tree", "version": 4}'])
def test_a_bad_tree_file_ends_in_one_line(data, run, tmp_path, command, content):
    (tmp_path / "bad.json").write_text(content)
    words = [] if command == "report" else [data]
    code, out, err = run(command, tmp_path / "bad.json", *words)
    assert code == 2
    assert out == ""
    assert "bad.json" in err
    assert err.count("\n") == 1


def test_labels_unseen_at_training_are_refused(data, run, tree):
    data.write_text(data.read_text().replace("low", "lower"))
    for command in (["certify", tree, data], ["predict", tree, data, "--label", "y"]):
        code, _, err = run(*command)
        assert code == 2
        assert "line 2, column 'y': label 'lower' was not seen at training" in err
