"""From arguments and a table, or a file and a table, to a Problem."""

import argparse
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.cli.samples.question import (
    chosen_columns,
    kind_of_split,
    learned_columns,
    notes_of,
    rows_kept,
    sensor_settings,
)
from octmip.errors import CertificateError, DataError
from octmip.formats.columns import ColumnsError
from octmip.formats.table import Table, read_table
from octmip.formats.table.preparation import Preparation, kept_rows
from octmip.formats.tree_file import TreeFile
from octmip.losses import NUMBER_LOSSES
from octmip.problem import Problem
from octmip.tree import Node, predict_values

OF_CLASSES = {
    "costs": "prices of taking one class for another",
    "allowed_splits": "groups of columns, which the regression core does not know",
    "integer_normals": "whole-numbered hyperplanes, which the search for numbers does not know",
    "numbers_are_classes": "a label of classes",
    "holdout": "shares of classes; give the rows for testing as a table of their own: --test FILE",
    "write": "mixed-integer models of classes",
    "assist": "mixed-integer models of classes",
    "checkpoint": "proofs of classes",
}
"""Options that have no meaning for numbers, and what they are about."""


@dataclass(frozen=True, slots=True, eq=False)
class NumberQuestion:
    """A regression problem and how its table became it."""

    problem: Problem
    weights_column: str | None
    preparation: Preparation
    notes: tuple[str, ...]


def ask_numbers(arguments: argparse.Namespace) -> NumberQuestion:
    """Return the problem of a command line with --target.

    Raises
    ------
    DataError
        an option is about classes, or a file does not hold what was announced.
    ProblemError
        no tree can answer.
    """
    _refuse_options(arguments)
    whole = read_table(arguments.data, arguments.format)
    chosen = chosen_columns(whole, arguments, arguments.target, "target")
    rows = rows_kept(arguments)
    table = kept_rows(whole, rows, chosen.label, chosen.needed)
    targets = table.numbers([chosen.label], "target")[:, 0]
    columns = learned_columns(table, chosen, arguments, doubled=True)
    split = kind_of_split(arguments)
    if split == "hyperplane" or arguments.leaf_model == "linear":
        columns.refuse_gaps_in_sums("leave these rows out by --missing drop-rows, or drop these columns: --drop")
    problem = Problem(
        columns.encode(table.frame[list(chosen.features)]),
        targets,
        weights=table.numbers([chosen.weights], "weight")[:, 0] if chosen.weights else np.ones(len(targets)),
        depth=arguments.depth,
        loss=NUMBER_LOSSES[arguments.loss or "squared"],
        split=split,
        split_size=arguments.split_size,
        leaf_model=arguments.leaf_model or "constant",
        leaf_size=arguments.leaf_size,
        leaf_penalty=arguments.leaf_penalty,
        sensor_budget=arguments.budget,
        feature_names=columns.feature_names,
        target_name=chosen.label,
        **sensor_settings(arguments, columns),
    )
    n_dropped = len(whole.frame) - len(table.frame)
    return NumberQuestion(
        problem, chosen.weights, Preparation(columns, chosen.index, rows), notes_of(n_dropped, columns, whole)
    )


def _refuse_options(arguments: argparse.Namespace) -> None:
    for name, about in OF_CLASSES.items():
        if getattr(arguments, name) not in (None, False):
            option = f"--{name.replace('_', '-')}"
            raise DataError(
                f"{option} is given with --target {arguments.target}, but is about {about}; expected options of "
                f"regression trees; leave {option} out, or name a column of classes with --label"
            )
    if arguments.method not in ("auto", "exact", "search"):
        raise DataError(
            f"--method {arguments.method} finds trees of classes but --target {arguments.target} asks for numbers; "
            "expected auto, exact or search; leave --method out"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Errors:
    """How far a tree is off on samples: their number, mean absolute error, root of the mean squared error."""

    n_samples: int
    mae: float
    rmse: float


def errors_of(tree: Node, features: NDArray[np.float64], targets: NDArray[np.float64]) -> Errors:
    """Return the errors of a tree on samples, all of the same weight."""
    misses = np.abs(predict_values(tree, features) - targets)
    return Errors(len(targets), float(misses.mean()), float(np.sqrt((misses**2).mean())))


def tested(path: str, problem: Problem, preparation: Preparation, tree: Node) -> Errors:
    """Return the errors of a tree on another table.

    Raises
    ------
    DataError
        it lacks a column, or holds what training did not.
    """
    table = read_table(path)
    table = kept_rows(table, preparation.rows, problem.target_name, preparation.columns.names)
    targets = table.numbers([problem.target_name], "target")[:, 0]
    return errors_of(tree, features_of(preparation, problem.feature_names, table), targets)


def features_of(preparation: Preparation | None, names: tuple[str, ...], table: Table) -> NDArray[np.float64]:
    """Return the features of a table's rows, encoded as in training, shape (n_rows, n_features).

    Raises
    ------
    DataError
        columns are missing or hold what they did not in training.
    """
    if preparation is None:
        return table.numbers(names)
    try:
        return preparation.columns.encode(table.frame)
    except ColumnsError as error:
        raise DataError(f"{table.name}: {error}") from error


def read_numbers(file: TreeFile, data: str, form: str | None, source: str) -> Problem:
    """Return the problem that a tree was trained on, read from its table.

    Raises
    ------
    DataError
        the table cannot be read or lacks a column.
    CertificateError
        it is not the one that the tree was trained on.
    """
    if file.target_column is None:
        raise DataError(
            f"{source} does not say which column held the target; write it again with octmip solve --target"
        )
    table = read_table(data, form)
    if file.preparation is not None:
        weights: tuple[Any, ...] = () if file.weights_column is None else (file.weights_column,)
        needed = (*file.preparation.columns.names, *weights)
        table = kept_rows(table, file.preparation.rows, file.target_column, needed)
    targets = table.numbers([file.target_column], "target")[:, 0]
    weighed = table.numbers([file.weights_column], "weight")[:, 0] if file.weights_column else np.ones(len(targets))
    problem = file.problem(features_of(file.preparation, file.feature_names, table), targets, weighed)
    if problem.digest() != file.sha256:
        raise CertificateError(
            f"{table.name} is not the table that {source} was trained on: sha256 {problem.digest()[:12]}.. of "
            f"{problem.n_samples} samples, expected {file.sha256[:12]}... of {file.n_samples}; give that table"
        )
    return problem
