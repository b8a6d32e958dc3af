"""Problem: everything that says which tree is wanted, checked once, here.

minimise   sum_i weights_i * loss(target_i, predicted_i) + leaf_penalty * complexity(tree)
over       trees of at most `depth` levels of splits (or of any), every leaf with at least `leaf_size` samples
           (or `leaf_weight`), at most `split_size` features per split, total sensor cost at most `sensor_budget`;
           where readings are missing, each split sends them to one side, of its own choice
"""

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.classes import classes_of, refuse_without_order, words_of_order
from octmip.trees.losses import ClassCosts, Loss, NumberLoss
from octmip.trees.problem_values import (
    KEPT,
    feature_names_of,
    features_of,
    in_blocks,
    names_of_columns,
    numbers_to_predict,
    weights_of,
)
from octmip.trees.shape import Shape, set_field, with_leaves
from octmip.trees.tree import (
    Leaf,
    Node,
    ValueLeaf,
    complexity,
    features_used,
    leaf_index,
    leaves,
    predict,
    predict_values,
    splits,
    with_sides_for_missing,
)

MANY_ROWS = 64
LEAST_SAVING = 1e-8
"""Share of the objective of a tree of numbers that another must save to be called better."""
_DERIVED: Any = None  # a field that is filled in when it is left out


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Problem(Shape):
    """Samples, the loss of a prediction, and which trees are allowed.

    Attributes
    ----------
    features
        (n_samples, n_features) float64, NaN where a reading is missing, never infinite; a data frame gives
        its names too. A copy, but of an array with memory of its own that nobody can write to: such a float64
        array is kept as it is, with split "axis" also a float32 one, which stands for its values as float64.
    targets
        (n_samples,) what is to be predicted, an array or a series: the class of each sample, as values of
        `class_names`, or a finite number of each (then float64), as the loss has it.
    loss
        what a wrong prediction costs: `ClassCosts` (0/1 unless given a matrix, or costs of each sample),
        `SquaredError`, `AbsoluteError`, `QuantileError`.
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
    Which trees are allowed: see `octmip.trees.shape.Shape`, whose attributes a Problem has, too.
    Derived:
        codes: (n_samples,) the targets as the loss reads them: int64, index of each class in `class_names`; of
        numbers the targets.
    """

    features: NDArray[np.float64]
    targets: NDArray[Any]
    loss: Loss = field(kw_only=True, default=_DERIVED)
    weights: NDArray[np.float64] = field(kw_only=True, default=_DERIVED)
    takes_missing: bool = field(kw_only=True, default=False)
    feature_names: tuple[str, ...] = field(kw_only=True, default=_DERIVED)
    class_names: tuple[Any, ...] = field(kw_only=True, default=_DERIVED)
    class_order: tuple[Any, ...] = field(kw_only=True, default=_DERIVED)
    target_name: str = field(kw_only=True, default="target")
    codes: NDArray[Any] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        set_field(self, "loss", ClassCosts() if self.loss is None else self.loss)
        if not isinstance(self.loss, Loss):
            raise ProblemError(
                f"loss is {self.loss!r}; expected one of octmip's, such as ClassCosts() or SquaredError()"
            )
        self._set_samples()
        if self.loss.predicts == "class":
            self._set_classes()
        else:
            self._set_numbers()
        set_field(self, "weights", weights_of(self.weights, self.n_samples))
        self._settle(self.feature_names, self.n_samples)
        self._check_leaf_weight(math.fsum(self.weights), self.has_sample_costs)
        if self.any_depth:
            self._end_depth(self.baseline + self.most_asked_splits * self.leaf_penalty, self.n_samples)
        if self.leaf_model == "linear" and self.loss.predicts == "class":
            raise ProblemError("leaf_model is 'linear' but the loss is one of classes; leave leaf_model out")
        if self.monotone is not None and self.loss.predicts == "class":
            refuse_without_order(self.class_order, self.class_names)
        if self.monotone is not None and self.takes_missing:
            raise ProblemError("monotone is given but readings may be missing, which have no order; fill them in")
        prices = self.leaf_penalty * min(2**self.depth - 1, self.n_samples) * self.max_split_size
        self.loss.check_range(self.weights, self.codes, prices)

    def _set_samples(self) -> None:
        given = self.feature_names if self.feature_names is not None else names_of_columns(self.features)
        kept = KEPT if self.split == "axis" and self.loss.predicts == "class" else KEPT[:1]
        features = features_of(self.features, takes_missing=True, kept=kept)
        if min(features.shape) == 0:
            raise ProblemError(f"features has shape {features.shape}; expected at least one sample and one feature")
        set_field(self, "features", features)
        set_field(self, "takes_missing", bool(self.takes_missing) or self.n_missing > 0)
        set_field(self, "feature_names", feature_names_of(given, features.shape[1]))

    def _set_classes(self) -> None:
        assert isinstance(self.loss, ClassCosts)
        found = classes_of(self.targets, self.class_names, self.class_order, self.n_samples)
        for name, value in zip(("targets", "class_names", "class_order", "codes"), found, strict=True):
            set_field(self, name, value)
        set_field(self, "loss", self.loss.over(self.class_names, self.n_samples))

    def _set_numbers(self) -> None:
        for name in ("class_names", "class_order"):
            if given := getattr(self, name):
                raise ProblemError(f"{name} is {given} but {self.loss} predicts numbers; leave it out")
        targets = numbers_to_predict(self.targets, self.n_samples)
        for name, value in {"targets": targets, "class_names": (), "class_order": (), "codes": targets}.items():
            set_field(self, name, value)

    def __repr__(self) -> str:
        counts = {"sample": self.n_samples, "feature": self.n_features}
        words = [f"{count} {noun}{'s' * (count != 1)}" for noun, count in counts.items()]
        words += [f"{self.n_classes} classes"] if self.class_names else [f"loss={self.loss!r}"]
        words += [f"depth={'any' if self.any_depth else self.depth}", f"split={self.split!r}"]
        usual = {"leaf_size": 1, "leaf_penalty": 0.0}
        sizes = "split_size", "leaf_size", "leaf_weight", "leaf_penalty", "max_splits", "sensor_budget"
        words += [f"{name}={getattr(self, name):g}" for name in sizes if getattr(self, name) != usual.get(name)]
        words += [] if self.leaf_model == "constant" else ["leaf_model='linear'"]
        words += [words_of_order(self.class_order)] if self.monotone is not None and self.class_order else []
        words += self.words_of_shape(self.feature_names)
        words += [f"{self.n_missing} readings missing"] if self.takes_missing else []
        words += [] if (self.weights == 1).all() else ["weighted"]
        words += [] if not isinstance(self.loss, ClassCosts) or self.loss.is_zero_one else ["with costs"]
        return f"Problem({', '.join(words)})"

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return int(self.features.shape[0])

    @property
    def n_features(self) -> int:
        """Number of features."""
        return len(self.sensor_index)

    @property
    def n_missing(self) -> int:
        """Number of readings that are missing."""
        return sum(int(np.isnan(block).sum()) for block in in_blocks(self.features))

    @property
    def features_with_missing(self) -> tuple[int, ...]:
        """The features of which some reading is missing, ascending."""
        with_missing = np.zeros(self.features.shape[1], dtype=np.bool_)
        for block in in_blocks(self.features):
            with_missing |= np.isnan(block).any(axis=0)
        return tuple(np.flatnonzero(with_missing).tolist())

    @property
    def n_classes(self) -> int:
        """Number of classes, those of `class_names` without a sample included."""
        return len(self.class_names)

    @property
    def costs(self) -> NDArray[np.float64]:
        """The cost matrix (n_classes, n_classes); a ProblemError of numbers, and of costs of single samples."""
        return self._class_costs.matrix

    @property
    def has_sample_costs(self) -> bool:
        """Whether costs are those of single samples."""
        return isinstance(self.loss, ClassCosts) and self.loss.per_sample

    @property
    def cost_table(self) -> NDArray[np.float64]:
        """Costs (n_rows, n_classes), a row for each class or for each sample; a ProblemError of numbers."""
        return self._class_costs.table

    @property
    def _class_costs(self) -> ClassCosts:
        if not isinstance(self.loss, ClassCosts):
            raise ProblemError(f"{self.loss} is a loss of numbers; this question needs classes")
        return self.loss

    @property
    def cost_rows(self) -> NDArray[Any]:
        """The row (n_samples,) of `cost_table` that each sample pays by; of numbers the targets."""
        return np.arange(self.n_samples) if self.has_sample_costs else self.codes

    @property
    def _loss_of_rows(self) -> Loss:
        """The loss, to be asked with `cost_rows`."""
        return self.loss.by_row if isinstance(self.loss, ClassCosts) and self.loss.per_sample else self.loss

    @property
    def number_loss(self) -> NumberLoss:
        """The loss, of numbers; a ProblemError of classes."""
        if not isinstance(self.loss, NumberLoss):
            raise ProblemError("the loss is one of classes; this question needs numbers")
        return self.loss

    @property
    def has_integer_costs(self) -> bool:
        """Whether every objective is an integer, so that bounds may be rounded up and compared with ``==``."""
        return self.leaf_penalty == math.floor(self.leaf_penalty) and self.loss.has_whole_costs(self.weights)

    @property
    def least_saving(self) -> float:
        """Least cost that one sample's best label, or one split fewer, saves; +inf if neither saves any.

        A proof whose tolerance is not below it cannot tell a tree from one that answers a sample better.
        """
        saved = self._class_costs.least_saving(self.weights, self.cost_rows)
        return float(min(saved, self.leaf_penalty or math.inf))

    def least_saving_from(self, objective: float) -> float:
        """Return the least that a tree must save to be called better than one of this objective.

        Of classes `least_saving`. Errors of real numbers may differ by as little as one likes, so no tolerance tells
        all trees apart: of numbers it is a hundred-millionth of the objective. A proof whose tolerance is not below it
        is none: see `octmip.trees.solution.closing_tolerance`.
        """
        return self.least_saving if self.loss.predicts == "class" else LEAST_SAVING * objective

    @property
    def words_of_saving(self) -> str:
        """What `least_saving_from` is, for a sentence."""
        if self.loss.predicts == "class":
            return "which one sample or split alone can save"
        return "a hundred-millionth of the tree's objective"

    @property
    def is_provable(self) -> bool:
        """Whether some solver has a proof for these trees: of numbers only where splits and leaves are plain."""
        return self.loss.predicts == "class" or (self.max_split_size == 1 and self.leaf_model == "constant")

    @property
    def baseline(self) -> float:
        """Objective of the best tree without a split: B&D's baseline error, by which they normalise."""
        if self.loss.predicts == "class":
            return float(self.class_costs().min())
        return self.objective(self.best_leaf())

    def class_costs(self, rows: NDArray[np.int64] | None = None) -> NDArray[np.float64]:
        """Return the cost of predicting each class for all the samples (or those of `rows`), shape (n_classes,)."""
        of_rows = self.cost_rows if rows is None else self.cost_rows[rows]
        weights = self.weights if rows is None else self.weights[rows]
        table = self.cost_table
        sums = np.bincount(of_rows, weights, len(table))
        present = np.flatnonzero(sums) if len(table) > MANY_ROWS else slice(None)  # a node has few of many classes
        return np.asarray(sums[present] @ table[present])

    def best_leaf(self, rows: NDArray[np.int64] | slice = slice(None)) -> Leaf:
        """Return the leaf that predicts these samples (all of them) at the least cost by one value."""
        value = self._loss_of_rows.best_value(self.weights[rows], self.cost_rows[rows])
        return Leaf(int(value)) if self.loss.predicts == "class" else ValueLeaf(value)

    def leaf_and_cost(self, rows: NDArray[np.int64]) -> tuple[Leaf, float]:
        """Return the best leaf for some samples and what it costs there, of numbers summed in float64."""
        if isinstance(self.loss, NumberLoss):
            leaf = self.best_leaf(rows)
            assert isinstance(leaf, ValueLeaf)
            return leaf, float(self.weights[rows] @ self.loss.of_misses(self.codes[rows] - leaf.value))
        costs = self.class_costs(rows)
        return Leaf(int(costs.argmin())), float(costs.min())

    def of_rows(self, rows: NDArray[Any], **others: Any) -> "Problem":
        """Return the problem of some samples: `rows` are indices in their order, or a mask; `others` other fields."""
        kept = {name: getattr(self, name)[rows] for name in ("features", "targets", "weights")}
        return replace(self, **{**kept, **others})

    def with_best_leaves(self, tree: Node) -> Node:
        """Return the tree with the best value in every leaf; samples must reach each."""
        reached = leaf_index(tree, self.features)
        fitted = iter([self.best_leaf(np.flatnonzero(reached == k)) for k in range(len(leaves(tree)))])
        return with_leaves(tree, fitted)

    def with_sides(self, tree: Node) -> Node:
        """Return a tree with a side for missing readings at every split, where this problem may lack some."""
        return with_sides_for_missing(tree, self.features, self.weights) if self.takes_missing else tree

    def predictions(self, tree: Node) -> NDArray[Any]:
        """Return what a tree predicts for every sample (n_samples,): as `codes`, classes by index or numbers."""
        return predict(tree, self.features) if self.loss.predicts == "class" else predict_values(tree, self.features)

    def objective(self, tree: Node) -> float:
        """Return the objective of a tree, every sample routed."""
        return self.objective_of(tree, self.predictions(tree))

    def objective_of(self, tree: Node, predicted: NDArray[Any]) -> float:
        """Return the objective of a tree whose predictions (n_samples,) are known."""
        return self._loss_of_rows.cost(self.weights, self.cost_rows, predicted, self._prices(tree))

    def exact_objective(self, tree: Node) -> Fraction:
        """Return the objective of a tree as a rational number: nothing is rounded."""
        paid = self._loss_of_rows.exact_cost(self.weights, self.cost_rows, self.predictions(tree))
        return paid + self._prices(tree)

    def _prices(self, tree: Node) -> Fraction:
        return Fraction(self.leaf_penalty) * complexity(tree)

    @property
    def limited_splits(self) -> int | None:
        """`max_splits` where it rules out trees that the depth allows, else None."""
        every = (2**self.depth - 1) * self.max_split_size
        return None if self.max_splits is None or self.max_splits >= every else self.max_splits

    @property
    def is_shaped(self) -> bool:
        """Whether trees are limited by more than levels, leaf sizes and what a split may read."""
        return self.limited_splits is not None or self.monotone is not None or self.has_parts

    @property
    def is_leaf_allowed(self) -> bool:
        """Whether a tree without a split has the parts that are asked for."""
        if not self.has_parts:
            return True
        gone = 0 if self.old_tree is None else len(splits(self.old_tree))
        return all(not part.features for part in self.given_splits) and gone <= (self.max_changes or 0)

    @property
    def most_asked_splits(self) -> int:
        """So many splits at most have to stand, 0 where a leaf is a tree: the best leaf and their price bound the best.

        They are the given ones, those above them, and those of the old tree: a tree that has the parts still has them
        once all other splits are pruned, lowest first, and no leaf of it costs more than the best single leaf did.
        """
        if self.is_leaf_allowed:
            return 0
        given = {part.path[:k] for part in self.given_splits for k in range(len(part.path) + 1)}
        return len(given) + (0 if self.old_tree is None else len(splits(self.old_tree)))

    @property
    def max_split_size(self) -> int:
        """Most features that one split may have."""
        return 1 if self.split == "axis" else min(self.split_size or self.n_features, self.n_features)

    def is_allowed(self, features: tuple[int, ...]) -> bool:
        """Whether these features may meet in one split."""
        if len(features) > self.max_split_size:
            return False
        return self.allowed_splits is None or any(set(features) <= set(group) for group in self.allowed_splits)

    def sensors_used(self, tree: Node) -> tuple[str, ...]:
        """Return the names of the sensors that a tree reads, in the order of `sensors`."""
        used = {int(self.sensor_index[feature]) for feature in features_used(tree)}
        return tuple(self.sensors[s] for s in sorted(used))

    def sensor_cost_of(self, tree: Node) -> float:
        """Return the total cost of the sensors that a tree reads, each paid once."""
        used = {int(self.sensor_index[feature]) for feature in features_used(tree)}
        return math.fsum(self.sensor_costs[s] for s in used)

    def measures(self, predicted: NDArray[Any]) -> Mapping[str, float]:
        """Return what people judge predictions (n_samples,) of the samples by: see `Loss.measures`."""
        return self.loss.measures(self.weights, self.codes, predicted)

    def digest(self) -> str:
        """Return the sha256 of the training data (features, targets, weights), as a tree file records it."""
        sha = hashlib.sha256()
        per_sample = (self.cost_table,) if self.has_sample_costs else ()  # they are data, not a question
        for array in (self.features, self.codes, self.weights, *per_sample):
            sha.update(str(array.shape).encode())
            for block in in_blocks(array):  # float32 readings as the float64 that they stand for
                sha.update(block.astype(np.float64 if block.dtype.kind == "f" else block.dtype).tobytes())
        is_class = self.loss.predicts == "class"
        sha.update((repr([str(name) for name in self.class_names]) if is_class else self.loss.spelling).encode())
        return sha.hexdigest()
