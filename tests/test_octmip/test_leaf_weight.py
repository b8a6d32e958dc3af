"""A least weight of leaves: weight k is k samples, for every solver that answers it, and nobody else forgets it."""

from dataclasses import replace

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

import octmip
from octmip import AbsoluteError, OptimalTreeClassifier, OptimalTreeRegressor, Problem, SquaredError, Stop
from octmip.errors import CertificateError, ProblemError
from octmip.trees.answer.certificate import certify
from octmip.trees.encoding import repeated_rows
from octmip.trees.question.losses import ClassCosts
from tests.oracles.enumeration import optimum

STRIPES = [[0.0], [1.0], [2.0], [3.0]], ["a", "b", "a", "b"]
WEIGHTS = {
    "whole": lambda rng, n, labels: rng.integers(0, 5, n) + (np.arange(n) < 2),
    "tenths": lambda rng, n, labels: rng.integers(1, 6, n) * 0.1,
    "real": lambda rng, n, labels: 3 * rng.random(n),
    "of classes": lambda rng, n, labels: np.where(labels == 0, 1000.0, 1e-4),
    "balanced": lambda rng, n, labels: np.where(labels == 0, 0.8, 8 / 3),
}


def weighted(seed: int, kind: str) -> Problem:
    """Return a tiny problem whose leaves have a least weight, in half of them that of some of the samples."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 10))
    features = rng.integers(0, 4, (n, int(rng.integers(1, 3)))).astype(np.float64)
    features[rng.random(features.shape) < 0.2 * (rng.random() < 0.2)] = np.nan
    labels = np.concatenate([[0, 1], rng.integers(0, 3, n - 2)])
    weights = np.asarray(WEIGHTS[kind](rng, n, labels), dtype=np.float64)
    some = float(np.round(weights[rng.random(n) < 0.4].sum(), 10))
    least = some if rng.random() < 0.5 else float(weights.sum() * rng.uniform(0, 0.5))
    penalty = float(rng.choice([0.0, 0.0, 0.5]))
    depth = int(rng.integers(1, 4))
    return Problem(features, labels, depth=depth, weights=weights, leaf_weight=least, leaf_penalty=penalty)


@pytest.mark.parametrize("kind", WEIGHTS)
def test_the_proven_optimum_is_that_of_enumeration(kind):
    n_bound = 0
    for seed in range(8):
        problem = weighted(seed, kind)
        best, found = optimum(problem).objective, octmip.solve(problem, "exact")
        assert found.is_optimal, seed
        assert found.objective == pytest.approx(best, rel=1e-12, abs=1e-12), seed
        n_bound += best > optimum(problem.replace(leaf_weight=None)).objective
        for method in ("cart", "search"):
            assert certify(problem, octmip.solve(problem, method)).objective >= best * (1 - 1e-12)
    assert n_bound >= 2  # else the limit would not have been tried


@pytest.mark.parametrize("loss", [ClassCosts(), SquaredError(), AbsoluteError()], ids=lambda loss: loss.name)
@pytest.mark.parametrize("method", ["exact", "search", "cart"])
def test_weight_k_is_k_samples_in_objective_and_leaf_sizes(loss, method):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        features, times = rng.integers(0, 5, (9, 2)).astype(np.float64), rng.integers(1, 5, 9)
        targets = np.concatenate([[0, 1], rng.integers(0, 3, 7)])
        rows = np.repeat(np.arange(9), times)
        weighs = Problem(features, targets, depth=2, loss=loss, weights=times, leaf_weight=6)
        repeats = Problem(features[rows], targets[rows], depth=2, loss=loss, leaf_size=6)
        one, other = octmip.solve(weighs, method), octmip.solve(repeats, method)
        assert one.objective == pytest.approx(other.objective, rel=1e-12)
        assert one.is_optimal == other.is_optimal == (method == "exact")
        certify(repeats, replace(other, tree=one.tree, objective=repeats.objective(one.tree)))


def test_a_leaf_of_too_little_weight_fails_its_certificate_and_is_no_incumbent():
    problem = Problem(*STRIPES, depth=2, weights=[1, 1, 1, 4], leaf_weight=3)
    free = octmip.solve(problem.replace(leaf_weight=None), "exact")
    with pytest.raises(CertificateError, match=r"leaf 0 .* weight 1 but leaf_weight is 3"):
        certify(problem, free)
    with pytest.raises(ProblemError, match="the incumbent is no tree of this problem: leaf 0"):
        octmip.solve(problem, "exact", incumbent=free)
    assert octmip.solve(problem, "exact").objective == 1.0


def test_rows_too_coarse_to_tell_leaves_apart_claim_no_optimum(monkeypatch):
    monkeypatch.setattr(repeated_rows, "units_of", lambda problem: [problem.samples.weights.sum()])
    problem = Problem(*STRIPES, depth=2, weights=[1, 1, 1, 1], leaf_weight=2)
    found = octmip.solve(problem, "exact")
    assert (found.objective, found.bound, found.stop) == (2.0, 0.0, Stop.NUMERICS)


def test_the_estimators_share_is_scikit_learns():
    rng = np.random.default_rng(0)
    features, weights = rng.normal(size=(60, 3)), rng.integers(1, 9, 60)
    labels = (features[:, 0] + rng.normal(size=60) > 0).astype(int)
    for model in (OptimalTreeClassifier, OptimalTreeRegressor):
        fitted = model(2, min_weight_fraction_leaf=0.2).fit(features, labels, weights)
        assert fitted.is_optimal_
        assert (
            np.bincount(fitted.apply(features), weights)[np.unique(fitted.apply(features))].min() >= 0.2 * weights.sum()
        )
    theirs = DecisionTreeClassifier(max_depth=2, min_weight_fraction_leaf=0.2, random_state=0)
    theirs.fit(features, labels, weights)
    ours = OptimalTreeClassifier(2, min_weight_fraction_leaf=0.2).fit(features, labels, weights)
    assert ours.score(features, labels, weights) >= theirs.score(features, labels, weights)
    for wrong in (-0.1, 0.6):
        with pytest.raises(ProblemError, match="min_weight_fraction_leaf is"):
            OptimalTreeClassifier(2, min_weight_fraction_leaf=wrong).fit(features, labels)
