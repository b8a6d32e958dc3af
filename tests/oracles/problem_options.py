"""Options of a problem besides samples and labels, for benchmarks and oracles that gather them piece by piece."""

from collections.abc import Sequence
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import NDArray

from octmip.trees.losses import Loss


class ProblemOptions(TypedDict, total=False):
    """Keyword arguments of `octmip.trees.problem.Problem`, any of them left out."""

    depth: int
    split: Literal["axis", "hyperplane"]
    split_size: int | None
    leaf_size: int
    leaf_penalty: float
    weights: NDArray[np.float64]
    loss: Loss
    sensor_of_feature: Sequence[str]
    sensor_cost: dict[str, float] | Sequence[float]
    sensor_budget: float
    allowed_splits: Sequence[Sequence[str | int]]
    integer_normals: int
    feature_names: tuple[str, ...]
    class_names: tuple[int, ...]
