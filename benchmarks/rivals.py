"""The solvers that answer benchmark cases, ours and others', behind one face; imported only when they run.

Each takes a problem and returns a function that solves it within so many seconds on so many threads, and answers. Only
that function is measured: ranking, binarising and copying for a rival are not.
"""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.question.problem import Problem

# STreeD and DL8.5 know binary features only. They take part where one for each threshold is not more than this, so that
# they solve the same question; a few quantiles instead is another question (it loses to plain CART, see the docs).
MOST_BINARY_FEATURES = 300
MOST_LEVELS_OF_STREED = 20


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a solver: `bound` is -inf where it claims no proof."""

    objective: float
    bound: float
    settings: str
    n_nodes: int = 0


Fit = Callable[[float, int], Answer]


@dataclass(frozen=True, slots=True)
class Rival:
    """A solver: how to prepare it, which package it is of, and whether it uses more than one thread."""

    prepare: Callable[[Problem], Fit]
    package: str
    is_threaded: bool = False

    @property
    def version(self) -> str:
        """The installed version."""
        return f"{self.package} {version(self.package)}"


def _octmip(settings: str, load: Callable[[], Callable[..., Solution]], **more: Any) -> Callable[[Problem], Fit]:
    """Return how a solver of ours is prepared: it is loaded, and called with further arguments."""

    def prepare(problem: Problem) -> Fit:
        solver = load()

        def fit(seconds: float, threads: int) -> Answer:
            solution = solver(problem, limits=Limits(seconds=seconds), n_jobs=threads, **more)
            return Answer(solution.objective, solution.bound, settings, solution.n_nodes)

        return fit

    return prepare


def _loaded(module: str, name: str) -> Callable[..., Solution]:
    solver: Callable[..., Solution] = getattr(importlib.import_module(f"octmip.trees.{module}"), name)
    return solver


def _errors(problem: Problem, predicted: Any) -> float:
    """Return the misclassified samples of predicted codes (n_samples,), of whatever type a rival has."""
    return float((np.asarray(predicted).astype(np.int64) != problem.samples.codes).sum())


def _pycontree(problem: Problem) -> Fit:
    from pycontree import ConTree

    # It keeps float32, so it gets dense ranks, which float32 holds exactly below 2^24.
    ranks = np.column_stack([np.unique(column, return_inverse=True)[1] for column in problem.samples.features.T])
    features, labels = ranks.astype(np.float64), problem.samples.codes.astype(np.int32)

    def fit(seconds: float, threads: int) -> Answer:
        model = ConTree(max_depth=problem.shape.depth, time_limit=seconds)
        model.fit(features, labels)
        errors = _errors(problem, model.predict(features))
        return Answer(errors, errors, "max_gap=0, dense ranks")

    return fit


def _pytrees(problem: Problem) -> Fit:
    from pytrees import ConTreeClassifier

    def fit(seconds: float, threads: int) -> Answer:
        model = ConTreeClassifier(max_depth=problem.shape.depth, max_time=seconds, use_lds=True)
        model.fit(problem.samples.features, problem.samples.codes)
        errors = _errors(problem, model.predict(problem.samples.features))
        return Answer(errors, errors if model.status_ == "optimal" else -np.inf, "use_lds=True")

    return fit


def _cart(problem: Problem) -> Fit:
    from sklearn.tree import DecisionTreeClassifier

    def fit(seconds: float, threads: int) -> Answer:
        model = DecisionTreeClassifier(max_depth=problem.shape.depth, random_state=0)
        model.fit(problem.samples.features, problem.samples.codes)
        return Answer(_errors(problem, model.predict(problem.samples.features)), -np.inf, "max_depth")

    return fit


def _binary(problem: Problem) -> NDArray[np.int32]:
    columns = [column <= value for column in problem.samples.features.T for value in np.unique(column)[:-1]]
    return np.column_stack(columns).astype(np.int32)


def _pystreed(problem: Problem) -> Fit:
    from pystreed import STreeDClassifier

    features = _binary(problem)
    depth = min(int(problem.shape.depth), MOST_LEVELS_OF_STREED)
    price = problem.shape.leaf_penalty / problem.samples.n_samples
    task = "cost-complex-accuracy" if price else "accuracy"

    def fit(seconds: float, threads: int) -> Answer:
        model = STreeDClassifier(task, max_depth=depth, cost_complexity=price, time_limit=seconds)
        model.fit(features, problem.samples.codes)
        errors = _errors(problem, model.predict(features))
        cost = errors + problem.shape.leaf_penalty * (model.get_n_leaves() - 1)
        bound = cost if model.fit_result.is_optimal() else -np.inf
        return Answer(cost, bound, f"{features.shape[1]} binary features, every threshold; {depth} levels")

    return fit


def _treefarms(problem: Problem) -> Fit:
    import contextlib
    import io

    import pandas as pd
    from treefarms import TREEFARMS

    features = _binary(problem).astype(int)
    columns = pd.DataFrame(features, columns=[f"b{j}" for j in range(features.shape[1])])
    labels = pd.Series(problem.samples.codes, name="class")
    n, price = problem.samples.n_samples, problem.shape.leaf_penalty / problem.samples.n_samples
    # With its default look_ahead the set reaches beyond its own bound, and its first tree need not be optimal.
    settings = {"regularization": price, "rashomon_bound_multiplier": 1e-6, "worker_limit": 1, "look_ahead": False}

    def fit(seconds: float, threads: int) -> Answer:
        model = TREEFARMS(settings | {"time_limit": int(np.ceil(seconds))})
        said = f"{features.shape[1]} binary features, every threshold; the set of the optimal trees; look_ahead off"
        with contextlib.redirect_stdout(io.StringIO()):
            model.fit(columns, labels)
        if not model.get_tree_count():  # stopped: its status does not say so
            return Answer(np.inf, -np.inf, said)
        trees = (model[k] for k in range(model.get_tree_count()))
        cost = round(min(n * (1 - tree.score(columns, labels) + price * (tree.leaves() - 1)) for tree in trees), 6)
        return Answer(cost, cost if model.time < seconds else -np.inf, said)

    return fit


def _pydl85(problem: Problem) -> Fit:
    from pydl85 import DL85Classifier

    features = _binary(problem)

    def fit(seconds: float, threads: int) -> Answer:
        model = DL85Classifier(max_depth=problem.shape.depth, time_limit=int(np.ceil(seconds)))
        model.fit(features, problem.samples.codes)
        return Answer(float(model.error_), float(model.error_), f"{features.shape[1]} binary features, every threshold")

    return fit


def _fast_small_tree(problem: Problem) -> Fit:
    import warnings

    from imodels import FastSmallTreeClassifier

    FastSmallTreeClassifier(0.1).fit(np.array([[0.0], [1.0], [2.0]]), np.array([0, 1, 1]))  # compiled before the clock
    n, price = problem.samples.n_samples, problem.shape.leaf_penalty / problem.samples.n_samples

    def fit(seconds: float, threads: int) -> Answer:
        model = FastSmallTreeClassifier(price, time_limit=seconds)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it was stopped shows in its bound
            model.fit(problem.samples.features, problem.samples.codes)
        # It charges leaves, of which there is one more than splits.
        cost, bound = (round(n * (share - price), 9) for share in (model.upperbound_, model.lowerbound_))
        return Answer(cost, cost if model.optimal_ else bound, f"regularization={price:g}")

    return fit


def can_be_binary(features: NDArray[np.float64]) -> bool:
    """Return whether one binary feature for each threshold is few enough for the binary solvers."""
    return sum(len(np.unique(column)) - 1 for column in features.T) <= MOST_BINARY_FEATURES


RIVALS = {
    "octmip": Rival(
        _octmip("solve(method='exact')", partial(_loaded, "solver", "solve"), method="exact"),
        "octmip",
        is_threaded=True,
    ),
    "octmip-auto": Rival(
        _octmip("solve", partial(_loaded, "solver", "solve")),
        "octmip",
        is_threaded=True,
    ),
    "octmip-search": Rival(
        _octmip("solve(method='search')", partial(_loaded, "solver", "solve"), method="search"),
        "octmip",
        is_threaded=True,
    ),
    "octmip-core": Rival(
        _octmip("branch_and_bound, no incumbent", partial(_loaded, "methods.exact", "branch_and_bound")),
        "octmip",
        is_threaded=True,
    ),
    "pycontree": Rival(_pycontree, "pycontree"),
    "pytrees-rs": Rival(_pytrees, "pytrees-rs"),
    "CART": Rival(_cart, "scikit-learn"),
    "pystreed": Rival(_pystreed, "pystreed"),
    "pydl8.5": Rival(_pydl85, "pydl8.5"),
    "treefarms": Rival(_treefarms, "treefarms"),
    "fastsmalltree": Rival(_fast_small_tree, "imodels"),
}
