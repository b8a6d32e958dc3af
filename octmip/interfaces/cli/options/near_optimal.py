"""Count all trees near the optimum: by the column at their root, by cost, and by what they read.

The count is exact and the trees are not written out; the best of them and uniform samples are shown on request.
Reaching a limit is no error, nor is Ctrl-C: what is counted for certain is shown, and where trees may be that are not.
"""

import argparse

from octmip.interfaces.cli.arguments import add_everyday_arguments, add_problem_arguments, add_run_arguments
from octmip.interfaces.cli.sets.amount import add_amount

EXAMPLES = """\
  octmip near-optimal iris.csv --label species --depth 2 --within 1
  octmip near-optimal iris.csv --label species --depth 2 --within 10% --best 3
  octmip near-optimal strains.csv --label state --depth 3 --within 1% --sets --threads 2 --seconds 60 --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip near-optimal`."""
    add_everyday_arguments(parser)
    group = parser.add_argument_group("near-optimal")
    add_amount(group, "1%")
    group.add_argument("--best", metavar="N", type=int, default=0, help="show the N best trees (default 0)")
    group.add_argument("--sample", metavar="N", type=int, default=0, help="show N trees drawn uniformly (default 0)")
    group.add_argument("--sets", action="store_true", help="also count by the set of sensors that the trees read")
    add_problem_arguments(parser)
    add_run_arguments(parser, with_method=False)
