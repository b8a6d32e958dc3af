"""The family written from scratch: the wing as strips (`strips`) under a lifting line, every effect solved in it.

It shares with the twin the public outline, the assumed section and materials, and the places of gauges and regions.
Two constants were settled as an engineer would, once, against the strains that the study's wing is known to have:
`SKIN`, a factor on the modulus of the skins, and `TAPER`, which together leave 1.5 % per gauge.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.sparse.linalg import SuperLU

from benchmarks.blind.assets.asset import CHORDS, HOUR, LENGTH, SPANS, Asset, Flaw, log_uniform
from benchmarks.blind.assets.beam.lift import AFT, LIFT_KINDS, other_lift, own_lift
from benchmarks.blind.assets.beam.section import BOTTOM, INNER, TOP, airfoil
from benchmarks.blind.assets.beam.strips import Card, Strips
from benchmarks.blind.assets.moment import Moment, State
from femlib.arrays import FloatArray

SKIN, TAPER = 1.240, 0.411
REGIONS = ((0.24, 0.39, 0.345, 0.55), (0.67, 0.83, 0.345, 0.43))
"""Span and chord fractions of the damage that mu1 and mu2 are: the study's."""
N_STATIONS = 121
EDGE = 0.005
"""Stations lie so far on both sides of a region's edge, where the strain has a corner."""
MICRO = 1e6
THICKER = 0.08
SKIN_EXPANSION, WEB_EXPANSION = 2.0e-6, 5.0e-6
GRAVITY = 9.80665
QUICK, SLOW = 120.0, 1800.0
"""Retardation times of two Kelvin elements [s] that creep alike."""
SWELLING = 20e-6
"""Strain by which the skin swells at the tip in an hour."""
CABLE = 2.0
"""Pull of a cable at the tip's trailing edge [N]."""


@dataclass(frozen=True, eq=False)
class Answers:
    """What one state answers: strains (n_gauges,) by name, and the displacements under the lift."""

    strains: Mapping[str, FloatArray]
    moved: FloatArray


class BeamAsset(Asset):
    """The wing as thin-walled strips."""

    family = "beam"
    n_places: ClassVar[Mapping[str, int]] = {
        "payload_inertia": 8,
        "damage_outside_library": 10,
        "spar_skin_debond": 8,
    }
    outside: ClassVar[tuple[str, ...]] = ("buckled_panel", "tip_cable", "moist_skin")

    differs: ClassVar[tuple[float, float]] = (0.01, 0.014)

    def __init__(self, seed: int, n_stations: int = N_STATIONS) -> None:
        super().__init__()
        card = Card()
        self.card = replace(card, skin=(SKIN * card.skin[0], card.skin[1]), taper=TAPER)
        self.section = airfoil()
        self.strips = Strips(self.section, self.card, _stations(n_stations))
        self._place_gauges()
        rng = np.random.default_rng([seed, 78])
        payloads = rng.uniform(0.4, 0.95, self.n_places["payload_inertia"])
        self.payloads = [f"payload_inertia:{eta:.3f}" for eta in payloads]
        self.lifts = [f"lift_distribution:{kind}" for kind in LIFT_KINDS]
        self.flaws = list(self._flaws(rng))

    def _place_gauges(self) -> None:
        spans = [np.concatenate([np.linspace(0.26, 0.47, n), np.linspace(0.57, 0.755, n)]) for n in (8, 4)]
        eta, row = np.concatenate(spans), np.repeat([0.21, 0.35], [16, 8])
        inside = [(a < eta) & (eta < b) & (c < row) & (row < d) for a, b, c, d in REGIONS]
        used = np.flatnonzero(~np.any(inside, axis=0))
        self.gauges = tuple(f"g{k + 1:02d}" for k in used)
        self.eta, self.row, self.span = eta[used], row[used], self.card.span
        upper = np.flatnonzero(self.section.z >= 0.0)
        gap = np.abs(self.section.x[upper] + 0.30 - self.row[:, None])
        self.boom = upper[gap.argmin(axis=1)]

    def _flaws(self, rng: np.random.Generator) -> Iterator[Flaw]:
        for _ in range(self.n_places["damage_outside_library"]):
            place = f"{rng.uniform(0.28, 0.74):.3f}:{rng.uniform(0.15, 0.6):.3f}:{rng.uniform(0.04, 0.07):.3f}"
            yield Flaw("damage_outside_library", place, float(min(90.0, 25.0 * log_uniform(rng))))
        for _ in range(self.n_places["spar_skin_debond"]):
            centre, width = rng.uniform(0.25, 0.75), LENGTH * log_uniform(rng)
            place = f"{rng.choice(['upper', 'lower'])}:{centre - width / 2:.3f}:{centre + width / 2:.3f}"
            yield Flaw("spar_skin_debond", place, 1.0)

    # -- what a family must answer ------------------------------------------------------------------------------------

    def strain(self, state: State) -> FloatArray:
        """Return the strains (n_gauges,) at load factor 1 [microstrain, compressive positive]."""
        return self._answers(state).strains["lift"]

    def field(self, name: str, state: State) -> FloatArray:
        """Return the change of the strains (n_gauges,) per unit of a field."""
        return self._answers(state).strains[name]

    def softness(self, state: State) -> FloatArray:
        """Return b (n_gauges,) where skins stiffer by the share s have strain / (1 + b s), near s = 0."""
        return np.asarray((self.stiffer(-0.001, state) - self.stiffer(0.001, state)) / 0.002)

    def flaw(self, flaw: Flaw) -> FloatArray:
        """Return the change of the healthy wing's strains (n_gauges,) by a flaw at load factor 1: solved again."""
        return self.kept(flaw, lambda: self._flawed(flaw))

    def bent(self, load: float) -> FloatArray:
        """Return the relative change of the strains (n_gauges,) by large deflection: shorter arms of the bent beam.

        The lift stays vertical; a station lies at the integral of cos(slope) and no longer at its distance on the wing.
        """
        along = self.strips.eta * self.span
        slope = np.gradient(load * self._answers((0.0, 0.0)).moved[:, -2], along)
        inward = np.concatenate([[0.0], np.cumsum(0.5 * (np.cos(slope[1:]) + np.cos(slope[:-1])) * np.diff(along))])
        force = self.kept("own lift", lambda: own_lift(self.card, self.strips.eta))
        straight, bent = (
            np.maximum(place - np.interp(self.eta, self.strips.eta, place)[:, None], 0.0) @ force
            for place in (along, inward)
        )
        return np.asarray(bent / straight - 1.0)

    def stiffer(self, share: float, state: State) -> FloatArray:
        """Return the strains (n_gauges,) over the wing's own: a parabola through three solutions."""
        less, more = self.kept(
            ("stiffer", state), lambda: tuple(self._stiffened(s, state) for s in (-THICKER, THICKER))
        )
        s = share / THICKER
        return np.asarray(1.0 + 0.5 * (more - less) * s + (0.5 * (more + less) - 1.0) * s**2)

    def built(self) -> FloatArray:
        """Return the relative change of the strains (n_gauges,) by the manufactured planform: solved in it."""
        return self.kept("built", self._built)

    def creep(self, since: FloatArray) -> FloatArray:
        """Return the creep (n,) a time [s] after a load, 1 after an hour: two Kelvin elements."""

        def course(t: FloatArray) -> FloatArray:
            return 1.0 - 0.5 * (np.exp(-t / QUICK) + np.exp(-t / SLOW))

        return np.asarray(course(np.maximum(since, 0.0)) / course(np.array(HOUR)))

    def turned(self, gauge: int) -> float:
        """Return one and Poisson's ratio: the skin is free to contract between the ribs."""
        return 1.0 + self.card.skin_poisson

    def slid(self, gauge: int, millimetres: float, moment: Moment, before: FloatArray) -> float:
        """Return the change of a mean reading where its gauge sits outboard: the strain of the same boom there."""
        moved = self._answers(moment.state).moved
        places = self.eta[gauge] + np.array([0.0, 1e-3 * millimetres / self.span])
        here, there = self.strips.strain(moved, places, self.boom[[gauge, gauge]])
        return float(-MICRO * moment.load * (there - here))

    # -- solutions ----------------------------------------------------------------------------------------------------

    def _answers(self, state: State) -> Answers:
        return self.kept(("state", state), lambda: self._solved(state))

    def _solved(self, state: State) -> Answers:
        stiff = self._stiffness(state)
        factors = self.strips.factors(stiff)
        moved = self.strips.moved(factors, self._lift())
        strains = {name: self._read(factors, self._force(name, stiff)) for name in self._names()}
        return Answers({"lift": self._gauges(moved), **strains}, moved)

    def _names(self) -> list[str]:
        plain = ["temperature_uniform", "temperature_gradient", "torsion", "tip_cable", "moist_skin"]
        return [*plain, *self.lifts, *self.payloads]

    def _read(self, factors: SuperLU, force: FloatArray) -> FloatArray:
        return self._gauges(self.strips.moved(factors, force))

    def _gauges(self, moved: FloatArray) -> FloatArray:
        return -MICRO * self.strips.strain(moved, self.eta, self.boom)

    def _lift(self) -> FloatArray:
        return self._aft(own_lift(self.card, self.strips.eta), AFT)

    def _aft(self, force: FloatArray, chords: float) -> FloatArray:
        return self.strips.lift(force, chords * self.card.chord(self.strips.eta))

    def _stiffness(self, state: State) -> FloatArray:
        """Return the factors of the elements (n_bays, n_edges) in a state."""
        stiff = np.ones((len(self.strips.middle), len(self.section.ends)))
        middle, s = self.strips.middle, self.section
        for mu, (inner, outer, fore, aft) in zip(state, REGIONS, strict=True):
            edges = (s.part == TOP) & (fore < s.chord_fraction) & (s.chord_fraction < aft)
            stiff[np.outer((inner < middle) & (middle < outer), edges)] *= 1.0 - mu
        return stiff

    def _force(self, name: str, stiff: FloatArray) -> FloatArray:
        kind, _, place = name.partition(":")
        if kind in ("temperature_uniform", "temperature_gradient", "moist_skin"):
            return self.strips.heat(self._swelling(kind), stiff)
        eta = self.strips.eta
        if kind == "lift_distribution":
            return self._aft(other_lift(self.card, eta, place), AFT)
        if kind == "torsion":
            turn = self._aft(own_lift(self.card, eta), 0.01)
            turn[:, -2] = 0.0
            return turn
        if kind == "payload_inertia":
            at = float(place)
            return self._aft(-GRAVITY * np.interp(eta, [at - 0.02, at, at + 0.02], [0, 1, 0]) / self._hats(at), 0.0)
        return self._aft(CABLE * (eta == 1.0), 1.0 - 0.30)

    def _hats(self, at: float) -> float:
        return float(np.interp(self.strips.eta, [at - 0.02, at, at + 0.02], [0, 1, 0]).sum())

    def _swelling(self, kind: str) -> FloatArray:
        """Return free strains (n_bays, n_edges) per unit: of a kelvin, of a kelvin between the skins, of an hour."""
        part, along = self.section.part, self.strips.middle[:, None]
        if kind == "temperature_uniform":
            return np.where(part == INNER, WEB_EXPANSION, SKIN_EXPANSION) + 0.0 * along
        if kind == "temperature_gradient":
            return SKIN_EXPANSION * np.select([part == TOP, part == BOTTOM], [0.5, -0.5], 0.0) + 0.0 * along
        return np.where(part == TOP, SWELLING, 0.0) * along

    def _stiffened(self, share: float, state: State) -> FloatArray:
        stiff = self._stiffness(state) * np.where(self.section.part == INNER, 1.0, 1.0 + share)
        return self._read(self.strips.factors(stiff), self._lift()) / self.strain(state)

    def _built(self) -> FloatArray:
        (_, root), (_, tip) = CHORDS
        card = replace(self.card, span=1e-3 * SPANS[1], root_chord=1e-3 * root, tip_chord=1e-3 * tip)
        other = Strips(self.section, card, self.strips.eta)
        moved = other.moved(other.factors(self._stiffness((0.0, 0.0))), self._lift())
        return -MICRO * other.strain(moved, self.eta, self.boom) / self.strain((0.0, 0.0)) - 1.0

    def _flawed(self, flaw: Flaw) -> FloatArray:
        stiff = self._stiffness((0.0, 0.0))
        shear = stiff.copy()
        if flaw.name == "spar_skin_debond":
            flange, inner, outer = flaw.place.split(":")
            web = np.flatnonzero(self.section.part == INNER)[0 if flange == "upper" else 1]
            middle = self.strips.middle
            shear[(float(inner) < middle) & (middle < float(outer)), web] = 1e-6
        else:
            stiff = stiff * (1.0 - 0.01 * flaw.size * self._patch(flaw.place))
            shear = stiff
        return self._read(self.strips.factors(stiff, shear), self._lift()) - self.strain((0.0, 0.0))

    def _patch(self, place: str) -> FloatArray:
        """Return how much (n_bays, n_edges) of a foreign damage each element has: full inside, soft at the rim."""
        eta, aft, reach = (float(part) for part in place.split(":"))
        along = (self.strips.middle[:, None] - eta) / reach
        across = (self.section.chord_fraction - aft) / 0.18
        return np.where(self.section.part == TOP, np.exp(-((along**2 + across**2) ** 2)), 0.0)


def _stations(n: int) -> FloatArray:
    """Return the span fractions of the stations: close to the edges of the regions, with no slivers."""
    edges = np.array([edge for inner, outer, _, _ in REGIONS for edge in (inner, outer)])
    close = np.concatenate([edges, edges - EDGE, edges + EDGE])
    plain = np.linspace(0.0, 1.0, n)
    clear = np.abs(plain[:, None] - close).min(axis=1) > 0.4 * EDGE
    return np.unique(np.round(np.concatenate([plain[clear], close]), 9))
