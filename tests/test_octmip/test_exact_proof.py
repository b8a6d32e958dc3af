"""Proof logs that the exact core writes, verified by the checker, which shares no code with it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from octmip.errors import CertificateError
from octmip.exact import branch_and_bound
from octmip.problem import Problem
from octmip.proof import check_proof


def random_problem(seed: int) -> Problem:
    """Return a problem of up to 60 samples with weights, costs, leaf sizes, penalties and budgets, by chance."""
    rng = np.random.default_rng(seed)
    n, p, k = int(rng.integers(6, 60)), int(rng.integers(2, 5)), int(rng.integers(2, 7))
    labels = np.concatenate([np.arange(k), rng.integers(0, k, max(n - k, 0))])
    n = len(labels)
    return Problem(
        np.round(rng.normal(size=(n, p)), int(rng.integers(0, 3))),
        labels,
        depth=int(rng.integers(1, 4)),
        weights=None if rng.random() < 0.5 else rng.integers(0, 5, n) + (np.arange(n) == 0),
        costs=None if rng.random() < 0.6 else rng.integers(0, 6, (k, k)),
        leaf_size=1 if rng.random() < 0.7 else int(rng.integers(1, 4)),
        leaf_penalty=0 if rng.random() < 0.6 else float(rng.integers(0, 5)) / 2,
        sensor_budget=None if rng.random() < 0.6 else float(rng.integers(0, p)),
    )


@pytest.mark.parametrize("block", range(6))
def test_the_checker_accepts_every_log(block: int, tmp_path: Path) -> None:
    log = tmp_path / "proof.txt"
    for seed in range(25 * block, 25 * block + 25):
        problem = random_problem(seed)
        solution = branch_and_bound(problem, proof=log)
        assert solution.is_optimal, seed
        assert check_proof(problem, log).bound == solution.bound, seed


def test_the_checker_refuses_a_log_of_other_labels(tmp_path: Path) -> None:
    problem = random_problem(3)
    branch_and_bound(problem, proof=tmp_path / "proof.txt")
    with pytest.raises(CertificateError, match="refused"):
        check_proof(replace(problem, labels=problem.labels[::-1]), tmp_path / "proof.txt")
