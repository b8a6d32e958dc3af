"""Limits of time: each stage stops once the clock is over, and what is there by then is a tree.

The clock of Python is set by hand here: a stage that takes a second moves it by one.
"""

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from octmip import Problem, certify
from octmip.interfaces.report.new_rows import choice_text
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.methods import cart, exact, search
from octmip.trees.question.losses import AbsoluteError, ClassCosts
from octmip.trees.runs import drawn_rows
from octmip.trees.runs.registry import Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff.default import solve_default


class Clock:
    """Seconds that move by hand, in place of `time.perf_counter`."""

    def __init__(self) -> None:
        self.now = 0.0
        self.calls: list[str] = []

    def __call__(self) -> float:
        return self.now

    def slowed(self, monkeypatch: pytest.MonkeyPatch, module: Any, function: str, seconds: float) -> None:
        """Let a function take so many seconds of this clock, and count its calls."""
        quick: Callable[..., Any] = getattr(module, function)

        def slow(*given: Any, **named: Any) -> Any:
            self.now += seconds
            self.calls.append(function)
            return quick(*given, **named)

        monkeypatch.setattr(module, function, slow)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(time, "perf_counter", made)
    return made


def table(n_samples: int = 60, **asked: Any) -> Problem:
    """Return a problem of three columns of few values."""
    rng = np.random.default_rng(4)
    features = rng.integers(0, 5, (n_samples, 3)).astype(float)
    targets = (features[:, 0] + features[:, 1] > 4) ^ (rng.random(n_samples) < 0.1)
    return Problem(features, targets.astype(int), **{"depth": 3, **asked})


@pytest.mark.parametrize(("seconds", "n_trees"), [(0.1, 2), (2.0, 2), (6.0, 4), (9.0, 6)])
def test_a_choice_grows_trees_of_folds_while_one_more_ends_in_time(monkeypatch, clock, seconds: float, n_trees: int):
    clock.slowed(monkeypatch, cart, "greedy_tree", 1.0)
    found = solve_default(table(), Run("auto", Limits(seconds=seconds)))
    certify(found.problem, found.solution)
    assert clock.calls == ["greedy_tree"] * n_trees
    assert found.solution.details["choice"]["n_folds"] == n_trees - 1
    assert f"({n_trees - 1} fold{'s' if n_trees > 2 else ''}, " in choice_text(found.problem, found.solution)


LARGE: dict[str, dict[str, Any]] = {
    "classes": {},
    "leaves of a size": {"leaf_size": 40},
    "leaves of a weight": {"leaf_weight": 40.0},
    "an order": {"monotone": {"x0": 1}},
    "few splits": {"max_splits": 2},
    "a budget": {"sensor_budget": 2},
    "any depth": {"depth": None, "leaf_penalty": 2.0},
    "numbers": {"loss": AbsoluteError()},
}


@pytest.mark.parametrize("asked", LARGE.values(), ids=list(LARGE))
def test_a_table_whose_set_up_alone_takes_the_time_gets_a_tree_of_drawn_rows(monkeypatch, clock, asked: dict[str, Any]):
    clock.slowed(monkeypatch, exact, "branch_and_bound", 100.0)
    monkeypatch.setattr(drawn_rows, "LARGE", 1000)
    monkeypatch.setattr(drawn_rows, "SETUP_READINGS", {"class": 1e3, "number": 1e3})
    problem = table(2000, **asked)
    solution = solve_run(problem, Run("auto", Limits(seconds=2.0)))
    certify(problem, solution)
    assert clock.calls == []
    assert solution.details["n_rows"] == 166
    assert (solution.stop, solution.bound) == (Stop.TIME, -math.inf)
    assert solution.objective < problem.baseline


def test_a_search_that_took_the_time_of_the_proof_is_the_answer(monkeypatch, clock):
    clock.slowed(monkeypatch, search, "local_search", 9.0)
    clock.slowed(monkeypatch, exact, "branch_and_bound", 100.0)
    monkeypatch.setattr(drawn_rows, "LARGE", 1000)
    monkeypatch.setattr(drawn_rows, "SETUP_READINGS", {"class": 2e3})
    problem = table(2000, depth=5)
    solution = solve_run(problem, Run("auto", Limits(seconds=11.0)))
    certify(problem, solution)
    assert clock.calls == ["local_search"]
    assert (solution.stop, solution.bound) == (Stop.TIME, -math.inf)


@pytest.mark.parametrize("n_classes", [2, 3, 6, 7])
@pytest.mark.parametrize("is_zero_one", [True, False])
def test_two_classes_differ_by_the_most_that_a_row_of_any_class_tells(n_classes: int, is_zero_one: bool):
    rng = np.random.default_rng(n_classes)
    costs = 1.0 - np.eye(n_classes) if is_zero_one else rng.integers(0, 3, (n_classes, n_classes)).astype(float)
    codes, weights = rng.integers(0, n_classes, 50), rng.random(50)
    mean = np.array([weights[codes == k].mean() for k in range(n_classes)])
    expected = [[max(mean * np.abs(costs[:, a] - costs[:, b])) for b in range(n_classes)] for a in range(n_classes)]
    assert ClassCosts(costs).contrasts(weights, codes) == pytest.approx(np.array(expected), rel=1e-12)
