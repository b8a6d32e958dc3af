"""The fewest splits and the fewest sensors among the trees of least cost: small problems, some without all readings."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from benchmarks.kinds.classes import Classes
from benchmarks.kinds.kind import Generator, Question
from octmip.trees.answer.solution import Solution
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.nodes.tree import Leaf, n_splits
from octmip.trees.question.problem import Problem
from tests.oracles.enumeration import Optimum, optimum
from tests.oracles.strategies import random_problem, with_missing


@dataclass(frozen=True, slots=True)
class Ties(Classes):
    """Trees of least cost of the exact core, ties broken."""

    def truth(self, problem: Problem) -> Optimum:  # type: ignore[override]
        """Return the least cost, and the fewest splits and sensors at it."""
        return optimum(problem)

    def ask(self, question: Question, problem: Problem, log: Path | None) -> Solution:
        """Return the answer to a question, whose limits are left out: a stopped search breaks no tie."""
        options, is_whole = ExactOptions(proof=log), problem.has_integer_costs
        return branch_and_bound(problem, seed=question.seed, options=options, break_ties=is_whole)

    def complaint(self, problem: Problem, answer: Solution, truth: Optimum, log: Path) -> str:  # type: ignore[override]
        """Return what is wrong with a solution and its log; '' when nothing is."""
        if wrong := Classes.complaint(self, problem, answer, Fraction(truth.objective), log):
            return wrong
        if not answer.is_optimal:
            return f"unproven: stopped as {answer.stop}"
        tree, ties = answer.tree or Leaf(0), answer.details["ties_broken"]
        assert isinstance(ties, Mapping)
        if problem.has_integer_costs and n_splits(tree) != truth.n_splits:
            return f"optimal: {n_splits(tree)} splits, enumeration finds {truth.n_splits}"
        n_sensors = len(problem.shape.sensors_used(tree))
        if ties["sensors"] == "fewest, proven" and n_sensors != truth.n_sensors:
            return f"optimal: {n_sensors} sensors, enumeration finds {truth.n_sensors}"
        return ""


def _small(rng: Generator) -> Problem:
    problem = random_problem(rng)
    return with_missing(rng, problem) if rng.random() < 0.4 else problem


TIES_KIND = Ties(20, _small, {"exact": 1.0})
