"""How a command line asks for parts of a tree: given splits, rules for paths, an old tree to stay near."""

import argparse

from octmip.interfaces.cli.arguments import rarely
from octmip.interfaces.cli.samples.file_arguments import reads
from octmip.trees.question.parts import RULES

FIX_HELP = "this split stands there: ROOT=g05, L=g01<=3.2 (left of the root), LR=leaf; may be given several times"


def add_part_arguments(group: argparse._ArgumentGroup) -> None:
    """Add the arguments that give parts of the tree, or rule some out."""
    rules = f"which columns may not meet on a path: {', '.join(RULES)}; not-below=B,A: B never below A"
    rarely(group.add_argument("--fix", metavar="NODE=SPLIT", action="append", default=[], help=FIX_HELP))
    rarely(group.add_argument("--path-rule", metavar="RULE=A,B", action="append", default=[], help=rules))
    reads(rarely(group.add_argument("--old-tree", metavar="TREE.json", help="stay near this tree (--max-changes)")))
    changes = "at most K splits differ from those of --old-tree: new, gone or other ones"
    rarely(group.add_argument("--max-changes", metavar="K", type=int, help=changes))
