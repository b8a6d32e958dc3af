"""Belief over time: the recursion against enumeration, likelihoods against their definition, and calibration."""

import dataclasses
import itertools

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from octmip.errors import DataError, ProblemError
from octmip.monitor import (
    Belief,
    Filter,
    Growth,
    LeafLikelihood,
    Library,
    grid_states,
    leaf_p_value,
    library_of,
    steady_growth,
)
from octmip.trees.nodes.tree import Leaf, Split
from tests.test_octmip.test_monitor_selector import LinearBeam

CENTRES = tuple(0.05 + 0.1 * k for k in range(8))


@dataclasses.dataclass
class WholeReading:
    """A whole reading as an observation of the state: normal, the state's place within its cell taken as normal too."""

    library: Library

    def log_likelihood(self, readings, load_factor):
        found = np.zeros((len(readings), self.library.n_states))
        is_known = ~np.isnan(readings[0])
        if not is_known.any():
            return found
        noise = np.diag(self.library.noise_sd[is_known] ** 2)
        for s, (strains, slopes) in enumerate(zip(self.library.strains, self.library.slopes, strict=True)):
            spread = (load_factor * slopes * self.library.widths[:, None] / np.sqrt(12.0))[:, is_known]
            state = multivariate_normal(load_factor * strains[is_known], noise + spread.T @ spread)
            found[:, s] = state.logpdf(readings[:, is_known])
        return found


@pytest.fixture(scope="module")
def cells() -> Library:
    return library_of(LinearBeam(), grid_states([CENTRES, CENTRES]), 60.0, widths=(0.1, 0.1))


def small_chain():
    library = Library(("mu1",), [[0.0], [0.3], [0.6]], ("a", "b"), [[1.0, 0.0], [2.0, 0.5], [4.0, -1.0]], 1.0)
    return library, steady_growth(library, (0.05, 0.2), sudden=0.02, change=0.1)


def test_the_belief_is_what_enumerating_all_histories_gives():
    library, growth = small_chain()
    observed = WholeReading(library)
    readings = np.array([[1.5, 0.1], [3.1, 0.4], [3.0, -0.5]])
    loads = [1.0, 2.0, 1.0]
    chain = Filter(observed, growth)
    belief = chain.start(1, state=0)
    for row, load in zip(readings, loads, strict=True):
        belief = chain.step(belief, row[None], load)
    likely = [np.exp(observed.log_likelihood(r[None], load)[0]) for r, load in zip(readings, loads, strict=True)]
    total = np.zeros(3)
    for rates in itertools.product(range(2), repeat=4):
        for states in itertools.product(range(3), repeat=3):
            p, before = 0.5, 0
            for k, state in enumerate(states):
                p *= growth.transitions[rates[k], before, state] * growth.changes[rates[k], rates[k + 1]]
                p *= likely[k][state]
                before = state
            total[states[-1]] += p
    assert belief.probability[0] == pytest.approx(total / total.sum(), rel=1e-12)


def test_axes_grow_as_the_full_table_says(cells):
    growth = steady_growth(cells, (0.01, 0.05), sudden=0.01, change=0.1)
    assert [table.shape for table in growth.tables] == [(4, 8, 8)] * 2
    weights = np.random.default_rng(0).random((3, 4, 64))
    expected = np.einsum("nks,kst,kl->nlt", weights, growth.transitions, growth.changes)
    assert growth.advance(weights) == pytest.approx(expected, rel=1e-12)
    assert growth.advance(weights[:0]).shape == (0, 4, 64)


def test_damage_jumps_with_the_probability_that_is_said_to_any_higher_level():
    library = library_of(LinearBeam(), grid_states([[0.0, 0.2, 0.6, 0.9], [0.0]]), 1.0)
    table = steady_growth(library, 0.0, sudden=0.06).transitions[0]
    assert table == pytest.approx(
        np.array([[0.94, 0.02, 0.02, 0.02], [0, 0.94, 0.03, 0.03], [0, 0, 0.94, 0.06], [0, 0, 0, 1]])
    )


def test_a_library_that_lacks_combinations_keeps_its_belief_to_itself():
    states = [[0.0, 0.0], [0.0, 0.5], [0.5, 0.5]]
    library = Library(("mu1", "mu2"), states, ("a",), [[0.0], [1.0], [2.0]], 1.0)
    growth = steady_growth(library, 0.1)
    both, one = 0.8 * 0.8, 0.2 * 0.8  # stays twice; one axis moves
    assert growth.transitions[0, 0] == pytest.approx(np.array([both, one, 0.04]) / (both + one + 0.04))
    assert growth.advance(np.ones((1, 1, 3)) / 3).sum() == pytest.approx(1.0)


def test_a_growth_that_is_none_is_refused(cells):
    library, growth = small_chain()
    with pytest.raises(ProblemError, match="less than one level per step"):
        steady_growth(library, 0.31)
    with pytest.raises(ProblemError, match="rows that add up to"):
        Growth((np.full((1, 2, 2), 0.4),), np.ones((1, 1)))
    with pytest.raises(ProblemError, match="expected 3 axes"):
        Growth((np.eye(2),), np.ones((1, 1)))
    with pytest.raises(ProblemError, match="expected a tuple"):
        Growth(np.eye(2)[None], np.ones((1, 1)))
    with pytest.raises(ProblemError, match="growth rates"):
        Growth((np.eye(2)[None],), np.eye(2))
    with pytest.raises(ProblemError, match="make both for one library"):
        Filter(WholeReading(cells), growth)


def test_quantiles_of_a_belief_are_linear_within_cells():
    library = Library(("mu1",), [[0.05], [0.15], [0.25]], ("a",), [[0.0], [1.0], [2.0]], 1.0, widths=[0.1])
    belief = Belief(library, np.array([[[0.2, 0.6, 0.2]], [[1.0, 0.0, 0.0]]]))
    assert belief.quantile("mu1", 0.5) == pytest.approx([0.15, 0.05])
    assert belief.quantile("mu1", 0.1) == pytest.approx([0.05, 0.01])
    assert belief.interval("mu1", 0.9)[1] == pytest.approx([0.275, 0.095])
    assert belief.probability_above({"mu1": 0.13}) == pytest.approx([0.2 + 0.6 * 0.7, 0.0])
    assert belief.expectation(np.array([1.0, 2.0, 3.0])) == pytest.approx([2.0, 1.0])
    assert belief.probability.argmax(axis=1).tolist() == [1, 0]
    with pytest.raises(ProblemError, match="no parameter 'mu9'"):
        belief.mean("mu9")


def mu1_tree():
    return Split(0, 800.0, Leaf(0), Split(1, 900.0, Leaf(1), Leaf(2)))


def test_a_reading_of_nothing_leaves_the_belief_as_growth_left_it(cells):
    for likelihood in (LeafLikelihood(mu1_tree(), cells, n_draws=200), WholeReading(cells)):
        chain = Filter(likelihood, steady_growth(cells, (0.004, 0.008)))
        before = chain.advance(chain.start(1, state=9))
        after = chain.observe(before, np.full((1, 20), np.nan), 3.0)
        assert after.weights == pytest.approx(before.weights)


def test_a_reading_that_no_state_explains_leaves_the_belief(cells):
    chain = Filter(WholeReading(cells), steady_growth(cells, 0.0))
    sure = chain.start(1, state=0)
    assert np.array_equal(chain.observe(sure, 3.0 * cells.strains[63:], 3.0).weights, sure.weights)


def test_readings_that_are_none_are_refused(cells):
    chain = Filter(WholeReading(cells), steady_growth(cells, 0.004))
    with pytest.raises(DataError, match=r"shape \(1, 3\)"):
        chain.observe(chain.start(), np.zeros((1, 3)), 3.0)
    with pytest.raises(DataError, match="g02 is infinite"):
        chain.observe(chain.start(), np.where(np.arange(20) == 1, np.inf, 0.0)[None], 3.0)
    with pytest.raises(DataError, match="load_factor is -1"):
        chain.observe(chain.start(), np.zeros((1, 20)), -1.0)


def drawn(rng, probabilities):
    """Return one index for each row of probabilities (n, n_choices)."""
    return (probabilities.cumsum(axis=1) > rng.random((len(probabilities), 1))).argmax(axis=1)


@pytest.mark.long("whole")
@pytest.mark.parametrize("kind", ["leaf", "whole"])
def test_sets_hold_what_they_say_on_histories_drawn_from_the_model(cells, kind):
    rng, sd = np.random.default_rng(3), 150.0  # cells narrow beside the noise: their spread is as good as normal
    cells = dataclasses.replace(cells, noise_sd=np.full(20, sd))
    likelihood = LeafLikelihood(mu1_tree(), cells) if kind == "leaf" else WholeReading(cells)
    growth = steady_growth(cells, (0.002, 0.01), sudden=0.002, change=0.05)
    chain, n = Filter(likelihood, growth), 400
    state, rate = np.zeros(n, dtype=int), rng.integers(growth.n_rates, size=n)
    belief, covered = chain.start(n, state=0), []
    for k in range(40):
        state = drawn(rng, growth.transitions[rate, state])
        rate = drawn(rng, growth.changes[rate])
        place = rng.uniform(-0.5, 0.5, (n, 2)) * cells.widths
        strains = cells.strains[state] + np.einsum("np,npg->ng", place, cells.slopes[state])
        load = 3.0 if k % 2 else 2.0
        belief = chain.step(belief, load * strains + rng.normal(0, sd, (n, 20)), load)
        for j, name in enumerate(("mu1", "mu2")):
            low, high = belief.interval(name, 0.9)
            truth = cells.states[state, j] + place[:, j]
            covered.append(((low <= truth) & (truth <= high)).mean())
    # 400 histories of some ten independent stretches each: a standard error of half a per cent. A whole reading keeps
    # places within a cell apart, which the belief spreads out: its sets are a little wide.
    low, high = (0.885, 0.915) if kind == "leaf" else (0.885, 0.935)
    assert low < np.mean(covered) < high


def test_a_leaf_that_growth_does_not_allow_is_a_surprise(cells):
    rng, n = np.random.default_rng(2), 2000
    likelihood = LeafLikelihood(mu1_tree(), cells)
    chain = Filter(likelihood, steady_growth(cells, 0.004))
    expected = chain.advance(chain.start(n, state=9))
    place = rng.uniform(-0.05, 0.05, (n, 2))
    state = np.array([rng.choice(64, p=row) for row in expected.probability])
    strains = cells.strains[state] + np.einsum("np,npg->ng", place, cells.slopes[state])
    p_value = leaf_p_value(likelihood, expected, 3.0 * strains + rng.normal(0, 60.0, strains.shape), 3.0)
    for level in (0.01, 0.05, 0.2, 0.7):
        assert (p_value <= level).mean() <= level + 3 * np.sqrt(level / n)
    jumped = 3.0 * cells.strains[63:]
    assert leaf_p_value(likelihood, chain.advance(chain.start(1, state=9)), jumped, 3.0)[0] < 0.02
    lacking = np.where(np.arange(20) == 0, np.nan, jumped)
    assert leaf_p_value(likelihood, chain.start(), lacking, 3.0)[0] == 1.0
