"""Run every method on one table, each within the same time limit, and show them side by side.

Each has its own gap, and the gap to the best bound that any of them proved: the most by which it can miss the optimum.
Beside it, how many seconds it took until its own tree and bound were within 10 %, 1 % and 0 % of each other.
The methods by HiGHS start from CART's tree, so that what they find beyond it is their own.

A method that cannot answer the problem is listed with the reason.
"""

import argparse

from octmip.interfaces.cli.arguments import (
    DATA,
    METHOD,
    TREE,
    add_everyday_arguments,
    add_method_options,
    add_problem_arguments,
    add_run_arguments,
    group_of,
    rarely,
)
from octmip.interfaces.cli.samples.options import add_held_out_arguments
from octmip.interfaces.cli.samples.part_arguments import add_part_arguments

EXAMPLES = """\
  octmip compare iris.csv --label species --depth 3
  octmip compare iris.csv --label species --depth 2 --holdout 0.25
  octmip compare iris.csv --label species --depth 3 --holdout 0.25 --baselines
  octmip compare houses.csv --target price --loss absolute --depth 3
  octmip compare iris.csv --label species --depth 2 --methods cart,search,exact --json
"""


def add_arguments(parser: argparse.ArgumentParser, of_folder: bool = False) -> None:
    """Add the arguments of `octmip compare`: of one table, or of a folder of them."""
    add_everyday_arguments(parser, seconds=60.0, has_target=True, of_folder=of_folder)
    if not of_folder:
        rarely(add_held_out_arguments(group_of(parser, DATA)))
    group_of(parser, METHOD).add_argument("--methods", metavar="A,B,...", help="methods to run (default: all)")
    if not of_folder:
        group_of(parser, METHOD).add_argument(
            "--baselines",
            action="store_true",
            help="beside them a linear model, pruned CART, a random forest and gradient boosting",
        )
    add_problem_arguments(parser)
    add_part_arguments(group_of(parser, TREE))
    add_run_arguments(parser, with_method=False)
    add_method_options(parser)
