"""Problem: everything that says which tree is wanted, checked once, here.

minimise   sum_i weights_i * loss(target_i, predicted_i) + leaf_penalty * complexity(tree)
over       trees of at most `depth` levels of splits (or of any), every leaf with at least `leaf_size` samples,
           at most `split_size` features per split, total sensor cost at most `sensor_budget`;
           where readings are missing, each split sends them to one side, of its own choice
"""

import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.losses import ClassCosts, Loss, NumberLoss
from octmip.trees.problem_values import (
    KEPT,
    distinct_labels,
    features_of,
    in_blocks,
    labels_of,
    names_of_columns,
    numbers_of,
)
from octmip.trees.shape import Shape, set_field
from octmip.trees.tree import (
    HyperplaneSplit,
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
        the classes in the order of the rows of a cost matrix; None: the sorted targets. Of numbers ().
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
        self._set_weights()
        self._settle(self.feature_names, self.n_samples, lambda: self.baseline)
        if self.leaf_model == "linear" and self.loss.predicts == "class":
            raise ProblemError("leaf_model is 'linear' but the loss is one of classes; leave leaf_model out")
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
        names = tuple(str(name) for name in ([f"x{j}" for j in range(features.shape[1])] if given is None else given))
        if len(names) != features.shape[1] or len(set(names)) != len(names):
            raise ProblemError(
                f"feature_names has {len(names)} entries ({len(set(names))} different) but features has "
                f"{features.shape[1]} columns; give one name for each column, none twice"
            )
        set_field(self, "feature_names", names)

    def _set_classes(self) -> None:
        targets = labels_of(self.targets)
        if targets.shape != (self.n_samples,):
            raise ProblemError(
                f"targets has shape {targets.shape} but features has {self.n_samples} rows; give one for each row"
            )
        present, inverse = distinct_labels(targets)
        if len(present if self.class_names is None else tuple(self.class_names)) < 2:
            raise ProblemError(f"targets holds one class only ({present[0]!r}); expected two or more")
        names = tuple(present) if self.class_names is None else tuple(self.class_names)
        position = {name: k for k, name in enumerate(names)}
        unknown = [label for label in present if label not in position]
        if unknown or len(position) != len(names):
            raise ProblemError(
                f"targets holds {unknown} which class_names {names} lacks (or names twice); name every class once"
            )
        assert isinstance(self.loss, ClassCosts)
        set_field(self, "targets", targets)
        set_field(self, "class_names", names)
        set_field(self, "codes", np.array([position[label] for label in present], dtype=np.int64)[inverse])
        set_field(self, "loss", self.loss.over(names, self.n_samples))

    def _set_numbers(self) -> None:
        if self.class_names:
            raise ProblemError(f"class_names is {self.class_names} but {self.loss} predicts numbers; leave it out")
        targets = numbers_of(self.targets, "targets", 1)
        if targets.shape != (self.n_samples,):
            raise ProblemError(
                f"targets has {len(targets)} entries but features has {self.n_samples} rows; give one for each row"
            )
        set_field(self, "targets", targets)
        set_field(self, "class_names", ())
        set_field(self, "codes", targets)

    def _set_weights(self) -> None:
        weights = np.ones(self.n_samples) if self.weights is None else numbers_of(self.weights, "weights", 1)
        if weights.shape != (self.n_samples,):
            raise ProblemError(
                f"weights has {len(weights)} entries but features has {self.n_samples} rows; give one each"
            )
        if (weights < 0).any():
            row = int(np.flatnonzero(weights < 0)[0])
            raise ProblemError(f"weights[{row}] is {weights[row]}; expected 0 or more")
        if not weights.any():
            raise ProblemError("all weights are 0; expected at least one positive weight")
        set_field(self, "weights", weights)

    def __repr__(self) -> str:
        words = [f"{self.n_samples} samples", f"{self.n_features} features"]
        words += [f"{self.n_classes} classes"] if self.class_names else [f"loss={self.loss!r}"]
        words += [f"depth={'any' if self.any_depth else self.depth}", f"split={self.split!r}"]
        usual = {"split_size": None, "leaf_size": 1, "leaf_penalty": 0.0, "max_splits": None, "sensor_budget": None}
        words += [f"{name}={getattr(self, name):g}" for name, value in usual.items() if getattr(self, name) != value]
        words += [] if self.leaf_model == "constant" else ["leaf_model='linear'"]
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
        table = self.cost_table
        excess = table - table.min(axis=1, keepdims=True)
        by_row = np.where(excess > 0, excess, np.inf).min(axis=1)
        lightest = np.full(len(table), np.inf)
        positive = self.weights > 0
        np.minimum.at(lightest, self.cost_rows[positive], self.weights[positive])
        pairs = zip(lightest.tolist(), by_row.tolist(), strict=True)
        # A product below the least float64 is something all the same.
        savings = [max(w * c, math.ulp(0.0)) for w, c in pairs if math.isfinite(w)]
        return float(min([*savings, self.leaf_penalty or math.inf]))

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
        return np.bincount(of_rows, weights, len(self.cost_table)) @ self.cost_table

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

    def with_best_leaves(self, tree: Node) -> Node:
        """Return the tree with the best value in every leaf; samples must reach each."""
        reached = leaf_index(tree, self.features)
        fitted = iter([self.best_leaf(np.flatnonzero(reached == k)) for k in range(len(leaves(tree)))])
        return _with_leaves(tree, fitted)

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

    def first_forbidden_split(self, tree: Node) -> str | None:
        """Return a sentence about the first split or leaf that this problem does not allow, None if there is none."""
        used = features_used(tree)
        if used and used[-1] >= self.n_features:
            return f"the tree reads feature {used[-1]} but the problem has {self.n_features} features"
        with_missing = set(self.features_with_missing) if self.takes_missing else set()
        for split in splits(tree):
            names = [self.feature_names[j] for j in split.features]
            if not self.is_allowed(split.features):
                return f"a split over {names} is not allowed (split_size {self.max_split_size}, allowed_splits)"
            if self.split == "axis" and isinstance(split, HyperplaneSplit):
                return f"a split over {names} is a hyperplane, which is not allowed: split is 'axis'"
            if isinstance(split, HyperplaneSplit) and not self.is_integral(split):
                return f"a split over {names} has coefficients {split.coefficients}, not integers within limits"
            if split.missing is None and with_missing.intersection(split.features):
                return f"a split over {names} has no side for missing readings, of which this problem has some"
        return next(filter(None, map(self._fault_of, leaves(tree))), None)

    def _fault_of(self, leaf: Leaf) -> str | None:
        if self.loss.predicts == "class":
            if isinstance(leaf, ValueLeaf):
                return f"a leaf predicts the number {leaf.value}; expected a class in every leaf"
            is_known = leaf.label < self.n_classes
            return (
                None if is_known else f"a leaf predicts class {leaf.label} but the problem has {self.n_classes} classes"
            )
        if not isinstance(leaf, ValueLeaf):
            return f"a leaf predicts class {leaf.label}; expected a number in every leaf"
        if leaf.features and self.leaf_model == "constant":
            return f"a leaf is linear over features {leaf.features} but leaf_model is 'constant'"
        return None

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


def _with_leaves(tree: Node, fitted: Iterator[Leaf]) -> Node:
    if isinstance(tree, Leaf):
        return next(fitted)
    left = _with_leaves(tree.left, fitted)
    return replace(tree, left=left, right=_with_leaves(tree.right, fitted))
