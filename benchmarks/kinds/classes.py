"""Classification: small problems over the whole range of float64, of all sizes, with missing readings or few splits."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kinds.kind import ROUNDING, Generator, Question
from octmip.errors import CertificateError
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Solution, Stop
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.options import NO_OPTIONS, ExactOptions
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve
from tests.oracles.planes import least_cost_of_planes, random_planes
from tests.oracles.rational import cost_of, least_cost
from tests.oracles.strategies import random_problem, with_missing
from tests.oracles.two_feature_problems import random_two_feature_problem
from tests.oracles.wide_problems import sized_lines, sized_problem, wide_problem

MIXED_INTEGER = ("oct", "flow", "oct_h", "benders")
MOST_SAMPLES = {1: 14, 2: 10, 3: 8}
"""Of splits over two features, by depth."""
MOST_SPLITS = 3


@dataclass(frozen=True, slots=True)
class Classes:
    """Trees of least cost that predict classes."""

    stream: int
    drawn: Callable[[Generator], Problem]
    methods: Mapping[str, float]
    share: float = 1.0
    proofs: tuple[str, ...] = field(default=("exact",))
    is_proven: bool = False

    def draw(self, rng: Generator) -> Problem:
        """Return a random problem."""
        return self.drawn(rng)

    def truth(self, problem: Problem) -> Fraction:
        """Return the least cost of any tree."""
        return least_cost(problem)

    def has_log(self, problem: Problem, method: str) -> bool:
        """Return whether a method writes proof logs of a problem."""
        shape = problem.shape
        return method in self.proofs and shape.integer_normals is None and (shape.split == "axis" or shape.depth <= 2)

    def ask(self, question: Question, problem: Problem, log: Path | None) -> Solution:
        """Return the answer to a question."""
        options = NO_OPTIONS if log is None else ExactOptions(proof=log)
        limits, method = question.limits, question.method
        return solve(problem, method, limits=limits, seed=question.seed, options=options)  # type: ignore[arg-type]

    def complaint(self, problem: Problem, answer: Solution, truth: Fraction, log: Path) -> str:
        """Return what is wrong with a solution and its log; '' when nothing is."""
        if (wrong := complaint(problem, answer, truth)) != "":
            return wrong
        return log_complaint(problem, log, answer, truth)


def complaint(problem: Problem, solution: Solution, least: Fraction) -> str:
    """Return what is wrong with a solution in exact arithmetic, '' when nothing is."""
    try:
        certify(problem, solution)
    except CertificateError as error:
        return f"answer: {error}"
    cost = cost_of(problem, solution.tree)
    if abs(Fraction(solution.objective) - cost) > ROUNDING * cost:
        return f"answer: objective {solution.objective} but {float(cost)} in fractions"
    is_restricted = not str(solution.details.get("scope", "all")).startswith("all")
    slack = Fraction(solution.tolerance) + ROUNDING * least
    return "" if is_restricted else claims_complaint(solution, cost, least, slack)


def claims_complaint(solution: Solution, cost: Fraction, least: Fraction, slack: Fraction) -> str:
    """Return what is wrong with "optimal" and the bound of a tree of this cost, '' when nothing is."""
    says_optimal = solution.is_optimal or solution.stop is Stop.OPTIMAL
    if says_optimal and cost - least > slack:
        return f"optimal: says so at {float(cost)}, tolerance {solution.tolerance}; the least cost is {float(least)}"
    if math.isfinite(solution.bound) and Fraction(solution.bound) > least * (1 + ROUNDING):
        return f"bound: {solution.bound} above the least cost {float(least)} (objective {float(cost)})"
    return ""


def log_complaint(problem: Any, log: Path, solution: Solution, least: Fraction) -> str:
    """Return what is wrong with a proof log, '' when nothing is or there is none."""
    if not log.exists():
        return ""
    try:
        report = check_proof(problem, log, bound=solution.bound)
    except CertificateError as error:
        return f"proof: {error}"
    return f"proof: accepted for {report.bound}" if Fraction(report.bound) > least * (1 + ROUNDING) else ""


def _hyperplanes(rng: Generator) -> Problem:
    return wide_problem(rng, split="hyperplane")


def _missing(rng: Generator) -> Problem:
    return with_missing(rng, wide_problem(rng))


def _sized(rng: Generator) -> Problem:
    problem = sized_problem(rng)
    return with_missing(rng, problem) if rng.random() < 0.2 else problem


def _two_features(rng: Generator) -> Problem:
    depth = int(rng.integers(1, 4))
    problem = random_two_feature_problem(rng, depth=depth, max_samples=MOST_SAMPLES[depth])
    return problem.replace(sensor_budget=None) if depth == 3 else problem


def _few_splits(rng: Generator) -> Problem:
    return wide_problem(rng).replace(max_splits=int(rng.integers(0, MOST_SPLITS + 1)))


def _few_leaves(rng: Generator) -> Problem:
    problem = wide_problem(rng)
    depth = int(rng.integers(1, 5))
    return problem.replace(depth=depth, sensor_budget=None, max_splits=int(rng.integers(0, min(2**depth, 6))))


def _large_leaves(rng: Generator) -> Problem:
    """Return a problem of leaves of two samples or more, with some other options at once."""
    problem = random_problem(rng, max_samples=14)
    problem = with_missing(rng, problem) if rng.random() < 0.2 else problem
    return problem.replace(leaf_size=int(rng.integers(2, max(2, problem.samples.n_samples // 3) + 1)))


def _grid(rng: Generator) -> Problem:
    """Return more samples on a coarse grid: trees of many levels, and nodes that are met by several ways."""
    n, n_features, n_classes = int(rng.integers(8, 17)), int(rng.integers(1, 4)), int(rng.integers(2, 5))
    features = rng.integers(0, 6 if n_features < 3 else 4, (n, n_features)).astype(float)
    targets = rng.integers(0, n_classes, n)
    targets[:n_classes] = np.arange(n_classes)
    costs = rng.integers(0, 6, (n_classes, n_classes)) if rng.random() < 0.3 else 1.0 - np.eye(n_classes)
    weights = rng.integers(1, 4, n).astype(float) if rng.random() < 0.4 else np.ones(n)
    size = 1 if rng.random() < 0.7 else 2
    return Problem(features, targets, depth=1, loss=ClassCosts(costs), weights=weights, leaf_size=size)


def _sparse(rng: Generator) -> Problem:
    problem = wide_problem(rng) if rng.random() < 0.5 else _grid(rng)
    share = float(rng.choice((0.02, 0.05, 0.1, 0.2, 0.5)))
    price = share * problem.baseline if rng.random() < 0.7 else float(math.ceil(share * problem.baseline))
    most = int(rng.integers(0, 6)) if rng.random() < 0.2 else None
    budget = problem.shape.sensor_budget if most is None else None
    any_depth: dict[str, Any] = {"depth": None, "max_splits": most, "sensor_budget": budget}
    return problem.replace(leaf_penalty=price or 1.0, **any_depth)


class AnyDepthClasses(Classes):
    """The same for trees of any depth: those of as many levels as samples are all that there are."""

    def truth(self, problem: Problem) -> Fraction:
        """Return the least cost of any tree."""
        return least_cost(problem.replace(depth=max(1, problem.samples.n_samples - 1)))


@dataclass(frozen=True, slots=True)
class Planes(Classes):
    """Trees of hyperplanes over all of up to four features."""

    def truth(self, problem: Problem) -> Fraction:
        """Return the least cost of any tree, separated by a margin or not."""
        return least_cost_of_planes(problem)


AXIS = {"exact": 1.0, "search": 0.6, "cart": 0.3, "oct": 0.12, "flow": 0.12, "benders": 0.3}
HYPERPLANE = {"exact": 1.0, "search": 0.6, "oct_h": 0.15}
"""Share of the problems that each solver is asked: those on HiGHS take a hundred times as long as the others."""

AXIS_KIND = Classes(5, wide_problem, AXIS)
HYPERPLANE_KIND = Classes(3, _hyperplanes, HYPERPLANE)
MISSING = {"exact": 1.0, "search": 0.5, "cart": 0.3, "oct": 0.05, "flow": 0.05, "benders": 0.05}
MISSING_KIND = Classes(7, _missing, MISSING, 0.5)
SIZED_KIND = Classes(11, _sized, {"exact": 1.0, "search": 0.3, "cart": 0.3}, 0.3)
LINES_KIND = Classes(13, sized_lines, {"exact": 1.0}, 0.1)
TWO_FEATURES = {"exact": 1.0, "search": 0.3, "flow": 0.05, "oct_h": 0.05}
TWO_FEATURE_KIND = Classes(60, _two_features, TWO_FEATURES, 0.4, is_proven=True)
PLANES_KIND = Planes(67, random_planes, {"search": 1.0, "oct_h": 0.2, "flow": 0.2}, 0.1, ())
FEW_SPLITS_KIND = Classes(17, _few_splits, {"oct": 0.5, "flow": 0.5}, 0.1, ())
LARGE_LEAVES_KIND = Classes(61, _large_leaves, {"exact": 1.0, "search": 0.2, "cart": 0.1}, 0.5)
SPARSE_KIND = AnyDepthClasses(23, _sparse, {"exact": 1.0, "search": 0.2, "cart": 0.1}, 0.3, ())
FEW_LEAVES_KIND = Classes(19, _few_leaves, {"exact": 1.0, "search": 0.2, "cart": 0.1}, 0.3, ())
