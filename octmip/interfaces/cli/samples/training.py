"""From a tree file and its table to the samples that the tree was trained on, and those that were held out."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, DataError
from octmip.formats.columns import Columns, ColumnsError
from octmip.formats.columns.column import Column
from octmip.formats.table import Table, read_table
from octmip.formats.table.preparation import kept_rows
from octmip.formats.tree_file import TreeFile, columns_read
from octmip.trees.question.classes import codes_of
from octmip.trees.question.losses import Loss
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff import Samples
from octmip.trees.tradeoff.held_out import held_out_rows, strata_of


@dataclass(frozen=True, slots=True, eq=False)
class Training:
    """The training samples of a tree file as its problem, the rows they are, and samples of that table held out."""

    problem: Problem
    rows: Table
    held_out: Samples | None


def samples_of(
    problem: Problem, features: NDArray[np.float64], labels: NDArray[Any], weights: NDArray[np.float64]
) -> Samples:
    """Return samples with targets as the problem's loss reads them: numbers, or classes by their place."""
    if problem.loss.predicts == "number":
        return Samples(features, labels, weights)
    return Samples(features, codes_of(labels, problem.samples.class_names), weights)


def targets_of(loss: Loss | None, table: Table, column: str, known: Sequence[Any] | None = None) -> NDArray[Any]:
    """Return the targets of a table's rows: numbers of a loss of numbers, else classes by their names, shape (n_rows,).

    Raises
    ------
    DataError
        the column is missing, a cell is no number where numbers are predicted, or none of the `known` classes.
    """
    if loss is not None and loss.predicts == "number":
        return table.numbers([column], "target")[:, 0]
    return table.labels(column, known)


def columns_of(file: TreeFile, are_all: bool = True) -> Columns:
    """Return how the columns of a table become the features of a file, or how those do that its tree reads."""
    if file.preparation is None:
        columns = tuple(Column(name, "number", True) for name in file.feature_names)
    else:
        columns = file.preparation.columns.columns
    read = set(columns_read(file))
    return Columns(tuple(one for one in columns if are_all or any(item.name in read for item in one.features)))


def features_of(file: TreeFile, table: Table, are_all: bool = True) -> NDArray[np.float64]:
    """Return the features of a table's rows, encoded as in the tree's training, shape (n_rows, n_features).

    Unless they are all wanted, columns that the tree does not read need not be there, and their features are 0.

    Raises
    ------
    DataError
        columns are missing or hold what they did not in training; all of them are named.
    """
    columns = columns_of(file, are_all)
    try:
        if file.preparation is None and not file.settings["takes_missing"]:
            found = table.numbers(columns.names)
        elif columns.columns:
            found = columns.encode(table.frame, takes_missing=file.settings["takes_missing"])
        else:  # a leaf reads nothing
            found = np.zeros((len(table.frame), 0))
    except ColumnsError as error:
        raise DataError(f"{table.name}: {error}") from error
    if are_all:  # a large table is not copied
        return found
    features = np.zeros((len(table.frame), len(file.feature_names)))
    features[:, [file.feature_names.index(name) for name in columns.feature_names]] = found
    return features


def read_training(
    file: TreeFile,
    data: str,
    *,
    label: str | None = None,
    weights: str | None = None,
    source: str = "the tree file",
) -> Training:
    """Return the samples that a tree was trained on, read from its table.

    Parameters
    ----------
    file
        the tree file.
    data
        the table.
    label, weights
        columns, those of the training by default.
    source
        what a sentence calls the tree file.

    Raises
    ------
    DataError
        the table cannot be read or lacks a column.
    CertificateError
        it is not the one that the tree was trained on.
    """
    label, weights = label or file.target_column, weights or file.weights_column
    if label is None:
        raise DataError(f"{source} does not say which column held the target; name it with --label")
    table = prepared(file, read_table(data), label, weights)
    labels, features = targets_of(file.loss, table, label, file.class_names), features_of(file, table)
    weighed = table.numbers([weights], "weight")[:, 0] if weights else np.ones(len(labels))
    claim = file.held_out
    is_split = claim is not None and claim.share is not None
    is_held = np.zeros(len(labels), dtype=np.bool_)
    if claim is not None and claim.share is not None:
        is_held = held_out_rows(strata_of(file.loss, labels), claim.share, claim.seed)
    in_training = weighed[~is_held]
    if file.class_weight is not None:
        in_training = in_training * np.array(file.class_weight)[codes_of(labels[~is_held], file.class_names)]
    problem = file.problem(features[~is_held], labels[~is_held], in_training)
    if problem.digest() != file.sha256:
        raise CertificateError(
            f"{table.name} is not the table that {source} was trained on: sha256 {problem.digest()[:12]}.. of "
            f"{problem.samples.n_samples} samples, expected {file.sha256[:12]}... of {file.n_samples}; give that table"
        )
    held = samples_of(problem, features[is_held], labels[is_held], weighed[is_held]) if is_split else None
    return Training(problem, table.rows(~is_held), held)


def read_test(file: TreeFile, problem: Problem, data: str) -> Samples:
    """Return the samples of another table that a tree is tested on.

    Raises
    ------
    DataError
        the table cannot be read, lacks a column, or holds a class that training had not.
    """
    if file.target_column is None:
        raise DataError("the tree file does not say which column held the target; write it again with octmip solve")
    table = prepared(file, read_table(data), file.target_column, file.weights_column)
    labels = targets_of(file.loss, table, file.target_column, file.class_names)
    weights = table.numbers([file.weights_column], "weight")[:, 0] if file.weights_column else np.ones(len(labels))
    return samples_of(problem, features_of(file, table), labels, weights)


def prepared(file: TreeFile, table: Table, label: str, weights: str | None) -> Table:
    """Return a table of the rows that the training would have kept, in the units of the training."""
    table.refuse_other_units(file.readings.units)
    if file.preparation is None:
        return table
    needed = [*file.preparation.columns.names, *([weights] if weights else [])]
    return kept_rows(table, file.preparation.rows, label, needed)
