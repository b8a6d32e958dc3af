"""The diagnosis of a flight: what may have been changed, by the sound flights of the same airframe."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real.answer import Answer
from benchmarks.real.by_diagnosis import COUNT, UNKNOWN, Named, asked, said
from benchmarks.real.quadrotor.flight import WITHIN, Flight, read_flights
from benchmarks.real.quadrotor.hover import NO_LOAD, PAIRS, ROTORS, SIDES, hover_twin
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, Odds

GRAMS = {"W1": 0.5, "W2": 1.2, "W3": 1.9}
"""The weights of practice [g], which are not told: the thrust that they took."""
PRIORS = {
    "blade_cut": 0.25, "weight_near_rotor": 0.17, "weight_on_string": 0.12, "tape_on_blade": 0.06, "blade_bent": 0.004,
    "motor_weak": 0.002, "arm_bent": 0.002, "centre_of_mass_shift": 0.004, "payload_centre": 0.004,
}  # fmt: skip
"""Probability of each kind before any reading, all places together."""
BETWEEN_TWO = 0.03
"""Probability of one weight between two rotors."""
OFTEN, AGAIN = 1.0, 4.0
"""What a place counts before practice, each told cause there counting one more; by how much more often than before, in
units of its prior, a cause acts for each practice flight that had it."""
Causes = frozenset[tuple[str, str]]


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What commissioning and practice teach of one airframe.

    Attributes
    ----------
    twin
        in hover.
    tests
        (n_readings,) of each sound flight, and of each practice flight less what was done to it.
    odds
        of each cause.
    """

    twin: FunctionTwin
    tests: tuple[FloatArray, ...]
    odds: Odds


def told_causes(condition: str, detail: str) -> list[tuple[str, str, float]]:
    """Return kind, place and size of every cause of a practice flight."""
    found = []
    for cause, words in zip(condition.split("; "), detail.split("; "), strict=True):
        kind, place = cause.split(" at ")
        millimetres = [float(number) for number in re.findall(r"([\d.]+) mm", words)]
        weight = re.search(r"W\d", words)
        found.append((kind, place, sum(millimetres) or (GRAMS[weight[0]] if weight else 1.0)))
    return found


def practice_of(folder: Path) -> dict[str, list[tuple[str, str, float]]]:
    """Return the causes of every practice flight by name."""
    rows = pd.read_csv(folder / "practice.csv").itertuples()
    return {str(row.flight): told_causes(str(row.condition), str(row.detail)) for row in rows}


def learn(folder: Path, flights: Mapping[str, Flight], airframe: str, without: str = "") -> Knowledge:
    """Return what is known of an airframe, one flight left out."""
    twin = hover_twin()
    own = [one for one in flights.values() if one.airframe == airframe and one.name != without]
    tests = [one.readings for one in own if one.role == "commissioning"]
    places, seen = dict.fromkeys(ROTORS, OFTEN), dict[Causes, float]()
    practice = practice_of(folder)
    for one in own:
        if one.name not in practice:
            continue
        causes = practice[one.name]
        done = {f"{kind} {place}": size for kind, place, size in causes}
        tests.append(one.readings - (twin.ask({}, NO_LOAD, done) - twin.ask({}, NO_LOAD, {})))
        acted = frozenset((kind, place) for kind, place, _ in causes)
        seen[acted] = seen.get(acted, 0.0) + AGAIN
        for rotor in (rotor for _, place in acted for rotor in place.split("+")):
            places[rotor] += 1.0
    shares = shares_of(places, seen)
    usual = float(np.mean(list(shares.values())))
    odds = Odds(COUNT, UNKNOWN, effects={effect: share / usual for effect, share in shares.items()})
    return Knowledge(twin, tuple(tests), odds)


def shares_of(places: Mapping[str, float], seen: Mapping[Causes, float]) -> dict[str, float]:
    """Return the probability of each parameter of the twin before any reading."""
    total = sum(places.values())
    by_rotor = {rotor: count / total for rotor, count in places.items()}
    others = {"centre_of_mass_shift": dict.fromkeys(SIDES, 0.25), "payload_centre": {"centre": 1.0}}
    found = {
        (kind, place): prior * share
        for kind, prior in PRIORS.items()
        for place, share in others.get(kind, by_rotor).items()
    }
    pairs = {pair: by_rotor[pair[0]] * by_rotor[pair[1]] for pair in PAIRS}
    between = BETWEEN_TWO / sum(pairs.values())
    found |= {("weight_near_rotor", "+".join(pair)): between * share for pair, share in pairs.items()}
    return {" ".join(cause): share * (1.0 + seen.get(frozenset([cause]), 0.0)) for cause, share in found.items()}


def answer(flight: Flight, known: Knowledge) -> Answer:
    """Return what a flight says."""
    ranges = known.twin.card.ranges

    def named(effect: str) -> Named:
        kind, _, place = effect.partition(" ")
        return Named(kind, place, ranges[effect].unit)

    found = asked(flight.readings, known.tests, known.twin, list(WITHIN.values()), known.odds)
    return Answer(flight.name, said(found, named), None)


def answers(folder: Path) -> list[Answer]:
    """Return the answer of every blind flight."""
    flights = read_flights(folder)
    known = {airframe: learn(folder, flights, airframe) for airframe in sorted({f.airframe for f in flights.values()})}
    return [answer(flight, known[flight.airframe]) for flight in flights.values() if flight.role == "blind"]
