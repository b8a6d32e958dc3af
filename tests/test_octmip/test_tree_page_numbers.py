"""The page of a tree of numbers says what that of classes says, in words of its loss."""

import datetime
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from octmip import AbsoluteError, Problem, QuantileError, SearchOptions, Split, SquaredError, ValueLeaf, solve
from octmip.formats.tree_file import record_tree
from octmip.interfaces.report.html import tree_page
from octmip.interfaces.report.page import Masthead
from octmip.interfaces.report.tree.drawing import draw_tree
from octmip.interfaces.report.tree.evidence import gather, judged_by
from octmip.interfaces.report.tree.measure import measure_of
from octmip.interfaces.report.tree.words import Wording, figure
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.question.losses import Loss
from tests.oracles.page_check import check_page
from tests.test_octmip.test_tree_page import drawn_from

DAY = datetime.date(2026, 3, 1)


def prices(loss: Loss, **asked: Any) -> Problem:
    """Return a problem of numbers that two levels tell apart but for some noise, and one greedy split does not see."""
    rng = np.random.default_rng(2)
    features = rng.normal(size=(120, 3))
    targets = 10 * ((features[:, 0] > 0) == (features[:, 1] > 0)) + rng.normal(0, 0.5, 120).round(2)
    return Problem(features, targets, depth=2, loss=loss, feature_names=("area", "age", "<b>"), **asked)


def number_page(problem: Problem, **options: Any) -> str:
    file = record_tree(problem, solve(problem, **options), "price")
    evidence = judged_by(gather(file, problem, seconds=2.0), file, drawn_from(problem), "new.csv")
    return tree_page(file, "t.json", evidence, data="houses.csv", units={"price": "EUR"}, masthead=Masthead(made=DAY))


@pytest.mark.parametrize("loss", [SquaredError(), AbsoluteError(), QuantileError(0.9)], ids=lambda loss: loss.name)
def test_a_tree_of_numbers_has_the_page_of_a_tree_of_classes_in_words_of_its_loss(loss: Loss):
    problem, page = prices(loss), number_page(prices(loss))
    best, greedy = solve(problem), greedy_tree(problem)
    off = problem.loss.measures(problem.samples.weights, problem.samples.codes, problem.predictions(best.tree))["mae"]
    assert ">Regression tree<" in page
    assert f"On average the tree is off by {figure(off, 4)} over 120 samples" in page
    assert f"Proven: no tree of depth 2 or less with these settings has less {loss.words}." in page
    assert figure(greedy.objective - best.objective, 6) in page
    assert greedy.objective > best.objective
    assert "Recounted for this page: each of the 120 samples of houses.csv" in page
    assert "Is the depth worth it?" in page
    assert f"{loss.words} per held-out sample" in page
    assert "How far off it is" in page
    assert " EUR</text>" in page
    shown = re.sub(r"<(style|script).*?</\1>", "", page, flags=re.DOTALL)
    assert not re.search(r"[{}]|\bNone\b|\bTrue\b|np\.|array\(|class of|wrong", shown)


def test_the_bar_of_a_number_says_where_it_lies_between_the_least_and_the_greatest():
    tree = Split(0, 0.0, ValueLeaf(-2.0), Split(1, 0.0, ValueLeaf(1.0), ValueLeaf(4.0)))
    boxes = draw_tree(tree, Wording(("a", "b"), ()), np.array([[3], [2], [5]])).boxes
    bars = [(box.width, sum(bar.width for bar in box.bars)) for box in boxes if box.label is not None]
    room = bars[0][0] - 18
    assert [width / room for _, width in bars] == pytest.approx([0.0, 0.5, 1.0])


def test_linear_leaves_are_sums_and_count_among_what_the_tree_reads():
    page = number_page(prices(SquaredError(), leaf_model="linear"), options=SearchOptions(restarts=1))
    assert "splits and leaves that read it" in page
    assert "a ridge regression, ridge 0.001" in page
    assert "Its bar says" not in page


def test_shares_of_the_misses_and_their_sides_are_those_of_the_samples():
    problem = Problem([[0.0], [1.0], [2.0], [3.0]], [0.0, 4.0, 10.0, 10.0], depth=1, loss=SquaredError())
    file = record_tree(problem, solve(problem), "y")
    (table,) = measure_of(file).details(gather(file, problem, seconds=0), Wording(("x",), ()))
    assert table["rows"] == [
        ["50 % of the samples", "0"], ["80 % of the samples", "2"], ["95 % of the samples", "2"], ["all samples", "2"],
        ["estimated too high", "1"], ["estimated too low", "1"],
    ]  # fmt: skip


def test_the_page_of_numbers_keeps_all_that_is_checked(browser: Any, tmp_path: Path):
    path = tmp_path / "page.html"
    path.write_text(number_page(prices(SquaredError())))
    assert check_page(path, browser, presses=False) == []  # its script is that of classes
