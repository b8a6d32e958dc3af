"""Trees that decide between 3 g and 2 g: missed critical damage against false alarms, by the price of a failure."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import markdown
from benchmarks.uav.study import strains_of
from femlib.dataset import Dataset, Recipe, build_dataset
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


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return the table of the trees of each seed; trees of depth 3, of depth 2 and few readings for smoke."""
    del folder
    recipe, depth = (Recipe(samples_per_state=10), 2) if is_smoke else (Recipe(), 3)
    rows: list[Row] = []
    for seed in range(1 if is_smoke else seeds):
        data = build_dataset(strains_of(source), recipe, seed=seed)
        rows += [*decision_rows(data, seed, depth), *state_rows(data, seed, depth)]
    return f"## Risk, {source}\n\n{decision_table(rows)}"


def losses_of(data: Dataset, task: str) -> NDArray[np.float64]:
    """Return the losses (n_samples, n_regions) that a task looks at, as fractions."""
    return np.stack([data.mu1, data.mu2], axis=1)[:, REGIONS[task]] / 100.0


def decision_rows(data: Dataset, seed: int, depth: int) -> Iterator[Row]:
    """Yield trees of two classes, the decisions, for every task and price."""
    is_train = data.is_train
    for task in REGIONS:
        losses, start = losses_of(data, task), time.process_time()
        points = trace_risk_frontier(
            RiskModel(), data.features[is_train], losses[is_train], PRICES, depth=depth, method="exact"
        )
        seconds = (time.process_time() - start) / len(points)
        for point in points:
            certify(point.problem, point.solution)
            assert point.solution.tree is not None
            test = point.model.rates(losses[~is_train], predict(point.solution.tree, data.features[~is_train]))
            price = point.model.failure_loss
            yield Row("decisions", task, seed, price, point.solution, point.rates, test, seconds)


def state_rows(data: Dataset, seed: int, depth: int) -> Iterator[Row]:
    """Yield trees of five classes, the states of one region, with what each state leads to in their costs."""
    is_train = data.is_train
    for task in ("mu1", "mu2"):
        labels, losses = getattr(data, task), losses_of(data, task)
        states = {int(label): float(label) / 100.0 for label in np.unique(labels)}
        for price in PRICES:
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


def decision_table(rows: Sequence[Row]) -> str:
    """Return a line for each kind of tree, task and price, means over the seeds."""
    head = (
        "classes",
        "damage",
        "price of a failure",
        "proven optimal",
        "missed critical, train / test",
        "false alarms, train / test",
        "regret in test",
        "CPU s per tree",
    )
    cells = []
    keys = list(dict.fromkeys((row.classes, row.task, row.price) for row in rows))
    for classes, task, price in keys:
        here = [row for row in rows if (row.classes, row.task, row.price) == (classes, task, price)]
        named = "unweighted" if price == UNWEIGHTED else f"{price:g}"
        proven = sum(row.solution.is_optimal for row in here)
        rates = [_both(here, lambda rates: rates.missed_critical), _both(here, lambda rates: rates.false_alarm)]
        regret, seconds = np.mean([(row.test.regret, row.cpu_seconds) for row in here], axis=0)
        of = f"{proven} of {len(here)}"
        cells.append([classes, task, named, of, *rates, f"{regret:.2f}", f"{seconds:.2g}"])
    return markdown(head, cells) + "\n"


def _both(rows: Sequence[Row], part: Callable[..., float]) -> str:
    train, test = (np.mean([part(getattr(row, rates)) for row in rows]) for rates in ("train", "test"))
    return f"{100 * train:.1f} / {100 * test:.1f} %"
