"""The asset of the sealed cases, whatever computes its strains: what a family must answer.

Everything about effects is this package's own: forces, constants, the order in which structure and measuring chain
act. It never imports a signature of the diagnosis or of `femlib.wing.effects`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import ClassVar, TypeVar, cast

import numpy as np

from benchmarks.blind.assets.moment import History, Moment, State
from femlib.arrays import FloatArray

T = TypeVar("T")

STATES: tuple[State, ...] = ((0.0, 0.0), (0.2, 0.0), (0.0, 0.4), (0.25, 0.45), (0.6, 0.2), (0.1, 0.7), (0.35, 0.1))
DAMAGED: State = (0.3, 0.0)
"""State of an asset that was damaged before its commissioning run."""
PARAMETERS = ("mu1", "mu2")
STEP = 0.02
"""Step of the damage from which the change of the strains with it is taken."""
LENGTH = 0.07
"""Typical length of a debond, span fractions: the bond is gone over 0.3 to 3 times this."""
HOUR = 3600.0
CHORDS = ((435.61, 433.0), (261.112, 260.0))
"""Designed and manufactured chord at root and tip [mm], of the public geometry table."""
SPANS = (1828.8, 1828.0)


@dataclass(frozen=True)
class Flaw:
    """One local fault of a structure, drawn once per set.

    Attributes
    ----------
    name
        "damage_outside_library" [%] or "spar_skin_debond" [-].
    place
        where, in words of the family's own.
    size
        how much.
    """

    name: str
    place: str
    size: float


def neighbours(state: State) -> tuple[State, ...]:
    """Return the states a step of damage further, one for each parameter."""
    return tuple(tuple(round(v + STEP * (k == p), 9) for k, v in enumerate(state)) for p in range(len(state)))


def log_uniform(rng: np.random.Generator) -> float:
    """Return a factor between 0.3 and 3, its logarithm uniform."""
    return float(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))


class Asset(ABC):
    """An asset as the cases see it.

    Attributes
    ----------
    family
        name of the code and mesh; its first word is its name on the command line.
    states
        damage states of the tests.
    n_places
        how many places there are of effects that are expensive to compute; 0: not in this family.
    outside
        kinds of change that no library holds.
    differs
        what another model of the wing differs by without a commissioning run, in common and per gauge: 1 %, or what
        was measured where that is more.
    gauges, eta, row, span
        of the gauges that lie in no region: name, span fraction, chordwise row; half-span [m].
    payloads, lifts
        names of the fields that were drawn for this set.
    flaws
        local faults that were drawn for it.
    """

    family: str = ""
    states: tuple[State, ...] = STATES
    n_places: ClassVar[Mapping[str, int]] = {
        "payload_inertia": 8,
        "damage_outside_library": 10,
        "spar_skin_debond": 8,
    }
    outside: ClassVar[tuple[str, ...]] = ()
    differs: ClassVar[tuple[float, float]] = (0.01, 0.01)
    gauges: tuple[str, ...]
    eta: FloatArray
    row: FloatArray
    span: float
    payloads: list[str]
    lifts: list[str]
    flaws: list[Flaw]

    def __init__(self) -> None:
        self._kept: dict[Hashable, object] = {}

    def kept(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what `make` returns, made once."""
        if key not in self._kept:
            self._kept[key] = make()
        return cast(T, self._kept[key])

    @abstractmethod
    def strain(self, state: State) -> FloatArray:
        """Return the strains (n_gauges,) at load factor 1 [microstrain, compressive positive]."""

    @abstractmethod
    def field(self, name: str, state: State) -> FloatArray:
        """Return the change of the strains (n_gauges,) per unit of a field, at load factor 1 or whatever the load."""

    @abstractmethod
    def softness(self, state: State) -> FloatArray:
        """Return b (n_gauges,) where skins stiffer by the share s have strain / (1 + b s)."""

    @abstractmethod
    def flaw(self, flaw: Flaw) -> FloatArray:
        """Return the change of the healthy wing's strains (n_gauges,) by a flaw at load factor 1."""

    @abstractmethod
    def bent(self, load: float) -> FloatArray:
        """Return the relative change of the strains (n_gauges,) by large deflection."""

    def stiffer(self, share: float, state: State) -> FloatArray:
        """Return the strains (n_gauges,) over the wing's own where the skins are stiffer by a share."""
        return np.asarray(1.0 / (1.0 + share * self.softness(state)))

    @abstractmethod
    def built(self) -> FloatArray:
        """Return the relative change of the strains (n_gauges,) by the manufactured planform."""

    def crept(self, times: FloatArray, history: History) -> FloatArray:
        """Return the load factor (n,) as creep weighs it, 1 an hour after a load of 1: a power law.

        Boltzmann's superposition: each step of the load creeps from its own start.
        """
        steps = zip(history, (0.0, *(load for load, _ in history)), strict=False)
        weighed = [(load - last) * self.creep(times - start) for (load, start), last in steps]
        return np.asarray(np.sum(weighed, axis=0))

    @abstractmethod
    def creep(self, since: FloatArray) -> FloatArray:
        """Return the creep (n,) a time [s] after a load, 1 after an hour."""

    @abstractmethod
    def turned(self, gauge: int) -> float:
        """Return one less the strain across a gauge over that along it: what a turned gauge loses of its reading."""

    @abstractmethod
    def slid(self, gauge: int, millimetres: float, moment: Moment, before: FloatArray) -> float:
        """Return the change of a mean reading (n_gauges,) where its gauge sits outboard."""
