"""Apply a tree file to a table: `octmip.interfaces.cli.options.predict` says how the command is called."""

import argparse
import csv
import io
import sys
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.table import Table, read_table
from octmip.formats.tree_file import TreeFile, read_tree_file
from octmip.input.files import write_bytes
from octmip.input.names import visible, visible_lines
from octmip.interfaces.cli.answer import print_json, then_written
from octmip.interfaces.cli.samples.names import one_name
from octmip.interfaces.cli.samples.training import columns_of, features_of, targets_of
from octmip.trees.answer.certificate import shares_in_leaves
from octmip.trees.nodes.tree import leaf_index, leaves, predict_values
from octmip.trees.question.classes import codes_of

MADE = "shares of the training rows, which are too high for fresh ones"


def run(arguments: argparse.Namespace) -> int:
    """Predict and show."""
    file = read_tree_file(arguments.tree)
    if arguments.proba and file.loss.predicts == "number":
        raise DataError(
            f"--proba adds shares of classes, but {arguments.tree} predicts numbers; expected a tree of classes; leave "
            "it out"
        )
    trained = None if file.preparation is None else file.preparation.index
    table = read_table(arguments.data, as_text=arguments.index or trained)
    table.refuse_other_units(file.readings.units)
    features = features_of(file, table, are_all=False)
    reached = leaf_index(file.tree, features)
    predicted = _predicted(file, features, reached)
    predictions = predicted.tolist() if not file.class_names else [file.class_names[code] for code in predicted]
    shares = shares_in_leaves(file.leaf_counts)[reached].tolist() if arguments.proba else None
    index = _index(arguments.index, file, table)
    label = arguments.label or _known_target(file, table)
    counted = _counted(file, table, label, predicted) if label else None
    content = _csv(file, predictions, shares, index)
    how = (f"probabilities are {MADE}",) * (shares is not None)
    # A name that no file can hold is said beforehand; JSON has escapes for it.
    encoded = _utf8(content) if arguments.out or not arguments.json else b""
    with then_written(arguments.out, partial(write_bytes, content=encoded), is_quiet=True):
        if arguments.json:
            told = {"class_names": list(file.class_names), "probabilities": shares, "probabilities_made": MADE}
            probabilities = {} if shares is None else told
            names = {} if index is None else {"index": index[1]}
            print_json(
                {"n_samples": len(predictions), "n_missing": int(np.isnan(features).sum())}
                | {**(counted or {}), **names, "predictions": predictions, **probabilities}
            )
            return 0
        if not arguments.out:
            print(visible_lines(content) if sys.stdout.isatty() else content, end="")
        for note in (*table.notes, *how, *_unseen(file, table), *_missing(features)):
            print(f"note: {visible(note)}", file=sys.stderr)
        if counted is not None:
            print(_errors_text(file, counted, len(predictions)), file=sys.stderr)
    return 0


def _missing(features: NDArray[np.float64]) -> tuple[str, ...]:
    """Return a sentence about readings that are missing; none where none is."""
    is_missing = np.isnan(features)
    if not is_missing.any():
        return ()
    count, rows = int(is_missing.sum()), int(is_missing.any(axis=1).sum())
    return (
        f"{count} of the readings that the tree may ask for {'are' if count > 1 else 'is'} missing, in {rows} of "
        f"{len(features)} rows; each split sends them to the side that training chose",
    )


def _unseen(file: TreeFile, table: Table) -> Sequence[str]:
    return () if file.preparation is None else columns_of(file, are_all=False).unseen(table.frame)


def _index(option: str | None, file: TreeFile, table: Table) -> tuple[str, list[str]] | None:
    """Return the name and the cells of the column that names the rows; that of the training where it is there."""
    name = None if file.preparation is None else file.preparation.index
    if option is not None:
        name = one_name(table, option)
    elif name not in table.columns:
        return None
    assert name is not None
    cells = table.column(name, "index")
    is_missing = cells.isna().tolist()
    return name, ["" if gone else str(cell) for cell, gone in zip(cells.tolist(), is_missing, strict=True)]


def _predicted(file: TreeFile, features: NDArray[np.float64], reached: NDArray[np.int64]) -> NDArray[Any]:
    """Return what the tree predicts for each row (n_rows,): the index of its class, or a number."""
    if not file.class_names:
        return predict_values(file.tree, features, reached)
    return np.array([leaf.label for leaf in leaves(file.tree)], dtype=np.int64)[reached]


def _known_target(file: TreeFile, table: Table) -> str | None:
    """Return the column of the training's numbers where the table has some of them."""
    name = file.target_column
    is_there = file.loss.predicts == "number" and name is not None and name in table.columns
    return name if is_there and name is not None and not table.missing(name, "target").all() else None


def _counted(file: TreeFile, table: Table, label: str, predicted: NDArray[Any]) -> dict[str, float]:
    """Return what the predictions are judged by, all rows alike, and how many rows have no label."""
    label = one_name(table, label)
    is_missing = table.missing(label, "label")
    if is_missing.all():
        raise DataError(f"{table.name}, column {label!r}: no row has a label; expected some; leave --label out")
    known = table.rows(~is_missing).with_plain_numbers(label) if is_missing.any() else table
    targets = targets_of(file.loss, known, label, file.class_names)
    if file.class_names:
        targets = codes_of(targets, file.class_names)
    measures = dict(file.loss.measures(np.ones(len(targets)), targets, predicted[~is_missing]))
    return measures | ({"n_unlabelled": int(is_missing.sum())} if is_missing.any() else {})


def _errors_text(file: TreeFile, counted: dict[str, float], n_samples: int) -> str:
    without = int(counted.get("n_unlabelled", 0))
    without_label = f"; {without} more row{'s have' if without > 1 else ' has'} no label" if without else ""
    return f"{file.loss.words_of(counted, n_samples - without)}{without_label}"


def _csv(
    file: TreeFile, predictions: list[Any], shares: list[list[float]] | None, index: tuple[str, list[str]] | None
) -> str:
    names = [f"share of {name}" for name in file.class_names] if shares is not None else []
    lines = [_csv_line([*([index[0]] if index else []), "prediction", *names])]
    for row, label in enumerate(predictions):
        cells = [*([index[1][row]] if index else []), label, *(shares[row] if shares is not None else ())]
        lines.append(_csv_line(cells))
    return "".join(lines)


def _csv_line(cells: list[Any]) -> str:
    """Return one line, ended by a line feed; with that end alone the csv module would not quote a carriage return."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerow(cells)
    return text.getvalue().removesuffix("\r\n") + "\n"


def _utf8(content: str) -> bytes:
    """Return the bytes of a text.

    Raises
    ------
    DataError
        a class name holds half of a surrogate pair, which no encoding has.
    """
    try:
        return content.encode()
    except UnicodeEncodeError as error:
        line = visible(content[: error.start + 1].rpartition("\n")[2])
        raise DataError(
            f"the class name in {line} holds half of a surrogate pair, which no file can hold; expected text that "
            "UTF-8 encodes; use --json, or rename the class"
        ) from error
