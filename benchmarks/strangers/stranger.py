"""A stranger's machine: a twin, an asset that is not like it, and what may be wrong with the asset."""

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
class Stranger:
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
    offsets
        name of an offset of each reading in the library.
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
    offsets: Mapping[str, str]

    def means(self, own: Numbers, fault: Fault | None = None) -> FloatArray:
        """Return what the asset shows without noise (n_cells, n_readings)."""
        readings, rows = list(self.offsets), []
        for loads in self.cells:
            acting = {fault.kind: fault.size} if fault and not fault.place else {}
            felt = dict(loads)
            if fault and fault.kind == "load":
                felt[fault.place] *= 1.0 + fault.size
            rows.append(self.measure(own, acting, felt))
        means = np.array(rows)
        if fault and fault.place in readings:
            k = readings.index(fault.place)
            of = np.sqrt(np.mean(means[:, k] ** 2))
            means[:, k] += fault.size * (means[:, k] if fault.kind == "gain" else of)
        return means

    def singles(self, rng: np.random.Generator) -> list[Fault]:
        """Return one draw of each fault that the library holds: the machine's, gains, offsets and loads."""
        found = [Fault((name,), name, "", float(rng.uniform(*ends))) for name, ends in self.faults.items()]
        for name, offset in self.offsets.items():
            found.append(Fault(("gauge_gain",), "gain", name, _signed(rng, 0.03, 0.12)))
            found.append(Fault((offset,), "bias", name, _signed(rng, 0.03, 0.12)))
        found += [Fault((f"{name}_error",), "load", name, _signed(rng, 0.03, 0.08)) for name in self.cells[0]]
        return found

    def outsiders(self, rng: np.random.Generator) -> list[Fault]:
        """Return one draw of each thing that no library holds."""
        return [Fault((), name, "", float(rng.uniform(*ends))) for name, ends in self.outside.items()]


def _signed(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.choice([-1.0, 1.0]) * rng.uniform(low, high))


def off(rng: np.random.Generator) -> float:
    """Return a factor that is 3 to 12 % off one."""
    return 1.0 + _signed(rng, 0.03, 0.12)
