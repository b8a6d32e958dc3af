"""Bounded reading errors, and sets of near-optimal trees."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmarks.kinds.classes import claims_complaint
from benchmarks.kinds.kind import ROUNDING, Generator, Question
from benchmarks.oracles.rational import least_cost
from benchmarks.oracles.strategies import random_problem, with_missing
from benchmarks.oracles.worst_case import least_worst_case
from octmip.errors import CertificateError
from octmip.trees.losses import ClassCosts
from octmip.trees.near_sets import NearOptimalSet, near_optimal
from octmip.trees.problem import Problem
from octmip.trees.set_certificate import Recount, certify_set, recount
from octmip.trees.solution import Solution
from octmip.trees.worst_case import Bands, certify_worst_case
from octmip.trees.worst_case import solve as solve_worst_case

MARGINS = (0.0, 0.3, 0.5, 1.0, 2.0, 4.0)
"""How far above the optimum trees are counted."""


@dataclass(frozen=True, slots=True)
class Banded:
    """A problem whose readings may be off within bands, of so many sensors at a time."""

    problem: Problem
    bands: Mapping[str, tuple[float, float]]
    off: int


class WorstCases:
    """Trees of least worst case under bounded reading errors."""

    stream, share, is_proven = 23, 0.3, True
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
        limits, n_jobs = question.limits, 1 + question.seed % 2
        found = solve_worst_case(problem.problem, problem.bands, problem.off, limits, seed=question.seed, n_jobs=n_jobs)
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

    stream, share, is_proven = 29, 0.3, True
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
            certify_set(problem.problem, answer, answer.best(5) + (answer.sample(3) if answer.is_complete else []))
        except CertificateError as error:
            return f"answer: {error}"
        if answer.optimum not in (None, truth.least):
            return f"optimal: the optimum {answer.optimum}, enumeration finds {truth.least}"
        if answer.trees_at_least > truth.trees or answer.trees not in (None, truth.trees):
            return f"answer: {answer.trees_at_least} trees or more, enumeration counts {truth.trees}"
        whole: Mapping[Any, int] = dict(answer.spectrum)
        if answer.is_complete and whole != dict(truth.spectrum):
            return f"answer: spectrum {whole}, enumeration finds {dict(truth.spectrum)}"
        if answer.is_complete and answer.by_sensors is not None and dict(answer.by_sensors) != dict(truth.by_sensors):
            return f"answer: by sensors {answer.by_sensors}, enumeration finds {truth.by_sensors}"
        return ""
