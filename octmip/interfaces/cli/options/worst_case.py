"""Find the tree of least worst case while gauges are off by up to given amounts, and prove it to depth 2.

In the worst case each reading of the gauges that are off is wrong by its own amount, so that samples inside the band
around a cut count on both sides. Beyond depth 2 the tree comes from local search, with the bound of trees without
reading errors. Reaching a limit is no error, nor is Ctrl-C: the best tree so far and its bound are shown and written.
"""

import argparse

from octmip.interfaces.cli.arguments import (
    OUTPUT,
    add_everyday_arguments,
    add_problem_arguments,
    add_run_arguments,
    group_of,
)
from octmip.interfaces.cli.samples.file_arguments import writes

EXAMPLES = """\
  octmip worst-case iris.csv --label species --depth 2 --off 0.3
  octmip worst-case iris.csv --label species --depth 2 --off "petal width=0.2" --off "petal length=0.1:0.4"
  octmip worst-case strains.csv --label state --depth 3 --off 21 --gauges-off 2 --seconds 60 --threads 2 --out tree.json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip worst-case`."""
    add_everyday_arguments(parser)
    group = parser.add_argument_group("reading errors")
    group.add_argument(
        "--off",
        metavar="[GAUGE=]AMOUNT",
        action="append",
        required=True,
        help="most that readings of this column or sensor are off, of all without a name; or BELOW:ABOVE",
    )
    group.add_argument("--gauges-off", metavar="K", type=int, default=1, help="most gauges off at a time (default 1)")
    writes(
        group_of(parser, OUTPUT).add_argument(
            "--out", metavar="TREE.json", help="write the tree to this file, with what it costs without reading errors"
        )
    )
    add_problem_arguments(parser)
    add_run_arguments(parser, with_method=False)
