"""Regression: corrupted logs are refused, what was wrong once is right, the study's row of numbers has every rule."""

import numpy as np
import pytest

from benchmarks.cases.fuzz.proofs import corrupted
from benchmarks.kinds.numbers import NUMBER_KINDS, far_problem, wide_problem
from octmip import solve
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.losses import AbsoluteError, SquaredError


@pytest.mark.parametrize("first", [2000, 2040])
def test_no_corruption_that_changes_the_claim_is_accepted(first):
    assert not [seed for seed in range(first, first + 40) if corrupted("numbers", seed)[1] == "wrong"]


@pytest.mark.parametrize(("kind", "draw", "seed"), [
    ("many_numbers", wide_problem, 60),  # more targets than bins of clusters, whose bound was false
    ("far_numbers", far_problem, 1485),  # rounded bounds do not grow from cut to cut
])  # fmt: skip
def test_what_the_fuzz_found_stays_mended_with_its_log(kind, draw, seed, tmp_path):
    asked = NUMBER_KINDS[kind]
    problem = draw(np.random.default_rng([asked.stream, seed]), (SquaredError(), AbsoluteError()))
    solution = solve(problem, options=ExactOptions(proof=tmp_path / "proof.log"))
    assert asked.complaint(problem, solution, asked.truth(problem), tmp_path / "proof.log") == ""
