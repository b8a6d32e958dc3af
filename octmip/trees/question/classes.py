"""Classes: their names, their order from low to high, the index of each target, the weight of each class.

`Shape.monotone` goes along an order of the classes. It is given, or the type of the targets names it: an ordered
categorical of pandas, an Enum of polars, an ordered dictionary of Arrow. Numbers, Booleans, dates and durations have
their own. Texts have none: the alphabet puts "high" below "low".
"""

import datetime
import numbers
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.input.named_arrays import unmasked

ClassWeight = Mapping[Any, float] | Literal["balanced"] | None

OF_ONE_KIND = (
    (bool, np.bool_),
    (numbers.Real, np.number),
    (datetime.date, np.datetime64),
    (datetime.time,),
    (datetime.timedelta, np.timedelta64),
)
"""Kinds of values that have an order of their own; values of two kinds have none, but for numbers beside Booleans."""


def class_order_of(targets: object, classes: Iterable[Any], given: Sequence[Any] | None) -> tuple[Any, ...]:
    """Return the classes of a problem from low to high; () where nothing gives an order.

    Parameters
    ----------
    targets
        as they were given, of any library: their type may name an order.
    classes
        that they hold.
    given
        the order that was asked for; it may name classes that the targets lack.

    Raises
    ------
    ProblemError
        the order lacks a class, or names one twice.
    """
    present = set(classes)
    if given is None:
        levels = ordered_levels(targets)
        named = present and present <= set(levels)
        return tuple(level for level in levels if level in present) if named else _own_order(present)
    if isinstance(given, set | frozenset):
        raise ProblemError(f"class_order is a set, {given}, which has no order; expected a list, from low to high")
    order = tuple(given)
    lacking = sorted(present.difference(order), key=str)
    if order and (lacking or len(set(order)) != len(order)):
        what = f"lacks {', '.join(map(repr, lacking))}" if lacking else "names a class twice"
        raise ProblemError(
            f"class_order is {', '.join(map(str, order))} and {what}; expected every class once, from low to high"
        )
    return order


def ordered_levels(values: Any) -> tuple[Any, ...]:
    """Return the levels from low to high that a column's type names; () where it names none."""
    arrow = getattr(values, "type", None)
    kind: Any = getattr(values, "dtype", None)
    if getattr(kind, "pyarrow_dtype", None) is not None:
        values = values.array.__arrow_array__()
        arrow = values.type
    if arrow is not None and getattr(arrow, "ordered", False) and hasattr(arrow, "value_type"):
        whole = values.unify_dictionaries().chunks if hasattr(values, "chunks") else [values]
        return tuple(whole[0].dictionary.to_pylist()) if whole else ()
    if getattr(kind, "ordered", False) or type(kind).__name__ == "Enum":
        return tuple(kind.categories.to_list() if hasattr(kind.categories, "to_list") else kind.categories)
    return ()


def words_of_order(order: Sequence[Any]) -> str:
    """Return an order of classes in words, from low to high."""
    return f"order of classes: {' < '.join(map(str, order))}"


def refuse_without_order(order: Sequence[Any], classes: Sequence[Any]) -> None:
    """Raise if an order of classes is needed and there is none.

    Raises
    ------
    ProblemError
        with the ways to give one.
    """
    if not order:
        names = ", ".join(map(str, classes[:5])) + (", ..." if len(classes) > 5 else "")
        raise ProblemError(
            f"monotone is given but the classes {names} are texts, which have no order; expected them from low to "
            "high; give class_order, an ordered categorical, or --class-order LOW,...,HIGH"
        )


def _own_order(present: set[Any]) -> tuple[Any, ...]:
    """Return values of one kind in the order of that kind, () of others."""
    is_one = any(all(isinstance(value, kind) for value in present) for kind in OF_ONE_KIND)
    return tuple(sorted(present)) if is_one else ()


def classes_of(
    given: ArrayLike, class_names: Sequence[Any] | None, class_order: Sequence[Any] | None, n_samples: int
) -> tuple[NDArray[Any], tuple[Any, ...], tuple[Any, ...], NDArray[np.int64]]:
    """Return targets (n_samples,), the names of the classes, their order, and of each target the index of its class.

    The order is () where nothing gives one; else the names are in it (`octmip.trees.class_order`).

    Raises
    ------
    ProblemError
        there is no target for each sample, one class only, or one without a name or with two.
    """
    targets = labels_of(given)
    if targets.shape != (n_samples,):
        raise ProblemError(
            f"targets has shape {targets.shape} but features has {n_samples} rows; give one for each row"
        )
    present, inverse = distinct_labels(targets)
    names = tuple(present if class_names is None else class_names)
    order = names if class_names is not None and class_order is None else class_order_of(given, present, class_order)
    if class_names is not None and order and set(names) != set(order):
        raise ProblemError(f"class_order is {order} but class_names is {names}; leave one of them out")
    names = order or names
    if len(names) < 2:
        raise ProblemError(f"targets holds one class only ({present[0]!r}); expected two or more")
    position = {name: k for k, name in enumerate(names)}
    unknown = [label for label in present if label not in position]
    if unknown or len(position) != len(names):
        raise ProblemError(
            f"targets holds {unknown} which class_names {names} lacks (or names twice); name every class once"
        )
    return targets, names, order, np.array([position[label] for label in present], dtype=np.int64)[inverse]


def codes_of(labels: NDArray[Any], names: Sequence[Any]) -> NDArray[np.int64]:
    """Return the index of each label (n_samples,) among the names of the classes."""
    position = {name: k for k, name in enumerate(names)}
    return np.array([position[label] for label in labels.tolist()], dtype=np.int64)


def in_class_order(given: Any, classes: Sequence[Any], what: str, first: int = 0) -> Any:
    """Return values for classes in the order of the classes, where their axes from the `first` one name these.

    Axes of series and frames do, unless they only count 0, 1, 2, ..., and so do the keys of a mapping.

    Raises
    ------
    ProblemError
        an axis does not name each class once.
    """
    axes = [list(given)] if isinstance(given, Mapping) else [list(own) for own in getattr(given, "axes", ())]
    table = np.array(list(given.values())) if isinstance(given, Mapping) else given
    wanted = [str(name) for name in classes]
    for axis, names in enumerate(axes):
        own = [str(name) for name in names]
        if axis < first or names == list(range(len(names))):
            continue
        if sorted(own) != sorted(wanted):
            raise ProblemError(f"{what} names {', '.join(own)}; expected each of the classes {', '.join(wanted)} once")
        table = np.take(np.asarray(table), [own.index(name) for name in wanted], axis)
    return table


def labels_of(values: ArrayLike) -> NDArray[Any]:
    """Return a copy of the labels of an array or a series.

    Raises
    ------
    ProblemError
        a label is missing or infinite.
    """
    labels = np.array(unmasked(values))
    is_absent = np.zeros(labels.shape, dtype=bool)
    if labels.dtype.kind == "f":
        is_absent = ~np.isfinite(labels)
    elif labels.dtype.kind in "mM":
        is_absent = np.isnat(labels)
    elif labels.dtype == np.dtype(object) and any(map(_is_missing, _distinct(labels.ravel().tolist()))):
        is_absent = np.array([_is_missing(value) for value in labels.ravel()], dtype=bool).reshape(labels.shape)
    if is_absent.any():
        row = ", ".join(str(int(i)) for i in np.argwhere(is_absent)[0])
        first = labels[is_absent][0]
        raise ProblemError(
            f"labels[{row}] is {first}; {int(is_absent.sum())} of {labels.size} labels are missing or infinite; "
            "expected a class for each sample; drop the others or give their labels"
        )
    return labels


def _distinct(labels: list[Any]) -> Iterable[Any]:
    """Return the labels, equal ones once; all where one of them cannot be hashed."""
    try:
        return set(labels)
    except TypeError:
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


def factors_of(
    class_weight: ClassWeight, classes: Sequence[Any], codes: NDArray[np.int64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what multiplies the weight of the samples of each class, shape (n_classes,).

    "balanced" gives every class the same total weight, the weights of the samples counted: a sample of weight 2 is
    two samples.

    Parameters
    ----------
    class_weight
        None, "balanced", or the weight of each class by name; classes left out have 1.
    classes, codes
        the classes, and the index of each sample's (n_samples,).
    weights
        (n_samples,) of the samples.

    Raises
    ------
    ProblemError
        class_weight is none of these, names what is no class, or gives no number of 0 or more.
    """
    if class_weight is None:
        return np.ones(len(classes))
    if isinstance(class_weight, str) and class_weight == "balanced":
        total = np.bincount(codes, weights, len(classes))
        return np.asarray(weights.sum() / (np.count_nonzero(total) * np.where(total > 0, total, 1.0)))
    names = ", ".join(map(str, classes[:10]))
    if not isinstance(class_weight, Mapping):
        raise ProblemError(
            f"class_weight is {class_weight!r}; expected None, 'balanced' or a weight for each of the classes {names}"
        )
    unknown = [name for name in class_weight if name not in set(classes)]
    if unknown and not set(classes) <= set(class_weight):
        raise ProblemError(
            f"class_weight names {unknown[0]!r}, which is none of the classes {names}; spell it as they do"
        )
    factors = np.array([class_weight.get(name, 1.0) for name in classes], dtype=np.float64)
    if not np.isfinite(factors).all() or (factors < 0).any():
        raise ProblemError(f"class_weight is {dict(class_weight)}; expected a number of 0 or more for each class")
    return factors
