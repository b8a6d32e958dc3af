"""Files of regression trees: a tree with all that is needed to use and to check it, as JSON.

    {"format": "octmip-regression-tree", "version": 1,
     "tree": {"feature": "g01", "threshold": 2.5, "left": {"value": 3.5},
              "right": {"value": 1.0, "features": ["g02"], "coefficients": [0.5]}},
     "feature_names": [...], "target_name": "mu",
     "problem": {"depth": 3, "loss": "squared", ...},           everything of the Problem but its samples
     "training": {"sha256": ..., "n_samples": ..., "weights": null, "leaf_sizes": [...]},
     "solution": {"objective": 28.0, "bound": 28.0, ...},       bound null: no proof
     "table": {"columns": {...}, "index": null, "rows": "all"}}  how columns became features, or null

Left is `x[feature] <= threshold`, or `coefficients . x[features] <= offset` (see octmip.tree). Floats are written with
as many digits as float64 needs to come back the same.
"""

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import OctmipError, TreeError
from octmip.formats.checked import Choice, Kind, ListOf, MapOf, MisfitError, Number, Record, Schema, Whole, maybe
from octmip.formats.files import PathLike, read_json_object, write_bytes
from octmip.formats.messages import shown
from octmip.formats.table.preparation import Preparation
from octmip.formats.tree_nodes import different
from octmip.formats.tree_schema import CLAIMS, COST, COUNT, NAME, TABLE, TRAINING
from octmip.losses import NUMBER_LOSSES
from octmip.problem import Problem
from octmip.shape import MAX_DEPTH
from octmip.solution import Solution, Stop
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, ValueLeaf, leaf_index, leaves

FORMAT, VERSION = "octmip-regression-tree", 1


@dataclass(frozen=True, slots=True)
class ValueNodeKind:
    """A node of a regression tree: a leaf, a split on one feature, or one on several, by the entries that it has."""

    words: str = "a node: value, or left and right with feature and threshold, or features, coefficients and offset"

    def take(self, value: Any) -> dict[str, Any]:
        """Return the node and all below it."""
        kind = next((kind for mark, kind in _NODES.items() if type(value) is dict and mark in value), None)
        if kind is None:
            raise MisfitError(f"is {shown(value)} and lacks the entry 'value' or 'left'; expected {self.words}")
        return kind.take(value)

    def schema(self) -> Schema:
        """Return the reference to the definition, which holds itself."""
        return {"$ref": "#/$defs/node"}


NODE = ValueNodeKind()
_SIDES: dict[str, Kind] = {"left": NODE, "right": NODE}
_TERMS: dict[str, Kind] = {"features": ListOf(NAME), "coefficients": ListOf(Number())}
_NODES = {
    "value": Record({"value": Number(), **_TERMS}, closed=True),
    "feature": Record({"feature": NAME, "threshold": Number(), **_SIDES}, closed=True),
    "left": Record({**_TERMS, "offset": Number(), **_SIDES}, closed=True),
}
SETTINGS: dict[str, Kind] = {
    "depth": Whole(1, MAX_DEPTH),
    "loss": Choice(tuple(NUMBER_LOSSES)),
    "split": Choice(("axis", "hyperplane")),
    "split_size": maybe(COUNT),
    "leaf_model": Choice(("constant", "linear")),
    "ridge": COST,
    "leaf_size": COUNT,
    "leaf_penalty": COST,
    "sensor_of_feature": ListOf(NAME),
    "sensor_cost": MapOf(COST),
    "sensor_budget": maybe(COST),
}
CONTENT = Record(
    {
        "tree": NODE,
        "feature_names": ListOf(NAME, 1),
        "target_name": NAME,
        "problem": Record(SETTINGS),
        "training": Record(
            {name: TRAINING[name] for name in ("sha256", "n_samples", "weights")}
            | {"leaf_sizes": ListOf(Whole(0, 2**53), 1)}
        ),
        "solution": Record(CLAIMS),
        "table": maybe(Record(TABLE)),
    }
)


def schema() -> Schema:
    """Return the JSON Schema of these files: each value's kind and range, not how names and sizes hang together."""
    content = CONTENT.schema()
    marks = {"format": {"const": FORMAT}, "version": {"const": VERSION}}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "octmip regression tree file",
        **content,
        "properties": marks | content["properties"],
        "required": [*marks, *content["required"]],
        "$defs": {"node": {"anyOf": [kind.schema() for kind in _NODES.values()]}},
    }


@dataclass(frozen=True, slots=True, eq=False)
class RegressionFile:
    """The content of a file of a regression tree.

    Attributes
    ----------
    solution
        the claims, tree included.
    feature_names, target_name
        of the problem.
    settings
        keyword arguments of Problem (all but samples, weights and names).
    sha256
        of the training data, `Problem.digest`.
    n_samples
        at training.
    weights_column
        of the training table, None without weights.
    leaf_sizes
        training samples of each leaf, leaves from the left.
    preparation
        how the training's table became samples; None where it was none.
    """

    solution: Solution
    feature_names: tuple[str, ...]
    target_name: str
    settings: Mapping[str, Any]
    sha256: str
    n_samples: int
    weights_column: str | None
    leaf_sizes: tuple[int, ...]
    preparation: Preparation | None

    @property
    def tree(self) -> Node:
        """The tree."""
        assert self.solution.tree is not None  # read and made so
        return self.solution.tree

    def problem(
        self, features: NDArray[np.float64], targets: NDArray[np.float64], weights: NDArray[np.float64]
    ) -> Problem:
        """Return the problem of this file over other (or the same) samples."""
        names: dict[str, Any] = {"feature_names": self.feature_names, "target_name": self.target_name}
        settings = {**self.settings, "loss": NUMBER_LOSSES[self.settings["loss"]]}
        return Problem(features, targets, weights=weights, **names, **settings)


def record_regression(
    problem: Problem, solution: Solution, weights_column: str | None, preparation: Preparation | None
) -> RegressionFile:
    """Return the file of a solution.

    Raises
    ------
    TreeError
        the solution has no tree.
    """
    if solution.tree is None:
        raise TreeError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to write")
    settings = {name: getattr(problem, name) for name in SETTINGS} | {"loss": problem.loss.name}
    settings["sensor_of_feature"] = list(problem.sensor_of_feature or ())
    settings["sensor_cost"] = dict(zip(problem.sensors, problem.sensor_costs.tolist(), strict=True))
    reached = leaf_index(solution.tree, problem.features)
    return RegressionFile(
        solution,
        problem.feature_names,
        problem.target_name,
        settings,
        problem.digest(),
        problem.n_samples,
        weights_column,
        tuple(np.bincount(reached, minlength=len(leaves(solution.tree))).tolist()),
        preparation,
    )


def write_regression_file(path: PathLike, file: RegressionFile) -> None:
    """Write a file, whole or not at all.

    Raises
    ------
    DataError
        it cannot be written, or holds what no reader would take.
    """
    claims = {field.name: getattr(file.solution, field.name) for field in dataclasses.fields(Solution)}
    bound = claims["bound"] if math.isfinite(claims["bound"]) else None
    content = {
        "format": FORMAT,
        "version": VERSION,
        "tree": encode_values(file.tree, file.feature_names),
        "feature_names": list(file.feature_names),
        "target_name": file.target_name,
        "problem": dict(file.settings),
        "training": {
            "sha256": file.sha256,
            "n_samples": file.n_samples,
            "weights": file.weights_column,
            "leaf_sizes": list(file.leaf_sizes),
        },
        "solution": {**{k: v for k, v in claims.items() if k != "tree"}, "stop": str(claims["stop"]), "bound": bound},
        "table": None if file.preparation is None else file.preparation.to_json(),
    }
    CONTENT.take(content)  # what could not be read again is not written
    write_bytes(path, (json.dumps(content, indent=1, allow_nan=False) + "\n").encode())


def is_regression_file(path: PathLike) -> bool:
    """Return whether a file says that it holds a regression tree.

    Raises
    ------
    DataError
        it cannot be read, or is no JSON object.
    """
    return bool(read_json_object(path).get("format") == FORMAT)


def read_regression_file(path: PathLike) -> RegressionFile:
    """Return the content of a file.

    Raises
    ------
    DataError
        the file cannot be read, or ends early.
    TreeError
        it is of another kind or a newer version, or what it holds is no tree.
    """
    content = read_json_object(path)
    marks = content.get("format"), content.get("version")
    if marks != (FORMAT, VERSION):
        raise TreeError(
            f"{path} is no file of a regression tree that this octmip reads: format and version are {shown(marks[0])} "
            f"and {shown(marks[1])}; expected {FORMAT!r} and {VERSION}; write it again with octmip solve --target"
        )
    try:
        return _decode(CONTENT.take(content))
    except OctmipError as error:
        cure = "write the file again with octmip solve --out, or correct that entry"
        raise TreeError(f"{path} holds no valid tree: {error}; {cure}") from error


def _decode(content: dict[str, Any]) -> RegressionFile:
    features = different(content["feature_names"], "feature_names")
    tree = decode_values(content["tree"], features)
    claims, training, settings = content["solution"], content["training"], content["problem"]
    claims["bound"] = -math.inf if claims["bound"] is None else claims["bound"]
    sizes = training["leaf_sizes"]
    if len(sizes) != len(leaves(tree)) or sum(sizes) != training["n_samples"]:
        raise TreeError(
            f"training.leaf_sizes has {len(sizes)} entries that add up to {sum(sizes)}; expected {len(leaves(tree))}, "
            f"one for each leaf, that add up to training.n_samples, {training['n_samples']}"
        )
    if len(settings["sensor_of_feature"]) != len(features):
        got = len(settings["sensor_of_feature"])
        raise TreeError(f"problem.sensor_of_feature has {got} names; expected one for each of {len(features)} features")
    preparation = None if content["table"] is None else Preparation.from_json(content["table"])
    if preparation is not None and preparation.columns.feature_names != features:
        raise TreeError(
            f"table.columns gives {len(preparation.columns.features)} features, which are not the {len(features)} of "
            "feature_names; expected the same names in the same order"
        )
    return RegressionFile(
        Solution(tree=tree, **claims | {"stop": Stop(claims["stop"])}),
        features,
        content["target_name"],
        settings,
        training["sha256"],
        training["n_samples"],
        training["weights"],
        tuple(sizes),
        preparation,
    )


def encode_values(tree: Node, feature_names: Sequence[str]) -> dict[str, Any]:
    """Return a regression tree as nested JSON objects, features by name."""
    if isinstance(tree, ValueLeaf):
        return {"value": tree.value, **_terms(tree, feature_names)}
    if isinstance(tree, Leaf):
        raise TreeError(f"a leaf predicts class {tree.label}; expected a regression tree, with a number in every leaf")
    sides = {"left": encode_values(tree.left, feature_names), "right": encode_values(tree.right, feature_names)}
    if isinstance(tree, Split):
        return {"feature": feature_names[tree.feature], "threshold": tree.threshold, **sides}
    return {**_terms(tree, feature_names), "offset": tree.offset, **sides}


def _terms(node: ValueLeaf | HyperplaneSplit, feature_names: Sequence[str]) -> dict[str, Any]:
    return {"features": [feature_names[j] for j in node.features], "coefficients": list(node.coefficients)}


def decode_values(node: Mapping[str, Any], feature_names: Sequence[str]) -> Node:
    """Return the tree of nested JSON objects that `NODE` has taken.

    Raises
    ------
    TreeError
        a feature is not among the names, or a split or leaf is none.
    """
    position = {name: j for j, name in enumerate(feature_names)}

    def index(name: str) -> int:
        if name not in position:
            raise TreeError(
                f"a node names the feature {shown(name)}; expected one of the {len(position)} feature_names"
            )
        return position[name]

    def build(node: Mapping[str, Any]) -> Node:
        if "feature" in node:
            return Split(index(node["feature"]), node["threshold"], build(node["left"]), build(node["right"]))
        named, coefficients = node["features"], node["coefficients"]
        if len(named) != len(coefficients):
            raise TreeError(
                f"a node has {len(named)} features and {len(coefficients)} coefficients; expected one for each"
            )
        terms = sorted(zip(map(index, named), coefficients, strict=True))
        features, factors = tuple(j for j, _ in terms), tuple(c for _, c in terms)
        if "value" in node:
            return ValueLeaf(node["value"], features, factors)
        return HyperplaneSplit(features, factors, node["offset"], build(node["left"]), build(node["right"]))

    return build(node)
