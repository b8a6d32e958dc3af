"""The parameters that both estimators have, and what they mean: weights, threads, seed, leaves, sensors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from joblib import effective_n_jobs
from numpy.typing import NDArray
from sklearn.utils import check_random_state

from octmip.errors import ProblemError
from octmip.formats.columns import Columns
from octmip.input.named_arrays import as_mapping
from octmip.trees.methods.options import Options
from octmip.trees.question.problem_values import directions_of, number_of, sensor_of_each, whole_of
from octmip.trees.question.shape import MAX_DEPTH
from octmip.trees.runs.registry import Method

RandomState = int | np.random.RandomState | None
MOST_SEED = 2**31 - 1
AUTO: Literal["auto"] = "auto"
CST = "monotonic_cst"


@dataclass(kw_only=True, eq=False, repr=False)
class Settings:
    """The parameters that both estimators have; `OptimalTreeClassifier` says what each is.

    scikit-learn reads the names of an estimator's parameters from the signature of its `__init__`, which a dataclass
    writes.
    """

    max_depth: int | Literal["auto"] | None = field(default="auto", kw_only=False)
    split: Literal["axis", "hyperplane"] = "axis"
    split_size: int | None = None
    min_samples_leaf: float = 1
    min_weight_fraction_leaf: float = 0.0
    max_leaf_nodes: int | None = None
    monotonic_cst: Mapping[str, int] | Sequence[int] | None = None
    fixed_splits: Mapping[str, Any] | None = None
    path_rules: Sequence[Sequence[str]] | None = None
    leaf_penalty: float = 0.0
    sensor_of_feature: Mapping[str, str] | Sequence[str] | None = None
    sensor_cost: Mapping[str, float] | Sequence[float] | None = None
    sensor_budget: float | None = None
    categories: Literal["yes-no", "subsets", "order", "refuse"] = "yes-no"
    missing: Literal["either-side", "refuse"] = "either-side"
    takes_missing: bool = True
    method: Method = "auto"
    options: Options | None = None
    seconds: float = 60.0
    n_jobs: int | None = None
    verbose: int = 0
    random_state: RandomState = 0


def depth_of(settings: Settings) -> Any:
    """Return the depth of the problem, None where any will do; 1 for "auto", whose choice replaces it.

    Raises
    ------
    ProblemError
        it is neither "auto" nor None nor a whole number from 1 to 30, or "auto" stands beside what it chooses itself,
        or None beside nothing that ends a tree.
    """
    if settings.max_depth is None:
        if settings.leaf_penalty == 0 and settings.max_leaf_nodes is None:
            raise ProblemError(
                "max_depth is None and leaf_penalty 0, so the largest tree would be the best; expected a price of a "
                "split, a number of leaves or of levels; give leaf_penalty, max_leaf_nodes, or a max_depth, such as 3"
            )
        return None
    if settings.max_depth != AUTO:
        return whole_of(settings.max_depth, "max_depth", 1, MAX_DEPTH)
    chosen = {"leaf_penalty": 0, "method": AUTO, "options": None, "max_leaf_nodes": None, "monotonic_cst": None}
    chosen |= {"fixed_splits": None, "path_rules": None}
    for name, usual in chosen.items():
        if (value := getattr(settings, name)) != usual:
            raise ProblemError(
                f"{name} is {value!r} with max_depth='auto', which chooses its own; expected {usual!r}; leave {name} "
                "out, or give a max_depth, such as 3"
            )
    return 1


def seed_of(random_state: RandomState) -> int:
    """Return the seed that a random_state means: itself, or one drawn from it."""
    if isinstance(random_state, int | np.integer) and not isinstance(random_state, bool):
        return whole_of(int(random_state), "random_state", 0, None)
    return int(check_random_state(random_state).randint(MOST_SEED))


def threads_of(n_jobs: int | None) -> int:
    """Return the threads that n_jobs means to joblib: 1 for None (or its context's), all for -1."""
    return int(effective_n_jobs(n_jobs))


def leaf_size_of(min_samples_leaf: float, n_samples: int) -> int:
    """Return the least samples of a leaf; a fraction is one of all samples.

    Raises
    ------
    ProblemError
        it is neither a whole number from 1 to n_samples nor a fraction between 0 and 1.
    """
    if isinstance(min_samples_leaf, float) and 0 < min_samples_leaf < 1:
        return math.ceil(min_samples_leaf * n_samples)
    return whole_of(min_samples_leaf, "min_samples_leaf", 1, n_samples)  # type: ignore[arg-type]


def leaf_weight_of(min_weight_fraction_leaf: float, weights: NDArray[np.float64]) -> float:
    """Return the least weight of a leaf: a share of that of all samples.

    Raises
    ------
    ProblemError
        it is no share from 0 to 0.5.
    """
    share = number_of(min_weight_fraction_leaf, "min_weight_fraction_leaf")
    if share > 0.5:
        raise ProblemError(f"min_weight_fraction_leaf is {share:g}; expected a share from 0 to 0.5")
    return share * math.fsum(weights)


def sensors_of(columns: Columns, sensor_of_feature: Mapping[str, str] | Sequence[str] | None) -> tuple[str, ...]:
    """Return the sensor of each feature: that of its column, so that a column which is read once costs once.

    Raises
    ------
    ProblemError
        the sensors are not one per column, or name a column that is none.
    """
    sensors = dict(zip(columns.names, sensor_of_each(sensor_of_feature, columns.names, "columns of X"), strict=True))
    return tuple(sensors[name] for name in columns.column_of_feature)


def directions_of_columns(columns: Columns, given: Mapping[str, int] | Sequence[int] | None) -> dict[str | int, Any]:
    """Return the direction of each feature that scikit-learn's `monotonic_cst` gives one: its column's.

    Raises
    ------
    ProblemError
        a column is unknown, has no such direction, or is text, whose values have no order.
    """
    given = as_mapping(given)
    wanted = directions_of(given if given is None or isinstance(given, Mapping) else list(given), columns.names, CST)
    signs = dict(zip(columns.names, wanted or (), strict=False))
    found: dict[str | int, Any] = {}
    for j, name in enumerate(columns.column_of_feature):
        if signs.get(name, 0):
            if columns.feature_names[j] != name:
                raise ProblemError(f"{CST} names the column {name!r}, whose values have no order; leave it out")
            found[j] = signs[name]
    return found
