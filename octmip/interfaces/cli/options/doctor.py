"""Check this installation: versions, the native core at work on a tiny problem, extras, threads and memory.

Exit code 0: the core works, and an extra that is absent is named with what it would give. 1: something that every
command needs does not work.
"""

import argparse

from octmip.interfaces.cli.arguments import add_json_argument

EXAMPLES = """\
  octmip doctor
  octmip doctor --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip doctor`."""
    add_json_argument(parser)
