"""Weights, costs and penalty as whole numbers: as they are, or rounded down on a grid.

Every float64 is a whole number times a power of two. Whatever decides between two costs compares them exactly, and what
is shown is rounded afterwards, a bound by `rounded_down`. A rounded sum is not compared with an exact one.

Bounds proven on the grid hold for the true costs, as no number is above the true one. What no prediction avoids is
counted apart (`base`), and a cost above that of a known tree is lowered to just above it, as no tree that pays it is
wanted; what is left decides between trees, and gets all the digits. Lemma and proof: docs/theory/exact.md.
"""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.trees.answer.solution import closing_tolerance
from octmip.trees.nodes.tree import Node, complexity, predict
from octmip.trees.question.problem import Problem

MOST = 2**62  # larger whole numbers do not enter the native core
CAPACITY = 2.0**52  # whole-numbered objectives stay below it, so float64 holds every one of them exactly
ROUNDED_CAPACITY = 2.0**60  # rounded numbers need more digits than float64 has; sums of two of them still fit 63 bits
# Rows of costs for single samples, at most: finer than products of a weight and a cost can be, but each is a kind of
# sample to the core, which is fast where kinds are few.
MOST_OWN_ROWS = 64
# Costs that are multiples of one number but for this share of them, up to so many times it, are counted in that number:
# 0.2, 0.4 and 0.6 are in truth, and float64 holds none of them.
ALIKE, MOST_STEPS, MOST_DISTINCT = 1e-12, 2**20, 256
LOWERED = 1 + 1e-9  # a known cost summed in float64 is at most this times too low


@dataclass(frozen=True, slots=True, eq=False)
class IntegerCosts:
    """Weights, costs and penalty as whole numbers of ``2**-exponent``, none above the true one.

    ``weights[i] * costs[rows[i], k] * 2**-exponent <= w_i * (C[label_i, k] - cheapest of C[label_i])`` for every sample
    i and class k; the cheapest answers together are `base`, which no tree avoids (0 where nothing is rounded: there the
    costs are whole as they stand).

    Attributes
    ----------
    weights
        (n_samples,) int64.
    rows
        (n_samples,) int64, row of `costs` of each sample: its class, or one of its own.
    costs
        (n_rows, n_rows) int64; columns beyond the classes are no answers and cost as much as the worst.
    penalty
        of one feature in one split.
    exponent
        of the unit.
    weight_exponent
        the part of it that scales the weights, where nothing is rounded.
    base
        what every tree costs besides.
    is_rounded
        whether a whole-numbered objective may lie below the true one, or a cost was lowered.
    tolerance
        how far, at most, for trees no worse than the one that was known; 0 when nothing was rounded.
    """

    weights: NDArray[np.int64]
    rows: NDArray[np.int64]
    costs: NDArray[np.int64]
    penalty: int
    exponent: int
    weight_exponent: int
    base: Fraction
    is_rounded: bool
    tolerance: float

    @property
    def unit(self) -> float:
        """Factor from a whole-numbered objective to the problem's, `base` left out."""
        return math.ldexp(1.0, -self.exponent)

    def value(self, whole: int) -> float:
        """Return the largest float64 not above a whole-numbered objective or bound, in the problem's units."""
        return rounded_down(self.base + whole * power_of_two(-self.exponent))

    def closing(self, problem: Problem, tree: Node | None, objective: float, bound: float) -> float:
        """Return the tolerance under which a bound proves a tree optimal, whose search ended; -1 where it does not.

        What rounding may hide is less than a sample's worth: see `closing_tolerance`. Half a unit in the objective's
        last place may be too much, and the tree's own rounding, which is often none, is not.
        """
        if not self.is_rounded:
            return 0.0 if bound >= objective else -1.0
        tolerance = closing_tolerance(objective, bound, problem.least_saving)
        if tolerance < 0 and tree is not None:
            rounding = float(abs(problem.exact_objective(tree) - Fraction(objective)))
            tolerance = closing_tolerance(objective, bound, problem.least_saving, rounding)
        return tolerance

    def whole_objective(self, problem: Problem, tree: Node) -> int:
        """Return the objective of a tree as the core counts it."""
        paid = self.weights * self.costs[self.rows, predict(tree, problem.samples.features)]
        return int(paid.sum()) + self.penalty * complexity(tree)


def integer_costs(problem: Problem, known: Node | None = None) -> IntegerCosts:
    """Return the weights, costs and penalty of a problem as whole numbers, rounded down where they are not whole.

    The smallest powers of two that make dyadic numbers (0.5, 2.25) whole; where none below `CAPACITY` does, all costs
    above the best tree known (`known`, or one leaf) are lowered to just above it, and the others fill
    `ROUNDED_CAPACITY`. The cheaper that tree, the finer the grid.
    """
    return _whole_costs(problem) or _rounded_costs(problem, known)


def _whole_costs(problem: Problem) -> IntegerCosts | None:
    """Return the costs of a problem whose objectives are whole numbers of some power of two, all below `CAPACITY`."""
    true = problem.samples.weights
    weight_exponent, cost_exponent = (max(0, whole_exponent(array)) for array in (true, problem.costs))
    weights = floors(true, power_of_two(weight_exponent), MOST)
    costs = floors(problem.costs.ravel(), power_of_two(cost_exponent), MOST).reshape(problem.costs.shape)
    most = float(weights.sum(dtype=np.float64)) * max(float(costs.max()), 1.0)
    if most + 1 >= CAPACITY:
        return None
    # A penalty above every other cost is cut to just above: no tree with a split is optimal either way, where none must
    # have one.
    price = Fraction(problem.shape.leaf_penalty) * power_of_two(weight_exponent + cost_exponent)
    n_asked = problem.shape.most_asked_splits
    more = price.denominator.bit_length() - 1 if price < most + 1 or n_asked else 0
    if (Fraction(most) + n_asked * price) * 2**more + 1 >= CAPACITY:
        return None
    above_all = int(weights.sum()) * max(int(costs.max()) << more, 1) + 1
    penalty = int(price * 2**more) if n_asked else min(int(price * 2**more), above_all)
    exponent = weight_exponent + cost_exponent + more
    zero = Fraction(0)
    return IntegerCosts(
        weights, problem.samples.codes, costs << more, penalty, exponent, weight_exponent, zero, False, 0.0
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Excess:
    """Excess costs: predictions above the cheapest of their samples, scaled by a power of two to below 1.

    Attributes
    ----------
    weights
        (n_samples,) float64, below 1.
    exact
        (n_classes, n_classes) costs less the cheapest of their row, as they are.
    costs
        the same in float64, below 1.
    scale
        weight times cost is ``2**scale`` times these.
    most
        what the best known tree costs, or a little more: costs above need not be distinguished.
    asked
        price of the splits that have to stand, on the same scale.
    """

    weights: NDArray[np.float64]
    exact: tuple[tuple[Fraction, ...], ...]
    costs: NDArray[np.float64]
    scale: int
    most: float
    asked: float

    @classmethod
    def of(cls, problem: Problem, known: Node | None) -> "_Excess":
        samples = problem.samples
        table = [[Fraction(cost) for cost in row] for row in problem.costs.tolist()]
        exact = tuple(tuple(cost - min(row) for cost in row) for row in table)
        scales = [int(np.frexp(top)[1]) for top in (samples.weights.max(), float(max(map(max, exact))))]
        weights = np.ldexp(samples.weights, -scales[0])
        costs = np.array([[float(cost * power_of_two(-scales[1])) for cost in row] for row in exact])
        price = Fraction(problem.shape.leaf_penalty) * power_of_two(-sum(scales))
        asked = float(problem.shape.most_asked_splits * price)
        most = float((np.bincount(samples.codes, weights, samples.n_classes) @ costs).min()) + asked
        if known is not None:
            penalty = complexity(known) * price
            if penalty < most:
                paid = math.fsum(weights * costs[samples.codes, predict(known, samples.features)])
                most = min(most, paid + float(penalty))
        return cls(weights, exact, costs, sum(scales), most * LOWERED, asked)


def _rounded_costs(problem: Problem, known: Node | None) -> IntegerCosts:
    excess = _Excess.of(problem, known)
    highest = excess.weights * excess.costs.max(axis=1)[problem.samples.codes]
    total = float(np.minimum(highest, 4 * excess.most).sum()) + excess.asked or 1.0
    exponent = math.floor(math.log2(ROUNDED_CAPACITY) - math.log2(total)) - excess.scale
    exact = whole_exponent(problem.samples.weights) + whole_exponent(problem.costs)
    exponent = min(exponent, max(exact, whole_exponent(np.array([problem.shape.leaf_penalty]))))
    while (grid := _Grid(problem, excess, exponent)).total > ROUNDED_CAPACITY:
        exponent -= 1
    return grid.costs()


class _Grid:
    """The excess costs of a problem on a grid of ``2**-exponent``, rounded down, those above the cap lowered to it.

    Where costs are multiples of one number but for rounding, the numbers of the grid are so exactly (`step`): the
    native core counts in the largest number that all are multiples of, and is fastest where that leaves small ones.

    A class with one price for every wrong answer counts it in its weights. Where there are more prices, samples of few
    different weights get rows of their own, as their costs are then rounded one by one. Many share the row of their
    class: weight and cost are rounded each for itself, and where a cost of a sample is above the cap, it takes a row
    that is cut off between the cap and four times it, together with samples of weights like its own.
    """

    def __init__(self, problem: Problem, excess: _Excess, exponent: int) -> None:
        samples = problem.samples
        self.problem, self.excess, self.exponent = problem, excess, exponent
        above = int(Fraction(excess.most) * power_of_two(excess.scale + exponent)) + 1
        self.step = _common_step(problem, excess, exponent, above)
        self.cap = -(-above // self.step) * self.step
        self.weights = np.zeros(samples.n_samples, dtype=np.int64)
        self.rows = samples.codes.copy()
        self.table: list[list[int] | None] = [None] * samples.n_classes
        self.loss = 0.0  # in units of 2**-exponent
        members = [np.flatnonzero((samples.codes == c) & (samples.weights > 0)) for c in range(samples.n_classes)]
        many = [c for c, prices in enumerate(excess.exact) if len({price for price in prices if price}) > 1]
        n_own = sum(len(np.unique(samples.weights[members[c]])) for c in many)
        for c in range(samples.n_classes):
            if c not in many:
                self._add_single(c, members[c])
            elif n_own <= MOST_OWN_ROWS:
                self._add_own(c, members[c])
            else:
                self._add_products(c, members[c])

    @property
    def total(self) -> float:
        """Sum of the largest cost of each sample, and of what splits that have to stand cost."""
        highest = np.array([float(max(row or [0])) for row in self.table])
        asked = math.ldexp(self.excess.asked, self.excess.scale + self.exponent)
        return float((self.weights.astype(float) * highest[self.rows]).sum()) + asked

    def _add(self, c: int, row: list[int], members: NDArray[np.int64], weights: NDArray[np.int64]) -> None:
        """Give some samples of class c this row: the class's own, if nobody has it yet, else one more."""
        place = c if self.table[c] is None else len(self.table)
        self.table[place : place + 1] = [row]
        self.rows[members], self.weights[members] = place, weights

    def _add_single(self, c: int, members: NDArray[np.int64]) -> None:
        price = max(self.excess.exact[c])
        weights = floors(self.problem.samples.weights[members], price * power_of_two(self.exponent), self.cap)
        past = weights % self.step
        self._add(c, [int(cost > 0) for cost in self.excess.exact[c]], members, weights - past)
        self.loss += len(members) + float(past.sum(dtype=float))

    def _add_own(self, c: int, members: NDArray[np.int64]) -> None:
        for weight in np.unique(self.problem.samples.weights[members]).tolist():
            scaled = Fraction(weight) * power_of_two(self.exponent)
            row = [min(self.cap, int(scaled * price)) for price in self.excess.exact[c]]
            past = [cost % self.step for cost in row]
            equal = members[self.problem.samples.weights[members] == weight]
            row = [cost - more for cost, more in zip(row, past, strict=True)]
            self._add(c, row, equal, np.ones(len(equal), dtype=np.int64))
            self.loss += len(equal) * (1.0 + max(past))

    def _add_products(self, c: int, members: NDArray[np.int64]) -> None:
        """Rows in which prices are cut off at a power of two, the least that costs a sample twice the cap or more."""
        prices = self.excess.exact[c]
        places = [price.numerator.bit_length() - price.denominator.bit_length() for price in prices if price]
        doubled = math.log2(max(2 * self.excess.most, 1e-300)) + self.excess.scale
        powers = np.ceil(doubled - np.log2(self.problem.samples.weights[members]))
        # Above all prices nothing is cut off, below the least one everything is.
        powers = np.clip(powers, min(places) - 1, max(places) + 1)
        for power in np.unique(powers).tolist():
            cut = [min(price, power_of_two(int(power))) for price in prices]
            self._add_product(c, cut, members[powers == power])

    def _add_product(self, c: int, prices: list[Fraction], members: NDArray[np.int64]) -> None:
        """Add a row for some samples, weights and prices rounded at the powers of two that lose least."""
        weights, highest = self.problem.samples.weights[members], max(prices)
        # A weight loses up to 2^-a of the highest price, a price up to 2^-b of the sum of the weights: best when equal.
        place = highest.numerator.bit_length() - highest.denominator.bit_length()
        equal = (self.exponent + round(math.log2(float(weights.mean()))) - place) // 2
        whole = max(price.denominator for price in prices).bit_length() - 1
        choices = {equal, whole, self.exponent - whole_exponent(weights)}
        loss, row, rounded = min(
            (self._product(prices, weights, b) for b in sorted(choices)), key=lambda entry: entry[0]
        )
        self._add(c, row, members, rounded)
        self.loss += loss

    def _product(
        self, prices: list[Fraction], weights: NDArray[np.float64], digits: int
    ) -> tuple[float, list[int], NDArray[np.int64]]:
        """Return what rounding may lose on the grid, prices and weights, with so many binary digits for the prices."""
        row = [int(price * power_of_two(digits)) for price in prices]
        if not any(row):  # nothing is left of the prices, so all that the samples cost is lost
            everything = float(max(prices) * power_of_two(self.exponent)) * float(weights.sum())
            return everything, row, np.zeros(len(weights), dtype=np.int64)
        most = min(MOST, 4 * self.cap // max(row) + 1)
        rounded = floors(weights, power_of_two(self.exponent - digits), most)
        short = max(price * power_of_two(digits) - cost for price, cost in zip(prices, row, strict=True))
        n_short = 0 if self.exponent - digits >= whole_exponent(weights) else len(weights)
        lost = float(short) * float(rounded.sum(dtype=float)) + float(max(prices) * power_of_two(digits)) * n_short
        return lost, row, rounded

    def costs(self) -> IntegerCosts:
        """Return the costs on the grid."""
        problem, table = self.problem, [row or [0] * self.problem.samples.n_classes for row in self.table]
        costs = np.array([row + [max(row)] * (len(table) - problem.samples.n_classes) for row in table], dtype=np.int64)
        price = Fraction(problem.shape.leaf_penalty) * power_of_two(self.exponent)
        n_prices = min(2.0**problem.shape.depth - 1, problem.samples.n_samples) * problem.shape.max_split_size
        penalty = min(int(price), self.cap)
        penalty -= penalty % self.step
        loss = self.loss + (float(price - penalty) * n_prices if price < self.cap else 0)
        is_exact = self.exponent >= whole_exponent(problem.samples.weights) + whole_exponent(problem.costs)
        if is_exact and self.step == 1 and (price.denominator == 1 or price > self.cap):
            loss = 0.0
        return IntegerCosts(
            self.weights,
            self.rows,
            costs,
            penalty,
            self.exponent,
            0,
            self._base(),
            True,
            math.ldexp(loss, -self.exponent),
        )

    def _base(self) -> Fraction:
        """Return what the cheapest answers cost together."""
        base = Fraction(0)
        for c, cheapest in enumerate(self.problem.costs.min(axis=1).tolist()):
            if cheapest:
                base += exact_sum(self.problem.samples.weights[self.problem.samples.codes == c]) * Fraction(cheapest)
        return base


def _common_step(problem: Problem, excess: _Excess, exponent: int, above: int) -> int:
    """Return the number on the grid that costs and penalty up to `above` are multiples of but for rounding, else 1.

    The cap is the next multiple. What lies between would be rounded down to the cost of the known tree: then it is 1.
    """
    samples = problem.samples
    if len(np.unique(samples.weights)) > MOST_DISTINCT:
        return 1
    counted = [np.unique(samples.weights[samples.codes == c]).tolist() for c in range(samples.n_classes)]
    pairs = zip(counted, excess.exact, strict=True)
    values = {Fraction(weight) * price for weights, row in pairs for weight in weights for price in set(row)}
    every = sorted(value * power_of_two(exponent) for value in values | {Fraction(problem.shape.leaf_penalty)})
    scaled = [value for value in every if 0 < value <= above]  # what is more is lowered to the cap
    if not scaled or len(scaled) > MOST_DISTINCT or scaled[-1] > MOST_STEPS * scaled[0]:
        return 1
    numbers = np.array([float(value / scaled[0]) for value in scaled])
    for part in range(1, 33):
        steps = np.rint(numbers * part)
        if (np.abs(numbers * part - steps) <= ALIKE * steps).all():
            step = max(1, min(int(value / int(n)) for value, n in zip(scaled, steps, strict=True)))
            return step if all(value <= above or value >= -(-above // step) * step for value in every) else 1
    return 1


def power_of_two(exponent: int) -> Fraction:
    """Return 2**exponent."""
    return Fraction(2) ** int(exponent)


def whole_exponent(numbers: NDArray[np.float64]) -> int:
    """Return the least power of two that makes all of them whole; below 0 where they are multiples of one."""
    mantissas, exponents = np.frexp(numbers[numbers > 0])
    digits = np.ldexp(mantissas, 53).astype(np.int64)
    lowest = np.frexp((digits & -digits).astype(np.float64))[1] - 1  # place of the last binary digit that is not 0
    return int((53 - exponents - lowest).max(initial=-2000))


def floors(values: NDArray[np.float64], factor: Fraction, most: int) -> NDArray[np.int64]:
    """Return the values times a factor, rounded down, `most` at most: in exact arithmetic."""
    shift = factor.numerator.bit_length() - factor.denominator.bit_length()
    if factor == power_of_two(shift):
        with np.errstate(over="ignore"):
            scaled = np.floor(np.ldexp(values, shift))
        return np.minimum(np.minimum(scaled, float(MOST)).astype(np.int64), most)
    distinct, places = np.unique(values, return_inverse=True)
    ratios = (value.as_integer_ratio() for value in distinct.tolist())
    floors = [min(most, above * factor.numerator // (below * factor.denominator)) for above, below in ratios]
    return np.array(floors, dtype=np.int64)[places]


def exact_sum(values: NDArray[np.float64]) -> Fraction:
    """Return the sum of numbers, none of its digits lost."""
    ratios = [value.as_integer_ratio() for value in values.tolist()]
    denominator = max((below for _, below in ratios), default=1)
    return Fraction(sum(above * (denominator // below) for above, below in ratios), denominator)


def rounded_down(exact: Fraction) -> float:
    """Return the largest float64 that is not above a number."""
    nearest = float(exact)
    return nearest if Fraction(nearest) <= exact else math.nextafter(nearest, -math.inf)
