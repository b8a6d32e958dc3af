"""The errors of femlib, and the checks of incoming arrays that raise them.

One parent, children that also answer to the built-in errors a caller expects. An array is taken in at a public noun:
copied, checked, made read-only.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from numbers import Integral, Real
from typing import TypeGuard

import numpy as np
import numpy.typing as npt

MOST_WHOLE = 2.0**53
"""Beyond it float64 merges neighbouring whole numbers."""
EXTRA_OF = {
    "pyfe3d": "wing",
    "matplotlib": "plot",
    "pyarrow": "parquet",
    "sksparse": "cholmod",
    "pyvista": "pictures",
    "meshio": "meshes",
    "h5py": "meshes",
}
"""The extra of octmip (the distribution femlib comes with) that installs an optional package."""


class FemlibError(Exception):
    """Any failure that femlib reports about its input or its solution."""


class InputError(FemlibError, ValueError):
    """An argument, a file or a state cannot be used; the message says what, where, got, expected and the cure."""


class MeshError(InputError):
    """A mesh has an element that the shell elements cannot represent."""


class SolveError(FemlibError, RuntimeError):
    """A linear or nonlinear system could not be solved to the asked accuracy."""


class MissingExtraError(InputError, ImportError):
    """A feature needs a package that belongs to an extra and is not installed."""


class LeftOutWarning(UserWarning):
    """A file has what changes the structure and is not in the mesh that was read from it."""


@contextmanager
def needed_by(what: str) -> Iterator[None]:
    """Within the context, the import of an optional package that is not installed names the extra to install.

    Parameters
    ----------
    what : str
        The feature that needs the package, the beginning of the sentence.

    Raises
    ------
    MissingExtraError
        If a package of `EXTRA_OF` is missing.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = str(error.name).partition(".")[0]
        if package not in EXTRA_OF:
            raise
        raise MissingExtraError(
            f"{what} needs the package {package}, which is not installed; install octmip[{EXTRA_OF[package]}]"
        ) from error


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is one finite real number: no text, no truth value, no array, no NaN."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


def is_whole(value: object) -> TypeGuard[int]:
    """Return whether a value is a whole number."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def frozen_floats(values: npt.ArrayLike, name: str, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    """Return a read-only float64 copy of `values` with the given shape (-1 = any length).

    Raises
    ------
    InputError
        If the values are no numbers, the shape differs or an entry is not finite.
    """
    array = _converted(values, name)
    _check_shape(array.shape, name, shape)
    if not np.isfinite(array).all():
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"{name}{list(where)} is {array[where]}; expected finite numbers; remove or repair that entry")
    array.flags.writeable = False
    return array


def frozen_ints(values: npt.ArrayLike, name: str, shape: tuple[int, ...]) -> npt.NDArray[np.int64]:
    """Return a read-only int64 copy of `values` with the given shape (-1 = any length).

    Raises
    ------
    InputError
        If the values are no whole numbers or the shape differs.
    """
    floats = _converted(values, name)
    _check_shape(floats.shape, name, shape)
    is_whole_number = (floats == np.rint(floats)) & (np.abs(floats) <= MOST_WHOLE)
    if not is_whole_number.all():
        raise InputError(f"{name} holds {floats[~is_whole_number][0]}; expected whole numbers; correct it")
    array = floats.astype(np.int64)
    array.flags.writeable = False
    return array


def _converted(values: npt.ArrayLike, name: str) -> npt.NDArray[np.float64]:
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name} is no array of numbers ({error}); expected numbers in rows of one length") from error


def _check_shape(got: tuple[int, ...], name: str, expected: tuple[int, ...]) -> None:
    fits = len(got) == len(expected) and all(e in (-1, g) for g, e in zip(got, expected, strict=True))
    if not fits:
        wanted = tuple("n" if e == -1 else e for e in expected)
        raise InputError(f"{name} has shape {got}; expected {wanted}; reshape or complete it")
