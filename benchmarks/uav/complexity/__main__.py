"""`python -m benchmarks.uav.complexity`: the whole study on many seeds; what is done already is read, not run again."""

import argparse
import time
from pathlib import Path

from benchmarks.data import SHARED
from benchmarks.main_program import run_main
from benchmarks.uav.complexity.cells import OBJECTIVES, bayes_limits, pair_limits, paper_cells, study_cells
from benchmarks.uav.complexity.lines import run
from benchmarks.uav.complexity.report import write_complexity
from benchmarks.uav.complexity.tables import paper_table
from femlib.dataset import MeanStrains, published_strains, simulated_strains
from femlib.wing import uav_wing
from octmip.formats.files import write_bytes


def main() -> None:
    """Run, keep, tabulate and draw."""
    options = _parser().parse_args()
    start = time.perf_counter()
    means, folder = _means(options.source), Path(options.out) / options.source
    folder.mkdir(parents=True, exist_ok=True)
    seeds = range(options.seeds)
    cells = {"study": study_cells, "paper": paper_cells}[options.grid](seeds)
    lines = run(cells, means, options.restarts, options.jobs, folder / "lines.jsonl")
    limits = bayes_limits(means)
    if options.grid == "study":
        write_complexity(folder, lines, limits, OBJECTIVES)
        text = (folder / "complexity.md").read_text()
    else:
        text = f"# The paper's figures\n\n{paper_table(lines, limits, pair_limits(means, lines))}\n"
        write_bytes(folder / "paper.md", text.encode())
    print(text)
    cpu = sum(line["cpu_seconds"] for line in lines.values())
    print(f"{means.source}: {len(cells)} trees, {cpu:.0f} CPU s of search, {time.perf_counter() - start:.0f} s now")


def _means(source: str) -> MeanStrains:
    return simulated_strains(uav_wing()) if source == "wing" else published_strains(SHARED / "uav" / "strains.csv")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.uav.complexity", description=__doc__)
    parser.add_argument("grid", choices=("study", "paper"), help="depth x split size, or the paper's own figures")
    parser.add_argument("--source", choices=("published", "wing"), default="published", help="the strains")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--restarts", type=int, default=4, help="of hyperplanes for mu2; others: five times as many")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--out", default="results/uav/complexity")
    return parser


if __name__ == "__main__":
    run_main(main)
