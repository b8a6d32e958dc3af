"""Predictions by the native core are those of the Python reference, which the certificates use."""

import numpy as np
import pytest

import octmip
from octmip.errors import TreeError
from octmip.trees.nodes.prediction import FEW_ROWS, reached_leaves
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split, leaf_index, predict


def drawn(rng, levels, takes_missing):
    """Return a tree of at most so many levels; with `takes_missing` its splits have sides for missing readings."""
    if levels == 0 or rng.random() < 0.15:
        return Leaf(int(rng.integers(3)))
    side = str(rng.choice(["left", "right"])) if takes_missing else None
    threshold = None if takes_missing and rng.random() < 0.2 else float(rng.choice([-0.5, 0.0, 0.5, 1.0]))
    left, right = drawn(rng, levels - 1, takes_missing), drawn(rng, levels - 1, takes_missing)
    return Split(int(rng.integers(4)), threshold, left, right, missing=side)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("seed", range(20))
def test_the_core_reaches_the_leaves_of_the_reference(seed, dtype):
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(FEW_ROWS + 7, 4)).round(1).astype(dtype)
    rows[rng.random(rows.shape) < 0.01] = rng.choice([np.inf, -np.inf])
    if seed % 2:
        rows[rng.random(rows.shape) < 0.1] = np.nan
    tree = drawn(rng, 1 + seed % 6, seed % 2)
    assert np.array_equal(reached_leaves(tree, rows), leaf_index(tree, rows))
    assert np.array_equal(octmip.predict(tree, rows), predict(tree, rows))
    moved = np.frombuffer(b"-" + rows.tobytes(), dtype=dtype, offset=1).reshape(rows.shape)  # as sent
    assert np.array_equal(reached_leaves(tree, moved), leaf_index(tree, rows))


def test_one_leaf_at_two_places_is_two_leaves():
    leaf = Leaf(1)
    rows = np.linspace(-1.0, 1.0, FEW_ROWS)[:, None]
    assert set(reached_leaves(Split(0, 0.0, leaf, leaf), rows).tolist()) == {0, 1}


@pytest.mark.parametrize("n", [4, 4 * FEW_ROWS])
def test_a_threshold_between_two_numbers_of_32_bits_is_not_rounded(n):
    """Before: NumPy rounded the threshold to float32, here to the upper of both, and sent that one left."""
    low = np.nextafter(np.float32(1.0), np.float32(2.0))
    high = np.nextafter(low, np.float32(2.0))
    tree = Split(0, (float(low) + float(high)) / 2, Leaf(0), Leaf(1))
    assert np.float32(tree.threshold) == high
    rows = np.tile(np.array([[low], [high]], dtype=np.float32), (n // 2, 1))
    assert octmip.predict(tree, rows).tolist() == [0, 1] * (n // 2)
    hyperplane = HyperplaneSplit((0,), (1.0,), tree.threshold, Leaf(0), Leaf(1))
    assert octmip.predict(hyperplane, rows).tolist() == [0, 1] * (n // 2)


def test_a_missing_reading_without_a_side_is_refused_in_the_same_words():
    rows = np.zeros((FEW_ROWS, 2))
    rows[17, 1] = np.nan
    with pytest.raises(TreeError, match="row 17 lacks its reading of feature 1"):
        octmip.predict(Split(1, 0.5, Leaf(0), Leaf(1)), rows)


@pytest.mark.parametrize("n", [4, FEW_ROWS])
def test_a_table_that_lacks_a_column_is_refused_in_words(n):
    """Before: "index 3 is out of bounds", without a word of what to do."""
    with pytest.raises(TreeError, match="features has 2 columns, but the tree asks for feature 3"):
        octmip.predict(Split(3, 0.5, Leaf(0), Leaf(1)), np.zeros((n, 2)))


def test_rows_in_another_order_and_hyperplanes_go_by_the_reference():
    rows = np.asfortranarray(np.random.default_rng(0).normal(size=(FEW_ROWS, 3)))
    tree = Split(2, 0.1, Leaf(0), HyperplaneSplit((0, 1), (1.0, -1.0), 0.0, Leaf(1), Leaf(2)))
    assert np.array_equal(octmip.predict(tree, rows), predict(tree, rows))
