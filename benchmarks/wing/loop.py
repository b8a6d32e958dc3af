"""The loop of the wing: a damage that no library holds, from the watch's alarm to a tree that reads it.

    python -m benchmarks.wing.loop [--refinement 0.35] [--all | --alarms]

The reduced wing of 28 regions is made once and kept in the folder. `octmip monitor` trains trees of mu1 and mu2 on it.
Then an asset flies 100 readings at load factor 3 with the paper's noise: mu1 and mu2 grow to 30 %, and from reading 40
on another region has lost a share of its stiffness at once. Its strains are those of the full wing on the same mesh.
`octmip monitor` with these readings is timed. With --all each of the 26 regions is damaged in turn. With --alarms
the watch alone sees `N_FLIGHTS` flights with each damage, and sound ones. d is the length of what a damage changes, in
standard deviations of a gauge: what states of the library could change as well is no sign of it and is left out.
"""

import argparse
import contextlib
import io
import json
import time
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from femlib.wing import Wing, WingTwin, reduce_wing, saved_twin, uav_wing
from femlib.wing.damage import damage_library
from octmip.interfaces.cli import main as octmip_command
from octmip.interfaces.report.markdown import markdown_table
from octmip.monitor import Watch, grid_states, library_of, state_candidates
from octmip.monitor.library import DEFAULT_LEVELS
from octmip.sensing.enrichment import PartOf

FOLDER = "results/wing/loop"
LOAD_FACTOR, NOISE_SD = 3.0, float(np.sqrt(1000.0))
N_READINGS, BEGINS = 100, 40
WORDS = ["monitor", "--twin", "benchmarks.wing.loop:twin", "--depth", "3", "--seconds", "20"]
GROWN = 0.3
"""Damage of the two known regions at the last reading."""
N_FLIGHTS = 200
REGION, SIZE = "R25", 0.6
"""The region that no library holds, and the share of stiffness that it loses."""
LEVELS = (0.4, 0.6, 0.8)


def twin() -> WingTwin:
    """Return the twin of the wing of 28 regions that is kept in the folder."""
    return saved_twin(Path(FOLDER) / "wing.npz")


def main() -> None:
    """Print what the command says, and its time."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.loop", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.35)
    parser.add_argument("--all", action="store_true", help="close the loop over each region, and print the table")
    parser.add_argument(
        "--alarms", action="store_true", help="the table of the alarms of the watch, instead of the loop"
    )
    options = parser.parse_args()
    folder = Path(FOLDER)
    folder.mkdir(parents=True, exist_ok=True)
    wing = uav_wing(refinement=options.refinement, regions=damage_library())
    if not (folder / "wing.npz").exists():
        reduce_wing(wing).save(folder / "wing.npz")
    if options.alarms:
        print(markdown_table(alarm_rows(wing)))
        return
    given = ["--only", "mu1,mu2", "--load", f"load_factor={LOAD_FACTOR:g}", "--noise", f"{NOISE_SD:.6g}"]
    octmip_command([*WORDS, *given, "--out", str(folder / "deployed")])
    if not options.all:
        flight(wing, REGION, SIZE).to_csv(folder / "flight.csv", index=False)
        start = time.perf_counter()
        octmip_command([*WORDS, *again()])
        print(f"from the readings to the trees: {time.perf_counter() - start:.1f} s")
        return
    print(markdown_table([closed(wing, own.name, SIZE) for own in wing.regions[2:]]))


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


def alarm_rows(wing: Wing) -> list[dict[str, object]]:
    """Return how large each damage is in the readings, and in how many flights the watch raises the alarm."""
    part = PartOf(twin(), ("mu1", "mu2"))
    library = library_of(part, grid_states([DEFAULT_LEVELS] * 2), NOISE_SD, load_factor=LOAD_FACTOR)
    watch = Watch(library, state_candidates(twin(), library), horizon=N_READINGS, largest_load=LOAD_FACTOR)
    free = watch.parity.projector(np.ones(len(library.gauges), dtype=bool))
    sound = alarms(watch, flown(len(wing.regions), 0, 0.0), 10 * N_FLIGHTS)
    rows: list[dict[str, object]] = [{"region": "none", "alarms %": 100 * float(np.mean(sound > 0))}]
    for k, own in enumerate(wing.regions[2:], start=2):
        for size in LEVELS:
            states = flown(len(wing.regions), k, size)
            without = states[BEGINS].copy()
            without[k] = 0.0
            apart = _strains(states[[BEGINS]]) - _strains(without[None])
            raised = alarms(watch, states, N_FLIGHTS)
            d = float(np.linalg.norm(apart[0] / NOISE_SD @ free))
            row: dict[str, object] = {"region": own.name, "surface": own.surface, "lost %": round(100 * size)}
            row |= {"d of a reading": round(d, 2), "d of 60 readings": round(d * np.sqrt(N_READINGS - BEGINS), 1)}
            row |= {"d of a reading, mu1 and mu2 known": round(float(np.linalg.norm(apart[0])) / NOISE_SD, 2)}
            row |= {"alarms %": round(100 * float(np.mean(raised > BEGINS)), 1)}
            if (raised > BEGINS).mean() >= 0.5:
                row |= {"readings to the alarm, median": round(float(np.median(raised[raised > BEGINS]))) - BEGINS}
            rows.append(row)
    return rows


def alarms(watch: Watch, states: NDArray[np.float64], n: int) -> NDArray[np.int64]:
    """Return the reading (n,) from 1 at which each of n flights through states raises the alarm, 0 where none does."""
    rng, seen = np.random.default_rng(1), watch.start(n)
    raised = np.zeros(n, dtype=np.int64)
    for k, clean in enumerate(_strains(states), start=1):
        readings = clean + rng.normal(0.0, NOISE_SD, (n, len(clean)))
        seen = watch.observe(seen, readings, LOAD_FACTOR)
        raised = np.where(seen.is_alarm & (raised == 0), k, raised)
    return raised


def _strains(states: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(LOAD_FACTOR * twin().predict_states(states, 1.0))


def flown(n_regions: int, region: int, size: float) -> NDArray[np.float64]:
    """Return the states (N_READINGS, n_regions) of a flight in which a region is damaged from `BEGINS` on."""
    states = np.zeros((N_READINGS, n_regions))
    states[:, :2] = np.linspace(0.0, GROWN, N_READINGS)[:, None]
    if size:
        states[BEGINS:, region] = size
    return states


def flight(wing: Wing, region: str, size: float) -> pd.DataFrame:
    """Return the readings of a flight in which a third region is damaged, as a campaign."""
    names = [own.name for own in wing.regions]
    states = flown(len(names), names.index(region), size)
    strains = np.concatenate([wing.strains_microstrain(row[None], LOAD_FACTOR) for row in states])
    readings = strains + np.random.default_rng(0).normal(0.0, NOISE_SD, strains.shape)
    table = pd.DataFrame(readings, columns=list(wing.gauges.names))
    table.insert(0, "load_factor", LOAD_FACTOR)
    table.insert(0, "test", "flight")
    return table


if __name__ == "__main__":
    run_main(main)
