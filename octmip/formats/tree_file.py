"""Tree files: a tree with all that is needed to use and to check it, as JSON.

    {"format": "octmip-tree", "version": 4,
     "tree": {"feature": "g01", "threshold": 2.5, "left": {"label": 0}, "right": {"label": 20}},
     "feature_names": [...], "class_names": [...],              no class names: a tree of numbers
     "problem": {"depth": 3, "loss": {"name": "classes", "costs": [[...], ...]}, ...},
                                                                everything of the Problem but its samples
     "training": {"sha256": ..., "n_samples": ..., "target": "mu1", "weights": null, "leaf_counts": [[...], ...]},
     "solution": {"objective": 28.0, "bound": 28.0, ...},       bound null: no proof
     "table": {"columns": {...}, "index": null, "rows": "all", ...},  how columns became features, or null
     "held_out": {"share": 0.25, "seed": 0, "n_samples": 37, "measures": {"errors": 2}, "cost": 2.0},    or null
     "readings": {"units": {"g01": "microstrain"}, "loads": {"force": 20.0}}}

A leaf of a number is {"value": 1.0, "features": ["g02"], "coefficients": [0.5]}, both lists empty where it is constant.

Left is `x[feature] <= threshold`, or `coefficients . x[features] <= offset` (see octmip.trees.nodes.tree). A split with
the entry "missing": "left" (or "right") sends missing readings there; its threshold is null where it asks for nothing
else. One without the entry refuses them. Floats have as many digits as float64 needs to come back the same.
"""

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from octmip.errors import OctmipError, TreeError
from octmip.formats.columns import Columns
from octmip.formats.held_out import HeldOut, held_out_of
from octmip.formats.table.preparation import Preparation
from octmip.formats.tree_schema import CONTENT, FORMAT, SETTINGS, VERSION
from octmip.input.files import PathLike, read_json_object, write_bytes
from octmip.input.messages import shown
from octmip.trees.answer.certificate import leaf_counts
from octmip.trees.answer.solution import Solution, Stop
from octmip.trees.nodes.tree import Node, features_used, n_splits
from octmip.trees.nodes.tree_nodes import decode_tree, different, encode_tree
from octmip.trees.question.losses import NUMBER_LOSSES, SAMPLE_COSTS, Loss, loss_of
from octmip.trees.question.parts import address, words_of_rules
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_values import SIGNS
from octmip.trees.question.shape import without_predictions


@dataclass(frozen=True, slots=True)
class Readings:
    """How the numbers that a tree reads are measured.

    Attributes
    ----------
    units
        of the columns, by name.
    loads
        the loads at which they are read, by name: the tree takes readings at these as they are.
    """

    units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    loads: Mapping[str, float] = dataclasses.field(default_factory=dict)


NO_READINGS = Readings()


@dataclass(frozen=True, slots=True, eq=False)
class TreeFile:
    """The content of a tree file.

    Attributes
    ----------
    solution
        the claims, tree included.
    feature_names, class_names
        of the problem; no class names of numbers.
    settings
        keyword arguments of Problem (all but samples, weights and names), the loss as `Loss.to_json` has it.
    sha256
        of the training data, `Problem.digest`.
    n_samples
        at training.
    target_column, weights_column
        of the training table, None where it was none.
    leaf_counts
        (n_leaves, n_classes) training samples of each class in each leaf, leaves from the left; of numbers
        (n_leaves, 1) all of them.
    preparation
        how the training's table became samples; None where it was none.
    held_out
        what the tree loses on samples held out; None without such.
    readings
        units and loads of what it reads; none are known where a table was all.
    """

    solution: Solution
    feature_names: tuple[str, ...]
    class_names: tuple[Any, ...]
    settings: Mapping[str, Any]
    sha256: str
    n_samples: int
    target_column: str | None
    weights_column: str | None
    leaf_counts: NDArray[np.int64]
    preparation: Preparation | None = None
    held_out: HeldOut | None = None
    readings: Readings = NO_READINGS

    def __post_init__(self) -> None:
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))

    def __reduce__(self) -> tuple[type["TreeFile"], tuple[Any, ...]]:
        """Go to other processes, which read-only mappings do not."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return TreeFile, tuple((values | {"settings": dict(self.settings)}).values())

    @property
    def tree(self) -> Node:
        """The tree."""
        return self.solution.tree

    @property
    def columns(self) -> Columns | None:
        """How the columns of a table become the features; None where every feature is its column."""
        return None if self.preparation is None or self.preparation.columns.is_plain else self.preparation.columns

    @property
    def class_weight(self) -> tuple[float, ...] | None:
        """What multiplied the weight of the training rows of each class; None: nothing."""
        return None if self.preparation is None else self.preparation.class_weight

    @property
    def is_weighted(self) -> bool:
        """Whether training rows weighed more or less than 1."""
        return self.weights_column is not None or self.class_weight is not None

    @property
    def loss(self) -> Loss:
        """What a wrong prediction costs."""
        return loss_of(self.settings["loss"])

    def problem(
        self, features: NDArray[np.float64], targets: NDArray[Any], weights: NDArray[np.float64] | None
    ) -> Problem:
        """Return the problem of this file over other (or the same) samples."""
        own: dict[str, Any] = {"feature_names": self.feature_names, "class_names": self.class_names}
        own |= {"weights": weights, "target_name": self.target_column or "target"}
        return Problem(features, targets, **{**self.settings, **own, "loss": self.loss})


def record_tree(
    problem: Problem,
    solution: Solution,
    target_column: str | None = None,
    weights_column: str | None = None,
    preparation: Preparation | None = None,
    held_out: HeldOut | None = None,
    readings: Readings = NO_READINGS,
) -> TreeFile:
    """Return the tree file of a solution.

    Raises
    ------
    TreeError
        the solution has no tree.
    """
    samples, shape = problem.samples, problem.shape
    if solution.tree is None:
        raise TreeError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to write")
    settings = {name: getattr(problem.shape, name, None) for name in SETTINGS}
    settings["takes_missing"] = samples.takes_missing
    settings["depth"] = None if shape.any_depth else shape.depth
    settings["allowed_splits"] = shape.allowed_splits and [list(group) for group in shape.allowed_splits]
    settings["monotone"] = None if shape.monotone is None else [SIGNS[way] for way in shape.directions]
    given = {address(part.path): part.split_words(samples.feature_names) for part in shape.fixed_splits or ()}
    settings["fixed_splits"] = given or None
    settings["path_rules"] = words_of_rules(shape.path_rules or (), samples.feature_names) or None
    settings["loss"] = problem.loss.to_json()
    settings["sensor_of_feature"] = list(shape.sensor_of_feature or ())
    settings["sensor_cost"] = dict(zip(shape.sensors, shape.sensor_costs.tolist(), strict=True))
    return TreeFile(
        solution=solution,
        feature_names=samples.feature_names,
        class_names=samples.class_names,
        settings=settings,
        sha256=problem.digest(),
        n_samples=samples.n_samples,
        target_column=target_column,
        weights_column=weights_column,
        leaf_counts=leaf_counts(problem, solution.tree),
        preparation=preparation,
        held_out=held_out,
        readings=readings,
    )


def write_tree_file(path: PathLike, file: TreeFile) -> None:
    """Write a tree file, whole or not at all.

    Raises
    ------
    DataError
        it cannot be written, or holds what no reader would take, such as a name of a thousand characters.
    """
    write_bytes(path, file_bytes(file))


def file_bytes(file: TreeFile) -> bytes:
    """Return the content of a tree file as bytes; see `write_tree_file`."""
    content = encode(file)
    CONTENT.take(content)  # what could not be read again is not written
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()


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
        "problem": dict(file.settings) | {"old_tree": _old_tree(file)},
        "training": {
            "sha256": file.sha256,
            "n_samples": file.n_samples,
            "target": file.target_column,
            "weights": file.weights_column,
            "leaf_counts": file.leaf_counts.tolist(),
        },
        "solution": solution,
        "table": None if file.preparation is None else file.preparation.to_json(),
        "held_out": None if file.held_out is None else dataclasses.asdict(file.held_out),
        "readings": {"units": dict(file.readings.units), "loads": dict(file.readings.loads)},
    }


def _old_tree(file: TreeFile) -> dict[str, Any] | None:
    old = file.settings["old_tree"]
    return None if old is None else encode_tree(old, file.feature_names, file.class_names)


def finite_or_none(number: float) -> float | None:
    """Return a number, None where JSON has none for it."""
    return number if math.isfinite(number) else None


def read_tree_file(path: PathLike, predicts: Literal["class", "number"] | None = None) -> TreeFile:
    """Return the content of a tree file; with `predicts` of a tree whose leaves hold this alone.

    Raises
    ------
    DataError
        the file cannot be read, or ends early.
    TreeError
        it is of another kind or version, or what it holds is no tree, or one that predicts something else.
    """
    content = read_json_object(path, "a tree file, as octmip solve --out writes it")
    if content.get("format") != FORMAT:
        raise TreeError(f"{path} is no tree file: format is {shown(content.get('format'))}; expected {FORMAT!r}")
    version: Any = content.get("version")
    if type(version) in (int, float) and version > VERSION:
        raise TreeError(
            f"{path} is of version {shown(version)}, newer than the known {VERSION}; install a newer octmip"
        )
    if version != VERSION:
        raise TreeError(f"{path} has version {shown(version)}; expected {VERSION}; write it again with octmip solve")
    try:
        file = _decode(CONTENT.take(content))
    except OctmipError as error:
        cure = "write the file again with octmip solve --out, or correct that entry"
        raise TreeError(f"{path} holds no valid tree: {error}; {cure}") from error
    if predicts not in (None, file.loss.predicts):
        raise TreeError(
            f"{path} holds a tree whose leaves predict a {file.loss.predicts}; expected a {predicts} in every leaf; "
            f"give a file of octmip solve {'--label' if predicts == 'class' else '--target'}"
        )
    return file


def _decode(content: dict[str, Any]) -> TreeFile:
    features, classes = (different(content[name], name) for name in ("feature_names", "class_names"))
    loss = content["problem"]["loss"]["name"]
    if bool(classes) != (loss not in NUMBER_LOSSES):
        raise TreeError(f"class_names has {len(classes)} names but problem.loss is {loss!r}; expected them of classes")
    tree = decode_tree(content["tree"], features, classes)
    claims, training = content["solution"], content["training"]
    claims["bound"] = -math.inf if claims["bound"] is None else claims["bound"]
    return TreeFile(
        solution=Solution(tree=tree, **claims | {"stop": Stop(claims["stop"])}),
        feature_names=features,
        class_names=classes,
        settings=_sized(content["problem"], features, classes, training["n_samples"]),
        sha256=training["sha256"],
        n_samples=training["n_samples"],
        target_column=training["target"],
        weights_column=training["weights"],
        leaf_counts=_counts(training, n_splits(tree) + 1, len(classes) or 1),
        preparation=_preparation(content["table"], features, classes),
        held_out=held_out_of(content["held_out"], loss_of(content["problem"]["loss"])),
        readings=Readings(**content["readings"]),
    )


def _preparation(
    content: dict[str, Any] | None, features: tuple[Any, ...], classes: tuple[Any, ...]
) -> Preparation | None:
    if content is None:
        return None
    found = Preparation.from_json(content)
    if found.class_weight is not None and len(found.class_weight) != len(classes):
        raise TreeError(
            f"table.class_weight has {len(found.class_weight)} numbers; expected one of {len(classes)} classes"
        )
    if found.columns.feature_names != features:
        raise TreeError(
            f"table.columns gives {len(found.columns.features)} features, which are not the {len(features)} of "
            "feature_names; expected the same names in the same order"
        )
    return found


def _counts(training: dict[str, Any], n_leaves: int, n_classes: int) -> NDArray[np.int64]:
    rows = training["leaf_counts"]
    if [len(row) for row in rows] != [n_classes] * n_leaves:
        sizes = sorted({len(row) for row in rows})
        raise TreeError(
            f"leaf_counts has shape ({len(rows)}, {' or '.join(map(str, sizes))}); expected {(n_leaves, n_classes)}, "
            "a row for each leaf and a column for each class, one of numbers"
        )
    total = sum(map(sum, rows))
    if total != training["n_samples"]:
        raise TreeError(f"leaf_counts adds up to {total}; expected training.n_samples, {training['n_samples']}")
    return np.array(rows, dtype=np.int64)


def _sized(
    settings: dict[str, Any], features: tuple[Any, ...], classes: tuple[Any, ...], n_samples: int
) -> dict[str, Any]:
    """Return the settings, once their sizes fit the names, the old tree decoded."""
    n_features, n_classes = len(features), len(classes)
    costs = settings["loss"].get("costs", [])
    n_rows = n_samples if settings["loss"]["name"] == SAMPLE_COSTS else n_classes
    if [len(row) for row in costs] != [n_classes] * n_rows:
        raise TreeError(f"problem.loss.costs has {len(costs)} rows; expected {(n_rows, n_classes)} numbers")
    if len(settings["sensor_of_feature"]) != n_features:
        got = len(settings["sensor_of_feature"])
        raise TreeError(f"problem.sensor_of_feature has {got} names; expected one for each of {n_features} features")
    old = settings["old_tree"]
    return settings | {"old_tree": None if old is None else decode_tree(old, features, classes)}


def tree_for(problem: Problem, file: TreeFile) -> Node:
    """Return the tree of a file for a problem whose features and classes may stand in another order.

    Raises
    ------
    TreeError
        the problem lacks a feature or class that the tree names.
    """
    named = encode_tree(file.tree, file.feature_names, file.class_names)
    return decode_tree(named, problem.samples.feature_names, problem.samples.class_names)


def old_tree_for(feature_names: Sequence[str], file: TreeFile) -> Node:
    """Return the splits of a file's tree over these features, each leaf the first class.

    Raises
    ------
    TreeError
        a feature that the tree reads is not among them.
    """
    named = encode_tree(without_predictions(file.tree), file.feature_names, ("",))
    return decode_tree(named, feature_names, ("",))


def columns_read(file: TreeFile) -> tuple[str, ...]:
    """Return the names of the features that the tree reads, in the order of `feature_names`."""
    return tuple(file.feature_names[feature] for feature in features_used(file.tree))
