"""Problem files: a problem with its samples as JSON, for programs that know nothing of Python, such as `octmip-check`.

    {"format": "octmip-problem", "version": 2, "feature_names": [...], "class_names": [...],
     "features": [[...], ...], "labels": [...], "weights": [...], "costs": [[...], ...],
     "depth": 3, "split": "axis", "split_size": 1, "leaf_size": 1, "leaf_penalty": 0.0,
     "sensor_of_feature": [0, ...], "sensor_cost": [1.0, ...], "sensor_limit": null, "allowed_splits": null}

One of numbers has format "octmip-regression-problem", version 1, and "target_name", "targets" and "loss" instead of
classes, costs, split and groups: its trees are axis-aligned, with one number in each leaf.

Labels, sensors and features of groups are indices from 0. Floats are written with as many digits as float64 needs to
come back the same; a missing reading is null, and a file without one is of version 1. `sensor_limit` is the budget with
its room for rounding, null without a budget.
"""

import hashlib
import json
import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.input.files import PathLike, write_bytes
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_values import in_blocks

FORMAT, VERSION = "octmip-problem", 2
FORMAT_OF_NUMBERS, VERSION_OF_NUMBERS = "octmip-regression-problem", 1


def write_problem_file(path: PathLike, problem: Problem) -> None:
    """Write a problem file, whole or not at all.

    Raises
    ------
    DataError
        it cannot be written.
    ProblemError
        trees of numbers with hyperplanes or linear leaves, or trees of a shape, which no program checks.
    """
    write_bytes(path, (json.dumps(encode(problem), allow_nan=False) + "\n").encode())


def encode(problem: Problem) -> dict[str, Any]:
    """Return a problem as one JSON object."""
    if problem.shape.is_shaped or problem.shape.leaf_weight is not None:
        raise ProblemError(
            "leaf_weight, max_splits, monotone or a part of the tree is given, of which a problem file says nothing; "
            "leave it or the file out"
        )
    return (_of_classes(problem) if problem.loss.predicts == "class" else _of_numbers(problem)) | _of_both(problem)


def _of_both(problem: Problem) -> dict[str, Any]:
    shape = problem.shape
    limit = shape.sensor_limit
    return {
        "feature_names": list(problem.samples.feature_names),
        "features": [
            [None if math.isnan(value) else value for value in row] for row in problem.samples.features.tolist()
        ],
        "weights": problem.samples.weights.tolist(),
        "depth": shape.depth,
        "leaf_size": shape.leaf_size,
        "leaf_penalty": shape.leaf_penalty,
        "sensor_of_feature": shape.sensor_index.tolist(),
        "sensor_cost": shape.sensor_costs.tolist(),
        "sensor_limit": limit if math.isfinite(limit) else None,
    }


def _of_classes(problem: Problem) -> dict[str, Any]:
    shape = problem.shape
    return {
        "format": FORMAT,
        "version": VERSION if problem.samples.n_missing else 1,  # which programs that know of no missing readings read
        "class_names": [str(name) for name in problem.samples.class_names],
        "labels": problem.samples.codes.tolist(),
        "costs": problem.costs.tolist(),
        "split": shape.split,
        "split_size": shape.max_split_size,
        "allowed_splits": None if shape.allowed_splits is None else [list(group) for group in shape.allowed_splits],
    }


def _of_numbers(problem: Problem) -> dict[str, Any]:
    if not problem.is_provable:
        raise ProblemError(
            f"split is {problem.shape.split!r} and leaf_model {problem.shape.leaf_model!r}, of which a problem file "
            "says nothing; expected axis-aligned regression trees with one number in each leaf; leave the file out"
        )
    return {
        "format": FORMAT_OF_NUMBERS,
        "version": VERSION_OF_NUMBERS,
        "target_name": problem.samples.target_name,
        "targets": problem.samples.targets.tolist(),
        "loss": problem.loss.spelling,
    }


def data_digest(problem: Problem) -> str:
    """Return the sha256 of samples, labels and weights that a proof log names."""
    samples = problem.samples
    sha = hashlib.sha256()
    _add(sha, "shape", np.array(samples.features.shape))
    _add(sha, "features", samples.features)
    _add(sha, "labels", samples.codes)
    _add(sha, "weights", samples.weights)
    return sha.hexdigest()


def question_digest(problem: Problem) -> str:
    """Return the sha256 of what is asked of the data: costs, depth, limits, sensors."""
    shape = problem.shape
    sha = hashlib.sha256()
    is_hyperplane = int(shape.split == "hyperplane")
    sizes = [problem.samples.n_classes, shape.depth, is_hyperplane, shape.max_split_size, shape.leaf_size]
    _add(sha, "sizes", np.array(sizes))
    _add(sha, "costs", problem.costs)
    _add(sha, "limits", np.array([shape.leaf_penalty, shape.sensor_limit]))
    _add(sha, "sensor_of_feature", shape.sensor_index)
    _add(sha, "sensor_cost", shape.sensor_costs)
    _add(sha, "is_limited", np.array([int(shape.allowed_splits is not None)]))
    if shape.leaf_weight is not None:
        _add(sha, "leaf_weight", np.array([shape.leaf_weight]))
    if shape.limited_splits is not None:
        _add(sha, "max_splits", np.array([shape.limited_splits]))
    if shape.monotone is not None:
        _add(sha, "monotone", np.array(shape.directions))
    if shape.has_parts:
        asked = [(shape.fixed_splits or ()), (shape.path_rules or ()), shape.old_tree, shape.max_changes]
        _add(sha, "parts", np.frombuffer(repr(asked).encode(), dtype=np.uint8))
    groups: Iterable[Iterable[Any]] = shape.allowed_splits or ()
    for group in groups:
        _add(sha, "group", np.array(list(group), dtype=np.int64))
    return sha.hexdigest()


def _add(sha: "hashlib._Hash", name: str, values: NDArray[Any]) -> None:
    """Feed a field: its name and length as text, its numbers as 8 bytes each, the lowest first."""
    kind = "<f8" if values.dtype.kind == "f" else "<i8"
    sha.update(f"{name} {values.size}\n".encode())
    for block in in_blocks(values):
        sha.update(block.astype(kind).tobytes())
