"""Array types of femlib."""

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


class Judged(np.ndarray[Any, np.dtype[np.float64]]):
    """An array of answers that carries the estimate of its error; what is computed from it carries none.

    Attributes
    ----------
    error : float
        Estimated error over the size of the whole array, as roots of sums of squares; NaN where there is none.
    """

    error: float

    def __array_finalize__(self, source: object) -> None:
        self.error = float("nan")


def judged(values: FloatArray, error: float) -> Judged:
    """Return a view of values with the estimate of their error."""
    found = np.asarray(values).view(Judged)
    found.error = error
    return found
