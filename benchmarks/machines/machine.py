"""A machine: a twin of some lines, an asset that obeys another model, and what may be wrong with the asset."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin

Numbers = Mapping[str, float]
Measure = Callable[[Numbers, Numbers, Numbers], FloatArray]
"""What makes this machine its own, faults by name, loads -> readings (n_readings,)."""


@dataclass(frozen=True)
class Fault:
    """What is wrong with an asset.

    Attributes
    ----------
    names
        what a diagnosis may call it; empty where no library holds it.
    kind
        a fault of the machine by name, or "gain", "bias" or "load".
    place
        the reading or the load that is wrong; "" for a fault of the machine.
    size
        in the unit of the machine's model; of the measuring chain a share.
    """

    names: tuple[str, ...]
    kind: str
    place: str
    size: float


@dataclass(frozen=True)
class Machine:
    """One machine.

    Attributes
    ----------
    name
        in one word.
    twin
        makes the user's twin.
    cells
        loads at which everything is read.
    repeats
        readings of each.
    noise
        (n_readings,) sd of one reading.
    own
        draws what makes one machine its own.
    measure
        the asset.
    faults
        least and greatest size of each fault of the machine that the twin has a parameter for.
    outside
        the same for what no library holds.
    """

    name: str
    twin: Callable[[], FunctionTwin]
    cells: Sequence[Numbers]
    repeats: int
    noise: FloatArray
    own: Callable[[np.random.Generator], Numbers]
    measure: Measure
    faults: Mapping[str, tuple[float, float]]
    outside: Mapping[str, tuple[float, float]]

    @property
    def readings(self) -> tuple[str, ...]:
        """Names of what is read."""
        return self.twin().gauges

    @property
    def new_cell(self) -> Numbers:
        """Loads that no campaign holds: between the first and the last ones."""
        first, last = self.cells[0], self.cells[-1]
        return {name: 0.45 * first[name] + 0.55 * last[name] for name in first}

    def means(self, own: Numbers, faults: Sequence[Fault] = (), cells: Sequence[Numbers] = ()) -> FloatArray:
        """Return what the asset shows without noise (n_cells, n_readings)."""
        acting = {fault.kind: fault.size for fault in faults if not fault.place}
        wrong = {fault.place: 1.0 + fault.size for fault in faults if fault.kind == "load"}

        def asked(some: Sequence[Numbers]) -> FloatArray:
            felt = [{name: load * wrong.get(name, 1.0) for name, load in loads.items()} for loads in some]
            return np.array([self.measure(own, acting, loads) for loads in felt])

        usual = asked(self.cells)
        found = asked(cells) if cells else usual.copy()
        for fault in faults:
            if fault.place in self.readings:
                k = self.readings.index(fault.place)
                of = np.sqrt(np.mean(usual[:, k] ** 2))
                found[:, k] += fault.size * (found[:, k] if fault.kind == "gain" else of)
        return found

    def singles(self, rng: np.random.Generator) -> list[Fault]:
        """Return one draw of each fault that the library holds: the machine's, gains, offsets and loads."""
        found = [Fault((name,), name, "", float(rng.uniform(*ends))) for name, ends in self.faults.items()]
        for name, unit in zip(self.readings, self.twin().units, strict=True):
            found.append(Fault(("gauge_gain",), "gain", name, _signed(rng, 0.03, 0.12)))
            found.append(Fault((_offset(unit),), "bias", name, _signed(rng, 0.03, 0.12)))
        found += [Fault((f"{name}_error",), "load", name, _signed(rng, 0.03, 0.08)) for name in self.cells[0]]
        return found

    def outsiders(self, rng: np.random.Generator) -> list[Fault]:
        """Return one draw of each thing that no library holds."""
        return [Fault((), name, "", float(rng.uniform(*ends))) for name, ends in self.outside.items()]


def _offset(unit: str) -> str:
    """Return what the library calls an offset of readings of a unit, one of several."""
    return (
        "gauge_bias" if unit == "microstrain" else f"gauge_bias_{re.sub(r'[^a-z0-9]+', '_', unit.lower()).strip('_')}"
    )


def _signed(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.choice([-1.0, 1.0]) * rng.uniform(low, high))


def off(rng: np.random.Generator) -> float:
    """Return a factor that is 3 to 12 % off one."""
    return 1.0 + _signed(rng, 0.03, 0.12)
