"""The same readings told otherwise: `python -m benchmarks.machines.retold [--assets 20] [--seed N]`.

Single faults of the judged machines, white noise, a run of the same cells, all constants built `OFF` off the drawing:

* each cell's readings named as 1, 2, 4 and 8 tests;
* a model that takes `SECONDS` an answer, asked `CALLS` times at most, two at a time, its progress heard.
"""

import argparse
import time
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from benchmarks.machines.__main__ import JUDGED
from benchmarks.machines.machine import Machine
from benchmarks.machines.ties import Asset
from femlib.arrays import FloatArray
from octmip.gap import Budget, Campaign, Diagnosis, FunctionTwin, Recorded, diagnose, function_twin, gathered

OFF, REPEATS = 0.08, 16
TESTS = (1, 2, 4, 8)
CALLS, SECONDS = 100, 0.05


def built_off(machine: Machine) -> Machine:
    """Return the machine with every constant `OFF` off the drawing, more or less."""

    def own(rng: np.random.Generator) -> dict[str, float]:
        return {name: 1.0 + OFF * float(rng.choice([-1.0, 1.0])) for name in machine.own(rng)}

    return replace(machine, own=own)


def named_as(asset: Asset, rows: list[FloatArray], n_tests: int) -> Campaign:
    """Return the readings of every cell, cut into as many tests."""
    cells = asset.machine.cells
    parts = [(np.array_split(read, n_tests), cell) for read, cell in zip(rows, cells, strict=True)]
    tests = [Recorded(own[k], cell, test=f"T{k}") for k in range(n_tests) for own, cell in parts]
    return gathered(asset.machine.twin(), tests)


def slow(twin: FunctionTwin) -> FunctionTwin:
    """Return the twin with a model that takes its time."""

    def function(p: Mapping[str, float], loads: Mapping[str, float]) -> FloatArray:
        time.sleep(SECONDS)
        return np.asarray(twin.function(p, loads), dtype=np.float64)

    readings = dict(zip(twin.gauges, twin.units, strict=True))
    return function_twin(function, readings, twin.card.ranges, loads=twin.loads)


def is_named(found: Diagnosis, asset: Asset) -> bool:
    """Return whether the first cause is the fault, by one of its names."""
    groups = found.which[0].names
    return len(groups) == 1 and bool(groups[0] & set(asset.fault.names))


def run(seed: int, n_assets: int) -> str:
    """Return the counts of a seed."""
    rng, heard = np.random.default_rng(seed), list[int]()
    named: dict[str, list[bool]] = {}
    seconds = []
    for k in range(n_assets):
        asset = Asset(built_off(JUDGED[k % len(JUDGED)]), rng)
        twin = asset.machine.twin()
        rows = asset.rows(list(asset.machine.cells), REPEATS, [asset.fault], "")
        sound = asset.measured(twin, [], [])
        for n in TESTS:
            found = diagnose(named_as(asset, rows, n), twin, commissioning=sound)
            named.setdefault(f"as {n} tests" if n > 1 else "as one test", []).append(is_named(found, asset))
        start, before = time.perf_counter(), len(heard)
        budget = Budget(calls=CALLS, jobs=2, progress=lambda done, total: heard.append(done))
        found = diagnose(named_as(asset, rows, 1), slow(twin), commissioning=sound, budget=budget)
        seconds.append(time.perf_counter() - start)
        named.setdefault(f"in {CALLS} calls", []).append(is_named(found, asset))
        assert before < len(heard), "nothing was heard of the progress"
    told = ", ".join(f"{how} {sum(hits)}" for how, hits in named.items())
    each = f"{len(heard) / n_assets:.0f} answers heard and {np.median(seconds):.1f} s a slow diagnosis"
    return f"Seed {seed}: of {n_assets} single faults named right: {told}; {each}."


def main() -> None:
    """Print how many single faults are named however they are told."""
    parser = argparse.ArgumentParser(prog="benchmarks.machines.retold", description=__doc__)
    parser.add_argument("--assets", type=int, default=20)
    parser.add_argument("--seed", type=int, default=None, help="default: the clock")
    options = parser.parse_args()
    print(run(int(time.time()) if options.seed is None else options.seed, options.assets))


if __name__ == "__main__":
    main()
