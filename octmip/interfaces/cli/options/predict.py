"""Apply a tree file to a table: one prediction for each row, as CSV on standard output or in a file.

The columns that the tree reads must be in the table, and are encoded as in its training. A tree that was trained where
readings were missing has a side for missing ones at every split, and takes them in any column of numbers. The column
that named the rows in training (solve --index) is written before the predictions. With --label the predictions are also
compared with the true classes, in the rows that have one.

Class names are written as they are, so that a program reads back what was trained on; on a terminal, control
characters are shown as escapes. A spreadsheet takes a cell that begins with one of = + - @ for a formula: import such
a file as text.
"""

import argparse

from octmip.interfaces.cli.arguments import add_json_argument
from octmip.interfaces.cli.samples.file_arguments import reads, writes
from octmip.interfaces.cli.samples.options import TABLE_HELP

EXAMPLES = """\
  octmip predict tree.json new.csv
  octmip predict tree.json new.csv --proba --index person --out predictions.csv
  cat new.csv | octmip predict tree.json - | head
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip predict`."""
    group = parser.add_argument_group("everyday")
    reads(group.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out"))
    reads(group.add_argument("data", metavar="DATA", help=TABLE_HELP))
    writes(group.add_argument("--out", metavar="FILE.csv", help="write the predictions to this file"))
    group.add_argument(
        "--proba",
        action="store_true",
        help="add each class's share of the training samples in the leaf",
    )
    group.add_argument(
        "--label",
        metavar="COL",
        help="column with the true class or number (default of numbers: as trained)",
    )
    group.add_argument("--index", metavar="COL", help="column that names the rows (default: that of the training)")
    group = parser.add_argument_group("more")
    add_json_argument(group)
