"""Recompute what a tree file claims, sample by sample, from the tree and its training data alone.

What the file says of samples held out is recomputed, too. With --proof, a checker that knows no solver also checks a
proof log: that no tree of the problem costs less than the bound. Exit code 0: every claim holds. 1: one does not, and
one line says which. 2: a file cannot be read.
"""

import argparse

from octmip.interfaces.cli.arguments import add_json_argument
from octmip.interfaces.cli.samples.file_arguments import reads
from octmip.interfaces.cli.samples.options import TABLE_HELP

EXAMPLES = """\
  octmip certify tree.json iris.csv
  octmip certify tree.json train.csv --test test.csv
  octmip certify tree.json iris.csv --proof proof.log --threads 2
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip certify`."""
    group = parser.add_argument_group("everyday")
    reads(group.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out"))
    reads(group.add_argument("data", metavar="DATA", help=f"the table that it was trained on; {TABLE_HELP}"))
    reads(group.add_argument("--proof", metavar="LOG", help="also check this proof log of octmip solve --proof"))
    reads(group.add_argument("--test", metavar="FILE", help="the other table that it was tested on (solve --test)"))
    group = parser.add_argument_group("table")
    group.add_argument("--label", metavar="COL", help="column with the class or number (default: that of the training)")
    group.add_argument("--weights", metavar="COL", help="column with the weights (default: that of the training)")
    group = parser.add_argument_group("run")
    group.add_argument("--threads", metavar="N", type=int, default=1, help="threads of the proof check (default 1)")
    add_json_argument(group)
