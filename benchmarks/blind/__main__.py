"""Make, diagnose and score a sealed set: `python -m benchmarks.blind [--cases 600] [--seed N] [--jobs 2] [--out DIR]`.

Three steps, each its own function: the cases are sealed, diagnosed by processes that are told the campaigns' folder
alone, and only then are the keys opened. Without --seed the seed comes from the clock, so no code can have been made
for it.
"""

import argparse
import json
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from benchmarks.blind.answers import answer, group_lasso, write
from benchmarks.blind.asset import REFINEMENT
from benchmarks.blind.cases import seal
from benchmarks.blind.guards import guards
from benchmarks.blind.score import figures, open_keys, strata


def main():
    """Run one set and print its tables in Markdown."""
    parser = argparse.ArgumentParser(prog="benchmarks.blind", description=__doc__)
    parser.add_argument("--cases", type=int, default=600)
    parser.add_argument("--seed", type=int, default=None, help="of the set; default: the clock")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=None, help="folder for campaigns, diagnoses and keys")
    parser.add_argument(
        "--without", type=float, default=0.25, help="share diagnosed once more without commissioning run"
    )
    parser.add_argument("--lasso", type=int, default=30, help="cases for the group lasso")
    options = parser.parse_args()
    seed = int(time.time()) if options.seed is None else options.seed
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.out or Path(scratch) / "set"
        print(run(folder, seed, options.cases, options.jobs, options.without, options.lasso))


def run(folder, seed, count, jobs, without, n_lasso, asset_mesh=REFINEMENT, twin_mesh=1.0):
    """Seal, diagnose, open, score; return the tables in Markdown."""
    folder.mkdir(parents=True, exist_ok=True)
    keys = folder.resolve().parent / f"{folder.name}.keys.json"
    start = time.time()
    seal(folder, keys, seed, count, asset_mesh)
    sealed = time.time()
    names = sorted(path.stem for path in (folder / "campaigns").glob("*.csv"))
    tasks = [(folder, name, True, twin_mesh) for name in names]
    tasks += [(folder, name, False, twin_mesh) for name in names[: round(without * len(names))]]
    lassos = [(folder, name, twin_mesh) for name in names[:n_lasso]]
    if jobs > 1:
        with ProcessPoolExecutor(jobs) as pool:
            found = list(pool.map(answer, *zip(*tasks, strict=True), chunksize=4))
            lasso = dict(zip(names[:n_lasso], pool.map(group_lasso, *zip(*lassos, strict=True)), strict=False))
    else:
        found = [answer(*task) for task in tasks]
        lasso = {task[1]: group_lasso(*task) for task in lassos}
    write(folder / "diagnoses.jsonl", found)
    done = time.time()
    answers = open_keys(folder, keys)
    tables = [f"Seed {seed}, {len(names)} cases, sealed in {sealed - start:.0f} s, diagnosed in {done - sealed:.0f} s."]
    for title, is_calibrated in (("With the commissioning run", True), ("Without a commissioning run", False)):
        part = [f for f in found if f["calibrated"] == is_calibrated]
        if part:
            tables.append(_markdown(title, figures(part, answers) + strata(part, answers)))
    tables.append(_markdown("Guards and baselines", guards([f for f in found if f["calibrated"]], answers, lasso)))
    (folder / "tables.md").write_text("\n\n".join(tables) + "\n")
    (folder / "lasso.json").write_text(json.dumps(lasso))
    return "\n\n".join(tables)


def _markdown(title, rows):
    lines = [f"| {title} | measured (95 % interval) |", "|---|---|"]
    return "\n".join([*lines, *(f"| {row.name} | {row.words()} |" for row in rows)])


if __name__ == "__main__":
    main()
