"""`python -m benchmarks.uav`: run the UAV study and write `results/uav/`."""

import argparse
import os
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no display is needed, nor looked for

from benchmarks.main_program import run_main
from benchmarks.uav import baselines
from benchmarks.uav.report import write_results
from benchmarks.uav.study import StudyLimits, run_study
from femlib.dataset import Recipe, build_dataset, published_strains, simulated_strains
from femlib.wing import tapered_wing, uav_wing

WINGS = {"uav": uav_wing, "tapered": tapered_wing}
PUBLISHED = Path(__file__).parents[2].parent / "shared" / "uav" / "strains.csv"


def main() -> None:
    """Run the study with the options of the command line."""
    options = _parser().parse_args()
    start = time.perf_counter()
    wing = WINGS[options.wing]()
    reference = published_strains(options.published) if Path(options.published).exists() else None
    simulated = simulated_strains(wing)
    means = published_strains(options.strains) if options.strains else simulated
    data = build_dataset(means, Recipe(), seed=options.seed)
    print(f"{data.source}: {len(data.features)} readings of {len(data.gauges)} gauges; solving ...", flush=True)
    outcomes = run_study(data, StudyLimits(options.seconds, options.mio_seconds), options.seed, options.jobs)
    folder = Path(options.out)
    write_results(folder, wing, simulated, reference, data, outcomes, time.perf_counter() - start)
    beside = baselines.rows_of(data, options.seed, options.seconds, options.jobs)
    (folder / "baselines.md").write_text(baselines.text_of(beside))
    print((folder / "table.md").read_text())
    print((folder / "baselines.md").read_text())
    print(f"{time.perf_counter() - start:.0f} s; table, pictures and run.json lie in {folder.resolve()}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.uav", description=__doc__)
    parser.add_argument("--wing", choices=sorted(WINGS), default="uav", help="which of femlib's wings")
    parser.add_argument("--strains", help="published strain table (CSV); default: strains of femlib's wing")
    parser.add_argument("--published", default=PUBLISHED, help="published table to draw beside the model's strain")
    parser.add_argument("--seconds", type=float, default=10.0, help="limit of each solve [s]")
    parser.add_argument("--mio-seconds", type=float, default=3.0, help="limit of each solve by HiGHS [s]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes")
    parser.add_argument("--out", default="results/uav")
    return parser


if __name__ == "__main__":
    run_main(main)
