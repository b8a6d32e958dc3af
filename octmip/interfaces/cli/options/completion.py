"""Print the script that lets a shell complete octmip's commands, options and file names.

shtab makes it from the parsers themselves, so it knows every option of this version.
"""

import argparse

import shtab

EXAMPLES = """\
  octmip completion bash > ~/.local/share/bash-completion/completions/octmip
  octmip completion zsh > ~/.zfunc/_octmip
  octmip completion tcsh > ~/.octmip.completion.csh
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip completion`."""
    parser.add_argument("shell", choices=shtab.SUPPORTED_SHELLS, help="the shell")
