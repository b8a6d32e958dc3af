"""Trees that decide between 3 g and 2 g: missed critical damage against false alarms, by the price of a failure."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from femlib.dataset import Dataset
from octmip import ClassCosts, Limits, certify, predict, solve
from octmip.trees.risk import ErrorRates, RiskModel
from octmip.trees.solution import Solution
from octmip.trees.tradeoff import trace_risk_frontier

REGIONS = {"mu1": (0,), "mu2": (1,), "mu1 or mu2": (0, 1)}
# In units of flying at 2 g for nothing. A missed critical damage then costs that price less one (2 g is right there): 2
# weighs both mistakes alike, the unweighted tree.
PRICES = (2.0, 4.0, 11.0)
UNWEIGHTED = 2.0


@dataclass(frozen=True, slots=True)
class Row:
    """One tree, and what it does on the rows that it was trained on and on others."""

    classes: str
    task: str
    seed: int
    price: float
    solution: Solution
    train: ErrorRates
    test: ErrorRates
    cpu_seconds: float


def losses_of(data: Dataset, task: str) -> NDArray[np.float64]:
    """Return the losses (n_samples, n_regions) that a task looks at, as fractions."""
    return np.stack([data.mu1, data.mu2], axis=1)[:, REGIONS[task]] / 100.0


def decision_rows(data: Dataset, seed: int, depth: int, prices: Sequence[float] = PRICES) -> Iterator[Row]:
    """Yield trees of two classes, the decisions, for every task and price."""
    is_train = data.is_train
    for task in REGIONS:
        losses, start = losses_of(data, task), time.process_time()
        points = trace_risk_frontier(
            RiskModel(), data.features[is_train], losses[is_train], prices, depth=depth, method="exact"
        )
        seconds = (time.process_time() - start) / len(points)
        for point in points:
            certify(point.problem, point.solution)
            assert point.solution.tree is not None
            test = point.model.rates(losses[~is_train], predict(point.solution.tree, data.features[~is_train]))
            price = point.model.failure_loss
            yield Row("decisions", task, seed, price, point.solution, point.rates, test, seconds)


def state_rows(data: Dataset, seed: int, depth: int, prices: Sequence[float] = PRICES) -> Iterator[Row]:
    """Yield trees of five classes, the states of one region, with what each state leads to in their costs."""
    is_train = data.is_train
    for task in ("mu1", "mu2"):
        labels, losses = getattr(data, task), losses_of(data, task)
        states = {int(label): float(label) / 100.0 for label in np.unique(labels)}
        for price in prices:
            model, start = RiskModel(failure_loss=price), time.process_time()
            problem = model.state_problem(data.features[is_train], labels[is_train], states, depth=depth)
            if price == UNWEIGHTED:  # wrong states alone are counted, as in the paper
                problem = replace(problem, loss=ClassCosts(1.0 - np.eye(len(states))))
            solution = solve(problem, "exact", Limits(seconds=300.0))
            certify(problem, solution)
            seconds = time.process_time() - start
            assert solution.tree is not None
            decision = model.decisions(model.losses_of_classes(states))
            told = decision[predict(solution.tree, data.features)]
            rates = [model.rates(losses[rows], told[rows]) for rows in (is_train, ~is_train)]
            yield Row("states", task, seed, price, solution, rates[0], rates[1], seconds)
