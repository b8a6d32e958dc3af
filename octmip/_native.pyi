"""The native core: see octmip/native/src/python.rs."""

import numpy as np
from numpy.typing import NDArray

class Problem:
    """A problem over dense ranks with integer costs, checked."""

    def __new__(
        cls,
        ranks: NDArray[np.uint32],
        n_ranks: list[int],
        labels: NDArray[np.uint32],
        weights: NDArray[np.int64],
        costs: NDArray[np.int64],
        penalty: int,
        depth: int,
        leaf_size: int,
        sensor_of_feature: list[int],
        sensor_cost: list[float],
        sensor_limit: float,
        allowed: list[bool],
    ) -> Problem: ...
