"""The exact solver against enumeration on random problems: a few hundred as in `benchmarks/cases/fuzz/exact.py`."""

import numpy as np
import pytest

from benchmarks.cases.fuzz.exact import complaint
from benchmarks.oracles.strategies import random_problem

N_PROBLEMS, BLOCK = 400, 20


@pytest.mark.parametrize("first", range(0, N_PROBLEMS, BLOCK))
def test_it_finds_the_optimum_of_enumeration_and_the_fewest_splits(first):
    for seed in range(first, first + BLOCK):
        problem = random_problem(np.random.default_rng([21, seed]))
        reason = complaint(problem)
        assert reason is None, f"seed {seed}: {reason}"
