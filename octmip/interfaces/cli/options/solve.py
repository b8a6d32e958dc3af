"""Find the best tree for a table within the limits, and the bound that proves how good it is.

Without --depth it is the best tree for new rows, as cross-validation tells: its kind, depth and leaf penalty are chosen
for them. With --depth it is the tree of least cost on the rows of the table, with --leaf-penalty and no --depth the one
of least cost and prices of splits among trees of any depth.

The result is certified (recomputed from tree and data alone) before it is shown. Reaching a limit is no error, nor is
Ctrl-C: the best tree so far and its bound are shown and written.
"""

import argparse

from octmip.interfaces.cli.arguments import (
    DATA,
    METHOD,
    OUTPUT,
    TREE,
    add_everyday_arguments,
    add_flag,
    add_method_options,
    add_problem_arguments,
    add_run_arguments,
    group_of,
    rarely,
)
from octmip.interfaces.cli.samples.file_arguments import reads, writes
from octmip.interfaces.cli.samples.options import add_held_out_arguments
from octmip.interfaces.cli.samples.part_arguments import add_part_arguments

EXAMPLES = """\
  octmip solve iris.csv --label species
  octmip solve iris.csv --label species --depth 2
  octmip solve iris.csv --label species --leaf-penalty 1.5
  octmip solve iris.csv --label species --depth 3 --holdout 0.25 --out tree.json
  octmip solve survey.csv.gz --label answer --depth 3 --index person --drop remarks,"name, first"
  octmip solve machines.parquet --label state --depth 4 --seconds 60 --sensor-cost sensors.csv --budget 10
  octmip solve houses.csv --target price --loss absolute --depth 3 --out tree.json
  octmip solve iris.csv --label species --depth 1 --method flow --option write=iris.lp
  octmip solve iris.csv --label species --depth 1 --read-solution iris.sol --of-model iris.lp --stated-bound 50
  zcat big.csv.gz | octmip solve - --label class --depth 2 --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip solve`."""
    add_everyday_arguments(parser, has_target=True, chooses=True)
    rarely(add_held_out_arguments(group_of(parser, DATA)))
    add_problem_arguments(parser)
    add_part_arguments(group_of(parser, TREE))
    output, method = group_of(parser, OUTPUT), group_of(parser, METHOD)
    writes(output.add_argument("--out", metavar="TREE.json", help="write the tree to this file"))
    add_run_arguments(parser)
    reads(rarely(method.add_argument("--incumbent", metavar="TREE.json", help="start from this tree of the problem")))
    foreign = method.add_argument(
        "--read-solution", metavar="FILE.sol", help="certify the solution that another solver wrote for a model's file"
    )
    model = method.add_argument(
        "--of-model", metavar="FILE", help="the model's file, by whose first line table and method are checked"
    )
    for action in (foreign, model):
        reads(rarely(action))
    rarely(
        method.add_argument(
            "--stated-bound", metavar="B", type=float, help="the lower bound that the other solver stated"
        )
    )
    add_flag(method, "cluster", "ADDRESS")
    writes(add_flag(method, "checkpoint", "FILE"))
    add_method_options(parser)
    writes(add_flag(output, "proof", "LOG"))
    problem = output.add_argument(
        "--write-problem",
        metavar="FILE",
        help="write the problem, samples included, to this JSON file for octmip-check",
    )
    writes(rarely(problem))
