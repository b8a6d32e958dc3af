"""Arguments that several commands share; nothing here is slow to import."""

import argparse
import contextlib
import math
import re
import textwrap
from collections.abc import Iterable, Iterator
from typing import NoReturn

from octmip.errors import DataError
from octmip.input.messages import shown
from octmip.interfaces.cli.samples.file_arguments import reads
from octmip.interfaces.cli.samples.options import (
    add_column_arguments,
    add_label_arguments,
    add_leaf_model,
    add_target_arguments,
)
from octmip.trees.answer.solution import Limits
from octmip.trees.methods.options import CHECKPOINT, FILE, METHODS, Options, all_options, help_of, values_of
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import chosen_method, read_options

MOST_THREADS = 1024
DATA, TREE, LOSS, METHOD, OUTPUT = "data", "tree", "loss", "method and limits", "output"
GROUPS = (DATA, TREE, LOSS, METHOD, OUTPUT)
"""Groups of options, in the order in which a command shows them."""
OF_METHODS = "options of the methods, by --option NAME=VALUE"


def _number_wanted(found: re.Match[str]) -> str:
    return f"{found[1]} is {found[3]}; expected a {'whole ' * (found[2] == 'int')}number; correct it"


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, like every other error of the command.

    --help shows what people use, --help-all the options too that are declared by `rarely`.
    """

    def __init__(self, prog: str, description: str | None, examples: str = "") -> None:
        super().__init__(
            prog=prog,
            description=description,
            epilog=examples and f"examples:\n{examples}",
            allow_abbrev=False,
            add_help=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        self.is_whole = False
        for title in GROUPS:
            self.add_argument_group(title)

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse as a DataError, in words of numbers where it has those of Python."""
        words = re.sub(r"^argument (.*): invalid (int|float) value: (.*)$", _number_wanted, message)
        raise DataError(f"{words}; see {self.prog} --help")

    def finish(self) -> "Parser":
        """Add --help as the last option, and shorten the usage to what must be given."""
        needed = [action for action in self._actions if action.required]
        words = [str(action.metavar or action.dest) for action in needed if not action.option_strings]
        words += [f"{action.option_strings[-1]} {action.metavar or ''}" for action in needed if action.option_strings]
        n_rare = sum(map(is_rare, self._actions))
        group = self.add_argument_group("help")
        group.add_argument("-h", "--help", action=_ShowHelp, help="show this text")
        if n_rare:
            group.add_argument("--help-all", action=_ShowHelp, help=f"show {n_rare} more options")
        self.usage = " ".join([self.prog, *words, "[options]"])
        return self

    def format_help(self) -> str:
        """Return the help: of the options that people use, or of all."""
        formatter = self._get_formatter()
        formatter.add_usage(self.usage, self._actions, self._mutually_exclusive_groups)
        formatter.add_text(self.description)
        for group in self._action_groups:
            formatter.start_section(group.title)
            formatter.add_text(group.description)
            formatter.add_arguments(a for a in group._group_actions if self.is_whole or not is_rare(a))
            formatter.end_section()
        if self.is_whole and "--option" in self._option_string_actions:
            formatter.start_section(OF_METHODS)
            formatter.add_text("\n".join(_lines_of_methods({action.dest for action in self._actions})))
            formatter.end_section()
        formatter.add_text(self.epilog)
        return formatter.format_help()


class _ShowHelp(argparse.Action):
    """Shows the help, with --help-all that of every option."""

    def __init__(self, option_strings: list[str], dest: str, help: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help=help, default=argparse.SUPPRESS)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        assert isinstance(parser, Parser)
        parser.is_whole = "--help-all" in self.option_strings
        parser.print_help()
        parser.exit()


def rarely(action: argparse.Action) -> argparse.Action:
    """Declare that an option is used rarely: --help-all shows it."""
    vars(action)["is_rare"] = True
    return action


def is_rare(action: argparse.Action) -> bool:
    """Whether an option is used rarely."""
    return bool(vars(action).get("is_rare", False))


def group_of(parser: argparse.ArgumentParser, title: str) -> argparse._ArgumentGroup:
    """Return a group of a parser's options, one of `GROUPS`."""
    return next(group for group in parser._action_groups if group.title == title)


def _lines_of_methods(own: set[str]) -> Iterator[str]:
    """Yield a line for each option of a method that --option may name beside the command's `own`."""
    for name in nameable(own):
        lines = textwrap.wrap(help_of(name), 56)
        yield f"{name:<20}  {lines[0]}"
        yield from (f"{'':<22}{line}" for line in lines[1:])


def nameable(own: Iterable[str]) -> list[str]:
    """Return the options that --option may name: none of the command's own, and no file, which it might overwrite."""
    return [name for name, one in all_options().items() if name not in own and values_of(one) not in (FILE, CHECKPOINT)]


def _only_classes(_: str) -> NoReturn:
    raise argparse.ArgumentTypeError("this command is about classes; name a column of them with --label")


def add_everyday_arguments(
    parser: argparse.ArgumentParser,
    seconds: float = math.inf,
    has_target: bool = False,
    chooses: bool = False,
    or_folder: bool = False,
) -> None:
    """Add the table, the label (or a target of numbers and its loss), the depth and the time.

    A command that `chooses` a tree where no depth is given needs none; one `or_folder` reads folders too.
    """
    add_label_arguments(group_of(parser, DATA), is_required=not has_target, or_folder=or_folder)
    without = " (default: chosen by cross-validation, for new rows; any beside --leaf-penalty)" if chooses else ""
    levels = f"levels of splits{without}"
    group_of(parser, TREE).add_argument("--depth", metavar="D", type=int, required=not chooses, help=levels)
    if not has_target:
        group_of(parser, DATA).add_argument("--target", type=_only_classes, help=argparse.SUPPRESS)
    if has_target:
        add_target_arguments(group_of(parser, DATA), group_of(parser, LOSS))
        rarely(add_leaf_model(group_of(parser, TREE)))
    shown = "no limit" if math.isinf(seconds) else f"{seconds:g}"
    group_of(parser, METHOD).add_argument(
        "--seconds", metavar="S", type=float, default=seconds, help=f"stop after S seconds (default {shown})"
    )


def add_problem_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that describe samples, tree, costs and sensors."""
    for action in add_column_arguments(group_of(parser, DATA)):
        rarely(action)
    group = group_of(parser, TREE)
    group.add_argument("--leaf-size", metavar="N", type=int, default=1, help="at least N samples in a leaf (default 1)")
    leaf_weight = group.add_argument(
        "--leaf-weight", metavar="W", type=float, help="at least the weight W in a leaf (see --weights, --class-weight)"
    )
    order = group.add_argument(
        "--monotone",
        metavar="C=+,D=-",
        help="the prediction never falls as column C rises, never rises as D rises; classes by --class-order",
    )
    classes = group.add_argument(
        "--class-order",
        metavar="LOW,HIGH",
        help="classes from low to high (default: of an ordered Parquet column its own, numbers by size)",
    )
    most_leaves = group.add_argument("--max-leaves", metavar="K", type=int, help="at most K leaves in the tree")
    for action in (leaf_weight, order, classes, most_leaves):
        rarely(action)
    group.add_argument(
        "--split-size", metavar="K", type=int, help="at most K features in one split; hyperplanes where K is 2 or more"
    )
    group.add_argument("--budget", metavar="B", type=float, help="most sensor cost of the whole tree")
    sensors = group.add_argument(
        "--sensor-cost", metavar="FILE", help="table with columns [feature,]sensor,cost (default: each column costs 1)"
    )
    price = group.add_argument(
        "--leaf-penalty",
        metavar="P",
        type=float,
        default=0.0,
        help="price of one feature in one split (default 0); solve without --depth proves the best tree of any depth",
    )
    kind = group.add_argument(
        "--split", choices=("axis", "hyperplane"), help="kind of split (default axis; hyperplane with --split-size > 1)"
    )
    for action in (reads(sensors), price, kind):
        rarely(action)
    reads(
        group_of(parser, LOSS).add_argument(
            "--costs", metavar="FILE", help="table of misclassification costs: true class by predicted class"
        )
    )


def add_run_arguments(parser: argparse.ArgumentParser, with_method: bool = True) -> None:
    """Add method, limits, seed, threads and --json."""
    group = group_of(parser, METHOD)
    if with_method:
        group.add_argument(
            "--method",
            choices=METHODS,
            default="auto",
            help="default auto: exact, or search for hyperplanes; exact proves hyperplanes of 2 features to depth 3",
        )
    group.add_argument("--threads", metavar="N", type=int, default=1, help="threads of one solver (default 1)")
    gap = group.add_argument(
        "--gap", metavar="G", type=float, default=0.0, help="stop at this relative gap (default 0)"
    )
    memory = group.add_argument(
        "--memory", metavar="GB", type=float, default=8.0, help="most memory of the solver's tables (default 8)"
    )
    seed = group.add_argument("--seed", metavar="N", type=int, default=0, help="seed of all random choices (default 0)")
    for action in (gap, memory, seed):
        rarely(action)
    add_json_argument(group_of(parser, OUTPUT))


def add_flag(group: argparse._ActionsContainer, name: str, metavar: str) -> argparse.Action:
    """Add an option of the command for one of the methods; its help is the class's."""
    return rarely(group.add_argument(f"--{name}", metavar=metavar, help=help_of(name)))


def add_method_options(parser: argparse.ArgumentParser) -> None:
    """Add --option."""
    rarely(
        group_of(parser, METHOD).add_argument(
            "--option",
            metavar="NAME=VALUE",
            action="append",
            default=[],
            help="an option of the method, of those below; may be given several times",
        )
    )


def words_of(arguments: argparse.Namespace) -> dict[str, str]:
    """Return the options of the method that the arguments give, each as a word, by name.

    Raises
    ------
    DataError
        --option is no NAME=VALUE, or has another name than it may.
    """
    own = {name: getattr(arguments, name) for name in all_options() if hasattr(arguments, name)}
    names = nameable(own)
    pairs = [text.partition("=") for text in arguments.option]
    for (name, sign, _), text in zip(pairs, arguments.option, strict=True):
        if name not in names or not sign:
            raise DataError(
                f"--option is {shown(text)}; expected NAME=VALUE with one of the names {', '.join(names)}; "
                "--help-all says what they mean"
            )
    return {name: word for name, word in own.items() if word is not None} | {name: word for name, _, word in pairs}


@contextlib.contextmanager
def method_options(arguments: argparse.Namespace, problem: Problem) -> Iterator[Options]:
    """Yield the options of the method, with an open cluster where they name one.

    Raises
    ------
    ProblemError
        the method takes no such option, or a word is none of its values.
    DataError
        an option is no NAME=VALUE, or nobody answers at the address of the cluster.
    """
    method = chosen_method(problem, arguments.method)
    with read_options(problem, method, words_of(arguments)).opened(arguments.threads) as options:
        yield options


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
    return Limits(arguments.seconds, arguments.gap, memory=arguments.memory * 2.0**30)
