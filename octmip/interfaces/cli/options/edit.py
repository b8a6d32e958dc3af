"""Say what a change of a tree costs: the best tree that has these splits, proven, beside the tree of the file.

Everything else is as it was asked of the tree: table, depth, costs, limits. All other splits are free, or, with
--max-changes, at most so many of the file's splits change. A node is named by the way to it: ROOT, L (left of the
root: the first branch that is printed), R, LL, LR and so on. With ? for a split, the best tree with each column there
is listed.
"""

import argparse

from octmip.interfaces.cli.arguments import add_json_argument
from octmip.interfaces.cli.samples.file_arguments import reads, writes
from octmip.interfaces.cli.samples.options import TABLE_HELP
from octmip.interfaces.cli.samples.part_arguments import FIX_HELP

EXAMPLES = """\
  octmip edit tree.json iris.csv --set ROOT=petal_width
  octmip edit tree.json iris.csv --set ROOT="petal_width<=0.8" --set R=sepal_length --out edited.json
  octmip edit tree.json iris.csv --set ROOT=?
  octmip edit tree.json iris.csv --set L=leaf --max-changes 2
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip edit`."""
    group = parser.add_argument_group("everyday")
    reads(group.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out"))
    reads(group.add_argument("data", metavar="DATA", help=f"the table that it was trained on; {TABLE_HELP}"))
    group.add_argument("--set", metavar="NODE=SPLIT", action="append", default=[], help=FIX_HELP)
    group.add_argument(
        "--max-changes", metavar="K", type=int, help="at most K splits differ from the file's: new, gone or other ones"
    )
    writes(group.add_argument("--out", metavar="NEW.json", help="write the best tree with these splits to this file"))
    group = parser.add_argument_group("run")
    group.add_argument("--seconds", metavar="S", type=float, default=60.0, help="stop after S seconds (default 60)")
    add_json_argument(group)
