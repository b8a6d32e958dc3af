"""Surprise: the p-value of the leaf that a reading reached, under the belief before the reading.

With q_l = sum_s P(l | s, L) b(s) the chance of leaf l under the belief b *before* the reading, the p-value of leaf l is
the sum of all q that are at most q_l. It is small when the asset moved within the library in a way that growth does not
allow; what leaves the library is the watch's business.
"""

import numpy as np
from numpy.typing import NDArray

from octmip.monitor.belief import Belief
from octmip.monitor.leaf_likelihood import LeafLikelihood, check_readings
from octmip.monitor.library import Applied

Floats = NDArray[np.float64]


def leaf_p_value(likelihood: LeafLikelihood, expected: Belief, readings: Floats, load_factor: Applied) -> Floats:
    """Return the p-value (n,) of the leaves of readings (n, n_gauges); 1 where missing gauges leave leaves open.

    Parameters
    ----------
    expected
        the belief about each asset just before the reading, `Filter.advance` of the last.

    Raises
    ------
    DataError
        the readings have another shape or hold an infinite number, or the load is not positive.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> tree = Split(0, 125.0, Leaf(0), Leaf(1))  # of the gauge g1
    >>> chain = Filter(LeafLikelihood(tree, library), steady_growth(library, rates=0.01))
    >>> expected = chain.advance(chain.start(state=0))
    >>> leaf_p_value(chain.likelihood, expected, np.array([[148.0, 201.0]]), 1.0).round(3).tolist()
    [0.031]
    """
    rows = check_readings(readings, likelihood.library)
    open_leaves = likelihood.open_leaves(likelihood.library.features(rows, load_factor))
    chance = expected.probability @ likelihood.table(load_factor).T
    own = np.where(open_leaves, chance, 0.0).sum(axis=1, keepdims=True)
    p_value = np.where(chance <= own * (1.0 + 1e-12), chance, 0.0).sum(axis=1)
    return np.asarray(np.where(open_leaves.sum(axis=1) == 1, np.minimum(p_value, 1.0), 1.0))
