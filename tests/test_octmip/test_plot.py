"""Figures: what is drawn is what the tree says."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.patches import Polygon

from octmip import HyperplaneSplit, Leaf, Problem, Split, predict
from octmip.errors import ProblemError
from octmip.interfaces.plot import choice_figure, partition_figure, tree_figure
from octmip.interfaces.plot.style import class_colours
from octmip.trees.tradeoff import choose_tree

RNG = np.random.default_rng(0)
POINTS = RNG.random((60, 2)) * [10, 1000]
PROBLEM = Problem(POINTS, RNG.integers(0, 3, 60), depth=3, feature_names=("g01", "g02"), class_names=(0, 1, 2))
AXIS = Split(0, 4.0, Split(1, 300.0, Leaf(0), Leaf(1)), Split(0, 8.0, Leaf(2), Split(1, 700.0, Leaf(1), Leaf(0))))
SLANTED = HyperplaneSplit((0, 1), (100.0, -1.0), 20.0, Split(1, 500.0, Leaf(0), Leaf(1)), Leaf(2))


@pytest.mark.parametrize("tree", [AXIS, SLANTED, Leaf(1)])
def test_every_point_of_the_plane_has_the_tint_of_its_prediction(tree):
    axes = partition_figure(PROBLEM, tree).axes[0]
    colours = class_colours(PROBLEM.samples.class_names)
    grid = RNG.random((400, 2)) * [10, 1000]
    cells = [patch for patch in axes.patches if isinstance(patch, Polygon)]
    for point, label in zip(grid, predict(tree, grid), strict=True):
        holding = [cell for cell in cells if cell.get_path().contains_point(point)]
        assert len(holding) == 1
        assert to_rgb(holding[0].get_facecolor()) == pytest.approx(colours[label])


def test_the_plane_of_a_tree_over_three_features_is_refused():
    problem = Problem(RNG.random((9, 3)), [0, 1, 0] * 3, depth=2)
    tree = Split(0, 0.5, Split(1, 0.5, Leaf(0), Leaf(1)), Split(2, 0.5, Leaf(0), Leaf(1)))
    with pytest.raises(ProblemError, match="reads 3 features"):
        partition_figure(problem, tree)
    with pytest.raises(ProblemError, match="predicts class 5"):
        tree_figure(problem, Leaf(5))


def test_a_choice_is_drawn_with_one_line_a_depth_and_its_mark():
    problem = Problem(RNG.random((30, 2)), [0, 1, 2] * 10, depth=2)
    choice = choose_tree(problem, folds=2, method="cart")
    axes = choice_figure(choice).axes[0]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["depth 1", "depth 2", "chosen"]
    costs = [step.validation_cost for step in choice.steps if step.depth == 1]
    assert axes.lines[0].get_ydata().tolist() == [*costs, costs[-1]]
    single = choose_tree(problem, folds=[(range(15), range(15, 30))], method="cart")
    assert choice_figure(single).axes[0].get_xlim()[0] == 0
