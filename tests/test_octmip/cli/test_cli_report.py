"""octmip report with the data: what is recounted, compared and held out, as words, Markdown and a page."""

import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest


@pytest.fixture
def solved(data: Path, run: Any, tmp_path: Path) -> Path:
    path = tmp_path / "two.json"
    words = ("--label", "y", "--depth", 2, "--features", "a,b", "--out", path, "--proof", tmp_path / "two.log")
    assert run("solve", data, *words)[0] == 0
    return path


def page_of(run: Any, tmp_path: Path, *words: Any) -> str:
    code, _, err = run("report", *words, "--out", tmp_path / "page.html")
    assert (code, err) == (0, "")
    text = (tmp_path / "page.html").read_text()
    return re.sub(r"\s+", " ", re.sub(r"<(style|script).*?</\1>", "", text, flags=re.DOTALL))


def test_the_page_of_a_tree_and_its_data_recounts_compares_and_checks_the_proof(run, data, solved, tmp_path):
    page = page_of(run, tmp_path, solved, data, "--proof", tmp_path / "two.log", "--unit", "a=mm")
    assert "A decision tree for y" in page
    assert "each of the 30 samples of data.csv was sent through the tree again" in page
    assert "Proof log checked for this page" in page
    assert re.search(r"≤ [\d.]+ mm\?", page)
    assert "Is the depth worth it?" in page


def test_a_test_table_and_samples_held_out_in_training_judge_the_page_s_own_tree(run, data, tmp_path):
    tree = tmp_path / "held.json"
    run("solve", data, "--label", "y", "--depth", 1, "--features", "a,b", "--holdout", 0.3, "--out", tree)
    assert "9 samples of data.csv, held out before the training" in page_of(run, tmp_path, tree, data)
    frame = pd.read_csv(data)
    frame.head(10).to_csv(tmp_path / "test.csv", index=False)
    assert "10 samples of test.csv" in page_of(run, tmp_path, tree, data, "--test", tmp_path / "test.csv")


def test_a_drawing_has_histograms_a_dark_ground_and_units_when_asked(run, data, solved, tmp_path):
    drawn = []
    for words in ((), (data, "--unit", "a=mm", "--histograms", "--dark", "--seconds", 0)):
        assert run("report", solved, *words, "--out", tmp_path / "tree.svg")[0] == 0
        drawn.append((tmp_path / "tree.svg").read_text())
    assert ["#14171b" in text for text in drawn] == [False, True]
    assert ["mm?" in text for text in drawn] == [False, True]
    assert drawn[1].count("<path") > drawn[0].count("<path") + 5
    pages = [page_of(run, tmp_path, solved, data, "--seconds", 0, *words) for words in ((), ("--histograms",))]
    assert pages[1].count('<rect class="class-') > pages[0].count('<rect class="class-')


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--test", "DATA"), "--test needs the table"),
        (("--histograms", "--out", "tree.svg"), "--histograms needs the training table"),
        (("--dark", "--out", "page.html"), "--dark is for pictures"),
        (("DATA", "--unit", "w=kg"), "'w', which is no column of numbers"),
        (("DATA", "--seconds", "nan"), "--seconds is nan"),
    ],
)
def test_what_cannot_be_reported_is_refused_with_a_cure(refused, data, solved, words, said):
    assert said in refused("report", solved, *(data if word == "DATA" else word for word in words))


def test_predict_needs_only_the_features_that_the_tree_reads(run, refused, tree, tmp_path):
    (tmp_path / "new.csv").write_text("a\n3\n20\n")
    assert run("predict", tree, tmp_path / "new.csv")[1].split() == ["prediction", "low", "high"]
    (tmp_path / "new.csv").write_text("b\n3\n")
    assert "'a' is not in the table" in refused("predict", tree, tmp_path / "new.csv")


def test_labels_unseen_at_training_are_refused(data, refused, tree):
    data.write_text(data.read_text().replace("low", "lower"))
    for command in (["certify", tree, data], ["predict", tree, data, "--label", "y"]):
        assert "line 2, column 'y': label 'lower' was not seen at training" in refused(*command)
