"""Show what each sensor is worth: the optimum without it, and the optimum of the trees that read it.

needed: every near-optimal tree reads it; useless: none does; replaceable: some do, some do not. Near-optimal are the
trees up to --within above the optimum. Every figure is proven; where time was too short a question mark stands behind.
"""

import argparse

from octmip.interfaces.cli.arguments import (
    OUTPUT,
    add_everyday_arguments,
    add_problem_arguments,
    add_run_arguments,
    group_of,
)
from octmip.interfaces.cli.picture import PICTURES
from octmip.interfaces.cli.samples.file_arguments import writes
from octmip.interfaces.cli.sets.amount import add_amount

EXAMPLES = """\
  octmip sensors iris.csv --label species --depth 2
  octmip sensors strains.csv --label state --depth 3 --within 1% --threads 2 --out sensors.svg
  octmip sensors strains.csv --label state --depth 2 --pairs --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip sensors`."""
    add_everyday_arguments(parser)
    group = parser.add_argument_group("sensors")
    add_amount(group, "0")
    group.add_argument("--pairs", action="store_true", help="also the optimum without each two sensors")
    writes(
        group_of(parser, OUTPUT).add_argument(
            "--out", metavar="FILE", help=f"draw the table in this file, one of {', '.join(PICTURES)}"
        )
    )
    add_problem_arguments(parser)
    add_run_arguments(parser, with_method=False)
