"""Arguments that several commands share; nothing here is slow to import."""

import argparse
import contextlib
import math
from collections.abc import Iterator
from typing import Any, NoReturn

from octmip.errors import DataError
from octmip.formats.messages import shown
from octmip.interfaces.cli.samples.file_arguments import reads
from octmip.interfaces.cli.samples.options import add_column_arguments, add_label_arguments, add_target_arguments
from octmip.trees.cluster import open_cluster
from octmip.trees.methods.options import METHODS
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits
from octmip.trees.solver import chosen_method

MOST_THREADS = 1024


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, like every other error of the command."""

    def __init__(self, prog: str, description: str | None, examples: str = "") -> None:
        super().__init__(
            prog=prog,
            description=description,
            epilog=examples and f"examples:\n{examples}",
            allow_abbrev=False,
            add_help=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse as a DataError."""
        raise DataError(f"{message}; see {self.prog} --help")

    def finish(self) -> "Parser":
        """Add --help as the last option, and shorten the usage to what must be given."""
        needed = [action for action in self._actions if action.required]
        words = [str(action.metavar or action.dest) for action in needed if not action.option_strings]
        words += [f"{action.option_strings[-1]} {action.metavar or ''}" for action in needed if action.option_strings]
        self.add_argument_group("help").add_argument("-h", "--help", action="help", help="show this text")
        self.usage = " ".join([self.prog, *words, "[options]"])
        return self


def add_everyday_arguments(
    parser: argparse.ArgumentParser, seconds: float = math.inf, has_target: bool = False
) -> argparse._ArgumentGroup:
    """Add the table, the label (or a target of numbers), the depth and the time, and return their group."""
    group = parser.add_argument_group("everyday")
    add_label_arguments(group, is_required=not has_target)
    if has_target:
        add_target_arguments(group)
    group.add_argument("--depth", metavar="D", type=int, required=True, help="levels of splits")
    shown = "no limit" if math.isinf(seconds) else f"{seconds:g}"
    group.add_argument(
        "--seconds", metavar="S", type=float, default=seconds, help=f"stop after S seconds (default {shown})"
    )
    return group


def add_problem_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that describe samples, tree, costs and sensors."""
    add_column_arguments(parser)
    group = parser.add_argument_group("tree")
    group.add_argument("--leaf-size", metavar="N", type=int, default=1, help="at least N samples in a leaf (default 1)")
    group.add_argument(
        "--leaf-penalty", metavar="P", type=float, default=0.0, help="price of one feature in one split (default 0)"
    )
    group.add_argument(
        "--split", choices=("axis", "hyperplane"), help="kind of split (default axis; hyperplane with --split-size > 1)"
    )
    group.add_argument("--split-size", metavar="K", type=int, help="at most K features in one split")
    reads(
        group.add_argument(
            "--allowed-splits", metavar="FILE", help="text file: on each line the columns that may meet in one split"
        )
    )
    group.add_argument("--integer-normals", metavar="N", type=int, help="hyperplane coefficients are integers up to N")
    group = parser.add_argument_group("costs and sensors")
    reads(
        group.add_argument(
            "--costs", metavar="FILE", help="table of misclassification costs: true class by predicted class"
        )
    )
    group.add_argument("--budget", metavar="B", type=float, help="most sensor cost of the whole tree")
    reads(
        group.add_argument(
            "--sensor-cost",
            metavar="FILE",
            help="table with columns [feature,]sensor,cost (default: each column costs 1)",
        )
    )


def add_run_arguments(parser: argparse.ArgumentParser, with_method: bool = True) -> None:
    """Add method, limits, seed, threads and --json."""
    group = parser.add_argument_group("run")
    if with_method:
        group.add_argument(
            "--method",
            choices=METHODS,
            default="auto",
            help="default auto: exact, or search for hyperplanes; exact proves hyperplanes of 2 features to depth 2",
        )
    group.add_argument("--gap", metavar="G", type=float, default=0.0, help="stop at this relative gap (default 0)")
    group.add_argument("--nodes", metavar="N", type=float, default=math.inf, help="stop after N search nodes")
    group.add_argument(
        "--memory", metavar="GB", type=float, default=8.0, help="most memory of the solver's tables (default 8)"
    )
    group.add_argument("--seed", metavar="N", type=int, default=0, help="seed of all random choices (default 0)")
    group.add_argument("--threads", metavar="N", type=int, default=1, help="threads of one solver (default 1)")
    add_json_argument(group)


def add_cluster_argument(group: argparse._ActionsContainer) -> None:
    """Add --cluster."""
    group.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="share the work among the workers of a Dask scheduler (tcp://host:8786), or of this machine: local (as "
        "many processes as --threads); axis-aligned proofs from depth 3 on (exact), restarts of search",
    )


@contextlib.contextmanager
def cluster_of(arguments: argparse.Namespace, problem: Problem) -> Iterator[dict[str, Any]]:
    """Open the cluster that the arguments name; yields the solver's options, none without --cluster.

    Raises
    ------
    DataError
        a method that a cluster does not help, or nobody answers at the address.
    """
    if arguments.cluster is None:
        yield {}
        return
    method = chosen_method(problem, arguments.method)
    if method != "search" and (method != "exact" or problem.split != "axis"):
        kind = "proofs of splits over two features" if method == "exact" else f"method {method!r}"
        raise DataError(
            "--cluster shares axis-aligned proofs (exact) and restarts of the local search (search); got "
            f"{kind}, done by the process that asks; leave it out, or take --threads"
        )
    with open_cluster(arguments.cluster, arguments.threads) as cluster:
        yield {"cluster": cluster}


def add_json_argument(parser: argparse._ActionsContainer) -> None:
    """Add --json."""
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object on standard output, and nothing else"
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
