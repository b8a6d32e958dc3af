"""What scikit-learn calls X, as the features that a tree reads.

An array of finite numbers is its own features. Anything else, text, dates, categories or missing values, is encoded
as the command does it, by `octmip.formats.columns`. `n_features_in_` and `feature_names_in_` are those of X itself.

Folds of a cross-validation are parts of a table: a cell may be missing in predict where none was in fit, and a column
may lose all its values. `takes_missing` says whether an estimator takes both.
"""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator
from sklearn.utils.validation import assert_all_finite, check_consistent_length, column_or_1d, validate_data

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.formats.columns.column import Column
from octmip.formats.columns.frames import frame_of, series_of
from octmip.input.cells import BEYOND, EXACT_INTEGERS, beyond_exact
from octmip.input.messages import shown
from octmip.trees.question.classes import codes_of
from octmip.trees.tradeoff.held_out import Samples

Floats = NDArray[np.float64]


def learn_samples(
    estimator: BaseEstimator, X: ArrayLike, y: ArrayLike, *, doubled: bool = False
) -> tuple[Floats, NDArray[Any], Columns]:
    """Return the features (n_samples, n_features), the labels (n_samples,) and how X became these features.

    `doubled` makes two complete features of numbers with missing values, as `Columns.learn` has it.

    Raises
    ------
    ValueError
        scikit-learn refuses X or y: shapes, lengths, sparse or complex values, infinite or missing labels.
    DataError
        a column cannot become features (also a ValueError); all of them are named.
    """
    X = frame_of(X)
    checked, labels = validate_data(estimator, _objects(X), labels_of(y), dtype=None, ensure_all_finite=False)
    names = _names(estimator)
    numbers = _numbers(estimator, checked, X)
    if numbers is not None and not np.isnan(numbers).any():
        return numbers, labels, plain_columns(names, numbers)
    columns = Columns.learn(
        _frame(X, checked, names),
        categories=estimator.categories,
        missing=estimator.missing,
        doubled=doubled,
        of_part=takes_missing(estimator),
    )
    if estimator.split == "hyperplane":
        columns.refuse_missing_in_sums("use split='axis', or fill them (NaN) before")
    return columns.encode(_frame(X, checked, names)), labels, columns


def read_samples(estimator: BaseEstimator, X: ArrayLike) -> Floats:
    """Return the features (n_samples, n_features) of the samples of a fitted estimator.

    Raises
    ------
    ValueError
        scikit-learn refuses X: another number of columns, other names, sparse, complex or infinite values.
    DataError
        a column holds what it did not in training (also a ValueError).
    """
    X = frame_of(X)
    checked = validate_data(estimator, _objects(X), dtype=None, ensure_all_finite=False, reset=False)
    columns: Columns = estimator.columns_
    takes = takes_missing(estimator) or columns.lack_numbers
    numbers = _numbers(estimator, checked, X)
    if numbers is not None and columns.is_plain and (takes or not np.isnan(numbers).any()):
        return numbers
    features = columns.encode(_frame(X, checked, columns.names), takes_missing=takes)
    if estimator.split == "hyperplane":
        _refuse_sums(features, columns)
    return features


def takes_missing(estimator: BaseEstimator) -> bool:
    """Whether predict takes a missing cell in a column that had none in fit; a sum in a leaf would have no value."""
    is_sum = getattr(estimator, "leaf_model", "constant") != "constant"
    return bool(estimator.takes_missing) and estimator.missing != "refuse" and not is_sum


def _refuse_sums(features: Floats, columns: Columns) -> None:
    """Refuse numbers that are missing where a hyperplane adds them; a missing text is no number."""
    numbers = [column.name for column in columns.columns if column.kind in ("number", "order")]
    for name, lacks in zip(columns.column_of_feature, np.isnan(features).T, strict=True):
        if lacks.any() and name in numbers:
            raise DataError(
                f"cells are missing in {shown(name)}; a hyperplane adds its features; fill them (NaN) before"
            )


def _objects(X: Any) -> Any:
    """Return X as scikit-learn is to check it: a frame as objects, unless all its columns are numbers of one array."""
    if isinstance(X, pd.DataFrame) and not all(map(_is_plain, X.dtypes, (X.iloc[:, k] for k in range(X.shape[1])))):
        return X.astype(object)
    return X


def _is_plain(kind: Any, column: "pd.Series[Any]") -> bool:
    """Whether a column of numpy's numbers is the same as float64."""
    return isinstance(kind, np.dtype) and (kind.kind in "bf" or (kind.kind in "iu" and _is_exact(column.to_numpy())))


def _is_exact(whole: NDArray[Any]) -> bool:
    """Whether float64 holds whole numbers; others are refused by the name of their column."""
    if not whole.size or whole.dtype.itemsize < 8:
        return True
    return int(whole.min()) >= -EXACT_INTEGERS and int(whole.max()) <= EXACT_INTEGERS


def labels_of(y: Any) -> Any:
    """Return labels as they are, numbers among objects and of pandas' own types as numpy's: whole ones stay whole.

    Raises
    ------
    DataError
        a label among texts is missing.
    """
    y = series_of(y)
    if not isinstance(y, pd.Series | np.ndarray | list):
        return y
    labels = pd.Series(y) if np.ndim(y) == 1 else pd.Series()
    n_missing, kind = int(labels.isna().sum()), getattr(labels.dtype, "numpy_dtype", None)
    if n_missing and labels.dtype.kind == "O":
        raise DataError(f"Input y contains NaN: {n_missing} of {len(labels)} labels are missing; drop these rows")
    if labels.dtype == object and labels.infer_objects().dtype.kind in "biuf":
        return labels.infer_objects().to_numpy()  # whole numbers or Booleans, which scikit-learn takes for no classes
    return labels.to_numpy(dtype=kind) if isinstance(kind, np.dtype) and kind.kind in "biuf" and not n_missing else y


def test_samples(estimator: BaseEstimator, X: ArrayLike, y: ArrayLike | None) -> Samples:
    """Return samples that a fitted estimator is judged by, each of weight 1.

    Raises
    ------
    ValueError
        X is refused, or X and y have different lengths.
    DataError
        y is not given, or holds what is no class of the training, or no number.
    """
    if y is None:
        raise DataError("X_test is given without y_test; expected both")
    features, labels = read_samples(estimator, X), column_or_1d(labels_of(y))
    check_consistent_length(features, labels)
    if not hasattr(estimator, "classes_"):
        return Samples(features, np.asarray(labels, dtype=np.float64), np.ones(len(labels)))
    names = estimator.problem_.samples.class_names
    known = set(names)
    unknown = next((label for label in labels.tolist() if label not in known), None)
    if unknown is not None:
        raise DataError(f"y_test holds {unknown!r}, which is no class of the training ({', '.join(map(str, names))})")
    return Samples(features, codes_of(labels, names), np.ones(len(labels)))


def label_name(y: Any) -> str | None:
    """Return the name of a series of labels; None where it has none."""
    name = getattr(y, "name", None)
    return name if isinstance(name, str) else None


def plain_columns(names: tuple[str, ...], numbers: Floats) -> Columns:
    """Return the columns of finite numbers (n_samples, n_columns): each is its own feature."""
    least, most = numbers.min(axis=0).tolist(), numbers.max(axis=0).tolist()
    found = zip(names, least, most, strict=True)
    return Columns(tuple(Column(name, "number", False, low, high) for name, low, high in found))


def _names(estimator: BaseEstimator) -> tuple[str, ...]:
    """Return the names of the columns of X: its own, or x0, x1, ... as `Problem` has them."""
    given = getattr(estimator, "feature_names_in_", None)
    return tuple(f"x{j}" for j in range(estimator.n_features_in_)) if given is None else tuple(map(str, given))


def _numbers(estimator: BaseEstimator, checked: NDArray[Any], given: Any) -> Floats | None:
    """Return the checked array as float64, NaN where missing; None where it holds text or objects.

    Raises
    ------
    DataError
        a value is missing that may not be, or X, as it was given, holds a whole number that float64 does not.
    """
    if checked.dtype.kind not in "biuf":
        return None
    numbers = checked.astype(np.float64)
    position = beyond_exact(given if isinstance(given, list | tuple) else checked, numbers)
    if position is not None:
        row, column = np.unravel_index(position, checked.shape)
        raise DataError(f"X holds a whole number in row {row}, column {column}, {BEYOND}")
    name = type(estimator).__name__
    assert_all_finite(numbers, allow_nan=True, estimator_name=name, input_name="X")
    is_missing = np.isnan(numbers)
    if is_missing.any() and not estimator.__sklearn_tags__().input_tags.allow_nan:
        row, column = np.argwhere(is_missing)[0].tolist()
        raise DataError(
            f"X is NaN at [{row}, {column}] ({int(is_missing.sum())} missing values in all); {name} takes them with "
            "split='axis' and missing='either-side' only; use these, or fill them before"
        )
    return numbers


def _frame(X: Any, checked: NDArray[Any], names: tuple[str, ...]) -> pd.DataFrame:
    """Return X as a table with these names, columns of an array of objects with the types that their values have."""
    frame = X if isinstance(X, pd.DataFrame) else pd.DataFrame(checked).infer_objects()
    return frame.set_axis(list(names), axis=1)
