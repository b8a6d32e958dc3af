"""Steps: the intervals of alpha on which the cross-validated cost of a family of trees does not change.

The penalty paths of all folds (octmip.trees.tradeoff.path) hold the best tree for every alpha; where no fold changes
its tree, the cost on the rows held out is one number. Each step stands for one tree of every fold and for the tree that
the family's path over all samples has there.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.prediction import predict, predict_values
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff.family import Family
from octmip.trees.tradeoff.folds import Fold, Rows
from octmip.trees.tradeoff.path import PenaltyPath, middle
from octmip.trees.tradeoff.validation import Judged


@dataclass(frozen=True, slots=True)
class Step:
    """A family of trees and an interval of alpha on which the cross-validated cost does not change.

    Attributes
    ----------
    family
        the kind of trees.
    alpha_low, alpha_high
        ends of the interval; the last of each depth has no upper one (inf).
    validation_cost
        mean over all samples of weight * cost when they were not trained on, divided by mean weight.
    standard_error
        of that mean, from the spread of the samples.
    complexity
        features summed over the splits of the tree fitted to all samples, in the middle of the interval.
    training_cost
        of that tree, per unit of weight like `validation_cost`.
    """

    family: Family
    alpha_low: float
    alpha_high: float
    validation_cost: float
    standard_error: float
    complexity: int
    training_cost: float

    @property
    def depth(self) -> int:
        """The depth of the family."""
        return self.family.depth

    @property
    def kind(self) -> str:
        """The family, in words."""
        return self.family.words

    @property
    def alpha(self) -> float:
        """The middle of the interval; twice its lower end where it has no upper one."""
        return middle(self.alpha_low, self.alpha_high)


def judged_steps(
    problem: Problem, path: PenaltyPath, family: Family, of_folds: Sequence[PenaltyPath], pairs: Sequence[Fold]
) -> tuple[list[Step], Judged]:
    """Return the steps of one family, neighbours of equal validation cost as one, and what they were judged by."""
    samples = problem.samples
    held = [rows for _, rows in pairs]
    weights = [samples.weights[rows] for rows in held]
    predicted = [_predictions(problem, fold, rows) for fold, rows in zip(of_folds, held, strict=True)]
    losses = [_losses(problem, rows, values) for rows, values in zip(held, predicted, strict=True)]
    costs = [np.array([math.fsum(column) for column in fold.T]) for fold in losses]
    baseline, baselines = problem.baseline, [f.problem.baseline for f in of_folds]  # each is a pass over the samples
    ends = sorted({c.penalty_low / base for f, base in zip(of_folds, baselines, strict=True) for c in f.trees})
    known: list[tuple[float, list[int], NDArray[np.float64]]] = []
    for low, high in pairwise([*ends, math.inf]):
        alpha = middle(low, high) if high > low else low
        at = [_index_at(f, alpha * base) for f, base in zip(of_folds, baselines, strict=True)]
        cost = np.array([fold[k] for fold, k in zip(costs, at, strict=True)])
        if not known or (cost != known[-1][2]).any():
            known.append((low, at, cost))
    contrasts = problem.loss.contrasts(samples.weights, samples.codes)
    trees = np.array([at for _, at, _ in known])
    judged = Judged(losses, weights, trees, np.arange(len(known)), predicted, contrasts)
    own, unit = judged.in_units()
    sums, steps = own.sums(), []
    ends_of = [*(low for low, _, _ in known[1:]), math.inf]
    means, errors = (sums.means() * unit).tolist(), (sums.standard_errors() * unit).tolist()
    for (low, _, _), high, mean, error in zip(known, ends_of, means, errors, strict=True):
        tree = path.best_at(middle(low, high) * baseline)
        steps.append(Step(family, low, high, mean, error, tree.complexity, tree.cost / float(samples.weights.sum())))
    return steps, judged


def all_together(judged: Sequence[Judged], steps: Sequence[Step]) -> Judged:
    """Return the steps of all families as one, ranked from the simplest; among equals by cost, proven before CART."""
    losses, predicted = (
        [np.concatenate(fold, axis=1) for fold in zip(*of_families, strict=True)]
        for of_families in ([one.losses for one in judged], [one.predicted for one in judged])
    )
    before = np.cumsum([[0] * len(losses), *([fold.shape[1] for fold in one.losses] for one in judged[:-1])], axis=0)
    trees = np.concatenate([one.trees + first for one, first in zip(judged, before, strict=True)])
    keys = [
        (step.complexity, step.validation_cost, step.family.method == "cart", step.depth, -step.alpha_low)
        for step in steps
    ]
    rank = np.empty(len(steps), dtype=np.int64)
    rank[sorted(range(len(steps)), key=keys.__getitem__)] = np.arange(len(steps))
    return Judged(losses, judged[0].weights, trees, rank, predicted, judged[0].contrasts)


def _predictions(problem: Problem, path: PenaltyPath, rows: Rows) -> NDArray[Any]:
    """Return what every tree of a path predicts for the held-out rows, shape (n_rows, n_trees)."""
    how = predict if problem.loss.predicts == "class" else predict_values
    return np.stack([how(best.tree, problem.samples.features[rows]) for best in path.trees], axis=1)


def _losses(problem: Problem, rows: Rows, predicted: NDArray[Any]) -> NDArray[np.float64]:
    """Return weight times cost of the held-out rows by every tree of a path, shape (n_rows, n_trees)."""
    part = problem.samples.weights[rows], problem.samples.codes[rows]
    return np.stack([problem.loss.row_costs(*part, values) for values in predicted.T], axis=1)


def _index_at(path: PenaltyPath, penalty: float) -> int:
    """Return the index of the tree of a path that is best at a penalty."""
    return bisect_right(path.trees, penalty, key=lambda best: best.penalty_low) - 1
