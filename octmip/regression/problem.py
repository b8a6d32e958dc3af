"""RegressionProblem: which regression tree is wanted, checked once, here.

minimise   sum_i weights_i * |targets_i - predicted_i|^q + leaf_penalty * complexity(tree)
           q = 2 (loss "squared") or 1 (loss "absolute"); each leaf predicts one number
over       trees of at most `depth` levels of splits, every leaf with at least `leaf_size` samples,
           total sensor cost at most `sensor_budget`
"""

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.problem_values import features_of, names_of_columns, number_of, numbers_of, sensor_costs_of, whole_of
from octmip.regression.exact_sums import best_constant, sum_of_errors
from octmip.tree import Leaf, Node, ValueLeaf, complexity, features_used, leaf_index, leaves, predict_values, splits

Loss = Literal["squared", "absolute"]
LOSSES: tuple[Loss, ...] = ("squared", "absolute")
_DERIVED: Any = None  # a field that is filled in when it is left out
MAX_DEPTH = 30
LEAST_SAVING = 1e-8
"""Share of the objective of a tree that another must save to be called better."""
LEAST_SIZE, MOST_SIZE = 1e-120, 1e120
"""Targets differ by this much, weights add up to this much: squares of float64 are numbers then."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RegressionProblem:
    """A regression problem and the tree that is wanted of it.

    Attributes
    ----------
    features
        (n_samples, n_features) float64, finite; a data frame gives its names too.
    targets
        (n_samples,) float64, finite: the number to predict.
    depth
        levels of splits, 1 or more.
    loss
        "squared" or "absolute" error.
    split
        "axis" (one feature and a threshold) or "hyperplane" (by search, without a proof).
    split_size
        at most so many features in one split; None: no limit (1 for "axis").
    leaf_model
        "constant", or "linear": each leaf predicts by a ridge regression of its samples (by search, without a proof).
    ridge
        share of the leaf's own variance that the ridge of a linear leaf adds to every feature's.
    leaf_size
        at least so many samples in every leaf.
    leaf_penalty
        price of one feature in one split, in units of the error.
    weights
        (n_samples,) weight of each sample's error, 0 or more; None: all 1.
    sensor_of_feature, sensor_cost, sensor_budget
        as in `octmip.Problem`.
    feature_names
        (n_features,); None: the names of the data frame's columns, of an array x0, x1, ...
    target_name
        for tables and pages.
    Derived:
        sensors: names of the sensors in the order of their first feature.
        sensor_index: (n_features,) int64, index in `sensors`.
        sensor_costs: (n_sensors,) float64.
    """

    features: NDArray[np.float64]
    targets: NDArray[np.float64]
    depth: int = field(kw_only=True)
    loss: Loss = field(kw_only=True, default="squared")
    split: Literal["axis", "hyperplane"] = field(kw_only=True, default="axis")
    split_size: int | None = field(kw_only=True, default=None)
    leaf_model: Literal["constant", "linear"] = field(kw_only=True, default="constant")
    ridge: float = field(kw_only=True, default=1e-3)
    leaf_size: int = field(kw_only=True, default=1)
    leaf_penalty: float = field(kw_only=True, default=0.0)
    weights: NDArray[np.float64] = field(kw_only=True, default=_DERIVED)
    sensor_of_feature: Sequence[str] | None = field(kw_only=True, default=None)
    sensor_cost: Mapping[str, float] | Sequence[float] | None = field(kw_only=True, default=None)
    sensor_budget: float | None = field(kw_only=True, default=None)
    feature_names: tuple[str, ...] = field(kw_only=True, default=_DERIVED)
    target_name: str = field(kw_only=True, default="target")
    sensors: tuple[str, ...] = field(init=False, repr=False)
    sensor_index: NDArray[np.int64] = field(init=False, repr=False)
    sensor_costs: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._set_samples()
        self._set_sensors()
        self._check_tree_limits()
        self._check_range()

    def _set(self, name: str, value: object) -> None:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        object.__setattr__(self, name, value)

    def _set_samples(self) -> None:
        given = self.feature_names if self.feature_names is not None else names_of_columns(self.features)
        features = features_of(self.features)
        if min(features.shape) == 0:
            raise ProblemError(f"features has shape {features.shape}; expected at least one sample and one feature")
        self._set("features", features)
        names = tuple(str(name) for name in ([f"x{j}" for j in range(features.shape[1])] if given is None else given))
        if len(names) != features.shape[1] or len(set(names)) != len(names):
            raise ProblemError(
                f"feature_names has {len(names)} entries ({len(set(names))} different) but features has "
                f"{features.shape[1]} columns; give one name for each column, none twice"
            )
        self._set("feature_names", names)
        for name, values in (("targets", self.targets), ("weights", self.weights)):
            numbers = np.ones(self.n_samples) if values is None else numbers_of(values, name, 1)
            if numbers.shape != (self.n_samples,):
                raise ProblemError(
                    f"{name} has {len(numbers)} entries but features has {self.n_samples} rows; give one each"
                )
            self._set(name, numbers)
        if (self.weights < 0).any() or not self.weights.any():
            raise ProblemError(
                f"weights go from {self.weights.min()} to {self.weights.max()}; expected 0 or more, not all 0"
            )

    def _set_sensors(self) -> None:
        names = self.feature_names if self.sensor_of_feature is None else self.sensor_of_feature
        of_feature = tuple(str(name) for name in names)
        if len(of_feature) != self.n_features:
            raise ProblemError(
                f"sensor_of_feature has {len(of_feature)} entries but there are {self.n_features} features; "
                "give one each"
            )
        sensors = tuple(dict.fromkeys(of_feature))
        position = {name: s for s, name in enumerate(sensors)}
        self._set("sensor_of_feature", of_feature)
        self._set("sensors", sensors)
        self._set("sensor_index", np.array([position[name] for name in of_feature], dtype=np.int64))
        self._set("sensor_costs", sensor_costs_of(self.sensor_cost, sensors))
        if self.sensor_budget is not None:
            self._set("sensor_budget", number_of(self.sensor_budget, "sensor_budget"))

    def _check_tree_limits(self) -> None:
        self._set("depth", whole_of(self.depth, "depth", 1, MAX_DEPTH))
        self._set("leaf_size", whole_of(self.leaf_size, "leaf_size", 1, self.n_samples))
        self._set("leaf_penalty", number_of(self.leaf_penalty, "leaf_penalty"))
        self._set("ridge", number_of(self.ridge, "ridge"))
        choices = {"loss": LOSSES, "split": ("axis", "hyperplane"), "leaf_model": ("constant", "linear")}
        for name, known in choices.items():
            if getattr(self, name) not in known:
                raise ProblemError(f"{name} is {getattr(self, name)!r}; expected one of {', '.join(known)}")
        if self.split == "axis" and self.split_size not in (None, 1):
            raise ProblemError(f"split_size is {self.split_size} but split is 'axis'; say split='hyperplane' for more")
        if self.split_size is not None:
            self._set("split_size", whole_of(self.split_size, "split_size", 1, None))

    def _check_range(self) -> None:
        """Every error is a number of float64 that is not rounded to 0."""
        span = float(self.targets.max() / 2 - self.targets.min() / 2)
        total = float(np.clip(self.weights, 0, 1e300).sum())
        size = max(float(np.abs(self.targets).max()), self.leaf_penalty)
        if not LEAST_SIZE <= total <= MOST_SIZE or size > MOST_SIZE or 0 < span < LEAST_SIZE:
            raise ProblemError(
                f"targets from {self.targets.min()} to {self.targets.max()}, weights of {total} in all, leaf_penalty "
                f"{self.leaf_penalty}: expected sizes from {LEAST_SIZE:g} to {MOST_SIZE:g}; scale them"
            )

    def __repr__(self) -> str:
        words = [f"{self.n_samples} samples", f"{self.n_features} features", f"depth={self.depth}"]
        words += [f"loss={self.loss!r}"]
        usual = {"split": "axis", "leaf_model": "constant", "leaf_size": 1, "leaf_penalty": 0.0, "sensor_budget": None}
        words += [f"{name}={getattr(self, name)!r}" for name, value in usual.items() if getattr(self, name) != value]
        words += [] if (self.weights == 1).all() else ["weighted"]
        return f"RegressionProblem({', '.join(words)})"

    @property
    def is_provable(self) -> bool:
        """Whether the exact core has a proof for these trees: one feature in a split, one number in a leaf."""
        return self.max_split_size == 1 and self.leaf_model == "constant"

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return int(self.features.shape[0])

    @property
    def n_features(self) -> int:
        """Number of features."""
        return int(self.features.shape[1])

    @property
    def max_split_size(self) -> int:
        """Most features that one split may have."""
        return 1 if self.split == "axis" else min(self.split_size or self.n_features, self.n_features)

    @property
    def baseline(self) -> float:
        """Objective of the best tree without a split."""
        return self.objective(self.best_leaf(np.arange(self.n_samples)))

    def least_saving(self, objective: float) -> float:
        """Return the least that a tree must save to be called better than one of this objective: 1e-8 of it.

        Errors of real numbers may differ by as little as one likes, so no tolerance tells all trees apart. A proof
        whose tolerance is not below this is none: see `octmip.solution.closing_tolerance`.
        """
        return LEAST_SAVING * objective

    def best_leaf(self, rows: NDArray[np.int64]) -> ValueLeaf:
        """Return the leaf that predicts these samples with the least error by one number, rounded once."""
        return ValueLeaf(best_constant(self.weights[rows], self.targets[rows], self.loss))

    def exact_error(self, tree: Node) -> Fraction:
        """Return the weighted error of a tree, its prices left out, as a rational number: nothing is rounded."""
        return sum_of_errors(self.weights, self.targets, predict_values(tree, self.features), self.loss)

    def exact_objective(self, tree: Node) -> Fraction:
        """Return the objective of a tree as a rational number."""
        return self.exact_error(tree) + Fraction(self.leaf_penalty) * complexity(tree)

    def objective(self, tree: Node) -> float:
        """Return the objective of a tree, every sample routed, rounded once."""
        return float(self.exact_objective(tree))

    def with_best_leaves(self, tree: Node) -> Node:
        """Return the tree with the best constant in every leaf; samples must reach each."""
        reached = leaf_index(tree, self.features)
        fitted = iter([self.best_leaf(np.flatnonzero(reached == k)) for k in range(len(leaves(tree)))])
        return _with_leaves(tree, fitted)

    def is_allowed(self, features: tuple[int, ...]) -> bool:
        """Whether these features may meet in one split."""
        return len(features) <= self.max_split_size

    def first_forbidden_split(self, tree: Node) -> str | None:
        """Return a sentence about the first split or leaf that this problem does not allow, None when there is none."""
        used = features_used(tree)
        if used and used[-1] >= self.n_features:
            return f"the tree reads feature {used[-1]} but the problem has {self.n_features} features"
        for split in splits(tree):
            if not self.is_allowed(split.features):
                return f"a split over {len(split.features)} features is not allowed (split_size {self.max_split_size})"
        for leaf in leaves(tree):
            if not isinstance(leaf, ValueLeaf):
                return f"a leaf predicts class {leaf.label}; expected a number in every leaf"
            if leaf.features and self.leaf_model == "constant":
                return f"a leaf is linear over features {leaf.features} but leaf_model is 'constant'"
        return None

    def sensors_used(self, tree: Node) -> tuple[str, ...]:
        """Return the names of the sensors that a tree reads, in the order of `sensors`."""
        used = {int(self.sensor_index[feature]) for feature in features_used(tree)}
        return tuple(self.sensors[s] for s in sorted(used))

    def sensor_cost_of(self, tree: Node) -> float:
        """Return the total cost of the sensors that a tree reads, each paid once."""
        used = {int(self.sensor_index[feature]) for feature in features_used(tree)}
        return math.fsum(self.sensor_costs[s] for s in used)

    @property
    def sensor_limit(self) -> float:
        """The budget with room for the rounding of decimal costs; +inf without a budget."""
        return math.inf if self.sensor_budget is None else self.sensor_budget + 1e-9 * max(1.0, self.sensor_budget)

    def digest(self) -> str:
        """Return the sha256 of the training data (features, targets, weights), as a tree file records it."""
        sha = hashlib.sha256()
        for array in (self.features, self.targets, self.weights):
            sha.update(str(array.shape).encode())
            sha.update(np.ascontiguousarray(array).tobytes())
        sha.update(self.loss.encode())
        return sha.hexdigest()


def _with_leaves(tree: Node, fitted: Iterator[ValueLeaf]) -> Node:
    if isinstance(tree, Leaf):
        return next(fitted)
    left = _with_leaves(tree.left, fitted)
    return replace(tree, left=left, right=_with_leaves(tree.right, fitted))
