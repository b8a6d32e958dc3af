"""Regression: corrupted logs are refused, what was wrong once is right, the study's row of numbers has every rule."""

import numpy as np
import pytest

from benchmarks.cases.fuzz.proofs import corrupted
from benchmarks.kinds.numbers import NUMBER_KINDS, far_problem, wide_problem
from benchmarks.uav.numbers import rows_of, text_of
from femlib.dataset import Recipe, build_dataset, simulated_strains
from femlib.wing import uav_wing
from octmip import solve
from octmip.trees.losses import AbsoluteError, SquaredError
from octmip.trees.methods.options import ExactOptions


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


def test_numbers_of_the_study_are_judged_by_every_rule():
    data = build_dataset(simulated_strains(uav_wing(refinement=0.25)), Recipe(samples_per_state=4), seed=0)
    rows = list(rows_of(data, (1,), 5.0))
    assert len(rows) == 14
    squared = next(row for row in rows if row["rule"] == "regression tree, squared error")
    greedy = next(row for row in rows if row["rule"] == "scikit-learn DecisionTreeRegressor")
    assert squared["rmse_train"] <= greedy["rmse_train"] + 1e-9
    assert text_of(rows).count("\n|") == 16
