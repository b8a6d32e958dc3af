"""Proof logs of two-feature trees: accepted where they are true, refused with line and reason elsewhere."""

from pathlib import Path

import numpy as np
import pytest

from octmip import Problem
from octmip.errors import CertificateError, ProblemError
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from tests.oracles.two_feature_problems import clouds


def test_logs_of_larger_problems_are_checked_on_several_threads(tmp_path: Path) -> None:
    path = tmp_path / "proof.log"
    for seed in (2, 6, 9):
        problem = clouds(seed, most_samples=140)
        solution = two_feature_branch_and_bound(problem, options=ExactOptions(proof=path), n_jobs=2)
        assert check_proof(problem, path, n_jobs=2).bound == solution.objective


def log_of(problem: Problem, path: Path) -> list[str]:
    two_feature_branch_and_bound(problem, options=ExactOptions(proof=path))
    return path.read_text().split("\n")


def test_a_log_is_bound_to_its_samples_and_its_question(tmp_path: Path) -> None:
    problem = clouds(2, most_samples=100)
    path = tmp_path / "proof.log"
    log_of(problem, path)
    other = problem.replace(features=problem.samples.features * 2)
    with pytest.raises(CertificateError, match="line 2"):
        check_proof(other, path)
    with pytest.raises(CertificateError, match="line 3"):
        check_proof(problem.replace(leaf_penalty=1), path)


def test_deeper_trees_have_no_logs() -> None:
    problem = Problem(np.eye(4), [0, 1, 0, 1], depth=3, split="hyperplane", split_size=2)
    with pytest.raises(ProblemError, match="depth 3 with 2 features per split has no proof log"):
        check_proof(problem, "nowhere.log")
