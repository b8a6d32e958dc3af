"""Costs of single samples: whole, decimal, real, or over twelve orders; some decisions are nobody's best."""

from dataclasses import dataclass
from pathlib import Path

from benchmarks.kinds.classes import Classes
from benchmarks.kinds.kind import Generator, Question
from benchmarks.outside import BY_PYOMO
from octmip.trees.losses import ClassCosts
from octmip.trees.mip.pyomo_model import model, solution_of
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution
from tests.oracles.problem_options import ProblemOptions

PATIENCE = 10.0  # seconds that HiGHS has, driven by Pyomo


@dataclass(frozen=True, slots=True)
class SampleCosts(Classes):
    """Trees of least cost where each sample has its own costs; "model" is OCT in Pyomo, solved by HiGHS."""

    def ask(self, question: Question, problem: Problem, log: Path | None) -> Solution:
        """Return the answer to a question."""
        if question.method != "model":
            return Classes.ask(self, question, problem, log)
        M = model(problem, "oct")
        return solution_of(M, BY_PYOMO["HiGHS"](M, PATIENCE))


def sample_problem(rng: Generator) -> Problem:
    """Return a random problem of two to four decisions, whose costs are those of single samples."""
    n, k = int(rng.integers(2, 11)), int(rng.integers(2, 5))
    kinds = (rng.integers(0, 6, (n, k)), rng.integers(0, 100, (n, k)) / 10, rng.random((n, k)))
    costs = (*kinds, 10.0 ** rng.uniform(-6, 6, (n, k)))[int(rng.integers(4))]
    if rng.random() < 0.5:
        costs[rng.random(n) < 0.5] = costs[0, 0]  # nothing to choose for some, who fill leaves all the same
    options: ProblemOptions = {"depth": int(rng.integers(1, 4)), "class_names": tuple(range(k))}
    if rng.random() < 0.3:
        options["weights"] = rng.random(n) + 0.01
    if rng.random() < 0.3:
        options["leaf_penalty"] = float(rng.choice([0.5, 1.0, 0.3]))
    if k == 2:
        options["leaf_size"] = int(rng.integers(1, min(n, 4) + 1))
    features = rng.integers(0, 5, (n, 2)).astype(float)
    options["loss"] = ClassCosts(costs, per_sample=True)
    return Problem(features, costs.argmin(axis=1), **options)


METHODS = {"exact": 1.0, "search": 0.1, "cart": 0.1, "oct": 0.03, "benders": 0.03, "model": 0.03}
SAMPLE_COSTS_KIND = SampleCosts(70, sample_problem, METHODS, 0.3, ())
