"""Run every method on every table of a folder, each within the same time limit, and show how the methods compare.

For each method: on how many tables it answers, proves its tree and has the best tree of all; its mean gap to the best
bound that any method proved, at the end; its seconds until the proof, as a geometric mean shifted by a second, where a
tree without a proof counts the whole limit; and the share of tables that it proves within 1, 2 and 10 times the time of
the quickest method (Dolan & More 2002, Benchmarking optimization software with performance profiles).

The rows of each table are those of `octmip compare`.
"""

import argparse

from octmip.interfaces.cli.arguments import OUTPUT, group_of
from octmip.interfaces.cli.options import compare

PICTURE, ROWS = "benchmark.svg", "rows.csv"
EXAMPLES = """\
  octmip benchmark tables/ --depth 2 --seconds 10
  octmip benchmark tables/ --label class --depth 3 --methods cart,search,exact,flow --out figures
  octmip benchmark tables/ --target price --depth 2 --methods search,exact --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip benchmark`: those of `octmip compare`, over a folder."""
    compare.add_arguments(parser, of_folder=True)
    group_of(parser, OUTPUT).add_argument(
        "--out", metavar="FOLDER", help=f"folder that is made or filled: {PICTURE} (profile, gaps over time) and {ROWS}"
    )
