"""Ties, and whether the proposed test settles them: `python -m benchmarks.machines.ties [--wanted 40] [--seed N]`.

A single fault of a judged machine is diagnosed by run and campaign. Where the first cause holds the true name beside
others that cannot be told from it, the first proposal of `next_test` is carried out on the asset, and the whole is
diagnosed again; beside it a random load of the campaign is read again as often. A tie mixes what is done at different
places, an instrument, a load or the machine, or leaves the true name less than `OPEN`. It is settled where the first
cause holds the true name and the same place alone.
"""

import argparse
import time
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from benchmarks.machines.__main__ import JUDGED
from benchmarks.machines.machine import Fault, Machine, Numbers
from femlib.arrays import FloatArray
from octmip.gap import Campaign, Diagnosis, FunctionTwin, Odds, Recorded, diagnose, function_twin, gathered
from octmip.gap.next_test import REPEATS, Proposal

CELL = "load_cell"
OTHER = "_2"
"""What the reading of a second instrument ends with."""
MOST, OPEN = 600, 0.9


class Asset:
    """A machine with one fault, its run, and its campaign."""

    def __init__(self, machine: Machine, rng: np.random.Generator) -> None:
        self.machine, self.rng, self.own = machine, rng, machine.own(rng)
        singles = machine.singles(rng)
        self.fault = singles[int(rng.integers(len(singles)))]

    def rows(self, cells: list[Numbers], repeats: int, faults: list[Fault], second: str) -> list[FloatArray]:
        """Return readings (repeats, n_readings) of each cell, beside them those of a second instrument of a reading."""
        found: list[FloatArray] = []
        if not cells:
            return found
        means = self.machine.means(self.own, faults, cells)
        true = self.machine.means(self.own, [fault for fault in faults if fault.place != second], cells)
        for row, own in zip(means, true, strict=True):
            read = row + self.machine.noise * self.rng.standard_normal((repeats, len(row)))
            if second:
                k = self.machine.readings.index(second)
                read = np.column_stack([read, own[k] + self.machine.noise[k] * self.rng.standard_normal(repeats)])
            found.append(read)
        return found

    def measured(self, twin: FunctionTwin, faults: list[Fault], more: list[Recorded]) -> Campaign:
        """Return every cell, and more; a second instrument reads nothing there."""
        cells, width = list(self.machine.cells), len(twin.gauges)
        blocks = []
        for cell, rows in zip(cells, self.rows(cells, self.machine.repeats, faults, ""), strict=True):
            empty = np.full((len(rows), width - rows.shape[1]), np.nan)
            blocks.append(Recorded(np.column_stack([rows, empty]), cell, test="T1"))
        return gathered(twin, [*blocks, *more])


def twin_with(machine: Machine, second: str) -> FunctionTwin:
    """Return the twin with a second instrument at a reading."""
    twin = machine.twin()
    if not second:
        return twin
    k = twin.gauges.index(second)
    readings = dict(zip(twin.gauges, twin.units, strict=True)) | {second + OTHER: twin.units[k]}

    def function(p: Numbers, loads: Numbers) -> list[float]:
        answer = list(np.asarray(twin.function(p, loads), dtype=np.float64))
        return [*answer, answer[k]]

    return function_twin(function, readings, twin.card.ranges, loads=twin.loads)


def diagnosed(asset: Asset, state: dict[str, object], proposal: Proposal | None, load: Numbers | None) -> Diagnosis:
    """Return the diagnosis after a proposal, or after a load is read again; the noise is drawn anew from one state."""
    asset.rng.bit_generator.state = state
    second = proposal.gauge if proposal is not None else ""
    twin = twin_with(asset.machine, second)
    cells: list[Numbers] = [load] if load is not None else list(asset.machine.cells) if second else []
    repeats = REPEATS if load is not None else asset.machine.repeats
    more = [
        Recorded(rows, cell, test="T2")
        for cell, rows in zip(cells, asset.rows(cells, repeats, [asset.fault], second), strict=True)
    ]
    now, odds = asset.measured(twin, [asset.fault], more), Odds()
    if proposal is not None and proposal.name == CELL:  # the loads are known now, and were what was felt
        felt = [1.0 + asset.fault.size * (name == asset.fault.place) for name in now.load_names]
        now = replace(now, load_factor=now.load_factor * (felt if len(felt) > 1 else felt[0]))
        odds = Odds(effects={f"{name}_{what}": 0.0 for name in now.load_names for what in ("error", "offset")})
    return diagnose(now, twin, commissioning=asset.measured(twin, [], []), odds=odds)


def kinds(names: Iterable[str], machine: Machine) -> set[str]:
    """Return where names act: at an instrument, at a load, or in the machine."""
    loads = {f"{load}_{what}" for load in machine.cells[0] for what in ("error", "offset")}
    own = machine.twin().card.ranges
    return {"load" if name in loads else "machine" if name in own else "instrument" for name in names}


def is_settled(found: Diagnosis, fault: Fault, machine: Machine) -> bool:
    """Return whether the first cause holds the true name, and others of the same place alone.

    Where the loads are known to have been wrong, nothing is left.
    """
    groups = [set(group) for group in found.which[0].names]
    if fault.kind == "load" and not any(name in found.inclusion for name in fault.names):
        return not groups
    return len(groups) == 1 and set(fault.names) <= groups[0] and len(kinds(groups[0], machine)) == 1


def is_tie(found: Diagnosis, fault: Fault, machine: Machine) -> bool:
    """Return whether the first cause holds the true name beside another of another place that is not improbable."""
    cause = found.which[0]
    if len(cause.names) != 1 or not cause.confounded or not set(fault.names) <= set(cause.names[0]):
        return False
    shares = dict(zip(cause.confounded[0].effects, cause.confounded[0].shares, strict=True))
    return len(kinds(shares, machine)) > 1 and max(shares.values()) < OPEN


def main() -> None:
    """Print how many ties the proposals settle, and how many random repeats."""
    parser = argparse.ArgumentParser(prog="benchmarks.machines.ties", description=__doc__)
    parser.add_argument("--wanted", type=int, default=40, help="ties")
    parser.add_argument("--seed", type=int, default=None, help="default: the clock")
    options = parser.parse_args()
    seed = int(time.time()) if options.seed is None else options.seed
    print(run(seed, options.wanted))


def run(seed: int, wanted: int) -> str:
    """Return the counts of a seed."""
    rng, n_asked = np.random.default_rng(seed), 0
    by: dict[str, list[bool]] = {}
    repeats: list[bool] = []
    while len(repeats) < wanted and n_asked < MOST:
        asset = Asset(JUDGED[n_asked % len(JUDGED)], rng)
        n_asked += 1
        state = dict(rng.bit_generator.state)
        first = diagnosed(asset, state, None, None)
        if not is_tie(first, asset.fault, asset.machine):
            continue
        cells = list(asset.machine.cells)
        again = cells[int(rng.integers(len(cells)))]
        proposal = first.next_test[0] if first.next_test else None
        kind = "none" if proposal is None else "cell" if proposal.name == CELL else proposal.name.split("_")[0]
        load = proposal.load if proposal is not None else None
        at = dict(load) if isinstance(load, Mapping) else None
        done = proposal is not None and (at is not None or bool(proposal.gauge) or kind == "cell")
        after = diagnosed(asset, state, proposal, at) if done else first
        by.setdefault(kind, []).append(is_settled(after, asset.fault, asset.machine))
        repeats.append(is_settled(diagnosed(asset, state, None, again), asset.fault, asset.machine))
    told = ", ".join(f"{kind} {sum(hits)} of {len(hits)}" for kind, hits in sorted(by.items()))
    settled = sum(map(sum, by.values()))
    return (
        f"Seed {seed}: {len(repeats)} ties among {n_asked} single faults; the proposal settles {settled} ({told}), a "
        f"random repeat {sum(repeats)}."
    )


if __name__ == "__main__":
    main()
