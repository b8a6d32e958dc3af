"""Random damage states."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def random_states(rng: np.random.Generator, n: int, n_regions: int, n_damaged: int, most: float) -> Floats:
    """Return states (n, n_regions) with `n_damaged` regions of uniform damage up to `most`, the others whole."""
    states = rng.uniform(0.0, most, (n, n_regions))
    whole = np.argsort(rng.uniform(size=states.shape), axis=1)[:, n_damaged:]
    np.put_along_axis(states, whole, 0.0, axis=1)
    return states
