"""Run every method on a table, or on every table of a folder, each within the same time limit, side by side.

Each has its own gap, and the gap to the best bound that any of them proved: the most by which it can miss the optimum.
Beside it, how many seconds it took until its own tree and bound were within 10 %, 1 % and 0 % of each other.
The methods by HiGHS start from CART's tree, so that what they find beyond it is their own.

A method that cannot answer the problem is listed with the reason.

Of a folder the first table counts for each method: on how many tables it answers, proves its tree and has the best tree
of all; its mean gap to the best bound that any method proved, at the end; its seconds until the proof, as a geometric
mean shifted by a second, where a tree without a proof counts the whole limit; and the share of tables that it proves
within 1, 2 and 10 times the time of the quickest method (Dolan & More 2002, Benchmarking optimization software with
performance profiles).
"""

import argparse

from octmip.interfaces.cli.arguments import (
    DATA,
    METHOD,
    OUTPUT,
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

PICTURE, ROWS = "benchmark.svg", "rows.csv"
EXAMPLES = """\
  octmip compare iris.csv --label species --depth 3
  octmip compare iris.csv --label species --depth 2 --holdout 0.25
  octmip compare iris.csv --label species --depth 3 --holdout 0.25 --baselines
  octmip compare houses.csv --target price --loss absolute --depth 3
  octmip compare iris.csv --label species --depth 2 --methods cart,search,exact --json
  octmip compare tables/ --label class --depth 3 --methods cart,search,exact,flow --out figures
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip compare`."""
    add_everyday_arguments(parser, seconds=60.0, has_target=True, or_folder=True)
    rarely(add_held_out_arguments(group_of(parser, DATA)))
    group_of(parser, METHOD).add_argument("--methods", metavar="A,B,...", help="methods to run (default: all)")
    group_of(parser, METHOD).add_argument(
        "--baselines",
        action="store_true",
        help="beside them a linear model, pruned CART, a random forest and gradient boosting",
    )
    add_problem_arguments(parser)
    add_part_arguments(group_of(parser, TREE))
    add_run_arguments(parser, with_method=False)
    group_of(parser, OUTPUT).add_argument(
        "--out",
        metavar="FOLDER",
        help=f"of a folder of tables: folder to fill with {PICTURE} (profile, gaps over time) and {ROWS}",
    )
    add_method_options(parser)
