"""Readings of the study: published table or femlib's wing, and the problems that are made of them."""

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.data import SHARED
from benchmarks.problem_options import ProblemOptions
from femlib.dataset import Dataset, MeanStrains, Recipe, build_dataset, published_strains, simulated_strains
from femlib.wing import Wing, uav_wing
from octmip import Problem
from octmip.trees.losses import ClassCosts
from octmip.trees.tree import Node, predict

LABELS = ("mu1", "mu2")
LEVELS = (0, 20, 40, 60, 80)
CLEARANCE = 0.04
"""Distance from a damage region [m] below which a candidate reads the region's edge itself."""
SMOKE = Recipe(samples_per_state=8)


@cache
def candidate_wing() -> Wing:
    """Return femlib's wing with all 82 candidate gauges."""
    return uav_wing(candidates=True)


@cache
def mean_strains(source: str) -> MeanStrains:
    """Return the mean strains of "published" (24 gauges) or "wing" (82)."""
    if source == "published":
        return published_strains(SHARED / "uav" / "strains.csv")
    return simulated_strains(candidate_wing())


def readings(source: str, seed: int, is_smoke: bool) -> Dataset:
    """Return the readings of one seed by the paper's recipe, or few of them."""
    return build_dataset(mean_strains(source), SMOKE if is_smoke else Recipe(), seed)


def installed(data: Dataset) -> tuple[str, ...]:
    """Return the gauges that are on the wing and usable: 20."""
    return tuple(name for name in data.gauges if name.startswith("g"))


def clear_of_regions(data: Dataset) -> tuple[str, ...]:
    """Return the usable gauges without the candidates that are less than `CLEARANCE` from a damage region."""
    wing = candidate_wing()
    distances = np.min([wing.gauges.distances(region, wing.planform) for region in wing.regions], axis=0)
    near = {name for name, d in zip(wing.gauges.names, distances, strict=True) if d < CLEARANCE}
    return tuple(name for name in data.gauges if name not in near or name in installed(data))


def problem_of(
    data: Dataset, label: str, depth: int, gauges: Sequence[str], split_size: int = 1, *, for_mae: bool = False
) -> Problem:
    """Return the training problem: misclassified samples as objective, or the absolute error in percent stiffness."""
    levels = np.array(LEVELS, dtype=float)
    options: ProblemOptions = {
        "depth": depth,
        "split": "axis" if split_size == 1 else "hyperplane",
        "split_size": split_size,
        "feature_names": tuple(gauges),
        "class_names": LEVELS,
    }
    if for_mae:
        options["loss"] = ClassCosts(np.abs(levels[:, None] - levels))
    features = data.features[data.is_train][:, [data.gauges.index(gauge) for gauge in gauges]]
    return Problem(features, getattr(data, label)[data.is_train], **options)


def mean_absolute_error(data: Dataset, label: str, gauges: Sequence[str], tree: Node, rows: NDArray[np.bool_]) -> float:
    """Return the MAE [percent stiffness] of a tree over `gauges` on some rows."""
    features = data.features[rows][:, [data.gauges.index(gauge) for gauge in gauges]]
    return float(np.abs(np.array(LEVELS)[predict(tree, features)] - getattr(data, label)[rows]).mean())
