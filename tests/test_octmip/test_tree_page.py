"""The page of a tree says what the tree does, in words, and every control of it works by mouse and by keyboard."""

import dataclasses
import datetime
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from octmip import (
    HyperplaneSplit,
    Leaf,
    Problem,
    Solution,
    Split,
    Stop,
    solve,
)
from octmip.formats.columns import Columns
from octmip.formats.table.preparation import Preparation
from octmip.formats.tree_file import TreeFile, record_tree
from octmip.input.names import html_text
from octmip.interfaces.report.html import tree_page
from octmip.interfaces.report.page import Masthead
from octmip.interfaces.report.tree.embedded import MOST_CELLS, MOST_ROWS, sample_data
from octmip.interfaces.report.tree.evidence import gather, judged_by
from octmip.interfaces.report.tree.measure import measure_of
from octmip.interfaces.report.tree.words import Wording, compact, figure, listed, percent, question
from octmip.trees.nodes.tree import leaf_index, leaves
from octmip.trees.tradeoff.held_out import Samples
from tests.oracles.hostile_names import hostile_names
from tests.oracles.page_check import check_page
from tests.oracles.report_runs import tree_file

DAY = datetime.date(2026, 3, 1)


def xor(n: int = 200, depth: int = 2) -> Problem:
    """Return a problem that two levels solve and one greedy split does not see."""
    features = np.random.default_rng(0).normal(size=(n, 3))
    labels = np.where((features[:, 0] > 0) == (features[:, 1] > 0), "same", "different")
    return Problem(features, labels, depth=depth, feature_names=("g01", "g02", "<b>"))


def drawn_from(problem: Problem) -> Samples:
    """Return a quarter of the samples, as if they were others."""
    rows = np.random.default_rng(0).permutation(problem.samples.n_samples)[: problem.samples.n_samples // 4]
    return Samples(problem.samples.features[rows], problem.samples.codes[rows], problem.samples.weights[rows])


@pytest.fixture(scope="module")
def xor_page() -> str:
    problem = xor()
    file = record_tree(problem, solve(problem), "side")
    evidence = judged_by(gather(file, problem), file, drawn_from(problem), "new.csv")
    return tree_page(
        file, "t.json", evidence, data="xor.csv", units={"g01": "microstrain"}, masthead=Masthead(made=DAY)
    )


def mixed() -> tuple[TreeFile, Problem, pd.DataFrame]:
    """Return a tree over text, an order and missing cells."""
    rng = np.random.default_rng(1)
    n = 300
    table = pd.DataFrame(
        {
            "age": np.where(rng.random(n) < 0.2, np.nan, rng.integers(18, 90, n).astype(float)),
            "colour": rng.choice(["red", "green", "blue"], n),
        }
    )
    labels = np.where(table.colour.eq("red") & (table.age.isna() | (table.age > 40)), "ill", "well")
    columns = Columns.learn(table)
    problem = Problem(columns.encode(table), labels, depth=2, feature_names=columns.feature_names)
    return record_tree(problem, solve(problem), "state", preparation=Preparation(columns)), problem, table


@pytest.mark.parametrize(
    ("value", "words"),
    [(0, "0"), (1550.0, "1,550"), (-2.5, "\u22122.5"), (1039.4102, "1,039.41"), (1 / 3, "0.333333"),
     (float("inf"), "\u2013"), (1.2e-7, "1.2 \u00d7 10\u207b\u2077"), (2e20, "2 \u00d7 10\u00b2\u2070"),
     (1234567.8, "1,234,568")],
)  # fmt: skip
def test_numbers_are_written_for_readers(value: float, words: str):
    assert figure(value) == words


def test_shares_and_lists_are_written_for_readers():
    assert html_text(compact(4.72e11)) == "4.72\u00d710\u00b9\u00b9"
    assert [percent(share) for share in (0.0, 0.005167, 0.0811, 1.0)] == ["0 %", "0.52 %", "8.1 %", "100 %"]
    assert listed(["a", "b", "c", "d"], 3) == "a, b and 2 more"


def test_a_split_is_a_question_in_words_of_the_table():
    file, _, _ = mixed()
    asked = [question(split, Wording(file.feature_names, file.class_names, file.columns, {"age": "years"})) for split in
             (Split(file.feature_names.index("colour is red"), 0.5, Leaf(0), Leaf(1)),
              Split(file.feature_names.index("age"), 40.5, Leaf(0), Leaf(1), missing="left"),
              Split(file.feature_names.index("age"), None, Leaf(0), Leaf(1), missing="left"),
              Split(file.feature_names.index("age"), 40.5, Leaf(0), Leaf(1), missing="right"))]  # fmt: skip
    assert [(one.text, one.yes_is_left) for one in asked] == [
        ("colour is red", False),
        ("age \u2264 40.5 years or missing", True),
        ("age is missing", True),
        ("age \u2264 40.5 years", True),
    ]
    weighted = HyperplaneSplit((0, 1), (-2.0, 1.0), 1 / 3, Leaf(0), Leaf(1))
    assert question(weighted, Wording(("a", "b"), (0, 1))).text == "\u2212 2 a + b \u2264 0.3333333333333333"


def test_the_top_says_what_is_decided_how_well_whether_proven_and_what_greedy_loses(xor_page: str):
    assert "A decision tree for side" in xor_page
    assert re.search(r"gets 200 of 200 samples right \(100 %\)\. No tree can do better on them\.", xor_page)
    assert re.search(r"The usual greedy tree \(CART\) makes \d+ more errors\.", xor_page)
    assert "Recounted for this page: each of the 200 samples of xor.csv" in xor_page
    assert "1 March 2026" in xor_page
    assert re.search(r"; boosting of a hundred trees or more: \d+ of 50 samples wrong .*; forest of", xor_page)
    assert "\u2264 0.00" in xor_page.replace("\u2264 \u2212", "\u2264 ")
    assert "microstrain?" in xor_page


def test_a_tree_file_alone_makes_a_page_that_says_what_it_lacks():
    problem = xor()
    tree = Split(0, 0.0, Leaf(0), Leaf(1))
    claim = Solution(tree, problem.objective(tree), 7.2, Stop.TIME, 1.0, 1, "search", "1", 0)
    page = tree_page(record_tree(problem, claim), "t.json")
    assert "Nothing was recounted for this page" in page
    assert "no tree of depth 2 or less with these settings has less than 8 errors" in page
    assert "<h1>A decision tree</h1>" in page


def test_the_confusion_has_the_true_class_in_rows():
    labels = ["yes", "no", "yes", "yes"]
    problem = Problem(np.array([[0.0], [1], [2], [3]]), labels, depth=1, feature_names=("a",))
    stump = Split(0, 0.5, Leaf(1), Leaf(0))  # right for the first sample and the second
    page = tree_page(
        record_tree(problem, Solution(stump, 2.0, 0.0, Stop.TIME, 0.0, 1, "search", "1", 0), "y"), "t.json"
    )
    cells = [re.findall(r"<t[dh][^>]*>([^<]*)", row) for row in re.findall(r"<tr>.*?</tr>", page)]
    table = cells.index(["true class", "no", "yes", "all", "recall"])
    assert cells[table + 1 : table + 4] == [
        ["no", "1", "0", "1", "100 %"],
        ["yes", "2", "1", "3", "33.3 %"],
        ["precision", "33.3 %", "100 %", "", ""],
    ]
    assert "balanced accuracy 66.7 %" in page


def test_rows_held_out_have_the_roc_of_each_class(xor_page: str):
    assert len(re.findall(r"<th [^>]*>recall</th><th [^>]*>AUROC</th>", xor_page)) == 1
    lines = re.findall(r'<path class="line class-(.)" d="M([^"]*)"><title>(.*?)</title>', xor_page)
    of_all_found = "58.0 208.0L58.0 14.0L328.0 14.0"
    assert lines == [("0", of_all_found, "different: AUROC 1"), ("1", of_all_found, "same: AUROC 1")]


def test_a_leaf_alone_is_a_tree_too():
    problem = Problem(np.array([[0.0], [1], [2]]), ["b", "a", "a"], depth=1, feature_names=("a",))
    file = record_tree(problem, Solution(Leaf(0), 1.0, 0.0, Stop.TIME, 0.0, 1, "search", "1", 0), "y")
    page = tree_page(file, "t.json", gather(file, problem))
    assert "by no question about nothing" not in page
    assert "The tree asks nothing: one answer for every sample." in page
    assert "0 instead of 1" in page  # the greedy tree is better, and the page says so


def test_depths_end_with_the_tree_of_the_file_and_never_rise():
    problem = xor(depth=3)
    file = record_tree(problem, solve(problem), "side")
    points = gather(file, problem).depths
    assert [point.depth for point in points] == [1, 2, 3]
    assert [point.objective for point in points] == sorted((point.objective for point in points), reverse=True)
    assert points[-1].objective == file.solution.objective
    assert all(point.bound <= point.objective for point in points)


def test_the_samples_in_a_page_are_those_of_their_leaf_and_no_more_than_there_is_room_for():
    n = 20_000
    features = np.random.default_rng(0).normal(size=(n, 100))
    problem = Problem(features, (features[:, 7] > 0).astype(int), depth=1)
    tree = Split(7, 0.0, Leaf(0), Leaf(1))
    file = record_tree(problem, Solution(tree, 0.0, 0.0, Stop.OPTIMAL, 0.0, 1, "exact", "1", 0))
    evidence = gather(file, problem, seconds=0)
    data = sample_data(evidence, measure_of(file), Wording(problem.samples.feature_names, problem.samples.class_names))
    assert [len(rows) for rows in data["leaves"]] == [MOST_ROWS, MOST_ROWS]
    assert data["columns"][0] == problem.samples.feature_names[7]
    assert len(data["columns"]) == 12
    reached = leaf_index(tree, problem.samples.features)
    assert all(reached[row[0] - 1] == leaf for leaf, rows in enumerate(data["leaves"]) for row in rows)
    assert sum(len(row) for rows in data["leaves"] for row in rows) <= MOST_CELLS + 3 * 2 * MOST_ROWS
    assert len(tree_page(file, "t.json", evidence)) < 200_000


def test_the_page_keeps_all_that_is_checked(browser: Any, tmp_path: Path, xor_page: str):
    path = tmp_path / "page.html"
    path.write_text(xor_page)
    assert check_page(path, browser) == []


def test_a_page_of_hostile_names_keeps_all_that_is_checked(browser: Any, tmp_path: Path):
    path = tmp_path / "page.html"
    names = [name for _, name in hostile_names(20, 1)]
    path.write_text(tree_page(tree_file(names), names[3]))
    assert check_page(path, browser, presses=False) == []


def _walk_by_keyboard(page: Any, answers: list[str]) -> str:
    for answer in answers:
        page.keyboard.type(answer)
        page.keyboard.press("Enter")
    return str(page.locator("#answer .result").inner_text())


def test_a_case_finds_its_leaf_by_keyboard_and_by_mouse(browser: Any, tmp_path: Path, xor_page: str):
    path = tmp_path / "page.html"
    path.write_text(xor_page)
    page = browser.new_page()
    page.goto(path.as_uri())
    page.locator("#ask input").focus()
    assert _walk_by_keyboard(page, ["-1.5", "-0.7"]) == "Answer: side is same"
    assert page.locator("#tree .node.lit").count() == 3
    assert page.locator("#tree .leaf.lit").count() == 1
    page.locator("#answer button").click()
    assert "Leaf: side is same" in page.locator("#detail").inner_text()
    page.locator("#again").click()
    while page.locator("#ask").is_visible():
        page.locator("#ask button", has_text="Yes").click()
    assert page.locator("#trail li").count() == 2
    page.close()


def test_every_training_sample_goes_the_same_way_in_the_page_and_in_the_tree(browser: Any, tmp_path: Path):
    file, problem, table = mixed()
    path = tmp_path / "page.html"
    path.write_text(tree_page(file, "t.json", dataclasses.replace(gather(file, problem, seconds=0), table=table)))
    page = browser.new_page()
    page.goto(path.as_uri())
    reached, labels = leaf_index(file.tree, problem.samples.features), [leaf.label for leaf in leaves(file.tree)]
    for row in range(5):
        while page.locator("#ask").is_visible():
            if page.locator("#ask select").count():
                page.locator("#ask select").select_option(label=str(table.colour[row]))
            else:
                page.locator("#ask input").fill("" if pd.isna(table.age[row]) else str(table.age[row]))
            page.locator("#ask button.main").click()
        expected = file.class_names[labels[reached[row]]]
        assert page.locator("#answer .result").inner_text() == f"Answer: state is {expected}"
        page.locator("#again").click()
    page.close()
