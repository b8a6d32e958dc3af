"""Numbers, bounded reading errors, and sets of near-optimal trees."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmarks.kinds.classes import claims_complaint, log_complaint
from benchmarks.kinds.kind import ROUNDING, Generator, Question
from benchmarks.oracles.rational import least_cost
from benchmarks.oracles.regression_runs import Runs
from benchmarks.oracles.regression_trees import least_objective
from benchmarks.oracles.strategies import random_problem, with_missing
from benchmarks.oracles.wide_problems import wide_numbers
from benchmarks.oracles.worst_case import least_worst_case
from octmip.errors import CertificateError
from octmip.trees.certificate import certify
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.options import ExactOptions
from octmip.trees.near_sets import NearOptimalSet, near_optimal
from octmip.trees.problem import Problem
from octmip.trees.set_certificate import Recount, certify_set, recount
from octmip.trees.solution import Solution
from octmip.trees.solver import solve
from octmip.trees.worst_case import Bands, certify_worst_case
from octmip.trees.worst_case import solve as solve_worst_case

MARGINS = (0.0, 0.3, 0.5, 1.0, 2.0, 4.0)
"""How far above the optimum trees are counted."""


class Numbers:
    """Regression trees, by squared or absolute error."""

    stream, share = 19, 0.5
    methods: Mapping[str, float] = MappingProxyType({"exact": 1.0, "search": 0.3})

    def draw(self, rng: Generator) -> Problem:
        """Return a random problem."""
        return wide_numbers(rng)

    def truth(self, problem: Problem) -> Fraction:
        """Return the least objective of any tree."""
        return Runs(problem).least() if problem.n_features == 1 else least_objective(problem)

    def has_log(self, problem: Problem, method: str) -> bool:
        """Return whether a method writes proof logs."""
        return method == "exact"

    def ask(self, question: Question, problem: Problem, log: Path | None) -> Solution:
        """Return the answer to a question."""
        options = ExactOptions(proof=log)
        limits, method = question.limits, question.method
        return solve(problem, method, limits=limits, seed=question.seed, options=options)  # type: ignore[arg-type]

    def complaint(self, problem: Problem, answer: Solution, truth: Fraction, log: Path) -> str:
        """Return what is wrong with a solution and its log; '' when nothing is."""
        try:
            certify(problem, answer)
        except CertificateError as error:
            return f"answer: {error}"
        assert answer.tree is not None
        cost = problem.exact_objective(answer.tree)
        # Means are rounded once: each is half of a last place from the best number of its leaf at most.
        last_place = Fraction(float(np.spacing(np.abs(problem.targets).max())))
        total = sum(map(Fraction, problem.weights.tolist()), Fraction(0))
        rounded = total * last_place**2 if problem.loss.name == "squared" else Fraction(0)
        wrong = claims_complaint(answer, cost, truth, ROUNDING * truth + rounded)
        return wrong or log_complaint(problem, log, answer, truth)


@dataclass(frozen=True, slots=True)
class Banded:
    """A problem whose readings may be off within bands, of so many sensors at a time."""

    problem: Problem
    bands: Mapping[str, tuple[float, float]]
    off: int


class WorstCases:
    """Trees of least worst case under bounded reading errors."""

    stream, share = 23, 0.3
    methods: Mapping[str, float] = MappingProxyType({"least_worst": 1.0})

    def draw(self, rng: Generator) -> Banded:
        """Return a random problem: as many cuts or classes as the proof's parts and tables part at, at times."""
        if rng.random() < 0.7:
            problem = random_problem(rng, max_samples=int(rng.integers(4, 13)), max_depth=2)
            scale = float(rng.choice([0.5, 1.0, 1e-6, 0.3]))
        else:
            problem, scale = _many_cuts(rng) if rng.random() < 0.6 else _many_classes(rng), 1.0
        return Banded(problem, random_bands(rng, problem, scale), int(rng.integers(1, 4)))

    def truth(self, problem: Banded) -> Fraction:
        """Return the least worst case."""
        bands = Bands.of(problem.problem, problem.bands)
        return Fraction(least_worst_case(problem.problem, bands, problem.off))

    def has_log(self, problem: Banded, method: str) -> bool:
        """Return False: there are no logs of worst cases."""
        return False

    def ask(self, question: Question, problem: Banded, log: Path | None) -> Solution:
        """Return the answer to a question."""
        found = solve_worst_case(problem.problem, problem.bands, problem.off, question.limits, seed=question.seed)
        return found.solution

    def complaint(self, problem: Banded, answer: Solution, truth: Fraction, log: Path) -> str:
        """Return what is wrong with a solution; '' when nothing is. The enumeration sums float64."""
        try:
            found = certify_worst_case(problem.problem, answer, problem.bands, problem.off)
        except CertificateError as error:
            return f"answer: {error}"
        slack = Fraction(answer.tolerance) + ROUNDING * truth
        return claims_complaint(answer, Fraction(found.worst), truth * (1 + ROUNDING), slack)


def random_bands(rng: Generator, problem: Problem, scale: float) -> dict[str, tuple[float, float]]:
    """Return bands of most features, some of them of no width, in steps that often meet the values or half of them."""
    sides = {name: rng.integers(0, 4, 2) * scale for name in problem.feature_names if rng.random() < 0.8}
    return {name: (float(below), float(above)) for name, (below, above) in sides.items()}


def _many_cuts(rng: Generator) -> Problem:
    n = int(rng.integers(26, 81))
    labels = rng.integers(0, 2, n)
    labels[:2] = [0, 1]
    return Problem(rng.permutation(n)[:, None].astype(float), labels, depth=int(rng.integers(1, 3)))


def _many_classes(rng: Generator) -> Problem:
    n, k = int(rng.integers(12, 21)), int(rng.integers(5, 10))
    costs = rng.integers(0, 9, (k, k)).astype(float)
    labels = np.concatenate([[0, 1], rng.integers(0, k, n - 2)])
    features = rng.integers(0, 8, (n, 1)).astype(float)
    return Problem(features, labels, depth=int(rng.integers(1, 3)), loss=ClassCosts(costs), class_names=tuple(range(k)))


@dataclass(frozen=True, slots=True)
class Near:
    """A problem, and how far above the optimum its trees are counted."""

    problem: Problem
    within: float
    by_sets: bool


class NearSets:
    """Counts of all trees near the optimum."""

    stream, share = 29, 0.3
    methods: Mapping[str, float] = MappingProxyType({"near_optimal": 1.0})

    def draw(self, rng: Generator) -> Near:
        """Return a random problem, of more cuts at times."""
        if rng.random() < 0.8:
            problem = random_problem(rng, max_samples=int(rng.integers(4, 9)))
            problem = with_missing(rng, problem) if rng.random() < 0.4 else problem
            return Near(problem, float(rng.choice(MARGINS)), bool(rng.random() < 0.5))
        problem = _many_cuts(rng)
        return Near(problem, float(rng.choice([0.0, 1.0])) * (problem.depth == 1), bool(rng.random() < 0.5))

    def truth(self, problem: Near) -> Recount:
        """Return the set."""
        return recount(problem.problem, least_cost(problem.problem) + Fraction(problem.within))

    def has_log(self, problem: Near, method: str) -> bool:
        """Return False: a count has no log."""
        return False

    def ask(self, question: Question, problem: Near, log: Path | None) -> NearOptimalSet:
        """Return the answer to a question."""
        return near_optimal(
            problem.problem, problem.within, limits=question.limits, by_sets=problem.by_sets, seed=question.seed
        )

    def complaint(self, problem: Near, answer: NearOptimalSet, truth: Recount, log: Path) -> str:
        """Return what is wrong with a set; '' when nothing is."""
        try:
            certify_set(problem.problem, answer, answer.best(3))
        except CertificateError as error:
            return f"answer: {error}"
        if answer.optimum not in (None, truth.least):
            return f"optimal: the optimum {answer.optimum}, enumeration finds {truth.least}"
        if answer.trees_at_least > truth.trees or answer.trees not in (None, truth.trees):
            return f"answer: {answer.trees_at_least} trees or more, enumeration counts {truth.trees}"
        whole: Mapping[Any, int] = dict(answer.spectrum)
        if answer.is_complete and whole != dict(truth.spectrum):
            return f"answer: spectrum {whole}, enumeration finds {dict(truth.spectrum)}"
        return ""
