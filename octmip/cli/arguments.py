"""Arguments that several commands share; nothing here is slow to import."""

import argparse
import math
from typing import NoReturn

from octmip.errors import DataError
from octmip.formats.checked import shown
from octmip.solution import Limits
from octmip.solver import METHODS

MOST_THREADS = 1024


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, like every other error of the command."""

    def __init__(self, prog: str, description: str | None) -> None:
        super().__init__(
            prog=prog,
            description=description,
            allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse as a DataError."""
        raise DataError(f"{message}; see {self.prog} --help")


def add_problem_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the table and the arguments that describe the tree."""
    parser.add_argument("data", metavar="DATA", help="table of samples, .csv or .parquet")
    group = parser.add_argument_group("tree")
    group.add_argument("--label", metavar="COL", required=True, help="column with the class of each sample")
    group.add_argument("--depth", metavar="D", type=int, required=True, help="levels of splits")
    group.add_argument("--features", metavar="A,B,...", help="columns to split on (default: all but label and weights)")
    group.add_argument(
        "--split", choices=("axis", "hyperplane"), help="kind of split (default axis; hyperplane with --split-size > 1)"
    )
    group.add_argument("--split-size", metavar="K", type=int, help="at most K features in one split")
    group.add_argument(
        "--allowed-splits", metavar="FILE", help="text file: on each line the features that may meet in one split"
    )
    group.add_argument("--integer-normals", metavar="N", type=int, help="hyperplane coefficients are integers up to N")
    group.add_argument("--leaf-size", metavar="N", type=int, default=1, help="at least N samples in a leaf (default 1)")
    group.add_argument(
        "--leaf-penalty", metavar="P", type=float, default=0.0, help="price of one feature in one split (default 0)"
    )
    group.add_argument("--weights", metavar="COL", help="column with the risk weight of each sample (default: all 1)")
    group.add_argument("--costs", metavar="FILE", help="CSV of misclassification costs: true class by predicted class")
    group.add_argument("--budget", metavar="B", type=float, help="most sensor cost of the whole tree")
    group.add_argument("--sensor-cost", metavar="FILE", help="CSV with columns [feature,]sensor,cost (default: all 1)")


def add_run_arguments(parser: argparse.ArgumentParser, seconds: float = math.inf) -> None:
    """Add limits, seed, threads and output."""
    group = parser.add_argument_group("run")
    shown = "no limit" if math.isinf(seconds) else f"{seconds:g}"
    group.add_argument(
        "--seconds", metavar="S", type=float, default=seconds, help=f"stop after S seconds (default {shown})"
    )
    group.add_argument("--gap", metavar="G", type=float, default=0.0, help="stop at this relative gap (default 0)")
    group.add_argument("--nodes", metavar="N", type=float, default=math.inf, help="stop after N search nodes")
    group.add_argument(
        "--memory", metavar="GB", type=float, default=8.0, help="most memory of the solver's tables (default 8)"
    )
    group.add_argument("--seed", metavar="N", type=int, default=0, help="seed of all random choices (default 0)")
    group.add_argument("--threads", metavar="N", type=int, default=1, help="threads of one solver (default 1)")
    add_json_argument(group)


def add_json_argument(parser: argparse._ActionsContainer) -> None:
    """Add --json."""
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object on standard output, and nothing else"
    )


def add_method_argument(parser: argparse.ArgumentParser) -> None:
    """Add --method."""
    parser.add_argument(
        "--method",
        choices=METHODS,
        default="auto",
        help="default auto: exact, or search for hyperplanes; exact proves hyperplanes of 2 features to depth 2",
    )


def limits_of(arguments: argparse.Namespace) -> Limits:
    """Return the limits that the arguments give.

    Raises
    ------
    ProblemError
        a limit is negative or not a number.
    DataError
        seed or threads are out of range.
    """
    for name, least, most in (("threads", 1, MOST_THREADS), ("seed", 0, 2**63 - 1)):
        value = getattr(arguments, name)
        if not least <= value <= most:
            raise DataError(f"--{name} is {shown(value)}; expected {least} or more, and at most {most}")
    return Limits(arguments.seconds, arguments.gap, arguments.nodes, arguments.memory * 2.0**30)
