"""Array types of femlib and the one way to take an array in: copied, checked and made read-only."""

import numpy as np
import numpy.typing as npt

from femlib.errors import InputError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def frozen_floats(values: npt.ArrayLike, name: str, shape: tuple[int, ...]) -> FloatArray:
    """Return a read-only float64 copy of `values` with the given shape (-1 = any length).

    Raises
    ------
    InputError
        If the shape differs or an entry is not finite.
    """
    array = np.array(values, dtype=np.float64)
    _check_shape(array.shape, name, shape)
    if not np.isfinite(array).all():
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"{name}{list(where)} is {array[where]}; expected finite numbers; remove or repair that entry")
    array.flags.writeable = False
    return array


def frozen_ints(values: npt.ArrayLike, name: str, shape: tuple[int, ...]) -> IntArray:
    """Return a read-only int64 copy of `values` with the given shape (-1 = any length).

    Raises
    ------
    InputError
        If the shape differs.
    """
    array = np.array(values, dtype=np.int64)
    _check_shape(array.shape, name, shape)
    array.flags.writeable = False
    return array


def _check_shape(got: tuple[int, ...], name: str, expected: tuple[int, ...]) -> None:
    fits = len(got) == len(expected) and all(e in (-1, g) for g, e in zip(got, expected, strict=True))
    if not fits:
        wanted = tuple("n" if e == -1 else e for e in expected)
        raise InputError(f"{name} has shape {got}; expected {wanted}; reshape or complete it")
