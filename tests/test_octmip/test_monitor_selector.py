"""From a reading to a state: the compiled tree, its exports bit for bit, the library, and the appended selector."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from octmip.errors import DataError, ProblemError, TreeError
from octmip.monitor import (
    REFUSED,
    LeafLikelihood,
    Library,
    ModelSelector,
    ParameterTree,
    grid_states,
    library_of,
)
from octmip.monitor.compiled import CompiledTree
from octmip.monitor.library import default_levels
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split, leaf_index, leaves, n_splits, nodes, predict
from tests.oracles.strategies import random_tree, trees
from tests.test_octmip.beam_twin import Beam

N_READINGS = 20_000
NAMES = ("a", 'b "quoted" */', "c")


def oblique_tree(rng, n_features, n_classes, depth):
    """Return a random tree of both kinds of split, with numbers that decimals and single precision cannot hold."""
    if depth == 0 or rng.random() < 0.1:
        return Leaf(int(rng.integers(n_classes)))
    sides = [oblique_tree(rng, n_features, n_classes, depth - 1) for _ in range(2)]
    if rng.random() < 0.4:
        return Split(
            int(rng.integers(n_features)), float(rng.choice([900 + 1e-6 * rng.random(), rng.normal()])), *sides
        )
    chosen = tuple(sorted(rng.choice(n_features, rng.integers(1, n_features + 1), replace=False).tolist()))
    return HyperplaneSplit(chosen, tuple(rng.normal(size=len(chosen)).tolist()), float(rng.normal()), *sides)


def near_thresholds(rng, tree, n_features, n=N_READINGS):
    """Return readings of which many lie on a threshold or one unit in the last place beside it, and some are NaN."""
    readings = rng.normal(size=(n, n_features))
    thresholds = [node.threshold for node in nodes(tree) if isinstance(node, Split)] or [0.0]
    chosen = rng.choice(thresholds, readings.shape)
    shifted = np.choose(
        rng.integers(3, size=readings.shape), [chosen, np.nextafter(chosen, 1e9), np.nextafter(chosen, -1e9)]
    )
    readings = np.where(rng.random(readings.shape) < 0.5, shifted, readings)
    readings[rng.random(readings.shape) < 0.02] = np.nan
    return readings


@pytest.fixture(scope="module", params=[0, 1, 2])
def case(request):
    rng = np.random.default_rng(request.param)
    make = random_tree if request.param == 0 else oblique_tree
    tree = make(rng, 3, 4, 5)
    readings = near_thresholds(rng, tree, 3)
    return tree, readings, CompiledTree(tree, NAMES).labels(readings)


@given(tree=trees(), seed=st.integers(0, 1000))
@settings(max_examples=60, deadline=None)
def test_the_compiled_tree_answers_what_the_tree_answers(tree, seed):
    readings = near_thresholds(np.random.default_rng(seed), tree, 3, 200)
    readings = np.nan_to_num(readings)
    compiled = CompiledTree(tree, NAMES)
    assert np.array_equal(compiled.labels(readings), predict(tree, readings))
    assert [compiled.label(row) for row in readings] == predict(tree, readings).tolist()


def test_one_reading_and_a_batch_answer_alike_and_refuse_alike(case):
    tree, readings, answers = case
    compiled = CompiledTree(tree, NAMES)
    assert 0 < (answers == REFUSED).sum() < np.isnan(readings).any(axis=1).sum()  # NaN off the way does no harm
    for row, answer in zip(readings[:3000], answers[:3000].tolist(), strict=True):
        if answer == REFUSED:
            with pytest.raises(DataError, match="has no number at"):
                compiled.label(row)
        else:
            assert compiled.label(row) == answer


def test_a_reading_of_another_length_is_refused():
    compiled = CompiledTree(Split(0, 1.0, Leaf(0), Leaf(1)), NAMES)
    with pytest.raises(DataError, match="has 2 values; expected 3"):
        compiled.label([1.0, 2.0])
    with pytest.raises(DataError, match=r"shape \(4, 2\)"):
        compiled.labels(np.zeros((4, 2)))
    with pytest.raises(DataError, match="reads feature 5"):
        CompiledTree(Split(5, 1.0, Leaf(0), Leaf(1)), NAMES)


LEVELS = (0.0, 0.2, 0.4, 0.6, 0.8)


class LinearBeam(Beam):
    is_linear_in_load = True


def small_library(**options):
    return library_of(LinearBeam(), grid_states([LEVELS, LEVELS]), 31.6, **options)


def a_selector():
    mu1 = Split(0, 800.0, Split(1, 600.0, Leaf(0), Leaf(1)), Leaf(4))
    mu2 = Split(0, 20.0, Leaf(1), Split(1, 40.0, Leaf(3), Leaf(4)))
    return ModelSelector.of_trees(
        small_library(),
        [ParameterTree("mu1", mu1, LEVELS, ("g01", "g02")), ParameterTree("mu2", mu2, LEVELS, ("g16", "g15"))],
    )


def test_a_library_holds_the_twins_strains_per_unit_of_load():
    twin, library = Beam(), small_library(gauges=("g03", "g01"))
    row = library.index_of({"mu1": 0.4, "mu2": 0.2})
    assert library.state_names[row] == "mu1=0.4 mu2=0.2"
    assert library.strains[row] * 3.0 == pytest.approx(twin.predict({"mu1": 0.4, "mu2": 0.2}, 3.0)[[2, 0]])


@pytest.mark.parametrize("made", [dict, pd.Series])
def test_noise_by_name_goes_by_name(made):
    gauges, states = LinearBeam().gauges, grid_states([LEVELS, LEVELS])
    noise = {name: 1.0 + k for k, name in enumerate(gauges)}
    turned = made(dict(reversed(noise.items())))
    assert library_of(LinearBeam(), states, turned).noise_sd.tolist() == list(noise.values())


def test_slopes_are_the_change_across_the_cell():
    states = grid_states([[0.3], [0.0]])
    library = library_of(LinearBeam(), states, 1.0, widths=(0.1, 0.1))
    ends = [Beam().predict({"mu1": mu, "mu2": 0.0}, 1.0) for mu in (0.25, 0.35)]
    assert library.slopes[0, 0] == pytest.approx((ends[1] - ends[0]) / 0.1)


def test_a_twin_that_is_not_linear_in_load_holds_for_one_load():
    library = library_of(Beam(), grid_states([LEVELS, LEVELS]), 31.6, load_factor=3.0)
    with pytest.raises(DataError, match="not linear in load"):
        library.features(np.zeros((1, 20)), 2.0)
    with pytest.raises(DataError, match="load_factor is 0"):
        library.checked_load(0.0)


def test_a_library_refuses_what_it_cannot_hold():
    with pytest.raises(ProblemError, match="lacks the gauges"):
        small_library(gauges=("g99",))
    with pytest.raises(ProblemError, match="twice"):
        Library(("mu1",), [[0.0], [0.0]], ("a",), [[1.0], [2.0]], 1.0)
    with pytest.raises(ProblemError, match="noise_sd is 0"):
        Library(("mu1",), [[0.0]], ("a",), [[1.0]], 0.0)
    with pytest.raises(ProblemError, match="has no state"):
        small_library().index_of({"mu1": 0.1})


def test_appended_trees_tell_what_each_tree_tells():
    selector = a_selector()
    assert n_splits(selector.tree) == 2 + 3 * 2
    rng = np.random.default_rng(0)
    readings = rng.uniform(0, 3000, (500, 20))
    readings[:, [14, 15]] = rng.uniform(0, 180, (500, 2))
    told = selector.library.states[selector.select_many(readings, 3.0)]
    x = readings / 3.0
    assert np.array_equal(told[:, 0], np.where(x[:, 0] > 800, 0.8, np.where(x[:, 1] > 600, 0.2, 0.0)))
    assert np.array_equal(told[:, 1], np.where(x[:, 15] <= 20, 0.2, np.where(x[:, 14] <= 40, 0.6, 0.8)))
    assert selector.gauges_read == ("g01", "g02", "g15", "g16")


def test_a_selection_is_bayes_rule_over_the_leaf():
    selector = a_selector()
    reading = 3.0 * selector.library.strains[7]
    got = selector.select(reading, 3.0)
    table = selector.likelihood.table(3.0)
    leaf = leaf_index(selector.tree, reading[None] / 3.0)[0]
    assert got.distribution == pytest.approx(table[leaf] / table[leaf].sum())
    assert got.name == selector.library.state_names[got.state]
    assert got.path[0] == 0
    assert np.allclose(table.sum(axis=0), 1.0)


def test_a_selector_comes_back_from_its_file_bit_for_bit(tmp_path):
    selector = a_selector()
    selector.write(tmp_path / "selector.json")
    back = ModelSelector.read(tmp_path / "selector.json")
    rng = np.random.default_rng(5)
    readings = rng.uniform(0, 3000, (N_READINGS, 20))
    assert back.tree == selector.tree
    assert np.array_equal(back.select_many(readings, 3.0), selector.select_many(readings, 3.0))
    assert np.array_equal(back.library.strains, selector.library.strains)
    (tmp_path / "broken.json").write_text('{"format": "octmip-selector", "version": 1, "tree": {}}')
    with pytest.raises(TreeError, match="no valid selector"):
        ModelSelector.read(tmp_path / "broken.json")


def test_a_tree_of_other_gauges_or_states_is_refused():
    library = small_library()
    with pytest.raises(TreeError, match="which the library lacks"):
        ModelSelector.of_trees(library, [ParameterTree("mu1", Leaf(0), LEVELS, ("x1",))])
    with pytest.raises(ProblemError, match="has no state"):
        ModelSelector.of_trees(library, [ParameterTree("mu1", Leaf(0), (0.33,), ("g01",))])
    with pytest.raises(TreeError, match="selects state 99"):
        ModelSelector(library, Leaf(99))


def test_the_leaf_table_is_the_share_of_readings_that_reach_the_leaf():
    library = Library(("mu1",), [[0.0], [0.5]], ("a",), [[100.0], [110.0]], 20.0)
    likelihood = LeafLikelihood(Split(0, 105.0, Leaf(0), Leaf(1)), library, n_draws=20_000)
    for load, expected in ((1.0, 0.5987), (2.0, 0.6915)):  # the normal distribution at 5 over 20 / load
        assert likelihood.table(load)[0, 0] == pytest.approx(expected, abs=0.012)
        assert likelihood.table(load)[1, 1] == pytest.approx(expected, abs=0.012)


def test_missing_gauges_leave_leaves_open_and_their_probabilities_add_up():
    tree = Split(0, 0.0, Split(1, 0.0, Leaf(0), Leaf(1)), Split(1, 1.0, Leaf(0), Leaf(1)))
    library = Library(("mu1",), [[0.0], [0.5]], ("a", "b"), [[0.1, 0.2], [0.5, 1.0]], 1.0)
    likelihood = LeafLikelihood(tree, library)
    nan = np.nan
    readings = np.array([[-1.0, nan], [nan, -1.0], [nan, 0.5], [nan, nan], [-1.0, -1.0]])
    expected = [[1, 1, 0, 0], [1, 0, 1, 0], [0, 1, 1, 0], [1, 1, 1, 1], [1, 0, 0, 0]]
    assert likelihood.open_leaves(readings).astype(int).tolist() == expected
    got = np.exp(likelihood.log_likelihood(readings, 1.0))
    assert got == pytest.approx(np.array(expected) @ likelihood.table(1.0))
    assert got[3] == pytest.approx([1.0, 1.0])
    assert len(leaves(tree)) == likelihood.n_leaves


def test_levels_that_are_not_given_have_few_digits():
    assert default_levels(0.35) == [0.0, 0.07, 0.14, 0.21, 0.28]
    assert default_levels(1e-7 / 3.0)[1] == 6.66666666667e-09
