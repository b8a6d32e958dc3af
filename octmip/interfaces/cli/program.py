"""The program: it runs one command, and says in a sentence what goes wrong.

Each command is two modules: one in `octmip.interfaces.cli.options` says how it is called (`add_arguments(parser)`), and
one with `run(arguments)` does the work. The second is imported once the words are right: help and errors of arguments
wait for no pandas. argparse of the standard library does all that is needed: no dependency is added.

    exit code    0 done    1 refuted, a solver failed, or a file could not be written    2 bad input
                 130 interrupted without a result (Ctrl-C)    143 likewise by SIGTERM
"""

import difflib
import importlib
import re
import sys
from collections.abc import Sequence
from importlib.metadata import version
from types import ModuleType

from octmip.errors import CertificateError, DataError, OctmipError, SolverError, WriteError, is_out_of_memory
from octmip.input.names import visible
from octmip.interfaces.cli.arguments import Parser
from octmip.interfaces.cli.samples.file_arguments import check_files
from octmip.interfaces.cli.stages import Heard, Watch, leave, term_as_interrupt
from octmip.interfaces.cli.streams import open_streams
from octmip.trees.answer.solution import ProofError
from octmip.trees.methods.memory import address_space_left, open_blas

COMMANDS = {
    "solve": "find the best tree for a table, and prove how good it is",
    "certify": "recompute what a tree file claims, from tree and data alone",
    "predict": "apply a tree file to a table",
    "compare": "run every method on a table, or on each of a folder, and show their gaps and times side by side",
    "near-optimal": "count all trees near the optimum, list the best, draw samples",
    "sensors": "show what each sensor is worth: the optimum without it, and where it must be read",
    "frontier": "show the least cost against depth, sensor budget or leaf penalty",
    "diagnose": "explain why an asset does not behave like its twin, and what to test next",
    "monitor": "make trees, page and C code that read an asset's state from few sensors, from its twin",
    "report": "show a tree file in words, or as a page, Markdown or a drawing",
    "doctor": "check this installation: versions, native core, extras, memory",
}
MODULES = {"near-optimal": "sets.near_optimal", "sensors": "sets.sensors"}
"""Modules of the commands that do not bear their name."""
NAMES = {"fixed_splits": "fix", "path_rules": "path_rule", "sensor_budget": "budget", "n_jobs": "threads"}
"""Names of Python whose option of the command is called otherwise."""
LEAST_MEMORY = 2.0**24
"""Bytes; a process that may take no more fails with errors of every kind."""
MOST_MESSAGE = 10_000  # characters of an error on standard error


def options_of(command: str) -> ModuleType:
    """Return the module that says how a command is called."""
    return importlib.import_module(f"octmip.interfaces.cli.options.{command.replace('-', '_')}")


def run_words(words: Sequence[str] | None) -> int:
    """Run one command and return its exit code; without words, those of the command line, as a program."""
    is_program = words is None
    words = list(sys.argv[1:] if words is None else words)
    if is_program:
        open_streams()
    with term_as_interrupt(raises=False) as heard:
        with Watch(heard):
            code = _code(words, heard)
        if is_program:
            heard.code = code  # nothing is left to be interrupted
            if heard.n_signals:
                leave(code)
    return code


def _code(words: list[str], heard: Heard) -> int:
    """Run one command; return its exit code, whatever it raises said in a sentence.

    A signal raises while the command runs and nowhere else, so none comes out of here as a traceback.
    """
    try:
        try:
            heard.begin()
            return _run_or_interrupted(words, heard)
        finally:
            heard.raises = False
    except OctmipError as error:
        name = f"octmip {words[0]}" if words and words[0] in COMMANDS else "octmip"
        print(f"{name}: {_with_options(_one_line(error), words)}", file=sys.stderr)
        return 1 if isinstance(error, CertificateError | SolverError | WriteError) else 2
    except KeyboardInterrupt:
        print(f"octmip: {heard.word}", file=sys.stderr)
        return heard.exit_code
    except BrokenPipeError:  # the reader of our output has seen enough
        return 0
    except UnicodeEncodeError as error:
        held = f"its encoding {error.encoding} lacks {error.object[error.start]!a}"
        print(f"octmip: standard output cannot be written ({held}); set PYTHONIOENCODING=utf-8", file=sys.stderr)
        return 1
    except Exception as error:
        if is_out_of_memory(error) or address_space_left() < LEAST_MEMORY:
            said = "out of memory; give fewer rows or columns, or let the process have more"
        elif isinstance(error, OSError):  # files have their own sentences by now, so this is standard output
            said = f"standard output cannot be written ({error.strerror})"
        else:
            raise
        print(f"octmip: {said}", file=sys.stderr)
        return 1


def _run_or_interrupted(words: list[str], heard: Heard) -> int:
    """Run one command; what fails after a signal is interrupted: what was in work may make any error of that."""
    try:
        code = _run(words)
        sys.stdout.flush()
        return code
    except (ProofError, WriteError):  # the result is shown, and this is news beside it
        raise
    except Exception as error:
        if heard.n_signals:
            raise KeyboardInterrupt from error
        raise


def _one_line(error: OctmipError) -> str:
    """Return a message on one line of bounded length, without what a terminal would obey."""
    words = " ".join(str(error).split())
    shown = words if len(words) <= MOST_MESSAGE else f"{words[: MOST_MESSAGE - 4]} ..."
    return visible(shown)


def _with_options(message: str, words: list[str]) -> str:
    """Return a message with the options of a command in place of the names that Python has for them.

    A name of one plain word stays: it may be a word of the sentence. So does that of a column or of a model's row.
    """
    if not words or words[0] not in COMMANDS:
        return message
    options = {one.dest: one.option_strings[-1] for one in _parser(words[0])._actions if one.option_strings}
    options |= {name: options[dest] for name, dest in NAMES.items() if dest in options}
    names = "|".join(name for name in options if "_" in name)
    return (
        re.sub(rf"(?<!['\w.-])(?<!--drop )({names})\b(?!['(\[])", lambda found: options[found[0]], message)
        if names
        else message
    )


def _parser(command: str) -> Parser:
    """Return the parser of a command, as its module of options makes it."""
    options = options_of(command)
    parser = Parser(f"octmip {command}", options.__doc__, getattr(options, "EXAMPLES", ""))
    options.add_arguments(parser)
    return parser


def _run(words: list[str]) -> int:
    if not words or words[0] in ("-h", "--help"):
        print(_overview(), file=sys.stdout if words else sys.stderr)
        return 0 if words else 2
    if words[0] == "--version":
        print(f"octmip {version('octmip')}")
        return 0
    if words[0] not in COMMANDS:
        near = difflib.get_close_matches(words[0], COMMANDS, n=1)
        hint = f"; did you mean {near[0]}?" if near else f"; expected one of {', '.join(COMMANDS)}"
        raise DataError(f"there is no command {words[0]!r}{hint}")
    parser = _parser(words[0])
    try:
        arguments = parser.finish().parse_args(words[1:])
    except SystemExit:  # its help is shown
        return 0
    check_files(parser, arguments)
    open_blas()
    command = importlib.import_module(f"octmip.interfaces.cli.{MODULES.get(words[0], words[0])}")
    code: int = command.run(arguments)
    return code


def _overview() -> str:
    lines = [f"  octmip {name:<12}  {summary}" for name, summary in COMMANDS.items()]
    return "\n".join(
        [
            "octmip finds decision trees that are optimal, proves it, and says why an asset is not as its twin.",
            "",
            *lines,
            "",
            "Begin with:  octmip solve TABLE.csv --label COLUMN",
            "octmip COMMAND --help describes a command with examples; octmip --version prints the version.",
        ]
    )
