"""An independent modeller: the formulas of docs/examples/model.md alone, typed into highspy, have octmip's optima."""

import numpy as np
import pytest

import octmip
from octmip import ClassCosts, MipOptions, Problem
from tests.oracles.enumeration import optimum
from tests.oracles.page_model import oct_h_optimum, oct_optimum

MARGIN = 0.02


def drawn(seed: int, split: str) -> Problem:
    """Return a problem of ten samples on a coarse grid, its weights, costs, leaf size and penalty as they come."""
    rng = np.random.default_rng([seed, len(split)])
    n_classes = int(rng.integers(2, 4))
    depth = int(rng.integers(1, 3)) if split == "axis" else 1 + (seed % 6 == 0)
    labels = np.concatenate([np.arange(n_classes), rng.integers(0, n_classes, 10 - n_classes)])
    features = rng.integers(0, rng.integers(2, 6), (10, 3 if depth == 1 else 2)).astype(float)
    if rng.random() < 0.2:
        features[:, 0] = 7.0  # no split on it
    costs = rng.integers(1, 5, (n_classes, n_classes)) * (1 - np.eye(n_classes))
    return Problem(
        features,
        labels,
        depth=depth,
        split=split,
        loss=ClassCosts(costs) if rng.random() < 0.5 else ClassCosts(),
        weights=rng.integers(1, 4, 10).astype(float) if rng.random() < 0.5 else None,
        leaf_size=int(rng.integers(1, 4)),
        leaf_penalty=float(rng.integers(0, 2)),
    )


@pytest.mark.parametrize("seed", range(8))
def test_oct_by_the_page_is_octmips_and_the_optimum(seed):
    problem = drawn(seed, "axis")
    solution = octmip.solve(problem, "oct")
    assert solution.is_optimal
    assert oct_optimum(problem) == pytest.approx(solution.objective, abs=1e-4)
    assert solution.objective == optimum(problem).objective


@pytest.mark.parametrize("seed", range(6))
def test_oct_h_by_the_page_is_octmips(seed):
    problem = drawn(seed, "hyperplane")
    solution = octmip.solve(problem, "oct_h", options=MipOptions(mu=MARGIN))
    assert solution.meets_bound
    within = solution.details.get("bound_in_scope", solution.bound)  # of the separated trees alone
    assert solution.is_optimal == ("bound_in_scope" in solution.details)
    assert oct_h_optimum(problem, MARGIN) == pytest.approx(within, abs=1e-4)
