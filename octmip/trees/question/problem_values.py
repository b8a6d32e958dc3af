"""The values that a problem is given, each checked and returned as the type that `Problem` keeps."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError, ProblemError
from octmip.input.cells import BEYOND, beyond_exact
from octmip.input.named_arrays import as_mapping, columns_of, numbers_in, settled, unmasked


def set_field(noun: object, name: str, value: object) -> None:
    """Set a field of a frozen dataclass while it is made; an array can be written to no more."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    object.__setattr__(noun, name, value)


def names_of_columns(features: object) -> tuple[str, ...] | None:
    """Return the names of columns; None for an array, or where they are only numbered.

    Raises
    ------
    ProblemError
        a name stands twice, or the rows of a query are not there yet.
    """
    try:
        columns = columns_of(features)
    except DataError as error:
        raise ProblemError(f"features: {error}") from error
    return None if columns is None else tuple(columns)


BLOCK = 1 << 20
"""Numbers of a block."""

KEPT = (np.float64, np.float32)
"""Types of a table of readings that nobody can write to which a problem of axis-aligned trees keeps as it is.

A float32 table stands for its values as float64, of which every one is exact: whoever adds readings, or takes a
midpoint, makes float64 of a column first (`octmip.trees.nodes.tree` compares without).
"""


def features_of(
    values: ArrayLike, *, takes_missing: bool = False, kept: tuple[type[np.floating[Any]], ...] = KEPT[:1]
) -> NDArray[np.float64]:
    """Return the features (n_samples, n_features) of an array or a data frame as float64.

    With `takes_missing` a reading may be missing (NaN, of a data frame also NA or None), and is NaN of one bit pattern.
    An array that nobody can write to stays as it is where it is of a type of `kept`.

    Raises
    ------
    ProblemError
        some value is no number, infinite, or (without `takes_missing`) missing; of a data frame, its columns are named.
    """
    if names_of_columns(values) is None:
        return numbers_of(values, "features", 2, takes_missing=takes_missing, kept=kept)
    given = columns_of(values) or {}
    columns = [_numbers_of_column(column, name) for name, column in given.items()]
    wrong = [name for name, column in zip(given, columns, strict=True) if not _are_usable(column, takes_missing)]
    if wrong:
        shown = ", ".join(map(repr, wrong[:5])) + (f" and {len(wrong) - 5} more" if len(wrong) > 5 else "")
        what = (
            ("text or infinite values", "numbers")
            if takes_missing
            else ("text, missing or infinite values", "finite numbers")
        )
        raise ProblemError(
            f"features holds {what[0]} in {shown}; expected {what[1]}; drop or encode "
            "these columns (octmip.OptimalTreeClassifier and octmip.formats.columns do so)"
        )
    found = [column for column in columns if column is not None]
    return numbers_of(np.column_stack(found) if found else np.zeros((0, 0)), "features", 2, takes_missing=takes_missing)


def _numbers_of_column(given: Any, name: str) -> NDArray[np.float64] | None:
    """Return a named column as numbers, NaN where missing; None where it holds something else.

    Raises
    ------
    ProblemError
        it holds a whole number beyond 2^53.
    """
    column = settled(given)
    try:
        numbers = numbers_in(column, name)
    except DataError:
        return None
    row = beyond_exact(column, numbers)
    if row is not None:
        raise ProblemError(f"features holds a whole number in row {row} of {name!r}, {BEYOND}")
    return numbers


def _are_usable(numbers: NDArray[np.float64] | None, takes_missing: bool) -> bool:
    return numbers is not None and not (np.isinf(numbers) if takes_missing else ~np.isfinite(numbers)).any()


def refuse_missing(n_missing: int, why: str, cure: str) -> None:
    """Raise if readings are missing where all are needed.

    Raises
    ------
    ProblemError
        some are; the sentence says `why` that cannot be and ends with the `cure`.
    """
    if n_missing:
        what = f"{n_missing} readings are" if n_missing > 1 else "1 reading is"
        raise ProblemError(f"{what} missing (NaN), and {why}; expected every reading; {cure}")


def numbers_of(
    values: ArrayLike,
    name: str,
    n_dimensions: int,
    *,
    takes_missing: bool = False,
    kept: tuple[type[np.floating[Any]], ...] = KEPT[:1],
) -> NDArray[np.float64]:
    """Return finite numbers as float64; with `takes_missing` some may be missing, NaN of one bit pattern.

    A copy, but of an array of a type of `kept` that nobody can write to (`array.flags.writeable` False, its memory its
    own): a table of 10^6 rows is then held once.

    Raises
    ------
    ProblemError
        some value is no finite number (nor, with `takes_missing`, missing), or the number of dimensions is another.
    """
    values = unmasked(values)
    if (kind := getattr(values, "dtype", None)) is not None and getattr(kind, "kind", "") in "cmM":
        raise ProblemError(f"{name} holds values of type {kind}; expected numbers; convert them to real ones first")
    try:
        array = values if _is_settled(values, kept) else np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ProblemError(f"{name} cannot be read as numbers ({error}); encode text as numbers first") from error
    if array.ndim != n_dimensions:
        raise ProblemError(f"{name} has {array.ndim} dimensions; expected {n_dimensions}")
    position = None if array is values else beyond_exact(values, array)
    if position is not None:
        place = ", ".join(map(str, np.unravel_index(position, array.shape)))
        raise ProblemError(f"{name}[{place}] is {np.asarray(values, dtype=object).ravel()[position]}, {BEYOND}")
    if all(np.isfinite(block).all() for block in in_blocks(array)):
        return array
    is_wrong = ~np.isfinite(array)
    is_missing = np.isnan(array)
    is_wrong = is_wrong & ~is_missing if takes_missing else is_wrong
    if is_wrong.any():
        place = ", ".join(str(int(i)) for i in np.argwhere(is_wrong)[0])
        what = (
            ("infinite", "finite numbers, or NaN where a reading is missing")
            if takes_missing
            else ("not finite", "finite numbers")
        )
        raise ProblemError(
            f"{name}[{place}] is {what[0]} ({int(is_wrong.sum())} in all); expected {what[1]}; drop or fill them"
        )
    if not array.flags.writeable:
        missing = array[is_missing]
        if missing.tobytes() == np.full_like(missing, np.nan).tobytes():
            return array
        array = array.copy()
    array[is_missing] = np.nan
    return array


def in_blocks(array: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Yield an array in blocks of rows: what is made of a table need not be as large as the table."""
    rows = max(1, BLOCK // max(1, array[:1].size))
    return (array[start : start + rows] for start in range(0, len(array), rows))


def _is_settled(values: object, kept: tuple[type[np.floating[Any]], ...]) -> TypeGuard[NDArray[np.float64]]:
    """Return whether values are of a type of `kept`, in memory of their own that nobody can write to."""
    if type(values) is not np.ndarray or values.dtype not in kept:
        return False
    return not values.flags.writeable and values.flags.owndata


def feature_names_of(given: Sequence[object] | None, n_features: int) -> tuple[str, ...]:
    """Return the names of the features, x0, x1, ... where none are given.

    Raises
    ------
    ProblemError
        they are more or fewer than the features, or one stands twice.
    """
    names = tuple(str(name) for name in ([f"x{j}" for j in range(n_features)] if given is None else given))
    if len(names) != n_features or len(set(names)) != len(names):
        raise ProblemError(
            f"feature_names has {len(names)} entries ({len(set(names))} different) but features has "
            f"{n_features} columns; give one name for each column, none twice"
        )
    return names


def numbers_to_predict(given: ArrayLike, n_samples: int) -> NDArray[np.float64]:
    """Return the targets (n_samples,) of a loss of numbers; a ProblemError unless there is one for each sample."""
    targets = numbers_of(given, "targets", 1)
    if targets.shape != (n_samples,):
        raise ProblemError(
            f"targets has {len(targets)} entries but features has {n_samples} rows; give one for each row"
        )
    return targets


def weights_of(given: ArrayLike | None, n_samples: int) -> NDArray[np.float64]:
    """Return the weights (n_samples,), 1 each where none are given.

    Raises
    ------
    ProblemError
        there is no weight for each sample, one is negative, or all are 0.
    """
    weights = np.ones(n_samples) if given is None else numbers_of(given, "weights", 1)
    if weights.shape != (n_samples,):
        raise ProblemError(f"weights has {len(weights)} entries but features has {n_samples} rows; give one each")
    if (weights < 0).any():
        row = int(np.flatnonzero(weights < 0)[0])
        raise ProblemError(f"weights[{row}] is {weights[row]}; expected 0 or more")
    if not weights.any():
        raise ProblemError("all weights are 0; expected at least one positive weight")
    return weights


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


def sensor_of_each(
    given: Mapping[str, str] | Sequence[str] | None, names: tuple[str, ...], what: str
) -> tuple[str, ...]:
    """Return the sensor of each name: its own where none is given, or a mapping leaves the name out.

    Raises
    ------
    ProblemError
        there are more or fewer sensors than names, or a mapping has another name; `what` says what they are.
    """
    given = as_mapping(given)
    if given is None:
        return names
    if isinstance(given, Mapping):
        unknown = [name for name in given if name not in names]
        if unknown:
            raise ProblemError(f"sensor_of_feature names {unknown}, no {what}; expected some of {list(names)}")
        return tuple(str(given.get(name, name)) for name in names)
    if len(given) != len(names):
        raise ProblemError(
            f"sensor_of_feature has {len(given)} entries but there are {len(names)} {what}; give one each, or a "
            "mapping from some of them"
        )
    return tuple(map(str, given))


def sensor_costs_of(
    given: Mapping[str, float] | Sequence[float] | None, sensors: tuple[str, ...]
) -> NDArray[np.float64]:
    """Return the cost of every sensor (n_sensors,); 1 each where nothing is given.

    Raises
    ------
    ProblemError
        a sensor has no cost, an unknown one has, or a cost is negative.
    """
    given = as_mapping(given)
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


DIRECTIONS = {"+": 1, "-": -1, "0": 0}
SIGNS = {direction: sign for sign, direction in DIRECTIONS.items()}


def directions_of(given: object, names: tuple[str, ...], what: str) -> tuple[int, ...] | None:
    """Return the direction of each feature: 1, -1 or 0; None where all are 0.

    Parameters
    ----------
    given
        a mapping from features (names or indices) to "+", "-", 1, -1 or 0, or one of them for each feature.
    names
        of the features.
    what
        is given, for an error.

    Raises
    ------
    ProblemError
        a feature is unknown, or a direction none.
    """
    given = as_mapping(given)
    if given is None:
        return None
    found = [0] * len(names)
    if isinstance(given, Mapping):
        pairs = [(names.index(key) if key in names else key, value) for key, value in given.items()]
    elif isinstance(given, str) or not isinstance(given, Sequence) or len(given) != len(names):
        raise ProblemError(
            f"{what} is {given!r}; expected a direction, 1, -1 or 0, for each of the {len(names)} features, or a "
            "mapping from some of them"
        )
    else:
        pairs = list(enumerate(given))
    for feature, value in pairs:
        if isinstance(feature, bool) or not isinstance(feature, int) or not 0 <= feature < len(names):
            raise ProblemError(f"{what} names {feature!r}; expected one of the features {', '.join(names)}")
        direction = DIRECTIONS.get(value, value) if isinstance(value, str) else value
        if isinstance(direction, bool) or direction not in (1, 0, -1):
            raise ProblemError(f"{what} of {names[feature]} is {value!r}; expected '+' (1), '-' (-1) or 0")
        found[feature] = int(direction)
    return tuple(found) if any(found) else None


def words_of(names: Sequence[str], directions: Sequence[int]) -> str:
    """Return directions as the command takes them: g01=+,g02=-."""
    pairs = zip(names, directions, strict=True)
    return ",".join(f"{name}={SIGNS[direction]}" for name, direction in pairs if direction)
