"""Make, diagnose and score a sealed set: `python -m benchmarks.blind [--cases 600] [--seed N] [--jobs 2] [--out DIR]`.

Three steps, each its own function: the cases are sealed, diagnosed by processes that know the campaigns' folder
alone, and only then are the keys opened. Without --seed the seed comes from the clock, so no code can have been made
for it. A run that was stopped goes on where it was when it is started again with the same arguments: in the folder of
--out, or else in the one under results/blind that is not finished.
"""

import argparse
import multiprocessing
import os
import signal
import sys
import time
from pathlib import Path

from benchmarks.blind.assets.families import FAMILIES, available
from benchmarks.blind.cases import SETS
from benchmarks.blind.run import Plan, begun_seed, run
from benchmarks.blind.selectors import SELECTORS

SETS_FOLDER = Path("results/blind")
"""Sets of runs without --out."""


def main() -> None:
    """Run one set and print its tables in Markdown."""
    parser = argparse.ArgumentParser(prog="benchmarks.blind", description=__doc__)
    parser.add_argument("--cases", type=int, default=600)
    parser.add_argument("--seed", type=int, default=None, help="of the set; default: the clock")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=None, help="folder for campaigns, diagnoses and tables")
    parser.add_argument("--without", type=float, default=1.0, help="share diagnosed without commissioning run too")
    parser.add_argument("--family", action="append", choices=FAMILIES, help="of assets; may be given more than once")
    parser.add_argument("--strata", choices=SETS, default="main", help="sound: noises, two tests, wrong runs")
    parser.add_argument("--twin-mesh", type=float, default=1.0, help="refinement of the twin")
    parser.add_argument("--selector", action="append", choices=SELECTORS, help="what answers; may be given twice")
    options = parser.parse_args()
    if options.cases < 1:
        parser.error(f"--cases is {options.cases}; expected 1 or more")
    folder = options.out or unfinished(SETS_FOLDER, options.seed)
    seed = options.seed if options.seed is not None else begun_seed(folder) or int(time.time())
    print(f"{folder}: {'goes on' if begun_seed(folder) else 'begins'} with seed {seed}", file=sys.stderr)
    plan = Plan(
        seed,
        options.cases,
        options.jobs,
        options.without,
        tuple(options.family or available()),
        options.twin_mesh,
        options.strata,
        tuple(options.selector or SELECTORS),
    )
    signal.signal(signal.SIGTERM, _stop)
    print(run(folder, plan))


def unfinished(sets: Path, seed: int | None) -> Path:
    """Return the folder of a set that was begun, with this seed if one is given, and not finished; else a new one."""
    begun = sorted(path.parent for path in sets.glob("*/plan.json") if not (path.parent / "tables.md").exists())
    same = [folder for folder in begun if seed is None or begun_seed(folder) == seed]
    return same[0] if same else sets / str(int(time.time()) if seed is None else seed)


def _stop(*_: object) -> None:
    """End this process and those that diagnose, at once: what is done is written."""
    for process in multiprocessing.active_children():
        process.terminate()
    os._exit(143)


if __name__ == "__main__":
    main()
