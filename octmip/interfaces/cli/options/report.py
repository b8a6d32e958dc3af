"""Show a tree file in words on standard output, or write it as a file of the kind that its ending names.

.html  a page to read and to send    .md  Markdown    .txt  words    .svg .png .pdf  a drawing
.sql  an expression over your own columns    .c  a function    .onnx  a model    .json  the tree file itself

With DATA, the table that the tree was trained on, every claim is recounted, and the report also has the greedy tree
(CART), the error on samples held out, and in a page trees of lower depth and the samples in each leaf.
"""

import argparse

from octmip.interfaces.cli.options.page import add_page_arguments
from octmip.interfaces.cli.samples.file_arguments import reads, writes
from octmip.interfaces.cli.samples.options import TABLE_HELP

EXPORTS = (".sql", ".c", ".onnx", ".json")
KINDS = (".html", ".md", ".txt", ".svg", ".png", ".pdf", *EXPORTS)
EXAMPLES = """\
  octmip report tree.json
  octmip report tree.json iris.csv --out iris.html
  octmip report tree.json strains.csv --unit microstrain --out strains.html
  octmip report tree.json train.csv --test test.csv --unit age=years --unit weight=kg --out page.html
  octmip report tree.json --out tree.sql
  octmip report tree.json pumps.csv --title "When a pump fails" --asset "Hall 2" --out pumps.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip report`."""
    group = parser.add_argument_group("everyday")
    reads(group.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out"))
    reads(group.add_argument("data", metavar="DATA", nargs="?", help=f"the table that it was trained on; {TABLE_HELP}"))
    writes(
        group.add_argument(
            "--out", metavar="FILE", help=f"one of {', '.join(KINDS)} (default: words on standard output)"
        )
    )
    reads(group.add_argument("--test", metavar="FILE", help="another table to test the tree on"))
    group.add_argument(
        "--table", metavar="NAME", default="", help="write this table's name before each column in .sql (default: none)"
    )
    group = parser.add_argument_group("page and drawing")
    add_page_arguments(group, "COL", "unit of the numbers, of one column or of all; may be given several times")
    group.add_argument(
        "--histograms",
        action="store_true",
        help="show at each split the values of the samples that come to it, in a page or a drawing; needs DATA",
    )
    group.add_argument("--dark", action="store_true", help="draw .svg, .png or .pdf on a dark ground")
    reads(group.add_argument("--proof", metavar="LOG", help="also check this proof log of octmip solve --proof"))
    group.add_argument(
        "--seconds",
        metavar="S",
        type=float,
        default=10.0,
        help="time for trees of lower depth, a tenth of it for other columns at the splits (default 10; 0: none)",
    )
