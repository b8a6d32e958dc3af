"""The exact solver's own proof logs: each is accepted by a checker that knows no solver, and no corruption passes."""

import numpy as np
import pytest

from benchmarks.cases.fuzz.proofs import corrupted
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.proof import check_proof
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem

BLOCK = 20


@pytest.mark.parametrize("first", range(0, 100, BLOCK))
def test_every_log_of_the_solver_proves_its_bound(first, tmp_path):
    for seed in range(first, first + BLOCK):
        problem = random_problem(np.random.default_rng([41, seed]))
        solution = branch_and_bound(problem, options=ExactOptions(proof=tmp_path / "proof.log"))
        report = check_proof(problem, tmp_path / "proof.log", bound=solution.bound)
        assert report.bound <= optimum(problem).objective * (1 + 1e-12), f"seed {seed}"
        assert report.bound >= solution.objective - solution.tolerance, f"seed {seed}"


@pytest.mark.parametrize("first", range(2000, 2060, BLOCK))
def test_no_corruption_that_changes_the_claim_is_accepted(first):
    assert not [seed for seed in range(first, first + BLOCK) if corrupted("classes", seed)[1] == "wrong"]
