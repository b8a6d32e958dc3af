"""The family of solid skins, few ribs and springs: CalculiX on bricks (`solids`), the lift after Schrenk.

It shares with the twin the public outline, the assumed section and materials, and the places of gauges and regions,
but for some millimetres. What was read differently: the drawn section is the skin's outer side, not its middle; the
skin tapers by its thickness, not by its modulus; 11 ribs, not 13; the tail carries nothing. Two constants were settled
as an engineer would: `SKIN`, a factor on the modulus of the skins, and `TAPER`, the thickness at the tip over that at
the root; 2.3 % per gauge are left. Some fifty runs of `ccx` make a set; their strains at the gauges are kept in a
file beside the keys.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import ClassVar

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from benchmarks.blind.assets.asset import CHORDS, DAMAGED, HOUR, SPANS, STATES, Asset, Flaw, log_uniform, neighbours
from benchmarks.blind.assets.moment import Moment, State
from benchmarks.blind.assets.springs import loads
from benchmarks.blind.assets.springs.deck import Deck, strains
from benchmarks.blind.assets.springs.solids import UPPER, Shape, Solids, solids, without
from femlib.arrays import FloatArray, IntArray

SKIN, TAPER = 1.160, 0.608
REGIONS = ((0.2415, 0.3885, 0.350, 0.545), (0.6715, 0.8285, 0.350, 0.425))
"""Span and chord fractions of the damage that mu1 and mu2 are: two or three millimetres off the study's."""
MISPLACED = 1.5e-3
"""Standard deviation of a gauge's place along and across [m]."""
MICRO = 1e6
REACH = 9.0
"""A gauge's strain is also read so far to both sides of it along the span [mm]."""
FORCE, WARMER, THICKER = 10.0, 10.0, 0.08
BENT_LOADS = (1.5, 3.0)
SETTLING = 30.0
"""Time after which creep goes with the logarithm of time [s]."""
SLACK, SLACK_FROM, SLACK_TO = 2e-3, 0.35, 0.65
"""What is left of the ties of web and upper skin in a slack joint, and where it is."""
HEALTHY = STATES[0]


class SpringsAsset(Asset):
    """The wing as bricks and springs."""

    family = "springs"
    states = tuple(STATES[k] for k in (0, 3, 4))
    n_places: ClassVar[Mapping[str, int]] = {
        "payload_inertia": 3,
        "damage_outside_library": 5,
        "spar_skin_debond": 4,
    }
    outside: ClassVar[tuple[str, ...]] = ("loose_rib", "slack_joint", "lead_wires")

    differs: ClassVar[tuple[float, float]] = (0.01, 0.023)

    def __init__(self, seed: int, store: Path | None = None, jobs: int = 1, refinement: float = 1.0) -> None:
        super().__init__()
        self.shape = Shape(taper=TAPER, refinement=refinement)
        self.wing = self._solids(self.shape)
        rng = np.random.default_rng([seed, 79])
        self._place_gauges(rng)
        self.payloads = [
            f"payload_inertia:{eta:.3f}" for eta in rng.uniform(0.4, 0.95, self.n_places["payload_inertia"])
        ]
        self.lifts = [f"lift_distribution:{kind}" for kind in loads.LIFT_KINDS]
        self.flaws = list(self._flaws(rng))
        self._read = self._run(store, jobs)

    def _place_gauges(self, rng: np.random.Generator) -> None:
        eta = np.concatenate([np.append(np.linspace(0.26, 0.47, n), np.linspace(0.57, 0.755, n)) for n in (8, 4)])
        row = np.repeat([0.21, 0.35], [16, 8])
        used = np.flatnonzero((row < 0.3) | ((eta > 0.39) & (eta < 0.67)))
        self.gauges = tuple(f"g{k + 1:02d}" for k in used)
        self.eta, self.row, self.span = eta[used], row[used], self.shape.span
        off = MISPLACED * rng.standard_normal((2, len(used)))
        self.places = np.stack([self.eta + off[0] / self.span, self.row + off[1] / self.shape.chord(self.eta)], axis=1)

    def _flaws(self, rng: np.random.Generator) -> Iterator[Flaw]:
        for _ in range(self.n_places["damage_outside_library"]):
            place = f"{rng.uniform(0.28, 0.74):.3f}:{rng.choice([0.18, 0.23, 0.41])}"
            yield Flaw("damage_outside_library", place, float(min(90.0, 30.0 * log_uniform(rng))))
        for _ in range(self.n_places["spar_skin_debond"]):
            centre, width = rng.uniform(0.25, 0.75), 0.08 * log_uniform(rng)
            place = f"{rng.choice(['upper', 'lower'])}:{centre - width / 2:.3f}:{centre + width / 2:.3f}"
            yield Flaw("spar_skin_debond", place, 1.0)

    # -- what a family must answer ------------------------------------------------------------------------------------

    def strain(self, state: State) -> FloatArray:
        """Return the strains (n_gauges,) at load factor 1 [microstrain, compressive positive]."""
        return self._at(_key("lift", state))

    def field(self, name: str, state: State) -> FloatArray:
        """Return the change of the strains (n_gauges,) per unit of a field."""
        if name.startswith(("loose_rib", "slack_joint")):
            return self._at(_key(name, HEALTHY)) - self.strain(HEALTHY)
        unit = WARMER if name.startswith("temperature") else FORCE
        return (self._at(_key(name, state)) - self.strain(state)) / unit

    def softness(self, state: State) -> FloatArray:
        """Return b (n_gauges,) where skins thicker by the share s have strain / (1 + b s)."""
        return (self.strain(state) / self._at(_key("thicker skin", state)) - 1.0) / THICKER

    def flaw(self, flaw: Flaw) -> FloatArray:
        """Return the change of the healthy wing's strains (n_gauges,) by a flaw at load factor 1."""
        return self._at(_key(flaw.place, HEALTHY)) - self.strain(HEALTHY)

    def bent(self, load: float) -> FloatArray:
        """Return the relative change of the strains (n_gauges,) by large deflection: a parabola through CalculiX's."""
        changes = [self._at(_key(f"bent {at:g}", HEALTHY)) / (at * self.strain(HEALTHY)) - 1.0 for at in BENT_LOADS]
        first, second = np.linalg.solve([[at, at**2] for at in BENT_LOADS], changes)
        return np.asarray(first * load + second * load**2)

    def built(self) -> FloatArray:
        """Return the relative change of the strains (n_gauges,) by the manufactured planform: solved in it."""
        return self._at(_key("built", HEALTHY)) / self.strain(HEALTHY) - 1.0

    def creep(self, since: FloatArray) -> FloatArray:
        """Return the creep (n,) a time [s] after a load, 1 after an hour: a logarithm of time."""
        return np.asarray(np.log1p(np.maximum(since, 0.0) / SETTLING) / np.log1p(HOUR / SETTLING))

    def turned(self, gauge: int) -> float:
        """Return one less the strain across a gauge over the strain along it."""
        aft, _, here, _ = self._read[_key("lift", HEALTHY)]
        return float(1.0 - aft[gauge] / here[gauge])

    def slid(self, gauge: int, millimetres: float, moment: Moment, before: FloatArray) -> float:
        """Return the change of a mean reading where its gauge sits outboard: a parabola through its neighbourhood."""
        _, inner, here, outer = self._read[_key("lift", moment.state)][:, gauge]
        step = millimetres / REACH
        return float(moment.load * (0.5 * (outer - inner) * step + (0.5 * (outer + inner) - here) * step**2))

    # -- runs ---------------------------------------------------------------------------------------------------------

    def _at(self, key: str) -> FloatArray:
        return np.asarray(self._read[key][2])

    def _run(self, store: Path | None, jobs: int) -> dict[str, FloatArray]:
        known: dict[str, list[list[float]]] = {}
        if store is not None and store.exists():
            known = json.loads(store.read_text())
        missing = {key: make for key, make in self._decks().items() if key not in known}
        with ThreadPoolExecutor(jobs) as pool:
            for key, found in zip(missing, pool.map(lambda make: self._gauged(make()), missing.values()), strict=True):
                known[key] = found.tolist()
                if store is not None:
                    store.write_text(json.dumps(known))
        return {key: np.array(values) for key, values in known.items()}

    def _gauged(self, deck: Deck) -> FloatArray:
        """Return (4, n_gauges) [microstrain, compressive positive]: across; along, inboard of it, there, outboard."""
        aft, along = strains(deck, SKIN)
        axes = (deck.wing.eta, deck.wing.chord_fraction[:UPPER][::-1])
        step = np.array([1e-3 * REACH / self.span, 0.0])
        read = [(aft, 0.0), (along, -1.0), (along, 0.0), (along, 1.0)]
        rows = [RegularGridInterpolator(axes, values[:, ::-1])(self.places + sign * step) for values, sign in read]
        return -MICRO * np.array(rows)

    def _decks(self) -> dict[str, Callable[[], Deck]]:
        """Return every run by its key, made when it is run."""
        near = [other for state in self.states[1:] for other in neighbours(state)]
        (_, root), (_, tip) = CHORDS
        built = replace(self.shape, span=1e-3 * SPANS[1], root_chord=1e-3 * root, tip_chord=1e-3 * tip)
        thick = replace(self.shape, skin=self.shape.skin * (1.0 + THICKER))
        found: dict[str, Callable[[], Deck]] = {_key("built", HEALTHY): partial(self._reshaped, built, HEALTHY)}
        for state in dict.fromkeys([*self.states, DAMAGED, *near]):
            found[_key("lift", state)] = partial(self._deck, state)
        for state in self.states:
            found[_key("thicker skin", state)] = partial(self._reshaped, thick, state)
            for name in self._field_names():
                found[_key(name, state)] = partial(self._loaded, name, state)
        for flaw in self.flaws:
            found[_key(flaw.place, HEALTHY)] = partial(self._flawed, flaw)
        for name in ("loose_rib:0.3", "loose_rib:0.4", "slack_joint"):
            found[_key(name, HEALTHY)] = partial(self._loosened, name)
        for load in BENT_LOADS:
            found[_key(f"bent {load:g}", HEALTHY)] = partial(self._bent, load)
        return found

    def _field_names(self) -> list[str]:
        return ["temperature_uniform", "temperature_gradient", "torsion", *self.lifts, *self.payloads]

    def _solids(self, shape: Shape) -> Solids:
        return solids(shape, [edge for inner, outer, _, _ in REGIONS for edge in (inner, outer)])

    def _deck(self, state: State) -> Deck:
        force = loads.lift(self.wing, self.shape)
        return Deck(self.wing, self._stiffness(state), force, np.zeros(len(force)))

    def _stiffness(self, state: State) -> FloatArray:
        stiff = np.ones(len(self.wing.bricks))
        for mu, region in zip(state, REGIONS, strict=True):
            stiff[self._bricks(*region)] *= 1.0 - mu
        return stiff

    def _bricks(self, inner: float, outer: float, fore: float, aft: float) -> IntArray:
        """Return the bricks (n,) of the upper skin in a rectangle of span and chord fractions."""
        eta, x = self.wing.eta, self.wing.chord_fraction[:UPPER]
        inside = np.outer((inner < eta) & (eta < outer), (fore < x) & (x < aft))
        return self.wing.grid[:, :UPPER][inside]

    def _reshaped(self, shape: Shape, state: State) -> Deck:
        return replace(self._deck(state), wing=self._solids(shape))

    def _loaded(self, name: str, state: State) -> Deck:
        deck = self._deck(state)
        if name.startswith("temperature"):
            return replace(deck, warm=WARMER * loads.warming(self.wing, name))
        return replace(deck, force=deck.force + FORCE * loads.force(self.wing, self.shape, name))

    def _bent(self, load: float) -> Deck:
        deck = self._deck(HEALTHY)
        return replace(deck, force=load * deck.force, is_bent=True)

    def _flawed(self, flaw: Flaw) -> Deck:
        deck = self._deck(HEALTHY)
        words = flaw.place.split(":")
        if flaw.name == "spar_skin_debond":
            at, of = self.wing.tie_eta, np.array(self.wing.tie_of) == words[0]
            return replace(deck, wing=without(self.wing, of & (float(words[1]) < at) & (at < float(words[2]))))
        eta, x = float(words[0]), float(words[1])
        stiff = deck.stiff.copy()
        stiff[self._bricks(eta - 0.04, eta + 0.04, x - 0.14, x + 0.14)] *= 1.0 - 0.01 * flaw.size
        return replace(deck, stiff=stiff)

    def _loosened(self, name: str) -> Deck:
        at, of = self.wing.tie_eta, np.array(self.wing.tie_of)
        kind, _, eta = name.partition(":")
        if kind == "loose_rib":
            soft = (of == "rib") & (np.abs(at - float(eta)) < 1e-6)
        else:
            soft = (of == "upper") & (at > SLACK_FROM) & (at < SLACK_TO)
        return replace(self._deck(HEALTHY), soft=dict.fromkeys(np.flatnonzero(soft).tolist(), SLACK))


def _key(name: str, state: State) -> str:
    return " ".join([name, *(f"{value:g}" for value in state)])
