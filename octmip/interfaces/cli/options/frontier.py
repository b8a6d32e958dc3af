"""Show the least cost against depth, sensor budget or leaf penalty: one row per value, each with its bound.

The limits apply to each value separately. Each value starts from the tree of the one before, and bounds proven under
wider limits are used for the tighter ones. With --folds each depth or penalty also shows its cost on samples held out,
per unit of weight, and the best pair of depth and penalty is chosen.
"""

import argparse

from octmip.interfaces.cli.arguments import (
    METHOD,
    OUTPUT,
    add_everyday_arguments,
    add_flag,
    add_method_options,
    add_problem_arguments,
    add_run_arguments,
    group_of,
)
from octmip.interfaces.cli.picture import PICTURES
from octmip.interfaces.cli.samples.file_arguments import writes

OVERS = ("depth", "budget", "penalty")
EXAMPLES = """\
  octmip frontier iris.csv --label species --over depth --depth 4
  octmip frontier iris.csv --label species --over budget --depth 3 --out frontier.svg
  octmip frontier houses.csv --target price --over depth --depth 4
  octmip frontier iris.csv --label species --over penalty --depth 3 --folds 5
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip frontier`."""
    add_everyday_arguments(parser, seconds=60.0, has_target=True)
    group = parser.add_argument_group("frontier")
    group.add_argument("--over", choices=OVERS, required=True, help="setting to vary")
    group.add_argument(
        "--values",
        metavar="A,B,...",
        help="its values (default: depths 1 to D; 1, 2, ... sensors; a penalty for each tree on the frontier)",
    )
    group.add_argument("--folds", metavar="K", type=int, help="also cross-validate on K folds (depth, penalty)")
    out = group_of(parser, OUTPUT).add_argument(
        "--out", metavar="FILE", help=f"draw it in this file, one of {', '.join(PICTURES)}"
    )
    writes(out), writes(add_flag(group_of(parser, METHOD), "checkpoint", "FILE"))
    add_problem_arguments(parser)
    add_run_arguments(parser)
    add_flag(group_of(parser, METHOD), "cluster", "ADDRESS")
    add_method_options(parser)
