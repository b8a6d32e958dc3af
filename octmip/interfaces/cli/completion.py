"""Print the script that lets a shell complete octmip's commands, options and file names.

shtab makes it from the parsers themselves, so it knows every option of this version.
"""

import argparse
import importlib

import shtab

from octmip.interfaces.cli.arguments import Parser
from octmip.interfaces.cli.samples.file_arguments import use_of

EXAMPLES = """\
  octmip completion bash > ~/.local/share/bash-completion/completions/octmip
  octmip completion zsh > ~/.zfunc/_octmip
  octmip completion tcsh > ~/.octmip.completion.csh
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip completion`."""
    parser.add_argument("shell", choices=shtab.SUPPORTED_SHELLS, help="the shell")


def run(arguments: argparse.Namespace) -> int:
    """Print the script."""
    from octmip.interfaces.cli.program import COMMANDS, MODULES  # which imports this module by name when it is called

    whole = argparse.ArgumentParser(prog="octmip", description="optimal classification trees, with their proofs")
    commands = whole.add_subparsers(parser_class=_CommandParser)
    for name, summary in COMMANDS.items():
        command = importlib.import_module(f"octmip.interfaces.cli.{MODULES.get(name, name)}")
        parser = commands.add_parser(name, help=summary)
        command.add_arguments(parser)
        _complete_files(parser.finish())
    print(shtab.complete(whole, arguments.shell))
    return 0


class _CommandParser(Parser):
    """The parser of a command as a part of the whole."""

    def __init__(self, **words: str) -> None:
        super().__init__(words["prog"], None)


def _complete_files(parser: Parser) -> None:
    """Let the shell complete the names of files where a file is meant."""
    for action in parser._actions:
        if use_of(action) is not None:
            vars(action)["complete"] = shtab.FILE  # where shtab looks for it
