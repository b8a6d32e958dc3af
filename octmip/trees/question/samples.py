"""Samples: what a Problem is about, each row with its readings, its target and its weight, checked and named."""

from collections.abc import Iterable
from dataclasses import InitVar, dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.question.classes import classes_of
from octmip.trees.question.problem_values import (
    KEPT,
    feature_names_of,
    features_of,
    in_blocks,
    names_of_columns,
    numbers_to_predict,
    set_field,
    weights_of,
)

_DERIVED: Any = None  # a field that is filled in when it is left out


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Samples:
    """Rows of readings with their targets and weights.

    Attributes
    ----------
    features
        (n_samples, n_features) float64, NaN where a reading is missing, never infinite; a data frame gives
        its names too. A copy, but of an array with memory of its own that nobody can write to: such a float64
        array is kept as it is, with axis-aligned trees of classes also a float32 one, which stands for its values as
        float64.
    targets
        (n_samples,) what is to be predicted, an array or a series: the class of each sample, as values of
        `class_names`, or a finite number of each (then float64), as the loss has it.
    weights
        (n_samples,) risk weights, 0 or more; None: all 1.
    takes_missing
        whether readings may be missing, so that every split says where they go; True wherever some are.
    feature_names
        (n_features,); None: the names of the data frame's columns, of an array x0, x1, ...
    class_names
        the classes in the order of the rows of a cost matrix; None: `class_order`, else the sorted targets.
    class_order
        the classes from low to high, for `monotone`; `class_names` then have this order. None: `class_names` as given,
        an ordered categorical's own order, that of numbers, Booleans and dates; of other texts (), none.
    target_name
        for files and pages.
    predicts, is_axis
        what the loss predicts, "class" or "number", and whether splits are axis-aligned.
    Derived:
        codes: (n_samples,) the targets as the loss reads them: int64, index of each class in `class_names`; of
        numbers the targets.
        n_samples, n_features, n_classes: their numbers; of classes those without a sample included, of numbers 0.
    """

    features: NDArray[np.float64]
    targets: NDArray[Any]
    weights: NDArray[np.float64] = _DERIVED
    takes_missing: bool = False
    feature_names: tuple[str, ...] = _DERIVED
    class_names: tuple[Any, ...] = _DERIVED
    class_order: tuple[Any, ...] = _DERIVED
    target_name: str = "target"
    predicts: InitVar[str] = "class"
    is_axis: InitVar[bool] = True
    codes: NDArray[Any] = field(init=False)
    n_samples: int = field(init=False)
    n_features: int = field(init=False)
    n_classes: int = field(init=False)

    def __post_init__(self, predicts: str, is_axis: bool) -> None:
        given = self.feature_names if self.feature_names is not None else names_of_columns(self.features)
        kept = KEPT if is_axis and predicts == "class" else KEPT[:1]
        features = features_of(self.features, takes_missing=True, kept=kept)
        if min(features.shape) == 0:
            raise ProblemError(f"features has shape {features.shape}; expected at least one sample and one feature")
        for name, value in zip(("features", "n_samples", "n_features"), (features, *features.shape), strict=True):
            set_field(self, name, value)
        set_field(self, "takes_missing", bool(self.takes_missing) or self.n_missing > 0)
        set_field(self, "feature_names", feature_names_of(given, features.shape[1]))
        names = "targets", "class_names", "class_order", "codes"
        for name, value in zip(names, self._of_classes() if predicts == "class" else self._of_numbers(), strict=True):
            set_field(self, name, value)
        set_field(self, "n_classes", len(self.class_names))
        set_field(self, "weights", weights_of(self.weights, self.n_samples))

    def __setstate__(self, state: list[Any]) -> None:
        """Take what another process sent: its arrays may begin at any byte, and the native core reads whole words."""
        for one, value in zip(fields(self), state, strict=True):
            is_moved = isinstance(value, np.ndarray) and not value.flags.aligned
            set_field(self, one.name, value.copy() if is_moved else value)

    def _of_classes(self) -> Iterable[Any]:
        return classes_of(self.targets, self.class_names, self.class_order, self.n_samples)

    def _of_numbers(self) -> Iterable[Any]:
        for name in ("class_names", "class_order"):
            if given := getattr(self, name):
                raise ProblemError(f"{name} is {given} but the loss predicts numbers; leave it out")
        targets = numbers_to_predict(self.targets, self.n_samples)
        return targets, (), (), targets

    @property
    def n_missing(self) -> int:
        """Number of readings that are missing."""
        return sum(int(np.isnan(block).sum()) for block in in_blocks(self.features))

    @property
    def features_with_missing(self) -> tuple[int, ...]:
        """The features of which some reading is missing, ascending."""
        with_missing = np.zeros(self.n_features, dtype=np.bool_)
        for block in in_blocks(self.features):
            with_missing |= np.isnan(block).any(axis=0)
        return tuple(np.flatnonzero(with_missing).tolist())
