"""Apply a tree file to a table: one prediction for each row, as CSV on standard output or in a file.

With --label the predictions are also compared with the true classes.

Class names are written as they are, so that a program reads back what was trained on; on a terminal, control
characters are shown as escapes. A spreadsheet takes a cell that begins with one of = + - @ for a formula: import such
a file as text.
"""

import argparse
import csv
import io
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.cli.answer import print_json
from octmip.cli.arguments import add_json_argument
from octmip.errors import DataError
from octmip.formats.files import check_writable, write_bytes
from octmip.formats.names import visible, visible_lines
from octmip.formats.table import Table, read_table
from octmip.formats.tree_file import TreeFile, columns_read, read_tree_file
from octmip.tree import leaf_index, leaves


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip predict`."""
    parser.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out")
    parser.add_argument("data", metavar="DATA", help="table with the features that the tree reads, .csv or .parquet")
    parser.add_argument("--label", metavar="COL", help="column with the true class, to count the errors")
    parser.add_argument(
        "--probabilities", action="store_true", help="add each class's share of the training samples in the leaf"
    )
    parser.add_argument("--out", metavar="FILE.csv", help="write the predictions to this file")
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Predict and show."""
    if arguments.out:
        check_writable(arguments.out)
    file = read_tree_file(arguments.tree)
    table = read_table(arguments.data)
    reached = leaf_index(file.tree, _features(file, table))
    labels = [file.class_names[leaf.label] for leaf in leaves(file.tree)]
    predictions = [labels[leaf] for leaf in reached.tolist()]
    errors = None
    if arguments.label:
        true = table.labels(arguments.label, file.class_names).tolist()
        errors = sum(predicted != label for predicted, label in zip(predictions, true, strict=True))
    shares = _shares(file)[reached].tolist() if arguments.probabilities else None
    content = _csv(file, predictions, shares)
    if arguments.out:
        write_bytes(arguments.out, _utf8(content))
    if arguments.json:
        counted = {} if errors is None else {"errors": errors}
        probabilities = {} if shares is None else {"class_names": list(file.class_names), "probabilities": shares}
        print_json({"n_samples": len(predictions), **counted, "predictions": predictions, **probabilities})
    elif not arguments.out:
        _utf8(content)  # its sentence about names that no file can hold
        print(visible_lines(content) if sys.stdout.isatty() else content, end="")
    if errors is not None and not arguments.json:
        print(f"{errors} of {len(predictions)} samples wrong", file=sys.stderr)
    return 0


def _features(file: TreeFile, table: Table) -> NDArray[np.float64]:
    """Return the features that the tree reads, in their places among all (the others 0: no split looks there)."""
    features = np.zeros((len(table.frame), len(file.feature_names)))
    for name in columns_read(file):
        features[:, file.feature_names.index(name)] = table.numbers([name])[:, 0]
    return features


def _shares(file: TreeFile) -> NDArray[np.float64]:
    totals = file.leaf_counts.sum(axis=1, keepdims=True)
    return np.asarray(file.leaf_counts / np.maximum(totals, 1))


def _csv(file: TreeFile, predictions: list[Any], shares: list[list[float]] | None) -> str:
    names = [f"share of {name}" for name in file.class_names] if shares is not None else []
    lines = [_csv_line(["prediction", *names])]
    lines += [_csv_line([label, *(shares[row] if shares is not None else ())]) for row, label in enumerate(predictions)]
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
