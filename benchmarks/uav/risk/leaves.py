"""Trust in the leaves of a proven tree of depth 3: calibration, credible sets, other priors."""

from dataclasses import dataclass

import numpy as np

from femlib.dataset import Dataset
from octmip import Limits, Problem, certify, solve
from octmip.trees.uncertainty import (
    Brier,
    LeafDistribution,
    ReliabilityBin,
    brier_score,
    calibrate_sets,
    calibration_error,
    reliability,
)

COVERAGE = 0.9
# A fleet that is mostly sound: share of the states of 0, 20, 40, 60, 80 % loss.
FLEET = (0.5, 0.2, 0.15, 0.1, 0.05)


@dataclass(frozen=True, slots=True)
class Trust:
    """One tree on test rows: half of them set the credible sets, all else is counted on the other half.

    Attributes
    ----------
    raw, laplace
        calibration error and Brier score of plain and smoothed leaves.
    bins
        of the reliability diagram, plain and smoothed.
    coverage, size
        share of sets that hold the truth, and how many states they hold; by_class: the same where each
        state has its own threshold, then the least coverage of a state.
    fleet
        Brier score on rows drawn in the shares of `FLEET`, with the training prior and with the fleet's.
    """

    label: str
    seed: int
    raw: tuple[float, Brier]
    laplace: tuple[float, Brier]
    bins: dict[str, list[ReliabilityBin]]
    coverage: float
    size: float
    by_class: tuple[float, float, float]
    fleet: tuple[float, float]


def trust(data: Dataset, label: str, seed: int, depth: int) -> Trust:
    """Return what the leaves of the proven tree of least error are worth on the test rows."""
    is_train = data.is_train
    problem = Problem(data.features[is_train], getattr(data, label)[is_train], depth=depth)
    solution = solve(problem, "exact", Limits(seconds=300.0))
    certify(problem, solution)
    assert solution.tree is not None
    plain = LeafDistribution.of(solution.tree, problem)
    smooth = LeafDistribution.of(solution.tree, problem, strength=float(problem.n_classes))
    features = data.features[~is_train]
    codes = np.searchsorted(problem.class_names, getattr(data, label)[~is_train])
    order = np.random.default_rng(seed).permutation(len(codes))
    calibration, rest = order[: len(order) // 2], order[len(order) // 2 :]
    table = smooth.predict(features)
    held = calibrate_sets(table[calibration], codes[calibration], coverage=COVERAGE).sets(table[rest])
    own = calibrate_sets(table[calibration], codes[calibration], coverage=COVERAGE, by_class=True).sets(table[rest])
    is_hit, is_own_hit = (sets[np.arange(len(rest)), codes[rest]] for sets in (held, own))
    least = min(float(is_own_hit[codes[rest] == k].mean()) for k in range(problem.n_classes))
    share = np.array(FLEET)[codes] / np.bincount(codes)[codes]
    fleet = [brier_score(smooth.predict(features, prior), codes, weights=share).score for prior in (None, FLEET)]
    raw = plain.predict(features)
    tables = {"shares of the training rows": raw, "Laplace": table}
    return Trust(
        label,
        seed,
        (calibration_error(raw, codes), brier_score(raw, codes)),
        (calibration_error(table, codes), brier_score(table, codes)),
        {name: reliability(t, codes) for name, t in tables.items()},
        float(is_hit.mean()),
        float(held.sum(axis=1).mean()),
        (float(is_own_hit.mean()), float(own.sum(axis=1).mean()), least),
        (fleet[0], fleet[1]),
    )
