"""Strangers' machines: `python -m benchmarks.strangers [--draws 40] [--seed N] [--selector plain] [--out DIR]`.

Each draw is another machine with a sound commissioning run of the same cells. Half of the draws have one fault, a
quarter none, a quarter one that no library holds. Cases are sealed, then answered, and only then are the keys opened.
Without --seed the seed comes from the clock.
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

from benchmarks.figure import Figure, share, statistic, table
from benchmarks.seals import is_right, open_keys
from benchmarks.strangers.draws import Key, seal
from benchmarks.strangers.frame import FRAME
from benchmarks.strangers.motor import MOTOR
from benchmarks.strangers.selectors import SELECTORS, Said, answer

STRANGERS = {"motor": MOTOR, "frame": FRAME}
STATED = 0.95
INFINITY = float("inf")


def main() -> None:
    """Seal, answer, open, and print the table in Markdown."""
    parser = argparse.ArgumentParser(prog="benchmarks.strangers", description=__doc__)
    parser.add_argument("--draws", type=int, default=40, help="of each machine")
    parser.add_argument("--seed", type=int, default=None, help="default: the clock")
    parser.add_argument("--machine", action="append", choices=STRANGERS, help="may be given more than once")
    parser.add_argument("--selector", action="append", choices=SELECTORS, help="may be given more than once")
    parser.add_argument("--out", type=Path, default=None, help="folder for cases and answers; it must be new")
    options = parser.parse_args()
    folder = options.out or Path(tempfile.mkdtemp(prefix="strangers"))
    seed = int(time.time()) if options.seed is None else options.seed
    print(run(folder, seed, options.draws, options.machine or list(STRANGERS), options.selector or list(SELECTORS)))


def run(folder: Path, seed: int, draws: int, machines: Sequence[str], selectors: Sequence[str]) -> str:
    """Return the table of a set, which is made in a new folder."""
    folder.mkdir(parents=True, exist_ok=True)
    keys = folder.resolve().parent / f"{folder.name}.keys.json"
    seal(folder, keys, seed, draws, [STRANGERS[name] for name in machines])
    said = {(m, s): _asked(folder, m, s) for m in machines for s in selectors}
    with (folder / "answers.jsonl").open("w") as file:
        for (_, selector), found in said.items():
            file.writelines(json.dumps({"case": k, "selector": selector, **asdict(v)}) + "\n" for k, v in found.items())
    cases: dict[str, Key] = open_keys(folder, keys)
    columns = {
        f"{machine}: {selector}": figures([(found[name], cases[name]) for name in found])
        for (machine, selector), found in said.items()
    }
    return f"Seed {seed}, {draws} draws of each.\n\n{table('Machines of strangers, with a run', columns)}"


def _asked(folder: Path, machine: str, selector: str) -> dict[str, Said]:
    twin, found = STRANGERS[machine].twin(), {}
    for place in sorted((folder / machine).iterdir()):
        found[place.name] = answer(place, twin, selector)
        print(f"{place.name}, {selector}: {found[place.name].names}", file=sys.stderr)
    return found


def figures(cases: Sequence[tuple[Said, Key]]) -> list[Figure]:
    """Return what a selector is judged by."""
    by = {s: [(said, key) for said, key in cases if key["stratum"] == s] for s in ("single", "sound", "outside")}
    usual = [*by["single"], *by["sound"]]
    stated = [is_right(said.names, truth_of(key)) for said, key in cases if said.probability >= STATED]
    return [
        share("single faults, named right", [is_right(s.names, k["names"]) for s, k in by["single"]], (0.9, INFINITY)),
        share("sound, accused", [bool(said.names) for said, _ in by["sound"]], (-INFINITY, 0.0)),
        share("outside, called unexplained", [["unknown"] in s.names for s, _ in by["outside"]], (0.9, INFINITY)),
        share("95 % sets that hold the truth", [any(is_right(g, k["names"]) for g in s.credible) for s, k in usual]),
        statistic("their size", [len(said.credible) for said, _ in usual]),
        share("stated 0.95 and more, wrong", [not hit for hit in stated]),
        share("run doubted", [bool(said.doubts) for said, _ in cases], (-INFINITY, 0.0)),
        statistic("CPU seconds", [said.seconds for said, _ in cases], np.median),
    ]


def truth_of(key: Key) -> list[str]:
    """Return the names of the truth as an answer would say them."""
    return ["unknown"] if key["stratum"] == "outside" else key["names"]


if __name__ == "__main__":
    main()
