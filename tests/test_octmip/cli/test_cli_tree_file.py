"""octmip certify, predict and report: a tree file recounted, refuted, applied and shown."""

import json

import pytest


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


def test_predict_needs_only_the_features_that_the_tree_reads(run, tree, tmp_path):
    (tmp_path / "new.csv").write_text("a\n3\n20\n")
    assert run("predict", tree, tmp_path / "new.csv")[1].split() == ["prediction", "low", "high"]
    (tmp_path / "new.csv").write_text("b\n3\n")
    code, _, err = run("predict", tree, tmp_path / "new.csv")
    assert code == 2
    assert "'a' is not in the table" in err


def test_labels_unseen_at_training_are_refused(data, run, tree):
    data.write_text(data.read_text().replace("low", "lower"))
    for command in (["certify", tree, data], ["predict", tree, data, "--label", "y"]):
        code, _, err = run(*command)
        assert code == 2
        assert "line 2, column 'y': label 'lower' was not seen at training" in err
