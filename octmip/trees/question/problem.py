"""Problem: everything that says which tree is wanted, checked once, here.

minimise   sum_i weights_i * loss(target_i, predicted_i) + leaf_penalty * complexity(tree)
over       trees of at most `depth` levels of splits (or of any), every leaf with at least `leaf_size` samples
           (or `leaf_weight`), at most `split_size` features per split, total sensor cost at most `sensor_budget`;
           where readings are missing, each split sends them to one side, of its own choice
"""

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from difflib import get_close_matches
from fractions import Fraction
from typing import Any, Literal, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.trees.nodes.tree import (
    Leaf,
    Node,
    ValueLeaf,
    complexity,
    leaf_index,
    leaves,
    predict,
    predict_values,
    with_sides_for_missing,
)
from octmip.trees.question.classes import refuse_without_order, words_of_order
from octmip.trees.question.losses import ClassCosts, Loss, NumberLoss
from octmip.trees.question.parts import GivenSplit, PathRule
from octmip.trees.question.problem_values import in_blocks, set_field
from octmip.trees.question.samples import Samples
from octmip.trees.question.shape import Shape, with_leaves

MANY_ROWS = 64
LEAST_SAVING = 1e-8
"""Share of the objective of a tree of numbers that another must save to be called better."""


class ShapeKeywords(TypedDict, total=False):
    """What a Problem may be given of its `Shape`."""

    depth: int | None
    split: Literal["axis", "hyperplane"]
    split_size: int | None
    leaf_size: int
    leaf_weight: float | None
    leaf_penalty: float
    sensor_of_feature: Mapping[str, str] | Sequence[str] | None
    sensor_cost: Mapping[str, float] | Sequence[float] | None
    sensor_budget: float | None
    allowed_splits: Sequence[Sequence[str | int]] | None
    leaf_model: Literal["constant", "linear"]
    ridge: float
    integer_normals: int | None
    max_splits: int | None
    monotone: Mapping[str | int, str | int] | Sequence[int] | None
    fixed_splits: Mapping[str, Any] | tuple[GivenSplit, ...] | None
    path_rules: Sequence[Sequence[str | int]] | tuple[PathRule, ...] | None
    old_tree: Node | None
    max_changes: int | None


def _refuse_unknown_keywords(given: Iterable[str]) -> None:
    known = list(ShapeKeywords.__annotations__)
    for name in given:
        if name not in known:
            near = get_close_matches(name, known, n=1)
            cure = f"write {near[0]}" if near else f"expected one of {', '.join(known)}, or of the samples"
            raise TypeError(f"Problem takes no {name!r}; {cure}")


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Problem:
    """Samples, which trees are allowed, and the loss of a prediction.

    Attributes
    ----------
    samples
        the rows with their targets and weights, named.
    shape
        which trees are allowed.
    loss
        what a wrong prediction costs, settled for these classes and rows.
    """

    samples: Samples
    shape: Shape
    loss: Loss

    def __init__(
        self,
        features: ArrayLike,
        targets: ArrayLike,
        *,
        loss: Loss | None = None,
        weights: ArrayLike | None = None,
        takes_missing: bool = False,
        feature_names: Sequence[str] | None = None,
        class_names: Sequence[Any] | None = None,
        class_order: Sequence[Any] | None = None,
        target_name: str = "target",
        **shape: Unpack[ShapeKeywords],
    ) -> None:
        """Check what was given and fill in what was left out.

        Parameters
        ----------
        features, targets, weights, takes_missing, feature_names, class_names, class_order, target_name
            see `octmip.trees.question.samples.Samples`.
        loss
            `ClassCosts` (0/1 unless given a matrix, or costs of each sample), which None stands for, `SquaredError`,
            `AbsoluteError`, `QuantileError`.
        shape
            by keyword, `depth=3`: see `octmip.trees.question.shape.Shape`.

        Raises
        ------
        ProblemError
            something is no such thing, or does not go together.
        TypeError
            a keyword is none of these.

        Examples
        --------
        >>> Problem([[0.0], [1.0], [2.0]], ["low", "low", "high"], depth=1)
        Problem(3 samples, 1 feature, 2 classes, depth=1, split='axis')
        """
        _refuse_unknown_keywords(shape)
        loss = ClassCosts() if loss is None else loss
        if not isinstance(loss, Loss):
            raise ProblemError(f"loss is {loss!r}; expected one of octmip's, such as ClassCosts() or SquaredError()")
        names: Any = {"feature_names": feature_names, "class_names": class_names, "class_order": class_order}
        data: Any = {"features": features, "targets": targets, "weights": weights, "takes_missing": takes_missing}
        is_axis = shape.get("split", "axis") == "axis"
        samples = Samples(**data, **names, target_name=target_name, predicts=loss.predicts, is_axis=is_axis)
        if isinstance(loss, ClassCosts):
            loss = loss.over(samples.class_names, samples.n_samples)
        settings: Any = shape
        set_field(self, "samples", samples)
        set_field(self, "loss", loss)
        set_field(self, "shape", Shape(**settings, feature_names=samples.feature_names, n_samples=samples.n_samples))
        self._check_together()

    def _check_together(self) -> None:
        """Check samples, shape and loss beside each other, and end the depth of trees of any."""
        samples, shape = self.samples, self.shape
        shape.check_leaf_weight(math.fsum(samples.weights), self.has_sample_costs)
        if shape.any_depth:
            shape.end_depth(self.baseline + shape.most_asked_splits * shape.leaf_penalty, samples.n_samples)
        if shape.leaf_model == "linear" and self.loss.predicts == "class":
            raise ProblemError("leaf_model is 'linear' but the loss is one of classes; leave leaf_model out")
        if shape.monotone is not None and self.loss.predicts == "class":
            refuse_without_order(samples.class_order, samples.class_names)
        if shape.monotone is not None and samples.takes_missing:
            raise ProblemError("monotone is given but readings may be missing, which have no order; fill them in")
        prices = shape.leaf_penalty * min(2**shape.depth - 1, samples.n_samples) * shape.max_split_size
        self.loss.check_range(samples.weights, samples.codes, prices)

    def __repr__(self) -> str:
        samples, shape = self.samples, self.shape
        counts = {"sample": samples.n_samples, "feature": samples.n_features}
        words = [f"{count} {noun}{'s' * (count != 1)}" for noun, count in counts.items()]
        words += [f"{samples.n_classes} classes"] if samples.class_names else [f"loss={self.loss!r}"]
        words += [f"depth={'any' if shape.any_depth else shape.depth}", f"split={shape.split!r}"]
        usual = {"leaf_size": 1, "leaf_penalty": 0.0}
        sizes = "split_size", "leaf_size", "leaf_weight", "leaf_penalty", "max_splits", "sensor_budget"
        words += [f"{name}={getattr(shape, name):g}" for name in sizes if getattr(shape, name) != usual.get(name)]
        words += [] if shape.leaf_model == "constant" else ["leaf_model='linear'"]
        words += [words_of_order(samples.class_order)] if shape.monotone is not None and samples.class_order else []
        words += shape.words(samples.feature_names)
        words += [f"{samples.n_missing} readings missing"] if samples.takes_missing else []
        words += [] if (samples.weights == 1).all() else ["weighted"]
        words += [] if not isinstance(self.loss, ClassCosts) or self.loss.is_zero_one else ["with costs"]
        return f"Problem({', '.join(words)})"

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
        return np.arange(self.samples.n_samples) if self.has_sample_costs else self.samples.codes

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
        has_whole_prices = self.shape.leaf_penalty == math.floor(self.shape.leaf_penalty)
        return has_whole_prices and self.loss.has_whole_costs(self.samples.weights)

    @property
    def least_saving(self) -> float:
        """Least cost that one sample's best label, or one split fewer, saves; +inf if neither saves any.

        A proof whose tolerance is not below it cannot tell a tree from one that answers a sample better.
        """
        saved = self._class_costs.least_saving(self.samples.weights, self.cost_rows)
        return float(min(saved, self.shape.leaf_penalty or math.inf))

    def least_saving_from(self, objective: float) -> float:
        """Return the least that a tree must save to be called better than one of this objective.

        Of classes `least_saving`. Errors of real numbers may differ by as little as one likes, so no tolerance tells
        all trees apart: of numbers it is a hundred-millionth of the objective. A proof whose tolerance is not below it
        is none: see `octmip.trees.answer.solution.closing_tolerance`.
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
        return self.loss.predicts == "class" or (self.shape.max_split_size == 1 and self.shape.leaf_model == "constant")

    @property
    def baseline(self) -> float:
        """Objective of the best tree without a split: B&D's baseline error, by which they normalise."""
        if self.loss.predicts == "class":
            return float(self.class_costs().min())
        return self.objective(self.best_leaf())

    @property
    def bound_by_labels(self) -> float:
        """What trees cost at least because they name no more classes than they have leaves; 0 where that says nothing.

        Rounded down, and true of splits of either kind, whatever else is asked for. Example: of five classes with 350
        samples each a tree of depth 1 has two leaves, and errs on 1,050 samples or more.
        """
        shape, k = self.shape, len(self.samples.class_names)
        most_splits = math.inf if shape.max_splits is None else shape.max_splits
        n_leaves = min(1 << min(shape.depth, 40), most_splits + 1, k)
        is_told = self.loss.predicts == "class" and not self.has_sample_costs
        if not is_told or (n_leaves == k and not shape.leaf_penalty):
            return 0.0
        least = self._class_costs.least_of_labels(self.samples.weights, self.samples.codes, int(n_leaves))
        bound = min(cost + shape.leaf_penalty * n for n, cost in enumerate(least))
        is_exact = self.has_integer_costs and bound < 2**53
        rounding = 0.0 if is_exact else 4 * (self.samples.n_samples + k) * math.ulp(1.0)
        return max(0.0, bound * (1.0 - rounding))

    def class_costs(self, rows: NDArray[np.int64] | None = None) -> NDArray[np.float64]:
        """Return the cost of predicting each class for all the samples (or those of `rows`), shape (n_classes,)."""
        of_rows = self.cost_rows if rows is None else self.cost_rows[rows]
        weights = self.samples.weights if rows is None else self.samples.weights[rows]
        table = self.cost_table
        sums = np.bincount(of_rows, weights, len(table))
        present = np.flatnonzero(sums) if len(table) > MANY_ROWS else slice(None)  # a node has few of many classes
        return np.asarray(sums[present] @ table[present])

    def best_leaf(self, rows: NDArray[np.int64] | slice = slice(None)) -> Leaf:
        """Return the leaf that predicts these samples (all of them) at the least cost by one value."""
        value = self._loss_of_rows.best_value(self.samples.weights[rows], self.cost_rows[rows])
        return Leaf(int(value)) if self.loss.predicts == "class" else ValueLeaf(value)

    def leaf_and_cost(self, rows: NDArray[np.int64]) -> tuple[Leaf, float]:
        """Return the best leaf for some samples and what it costs there, of numbers summed in float64."""
        if isinstance(self.loss, NumberLoss):
            leaf = self.best_leaf(rows)
            assert isinstance(leaf, ValueLeaf)
            return leaf, float(self.samples.weights[rows] @ self.loss.of_misses(self.samples.codes[rows] - leaf.value))
        costs = self.class_costs(rows)
        return Leaf(int(costs.argmin())), float(costs.min())

    def replace(self, **changes: Any) -> "Problem":
        """Return the problem with other values of some keywords that a Problem takes."""
        given: Any = {one.name: getattr(self.shape, one.name) for one in fields(self.shape) if one.init}
        if changes.keys() <= given.keys() - {"split"}:  # what splits read says how the samples are kept
            return self._of_shape({**given, **changes})
        given |= {one.name: getattr(self.samples, one.name) for one in fields(self.samples) if one.init}
        return Problem(**{**given, "loss": self.loss, **changes})

    def _of_shape(self, settings: Any) -> "Problem":
        """Return the problem of the same samples, which were checked before, and another shape."""
        problem, samples = object.__new__(Problem), self.samples
        shape = Shape(**settings, feature_names=samples.feature_names, n_samples=samples.n_samples)
        for name, part in {"samples": samples, "loss": self.loss, "shape": shape}.items():
            set_field(problem, name, part)
        problem._check_together()
        return problem

    def of_rows(self, rows: NDArray[Any], **others: Any) -> "Problem":
        """Return the problem of some samples: `rows` are indices in their order, or a mask; `others` other keywords."""
        kept = {name: getattr(self.samples, name)[rows] for name in ("features", "targets", "weights")}
        return self.replace(**{**kept, **others})

    def with_best_leaves(self, tree: Node) -> Node:
        """Return the tree with the best value in every leaf; samples must reach each."""
        reached = leaf_index(tree, self.samples.features)
        fitted = iter([self.best_leaf(np.flatnonzero(reached == k)) for k in range(len(leaves(tree)))])
        return with_leaves(tree, fitted)

    def with_sides(self, tree: Node) -> Node:
        """Return a tree with a side for missing readings at every split, where this problem may lack some."""
        samples = self.samples
        return with_sides_for_missing(tree, samples.features, samples.weights) if samples.takes_missing else tree

    def predictions(self, tree: Node) -> NDArray[Any]:
        """Return what a tree predicts for every sample (n_samples,): as `codes`, classes by index or numbers."""
        predicted = predict if self.loss.predicts == "class" else predict_values
        return predicted(tree, self.samples.features)

    def objective(self, tree: Node) -> float:
        """Return the objective of a tree, every sample routed."""
        return self.objective_of(tree, self.predictions(tree))

    def objective_of(self, tree: Node, predicted: NDArray[Any]) -> float:
        """Return the objective of a tree whose predictions (n_samples,) are known."""
        return self._loss_of_rows.cost(self.samples.weights, self.cost_rows, predicted, self._prices(tree))

    def exact_objective(self, tree: Node) -> Fraction:
        """Return the objective of a tree as a rational number: nothing is rounded."""
        paid = self._loss_of_rows.exact_cost(self.samples.weights, self.cost_rows, self.predictions(tree))
        return paid + self._prices(tree)

    def _prices(self, tree: Node) -> Fraction:
        return Fraction(self.shape.leaf_penalty) * complexity(tree)

    def measures(self, predicted: NDArray[Any]) -> Mapping[str, float]:
        """Return what people judge predictions (n_samples,) of the samples by: see `Loss.measures`."""
        return self.loss.measures(self.samples.weights, self.samples.codes, predicted)

    def digest(self) -> str:
        """Return the sha256 of the training data (features, targets, weights), as a tree file records it."""
        sha, samples = hashlib.sha256(), self.samples
        per_sample = (self.cost_table,) if self.has_sample_costs else ()  # they are data, not a question
        for array in (samples.features, samples.codes, samples.weights, *per_sample):
            sha.update(str(array.shape).encode())
            for block in in_blocks(array):  # float32 readings as the float64 that they stand for
                sha.update(block.astype(np.float64 if block.dtype.kind == "f" else block.dtype).tobytes())
        is_class = self.loss.predicts == "class"
        sha.update((repr([str(name) for name in samples.class_names]) if is_class else self.loss.spelling).encode())
        return sha.hexdigest()
