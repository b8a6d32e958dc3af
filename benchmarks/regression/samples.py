"""Samples made up for speed: many, and of a tree that is known."""

import numpy as np
from numpy.typing import NDArray


def made_up(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return samples of a tree of depth 2 with a slope and noise."""
    rng = np.random.default_rng(0)
    features = rng.normal(size=(n, 10))
    inner = np.where(features[:, 0] > 0.3, 2.0 * (features[:, 1] > 0), features[:, 2] > -0.5)
    return features, inner + 0.3 * features[:, 3] + rng.normal(size=n)
