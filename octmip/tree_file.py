"""Tree files: a tree with all that is needed to use, doubt and check it, as JSON.

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
from dataclasses import dataclass
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import OctmipError, TreeError
from octmip.files import PathLike, read_json_object, write_bytes
from octmip.problem import Problem
from octmip.solution import Solution, Stop
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, leaf_index, leaves, n_splits, splits

FORMAT, VERSION = "octmip-tree", 1
SETTINGS = (
    "depth",
    "split",
    "split_size",
    "leaf_size",
    "leaf_penalty",
    "costs",
    "sensor_of_feature",
    "sensor_cost",
    "sensor_budget",
    "allowed_splits",
    "integer_normals",
)


@dataclass(frozen=True, slots=True, eq=False)
class TreeFile:
    """What a tree file holds.

    Attributes:
        solution: the claims, tree included.
        feature_names, class_names: of the problem.
        settings: keyword arguments of Problem (all but samples, weights and names).
        sha256: of the training data, `Problem.digest`.
        n_samples: at training.
        label_column, weights_column: of the training table, None where it was none.
        leaf_counts: (n_leaves, n_classes) training samples of each class in each leaf, leaves from the left.
    """

    solution: Solution
    feature_names: tuple[str, ...]
    class_names: tuple[Any, ...]
    settings: dict[str, Any]
    sha256: str
    n_samples: int
    label_column: str | None
    weights_column: str | None
    leaf_counts: NDArray[np.int64]

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

    Raises:
        TreeError: the solution has no tree.
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

    Raises:
        DataError: it cannot be written.
    """
    write_bytes(path, (json.dumps(encode(file), indent=1, allow_nan=False) + "\n").encode())


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
        "problem": file.settings,
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

    Raises:
        DataError: the file cannot be read, or ends early.
        TreeError: it is of another kind or a newer version, or what it holds is no tree.
    """
    content = read_json_object(path)
    if content.get("format") != FORMAT:
        raise TreeError(f"{path} is no tree file: format is {content.get('format')!r}; expected {FORMAT!r}")
    version = content.get("version")
    if not isinstance(version, int) or version < 1:
        raise TreeError(f"{path} has version {version!r}; expected a whole number from 1 to {VERSION}")
    if version > VERSION:
        raise TreeError(f"{path} is of version {version}, newer than the known {VERSION}; install a newer octmip")
    try:
        return _decode(content)
    except KeyError as error:
        raise TreeError(f"{path} lacks the entry {error}; was it changed by hand?") from error
    except (OctmipError, TypeError, ValueError, AttributeError) as error:
        raise TreeError(f"{path} holds no valid tree: {error}") from error


CLAIMS: dict[str, tuple[type, ...]] = {
    "objective": (int, float),
    "bound": (int, float, NoneType),
    "stop": (str,),
    "seconds": (int, float),
    "n_nodes": (int,),
    "solver": (str,),
    "version": (str,),
    "seed": (int,),
    "tolerance": (int, float),
    "details": (dict,),
}
TRAINING: dict[str, tuple[type, ...]] = {
    "sha256": (str,),
    "n_samples": (int,),
    "label": (str, NoneType),
    "weights": (str, NoneType),
    "leaf_counts": (list,),
}


def _entries(content: Any, name: str, kinds: dict[str, tuple[type, ...]]) -> dict[str, Any]:
    """Return the entries of one object of the file, each of the kind it must be."""
    for entry, kind in kinds.items():
        value = content[name][entry]
        if not isinstance(value, kind) or isinstance(value, bool):
            wanted = " or ".join("null" if k is NoneType else k.__name__ for k in kind)
            raise TreeError(f"{name}.{entry} is {value!r}; expected {wanted}")
    return {entry: content[name][entry] for entry in kinds}


def _names(content: dict[str, Any], name: str) -> tuple[Any, ...]:
    names = content[name]
    if not isinstance(names, list) or len(set(names)) != len(names) or not names:
        raise TreeError(f"{name} is {names!r}; expected a list of different names")
    return tuple(names)


def _decode(content: dict[str, Any]) -> TreeFile:
    features, classes = _names(content, "feature_names"), _names(content, "class_names")
    tree = decode_tree(content["tree"], features, classes)
    claims, training = _entries(content, "solution", CLAIMS), _entries(content, "training", TRAINING)
    claims["bound"] = -math.inf if claims["bound"] is None else float(claims["bound"])
    claims["stop"] = Stop(claims["stop"])
    counts = np.array(training["leaf_counts"], dtype=np.int64)
    if counts.shape != (n_splits(tree) + 1, len(classes)):
        raise TreeError(f"leaf_counts has shape {counts.shape}; expected {(n_splits(tree) + 1, len(classes))}")
    return TreeFile(
        solution=Solution(tree=tree, **claims),
        feature_names=features,
        class_names=classes,
        settings={name: content["problem"][name] for name in SETTINGS},
        sha256=training["sha256"],
        n_samples=training["n_samples"],
        label_column=training["label"],
        weights_column=training["weights"],
        leaf_counts=counts,
    )


def decode_tree(node: dict[str, Any], feature_names: tuple[str, ...], class_names: tuple[Any, ...]) -> Node:
    """Return the tree of nested JSON objects.

    Raises:
        TreeError: a feature or class is not among the names, or a number is none.
    """
    if "label" in node:
        return Leaf(_index(node["label"], class_names, "class"))
    left = decode_tree(node["left"], feature_names, class_names)
    right = decode_tree(node["right"], feature_names, class_names)
    if "feature" in node:
        return Split(_index(node["feature"], feature_names, "feature"), _float(node["threshold"]), left, right)
    features = [_index(name, feature_names, "feature") for name in node["features"]]
    coefficients = [_float(value) for value in node["coefficients"]]
    terms = sorted(zip(features, coefficients, strict=True))
    return HyperplaneSplit(tuple(j for j, _ in terms), tuple(c for _, c in terms), _float(node["offset"]), left, right)


def _index(name: Any, names: tuple[Any, ...], kind: str) -> int:
    if name not in names:
        raise TreeError(f"a node names the {kind} {name!r}, which is not among its {len(names)} {kind} names")
    return names.index(name)


def _float(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TreeError(f"a node holds {value!r} where a number is expected")
    return float(value)


def tree_for(problem: Problem, file: TreeFile) -> Node:
    """Return the tree of a file for a problem whose features and classes may stand in another order.

    Raises:
        TreeError: the problem lacks a feature or class that the tree names.
    """
    named = encode_tree(file.tree, file.feature_names, file.class_names)
    return decode_tree(named, problem.feature_names, problem.class_names)


def columns_read(file: TreeFile) -> tuple[str, ...]:
    """Return the names of the features that the tree reads, in the order of `feature_names`."""
    used = {feature for split in splits(file.tree) for feature in split.features}
    return tuple(file.feature_names[feature] for feature in sorted(used))
