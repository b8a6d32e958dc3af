"""Shape: which trees a Problem allows, whatever they predict: what is given, and whether it goes together.

Trees of at most `depth` levels of splits, every leaf with at least `leaf_size` samples, at most `split_size` features
per split, total sensor cost at most `sensor_budget`.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, replace
from itertools import repeat
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, features_used, splits
from octmip.trees.question.parts import GivenSplit, PathRule, address, given_splits, path_rules, words_of_rules
from octmip.trees.question.problem_values import (
    directions_of,
    number_of,
    sensor_costs_of,
    sensor_of_each,
    set_field,
    whole_of,
    words_of,
)

MAX_DEPTH = 30  # 2**30 leaves: beyond any use, and the node tables of the solvers are indexed by 32 bits
_DERIVED: Any = None  # a field that is filled in when it is left out


class AnyDepth(int):
    """The depth of a Problem that was asked for none: so many levels that no tree of more costs less, or MAX_DEPTH."""


def with_leaves(tree: Node, others: Iterator[Leaf]) -> Node:
    """Return a tree with other leaves, from the left."""
    if isinstance(tree, Leaf):
        return next(others)
    left = with_leaves(tree.left, others)
    return replace(tree, left=left, right=with_leaves(tree.right, others))


def without_predictions(tree: Node) -> Node:
    """Return a tree with class 0 in every leaf: its splits alone."""
    return with_leaves(tree, repeat(Leaf(0)))


def splits_of(most_leaves: int | None, split: str, name: str) -> int | None:
    """Return the splits of an axis-aligned tree of at most so many leaves, None without a limit.

    Raises
    ------
    ProblemError
        it is no whole number of 1 or more, or splits are hyperplanes, whose features are counted instead.
    """
    if most_leaves is None:
        return None
    if split != "axis":
        raise ProblemError(
            f"{name} is {most_leaves} but split is {split!r}; leave it out, or give a Problem max_splits, which counts "
            "the features in all hyperplanes"
        )
    return whole_of(most_leaves, name, 1, None) - 1


@dataclass(frozen=True, slots=True, eq=False, repr=False, kw_only=True)
class Shape:
    """Which trees are allowed.

    Attributes
    ----------
    depth
        levels of splits, 1 or more; None: trees of any depth, where splits have a price (`leaf_penalty`) or are counted
        (`max_splits`). It is then an `AnyDepth`: enough levels for every tree that may be the best.
    split
        "axis" (one feature and a threshold) or "hyperplane".
    split_size
        at most so many features in one split; None: no limit (1 for "axis").
    leaf_size
        at least so many samples in every leaf. Rows are counted, whatever they weigh.
    leaf_weight
        at least so much sample weight in every leaf, beside `leaf_size` 1; a tree without a split always holds.
        None (or 0): no limit.
    leaf_penalty
        price of one feature in one split (of a split, in an axis-aligned tree), in units of cost.
    sensor_of_feature
        (n_features,) name of the sensor that a feature is read from, or a mapping from features; of one that is left
        out, and with None, its own name.
    sensor_cost
        cost of each sensor, a mapping by name or one number per sensor in the order of `sensors`; None: 1.
    sensor_budget
        at most so much sensor cost in the whole tree; None: no limit.
    allowed_splits
        groups of features (names or indices) that may meet in one split; None: any may. A feature in
        no group is not used at all.
    leaf_model
        "constant": one class or number in a leaf; "linear": a ridge regression of its samples (numbers, by search).
    ridge
        share of the leaf's own variance that the ridge of a linear leaf adds to every feature's.
    integer_normals
        the coefficients of a hyperplane are integers of at most this size; None: real.
    max_splits
        at most so many splits in the tree, of hyperplanes so many features in all of them; None: no limit. A tree of
        `k` leaves has `k - 1` splits.
    monotone
        features along which the prediction never falls ("+" or 1) or never rises ("-" or -1) anywhere in the tree, all
        other features being equal: a mapping from features, or one direction for each; classes rise along
        `class_order`. None: no order. Axis-aligned splits, constant leaves and no missing readings.
    fixed_splits
        splits that stand in the tree, by address: a mapping such as {"ROOT": "g05", "L": "g01<=3.2", "R": "leaf"}
        (`octmip.trees.question.parts`). None: none. Predictions are free.
    path_rules
        which features may not follow each other on a path, such as [("not-below", "g07", "g05")]
        (`octmip.trees.question.parts`). None: none.
    old_tree, max_changes
        the tree differs from the old one at so many places at most: one of both has a split there that the other has
        not, or another one (`octmip.trees.question.part_check.n_changes`). Predictions are free. None: no limit.
    Derived:
        sensors: names of the sensors in the order of their first feature.
        sensor_index: (n_features,) int64, index in `sensors`.
        sensor_costs: (n_sensors,) float64.
    """

    depth: int = _DERIVED
    split: Literal["axis", "hyperplane"] = "axis"
    split_size: int | None = None
    leaf_size: int = 1
    leaf_weight: float | None = None
    leaf_penalty: float = 0.0
    sensor_of_feature: tuple[str, ...] = _DERIVED
    sensor_cost: Mapping[str, float] | Sequence[float] | None = None
    sensor_budget: float | None = None
    allowed_splits: tuple[tuple[int, ...], ...] | None = None
    leaf_model: Literal["constant", "linear"] = "constant"
    ridge: float = 1e-3
    integer_normals: int | None = None
    max_splits: int | None = None
    monotone: tuple[int, ...] | None = None
    fixed_splits: tuple[GivenSplit, ...] | None = None
    path_rules: tuple[PathRule, ...] | None = None
    old_tree: Node | None = None
    max_changes: int | None = None
    feature_names: InitVar[tuple[str, ...]]
    n_samples: InitVar[int]
    sensors: tuple[str, ...] = field(init=False)
    sensor_index: NDArray[np.int64] = field(init=False)
    sensor_costs: NDArray[np.float64] = field(init=False)

    def __post_init__(self, feature_names: tuple[str, ...], n_samples: int) -> None:
        self._set_sensors(feature_names)
        self._check_sizes(n_samples)
        self._set_allowed_splits(feature_names)
        self._set_monotone(feature_names)
        self._set_parts(feature_names)

    def _set_sensors(self, feature_names: tuple[str, ...]) -> None:
        of_feature = sensor_of_each(self.sensor_of_feature, feature_names, "features")
        sensors = tuple(dict.fromkeys(of_feature))
        position = {name: s for s, name in enumerate(sensors)}
        set_field(self, "sensor_of_feature", of_feature)
        set_field(self, "sensors", sensors)
        set_field(self, "sensor_index", np.array([position[name] for name in of_feature], dtype=np.int64))
        set_field(self, "sensor_costs", sensor_costs_of(self.sensor_cost, sensors))
        if self.sensor_budget is not None:
            set_field(self, "sensor_budget", number_of(self.sensor_budget, "sensor_budget"))

    def _check_sizes(self, n_samples: int) -> None:
        set_field(self, "leaf_size", whole_of(self.leaf_size, "leaf_size", 1, n_samples))
        if self.leaf_weight is not None:
            set_field(self, "leaf_weight", number_of(self.leaf_weight, "leaf_weight") or None)
        if self.leaf_weight is not None and self.leaf_size > 1:
            raise ProblemError(
                f"leaf_size is {self.leaf_size} and leaf_weight {self.leaf_weight:g}; expected one of the two; leave "
                "one out"
            )
        set_field(self, "leaf_penalty", number_of(self.leaf_penalty, "leaf_penalty"))
        set_field(self, "ridge", number_of(self.ridge, "ridge"))
        for name, known in (("split", ("axis", "hyperplane")), ("leaf_model", ("constant", "linear"))):
            if getattr(self, name) not in known:
                raise ProblemError(f"{name} is {getattr(self, name)!r}; expected {known[0]!r} or {known[1]!r}")
        if self.split == "axis" and self.split_size not in (None, 1):
            raise ProblemError(f"split_size is {self.split_size} but split is 'axis'; say split='hyperplane' for more")
        if self.split_size is not None:
            set_field(self, "split_size", whole_of(self.split_size, "split_size", 1, None))
        if self.integer_normals is not None:
            set_field(self, "integer_normals", whole_of(self.integer_normals, "integer_normals", 1, 2**53))
        if self.max_splits is not None:
            set_field(self, "max_splits", whole_of(self.max_splits, "max_splits", 0, None))
        self._set_depth()

    def check_leaf_weight(self, total: float, has_sample_costs: bool) -> None:
        """Raise if no split could have leaves of that weight, or if costs are those of single samples.

        Raises
        ------
        ProblemError
            one of both.
        """
        if self.leaf_weight is None:
            return
        if self.least_leaf_weight > total:
            raise ProblemError(
                f"leaf_weight is {self.leaf_weight:g} but all samples together weigh {total:g}; expected half of that "
                "at most, as a split needs two leaves"
            )
        if has_sample_costs:
            raise ProblemError(
                "leaf_weight is given with costs of single samples, which no solver answers together; leave one out"
            )

    def _set_depth(self) -> None:
        if self.depth is not None and not isinstance(self.depth, AnyDepth):
            set_field(self, "depth", whole_of(self.depth, "depth", 1, MAX_DEPTH))
            return
        if self.split != "axis":
            raise ProblemError(f"depth is None but split is {self.split!r}; give a depth, such as 2, or split='axis'")
        if self.leaf_penalty == 0 and self.max_splits is None:
            raise ProblemError(
                "depth is None and leaf_penalty 0, so the largest tree would be the best; expected a price of a split "
                "or a number of levels; give leaf_penalty, such as a hundredth of the samples, or depth, such as 3"
            )
        set_field(self, "depth", AnyDepth(MAX_DEPTH))

    def end_depth(self, of_least: float, n_samples: int) -> None:
        """Set any depth to levels of which no tree of more is better than all others, MAX_DEPTH at most.

        A tree of m levels has m splits or more, whose prices alone must stay below the cost of the leaf; and there is a
        sample in each of its leaves. Where splits have to stand, their price comes to that of the leaf: `of_least`.
        """
        most = min(MAX_DEPTH, max(1, n_samples - 1))
        if self.max_splits is not None:
            most = min(most, max(1, self.max_splits))
        if of_least < most * self.leaf_penalty:
            most = math.floor(of_least / self.leaf_penalty) + 1
        set_field(self, "depth", AnyDepth(most))

    def _set_monotone(self, feature_names: tuple[str, ...]) -> None:
        set_field(self, "monotone", directions_of(self.monotone, feature_names, "monotone"))
        if self.monotone is not None and (self.split != "axis" or self.leaf_model != "constant"):
            raise ProblemError(
                f"monotone is given but split is {self.split!r} and leaf_model {self.leaf_model!r}; expected 'axis' "
                "and 'constant', whose leaves are boxes with one prediction; leave monotone out"
            )

    def _set_parts(self, feature_names: tuple[str, ...]) -> None:
        given = given_splits(self.fixed_splits, feature_names, "fixed_splits", self.sensor_of_feature)
        rules = path_rules(self.path_rules, feature_names, "path_rules")
        set_field(self, "fixed_splits", given)
        set_field(self, "path_rules", rules)
        deep = [part for part in self.fixed_splits or () if len(part.path) >= self.depth + (not part.features)]
        if deep:
            raise ProblemError(
                f"fixed_splits names {address(deep[-1].path)} but depth is {self.depth}; give a depth of "
                f"{len(deep[-1].path) + 1} or more, or leave it out"
            )
        if (self.old_tree is None) != (self.max_changes is None):
            raise ProblemError("old_tree and max_changes belong together and only one is given; give both, or neither")
        if self.old_tree is not None and self.max_changes is not None:
            set_field(self, "max_changes", whole_of(self.max_changes, "max_changes", 0, None))
            self._check_old_tree(self.old_tree, len(feature_names))
            set_field(self, "old_tree", without_predictions(self.old_tree))
        has_parts = not (given is None and rules is None and self.max_changes is None)
        if has_parts and (self.split != "axis" or self.leaf_model != "constant" or self.monotone is not None):
            raise ProblemError(
                "fixed_splits, path_rules or max_changes is given with hyperplanes, linear leaves or monotone, which "
                "no search knows together; leave one of them out"
            )

    @staticmethod
    def _check_old_tree(tree: Node, n_features: int) -> None:
        if not isinstance(tree, Node):
            raise ProblemError(f"old_tree is {type(tree).__name__}; expected a tree, such as that of a tree file")
        if any(isinstance(split, HyperplaneSplit) for split in splits(tree)):
            raise ProblemError("old_tree has a hyperplane, of which no part can be kept; give an axis-aligned tree")
        if max(features_used(tree), default=0) >= n_features:
            raise ProblemError(
                f"old_tree reads feature {features_used(tree)[-1]} but there are {n_features} features; "
                "expected a tree over the same columns"
            )

    def _set_allowed_splits(self, feature_names: tuple[str, ...]) -> None:
        if self.allowed_splits is None:
            return
        position = {name: j for j, name in enumerate(feature_names)}
        groups = []
        for group in self.allowed_splits:
            indices = {position.get(entry, entry) if isinstance(entry, str) else entry for entry in group}
            wrong = [e for e in indices if isinstance(e, str) or not 0 <= e < len(feature_names)]
            if wrong or not indices:
                raise ProblemError(
                    f"allowed_splits names {wrong or 'an empty group'}; expected features by name or index"
                )
            groups.append(tuple(sorted(int(e) for e in indices)))
        set_field(self, "allowed_splits", tuple(groups))

    @property
    def any_depth(self) -> bool:
        """Whether trees may be as deep as they like."""
        return isinstance(self.depth, AnyDepth)

    @property
    def has_parts(self) -> bool:
        """Whether parts of the tree are given, ruled out or kept."""
        return not (self.fixed_splits is None and self.path_rules is None and self.max_changes is None)

    @property
    def sensor_limit(self) -> float:
        """The budget with room for the rounding of decimal costs (0.1 + 0.2 is within 0.3); +inf without a budget."""
        return math.inf if self.sensor_budget is None else self.sensor_budget + 1e-9 * max(1.0, self.sensor_budget)

    @property
    def least_leaf_weight(self) -> float:
        """`leaf_weight` with room for the rounding of decimal weights (0.3 three times is 0.9); 0 without one."""
        return (self.leaf_weight or 0.0) * (1 - 1e-9)

    def words(self, names: Sequence[str]) -> list[str]:
        """Return the order and the parts that are asked for, in short."""
        words = [] if self.monotone is None else [f"monotone={words_of(names, self.directions)}"]
        words += [part.words(names) for part in self.fixed_splits or ()]
        words += [" ".join(rule) for rule in words_of_rules(self.path_rules or (), names)]
        return words + ([] if self.max_changes is None else [f"max_changes={self.max_changes}"])

    @property
    def directions(self) -> tuple[int, ...]:
        """Of each feature 1 where predictions may not fall along it, -1 where they may not rise, else 0."""
        return self.monotone or (0,) * len(self.sensor_index)

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
        return all(not part.features for part in self.fixed_splits or ()) and gone <= (self.max_changes or 0)

    @property
    def most_asked_splits(self) -> int:
        """So many splits at most have to stand, 0 where a leaf is a tree: the best leaf and their price bound the best.

        They are the given ones, those above them, and those of the old tree: a tree that has the parts still has them
        once all other splits are pruned, lowest first, and no leaf of it costs more than the best single leaf did.
        """
        if self.is_leaf_allowed:
            return 0
        given = {part.path[:k] for part in self.fixed_splits or () for k in range(len(part.path) + 1)}
        return len(given) + (0 if self.old_tree is None else len(splits(self.old_tree)))

    @property
    def max_split_size(self) -> int:
        """Most features that one split may have."""
        return 1 if self.split == "axis" else min(self.split_size or len(self.sensor_index), len(self.sensor_index))

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
