"""`python -m benchmarks.uav.mission --policies --watch 100 --lives 1000`: the tables of docs/results/mission.md."""

import argparse
import time
from pathlib import Path

from benchmarks.main_program import run_main
from benchmarks.uav.mission.aircraft import build_aircraft
from benchmarks.uav.mission.histories import KINDS
from benchmarks.uav.mission.lives import life_rows
from benchmarks.uav.mission.local_damage import local_rows
from benchmarks.uav.mission.policy_picture import picture
from benchmarks.uav.mission.policy_table import policy_rows
from octmip.interfaces.report.markdown import markdown_table


def main() -> None:
    """Write what the command line asks for."""
    options = _parser().parse_args()
    start = time.perf_counter()
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    aircraft = build_aircraft(folder, options.strains, options.seed, is_coarse=options.coarse)
    print(f"{aircraft.source}: trees read {', '.join(aircraft.selector.gauges_read)}", flush=True)
    if options.policies:
        rows = policy_rows(aircraft, options.missions, options.seed, options.kinds)
        picture(rows).savefig(folder / "policies.png", dpi=110)
        print(f"\n{markdown_table(rows)}", flush=True)
    seed = options.seed or time.time_ns() % 2**32
    if options.watch:
        print(f"\n{markdown_table(list(local_rows(aircraft, options.watch, seed)))}", flush=True)
    if options.lives:
        print(f"\n{markdown_table(list(life_rows(aircraft, options.lives, seed)))}", flush=True)
    print(f"{time.perf_counter() - start:.0f} s; all lies in {folder.resolve()}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.uav.mission", description=__doc__)
    parser.add_argument("--strains", help="published strain table (CSV); default: strains of femlib's wing")
    parser.add_argument("--policies", action="store_true", help="print the table of policies and draw it")
    parser.add_argument("--watch", type=int, default=0, help="flights of each number of damaged and failed gauges")
    parser.add_argument("--lives", type=int, default=0, help="simulated lives beside their forecasts")
    parser.add_argument("--coarse", action="store_true", help="policies believe the capability of a coarse mesh")
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=KINDS, help="missions of the policy table")
    parser.add_argument("--missions", type=int, default=10_000, help="missions of each policy")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", default="results/uav/mission/wing")
    return parser


if __name__ == "__main__":
    run_main(main)
