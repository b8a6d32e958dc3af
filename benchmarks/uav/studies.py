"""`python -m benchmarks.uav.studies STUDY`: the studies beside `make uav`, one after the other, on one kind of strains.

Each prints its tables, and writes them and its pictures into a folder of the strains. What the studies of complexity,
of the paper's figures and of placement have done already is read, not run again.
"""

import argparse
import time
from pathlib import Path

from benchmarks.main_program import run_main
from benchmarks.uav.complexity import report as complexity
from benchmarks.uav.risk import decisions
from benchmarks.uav.sensing import budget, failure, placement
from octmip.input.files import write_bytes

STUDIES = {
    "placement": placement.report,
    "budget": budget.report,
    "failure": failure.report,
    "risk": decisions.report,
    "complexity": complexity.report,
    "paper": complexity.paper_report,
}


def main() -> None:
    """Run the studies that are named and write what they say."""
    options = _parser().parse_args()
    folder = Path(options.out) / options.source
    folder.mkdir(parents=True, exist_ok=True)
    for name in options.studies:
        start, before = time.perf_counter(), time.process_time()
        text = STUDIES[name](options.source, folder, options.seeds, options.smoke)
        write_bytes(folder / f"{name}.md", text.encode())
        spent = f"{time.process_time() - before:.0f} CPU s, {time.perf_counter() - start:.0f} s"
        print(f"{text}\n{name}: {spent}; written to {folder.resolve()}", flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.uav.studies", description=__doc__)
    parser.add_argument("studies", nargs="+", choices=tuple(STUDIES))
    parser.add_argument("--source", choices=("published", "wing"), default="wing", help="the strains")
    parser.add_argument("--seeds", type=int, default=5, help="of readings and searches; where a study has several")
    parser.add_argument("--smoke", action="store_true", help="small and quick: shows that it runs")
    parser.add_argument("--out", default="results/uav/studies")
    return parser


if __name__ == "__main__":
    run_main(main)
