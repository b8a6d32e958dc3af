"""From the arguments of a command and its table to a Problem.

1. what is predicted: classes (`--label`) or numbers (`--target`), and by which loss
2. the columns that the arguments choose, and the rows that they keep
3. columns as features (`octmip.formats.columns`): text encoded, missing cells allowed or refused
4. rows held out, from this table (`--holdout`) or from another (`--test`)
5. the Problem, with notes for the user about what changed on the way
"""

import argparse
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError, ProblemError
from octmip.formats.columns import Columns, ColumnsError
from octmip.formats.columns.written import words_of
from octmip.formats.held_out import HeldOut
from octmip.formats.table import Table, read_costs, read_sensors, read_table
from octmip.formats.table.preparation import Preparation, RowsKept, kept_rows
from octmip.input.messages import several, shown
from octmip.interfaces.cli.samples.classes import class_weight_of, order_of_column
from octmip.interfaces.cli.samples.mixtures import mixed_columns
from octmip.interfaces.cli.samples.names import listed_names, one_name
from octmip.interfaces.cli.samples.parts import parts_of
from octmip.interfaces.cli.samples.targets import refuse_quantity
from octmip.interfaces.cli.samples.training import samples_of, targets_of
from octmip.trees.question.classes import factors_of
from octmip.trees.question.losses import ClassCosts, Loss, NumberLoss, number_loss
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import splits_of
from octmip.trees.runs.registry import CAPABILITIES, lacked
from octmip.trees.tradeoff import Samples, Score
from octmip.trees.tradeoff.held_out import held_out_rows, strata_of

FEWEST_COUNTED = 20
"""Rows of a table from which on a column that goes up by one is taken for their number."""


@dataclass(frozen=True, slots=True, eq=False)
class TableProblem:
    """A problem and the table that it was read from.

    Attributes
    ----------
    problem
        over the training samples.
    target_column, weights_column
        of the table.
    preparation
        how the table became samples.
    notes
        sentences for the user about what was encoded or left out.
    held_out
        samples kept from training, None without such.
    share, seed
        of the table's rows that are held out; the share is None where there are none or another table has them.
    units
        that the table gives its columns.
    """

    problem: Problem
    target_column: str
    weights_column: str | None
    preparation: Preparation
    notes: tuple[str, ...]
    held_out: Samples | None
    share: float | None
    seed: int
    units: Mapping[str, str]

    def claim(self, score: Score | None) -> HeldOut | None:
        """Return what a tree file says of a tree with this score on the samples held out."""
        if score is None:
            return None
        return HeldOut(self.share, self.seed, score.n_samples, score.measures, score.cost)


@dataclass(frozen=True, slots=True)
class Chosen:
    """The columns that the arguments choose."""

    label: str
    weights: str | None
    index: str | None
    features: tuple[str, ...]

    @property
    def needed(self) -> tuple[str, ...]:
        """Features and weights."""
        return self.features if self.weights is None else (*self.features, self.weights)


def read_problem(arguments: argparse.Namespace) -> TableProblem:
    """Return the problem of a command line.

    Raises
    ------
    DataError
        a file does not hold what was announced.
    ProblemError
        no tree can answer.
    """
    loss = _loss(arguments)
    purpose, predicted = ("label", arguments.label) if loss is None else ("target", arguments.target)
    whole = read_table(arguments.data, as_text=arguments.index)
    chosen = _chosen_columns(whole, arguments, predicted, purpose)
    rows = _rows_kept(arguments)
    table = kept_rows(whole, rows, chosen.label, chosen.needed)
    labels = targets_of(loss, table, chosen.label)
    if loss is None and not arguments.numbers_are_classes:
        refuse_quantity(table, chosen.label, labels)
    preparation = Preparation(_learned_columns(table, chosen, arguments, loss), chosen.index, rows)
    features, weights = preparation.columns.encode(table.frame[list(chosen.features)]), _weights(table, chosen)
    share = getattr(arguments, "holdout", None)
    strata = labels if loss is None else strata_of(loss, labels)
    is_held = np.zeros(len(labels), dtype=np.bool_) if share is None else held_out_rows(strata, share, arguments.seed)
    training = features if share is None else features[~is_held]  # a large table is not copied without need
    settings = {} if loss is not None else order_of_column(table, chosen.label, labels, arguments)
    of_training = labels[~is_held], weights[~is_held]
    problem = _problem(arguments, loss, preparation.columns, training, *of_training, settings)
    if arguments.class_weight is not None:
        given = class_weight_of(arguments.class_weight, list(problem.samples.class_names))
        factors = factors_of(given, problem.samples.class_names, problem.samples.codes, problem.samples.weights)
        weighted = problem.samples.weights * factors[problem.samples.codes]
        problem = problem.replace(weights=weighted, leaf_weight=arguments.leaf_weight)
        preparation = replace(preparation, class_weight=tuple(factors.tolist()))
    held_out = samples_of(problem, features[is_held], labels[is_held], weights[is_held]) if share is not None else None
    if getattr(arguments, "test", None):
        held_out = _tested(arguments.test, problem, chosen, preparation, dict(whole.units))
    n_dropped = len(whole.frame) - len(table.frame)
    notes = *_notes_of(n_dropped, preparation.columns, whole), *_forms(table, chosen, purpose), *_missing(problem)
    beside = notes, held_out, share, arguments.seed, dict(whole.units)
    return TableProblem(problem, chosen.label, chosen.weights, preparation, *beside)


def _loss(arguments: argparse.Namespace) -> NumberLoss | None:
    """Return the loss of the numbers that are predicted; None where classes are."""
    if hasattr(arguments, "loss"):
        _check_predicted(arguments)
    if getattr(arguments, "target", None) is None:
        return None
    _refuse_options_of_classes(arguments)
    return number_loss(arguments.loss or "squared")


def _weights(table: Table, chosen: Chosen) -> NDArray[np.float64]:
    """Return the weights (n_rows,) of the rows, 1 where no column holds any."""
    return table.numbers([chosen.weights], "weight")[:, 0] if chosen.weights else np.ones(len(table.frame))


def _check_predicted(arguments: argparse.Namespace) -> None:
    """Raise a DataError unless one column is to be predicted, with no option about another kind of it."""
    given = [f"--{name}" for name in ("label", "target") if getattr(arguments, name) is not None]
    if len(given) != 1:
        raise DataError(
            f"the column to predict is named by {' and '.join(given) or 'no option'}; expected --label COL for classes "
            "or --target COL for numbers; give one of the two"
        )
    if arguments.target is None and (arguments.loss or arguments.leaf_model):
        option = "--loss" if arguments.loss else "--leaf-model"
        raise DataError(
            f"{option} is given with --label {arguments.label}, but is about regression trees; expected it with "
            f"--target; leave it out, or name a column of numbers with --target"
        )


def _refuse_options_of_classes(arguments: argparse.Namespace) -> None:
    for name in lacked("numbers", "word"):
        if getattr(arguments, name) not in (None, False):
            option = f"--{name.replace('_', '-')}"
            raise DataError(
                f"{option} is given with --target {arguments.target}, but is about {CAPABILITIES[name].words}; "
                f"expected options of regression trees; leave {option} out, or name a column of classes with --label"
            )


def _chosen_columns(table: Table, arguments: argparse.Namespace, label: str, purpose: str) -> Chosen:
    """Return the columns that the arguments choose; `label` is to be predicted, a sentence calls it by its purpose.

    Raises
    ------
    DataError
        the table lacks one, or one is chosen for two purposes.
    """
    label = one_name(table, label)
    table.column(label, purpose)
    weights, index = (value and one_name(table, value) for value in (arguments.weights, arguments.index))
    for name, use in ((weights, "weights"), (index, "index")):
        if name:
            table.column(name, use)
    taken = {label: f"the {purpose}", weights: "the weights", index: "the index"}
    dropped = listed_names(table, "--drop", arguments.drop)
    if arguments.features is None:
        features = [name for name in table.columns if name not in taken and name not in dropped]
        if not features:
            raise DataError(
                f"{table.name} has no column beside {several(name for name in taken if name)}; expected at least one "
                "feature; drop fewer columns"
            )
    else:
        features = listed_names(table, "--features", arguments.features)
    for option, names in (("--features", features), ("--drop", dropped)):
        wrong = [f"{shown(name)} ({taken[name]})" for name in names if name in taken]
        if wrong:
            raise DataError(f"{option} names {', '.join(wrong)}; expected other columns; leave it out")
    both = [name for name in dropped if name in features]
    if both:
        raise DataError(f"--features and --drop both name {several(both)}; expected one of the two; leave one out")
    return Chosen(label, weights, index, tuple(features))


def _rows_kept(arguments: argparse.Namespace) -> RowsKept:
    """Return which rows the arguments keep."""
    if arguments.missing == "drop-rows":
        return "complete"
    return "labelled" if arguments.drop_unlabelled else "all"


def _learned_columns(table: Table, chosen: Chosen, arguments: argparse.Namespace, loss: NumberLoss | None) -> Columns:
    """Return how the columns become features; refuse all that cannot, in one sentence with the switches that help.

    Of a loss of numbers, whose splits are cuts alone, numbers with missing cells become two complete features.
    """
    missing: Literal["either-side", "refuse"] = "either-side" if arguments.missing == "either-side" else "refuse"
    frame = table.frame[list(chosen.features)]
    reasons = {} if arguments.categories else mixed_columns(table, chosen.features)
    try:
        columns = Columns.learn(
            frame, categories=arguments.categories or "yes-no", missing=missing, doubled=loss is not None
        )
    except ColumnsError as error:
        reasons = dict(error.reasons) | reasons
    if reasons:
        raise DataError(f"{table.name}: {ColumnsError(reasons, len(chosen.features))}; {_cure(reasons)}")
    if _kind_of_split(arguments) == "hyperplane" or getattr(arguments, "leaf_model", None) == "linear":
        columns.refuse_missing_in_sums("leave these rows out by --missing drop-rows, or drop these columns: --drop")
    return columns


def _cure(names: Iterable[str]) -> str:
    cells = ['"' + name.replace('"', '""') + '"' if set(name) & set(',"') else name for name in names]
    return (
        f"to leave out what cannot be used: --drop {shlex.quote(','.join(cells))}; for the column that names the rows: "
        "--index; for text and missing cells: --categories, --missing"
    )


def _problem(
    arguments: argparse.Namespace,
    loss: Loss | None,
    columns: Columns,
    features: NDArray[np.float64],
    labels: NDArray[Any],
    weights: NDArray[np.float64],
    settings: dict[str, Any],
) -> Problem:
    settings = settings | _sensor_settings(arguments, columns)
    if loss is not None:
        settings |= {"loss": loss, "leaf_model": arguments.leaf_model or "constant", "target_name": arguments.target}
    if arguments.costs:
        classes = settings["class_order"] or sorted(set(labels.tolist()))
        settings |= {"loss": ClassCosts(read_costs(arguments.costs, classes)), "class_names": classes}
    features.flags.writeable = False  # the problem keeps it, and makes no copy
    return Problem(
        features,
        labels,
        weights=weights,
        depth=_depth(arguments),
        split=_kind_of_split(arguments),
        split_size=arguments.split_size,
        leaf_size=arguments.leaf_size,
        leaf_weight=arguments.leaf_weight if arguments.class_weight is None else None,  # else of the weights to come
        monotone=_directions(arguments.monotone),
        leaf_penalty=arguments.leaf_penalty,
        max_splits=splits_of(arguments.max_leaves, _kind_of_split(arguments), "--max-leaves"),
        sensor_budget=arguments.budget,
        takes_missing=columns.lack_numbers,
        feature_names=columns.feature_names,
        **parts_of(arguments, columns),
        **settings,
    )


def _depth(arguments: argparse.Namespace) -> Any:
    """Return the depth that is asked for; without one any (None) where splits have a price, else it is chosen (1)."""
    return 1 if arguments.depth is None and not arguments.leaf_penalty else arguments.depth


def _sensor_settings(arguments: argparse.Namespace, columns: Columns) -> dict[str, Any]:
    """Return sensors and their costs as a problem takes them: those of a file, or one for each column."""
    if not arguments.sensor_cost:
        return {"sensor_of_feature": columns.column_of_feature}
    sensors = read_sensors(arguments.sensor_cost, columns.names)
    of_column = dict(zip(columns.names, sensors.of_feature, strict=True))
    of_feature = [of_column[name] for name in columns.column_of_feature]
    return {"sensor_of_feature": of_feature, "sensor_cost": dict(sensors.cost)}


def _directions(words: str | None) -> dict[str | int, str | int] | None:
    """Return the directions that `--monotone` gives columns by name, None without it."""
    if words is None:
        return None
    pairs = [entry.rpartition("=") for entry in words.split(",")]
    wrong = [sign for name, _, sign in pairs if not name or sign not in ("+", "-")]
    if wrong:
        raise ProblemError(f"--monotone is {words!r}; expected COLUMN=+ or COLUMN=-, several joined by commas")
    return {name: sign for name, _, sign in pairs}


def _kind_of_split(arguments: argparse.Namespace) -> Literal["axis", "hyperplane"]:
    """Return the kind of split that the arguments ask for."""
    if arguments.split:
        return "axis" if arguments.split == "axis" else "hyperplane"
    return "hyperplane" if (arguments.split_size or 1) > 1 else "axis"


def _tested(path: str, problem: Problem, chosen: Chosen, preparation: Preparation, units: Mapping[str, str]) -> Samples:
    table = kept_rows(read_table(path), preparation.rows, chosen.label, chosen.needed)
    table.refuse_other_units(units)
    labels = targets_of(problem.loss, table, chosen.label, problem.samples.class_names)
    try:
        return samples_of(problem, preparation.columns.encode(table.frame), labels, _weights(table, chosen))
    except ColumnsError as error:
        raise DataError(f"{table.name}: {error}") from error


def _notes_of(n_dropped: int, columns: Columns, table: Table) -> tuple[str, ...]:
    """Return sentences for the user about what was encoded or left out."""
    left_out = (f"{n_dropped} row{'s' * (n_dropped != 1)} with missing cells left out",) if n_dropped else ()
    counts = tuple(
        f"the column {shown(name)} counts the rows; if it only names them, leave it out: --index or --drop"
        for name in columns.names
        if _counts_rows(table.frame[name])
    )
    return (*table.notes, *left_out, *counts, *columns.changes())


def _forms(table: Table, chosen: Chosen, purpose: str) -> tuple[str, ...]:
    """Return a sentence about each column of numbers beside the features that is written in a form of its own."""
    columns = ((chosen.label, "target"), (chosen.weights, "weight"))
    wanted = [(name, use) for name, use in columns if name and use in (purpose, "weight")]
    forms = [(name, table.form(name, use)) for name, use in wanted]
    return tuple(f"{name} read as {words_of(form)}" for name, form in forms if form)


def _missing(problem: Problem) -> tuple[str, ...]:
    """Return a sentence about the training readings that are missing; none where none is."""
    count = problem.samples.n_missing
    return (f"{count} training reading{'s are' if count > 1 else ' is'} missing",) if count else ()


def _counts_rows(column: "pd.Series[Any]") -> bool:
    """Whether a column of whole numbers goes up by one from row to row, as one that names the rows does."""
    return len(column) >= FEWEST_COUNTED and column.dtype.kind in "iu" and bool((column.diff().iloc[1:] == 1).all())
