"""Machines: `python -m benchmarks.machines [--draws 50] [--seed N] [--selector squares] [--machine pump] [--out DIR]`.

Each draw is another machine with a sound commissioning run of the same cells: a fifth sound, two fifths with one fault,
a fifth with two, a fifth with one that no library holds; noise white, with a memory, or of a coarse display. Cases are
sealed, then answered, and only then are the keys opened. Constants were settled on `SETTLED`; `JUDGED` were asked
afterwards. Without --seed the seed comes from the clock.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.figure import Figure, area, share, statistic, table, tenth
from benchmarks.machines.bare import bare_figures, of_its_twin
from benchmarks.machines.draws import Key, seal
from benchmarks.machines.frame import FRAME
from benchmarks.machines.motor import MOTOR
from benchmarks.machines.oven import OVEN
from benchmarks.machines.panel import PANEL
from benchmarks.machines.pump import PUMP
from benchmarks.machines.selectors import SELECTORS, Said, answer, far
from benchmarks.machines.ship import SHIP
from benchmarks.machines.tanks import TANKS
from benchmarks.machines.transformer import TRANSFORMER
from benchmarks.seals import is_right, open_keys

SETTLED, JUDGED, OLD = (PUMP, OVEN, TRANSFORMER), (TANKS, SHIP, PANEL), (MOTOR, FRAME)
MACHINES = {machine.name: machine for machine in (*SETTLED, *JUDGED, *OLD)}
STATED = 0.95
INFINITY = float("inf")


def main() -> None:
    """Seal, answer, open, and print the table in Markdown."""
    parser = argparse.ArgumentParser(prog="benchmarks.machines", description=__doc__)
    parser.add_argument("--draws", type=int, default=50, help="of each machine")
    parser.add_argument("--seed", type=int, default=None, help="default: the clock")
    parser.add_argument("--machine", action="append", choices=MACHINES, help="may be given more than once")
    parser.add_argument("--selector", action="append", choices=list(SELECTORS), help="may be given again")
    parser.add_argument(
        "--without-run", action="store_true", help="assets that obey their twin, diagnosed without a run"
    )
    parser.add_argument("--out", type=Path, default=None, help="folder for cases and answers; it must be new")
    options = parser.parse_args()
    folder = options.out or Path(tempfile.mkdtemp(prefix="machines"))
    seed = int(time.time()) if options.seed is None else options.seed
    names = options.machine or list(MACHINES)
    if options.without_run:
        print(run_bare(folder, seed, options.draws, names))
    else:
        print(run(folder, seed, options.draws, names, options.selector or ["diagnosis", "plain"]))


def run_bare(folder: Path, seed: int, draws: int, machines: Sequence[str]) -> str:
    """Return the table of a set without runs, which is made in a new folder."""
    folder.mkdir(parents=True, exist_ok=True)
    keys = folder.resolve().parent / f"{folder.name}.keys.json"
    seal(folder, keys, seed, draws, [of_its_twin(MACHINES[name]) for name in machines])
    said = {name: _asked(folder, name, "bare") for name in machines}
    cases: dict[str, Key] = open_keys(folder, keys)
    columns = {
        name: bare_figures(MACHINES[name], [(answer, cases[k]) for k, answer in found.items()])
        for name, found in said.items()
    }
    return f"Seed {seed}, {draws} draws of each.\n\n{table('Machines, without a run', columns)}"


def run(folder: Path, seed: int, draws: int, machines: Sequence[str], selectors: Sequence[str]) -> str:
    """Return the table of a set, which is made in a new folder."""
    folder.mkdir(parents=True, exist_ok=True)
    keys = folder.resolve().parent / f"{folder.name}.keys.json"
    seal(folder, keys, seed, draws, [MACHINES[name] for name in machines])
    said = {
        selector: {k: v for m in machines for k, v in _asked(folder, m, selector).items()} for selector in selectors
    }
    with (folder / "answers.jsonl").open("w") as file:
        for selector, found in said.items():
            file.writelines(json.dumps({"case": k, "selector": selector, **asdict(v)}) + "\n" for k, v in found.items())
    cases: dict[str, Key] = open_keys(folder, keys)
    columns = {}
    for name, some in {**{machine: [machine] for machine in machines}, "all": machines}.items():
        for selector, found in said.items():
            kept = [(v, cases[k]) for k, v in found.items() if cases[k]["machine"] in some]
            columns[f"{name}: {selector}"] = figures(kept)
    return f"Seed {seed}, {draws} draws of each.\n\n{table('Machines, with a run', columns)}"


def _asked(folder: Path, machine: str, selector: str) -> dict[str, Said]:
    found = {}
    for place in sorted((folder / machine).iterdir()):
        found[place.name] = answer(place, MACHINES[machine], selector)
        print(f"{place.name}, {selector}: {found[place.name].names}", file=sys.stderr)
    return found


def figures(cases: Sequence[tuple[Said, Key]]) -> list[Figure]:
    """Return what a selector is judged by."""
    by = {s: [(a, key) for a, key in cases if key["stratum"] == s] for s in ("sound", "single", "pair", "outside")}
    held = [*by["single"], *by["pair"], *by["sound"]]
    stated = [is_right(said.names, truth_of(key)) for said, key in cases if said.probability >= STATED]
    right = [(s, k) for s, k in [*by["single"], *by["pair"]] if is_right(s.names, k["names"])]
    new = [c for s, k in right if (c := closed(s, k)) is not None]
    return [
        share("single faults, named right", [is_right(s.names, k["names"]) for s, k in by["single"]], (0.95, INFINITY)),
        share("pairs, both named right", [is_right(s.names, k["names"]) for s, k in by["pair"]], (0.85, INFINITY)),
        share("sound, accused", [bool(said.names) for said, _ in by["sound"]], (-INFINITY, 0.02)),
        share("outside, called unexplained", [["unknown"] in s.names for s, _ in by["outside"]], (0.85, INFINITY)),
        area("outside, AUROC", [s.unknown_probability for s, _ in by["outside"]],
             [s.unknown_probability for s, _ in held], (0.92, INFINITY)),
        share("95 % sets that hold the truth", [any(is_right(g, k["names"]) for g in s.credible) for s, k in held],
              (0.93, 0.99)),
        statistic("their size", [len(said.credible) for said, _ in held], np.mean, (-INFINITY, 1.4)),
        share("stated 0.95 and more, wrong", [not hit for hit in stated], (-INFINITY, 0.06)),
        share("90 % intervals that hold the size", [hit for s, k in right for hit in inside(s, k)], (0.86, 0.94)),
        share("`closed` above 1", [s.closed > 1.0 for s, _ in cases if s.closed is not None], (-INFINITY, 0.0)),
        statistic("closed at a new load, median", new, np.median, (0.97, INFINITY)),
        statistic("worst tenth", new, tenth, (0.85, INFINITY)),
        share("run doubted", [bool(said.doubts) for said, _ in cases], (-INFINITY, 0.0)),
        statistic("CPU seconds", [said.seconds for said, _ in cases], np.median),
        statistic("calls of the twin", [said.calls for said, _ in cases], np.median, (-INFINITY, 150.0)),
    ]  # fmt: skip


def truth_of(key: Key) -> list[str]:
    """Return the names of the truth as an answer would say them."""
    return ["unknown"] if key["stratum"] == "outside" else key["names"]


def closed(said: Said, key: Key) -> float | None:
    """Return the share of the gap at the new load that the first cause closes; None where it is within the noise."""
    if not said.new:
        return None
    machine = MACHINES[key["machine"]]
    before, after = far(machine, said.before, key["new"]), far(machine, said.new, key["new"])
    return 1.0 - after**2 / before**2 if before > 3.0 else None


def inside(said: Said, key: Key) -> list[bool]:
    """Return whether the intervals of a right cause hold the sizes of gains and loads [%], which the key holds."""
    sizes = {("gauge_gain", place): 100.0 * size for kind, place, size in key["faults"] if kind == "gain"}
    sizes |= {(f"{place}_error", ""): 100.0 * size for kind, place, size in key["faults"] if kind == "load"}
    held = [(sizes.get((name, place)), low, high) for name, place, low, high in said.sizes]
    return [low <= size <= high for size, low, high in held if size is not None]


if __name__ == "__main__":
    main()
