"""What the trees of all the folds cost on rows held out, and what a tree that is chosen by that costs on new rows.

The least of many validated costs is too low: it was chosen for being low. So the choice is made again on rows drawn
with replacement, and its cost is taken on the rows that were not drawn, which had no part in it:

    for each draw b:   step_b = the rule's choice by the drawn rows;   cost_b = cost of step_b on the others

The mean of cost_b is the estimate, its percentiles are the interval. No tree is trained again, as all trees of the
folds have been judged on every row held out. The same draws choose a pruning of CART, so the difference has an interval
too. Trees of the folds are trained on fewer rows than the tree that is returned, so the estimate is careful.

Source: I. Tsamardinos, E. Greasidou, G. Borboudakis, Bootstrapping the out-of-sample predictions for efficient and
accurate cross-validation (2018). The standard error by rows: Breiman, Friedman, Olshen & Stone (1984), Classification
and Regression Trees, section 3.4.3.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
MOST_DRAWS, FEWEST_DRAWS = 400, 100
DRAWN_ROWS = 2e7
"""In all draws, some seconds; of many rows fewer draws say as much, as their costs differ by less."""
DRAWS_AT_ONCE = 20
ROUNDING = 1e-12
"""Of a mean of costs."""
PERCENTILES = (2.5, 97.5)


@dataclass(frozen=True, slots=True)
class Nearness:
    """How near the least validated cost a simpler tree must be to be chosen.

    Attributes
    ----------
    standard_errors
        so many above the least.
    is_paired
        those of the difference of both costs on the same rows; else those of the least cost. Trees that err on the same
        rows differ by less than either is uncertain.
    """

    standard_errors: float
    is_paired: bool = False


@dataclass(frozen=True, slots=True)
class Expected:
    """A cost per unit of weight that is expected on new rows, with an interval of 95 %."""

    mean: float
    low: float
    high: float

    @classmethod
    def of(cls, draws: Floats) -> "Expected":
        """Return mean and interval of one cost for each draw, shape (n_draws,)."""
        low, high = np.percentile(draws, PERCENTILES)
        return cls(float(draws.mean()), float(low), float(high))

    def __str__(self) -> str:
        return f"{self.mean:.4g} ({self.low:.4g} to {self.high:.4g})"

    def to_json(self) -> dict[str, float]:
        """Return the three numbers."""
        return {"mean": self.mean, "low": self.low, "high": self.high}


@dataclass(frozen=True, slots=True)
class Expectation:
    """What is expected on new rows of the chosen tree, of CART pruned by the same folds, and of their difference.

    Without CART among the families, or where no rows are left for a draw, they are None.
    """

    tree: Expected
    cart: Expected | None
    difference: Expected | None

    def words(self) -> str:
        """Return what to expect on one line, with intervals of 95 %."""
        beside = "" if self.cart is None else f", of CART {self.cart}"
        return f"cost per unit of weight on new rows {self.tree}{beside}"

    def to_json(self) -> dict[str, Any]:
        """Return the object that files and `--json` hold."""
        named = {"tree": self.tree, "cart": self.cart, "difference": self.difference}
        return {name: value and value.to_json() for name, value in named.items()}


@dataclass(frozen=True, slots=True)
class Sums:
    """Sums over some rows: of each tree's losses L, their squares, and their products with the weights w.

    Attributes
    ----------
    of_losses, of_squares, of_products
        (..., n_trees) sums of L, L^2 and L w.
    weight, weight_squares
        (...,) sums of w and w^2.
    """

    of_losses: Floats
    of_squares: Floats
    of_products: Floats
    weight: Floats
    weight_squares: Floats

    def means(self) -> Floats:
        """Return the cost per unit of weight by each tree."""
        means: Floats = self.of_losses / self.weight[..., None]
        return means

    def standard_errors(self) -> Floats:
        """Return the standard error of each mean, from the spread of the rows: root of sum (L - m w)^2, by sum w."""
        m = self.means()
        squares = self.of_squares - 2 * m * self.of_products + m**2 * self.weight_squares[..., None]
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / self.weight[..., None])


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """The validated costs of every step.

    Attributes
    ----------
    losses
        for each fold (n_held, n_trees): weight times cost of each row by each tree of the fold.
    weights
        for each fold (n_held,).
    trees
        (n_steps, n_folds) which tree of each fold a step stands for.
    simplicity
        (n_steps,) the rank of each step from the simplest, 0.
    predicted
        for each fold (n_held, n_trees) the predicted class, the column of `contrasts`; unused where that is None.
    contrasts
        of the loss: the most by which two predicted classes differ in cost on one row of any class.
    """

    losses: Sequence[Floats]
    weights: Sequence[Floats]
    trees: NDArray[np.int64]
    simplicity: NDArray[np.int64]
    predicted: Sequence[NDArray[Any]] = ()
    contrasts: Floats | None = None

    def in_units(self) -> tuple["Judged", float]:
        """Return the same in powers of two in which no square overflows, and the unit of its costs per weight."""
        loss, weight = (
            int(np.frexp(max((float(fold.max(initial=0.0)) for fold in folds), default=0.0))[1])
            for folds in (self.losses, self.weights)
        )
        losses, weights = [np.ldexp(fold, -loss) for fold in self.losses], [np.ldexp(w, -weight) for w in self.weights]
        contrasts = None if self.contrasts is None else np.ldexp(self.contrasts, -loss)
        return replace(self, losses=losses, weights=weights, contrasts=contrasts), math.ldexp(1.0, loss - weight)

    def sums(self) -> Sums:
        """Return the sums of every step over all rows held out, shape (n_steps,)."""
        return next(self._sums([np.ones((1, len(weights))) for weights in self.weights]))

    def _sums(self, times: Sequence[Floats]) -> Iterator[Sums]:
        """Yield the sums of every step where each row of each fold counts so many times, (n_draws, n_held) each."""
        total: list[Any] = [0.0] * 5
        for k, (count, losses, weights) in enumerate(zip(times, self.losses, self.weights, strict=True)):
            steps = self.trees[:, k]
            of_fold = [(count @ table)[:, steps] for table in (losses, losses**2, losses * weights[:, None])]
            total = [a + b for a, b in zip(total, [*of_fold, count @ weights, count @ weights**2], strict=True)]
        return (Sums(*parts) for parts in zip(*total, strict=True))

    def _farthest(self, least: int) -> Floats:
        """Return the most by which each step's loss on one row differs from that of one step, shape (n_steps,).

        Where two trees predict different classes the row may be of any class: new rows of the class that costs most may
        come where none was held out.
        """
        most = np.zeros(len(self.trees))
        for k, losses in enumerate(self.losses):
            at = self.trees[least, k]
            apart = np.abs(losses - losses[:, [at]])
            if self.contrasts is not None:
                apart = np.maximum(apart, self.contrasts[self.predicted[k], self.predicted[k][:, [at]]])
            most = np.maximum(most, apart.max(axis=0, initial=0.0)[self.trees[:, k]])
        return most

    def best(self, nearness: Nearness) -> int:
        """Return the simplest step whose validated cost is so near the least."""
        times = [np.ones(len(weights)) for weights in self.weights]
        every = np.ones(len(self.trees), dtype=np.bool_)
        own, _ = self.in_units()
        return own._best(times, own.sums(), nearness, every, own._farthest)

    def _best(
        self,
        times: Sequence[Floats],
        sums: Sums,
        nearness: Nearness,
        is_wanted: NDArray[np.bool_],
        farthest: Callable[[int], Floats],
    ) -> int:
        """Return the best of the wanted steps where each row of each fold counts so many times, (n_held,) each."""
        means = np.where(is_wanted, sums.means(), np.inf)
        least = int(np.lexsort((self.simplicity, means))[0])
        errors = sums.standard_errors()[least]
        if nearness.is_paired:
            errors = self._paired_errors(times, sums, least, farthest(least))
        # Sums of one and the same row losses may differ by rounding.
        most = means[least] * (1 + ROUNDING) + nearness.standard_errors * errors
        good = np.flatnonzero(means <= most)
        return int(good[self.simplicity[good].argmin()])

    def _paired_errors(self, times: Sequence[Floats], sums: Sums, least: int, farthest: Floats) -> Floats:
        """Return the standard error of each step's mean less that of one step, shape (n_steps,).

        One row is added on which both differ as far as they can: few rows may lack the difference that costs most.
        """
        both: Any = 0.0  # sums of L L_least
        for k, (count, losses) in enumerate(zip(times, self.losses, strict=True)):
            both = both + ((count * losses[:, self.trees[least, k]]) @ losses)[self.trees[:, k]]
        m = sums.means() - sums.means()[least]
        squares = sums.of_squares + sums.of_squares[least] - 2 * both
        products = sums.of_products - sums.of_products[least]
        squares = squares - 2 * m * products + m**2 * sums.weight_squares
        return np.asarray(np.sqrt(np.maximum(squares, 0.0) + farthest**2) / sums.weight)

    def expectation(self, nearness: Nearness, is_cart: NDArray[np.bool_], seed: int) -> Expectation | None:
        """Return what the rule's choice costs on new rows; None where every draw takes all rows that weigh anything.

        Parameters
        ----------
        nearness
            of the rule.
        is_cart
            (n_steps,) which steps are prunings of CART; of these the one of least cost is taken.
        seed
            of the draws.
        """
        every = np.ones(len(is_cart), dtype=np.bool_)
        own, unit = self.in_units()
        costs, farthest = [], cache(own._farthest)  # few steps are the least of any draw
        for times, drawn, left in own._draws(seed):
            if left.weight > 0 and drawn.weight > 0:
                at = own._best(times, drawn, nearness, every, farthest)
                by_cart = own._best(times, drawn, Nearness(0.0), is_cart, farthest) if is_cart.any() else at
                costs.append(left.means()[[at, by_cart]])
        if not costs:
            return None
        tree, cart = np.array(costs).T * unit
        beside = (Expected.of(cart), Expected.of(tree - cart)) if is_cart.any() else (None, None)
        return Expectation(Expected.of(tree), *beside)

    def _draws(self, seed: int) -> Iterator[tuple[list[Floats], Sums, Sums]]:
        """Yield for each draw how often it takes each row, the sums over these rows, and over those not taken."""
        rng = np.random.default_rng(seed)
        n_draws = int(np.clip(DRAWN_ROWS / sum(map(len, self.weights)), FEWEST_DRAWS, MOST_DRAWS))
        for _ in range(n_draws // DRAWS_AT_ONCE):
            drawn = []
            for n in map(len, self.weights):
                rows = rng.integers(n, size=(DRAWS_AT_ONCE, n)) + n * np.arange(DRAWS_AT_ONCE)[:, None]
                times = np.bincount(rows.ravel(), minlength=n * DRAWS_AT_ONCE)
                drawn.append(times.reshape(DRAWS_AT_ONCE, n).astype(np.float64))
            left = self._sums([(times == 0) * 1.0 for times in drawn])
            each = ([times[k] for times in drawn] for k in range(DRAWS_AT_ONCE))
            yield from zip(each, self._sums(drawn), left, strict=True)
