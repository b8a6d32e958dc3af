"""`python -m benchmarks.uav.risk`: risk-weighted trees by the price of a failure, one table."""

import argparse
import time
from pathlib import Path

from benchmarks.data import SHARED
from benchmarks.main_program import run_main
from benchmarks.uav.risk.decisions import Row, decision_rows, state_rows
from benchmarks.uav.risk.tables import decision_table
from femlib.dataset import MeanStrains, Recipe, build_dataset, published_strains, simulated_strains
from femlib.wing import uav_wing


def main(arguments: list[str] | None = None) -> None:
    """Run the study with the options of the command line."""
    options = _parser().parse_args(arguments)
    recipe = Recipe(samples_per_state=10) if options.smoke else Recipe()
    depth, seeds = (2, (0,)) if options.smoke else (3, range(options.seeds))
    start, means = time.process_time(), _means(options.source)
    rows: list[Row] = []
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    text = ""
    for n, seed in enumerate(seeds, start=1):
        data = build_dataset(means, recipe, seed=seed)
        rows += [*decision_rows(data, seed, depth), *state_rows(data, seed, depth)]
        seconds = time.process_time() - start
        text = f"{means.source}, {n} seeds, {seconds:.0f} CPU s\n\n{decision_table(rows)}"
        (folder / f"risk_{options.source}.md").write_text(text)  # each seed is kept, should the next be interrupted
    print(text)


def _means(source: str) -> MeanStrains:
    return simulated_strains(uav_wing()) if source == "wing" else published_strains(SHARED / "uav" / "strains.csv")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.uav.risk", description=__doc__)
    parser.add_argument("--source", choices=("published", "wing"), default="published", help="the strains")
    parser.add_argument("--seeds", type=int, default=3, help="so many, from 0")
    parser.add_argument("--smoke", action="store_true", help="few readings, depth 2, one seed: does it run?")
    parser.add_argument("--out", default="results/uav")
    return parser


if __name__ == "__main__":
    run_main(main)
