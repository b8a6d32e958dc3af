"""The values that a problem is given, each checked and returned as the type that `Problem` keeps."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError


def names_of_columns(features: object) -> tuple[str, ...] | None:
    """Return the names of the columns of a data frame; None for an array, or where the columns are only numbered."""
    columns = getattr(features, "columns", None)
    if columns is None or all(isinstance(name, int | np.integer) for name in columns):
        return None
    return tuple(str(name) for name in columns)


def features_of(values: ArrayLike) -> NDArray[np.float64]:
    """Return the features (n_samples, n_features) of an array or a data frame as a float64 copy.

    Raises
    ------
    ProblemError
        some value is no finite number; of a data frame, the columns that hold such values are named.
    """
    names = names_of_columns(values)
    if names is None:
        return numbers_of(values, "features", 2)
    wrong = [name for j, name in enumerate(names) if not _is_finite_column(values, j)]
    if wrong:
        shown = ", ".join(map(repr, wrong[:5])) + (f" and {len(wrong) - 5} more" if len(wrong) > 5 else "")
        raise ProblemError(
            f"features holds text, missing or infinite values in {shown}; expected finite numbers; drop or encode "
            "these columns (octmip.OptimalTreeClassifier and octmip.formats.columns do so)"
        )
    return numbers_of(values, "features", 2)


def _is_finite_column(frame: Any, position: int) -> bool:
    try:
        column = np.asarray(frame.iloc[:, position], dtype=np.float64)
    except (TypeError, ValueError):
        return False
    return bool(np.isfinite(column).all())


def labels_of(values: ArrayLike) -> NDArray[Any]:
    """Return a copy of the labels of an array or a series.

    Raises
    ------
    ProblemError
        a label is missing or infinite.
    """
    labels = np.array(values)
    is_absent = np.zeros(labels.shape, dtype=bool)
    if labels.dtype.kind == "f":
        is_absent = ~np.isfinite(labels)
    elif labels.dtype.kind in "mM":
        is_absent = np.isnat(labels)
    elif labels.dtype == np.dtype(object):
        is_absent = np.array([_is_missing(value) for value in labels.ravel()], dtype=bool).reshape(labels.shape)
    if is_absent.any():
        row = ", ".join(str(int(i)) for i in np.argwhere(is_absent)[0])
        first = labels[is_absent][0]
        raise ProblemError(
            f"labels[{row}] is {first}; {int(is_absent.sum())} of {labels.size} labels are missing or infinite; "
            "expected a class for each sample; drop the others or give their labels"
        )
    return labels


def _is_missing(label: Any) -> bool:
    """Whether a label is None, a NaN of any kind or the NA of pandas, which compares to nothing."""
    return label is None or type(label).__name__ == "NAType" or bool(label != label)


def distinct_labels(labels: NDArray[Any]) -> tuple[list[Any], NDArray[np.int64]]:
    """Return the distinct labels in ascending order and the index of each sample's label among them."""
    if labels.dtype != np.dtype(object):
        distinct, inverse = np.unique(labels, return_inverse=True)
        return distinct.tolist(), inverse.astype(np.int64)
    values = labels.tolist()
    present = sorted(set(values), key=lambda value: (type(value).__name__, value))
    position = {value: k for k, value in enumerate(present)}
    return present, np.array([position[value] for value in values], dtype=np.int64)


def numbers_of(values: ArrayLike, name: str, n_dimensions: int) -> NDArray[np.float64]:
    """Return a float64 copy of finite numbers.

    Raises
    ------
    ProblemError
        some value is no finite number, or the number of dimensions is another.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ProblemError(f"{name} cannot be read as numbers ({error}); encode text as numbers first") from error
    if array.ndim != n_dimensions:
        raise ProblemError(f"{name} has {array.ndim} dimensions; expected {n_dimensions}")
    if not np.isfinite(array).all():
        place = ", ".join(str(int(i)) for i in np.argwhere(~np.isfinite(array))[0])
        count = int((~np.isfinite(array)).sum())
        raise ProblemError(
            f"{name}[{place}] is not finite ({count} in all); expected finite numbers; drop or fill them"
        )
    return array


def number_of(value: float, name: str) -> float:
    """Return a finite number of 0 or more.

    Raises
    ------
    ProblemError
        it is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not np.isfinite(value) or value < 0:
        raise ProblemError(f"{name} is {value!r}; expected a finite number of 0 or more")
    return float(value)


def whole_of(value: int, name: str, low: int, high: int | None) -> int:
    """Return a whole number from `low` to `high` (None: no upper end).

    Raises
    ------
    ProblemError
        it is none, or lies outside.
    """
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not is_whole or value < low or (high is not None and value > high):
        most = "" if high is None else f" to {high}"
        raise ProblemError(f"{name} is {value!r}; expected a whole number from {low}{most or ' on'}")
    return int(value)


def sensor_costs_of(
    given: Mapping[str, float] | Sequence[float] | None, sensors: tuple[str, ...]
) -> NDArray[np.float64]:
    """Return the cost of every sensor (n_sensors,); 1 each where nothing is given.

    Raises
    ------
    ProblemError
        a sensor has no cost, an unknown one has, or a cost is negative.
    """
    if given is None:
        return np.ones(len(sensors))
    if isinstance(given, Mapping):
        missing = [name for name in sensors if name not in given]
        unknown = [name for name in given if name not in sensors]
        if missing or unknown:
            raise ProblemError(
                f"sensor_cost has {len(given)} entries but sensor_of_feature names {len(sensors)} sensors "
                f"(missing: {missing}, unknown: {unknown}); give one cost per sensor"
            )
        given = [given[name] for name in sensors]
    costs = numbers_of(given, "sensor_cost", 1)
    if len(costs) != len(sensors):
        raise ProblemError(
            f"sensor_cost has {len(costs)} entries but sensor_of_feature names {len(sensors)} sensors "
            f"(missing: {list(sensors[len(costs) :])}); give one cost per sensor"
        )
    if (costs < 0).any():
        worst = int(np.argmin(costs))
        raise ProblemError(f"sensor_cost of {sensors[worst]!r} is {costs[worst]}; expected 0 or more")
    return costs
