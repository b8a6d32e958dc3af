"""Proof logs of regression trees: good ones prove the optimum, each corruption is refused, no log proves more."""

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.kinds.numbers import NUMBER_KINDS, far_problem, wide_problem
from octmip.errors import CertificateError, ProblemError
from octmip.trees.answer.solution import Stop
from octmip.trees.evidence.proof import check_proof
from octmip.trees.evidence.regression_log import write_proof
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.losses import SPELLINGS, AbsoluteError, SquaredError, number_loss
from octmip.trees.question.problem import Problem
from octmip.trees.regression.exact import exact_regression
from tests.oracles.regression_trees import least_objective, random_problem


def strains(loss: str, depth: int = 3) -> Problem:
    """Return twenty-four samples of two features with five targets."""
    rng = np.random.default_rng(5)
    features = rng.normal(size=(24, 2)).round(1)
    return Problem(features, 20.0 * rng.integers(0, 5, 24), depth=depth, loss=number_loss(loss))


@pytest.mark.parametrize(("kind", "draw", "seed"), [
    ("many_numbers", wide_problem, 60),  # more targets than bins of clusters, whose bound was false
    ("far_numbers", far_problem, 1485),  # rounded bounds do not grow from cut to cut
])  # fmt: skip
def test_what_the_fuzz_found_stays_mended_with_its_log(kind: str, draw: Any, seed: int, tmp_path: Path) -> None:
    asked, log = NUMBER_KINDS[kind], tmp_path / "proof.log"
    problem = draw(np.random.default_rng([asked.stream, seed]), (SquaredError(), AbsoluteError()))
    solution = exact_regression(problem, options=ExactOptions(proof=log))
    assert asked.complaint(problem, solution, asked.truth(problem), log) == ""


@pytest.mark.parametrize("loss", SPELLINGS)
def test_logs_of_random_problems_prove_no_less_than_the_optimum(loss: str, tmp_path: Path) -> None:
    for seed in range(6):
        problem, log = random_problem(np.random.default_rng([41, seed]), loss), tmp_path / "proof.log"
        exact_regression(problem, options=ExactOptions(proof=log))
        least = pytest.approx(float(least_objective(problem)), rel=1e-5, abs=1e-6 * problem.baseline)
        assert check_proof(problem, log).bound == least, seed


@pytest.mark.parametrize("loss", SPELLINGS)
def test_a_log_of_whole_numbers_proves_what_the_solver_does(loss: str, tmp_path: Path) -> None:
    problem = strains(loss)
    solution = exact_regression(problem, options=ExactOptions(proof=tmp_path / "proof.log"))
    report = check_proof(problem, tmp_path / "proof.log", bound=solution.bound)
    assert solution.is_optimal
    assert solution.stop is Stop.OPTIMAL
    assert report.bound == pytest.approx(solution.objective, rel=1e-12)
    assert report.bound == solution.objective or loss != "absolute"
    # Tenths are rounded once, the bound downwards.
    assert loss == "squared" or report.bound >= np.nextafter(solution.objective, 0.0)


@pytest.mark.parametrize("loss", SPELLINGS)
def test_a_log_without_one_of_its_lines_is_refused(loss: str, tmp_path: Path) -> None:
    problem, path = strains(loss), tmp_path / "proof.log"
    exact_regression(problem, options=ExactOptions(proof=path))
    lines = path.read_text().splitlines(keepends=True)
    accepted = []
    for dropped in range(len(lines)):
        path.write_text("".join(lines[:dropped] + lines[dropped + 1 :]))
        try:
            check_proof(problem, path)
        except CertificateError:
            continue
        accepted.append(lines[dropped])
    # Cuts that the writer solved before it knew the best tree may not be needed; no other line may be left out.
    assert len(accepted) < len(lines) / 10
    assert all(line.startswith("F ") for line in accepted)


def test_a_log_of_other_data_or_of_another_question_is_refused(tmp_path: Path) -> None:
    problem, path = strains("absolute", depth=2), tmp_path / "proof.log"
    exact_regression(problem, options=ExactOptions(proof=path))
    targets = problem.samples.targets.copy()
    targets[7] += 20.0
    changed = Problem(problem.samples.features, targets, depth=2, loss=AbsoluteError())
    with pytest.raises(CertificateError, match='line 2: got "data '):
        check_proof(changed, path)
    for other in (
        strains("absolute", depth=3),
        Problem(problem.samples.features, problem.samples.targets, depth=2, loss=SquaredError()),
    ):
        with pytest.raises(CertificateError, match=r"line [13]: got"):
            check_proof(other, path)


def test_a_log_that_proves_less_than_a_tree_claims_is_refused(tmp_path: Path) -> None:
    problem, path = strains("absolute", depth=2), tmp_path / "proof.log"
    solution = exact_regression(problem, options=ExactOptions(proof=path))
    with pytest.raises(CertificateError, match=r"but .* is claimed for the tree"):
        check_proof(problem, path, bound=math.nextafter(solution.bound, math.inf))


def test_a_bound_below_the_optimum_has_a_log_too(tmp_path: Path) -> None:
    problem, path = strains("absolute"), tmp_path / "proof.log"
    assert write_proof(path, problem, Fraction(20)) == 20
    assert check_proof(problem, path, bound=20.0).bound == 20
    third = Fraction(61, 3)  # between two numbers of any grid
    assert third - Fraction(1, 10**6) < Fraction(write_proof(path, problem, third)) <= third


def test_trees_found_by_search_have_no_log(tmp_path: Path) -> None:
    problem = Problem(np.eye(4), np.arange(4.0), depth=1, leaf_model="linear", loss=SquaredError())
    with pytest.raises(ProblemError, match="have no proof log"):
        check_proof(problem, tmp_path / "proof.log")
