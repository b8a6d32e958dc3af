"""Retraining a tree on the augmented twin: what comes back, and when nothing can be said."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import CHAIN, Addition, AugmentedTwin
from octmip.gap.retrain import Lesson, Recovery, means, recovery, retrained, samples, trained
from octmip.trees.tree import Leaf, Split, predict


@dataclass(frozen=True)
class Bar:
    """Two gauges whose strain at load factor 1 is 1000 and 500 microstrain, and twice that at full damage."""

    gauges: tuple = ("a", "b")
    parameters: tuple = ("mu",)
    effects: dict = field(default_factory=dict)

    def predict(self, state, load_factor):
        return load_factor * np.array([1000.0, 500.0]) * (1.0 + state.get("mu", 0.0))


def lesson(**other):
    states = np.array([[0.0], [0.2], [0.4]])
    settings = {"states": states, "labels": 100.0 * states[:, 0], "gauges": ("a",), "load_factor": 2.0}
    return Lesson(**{**settings, "repeats": 60, "sd": 30.0, "depth": 2, **other})


def augmented(gain):
    return AugmentedTwin(Bar(), (Addition(CHAIN["common_gain"], "", gain),))


def test_the_means_are_the_twins_at_the_load_of_the_lesson():
    assert means(Bar(), lesson()).ravel() == pytest.approx([2000.0, 2400.0, 2800.0])
    assert means(augmented(10.0), lesson()).ravel() == pytest.approx([2200.0, 2640.0, 3080.0])


def test_a_calibrated_gauge_differs_in_the_change_that_damage_makes_by_the_share_of_its_healthy_strain():
    twin = AugmentedTwin(Bar(), (), calibration=np.array([50.0, 200.0]))
    assert twin.predict({}, 2.0) == pytest.approx([2100.0, 1400.0])
    # 5 % of a change of 800; 200 of 500 is no factor on a gauge's strain
    assert twin.predict({"mu": 0.4}, 2.0) == pytest.approx([2800.0 + 100.0 + 40.0, 1400.0 + 400.0])


def test_features_are_readings_over_the_load_with_the_noise_of_one_reading():
    features, labels = samples(lesson(), means(Bar(), lesson()), 4000, seed=3)
    healthy = features[labels == 0.0]
    assert healthy.mean() == pytest.approx(1000.0, abs=1.0)
    assert healthy.std() == pytest.approx(15.0, rel=0.05)


@pytest.mark.parametrize("method", ["search", "cart"])
def test_a_tree_learns_thresholds_midway_between_the_states(method):
    solution = retrained(Bar(), lesson(sd=1.0), method)
    assert solution.objective == 0.0
    told = predict(solution.tree, np.array([[1099.0], [1101.0], [1299.0], [1301.0]]))
    assert told.tolist() == [0, 1, 1, 2]


def test_an_augmented_twin_that_is_the_asset_recovers_everything():
    plan, asset = lesson(), means(augmented(10.0), lesson())
    trees = [trained(plan, mean).tree for mean in (means(Bar(), plan), means(augmented(10.0), plan), asset)]
    found = recovery(plan, asset, trees)
    assert found.after == found.oracle
    assert found.recovered == 1.0
    assert found.before > found.oracle + 5.0


def test_a_better_but_wrong_twin_recovers_a_part():
    plan = lesson(sd=120.0, repeats=400)
    asset = means(augmented(10.0), plan)
    trees = [trained(plan, mean).tree for mean in (means(Bar(), plan), means(augmented(5.0), plan), asset)]
    assert 0.3 < recovery(plan, asset, trees).recovered < 0.95


def test_the_errors_are_those_of_hand_made_trees():
    plan = lesson(sd=1e-3)
    perfect = Split(0, 1100.0, Leaf(0), Split(0, 1300.0, Leaf(1), Leaf(2)))
    found = recovery(plan, means(Bar(), plan), [Leaf(0), Leaf(1), perfect])
    assert (found.before, found.after, found.oracle) == pytest.approx((20.0, 40.0 / 3.0, 0.0))
    assert found.recovered == pytest.approx(1.0 / 3.0)


def test_no_share_is_told_where_the_gap_costs_the_tree_nothing():
    assert np.isnan(Recovery(before=1.0, after=0.9, oracle=0.9, standard_error=0.05).recovered)
    assert Recovery(before=1.0, after=0.9, oracle=0.5, standard_error=0.05).recovered == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"gauges": ("c",)}, "'c', which is no gauge of the twin"),
        ({"load_factor": 0.0}, "load factor of a lesson is 0"),
        ({"labels": np.zeros(2)}, "3 states and labels of shape"),
        ({"sd": 0.0}, "noise of a lesson is 0"),
    ],
)
def test_a_lesson_that_cannot_be_learnt_is_refused(other, words):
    with pytest.raises(DataError, match=words):
        retrained(Bar(), lesson(**other))


def test_a_lesson_changes_nothing_that_it_was_given():
    states = np.zeros((3, 1))
    plan = lesson(states=states)
    states[0] = 9.0
    assert plan.states[0] == 0.0
    assert replace(plan, depth=1).depth == 1
