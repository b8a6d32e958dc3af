"""Find the best tree for a table within the limits, and the bound that proves how good it is.

The result is certified (recomputed from tree and data alone) before it is shown. Reaching a limit is no error, nor is
Ctrl-C: the best tree so far and its bound are shown and written.
"""

import argparse

from octmip.interfaces.cli.arguments import (
    add_cluster_argument,
    add_everyday_arguments,
    add_problem_arguments,
    add_run_arguments,
)
from octmip.interfaces.cli.samples.file_arguments import reads, writes
from octmip.interfaces.cli.samples.options import add_held_out_arguments
from octmip.trees.methods.options import ASSISTANTS

EXAMPLES = """\
  octmip solve iris.csv --label species --depth 2
  octmip solve iris.csv --label species --depth 3 --holdout 0.25 --out tree.json
  octmip solve survey.csv.gz --label answer --depth 3 --index person --drop remarks,"name, first"
  octmip solve machines.parquet --label state --depth 4 --seconds 60 --sensor-cost sensors.csv --budget 10
  octmip solve houses.csv --target price --loss absolute --depth 3 --out tree.json
  zcat big.csv.gz | octmip solve - --label class --depth 2 --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip solve`."""
    group = add_everyday_arguments(parser, has_target=True)
    add_held_out_arguments(group)
    writes(group.add_argument("--out", metavar="TREE.json", help="write the tree to this file"))
    add_problem_arguments(parser)
    add_run_arguments(parser)
    add_cluster_argument(parser)
    group = parser.add_argument_group("more files")
    reads(group.add_argument("--incumbent", metavar="TREE.json", help="start from this tree of the problem"))
    model = group.add_argument("--write", metavar="MODEL", help="also write the mixed-integer model (.mps or .lp file)")
    group.add_argument(
        "--assist",
        nargs="+",
        choices=ASSISTANTS,
        help="give HiGHS the exact core's bound, or trees of local search while it runs (oct, oct_h, flow)",
    )
    log = group.add_argument(
        "--proof",
        metavar="LOG",
        help="write a proof log that octmip certify --proof checks (exact)",
    )
    kept = group.add_argument(
        "--checkpoint",
        metavar="FILE",
        help="keep what is proven in this file, and resume from it where it exists (exact, axis)",
    )
    group.add_argument(
        "--every", metavar="S", type=float, help="seconds between two checkpoints (default 60; with --checkpoint)"
    )
    problem = group.add_argument(
        "--write-problem",
        metavar="FILE",
        help="write the problem, samples included, to this JSON file for octmip-check",
    )
    for action in (model, log, kept, problem):
        writes(action)
