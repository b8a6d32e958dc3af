"""Explain why an asset does not behave like its twin: where, which effect, how far the gap closes, what to test next.

CAMPAIGN.csv holds one row per reading: test, the loads (load_factor where the twin names none), the known state
parameters, optional time and temperature, and one column per gauge under the twin's name for it, in its unit.
"""

import argparse

from octmip.interfaces.cli.arguments import add_json_argument
from octmip.interfaces.cli.options.page import add_page_arguments
from octmip.interfaces.cli.samples.file_arguments import reads, writes


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip diagnose`."""
    reads(
        parser.add_argument(
            "campaign",
            metavar="CAMPAIGN.csv",
            help="readings of the asset: a table, or a recording of a measuring system",
        )
    )
    twin = parser.add_argument(
        "--twin",
        metavar="MODULE:NAME",
        required=True,
        help="the twin, its class or a function that makes it, such as femlib.wing:uav_twin; or a model behind a door: "
        "python:MODULE:FUNCTION, table:FILE",
    )
    card = parser.add_argument(
        "--card",
        metavar="CARD.json",
        help="readings, units, loads and ranges of a model behind a door; by default the file's name with .json added",
    )
    run = parser.add_argument("--commissioning", metavar="RUN.csv", help="readings of the asset while it was sound")
    reads(twin, _behind_door), reads(card), reads(run)
    _add_recording_arguments(parser)
    reads(parser.add_argument("--tree", metavar="TREE.json", help="rank the nodes of this tree by flipped decisions"))
    parser.add_argument(
        "--noise",
        metavar="SD",
        type=float,
        help="standard deviation of one reading in its unit, used where no load was read three times",
    )
    parser.add_argument(
        "--constants",
        metavar="PERCENT",
        type=float,
        help="how far constants of the asset are off the drawing, where no run says it (default 8)",
    )
    parser.add_argument("--calls", metavar="N", type=int, help="ask a slow model behind a door no more than N times")
    parser.add_argument("--jobs", metavar="N", type=int, default=1, help="questions at the same time (with --calls)")
    answers = parser.add_argument(
        "--answers",
        metavar="FILE.jsonl",
        help="keep each answer of the model there and take earlier ones (with --calls)",
    )
    writes(answers)
    parser.add_argument(
        "--load-limits",
        metavar=("LOW", "HIGH"),
        type=float,
        nargs=2,
        help="loads between which the structure may be tested; no test beyond them is proposed",
    )
    writes(parser.add_argument("--out", metavar="PAGE.html", help="write a page with figures to this file"))
    add_page_arguments(parser, "READING", "unit of the readings of a twin that names none (default microstrain)")
    add_json_argument(parser)


def _add_recording_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what a recording needs: which channels, and which stretches of it."""
    for name, metavar, kind, words in (
        ("readings", "NAME=CHANNEL", str, "channels of a recording by the twin's names for its readings"),
        ("loads", "NAME=CHANNEL", str, "the same of loads, states and temperature; a number holds all along"),
        ("load-units", "NAME=UNIT", str, "units in which the twin takes loads: channels in others are converted"),
        ("windows", "START,END[,TEST]", str, "windows of a recording [s]"),
        ("modes", "NAME=HERTZ", str, "readings that are frequencies or damping of modes, and about where each mode is"),
        ("vibrations", "CHANNEL", str, "channels of a recording by which modes are identified"),
        ("levels", "NAME=LEVEL", str, "readings that are max, min, or the RMS from LOW:HIGH Hz, instead of means"),
        ("no-reading", "NUMBER", float, "numbers by which a logger says that there is no reading"),
    ):
        parser.add_argument(f"--{name}", metavar=metavar, type=kind, nargs="+", action="extend", default=[], help=words)
    parser.add_argument(
        "--steady",
        metavar="LOAD",
        nargs="*",
        help="cut a recording into windows where these loads, or all, stand still",
    )
    parser.add_argument("--least", metavar="SECONDS", type=float, help="length of the shortest such window")
    parser.add_argument("--test", metavar="CHANNEL", default="", help="channel of a recording that numbers the tests")
    writes(parser.add_argument("--show-windows", metavar="FILE.png", help="draw the windows before the diagnosis"))


def _behind_door(twin: str) -> str:
    """Return the file behind a door such as ``table:FILE``."""
    return twin.partition(":")[2] or twin
