"""Sets of near-optimal trees."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

from benchmarks.kinds.kind import Generator, Question
from octmip.errors import CertificateError
from octmip.trees.answer.set_certificate import Recount, certify_set, recount
from octmip.trees.near_sets import NearOptimalSet, near_optimal
from octmip.trees.question.problem import Problem
from tests.oracles.rational import least_cost
from tests.oracles.strategies import random_problem, with_missing

MARGINS = (0.0, 0.3, 0.5, 1.0, 2.0, 4.0)
"""How far above the optimum trees are counted."""


def _many_cuts(rng: Generator) -> Problem:
    n = int(rng.integers(26, 81))
    labels = rng.integers(0, 2, n)
    labels[:2] = [0, 1]
    return Problem(rng.permutation(n)[:, None].astype(float), labels, depth=int(rng.integers(1, 3)))


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
        return Near(problem, float(rng.choice([0.0, 1.0])) * (problem.shape.depth == 1), bool(rng.random() < 0.5))

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
