"""What one channel does wrong: readings that say nothing of the asset."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Fault:
    """Readings of one channel that are left out.

    Attributes
    ----------
    kind
        "stuck", "clipped" or "jump".
    gauge
        name of the channel.
    rows
        (n,) rows of the campaign.
    words
        a sentence on it.
    value
        where it stands still or ends, or by how much it jumps, in the unit of its readings.
    first
        first row of it; of a jump the first one after it.
    """

    kind: str
    gauge: str
    rows: NDArray[np.int64]
    words: str
    value: float
    first: int
