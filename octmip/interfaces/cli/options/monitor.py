"""Make a monitor of an asset from its twin: trees that read its state from few sensors, with page, C code and JSON.

The twin's states are what is monitored. Readings are drawn from the twin at each of their levels, with noise; a tree is
solved for each state; what it is off is counted on readings that it has not seen. FOLDER then holds for each state
STATE.json (the tree), STATE.html (its page) and STATE.c (one C function), and monitor.json, which octmip.monitor reads.

With --readings and --deployed the loop is closed: a monitor that was made before watches the readings. Where they leave
its library, the command says where to inspect, adds the damage to the library, solves the trees again, and writes
change.json and its page change.html: what was found, which trees and splits changed, and their proofs.
"""

import argparse
import math

from octmip.interfaces.cli.arguments import add_json_argument
from octmip.interfaces.cli.samples.file_arguments import reads

EXAMPLES = """\
  octmip monitor --twin python:bridge:bridge --card bridge.json --load truck_1=200,truck_2=300 \\
      --noise mm=0.2 --noise microstrain=3 --budget 2 --out crack
  octmip monitor --twin my_wing:twin --only mu1,mu2 --load load_factor=3 --noise 31.6 --depth 3 --out sound
  octmip monitor --twin my_wing:twin --deployed sound --readings flight.csv --out enriched
  octmip monitor --twin table:beam.csv --linear --noise 2 --states crack=0,0.2,0.4 --depth 3 --out crack
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip monitor`."""
    group = parser.add_argument_group("everyday")
    twin = group.add_argument(
        "--twin",
        metavar="MODULE:NAME",
        required=True,
        help="as for octmip diagnose: a twin, or a model behind a door (python:MODULE:FUNCTION, table:FILE, ...)",
    )
    card = group.add_argument("--card", metavar="CARD.json", help="the card of a model behind a door")
    reads(twin, lambda name: name.partition(":")[2] or name), reads(card)
    group.add_argument(
        "--load",
        metavar="NAME=VALUE,...",
        action="append",
        default=[],
        help="where the asset is read: all loads of the twin; given several times, each has a folder of its own "
        "(default: 1 of every load)",
    )
    group.add_argument(
        "--noise",
        metavar="[NAME=]SD",
        action="append",
        default=[],
        help="standard deviation of one reading: of all, of a unit (mm=0.2) or of one reading (w1=0.2); may be given "
        "several times",
    )
    group.add_argument("--budget", metavar="B", type=float, help="most cost of all sensors together")
    group.add_argument("--out", metavar="FOLDER", required=True, help="folder that is made, or filled")
    loop = parser.add_argument_group("the loop")
    loop.add_argument(
        "--only",
        metavar="STATE,...",
        default="",
        help="states that the trees tell apart; the watch looks for the others (default: all states)",
    )
    reads(
        loop.add_argument(
            "--readings",
            metavar="FLIGHT.csv",
            help="readings of the asset in order, as the campaign of octmip diagnose",
        )
    )
    loop.add_argument("--deployed", metavar="FOLDER", help="the folder of the monitor at work, made by this command")
    loop.add_argument(
        "--inspected", metavar="STATE", help="the damage that an inspection found (default: the watch's most probable)"
    )
    more = parser.add_argument_group("more")
    more.add_argument(
        "--states",
        metavar="NAME=LEVEL,...",
        action="append",
        default=[],
        help="levels of a state (default: 0 to 0.8 of its limit in steps of 0.2)",
    )
    more.add_argument(
        "--cost", metavar="READING=COST", action="append", default=[], help="cost of a sensor (default 1 each)"
    )
    more.add_argument(
        "--depth",
        metavar="D",
        type=int,
        default=2,
        help="levels of splits of each tree (default 2; in the loop as many as a deployed tree has, at least)",
    )
    more.add_argument("--linear", action="store_true", help="readings are proportional to the loads")
    more.add_argument("--draws", metavar="N", type=int, default=40, help="readings drawn of each state (default 40)")
    more.add_argument("--seconds", metavar="S", type=float, default=math.inf, help="most seconds of a solve")
    more.add_argument("--seed", metavar="N", type=int, default=0, help="seed of noise and solver (default 0)")
    add_json_argument(more)
