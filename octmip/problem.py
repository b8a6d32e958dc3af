"""Problem: everything that says which tree is wanted, checked once, here.

minimise   sum_i weights_i * costs[label_i, predicted_i] + leaf_penalty * complexity(tree)
over       trees of at most `depth` levels of splits, every leaf with at least `leaf_size` samples,
           at most `split_size` features per split, total sensor cost at most `sensor_budget`;
           where readings are missing, each split sends them to one side, of its own choice
"""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.problem_values import (
    KEPT,
    distinct_labels,
    features_of,
    in_blocks,
    labels_of,
    names_of_columns,
    number_of,
    numbers_of,
    sensor_costs_of,
    whole_of,
)
from octmip.tree import HyperplaneSplit, Node, complexity, features_used, predict, splits, with_sides_for_gaps

_DERIVED: Any = None  # a field that is filled in when it is left out
LEAST_COST, MOST_COST = 1e-280, 1e303  # of the worst tree
MAX_DEPTH = 30  # 2**30 leaves: beyond any use, and the node tables of the solvers are indexed by 32 bits


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Problem:
    """A classification problem and the tree that is wanted of it.

    Attributes
    ----------
    features
        (n_samples, n_features) float64, NaN where a reading is missing, never infinite; a data frame gives
        its names too. A copy, but of an array with memory of its own that nobody can write to: such a float64
        array is kept as it is, with split "axis" also a float32 one, which stands for its values as float64.
    labels
        (n_samples,) class of each sample, as values of `class_names`; an array or a series.
    depth
        levels of splits, 1 or more.
    split
        "axis" (one feature and a threshold) or "hyperplane".
    split_size
        at most so many features in one split; None: no limit (1 for "axis").
    leaf_size
        at least so many samples in every leaf.
    leaf_penalty
        price of one feature in one split (of a split, in an axis-aligned tree), in units of cost.
    weights
        (n_samples,) risk weights, 0 or more; None: all 1.
    costs
        (n_classes, n_classes) cost of predicting column k for a sample of class row i; None: 0/1.
    sensor_of_feature
        (n_features,) name of the sensor that a feature is read from; None: one sensor per feature,
        named like the feature.
    sensor_cost
        cost of each sensor, a mapping by name or one number per sensor in the order of `sensors`; None: 1.
    sensor_budget
        at most so much sensor cost in the whole tree; None: no limit.
    allowed_splits
        groups of features (names or indices) that may meet in one split; None: any may. A feature in
        no group is not used at all.
    integer_normals
        the coefficients of a hyperplane are integers of at most this size; None: real.
    gaps
        whether readings may be missing, so that every split says where they go; True wherever some of
        `features` are.
    feature_names
        (n_features,); None: the names of the data frame's columns, of an array x0, x1, ...
    class_names
        the classes in the order of the rows of `costs`; None: the sorted labels.
    Derived:
        codes: (n_samples,) int64, index of each label in `class_names`.
        sensors: names of the sensors in the order of their first feature.
        sensor_index: (n_features,) int64, index in `sensors`.
        sensor_costs: (n_sensors,) float64.
    """

    features: NDArray[np.float64]
    labels: NDArray[Any]
    depth: int = field(kw_only=True)
    split: Literal["axis", "hyperplane"] = field(kw_only=True, default="axis")
    split_size: int | None = field(kw_only=True, default=None)
    leaf_size: int = field(kw_only=True, default=1)
    leaf_penalty: float = field(kw_only=True, default=0.0)
    weights: NDArray[np.float64] = field(kw_only=True, default=_DERIVED)
    costs: NDArray[np.float64] = field(kw_only=True, default=_DERIVED)
    sensor_of_feature: Sequence[str] | None = field(kw_only=True, default=None)
    sensor_cost: Mapping[str, float] | Sequence[float] | None = field(kw_only=True, default=None)
    sensor_budget: float | None = field(kw_only=True, default=None)
    allowed_splits: Sequence[Sequence[str | int]] | None = field(kw_only=True, default=None)
    integer_normals: int | None = field(kw_only=True, default=None)
    gaps: bool = field(kw_only=True, default=False)
    feature_names: tuple[str, ...] = field(kw_only=True, default=_DERIVED)
    class_names: tuple[Any, ...] = field(kw_only=True, default=_DERIVED)
    codes: NDArray[np.int64] = field(init=False, repr=False)
    sensors: tuple[str, ...] = field(init=False, repr=False)
    sensor_index: NDArray[np.int64] = field(init=False, repr=False)
    sensor_costs: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._set_samples()
        self._set_classes()
        self._set_weights_and_costs()
        self._set_sensors()
        self._check_tree_limits()
        self._set_allowed_splits()
        self._check_range()

    def _set(self, name: str, value: object) -> None:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        object.__setattr__(self, name, value)

    def _set_samples(self) -> None:
        given = self.feature_names if self.feature_names is not None else names_of_columns(self.features)
        kept = KEPT if self.split == "axis" else KEPT[:1]
        features = features_of(self.features, gaps=True, kept=kept)
        if min(features.shape) == 0:
            raise ProblemError(f"features has shape {features.shape}; expected at least one sample and one feature")
        self._set("features", features)
        self._set("gaps", bool(self.gaps) or self.n_missing > 0)
        names = tuple(str(name) for name in ([f"x{j}" for j in range(features.shape[1])] if given is None else given))
        if len(names) != features.shape[1] or len(set(names)) != len(names):
            raise ProblemError(
                f"feature_names has {len(names)} entries ({len(set(names))} different) but features has "
                f"{features.shape[1]} columns; give one name for each column, none twice"
            )
        self._set("feature_names", names)

    def _set_classes(self) -> None:
        labels = labels_of(self.labels)
        if labels.shape != (self.n_samples,):
            raise ProblemError(
                f"labels has shape {labels.shape} but features has {self.n_samples} rows; give one label for each row"
            )
        present, inverse = distinct_labels(labels)
        if len(present) < 2:
            raise ProblemError(f"labels holds one class only ({present[0]!r}); expected two or more")
        names = tuple(present) if self.class_names is None else tuple(self.class_names)
        position = {name: k for k, name in enumerate(names)}
        unknown = [label for label in present if label not in position]
        if unknown or len(position) != len(names):
            raise ProblemError(
                f"labels holds {unknown} which class_names {names} lacks (or names twice); name every class once"
            )
        self._set("labels", labels)
        self._set("class_names", names)
        self._set("codes", np.array([position[label] for label in present], dtype=np.int64)[inverse])

    def _set_weights_and_costs(self) -> None:
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
        k = self.n_classes
        costs = 1.0 - np.eye(k) if self.costs is None else numbers_of(self.costs, "costs", 2)
        if costs.shape != (k, k):
            raise ProblemError(
                f"costs has shape {costs.shape}; expected ({k}, {k}), rows and columns {self.class_names}"
            )
        if (costs < 0).any():
            i, j = (int(index) for index in np.argwhere(costs < 0)[0])
            raise ProblemError(f"costs[{i}, {j}] is {costs[i, j]}; expected 0 or more")
        with np.errstate(over="ignore"):
            most = float(weights.sum() * costs.max())
        if costs.any() and not LEAST_COST <= most <= MOST_COST:
            raise ProblemError(
                f"weights and costs make trees that cost up to {most}; expected from {LEAST_COST:g} to {MOST_COST:g}, "
                "beyond which sums of float64 are no longer what they say; scale weights or costs"
            )
        self._set("weights", weights)
        self._set("costs", costs)

    def _set_sensors(self) -> None:
        names = self.feature_names if self.sensor_of_feature is None else self.sensor_of_feature
        of_feature = tuple(str(name) for name in names)
        if len(of_feature) != self.n_features:
            raise ProblemError(
                f"sensor_of_feature has {len(of_feature)} entries but there are {self.n_features} features; "
                "give one each"
            )
        sensors = tuple(dict.fromkeys(of_feature))
        self._set("sensor_of_feature", of_feature)
        self._set("sensors", sensors)
        self._set("sensor_index", np.array([sensors.index(name) for name in of_feature], dtype=np.int64))
        self._set("sensor_costs", sensor_costs_of(self.sensor_cost, sensors))
        if self.sensor_budget is not None:
            self._set("sensor_budget", number_of(self.sensor_budget, "sensor_budget"))

    def _check_tree_limits(self) -> None:
        self._set("depth", whole_of(self.depth, "depth", 1, MAX_DEPTH))
        self._set("leaf_size", whole_of(self.leaf_size, "leaf_size", 1, self.n_samples))
        self._set("leaf_penalty", number_of(self.leaf_penalty, "leaf_penalty"))
        if self.split not in ("axis", "hyperplane"):
            raise ProblemError(f"split is {self.split!r}; expected 'axis' or 'hyperplane'")
        if self.split == "axis" and self.split_size not in (None, 1):
            raise ProblemError(f"split_size is {self.split_size} but split is 'axis'; say split='hyperplane' for more")
        if self.split_size is not None:
            self._set("split_size", whole_of(self.split_size, "split_size", 1, None))
        if self.integer_normals is not None:
            self._set("integer_normals", whole_of(self.integer_normals, "integer_normals", 1, 2**53))

    def _check_range(self) -> None:
        """Every objective is a float64: none overflows."""
        with np.errstate(over="ignore"):
            paid = float(self.weights.sum()) * float(self.costs.max())
        prices = self.leaf_penalty * min(2**self.depth - 1, self.n_samples) * self.max_split_size
        if not math.isfinite(paid + prices):
            raise ProblemError(
                f"weights up to {self.weights.max()}, costs up to {self.costs.max()} and leaf_penalty "
                f"{self.leaf_penalty} add up to more than float64 holds (1.8e308); divide them all by one number"
            )

    def _set_allowed_splits(self) -> None:
        if self.allowed_splits is None:
            return
        position = {name: j for j, name in enumerate(self.feature_names)}
        groups = []
        for group in self.allowed_splits:
            indices = {position.get(entry, entry) if isinstance(entry, str) else entry for entry in group}
            wrong = [e for e in indices if isinstance(e, str) or not 0 <= e < self.n_features]
            if wrong or not indices:
                raise ProblemError(
                    f"allowed_splits names {wrong or 'an empty group'}; expected features by name or index"
                )
            groups.append(tuple(sorted(int(e) for e in indices)))
        self._set("allowed_splits", tuple(groups))

    def __repr__(self) -> str:
        words = [f"{self.n_samples} samples", f"{self.n_features} features", f"{self.n_classes} classes"]
        words += [f"depth={self.depth}", f"split={self.split!r}"]
        for name, usual in (("split_size", None), ("leaf_size", 1), ("leaf_penalty", 0.0), ("sensor_budget", None)):
            value = getattr(self, name)
            words += [] if value == usual else [f"{name}={value:g}"]
        if self.gaps:
            words.append(f"{self.n_missing} readings missing")
        words += [] if (self.weights == 1).all() else ["weighted"]
        words += [] if (self.costs == 1 - np.eye(self.n_classes)).all() else ["with costs"]
        return f"Problem({', '.join(words)})"

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return int(self.features.shape[0])

    @property
    def n_features(self) -> int:
        """Number of features."""
        return int(self.features.shape[1])

    @property
    def n_missing(self) -> int:
        """Number of readings that are missing."""
        return sum(int(np.isnan(block).sum()) for block in in_blocks(self.features))

    @property
    def features_with_gaps(self) -> tuple[int, ...]:
        """The features of which some reading is missing, ascending."""
        with_gaps = np.zeros(self.n_features, dtype=np.bool_)
        for block in in_blocks(self.features):
            with_gaps |= np.isnan(block).any(axis=0)
        return tuple(np.flatnonzero(with_gaps).tolist())

    @property
    def n_classes(self) -> int:
        """Number of classes, those of `class_names` without a sample included."""
        return len(self.class_names)

    @property
    def max_split_size(self) -> int:
        """Most features that one split may have."""
        return 1 if self.split == "axis" else min(self.split_size or self.n_features, self.n_features)

    @property
    def has_integer_costs(self) -> bool:
        """Whether every objective is an integer, so that bounds may be rounded up and compared with ``==``."""
        return bool(
            all((array == np.floor(array)).all() for array in (self.weights, self.costs))
            and self.leaf_penalty == math.floor(self.leaf_penalty)
            and self.weights.sum() * max(self.costs.max(), 1.0) < 2.0**52
        )

    @property
    def least_saving(self) -> float:
        """Least cost that one sample's best label, or one split fewer, saves; +inf if neither saves any.

        A proof whose tolerance is not below it cannot tell a tree from one that answers a sample better.
        """
        excess = self.costs - self.costs.min(axis=1, keepdims=True)
        by_class = np.where(excess > 0, excess, np.inf).min(axis=1)
        lightest = np.full(self.n_classes, np.inf)
        positive = self.weights > 0
        np.minimum.at(lightest, self.codes[positive], self.weights[positive])
        pairs = zip(lightest.tolist(), by_class.tolist(), strict=True)
        # A product below the least float64 is something all the same.
        savings = [max(w * c, math.ulp(0.0)) for w, c in pairs if math.isfinite(w)]
        return float(min([*savings, self.leaf_penalty or math.inf]))

    @property
    def baseline(self) -> float:
        """Objective of the best tree without a split: B&D's baseline error, by which they normalise."""
        return float(self.class_costs().min())

    def class_costs(self, rows: NDArray[np.int64] | None = None) -> NDArray[np.float64]:
        """Return the cost of predicting each class for all the samples (or those of `rows`), shape (n_classes,)."""
        codes = self.codes if rows is None else self.codes[rows]
        weights = self.weights if rows is None else self.weights[rows]
        return np.bincount(codes, weights, self.n_classes) @ self.costs

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
        """The budget with room for the rounding of decimal costs (0.1 + 0.2 is within 0.3); +inf without a budget."""
        return math.inf if self.sensor_budget is None else self.sensor_budget + 1e-9 * max(1.0, self.sensor_budget)

    def with_sides(self, tree: Node) -> Node:
        """Return a tree with a side for missing readings at every split, where this problem may lack some."""
        return with_sides_for_gaps(tree, self.features, self.weights) if self.gaps else tree

    def objective(self, tree: Node) -> float:
        """Return the objective of a tree, every sample routed."""
        return self.objective_of(tree, predict(tree, self.features))

    def objective_of(self, tree: Node, predicted: NDArray[np.int64]) -> float:
        """Return the objective of a tree whose predictions (n_samples,) are known."""
        paid = self.weights * self.costs[self.codes, predicted]
        # Sums of whole numbers below 2^52 are exact in any order; fsum rounds others once, but takes ten times as long.
        total = float(paid.sum()) if self.has_integer_costs else math.fsum(paid)
        return total + self.leaf_penalty * complexity(tree)

    def is_allowed(self, features: tuple[int, ...]) -> bool:
        """Whether these features may meet in one split."""
        if len(features) > self.max_split_size:
            return False
        return self.allowed_splits is None or any(set(features) <= set(group) for group in self.allowed_splits)

    def first_forbidden_split(self, tree: Node) -> str | None:
        """Return a sentence about the first split that this problem does not allow, None when there is none."""
        with_gaps = set(self.features_with_gaps) if self.gaps else set()
        for split in splits(tree):
            if max(split.features) >= self.n_features:
                return f"a split reads feature {max(split.features)} but the problem has {self.n_features} features"
            names = [self.feature_names[j] for j in split.features]
            if not self.is_allowed(split.features):
                return f"a split over {names} is not allowed (split_size {self.max_split_size}, allowed_splits)"
            if isinstance(split, HyperplaneSplit) and not self._is_integral(split):
                return f"a split over {names} has coefficients {split.coefficients}, not integers within limits"
            if split.missing is None and with_gaps.intersection(split.features):
                return f"a split over {names} has no side for missing readings, of which this problem has some"
        return None

    def _is_integral(self, split: HyperplaneSplit) -> bool:
        most = self.integer_normals
        return most is None or all(c == math.floor(c) and abs(c) <= most for c in split.coefficients)

    def digest(self) -> str:
        """Return the sha256 of the training data (features, labels, weights), as a tree file records it."""
        sha = hashlib.sha256()
        for array in (self.features, self.codes, self.weights):
            sha.update(str(array.shape).encode())
            for block in in_blocks(array):  # float32 readings as the float64 that they stand for
                sha.update(block.astype(np.float64 if block.dtype.kind == "f" else block.dtype).tobytes())
        sha.update(repr([str(name) for name in self.class_names]).encode())
        return sha.hexdigest()
