"""A regression problem as the native core counts it, and what its bounds prove of the true one.

The core adds float64. Gaps between targets that no leaf of a better tree spans are closed up
(`octmip.trees.evidence.far_targets`); then the targets are moved to the middle of their range and scaled by a power
of two, so that

* where targets and weights are whole numbers of some power of two, small enough together, nothing is rounded;
* where only the weights are, targets are rounded to a grid so fine that all sums of weighted targets still are whole
  numbers below 2^53;
* otherwise targets and weights stay as they are, and sums are rounded.

How far a bound of the core may lie above the true one (`distance` of a target from the grid, `rounding` of the sums) is
taken off before it is returned. Proof: docs/theory/regression.md.
"""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding.costs import power_of_two, rounded_down, whole_exponent
from octmip.trees.evidence.far_targets import closed_up, reach
from octmip.trees.question.losses import NumberLoss
from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]
CAPACITY = 2.0**53
"""Whole numbers below it are numbers of float64, and so are their sums while these stay below it."""
UNIT_ROUNDOFF = 2.0**-53
MOST_WEIGHT = 2.0**23
"""Whole weights of more than this together leave the targets too coarse a grid."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Targets, weights and squares of the native core.

    Attributes
    ----------
    targets, weights
        (n_samples,) scaled by powers of two, targets moved to the middle of their range.
    squares
        (n_samples,) weight times squared target, rounded up to multiples of `grain`; 0 for sloped errors.
    grain
        a power of two, or 0.
    penalty
        of a split.
    unit
        what one unit of the core's costs is worth; sloped errors are counted in whole slopes.
    base
        what the squares were rounded up by together.
    distance
        of a target from the grid, at most.
    rounding
        how far a computed cost or bound may be from that of the targets on the grid.
    is_whole
        whether all costs are whole numbers.
    loss, total
        of the problem; sum of the weights.
    span
        of the targets that were closed up, in the problem's units.
    """

    targets: Floats
    weights: Floats
    squares: Floats
    grain: float
    penalty: float
    unit: Fraction
    base: Fraction
    distance: float
    rounding: float
    is_whole: bool
    loss: NumberLoss
    total: float
    span: float

    @classmethod
    def of(cls, problem: Problem, objective: float) -> "Grid":
        """Return the grid of a problem on which trees of less than this objective cost what they do."""
        weight_exponent, weights = _scaled_weights(problem.samples.weights)
        near = closed_up(problem.samples.targets, reach(problem, objective))
        slopes = problem.number_loss.slopes
        steepest, over = (1, 1) if slopes is None else (slopes.steepest, slopes.over)
        exponent, targets, distance = _scaled_targets(near, weights, steepest)
        total, most = math.fsum(weights), float(np.abs(targets).max())
        is_exact = bool((weights == np.floor(weights)).all()) and total * steepest * max(most, 1.0) <= CAPACITY
        power = 2 if slopes is None else 1
        size = total * steepest * most**power
        squares, grain, base = np.zeros(len(targets)), 0.0, Fraction(0)
        if slopes is None:
            squares, grain, base = _rounded_squares(weights, targets)
            size = math.fsum(squares) if is_exact else size
        rounding = 2.0**-44 * size
        if not is_exact:
            n, lightest = len(targets) + 64, float(weights[weights > 0].min())
            rounding += 16 * n * UNIT_ROUNDOFF * size * (1 + n * UNIT_ROUNDOFF * total / lightest)
        unit = power_of_two(-weight_exponent - power * exponent) / over
        penalty = Fraction(problem.shape.leaf_penalty) / unit
        is_whole = is_exact and slopes is not None and distance == 0 and penalty.denominator == 1
        # A split that costs more than the best leaf saves nothing: any such price is as good as another.
        price = float(min(penalty, Fraction(4 * size + 4)))
        return cls(
            targets=targets,
            weights=weights,
            squares=squares,
            grain=grain,
            penalty=price,
            unit=unit,
            base=base,
            distance=distance,
            rounding=rounding,
            is_whole=is_whole,
            loss=problem.number_loss,
            total=total,
            span=float(near.max() - near.min()),
        )

    @property
    def leaf(self) -> float:
        """Objective of the best leaf for the targets that were closed up, but for rounding."""
        misses = self.targets - self.loss.best_value(self.weights, self.targets)
        over = 1 if self.loss.slopes is None else self.loss.slopes.over
        return float(self.weights @ self.loss.of_misses(misses)) * float(self.unit * over)

    def lower(self, bound: float) -> float:
        """Return the largest float64 that a bound of the core proves to be one of the problem."""
        exact = Fraction(bound) - Fraction(self.rounding)
        if self.is_whole:
            exact = Fraction(math.ceil(exact))
        exact -= self.base
        if self.loss.slopes is not None:
            exact -= Fraction(self.distance) * Fraction(self.total) * self.loss.slopes.per_move
        elif self.distance:
            # Moving the targets by so much moves the root of the error by at most distance * sqrt(total).
            least = Fraction(self.distance) ** 2 * Fraction(self.total)
            moved = 2 * self.distance * math.sqrt(self.total) * math.sqrt(max(0.0, float(exact))) * (1 + 1e-14)
            exact = exact - Fraction(moved) if exact > least else Fraction(0)
        return max(0.0, rounded_down(exact * self.unit))

    def room(self, objective: Fraction) -> float:
        """Return what a tree of this objective costs on the grid, or a little more."""
        cost = float(objective / self.unit + self.base)
        if self.loss.slopes is None:
            cost += 2 * self.distance * math.sqrt(self.total * cost) + self.distance**2 * self.total
        else:
            cost += self.distance * self.total * float(self.loss.slopes.per_move)
        return (cost + self.rounding) * (1 + 1e-12)


def _scaled_weights(weights: Floats) -> tuple[int, Floats]:
    """Return a power of two and the weights scaled by it: whole numbers where they can be small ones."""
    exponent = whole_exponent(weights)
    if math.ldexp(float(weights.sum()), min(exponent, 1000)) <= MOST_WEIGHT:
        return exponent, np.ldexp(weights, exponent)
    exponent = -math.frexp(float(weights.max()))[1]
    return exponent, np.ldexp(weights, exponent)


def _scaled_targets(targets: Floats, weights: Floats, steepest: int) -> tuple[int, Floats, float]:
    """Return a power of two, the targets scaled by it about the middle, and how far they are from the true ones."""
    middle = float(targets.min() / 2 + targets.max() / 2)
    whole = whole_exponent(np.abs(targets[targets != 0])) if targets.any() else 0
    total = math.fsum(weights) * steepest
    if math.ldexp(float(np.abs(targets).max()), min(whole, 2000)) < CAPACITY if whole < 900 else False:
        scaled = np.ldexp(targets, whole)
        moved = scaled - np.floor(math.ldexp(middle, whole))
        if total * float(np.abs(moved).max()) <= CAPACITY:
            return whole, moved, 0.0
    moved = targets - middle
    most = float(np.abs(moved).max())
    if most == 0:
        return 0, moved, 0.0
    if (weights == np.floor(weights)).all():
        exponent = math.frexp(CAPACITY / total / most)[1] - 2
        rounded = np.rint(np.ldexp(moved, exponent))
        return exponent, rounded, 0.5 + 2.0**-50 * float(np.abs(rounded).max())
    # Targets that were closed up have been rounded three times, by 2^-53 of twice the largest each.
    exponent = -math.frexp(most)[1]
    return exponent, np.ldexp(moved, exponent), 2.0**-50


def _rounded_squares(weights: Floats, targets: Floats) -> tuple[Floats, float, Fraction]:
    """Return weight times squared target rounded up to a grid, the grid, and by how much at most in all."""
    squares = weights * targets * targets
    total = math.fsum(squares)
    if total == 0:
        return squares, 0.0, Fraction(0)
    grain = math.ldexp(1.0, math.frexp(total)[1] - 50)
    rounded = (np.ceil(squares / grain) + 1) * grain
    # Products are rounded twice, by at most 2^-52 of themselves.
    return rounded, grain, Fraction(math.fsum(rounded)) - Fraction(total) * (1 - Fraction(1, 2**50))
