"""Tree files: a tree with all that is needed to use and to check it, as JSON.

    {"format": "octmip-tree", "version": 1,
     "tree": {"feature": "g01", "threshold": 2.5, "left": {"label": 0}, "right": {"label": 20}},
     "feature_names": [...], "class_names": [...],
     "problem": {"depth": 3, "split": "axis", ...},             everything of the Problem but its samples
     "training": {"sha256": ..., "n_samples": ..., "label": "mu1", "weights": null, "leaf_counts": [[...], ...]},
     "solution": {"objective": 28.0, "bound": 28.0, ...}}       bound null: no proof

Left is `x[feature] <= threshold`, or `coefficients . x[features] <= offset` (see octmip.tree). Floats are written with
as many digits as float64 needs to come back the same.
"""

import dataclasses
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import OctmipError, TreeError
from octmip.formats.checked import shown
from octmip.formats.files import PathLike, read_json_object, write_bytes
from octmip.formats.tree_schema import CONTENT, FORMAT, SETTINGS, VERSION
from octmip.problem import Problem
from octmip.solution import Solution, Stop
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, leaf_index, leaves, n_splits, splits


@dataclass(frozen=True, slots=True, eq=False)
class TreeFile:
    """The content of a tree file.

    Attributes
    ----------
    solution
        the claims, tree included.
    feature_names, class_names
        of the problem.
    settings
        keyword arguments of Problem (all but samples, weights and names).
    sha256
        of the training data, `Problem.digest`.
    n_samples
        at training.
    label_column, weights_column
        of the training table, None where it was none.
    leaf_counts
        (n_leaves, n_classes) training samples of each class in each leaf, leaves from the left.
    """

    solution: Solution
    feature_names: tuple[str, ...]
    class_names: tuple[Any, ...]
    settings: Mapping[str, Any]
    sha256: str
    n_samples: int
    label_column: str | None
    weights_column: str | None
    leaf_counts: NDArray[np.int64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))

    def __reduce__(self) -> tuple[type["TreeFile"], tuple[Any, ...]]:
        """Go to other processes, which read-only mappings do not."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return TreeFile, tuple((values | {"settings": dict(self.settings)}).values())

    @property
    def tree(self) -> Node:
        """The tree."""
        assert self.solution.tree is not None  # read and made so
        return self.solution.tree

    def problem(
        self, features: NDArray[np.float64], labels: NDArray[Any], weights: NDArray[np.float64] | None
    ) -> Problem:
        """Return the problem of this file over other (or the same) samples."""
        names = {"feature_names": self.feature_names, "class_names": self.class_names}
        return Problem(features, labels, weights=weights, **names, **self.settings)  # type: ignore[arg-type]


def record_tree(
    problem: Problem, solution: Solution, label_column: str | None = None, weights_column: str | None = None
) -> TreeFile:
    """Return the tree file of a solution.

    Raises
    ------
    TreeError
        the solution has no tree.
    """
    if solution.tree is None:
        raise TreeError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to write")
    settings = {name: getattr(problem, name) for name in SETTINGS}
    settings["allowed_splits"] = problem.allowed_splits and [list(group) for group in problem.allowed_splits]
    settings["costs"] = problem.costs.tolist()
    settings["sensor_of_feature"] = list(problem.sensor_of_feature or ())
    settings["sensor_cost"] = dict(zip(problem.sensors, problem.sensor_costs.tolist(), strict=True))
    return TreeFile(
        solution=solution,
        feature_names=problem.feature_names,
        class_names=problem.class_names,
        settings=settings,
        sha256=problem.digest(),
        n_samples=problem.n_samples,
        label_column=label_column,
        weights_column=weights_column,
        leaf_counts=leaf_counts(problem, solution.tree),
    )


def leaf_counts(problem: Problem, tree: Node) -> NDArray[np.int64]:
    """Return the samples of each class in each leaf, leaves from the left, shape (n_leaves, n_classes)."""
    counts = np.zeros((len(leaves(tree)), problem.n_classes), dtype=np.int64)
    np.add.at(counts, (leaf_index(tree, problem.features), problem.codes), 1)
    return counts


def write_tree_file(path: PathLike, file: TreeFile) -> None:
    """Write a tree file, whole or not at all.

    Raises
    ------
    DataError
        it cannot be written, or holds what no reader would take, such as a name of a thousand characters.
    """
    content = encode(file)
    CONTENT.take(content)  # what could not be read again is not written
    write_bytes(path, (json.dumps(content, indent=1, allow_nan=False) + "\n").encode())


def encode(file: TreeFile) -> dict[str, Any]:
    """Return a tree file as one JSON object."""
    solution = {
        field.name: getattr(file.solution, field.name) for field in dataclasses.fields(Solution) if field.name != "tree"
    }
    solution |= {"stop": str(file.solution.stop), "bound": finite_or_none(file.solution.bound)}
    return {
        "format": FORMAT,
        "version": VERSION,
        "tree": encode_tree(file.tree, file.feature_names, file.class_names),
        "feature_names": list(file.feature_names),
        "class_names": list(file.class_names),
        "problem": dict(file.settings),
        "training": {
            "sha256": file.sha256,
            "n_samples": file.n_samples,
            "label": file.label_column,
            "weights": file.weights_column,
            "leaf_counts": file.leaf_counts.tolist(),
        },
        "solution": solution,
    }


def finite_or_none(number: float) -> float | None:
    """Return a number, None where JSON has none for it."""
    return number if math.isfinite(number) else None


def encode_tree(tree: Node, feature_names: tuple[str, ...], class_names: tuple[Any, ...]) -> dict[str, Any]:
    """Return a tree as nested JSON objects, features and classes by name."""
    if isinstance(tree, Leaf):
        return {"label": class_names[tree.label]}
    sides = {
        "left": encode_tree(tree.left, feature_names, class_names),
        "right": encode_tree(tree.right, feature_names, class_names),
    }
    if isinstance(tree, Split):
        return {"feature": feature_names[tree.feature], "threshold": tree.threshold, **sides}
    names = [feature_names[feature] for feature in tree.features]
    return {"features": names, "coefficients": list(tree.coefficients), "offset": tree.offset, **sides}


def read_tree_file(path: PathLike) -> TreeFile:
    """Return the content of a tree file.

    Raises
    ------
    DataError
        the file cannot be read, or ends early.
    TreeError
        it is of another kind or a newer version, or what it holds is no tree.
    """
    content = read_json_object(path)
    if content.get("format") != FORMAT:
        raise TreeError(f"{path} is no tree file: format is {shown(content.get('format'))}; expected {FORMAT!r}")
    version: Any = content.get("version")
    if type(version) not in (int, float) or version < 1:
        raise TreeError(f"{path} has version {shown(version)}; expected {VERSION}; write it again with octmip solve")
    if version > VERSION:
        raise TreeError(
            f"{path} is of version {shown(version)}, newer than the known {VERSION}; install a newer octmip"
        )
    if version != VERSION:
        raise TreeError(f"{path} has version {shown(version)}; expected {VERSION}; write it again with octmip solve")
    try:
        return _decode(CONTENT.take(content))
    except OctmipError as error:
        cure = "write the file again with octmip solve --out, or correct that entry"
        raise TreeError(f"{path} holds no valid tree: {error}; {cure}") from error


def different(names: Sequence[Any], what: str) -> tuple[Any, ...]:
    """Return names as a tuple.

    Raises
    ------
    TreeError
        one stands there twice.
    """
    if len(set(names)) < len(names):
        twice, times = Counter(names).most_common(1)[0]
        raise TreeError(f"{what} holds {shown(twice)} {times} times; expected a list of different names")
    return tuple(names)


def _decode(content: dict[str, Any]) -> TreeFile:
    features, classes = (different(content[name], name) for name in ("feature_names", "class_names"))
    tree = decode_tree(content["tree"], features, classes)
    claims, training = content["solution"], content["training"]
    claims["bound"] = -math.inf if claims["bound"] is None else claims["bound"]
    return TreeFile(
        solution=Solution(tree=tree, **claims | {"stop": Stop(claims["stop"])}),
        feature_names=features,
        class_names=classes,
        settings=_sized(content["problem"], len(features), len(classes)),
        sha256=training["sha256"],
        n_samples=training["n_samples"],
        label_column=training["label"],
        weights_column=training["weights"],
        leaf_counts=_counts(training, n_splits(tree) + 1, len(classes)),
    )


def _counts(training: dict[str, Any], n_leaves: int, n_classes: int) -> NDArray[np.int64]:
    rows = training["leaf_counts"]
    if [len(row) for row in rows] != [n_classes] * n_leaves:
        sizes = sorted({len(row) for row in rows})
        raise TreeError(
            f"leaf_counts has shape ({len(rows)}, {' or '.join(map(str, sizes))}); expected {(n_leaves, n_classes)}, "
            "a row for each leaf and a column for each class"
        )
    total = sum(map(sum, rows))
    if total != training["n_samples"]:
        raise TreeError(f"leaf_counts adds up to {total}; expected training.n_samples, {training['n_samples']}")
    return np.array(rows, dtype=np.int64)


def _sized(settings: dict[str, Any], n_features: int, n_classes: int) -> dict[str, Any]:
    """Return the settings, once their sizes fit the names."""
    if [len(row) for row in settings["costs"]] != [n_classes] * n_classes:
        raise TreeError(f"problem.costs has {len(settings['costs'])} rows; expected {(n_classes, n_classes)} numbers")
    if len(settings["sensor_of_feature"]) != n_features:
        got = len(settings["sensor_of_feature"])
        raise TreeError(f"problem.sensor_of_feature has {got} names; expected one for each of {n_features} features")
    return settings


def decode_tree(node: dict[str, Any], feature_names: Sequence[str], class_names: Sequence[Any]) -> Node:
    """Return the tree of nested JSON objects that `NODE` has taken.

    Raises
    ------
    TreeError
        a feature or class is not among the names, or a split is none.
    """
    positions = [{name: k for k, name in enumerate(names)} for names in (feature_names, class_names)]
    return _node(node, *positions)


def _node(node: dict[str, Any], features: dict[str, int], classes: dict[Any, int]) -> Node:
    if "label" in node:
        return Leaf(_index(node["label"], classes, "class"))
    left, right = _node(node["left"], features, classes), _node(node["right"], features, classes)
    if "feature" in node:
        return Split(_index(node["feature"], features, "feature"), node["threshold"], left, right)
    read, coefficients = [_index(name, features, "feature") for name in node["features"]], node["coefficients"]
    if len(read) != len(coefficients):
        raise TreeError(f"a node has {len(read)} features and {len(coefficients)} coefficients; expected one for each")
    terms = sorted(zip(read, coefficients, strict=True))
    return HyperplaneSplit(tuple(j for j, _ in terms), tuple(c for _, c in terms), node["offset"], left, right)


def _index(name: Any, positions: dict[Any, int], kind: str) -> int:
    if name not in positions:
        raise TreeError(f"a node names the {kind} {shown(name)}, which is not among its {len(positions)} {kind} names")
    return positions[name]


def tree_for(problem: Problem, file: TreeFile) -> Node:
    """Return the tree of a file for a problem whose features and classes may stand in another order.

    Raises
    ------
    TreeError
        the problem lacks a feature or class that the tree names.
    """
    named = encode_tree(file.tree, file.feature_names, file.class_names)
    return decode_tree(named, problem.feature_names, problem.class_names)


def columns_read(file: TreeFile) -> tuple[str, ...]:
    """Return the names of the features that the tree reads, in the order of `feature_names`."""
    used = {feature for split in splits(file.tree) for feature in split.features}
    return tuple(file.feature_names[feature] for feature in sorted(used))
