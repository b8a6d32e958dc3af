"""Print the script for a shell: `octmip.interfaces.cli.options.completion` says how the command is called."""

import argparse

import shtab

from octmip.interfaces.cli.arguments import Parser
from octmip.interfaces.cli.samples.file_arguments import use_of


def run(arguments: argparse.Namespace) -> int:
    """Print the script."""
    from octmip.interfaces.cli.program import (  # which imports this module by name when it is called
        COMMANDS,
        options_of,
    )

    whole = argparse.ArgumentParser(prog="octmip", description="optimal classification trees, with their proofs")
    commands = whole.add_subparsers(parser_class=_CommandParser)
    for name, summary in COMMANDS.items():
        parser = commands.add_parser(name, help=summary)
        options_of(name).add_arguments(parser)
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
