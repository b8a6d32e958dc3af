"""Leaf distributions: by hand, against identities, and calibrated on fresh rows."""

from dataclasses import replace

import numpy as np
import pytest

from octmip import Leaf, OptimalTreeClassifier, Problem, Split, solve
from octmip.errors import ProblemError
from octmip.trees.answer.solution import Stop
from octmip.trees.tradeoff import leaf_shares
from octmip.trees.tradeoff.leaf_shares import leaves_on_fresh_rows
from octmip.trees.uncertainty import LeafDistribution, posterior, smoothed_shares
from octmip.trees.uncertainty.leaf_distribution import corrected_shares, fitted_line

TREE = Split(0, 0.5, Leaf(0), Leaf(1))


def test_smoothing_draws_towards_the_prior_and_laplace_is_one_more_of_each():
    weights = np.array([[3.0, 1.0], [0.0, 0.0]])
    assert smoothed_shares(weights).tolist() == [[0.75, 0.25], [0.5, 0.5]]
    assert smoothed_shares(weights, 2.0)[0].tolist() == [4 / 6, 2 / 6]
    assert smoothed_shares(weights, 4.0, [0.0, 1.0])[0].tolist() == [3 / 8, 5 / 8]


def test_leaves_count_weights_or_samples():
    problem = Problem([[0], [0], [1], [1]], [0, 1, 1, 1], depth=1, weights=[3, 1, 2, 2])
    assert LeafDistribution.of(TREE, problem).probabilities.tolist() == [[0.75, 0.25], [0, 1]]
    assert LeafDistribution.of(TREE, problem, is_weighted=False).probabilities[0].tolist() == [0.5, 0.5]


def test_another_prior_is_as_if_the_classes_had_come_in_those_shares():
    weights = np.array([[8.0, 2.0], [2.0, 18.0]])
    leaf = LeafDistribution(TREE, weights)
    assert LeafDistribution(TREE, np.array([[1, 2], [3, 4]])).weights.dtype == np.float64
    resampled = weights * (np.array([0.9, 0.1]) / weights.sum(axis=0))
    assert np.allclose(leaf.with_prior([0.9, 0.1]), smoothed_shares(resampled))
    assert np.allclose(leaf.with_prior(leaf.training_prior), leaf.probabilities)
    assert np.allclose(leaf.predict([[0.0]], prior=[1, 0]), [[1, 0]])
    assert np.array_equal(LeafDistribution(TREE, np.array([[1.0, 0.0], [1.0, 0.0]])).with_prior([1, 0]), [[1, 0]] * 2)


def test_bayes_rule_with_and_without_a_prior():
    assert np.allclose(posterior(np.log([[0.2, 0.6]])), [[0.25, 0.75]])
    assert np.allclose(posterior(np.log([[0.2, 0.6]]), [3, 1]), [[0.5, 0.5]])
    with pytest.raises(ProblemError, match="gives 0"), np.errstate(divide="ignore"):
        posterior(np.log([[0.0, 1.0]]), [1, 0])


def test_the_classifier_gives_the_same_leaf_distributions():
    rng = np.random.default_rng(0)
    features, labels = rng.normal(size=(60, 2)), rng.integers(0, 3, 60)
    model = OptimalTreeClassifier(max_depth=2, smoothing=3.0).fit(features, labels, rng.integers(1, 4, 60))
    assert np.array_equal(model.predict_proba(features), model.leaf_distribution_.predict(features))
    assert (model.predict_proba(features) > 0).all()
    assert np.allclose(model.predict_proba(features, prior=[0, 0, 1]), [0, 0, 1])


@pytest.mark.parametrize(
    "call",
    [
        lambda: smoothed_shares(np.ones((1, 2)), -1.0),
        lambda: smoothed_shares(np.ones((1, 2)), 1.0, [1, 1, 1]),
        lambda: LeafDistribution(TREE, np.ones((3, 2))),
        lambda: LeafDistribution(TREE, np.array([[1.0, 0.0], [1.0, 0.0]])).with_prior([0.5, 0.5]),
    ],
)
def test_wrong_input_is_refused(call):
    with pytest.raises(ProblemError):
        call()


def noisy(n, seed):
    """Return features that say little about three classes."""
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(n, 6))
    return features, np.where(rng.random(n) < 0.2, (features[:, 0] > 0).astype(int), rng.integers(0, 3, n))


def calibration_error(table, codes):
    """Return the expected calibration error of probabilities (n, n_classes), ten bins of the greatest in each row."""
    given, is_hit = table.max(axis=1), table.argmax(axis=1) == codes
    bins = np.ceil(given * 10).astype(int)
    return np.abs(np.bincount(bins, given - is_hit)).sum() / len(codes)


def test_shares_of_training_rows_are_too_high_and_those_corrected_out_of_fold_are_not():
    errors = {0.0: [], "out-of-fold": []}
    for seed in range(4):
        fresh, codes = noisy(20_000, seed + 100)
        for smoothing, found in errors.items():
            model = OptimalTreeClassifier(max_depth=2, smoothing=smoothing).fit(*noisy(1500, seed))
            found.append(calibration_error(model.predict_proba(fresh), codes))
            assert (model.predict_proba(fresh).argmax(axis=1) == model.predict(fresh)).all()
    assert np.mean(errors["out-of-fold"]) < 0.02 < np.mean(errors[0.0])


def test_leaves_of_few_rows_are_smoothed_alike_whether_rows_are_repeated_or_weigh_more_or_all_less():
    X, y = noisy(40, 0)
    tree = Split(0, 0.0, Leaf(0), Leaf(1))
    tables = [
        leaves_on_fresh_rows(Problem(np.repeat(X, k, 0), np.repeat(y, k), depth=1, weights=np.full(40 * k, w)), tree)
        for k, w in ((2, 1.0), (1, 2.0), (1, 1.0), (1, 0.5))
    ]
    assert np.allclose(tables[0].probabilities, tables[1].probabilities)
    assert np.allclose(tables[2].probabilities, tables[3].probabilities)
    assert not np.allclose(tables[1].probabilities, tables[2].probabilities)


def test_all_refits_of_leaves_together_have_the_seconds_and_judge_rows_they_have_not_seen(monkeypatch):
    asked = []

    def solved(part, method, limits, **named):
        asked.append((limits.seconds, part.samples.n_samples))
        return solve(part, method, **named)

    monkeypatch.setattr(leaf_shares, "solve", solved)
    X = np.arange(200.0)[:, None]
    problem = Problem(X, np.random.default_rng(0).integers(0, 2, 200), depth=5)
    line = leaves_on_fresh_rows(problem, solve(problem, "cart").tree, seconds=50.0).line
    assert asked == [(5.0, 180)] * 10
    assert line[0] + 0.9 * line[1] < 0.7  # of labels by chance no leaf says much


def test_probabilities_are_corrected_by_default_when_they_are_first_asked_for(monkeypatch):
    asked = []
    monkeypatch.setattr(leaf_shares, "solve", lambda *a, **k: asked.append(a[1]) or solve(*a, **k))
    model = OptimalTreeClassifier(max_depth=2).fit(*noisy(1500, 0))
    assert model.predict(noisy(9, 1)[0]).shape == (9,)
    assert asked == []
    before = dict(vars(model))
    first = model.predict_proba(noisy(200, 1)[0])
    assert asked == ["search"] * 10
    assert vars(model) == before
    assert np.array_equal(model.predict_proba(noisy(200, 1)[0]), first)
    assert len(asked) == 10
    assert "corrected" in model.leaf_distribution_.made
    assert np.array_equal(
        OptimalTreeClassifier(max_depth=2).fit(*noisy(1500, 0)).predict_proba(noisy(200, 1)[0]), first
    )


def test_few_rows_are_smoothed_and_the_leaves_say_so():
    features, labels = noisy(99, 0)
    model = OptimalTreeClassifier(1).fit(features, labels)
    assert model.leaf_distribution_.made == "training shares, smoothed by 3"
    twice = OptimalTreeClassifier(1).fit(features[:40], labels[:40], np.full(40, 2.0))
    rows = np.repeat(np.arange(40), 2)
    assert np.allclose(
        OptimalTreeClassifier(1).fit(features[rows], labels[rows]).predict_proba(features),
        twice.predict_proba(features),
    )


def test_a_class_that_one_fold_holds_out_leaves_the_line_to_the_others():
    rng = np.random.default_rng(0)
    features, labels = rng.normal(size=(300, 2)), np.arange(300) == 7
    leaves = OptimalTreeClassifier(2).fit(features, labels).leaf_distribution_
    assert leaves.line is not None
    assert leaves.probabilities.max(axis=1).min() > 0.5


def test_ctrl_c_ends_the_refits(monkeypatch):
    interrupted = lambda *a, **k: replace(solve(*a, **k), stop=Stop.INTERRUPTED)  # noqa: E731
    model = OptimalTreeClassifier(1).fit(*noisy(200, 0))
    monkeypatch.setattr(leaf_shares, "solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        model.predict_proba(noisy(5, 1)[0])


def test_the_line_is_that_of_least_squares_and_never_falls():
    shares, hits = np.array([0.4, 0.4, 0.8, 0.8]), np.array([True, False, True, True])
    assert fitted_line(shares, hits, np.ones(4)) == pytest.approx((0.0, 1.25))
    assert fitted_line(shares, ~hits, np.ones(4)) == pytest.approx((0.25, 0.0))
    assert fitted_line(np.full(4, 0.5), hits, np.array([1.0, 0, 0, 1.0])) == (1.0, 0.0)


def test_a_corrected_leaf_stays_a_distribution_whose_greatest_share_is_its_class():
    shares, prior = np.array([[0.6, 0.3, 0.1], [1.0, 0.0, 0.0], [0.5, 0.5, 0.0]]), np.array([0.2, 0.6, 0.2])
    out = corrected_shares(shares, (0.0, 0.8), prior)
    assert np.allclose(out, [[0.48, 0.39, 0.13], [0.8, 0.15, 0.05], [0.5, 0.5, 0.0]])
    assert np.allclose(corrected_shares(shares, (0.0, 0.1), prior).argmax(axis=1), 0)
    assert corrected_shares(np.array([[1.0]]), (0.0, 0.5), np.array([1.0])).tolist() == [[1.0]]
