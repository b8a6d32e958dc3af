"""The loop of the wing: a damage that no library holds, from the watch's alarm to a tree that reads it.

    python -m benchmarks.wing.loop [--region R25] [--size 0.6] [--refinement 0.35] [--tables FOLDER]

The reduced wing of 28 regions is made once and kept in the folder. `octmip monitor` trains trees of mu1 and mu2 on it.
Then an asset flies 100 readings at load factor 3 with the paper's noise: mu1 and mu2 grow to 30 %, and from reading 40
on another region has lost a share of its stiffness at once. Its strains are those of the full wing on the same mesh.
`octmip monitor` with these readings is timed. With --tables each of the 26 regions is damaged in turn.
"""

import argparse
import contextlib
import io
import json
import time
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.main_program import run_main
from femlib.wing import Wing, WingTwin, reduce_wing, saved_twin, uav_wing
from femlib.wing.damage import damage_library
from octmip.formats.files import write_bytes
from octmip.interfaces.cli import main as octmip_command
from octmip.interfaces.report.markdown import markdown_table

FOLDER = "results/wing/loop"
LOAD_FACTOR, NOISE_SD = 3.0, float(np.sqrt(1000.0))
N_READINGS, BEGINS = 100, 40
WORDS = ["monitor", "--twin", "benchmarks.wing.loop:twin", "--depth", "3", "--seconds", "20"]
GROWN = 0.3
"""Damage of the two known regions at the last reading."""


def twin() -> WingTwin:
    """Return the twin of the wing of 28 regions that is kept in the folder."""
    return saved_twin(Path(FOLDER) / "wing.npz")


def main() -> None:
    """Print what the command says, and its time."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.loop", description=__doc__)
    parser.add_argument("--region", default="R25", help="the region that no library holds")
    parser.add_argument("--size", type=float, default=0.6, help="share of stiffness that it loses")
    parser.add_argument("--refinement", type=float, default=0.35)
    parser.add_argument("--tables", help="folder for the CSV file of all regions")
    options = parser.parse_args()
    folder = Path(FOLDER)
    folder.mkdir(parents=True, exist_ok=True)
    wing = uav_wing(refinement=options.refinement, regions=damage_library())
    if not (folder / "wing.npz").exists():
        reduce_wing(wing).save(folder / "wing.npz")
    given = ["--only", "mu1,mu2", "--load", f"load_factor={LOAD_FACTOR:g}", "--noise", f"{NOISE_SD:.6g}"]
    octmip_command([*WORDS, *given, "--out", str(folder / "deployed")])
    if not options.tables:
        flight(wing, options.region, options.size).to_csv(folder / "flight.csv", index=False)
        start = time.perf_counter()
        octmip_command([*WORDS, *again()])
        print(f"from the readings to the trees: {time.perf_counter() - start:.1f} s")
        return
    rows = [closed(wing, own.name, options.size) for own in wing.regions[2:]]
    print(markdown_table(rows))
    Path(options.tables).mkdir(parents=True, exist_ok=True)
    write_bytes(Path(options.tables) / "loop.csv", pd.DataFrame(rows).to_csv(index=False).encode())


def again() -> list[str]:
    """Return the words that close the loop over the flight in the folder."""
    folder = Path(FOLDER)
    read = ["--deployed", str(folder / "deployed"), "--readings", str(folder / "flight.csv")]
    return [*read, "--out", str(folder / "enriched")]


def closed(wing: Wing, region: str, size: float) -> dict[str, object]:
    """Close the loop over one damage by the command, and return what it said, and its time."""
    flight(wing, region, size).to_csv(Path(FOLDER) / "flight.csv", index=False)
    start = time.perf_counter()
    with contextlib.redirect_stdout(io.StringIO()) as said:
        octmip_command([*WORDS, *again(), "--json"])
    seconds, found = time.perf_counter() - start, json.loads(said.getvalue())
    own = next(one for one in wing.regions if one.name == region)
    row: dict[str, object] = {"region": region, "surface": own.surface, "alarm at reading": found["watch"]["alarm"]}
    row["gauges left out"] = len(found["watch"]["faulty_gauges"])
    if found["watch"]["inspect"]:
        first = found["watch"]["inspect"][0]
        row |= {"named right": first["name"] == own.parameter, "probability": round(first["probability"], 3)}
    if "trees" in found:
        new, told = found["trees"][-1], found["told_since"]
        error = sum(abs(float(level) - size) * count for level, count in told.items()) / sum(told.values())
        row |= {
            "new tree off by %": round(100 * new["retrained_off_by"], 1),
            "proven": new["is_optimal"],
            "off by in this flight %": round(100 * error, 1),
            "deployed trees kept": sum(one["change"] == "kept" for one in found["trees"]),
            "readings explained": found["alarm_of_enriched_library"] is None,
        }
    row["seconds"] = round(seconds, 1)
    print(row, flush=True)
    return row


def flight(wing: Wing, region: str, size: float, seed: int = 0) -> pd.DataFrame:
    """Return the readings of a flight in which a third region is damaged, as a campaign."""
    names = [own.name for own in wing.regions]
    states = np.zeros((N_READINGS, len(names)))
    states[:, :2] = np.linspace(0.0, GROWN, N_READINGS)[:, None]
    states[BEGINS:, names.index(region)] = size
    strains = np.concatenate([wing.strains_microstrain(row[None], LOAD_FACTOR) for row in states])
    readings = strains + np.random.default_rng(seed).normal(0.0, NOISE_SD, strains.shape)
    table = pd.DataFrame(readings, columns=list(wing.gauges.names))
    table.insert(0, "load_factor", LOAD_FACTOR)
    table.insert(0, "test", "flight")
    return table


if __name__ == "__main__":
    run_main(main)
