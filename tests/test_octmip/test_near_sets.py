"""Sets of near-optimal trees against plain enumeration, which knows no bound and no solver."""

import math
import pickle
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from octmip import near_optimal, solve
from octmip.errors import CertificateError, ProblemError
from octmip.trees.answer.set_certificate import certify_set, recount
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.near_sets import NearOptimalSet, NearTree, counting
from octmip.trees.nodes.tree import Leaf, Split
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem
from tests.oracles.strategies import random_problem


def five_values(labels: str = "aabab", **options: object) -> Problem:
    """Return samples at 0, 1, 2, 3, 4 of two classes."""
    settings: dict[str, object] = {"depth": 1} | options
    return Problem(np.arange(5.0)[:, None], np.array(list(labels)), **settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(12))
def test_trees_are_listed_once_by_their_cost_and_predictions_counted(seed: int) -> None:
    """The fuzz holds counts, spectrum and sensors against enumeration."""
    rng = np.random.default_rng(seed)
    found = near_optimal(random_problem(rng, max_samples=int(rng.integers(4, 9))), float(rng.choice([0, 0.5, 1, 2])))
    assert (found.is_complete, found.stop) == (True, Stop.FINISHED)
    counted = certify_set(found.problem, found)
    assert counted is not None
    assert found.predictions == counted.predictions
    assert pickle.loads(pickle.dumps(found)).best(5) == found.best(5)  # in another process too
    every = found.best(found.trees or 0) if (found.trees or 0) <= 300 else []
    assert len({str(entry.tree) for entry in every}) == len(every)
    assert [entry.objective for entry in every] == sorted(entry.objective for entry in every)


def test_a_set_on_five_values_is_the_one_counted_by_hand() -> None:
    # Cuts after 1, 2, 3, 4 samples: a|b costs 2, 1, 2, 1, and b|a costs 3, 4, 3, 4; the leaf a costs 2, b costs 3.
    found = near_optimal(five_values(), within=1)
    assert found.spectrum == ((Fraction(1), 2), (Fraction(2), 3))
    assert found.by_root == {"x0": 4, "": 1}
    assert found.predictions == 5
    assert [(root.first, root.last, root.n_cuts, root.trees) for root in found.roots] == [(0.5, 3.5, 4, 4)]


def test_cuts_that_part_readings_with_missing_readings_alike_are_one() -> None:
    # x0 parts the samples as missing | 0 1 2, missing 0 | 1 2, missing 0 1 | 2, 0 | 1 2 missing, 0 1 | 2 missing.
    features = np.array([[0.0], [1.0], [2.0], [np.nan]])
    found = near_optimal(Problem(features, np.array(list("abab")), depth=1), within=4)
    assert found.by_root == {"x0": 10, "": 2}  # a|b and b|a each
    intervals = [(root.first, root.last, root.missing, root.n_cuts) for root in found.roots]
    assert intervals == [(None, None, "left", 1), (0.5, 1.5, "left", 2), (0.5, 1.5, "right", 2)]
    # Below a root that parts the missing one from the others, a side for it is no further tree.
    two = Problem(features, np.array(list("abab")), depth=2)
    counted = recount(two, Fraction(4))
    assert near_optimal(two, within=4).trees == counted.trees


def test_a_count_without_time_names_each_cut_of_a_feature_with_missing_readings_once() -> None:
    problem = Problem(np.array([[0.0], [1.0], [2.0], [np.nan]]), np.array(list("abab")), depth=2)
    found = near_optimal(problem, within=4, limits=Limits(seconds=0.0), incumbent=solve(problem))
    intervals = [(root.first, root.last, root.missing, root.n_cuts) for root in found.open]
    assert intervals == [(None, None, "left", 1), (0.5, 1.5, "left", 2), (0.5, 1.5, "right", 2)]


def test_a_tree_at_the_border_belongs_to_the_set() -> None:
    third = 1 / 3
    problem = five_values(weights=np.full(5, third))
    exact = Fraction(third)
    assert near_optimal(problem, within=third).trees == 5
    assert near_optimal(problem, within=exact).trees == 5
    assert near_optimal(problem, within=math.nextafter(third, 0)).trees == 2
    assert near_optimal(five_values(), relative=1.0).trees == 5
    assert near_optimal(five_values(), relative=0.99).trees == 2


def test_weights_of_many_digits_are_counted_without_rounding() -> None:
    rng = np.random.default_rng(3)
    weights = rng.random(5) * 10.0 ** rng.integers(-6, 6, 5)
    problem = five_values(weights=weights, depth=2, loss=ClassCosts(rng.random((2, 2)) * (1 - np.eye(2))))
    found = near_optimal(problem, relative=0.5)
    assert certify_set(problem, found, found.best(20)) is not None
    with pytest.raises(ProblemError, match=r"binary digits, too many to count"):
        near_optimal(five_values(weights=np.array([1e-60, 1, 1, 1, 1e60])), within=1)


def test_equal_cuts_of_a_node_are_one() -> None:
    features = np.array([[0.0, 0], [1, 0], [2, 1], [3, 1]])
    problem = Problem(features, np.array([0, 1, 0, 1]), depth=2)
    found = near_optimal(problem, within=0)
    # Root between 1 and 2 by either feature: each side then has one cut of x0. Roots elsewhere leave an error.
    assert found.by_root == {"x0": 1, "x1": 1}
    assert found.predictions == 1


def test_samples_are_uniform_and_follow_their_seed() -> None:
    found = near_optimal(five_values(depth=2), within=1)
    assert found.trees is not None
    drawn = found.sample(60 * found.trees, seed=7)
    counts = Counter(str(entry.tree) for entry in drawn)
    assert len(counts) == found.trees
    # 60 expected of each: beyond 5 standard deviations once in a million.
    assert all(abs(n - 60) < 5 * math.sqrt(60) for n in counts.values())
    assert [e.tree for e in found.sample(5, seed=1)] == [e.tree for e in found.sample(5, seed=1)]
    assert [e.tree for e in found.sample(9, seed=1)] != [e.tree for e in found.sample(9, seed=2)]


def test_a_count_that_is_stopped_claims_no_more_than_it_has_counted() -> None:
    rng = np.random.default_rng(0)
    problem = Problem(rng.normal(size=(60, 4)), rng.integers(0, 3, 60), depth=3)
    whole = near_optimal(problem, within=1)
    assert whole.trees is not None
    stopped = near_optimal(problem, within=1, limits=Limits(seconds=0.0))
    assert stopped.trees is None
    assert stopped.stop is Stop.TIME
    assert stopped.trees_at_least <= whole.trees
    assert stopped.open
    assert stopped.predictions is None
    with pytest.raises(ProblemError, match="not counted to its end"):
        stopped.sample(1)


def test_an_interrupt_during_the_search_for_the_optimum_ends_the_count(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    problem = Problem(rng.normal(size=(60, 4)), rng.integers(0, 3, 60), depth=3)
    cut_short = replace(solve(problem, "cart"), stop=Stop.INTERRUPTED)
    monkeypatch.setattr(counting, "solve", lambda *_args, **_options: cut_short)
    found = near_optimal(problem, within=1)
    assert (found.stop, found.trees, found.optimum) == (Stop.INTERRUPTED, None, None)


def test_threads_do_not_change_the_set() -> None:
    rng = np.random.default_rng(1)
    problem = Problem(rng.normal(size=(40, 3)), rng.integers(0, 3, 40), depth=3)
    one, two = (near_optimal(problem, within=1, n_jobs=n) for n in (1, 2))
    assert one.spectrum == two.spectrum
    assert one.roots == two.roots
    assert [e.tree for e in one.best(7)] == [e.tree for e in two.best(7)]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "expected one of the two"),
        ({"within": 1, "relative": 0.1}, "expected one of the two"),
        ({"within": -1}, "expected a number of 0 or more"),
        ({"relative": math.nan}, "expected a number of 0 or more"),
        ({"problem": five_values(split="hyperplane"), "within": 1}, "split is 'hyperplane'"),
    ],
)
def test_what_is_asked_must_make_sense(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        near_optimal(**{"problem": five_values(), **options})


class Claimed:
    """A set that claims other numbers than another one."""

    def __init__(self, true: NearOptimalSet, **other: object) -> None:
        self.__dict__ |= {name: getattr(true, name) for name in ("limit", "optimum", "trees", "trees_at_least")}
        self.__dict__ |= {"predictions": true.predictions, "by_root": true.by_root} | other


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"trees": 6}, "claims 6 trees but enumeration counts 5"),
        ({"trees": None, "trees_at_least": 6}, "claims 6 trees or more but there are 5"),
        ({"predictions": 4}, "claims 4 predictions"),
        ({"optimum": Fraction(2)}, "claims the optimum 2"),
        ({"optimum": Fraction(1, 2)}, "claims the optimum 1/2"),
        ({"optimum": None}, "claims the optimum None"),
        ({"by_root": {"x0": 5}}, "by root"),
    ],
)
def test_the_certificate_refutes_a_wrong_claim(other: dict[str, object], message: str) -> None:
    problem = five_values()
    true = near_optimal(problem, within=1)
    certify_set(problem, true)
    with pytest.raises(CertificateError, match=message):
        certify_set(problem, Claimed(true, **other))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("tree", "objective", "message"),
    [
        (Split(0, 1.5, Leaf(0), Leaf(1)), 2.0, "claims 2.0 but costs 1.0"),
        (Split(0, 1.5, Leaf(1), Leaf(1)), 3.0, "two leaves of one label"),
        (Split(0, 1.5, Leaf(1), Leaf(0)), 4.0, "above the limit"),
        (Split(0, 1.5, Split(0, 0.5, Leaf(0), Leaf(1)), Leaf(0)), 3.0, "depth 2"),
    ],
)
def test_the_certificate_refutes_a_wrong_tree(tree: Split, objective: float, message: str) -> None:
    problem = five_values()
    with pytest.raises(CertificateError, match=message):
        certify_set(problem, near_optimal(problem, within=1), [NearTree(tree, objective)])


def test_enumeration_of_a_large_problem_is_refused() -> None:
    problem = Problem(np.arange(300.0)[:, None], np.arange(300) % 2, depth=1)
    with pytest.raises(CertificateError, match="299 cuts"):
        recount(problem, Fraction(10))
    assert certify_set(problem, near_optimal(problem, within=0)) is None
