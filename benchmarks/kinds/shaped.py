"""Trees of classes of a shape that is asked for: random problems against a list of all trees.

Predictions in order, given splits, rules for paths, few changes of an old tree, no depth, and several of them at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator

from benchmarks.kinds.classes import Classes
from octmip.trees.losses import ClassCosts
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution, Stop
from octmip.trees.tree import Leaf, Node, Split
from tests.oracles.monotone import least_monotone_cost
from tests.oracles.parts import least_cost_with_parts

MOST_SAMPLES = {1: 12, 2: 11, 3: 9}
"""By depth: the list of all trees grows with their power."""
SENSOR = "sensor"
"""What the first two features are read from."""


@dataclass(frozen=True, slots=True)
class Ordered(Classes):
    """Trees of least cost that keep the order of some features."""

    def truth(self, problem: Problem) -> Fraction:
        """Return the least cost of any tree that keeps the order."""
        return Fraction(least_monotone_cost(problem))


@dataclass(frozen=True, slots=True)
class Parted(Classes):
    """Trees of least cost that have given parts, keep rules for paths or change little."""

    def draw(self, rng: Generator) -> Problem:
        """Return a random problem that has a tree."""
        while True:
            problem = self.drawn(rng)
            if least_cost_with_parts(problem) is not None:
                return problem

    def truth(self, problem: Problem) -> Fraction:
        """Return the least cost of any tree that has the parts."""
        least = least_cost_with_parts(problem)
        assert least is not None
        return least

    def complaint(self, problem: Problem, answer: Solution, truth: Fraction, log: Path) -> str:
        """Return what is wrong with a solution; '' when nothing is, or a limit came before the first tree."""
        if answer.tree is None:
            return "answer: no tree and no limit" if answer.stop is Stop.OPTIMAL else ""
        return Classes.complaint(self, problem, answer, truth, log)


def shaped_problem(rng: Generator, asked: tuple[str, ...]) -> Problem:
    """Return a problem of whole costs and what is named: order, fixed, rules, changes, missing, splits, any-depth."""
    depth, p = int(rng.choice([1, 2, 2, 3])), int(rng.integers(1, 4))
    is_any, most = "any-depth" in asked, MOST_SAMPLES[depth] - (depth - 1 if "order" in asked else 0)
    is_long = is_any or "missing" in asked  # the list of all trees
    n = int(rng.integers(3, 8 if is_long else most + (3 if p < 3 else 0)))
    k = int(rng.integers(2, 4))
    labels = rng.integers(0, k, n)
    labels[:2] = 0, 1
    costs = rng.integers(0, 5, (k, k)) * (1 - np.eye(k)) if rng.random() < 0.4 else 1 - np.eye(k)
    features = rng.integers(0, 4 if depth < 3 else 3, (n, p)).astype(float)
    sides: list[Any] = ["left", "right", None] if "missing" in asked else [None]
    if "missing" in asked:
        features[rng.random((n, p)) < 0.2] = np.nan
    shape: dict[str, Any] = {"depth": None if is_any else depth}
    if "order" in asked:
        directions = rng.choice([-1, 0, 1], p)
        directions[int(rng.integers(0, p))] = rng.choice([-1, 1])
        shape["monotone"] = directions.tolist()
    if "fixed" in asked:
        shape["fixed_splits"] = _given(rng, depth, p)
    if "rules" in asked:
        shape["path_rules"] = _rules(rng, p)
    if "changes" in asked:
        shape |= {"old_tree": _tree(rng, depth, p, sides), "max_changes": int(rng.integers(0, 5))}
    if "splits" in asked:
        shape["max_splits"] = int(rng.integers(1, 2**depth))
    return Problem(
        features,
        labels,
        loss=ClassCosts(costs),
        class_names=tuple(range(k)),
        weights=rng.integers(1, 4 if rng.random() < 0.5 else 2, n).astype(float),
        leaf_size=int(rng.choice([1, 1, 2])),
        leaf_penalty=float(rng.choice([1, 1, 2] if is_any else [0, 0, 1])),
        sensor_of_feature=[SENSOR, SENSOR, "other"][:p],
        **shape,
    )


def _given(rng: Generator, depth: int, p: int) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for _ in range(int(rng.integers(1, 4))):
        path = "".join(rng.choice(["L", "R"], int(rng.integers(0, depth))))
        threshold = float(rng.choice([0.5, 1.0, 1.5, 2.5])) if rng.random() < 0.4 else None
        is_sensor = p > 1 and rng.random() < 0.2
        found[path or "ROOT"] = SENSOR if is_sensor else (int(rng.integers(0, p)), threshold)
    free = [path + turn for path in ["" if key == "ROOT" else key for key in found] for turn in "LR"]
    leaf = str(rng.choice(free))
    if rng.random() < 0.2 and not any(key.startswith(leaf) for key in found):
        found[leaf] = "leaf"
    return found


def _rules(rng: Generator, p: int) -> list[tuple[Any, ...]]:
    rules: list[tuple[Any, ...]] = []
    for _ in range(int(rng.integers(1, 3))):
        two = [int(f) for f in rng.permutation(p)[:2]]
        kinds = ["root-only"] if p == 1 else ["not-below", "apart", "root-only"]
        kind = str(rng.choice(kinds))
        rules.append((kind, *(two[:1] if kind == "root-only" else two)))
    return rules


def _tree(rng: Generator, depth: int, p: int, sides: Sequence[Any]) -> Node:
    if depth == 0 or rng.random() < 0.2:
        return Leaf(int(rng.integers(0, 2)))
    threshold = float(rng.choice([0.5, 1.0, 1.5, 2.2]))
    missing = sides[int(rng.integers(len(sides)))]
    below = [_tree(rng, depth - 1, p, sides) for _ in range(2)]
    return Split(
        int(rng.integers(0, p)), threshold if missing is None or rng.random() < 0.8 else None, *below, missing=missing
    )


def _several(rng: Generator) -> Problem:
    names = np.array(["fixed", "rules", "changes", "splits"])
    return shaped_problem(rng, tuple(str(name) for name in rng.permutation(names)[: int(rng.integers(2, 5))]))


def _sparse(rng: Generator) -> Problem:
    names = np.array(["fixed", "rules", "changes"])
    some = rng.permutation(names)[: int(rng.integers(1, 4))]
    return shaped_problem(rng, ("any-depth", *(str(name) for name in some)))


EXACT = {"exact": 1.0}
METHODS = EXACT | {"search": 0.2, "cart": 0.2}
MONOTONE_KINDS = {
    "monotone": Ordered(23, partial(shaped_problem, asked=("order",)), METHODS, 0.3, ()),
    "monotone_few": Ordered(29, partial(shaped_problem, asked=("order", "splits")), METHODS, 0.3, ()),
}
PART_KINDS = {
    "fixed_splits": Parted(31, partial(shaped_problem, asked=("fixed",)), EXACT, 0.3, ()),
    "path_rules": Parted(37, partial(shaped_problem, asked=("rules",)), EXACT, 0.3, ()),
    "max_changes": Parted(41, partial(shaped_problem, asked=("changes",)), EXACT, 0.3, ()),
    "changes_missing": Parted(53, partial(shaped_problem, asked=("changes", "missing")), EXACT, 0.1, ()),
    "parts": Parted(43, _several, EXACT, 0.3, ()),
    "sparse_parts": Parted(47, _sparse, EXACT, 0.3, ()),
}
