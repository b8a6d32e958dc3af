"""Retraining of a deployed tree on the augmented twin, and the share of the gap's cost that it recovers.

A tree that reads damage from strain learns from readings that a twin simulates: every state of a plan, so many noisy
repeats each, divided by the load factor. With E the mean absolute error on the asset's readings,

    recovered = (E_before - E_after) / (E_before - E_oracle),

before: trained on the twin as it is; after: on the augmented twin; oracle: on the asset itself. All three learn with
the same noise, so that their difference is the twins' alone.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError
from octmip.trees.losses import ClassCosts
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution
from octmip.trees.solver import Method, solve
from octmip.trees.tree import Node, predict
from octmip.twin import Twin, predict_states

Floats = NDArray[np.float64]

ANSWERS = 400
"""Readings per state on which an error is measured."""
SIGNIFICANT = 3.0
"""Standard errors by which the gap's cost must exceed zero before a share of it means anything."""


@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """The task that a tree is to learn.

    Attributes
    ----------
    states
        (n_states, n_parameters) values of the twin's state parameters.
    labels
        (n_states,) number that the tree is to predict in each state, for instance a damage in per cent.
    gauges
        names of the gauges that the tree may read; its features, in this order.
    load_factor
        of the readings; they are divided by it.
    repeats
        noisy readings per state.
    sd
        standard deviation of one reading [microstrain] before the division, or one per gauge (n_gauges,).
    depth
        levels of splits.
    """

    states: Floats
    labels: Floats
    gauges: tuple[str, ...]
    load_factor: float
    repeats: int
    sd: float | Floats
    depth: int

    def __post_init__(self) -> None:
        states = np.atleast_2d(np.array(self.states, dtype=np.float64))
        labels = np.array(self.labels, dtype=np.float64)
        if labels.shape != (len(states),):
            raise DataError(
                f"a lesson has {len(states)} states and labels of shape {labels.shape}; give one label each"
            )
        if self.load_factor == 0.0:
            raise DataError("the load factor of a lesson is 0; expected another, readings are divided by it")
        if not (np.asarray(self.sd) > 0.0).all():
            raise DataError(f"the noise of a lesson is {self.sd}; expected more than 0 microstrain")
        object.__setattr__(self, "states", states)
        object.__setattr__(self, "labels", labels)
        object.__setattr__(self, "gauges", tuple(self.gauges))


def means(twin: Twin, lesson: Lesson) -> Floats:
    """Return the twin's readings (n_states, n_gauges) [microstrain] in the lesson's states, without noise.

    Raises
    ------
    DataError
        the twin lacks a gauge of the lesson.
    """
    missing = [name for name in lesson.gauges if name not in twin.gauges]
    if missing:
        raise DataError(f"the lesson reads {missing[0]!r}, which is no gauge of the twin ({', '.join(twin.gauges)})")
    order = [twin.gauges.index(name) for name in lesson.gauges]
    return predict_states(twin, lesson.states, lesson.load_factor)[:, order]


def samples(lesson: Lesson, mean: ArrayLike, repeats: int, seed: int) -> tuple[Floats, Floats]:
    """Return features (n_states repeats, n_gauges), readings over the load factor, and their labels (n,)."""
    centre = np.repeat(np.asarray(mean, dtype=np.float64), repeats, axis=0)
    noise = np.random.default_rng(seed).standard_normal(centre.shape) * np.asarray(lesson.sd)
    return (centre + noise) / lesson.load_factor, np.repeat(lesson.labels, repeats)


def trained(lesson: Lesson, mean: ArrayLike, method: Method = "search", seed: int = 0) -> Solution:
    """Return the tree of least mean absolute error on noisy readings about means (n_states, n_gauges).

    Parameters
    ----------
    lesson
        what it is to learn.
    mean
        of the readings [microstrain], from `means` or from an asset whose states are known.
    method
        of `octmip.solve`; "search" and "cart" take seconds.
    seed
        of the noise and of the search.
    """
    features, labels = samples(lesson, mean, lesson.repeats, seed)
    classes = np.unique(lesson.labels)
    costs = np.abs(classes[:, None] - classes[None, :])
    names = tuple(classes.tolist())
    problem = Problem(
        features, labels, depth=lesson.depth, loss=ClassCosts(costs), class_names=names, feature_names=lesson.gauges
    )
    return solve(problem, method=method, seed=seed)


def retrained(twin: Twin, lesson: Lesson, method: Method = "search", seed: int = 0) -> Solution:
    """Return the tree that a twin's readings teach: give `diagnosis.augmented(twin)` to retrain after a diagnosis.

    Raises
    ------
    DataError
        the twin lacks a gauge of the lesson.
    """
    return trained(lesson, means(twin, lesson), method, seed)


@dataclass(frozen=True, slots=True)
class Recovery:
    """Mean absolute errors on the asset's readings, in the unit of the labels.

    Attributes
    ----------
    before, after, oracle
        of the trees trained on the twin, on the augmented twin and on the asset.
    standard_error
        of `before` - `oracle`.
    """

    before: float
    after: float
    oracle: float
    standard_error: float
    recovered: float = field(init=False)

    def __post_init__(self) -> None:
        cost = self.before - self.oracle
        is_significant = cost > SIGNIFICANT * self.standard_error
        object.__setattr__(self, "recovered", (self.before - self.after) / cost if is_significant else math.nan)


def recovery(
    lesson: Lesson, asset_means: ArrayLike, trees: Sequence[Node], seed: int = 1, answers: int = ANSWERS
) -> Recovery:
    """Return what retraining recovers on the asset's readings; NaN where the gap costs no more than noise.

    Parameters
    ----------
    lesson
        what the trees were to learn.
    asset_means
        (n_states, n_gauges) the asset's mean readings in the lesson's states [microstrain].
    trees
        trained on the twin, on the augmented twin and on the asset.
    seed
        of the readings on which all three are tried; another than the training's.
    answers
        readings per state.
    """
    features, labels = samples(lesson, asset_means, answers, seed)
    before, after, oracle = (np.abs(_predicted(tree, lesson, features) - labels) for tree in trees)
    error = float(np.std(before - oracle) / np.sqrt(len(labels)))
    return Recovery(float(before.mean()), float(after.mean()), float(oracle.mean()), error)


def _predicted(tree: Node, lesson: Lesson, features: Floats) -> Floats:
    return np.unique(lesson.labels)[predict(tree, features)]
