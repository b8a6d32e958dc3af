"""The second family of assets: strains that CalculiX computes, on quadratic shells of its own.

Some forty linear runs of `ccx` make a set: the lift in each state, every field in three states, a stiffer skin and two
foreign patches. They are kept in a file beside the keys, so that a set which goes on does not run them again. What is
left to femlib: nonlinearity (its relative change alone) and, as no debonds are modelled in the decks, none of those.
"""

import json
import tempfile
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, TypedDict

import numpy as np

from benchmarks import ccx
from benchmarks.blind.assets import forces
from benchmarks.blind.assets.asset import DAMAGED, PARAMETERS, STATES, Flaw, neighbours
from benchmarks.blind.assets.moment import State
from benchmarks.blind.assets.shells import THICKER, ShellAsset
from femlib.arrays import FloatArray
from femlib.components import DamagedStructure
from femlib.wing import Wing, tapered_wing
from femlib.wing.export.calculix import read_gauges, write_deck
from femlib.wing.structure import tapered_materials

REFINEMENT = 0.6
"""At 0.5 the changes that damage makes are 4 % off those of a finer mesh, at 0.4 9 %."""
WARMER = 10.0
"""Temperature of the decks [K]: their results are printed with few digits."""
FORCE = 10.0


class Settings(TypedDict, total=False):
    """Loads beside, or instead of, the wing's own lift, as `write_deck` takes them."""

    lift: FloatArray
    warming: float | FloatArray


@dataclass(frozen=True, eq=False)
class Deck:
    """One run: its name, and what `write_deck` needs."""

    key: str
    wing: Wing
    state: State
    settings: Settings


class CalculixAsset(ShellAsset):
    """The wing as CalculiX sees it."""

    family = "CalculiX"
    outside: ClassVar[tuple[str, ...]] = ("hot_spot", "patchy_gain", "hysteresis")
    states = tuple(STATES[k] for k in (0, 3, 4))
    n_places: ClassVar[Mapping[str, int]] = {
        "payload_inertia": 2,
        "hot_spot": 1,
        "damage_outside_library": 2,
        "spar_skin_debond": 0,
    }

    def __init__(self, seed: int, refinement: float = REFINEMENT, store: Path | None = None, jobs: int = 2) -> None:
        super().__init__(seed, refinement)
        self._strains = self._run(store, jobs)

    def strain(self, state: State) -> FloatArray:
        """Return the strains (n_gauges,) at load factor 1 [microstrain, compressive positive]."""
        return self._strains[_key("lift", state)]

    def field(self, name: str, state: State) -> FloatArray:
        """Return the change of the strains (n_gauges,) per unit of a field."""
        unit = WARMER if forces.is_thermal(name) else FORCE
        return (self._strains[_key(name, state)] - self.strain(state)) / unit

    def softness(self, state: State) -> FloatArray:
        """Return b (n_gauges,) where skins stiffer by the share s have strain / (1 + b s)."""
        return (self.strain(state) / self._strains[_key("stiffer skin", state)] - 1.0) / THICKER

    def flaw(self, flaw: Flaw) -> FloatArray:
        """Return the change of the healthy wing's strains (n_gauges,) by a flaw at load factor 1."""
        return self._strains[_key(flaw.place, STATES[0])] - self.strain(STATES[0])

    def _run(self, store: Path | None, jobs: int) -> dict[str, FloatArray]:
        known: dict[str, list[float]] = json.loads(store.read_text()) if store is not None and store.exists() else {}
        decks = [deck for deck in self._decks() if deck.key not in known]
        with ThreadPoolExecutor(jobs) as pool:
            for deck, strains in zip(decks, pool.map(run_deck, decks), strict=True):
                known[deck.key] = strains[self.columns].tolist()
        if store is not None:
            store.write_text(json.dumps(known))
        return {key: np.array(values) for key, values in known.items()}

    def _decks(self) -> list[Deck]:
        wing, cards = self.wing, tapered_materials()
        thick = tapered_wing(
            refinement=self.refinement, materials=replace(cards, skin_young=cards.skin_young * (1 + THICKER))
        )
        every = dict.fromkeys(
            [*self.states, DAMAGED, *(near for state in self.states[1:] for near in neighbours(state))]
        )
        decks = [Deck(_key("lift", state), wing, state, {}) for state in every]
        decks += [Deck(_key("stiffer skin", state), thick, state, {}) for state in self.states]
        decks += [Deck(_key(f.place, STATES[0]), _patched(wing, f), STATES[0], {}) for f in self.flaws]
        return decks + [
            Deck(_key(name, state), wing, state, self._settings(name))
            for state in self.states
            for name in self.field_names
        ]

    def _settings(self, name: str) -> Settings:
        if not forces.is_thermal(name):
            return {"lift": self.wing.lift + FORCE * forces.force(self.wing, name)}
        warmth = WARMER if name == "temperature_uniform" else WARMER * forces.warming(self.wing, name)
        return {"warming": warmth}


def _key(name: str, state: State) -> str:
    return " ".join([name, *(f"{value:g}" for value in state)])


def run_deck(deck: Deck) -> FloatArray:
    """Return the gauge strains (n_gauges,) that CalculiX finds [microstrain]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wing.inp"
        write_deck(deck.wing, path, dict(zip(PARAMETERS, deck.state, strict=True)), 1.0, **deck.settings)
        ccx.run_deck(path)
        return read_gauges(deck.wing, path.with_suffix(".dat"))


def _patched(wing: Wing, flaw: Flaw) -> Wing:
    structure = wing.structure
    scale = np.where(forces.foreign_patch(wing, flaw.place), 1.0 - 0.01 * flaw.size, 1.0) * structure.shells.scale
    shells = replace(structure.shells, scale=scale)
    return replace(wing, structure=DamagedStructure(shells, structure.supports, structure.components))
