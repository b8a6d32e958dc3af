"""Without a run: an asset that obeys its twin's own equations, its constants 5 % off those of the drawing."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.figure import Figure, share, statistic
from benchmarks.machines.draws import Key
from benchmarks.machines.machine import Machine, Numbers
from benchmarks.machines.selectors import BUILT, Said
from benchmarks.seals import is_right
from femlib.arrays import FloatArray

STATED = 0.95
INFINITY = float("inf")


def of_its_twin(machine: Machine) -> Machine:
    """Return the machine whose asset is its twin with other constants; nothing is outside the library."""
    twin = machine.twin()

    def own(rng: np.random.Generator) -> Numbers:
        return {name: 1.0 + BUILT * float(rng.standard_normal()) for name in twin.card.ranges}

    def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
        return np.asarray(twin.function(today(machine, own, faults), loads), dtype=np.float64)

    return replace(machine, own=own, measure=measure, outside={})


def today(machine: Machine, own: Numbers, faults: Numbers) -> dict[str, float]:
    """Return the constants: a fault is a share of one, or the value of one that is 0 in the drawing."""
    nominal = {name: one.nominal for name, one in machine.twin().card.ranges.items()}
    return {k: v * own[k] * (1.0 + faults.get(k, 0.0)) if v else faults.get(k, 0.0) for k, v in nominal.items()}


def bare_figures(machine: Machine, cases: Sequence[tuple[Said, Key]]) -> list[Figure]:
    """Return what a diagnosis without a run is judged by."""
    named = [(s, k) for s, k in cases if s.names and ["unknown"] not in s.names]
    stated = [is_right(s.names, k["names"]) for s, k in named if s.probability >= STATED]
    singles = [is_right(s.names, k["names"]) for s, k in cases if k["stratum"] == "single"]
    held = []
    for said, key in cases:
        truth = today(machine, key["own"], {kind: size for kind, place, size in key["faults"] if not place})
        held += [low <= truth[name] <= high for name, low, high in said.constants]
    return [
        share("names stated at 0.95 and more, wrong", [not hit for hit in stated], (-INFINITY, 0.08)),
        share("90 % intervals that hold a constant", held, (0.86, 0.94)),
        share("single faults, named right", singles),
        share("sound, called faulty", [bool(s.names) for s, k in cases if k["stratum"] == "sound"]),
        statistic("CPU seconds", [said.seconds for said, _ in cases], np.median),
    ]
