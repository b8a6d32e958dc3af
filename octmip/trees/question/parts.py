"""Parts of a tree that a Problem asks for: given splits by their address, and rules for the features on a path.

The address of a node is the way to it from the root, a letter for each split: "ROOT", "L" (left of the root), "LR"
(right of that). A given split is a feature, "g05", with a threshold, "g05<=3.2", any feature of a sensor, such as all
questions for a column of texts, or "leaf": nothing is split there.

    ("not-below", "g07", "g05")    g07 is never split below a split of g05 (or of others that follow)
    ("apart", "g01", "g02")        no path from the root to a leaf splits two of these features
    ("root-only", "g03")           g03 is split at the root or nowhere
"""

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from octmip.errors import ProblemError

ROOT = "ROOT"
LEAF = "leaf"
RULES = {"not-below": 2, "apart": 2, "root-only": 1}
"""Kinds of rules, and how many features they need."""
PathRule = tuple[str, tuple[int, ...]]
"""A kind of rule and its features by index."""


@dataclass(frozen=True, slots=True, order=True)
class GivenSplit:
    """A split that stands at an address.

    Attributes
    ----------
    path
        "" for the root, else letters L and R.
    features
        by index, one of which is split here; none: a leaf stands here.
    threshold
        of the one feature; None: any.
    sensor
        whose features they are; "" where one feature is named.
    """

    path: str
    features: tuple[int, ...]
    threshold: float | None = None
    sensor: str = ""

    def words(self, names: Sequence[str]) -> str:
        """Return it as the command takes it: L=g05<=3.2."""
        return f"{address(self.path)}={self.split_words(names)}"

    def split_words(self, names: Sequence[str]) -> str:
        """Return what stands there: g05, g05<=3.2 or leaf."""
        if not self.features:
            return LEAF
        return self.sensor or names[self.features[0]] + ("" if self.threshold is None else f"<={self.threshold!r}")


def address(path: str) -> str:
    """Return the address of a path, ROOT where it is empty."""
    return path or ROOT


def given_splits(
    given: object, names: tuple[str, ...], what: str, sensor_of_feature: Sequence[str]
) -> tuple[GivenSplit, ...] | None:
    """Return given splits in the order of their addresses, None where there are none.

    Parameters
    ----------
    given
        a mapping from addresses to features (names or indices), texts as "g05<=3.2", pairs (feature, threshold) or
        "leaf"; or what this function returned.
    names
        of the features.
    what
        is given, for an error.
    sensor_of_feature
        (n_features,) names of sensors, each of which may stand for all its features.

    Raises
    ------
    ProblemError
        an address is none, a feature is unknown, or a split stands below a leaf.
    """
    if given is None:
        return None
    if isinstance(given, Mapping):
        found = [_given_split(key, value, names, what, sensor_of_feature) for key, value in given.items()]
    elif isinstance(given, tuple) and all(isinstance(entry, GivenSplit) for entry in given):
        found = list(given)
    else:
        raise ProblemError(f"{what} is {given!r}; expected a mapping from addresses to splits, such as ROOT to 'g05'")
    leaves = [entry.path for entry in found if not entry.features]
    below = [entry for entry in found for leaf in leaves if entry.path != leaf and entry.path.startswith(leaf)]
    if below or len({entry.path for entry in found}) < len(found):
        where = address(below[0].path) if below else "an address twice"
        raise ProblemError(f"{what} names {where}, but each address stands once and nothing below a leaf; leave it out")
    return tuple(sorted(found, key=lambda entry: entry.path)) or None


def _given_split(
    key: object, value: Any, names: tuple[str, ...], what: str, sensor_of_feature: Sequence[str]
) -> GivenSplit:
    path = "" if key == ROOT else key
    if not isinstance(path, str) or set(path) - set("LR"):
        raise ProblemError(f"{what} names the address {key!r}; expected ROOT, or a way from it such as L or LR")
    if isinstance(value, str) and value == LEAF and LEAF not in names:
        return GivenSplit(path, ())
    if isinstance(value, str) and value not in names and value in sensor_of_feature:
        return GivenSplit(path, tuple(j for j, of in enumerate(sensor_of_feature) if of == value), None, value)
    feature, threshold = value if isinstance(value, list | tuple) and len(value) == 2 else (value, None)
    if isinstance(value, str) and value not in names and "<=" in value:
        feature, _, number = value.rpartition("<=")
        feature = feature if feature in names else feature.strip()
        try:
            threshold = float(number)
        except ValueError:
            raise ProblemError(f"{what} of {key} is {value!r}; expected a number after <=, such as g05<=3.2") from None
    if threshold is not None and not math.isfinite(threshold):
        raise ProblemError(f"{what} of {key} has the threshold {threshold}; expected a finite number")
    index = _index(feature, names, f"{what} of {key}", sensor_of_feature)
    return GivenSplit(path, (index,), None if threshold is None else float(threshold))


def _index(feature: object, names: tuple[str, ...], what: str, sensors: Sequence[str] = ()) -> int:
    index = names.index(feature) if isinstance(feature, str) and feature in names else feature
    if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(names):
        raise ProblemError(f"{what} names {feature!r}; {_expected(feature, 'features', (*sensors, *names))}")
    return index


def _expected(name: object, kind: str, known: Sequence[str]) -> str:
    """Return the known names that are nearest to one that is none of them, or the first ones."""
    names = list(dict.fromkeys(known))
    if near := difflib.get_close_matches(str(name), names):
        return f"did you mean {' or '.join(near)}?"
    return f"expected one of the {kind} {', '.join(names[:8])}{', ...' if len(names) > 8 else ''}"


def path_rules(given: object, names: tuple[str, ...], what: str) -> tuple[PathRule, ...] | None:
    """Return rules for the features on a path by index, None where there are none.

    Parameters
    ----------
    given
        a sequence of rules: a kind and features by name or index, in one sequence; or what this function returned.
    names
        of the features.
    what
        is given, for an error.

    Raises
    ------
    ProblemError
        a rule is none, or a feature is unknown.
    """
    if given is None:
        return None
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise ProblemError(f"{what} is {given!r}; expected a list of rules, such as ('apart', 'g01', 'g02')")
    return tuple(_rule(rule, names, what) for rule in given) or None


def _rule(rule: Any, names: tuple[str, ...], what: str) -> PathRule:
    kind, *features = rule if isinstance(rule, list | tuple) and rule else (rule,)
    if len(features) == 1 and isinstance(features[0], tuple):
        features = list(features[0])
    if kind not in RULES:
        raise ProblemError(f"{what} has the rule {rule!r}; expected one that begins with {', '.join(RULES)}")
    found = tuple(_index(feature, names, f"{what}, {kind},") for feature in features)
    if len(set(found)) < RULES[kind] or (kind == "apart" and len(set(found)) < len(found)):
        raise ProblemError(f"{what} has the rule {rule!r}; expected {RULES[kind]} or more different features after it")
    return kind, found


def rules_of_columns(rules: Sequence[Sequence[str]], column_of_feature: Sequence[str]) -> list[tuple[str | int, ...]]:
    """Return rules for columns as rules for the features that were made of them, by index.

    Raises
    ------
    ProblemError
        a column is unknown.
    """

    def features(column: str) -> list[int]:
        found = [j for j, of in enumerate(column_of_feature) if of == column]
        if not found:
            raise ProblemError(f"path_rules names {column!r}; {_expected(column, 'columns', column_of_feature)}")
        return found

    found: list[tuple[str | int, ...]] = []
    for kind, *columns in rules:
        if len(set(columns)) < max(len(columns), RULES[kind]):
            raise ProblemError(
                f"path_rules, {kind}, names {', '.join(columns)}; expected {RULES[kind]} or more different columns"
            )
        groups = [features(column) for column in columns]
        if kind == "not-below":
            found += [(kind, one, *(j for group in groups[1:] for j in group)) for one in groups[0]]
        elif kind == "apart":
            found += [(kind, one, other) for a, b in combinations(groups, 2) for one in a for other in b]
        else:
            found.append((kind, *(j for group in groups for j in group)))
    return found


def banned_below(rules: Sequence[PathRule], n_features: int) -> list[set[int]]:
    """Return for each feature those that no split below one of it may have."""
    banned: list[set[int]] = [set() for _ in range(n_features)]
    for kind, features in rules:
        if kind == "not-below":
            for above in features[1:]:
                banned[above].add(features[0])
        elif kind == "apart":
            for above in features:
                banned[above].update(set(features) - {above})
        else:
            for below in banned:
                below.update(features)
    return banned


def words_of_rules(rules: Sequence[PathRule], names: Sequence[str]) -> list[list[str]]:
    """Return rules as lists of their kind and the names of their features."""
    return [[kind, *(names[feature] for feature in features)] for kind, features in rules]
