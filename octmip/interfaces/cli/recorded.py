"""A recording as the table of a campaign, by the options of `octmip diagnose`; a table stays what it is."""

import argparse
import importlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from octmip.errors import DataError
from octmip.input.messages import several, shown
from octmip.interfaces.cli.samples.file_arguments import STANDARD_INPUT

if TYPE_CHECKING:
    from octmip.formats.table import Table
    from octmip.twin import Twin

OPTIONS = (
    "readings",
    "loads",
    "load_units",
    "least",
    "test",
    "no_reading",
    "modes",
    "vibrations",
    "levels",
    "show_windows",
)
"""What only a recording takes."""


def table_of(arguments: argparse.Namespace, path: str, twin: "Twin", is_commissioning: bool = False) -> "str | Table":
    """Return the table of a recording's windows, or the path where it is a table itself.

    Raises
    ------
    DataError
        a recording without windows, options of a recording beside a table, or windows for two recordings.
    """
    from octmip.recordings.averages import averages_of
    from octmip.recordings.levels import how_of
    from octmip.recordings.opening import format_of, recording
    from octmip.recordings.windows import window_of

    form = path != STANDARD_INPUT and format_of(path)
    is_cut = arguments.steady is not None or bool(arguments.windows)
    if not form and (is_commissioning or not is_cut):
        given = next((name for name in OPTIONS if getattr(arguments, name)), None)
        if given is not None and not is_commissioning:
            raise DataError(
                f"--{given.replace('_', '-')} is for a recording, and {path} is a table; give --steady or --windows "
                "too where its rows are samples"
            )
        return path
    opened = recording(path)
    if not is_cut:
        raise DataError(
            f"{path} is a recording ({opened.format}); expected --steady, or --windows START,END for stretches of "
            f"steady load; its channels: {several(opened.channels, 12)}"
        )
    if is_commissioning and arguments.windows:
        raise DataError(
            f"--windows are those of {arguments.campaign}; expected windows of {path} too; use --steady for both, or "
            "give the commissioning run as a table"
        )
    found = averages_of(
        opened,
        twin,
        *(_pairs(arguments, name) for name in ("readings", "loads", "load_units")),
        windows=[window_of(text) for text in arguments.windows or ()],
        steady=arguments.steady or (),
        modes=_frequencies(_pairs(arguments, "modes")),
        levels={name: how_of(words) for name, words in _pairs(arguments, "levels").items()},
        **{name: getattr(arguments, name) for name in ("least", "test", "no_reading", "vibrations")},
    )
    if arguments.show_windows and not is_commissioning:
        importlib.import_module("octmip.interfaces.plot.windows").draw_windows(found, arguments.show_windows)
    return found.table


def _pairs(arguments: argparse.Namespace, name: str) -> Mapping[str, str]:
    """Return what stands behind each name of the words NAME=VALUE of an option."""
    pairs = dict[str, str]()
    for words in getattr(arguments, name):
        key, sign, value = words.partition("=")
        if not (key and sign and value) or key in pairs:
            why = f"names {key} twice" if key in pairs else f"holds {shown(words)}"
            raise DataError(f"--{name.replace('_', '-')} {why}; expected NAME=VALUE, each name once; write it so")
        pairs[key] = value
    return pairs


def _frequencies(modes: Mapping[str, str]) -> Mapping[str, float]:
    try:
        return {name: float(words) for name, words in modes.items()}
    except ValueError as error:
        raise DataError(
            f"--modes says {shown(modes)}; expected a frequency in Hz behind each name; write it"
        ) from error
