"""The one drawing of a tree, as SVG and as a figure: places, words that fit, histograms, spreads, the way of a row."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.patches import FancyBboxPatch

from octmip import HyperplaneSplit, Leaf, OptimalTreeClassifier, Problem, Split, SquaredError
from octmip.errors import ProblemError
from octmip.interfaces.estimator.paths import node_indicator
from octmip.interfaces.plot import tree_figure
from octmip.interfaces.plot.style import DARK
from octmip.interfaces.report.tree.drawing import draw_tree
from octmip.interfaces.report.tree.seen import Seen
from octmip.interfaces.report.tree.svg import drawing_svg
from octmip.interfaces.report.tree.words import Wording
from octmip.trees.answer.certificate import leaf_counts
from octmip.trees.nodes.tree import ValueLeaf

RNG = np.random.default_rng(0)
POINTS = RNG.normal(size=(200, 2))
PROBLEM = Problem(POINTS, RNG.integers(0, 3, 200), depth=3)
TREE = Split(0, 0.1, Split(1, -0.3, Leaf(0), Leaf(1)), Split(1, 0.4, Split(0, 0.8, Leaf(2), Leaf(0)), Leaf(1)))


def drawing_of(problem, tree, histograms=False, way=None):
    names = Wording(problem.samples.feature_names, problem.samples.class_names)
    return draw_tree(tree, names, leaf_counts(problem, tree), seen=Seen.of(problem, tree, histograms), way=way)


@pytest.mark.parametrize("histograms", [False, True])
def test_no_box_of_a_drawing_lies_on_another(histograms):
    long = Problem(POINTS, PROBLEM.samples.codes, depth=3, feature_names=("a" * 90, "b"), class_names=(0, 1, 2))
    drawing = drawing_of(long, TREE, histograms)
    places = [(b.left, b.left + b.width, b.y, b.y + b.height) for b in drawing.boxes]
    assert all(left >= 0 and right <= drawing.width and bottom <= drawing.height for left, right, _, bottom in places)
    for one, other in combinations(places, 2):
        assert one[1] <= other[0] or other[1] <= one[0] or one[3] <= other[2] or other[3] <= one[2]
    for box in drawing.boxes:
        assert all(box.text_places[-1][1] < bar.y and bar.y + bar.height < box.y + box.height for bar in box.bars)
    assert [box.index for box in drawing.boxes] == list(range(len(drawing.boxes)))


@pytest.mark.parametrize("name", ["OQGDHN" * 3, "漢字", "illicit wares " * 9])
def test_every_text_of_a_figure_lies_in_its_box(name):
    labels = np.array([name, "a", "b"])[PROBLEM.samples.codes]
    problem = Problem(POINTS, labels, depth=2, feature_names=(name, "b"))
    low = Split(0, -123456.5, Leaf(0), HyperplaneSplit((0, 1), (2.5, -1.25), 1.5, Leaf(1), Leaf(2)))
    figure = tree_figure(problem, low, histograms=True)
    draw = FigureCanvasAgg(figure).get_renderer()
    frames = [patch.get_window_extent(draw) for patch in figure.axes[0].patches if isinstance(patch, FancyBboxPatch)]
    texts = [text for text in figure.axes[0].texts if text.get_text() not in ("yes", "no")]
    assert len(texts) > 2 * len(frames)
    for text in texts:
        place = text.get_window_extent(draw)
        assert any(f.x0 <= place.x0 and place.x1 <= f.x1 and f.y0 <= place.y0 and place.y1 <= f.y1 for f in frames), (
            text.get_text()
        )


def test_bars_left_of_the_mark_are_the_samples_that_go_left():
    box = drawing_of(PROBLEM, TREE, histograms=True).boxes[1]
    here = POINTS[:, 0] <= 0.1
    codes, goes_left = PROBLEM.samples.codes[here], POINTS[here, 1] <= -0.3
    high = sum(bar.height for bar in box.bars)
    for label in range(3):
        left = sum(bar.height for bar in box.bars if bar.label == label and bar.x < box.mark[0] - 1e-9)
        assert left / high == pytest.approx(((codes == label) & goes_left).mean())
    assert not any(box.bars for box in drawing_of(PROBLEM, TREE).boxes if box.label is None)


def test_a_leaf_of_a_number_shows_how_far_its_samples_spread():
    values = np.array([[0.0], [0.0], [1.0], [1.0]])
    tree = Split(0, 0.5, ValueLeaf(2.0), ValueLeaf(10.0))
    problem = Problem(values, [1.0, 3.0, 10.0, 16.0], weights=[1, 1, 3, 1], depth=1, loss=SquaredError())
    left, right = drawing_of(problem, tree).boxes[1:]
    assert left.text.lines == ("2", "± 1", "2, 50 %")
    assert right.text.lines == ("10", "± 3", "2, 50 %")
    assert "± 3" in [text.get_text() for text in tree_figure(problem, tree).axes[0].texts]
    assert ">± 3<" in drawing_svg(drawing_of(problem, tree))


def test_the_way_of_a_sample_is_lit_in_svg_and_figure():
    for row in POINTS[:6]:
        way = int(np.flatnonzero([(row == point).all() for point in POINTS])[0])
        leaf = int(Seen.of(PROBLEM, TREE).leaf_of_sample[way])
        drawing = drawing_of(PROBLEM, TREE, way=leaf)
        lit = [box.index for box in drawing.boxes if box.is_lit]
        assert lit == node_indicator(TREE, row[None])[0].indices.tolist()
        assert drawing_svg(drawing).count(" lit") == 2 * len(lit) - 1
        patches = tree_figure(PROBLEM, TREE, sample=row, dark=True).axes[0].patches
        assert sum(to_hex(patch.get_edgecolor()) == DARK.accent for patch in patches) == 2 * len(lit) - 1
    with pytest.raises(ProblemError, match=r"sample has shape \(2, 2\)"):
        tree_figure(PROBLEM, TREE, sample=POINTS[:2])


def test_yes_is_on_the_left_where_the_tree_has_it_on_the_right_and_the_histogram_too():
    table = pd.DataFrame({"colour": ["red"] * 4 + ["blue"] * 3 + ["green"] * 3})
    model = OptimalTreeClassifier(max_depth=1).fit(table, ["a"] * 4 + ["b"] * 6)
    wording = Wording(model.problem_.samples.feature_names, model.classes_, model.columns_)
    counts, seen = leaf_counts(model.problem_, model.tree_), Seen.of(model.problem_, model.tree_, histograms=True)
    split, one, other = draw_tree(model.tree_, wording, counts, seen=seen).boxes
    assert split.text.lines == ("colour", "is red?")
    assert [box.text.lines[0] for box in (one, other)] == ["b", "a"]
    assert {one.edge.word: one.x < other.x, other.edge.word: other.x < one.x} == {"yes": True, "no": False}
    assert [bar.label for bar in split.bars] == [0, 1]
    assert [bar.x < split.mark[0] - 1 for bar in split.bars] == [True, False]
    shown = model.plot(histograms=True, sample=table.iloc[[0]], dark=True)
    assert to_hex(shown.get_facecolor()) == DARK.paper
    with pytest.raises(ProblemError, match="sample has 2 rows; expected one of the columns 'colour'; give one row"):
        model.plot(sample=table.iloc[:2])
