"""Numbers: small problems, problems of many samples, and problems of targets far off and weights of any size.

Many samples: 8 to 400 of 1 to 4 columns, past the core's 16 bins, 48 and 64 buckets and 256 parts of a feature, with
targets lognormal, Cauchy, tied, whole or in clusters.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.kinds.classes import claims_complaint, log_complaint
from benchmarks.kinds.kind import ROUNDING, Generator, Question
from octmip.errors import CertificateError
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Solution
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.losses import SPELLINGS, AbsoluteError, NumberLoss, QuantileError, SquaredError
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve
from tests.oracles.regression_runs import Runs
from tests.oracles.regression_trees import least_objective, random_problem

LEVELS = (0.1, 0.9, 0.5, 0.25, 0.95, 0.025, 1 / 3, 0.999)
WIDEST = Fraction(1, 10**8)
"""Share of an objective within which it may be called optimal."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """Regression trees, by squared, absolute or quantile error."""

    stream: int
    share: float
    drawn: Callable[[Generator], Problem]
    least: Callable[[Problem], Fraction]
    methods: Mapping[str, float]
    is_proven: bool = False

    def draw(self, rng: Generator) -> Problem:
        """Return a random problem."""
        return self.drawn(rng)

    def truth(self, problem: Problem) -> Fraction:
        """Return the least objective of any tree."""
        return self.least(problem)

    def has_log(self, problem: Problem, method: str) -> bool:
        """Return whether a method writes proof logs."""
        return method == "exact"

    def ask(self, question: Question, problem: Problem, log: Path | None) -> Solution:
        """Return the answer to a question, on one thread or two."""
        options = ExactOptions(proof=log)
        limits, method, n_jobs = question.limits, question.method, 1 + question.seed % 2
        return solve(problem, method, limits, seed=question.seed, n_jobs=n_jobs, options=options)  # type: ignore[arg-type]

    def complaint(self, problem: Problem, answer: Solution, truth: Fraction, log: Path) -> str:
        """Return what is wrong with a solution and its log; '' when nothing is."""
        try:
            certify(problem, answer)
        except CertificateError as error:
            return f"answer: {error}"
        cost = problem.exact_objective(answer.tree)
        if answer.tolerance > WIDEST * cost:
            return f"optimal: {answer.objective} would be within {answer.tolerance}, too wide a tolerance"
        # Means are rounded once: each is half of a last place from the best number of its leaf at most.
        last_place = Fraction(float(np.spacing(np.abs(problem.samples.targets).max())))
        total = sum(map(Fraction, problem.samples.weights.tolist()), Fraction(0))
        rounded = total * last_place**2 if problem.loss.name == "squared" else Fraction(0)
        wrong = claims_complaint(answer, cost, truth, ROUNDING * truth + rounded)
        return wrong or log_complaint(problem, log, answer, truth)


def _by_runs(problem: Problem) -> Fraction:
    return Runs(problem).least()


def _small(rng: Generator) -> Problem:
    return random_problem(rng, str(rng.choice(SPELLINGS)))


def _wide(rng: Generator) -> Problem:
    return wide_problem(rng, _losses(rng))


def _far(rng: Generator) -> Problem:
    return far_problem(rng, _losses(rng))


def _losses(rng: Generator) -> Sequence[NumberLoss]:
    return quantiles(rng) if rng.random() < 0.4 else (SquaredError(), AbsoluteError())


def quantiles(rng: Generator) -> tuple[NumberLoss, ...]:
    """Return a quantile loss of a common level, and one of any level in thousandths."""
    return QuantileError(LEVELS[int(rng.integers(len(LEVELS)))]), QuantileError(int(rng.integers(1, 1000)) / 1000)


def wide_problem(rng: Generator, losses: Sequence[NumberLoss]) -> Problem:
    """Return a problem of many samples: one column of any depth, or more columns as deep as they can be counted."""
    n_columns = int(rng.choice([1, 1, 2, 3, 4]))
    depth = int(rng.integers(1, 4))
    most = 400 if n_columns == 1 or depth == 1 else (60 if depth == 2 else 14)
    n = int(np.exp(rng.uniform(np.log(8), np.log(most))))
    features = [rng.normal(size=(n, n_columns)), rng.integers(0, max(2, n // 3), (n, n_columns)).astype(float)]
    return Problem(features[rng.integers(2)], wide_targets(rng, n), depth=depth, **_options(rng, n, losses))  # type: ignore[arg-type]


def wide_targets(rng: Generator, n: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return targets with a spread top, tied, whole or in clusters; mostly multiples of 1/64."""
    targets = [
        np.exp(1.5 * rng.normal(size=n)),
        np.clip(rng.standard_cauchy(n), -1e4, 1e4),
        np.round(np.exp(rng.normal(size=n)), 1),
        rng.integers(0, int(rng.integers(2, 300)), n).astype(float),
        100.0 * rng.integers(0, 5, n) + rng.normal(size=n),
        rng.normal(size=n),
    ][rng.choice(6, p=[0.3, 0.2, 0.15, 0.15, 0.1, 0.1])]
    return targets if n < 60 and rng.random() < 0.5 else np.round(targets * 64) / 64


def _options(rng: Generator, n: int, losses: Sequence[NumberLoss]) -> dict[str, object]:
    options: dict[str, object] = {"loss": losses[int(rng.integers(2))]}
    if rng.random() < 0.3:
        options["weights"] = np.maximum(rng.integers(0, 5, n), np.arange(n) == 0).astype(float)
    if rng.random() < 0.2:
        options["leaf_size"] = int(rng.integers(2, max(3, n // 6)))
    if rng.random() < 0.2:
        options["leaf_penalty"] = float(rng.choice([0.25, 1.0, 10.0]))
    return options


def far_problem(rng: Generator, losses: Sequence[NumberLoss]) -> Problem:
    """Return a small problem with some targets far off, or weights of any size, or both."""
    n, n_columns = int(rng.integers(3, 10)), int(rng.integers(1, 3))
    features = rng.integers(0, n, (n, n_columns)).astype(float)
    targets = [np.round(rng.normal(size=n), 1), rng.normal(size=n), rng.integers(0, 9, n).astype(float)][
        rng.integers(3)
    ]
    for row in rng.integers(0, n, int(rng.integers(0, 4))).tolist():
        targets[row] += rng.choice([-1.0, 1.0]) * np.round(10.0 ** rng.uniform(3, 12), int(rng.integers(0, 3)))
    loss = losses[int(rng.integers(2))]
    weights = [np.ones(n), np.round(rng.uniform(0.1, 1, n), 1), 10.0 ** rng.uniform(-9, 9, n)][rng.integers(3)]
    return Problem(features, targets, weights=weights, depth=int(rng.integers(1, 4)), loss=loss)


METHODS = {"exact": 1.0, "search": 0.2}
NUMBER_KINDS = {
    "numbers": Numbers(27, 0.4, _small, least_objective, METHODS, is_proven=True),
    "many_numbers": Numbers(127, 0.2, _wide, _by_runs, METHODS),
    "far_numbers": Numbers(128, 0.3, _far, least_objective, METHODS),
}
