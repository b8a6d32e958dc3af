"""The diagnosis of a flight: what may have been changed, weighed against sound flights of the same airframe."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.real.answer import Answer
from benchmarks.real.evidence import Hypothesis, Judged, Named, judge
from benchmarks.real.quadrotor.flight import READINGS, Flight, read_flights
from benchmarks.real.quadrotor.hover import NO_LOAD, PAIRS, ROTORS, SIDES, hover_twin
from benchmarks.real.quadrotor.normal import WITHIN, Told, references, usual_shaking
from femlib.arrays import FloatArray
from octmip.gap.doors.function import FunctionTwin

N_STEADY = len(WITHIN)
GRAMS = {"W1": 0.5, "W2": 1.2, "W3": 1.9}
"""The weights of practice [g], which are not told: the thrust that they took."""
HEADING = 0.12
"""Standard deviation by which a disturbed flight's yaw commands of both ways differ beside what the twin says [g]."""
SHARPNESS = 1.2
"""Power of probabilities for sets: at 1.2 the sets of all 22 told flights, each left out, hold the truth; at 1.4 21."""
UNKNOWN = Named("unknown", "", "")
SAME_AIRFRAME, OTHER_AIRFRAME = 1.0, 0.4
"""What a practice flight says of how a kind shakes, over what was expected before."""
TOLD_ERROR = 0.3
"""Relative error of what a told cause changes."""


@dataclass(frozen=True, slots=True)
class Kind:
    """What is expected of a kind before any reading.

    Attributes
    ----------
    unit, mean, sd
        of its size.
    prior
        probability, all places together.
    error
        relative error of what it changes of the steady commands.
    step, shake
        (mean, standard deviation) by which it raises the logarithms of the steps of commands and of what shakes.
    tie
        standard deviation by which it changes how channels go together.
    """

    unit: str
    mean: float
    sd: float
    prior: float
    error: float
    step: tuple[float, float]
    shake: tuple[float, float]
    tie: float = 0.2


SOUND_PRIOR, UNKNOWN_PRIOR, UNKNOWN_SD = 0.08, 0.015, 0.5
KINDS: Mapping[str, Kind] = {
    "blade_cut": Kind("mm", 3.5, 2.5, 0.25, 0.3, (0.35, 0.5), (0.1, 0.4), 0.3),
    "weight_near_rotor": Kind("g", 1.2, 1.0, 0.17, 0.35, (0.3, 0.45), (-0.1, 0.25), 0.1),
    "weight_on_string": Kind("g", 1.5, 0.9, 0.12, 0.5, (0.2, 0.4), (0.15, 0.3), 0.1),
    "tape_on_blade": Kind("-", 1.0, 0.6, 0.06, 0.4, (-0.3, 0.5), (0.3, 0.3), 0.3),
    "blade_bent": Kind("-", 1.0, 0.6, 0.004, 0.4, (0.35, 0.5), (0.3, 0.4)),
    "motor_weak": Kind("%", 6.0, 5.0, 0.002, 0.2, (0.0, 0.2), (0.0, 0.1), 0.1),
    "arm_bent": Kind("deg", 0.0, 1.0, 0.002, 0.2, (0.0, 0.2), (0.0, 0.1), 0.1),
    "centre_of_mass_shift": Kind("mm", 1.0, 1.0, 0.004, 0.2, (0.0, 0.3), (0.0, 0.2), 0.1),
    "payload_centre": Kind("g", 1.5, 1.5, 0.004, 0.2, (0.0, 0.3), (0.0, 0.2), 0.1),
}
ON_TWO_ROTORS = {"blade_cut": 0.15, "tape_on_blade": 0.07}
"""Probability that two rotors have one each."""
BETWEEN_TWO = 0.03
"""Probability of one weight between two rotors."""
OFTEN, AGAIN = 1.0, 4.0
"""What a place counts before practice, each told cause there counting one more; by how much more often than before, in
units of its prior, a combination acts for each practice flight that had it."""


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What commissioning and practice teach of one airframe: sound flights, told ones as sound, places and causes."""

    twin: FunctionTwin
    sound: tuple[Flight, ...]
    told: tuple[Told, ...]
    places: Mapping[str, float]
    seen: Mapping[frozenset[tuple[str, str]], float]
    shaking: Mapping[str, FloatArray]


def told_causes(condition: str, detail: str) -> list[tuple[str, str, float]]:
    """Return kind, place and size of every cause of a practice flight."""
    found = []
    for cause, words in zip(condition.split("; "), detail.split("; "), strict=True):
        kind, place = cause.split(" at ")
        millimetres = [float(number) for number in re.findall(r"([\d.]+) mm", words)]
        weight = re.search(r"W\d", words)
        found.append((kind, place, sum(millimetres) or (GRAMS[weight[0]] if weight else 1.0)))
    return found


def learn(folder: Path, flights: Mapping[str, Flight], airframe: str, without: str = "") -> Knowledge:
    """Return what is known of an airframe, one flight left out."""
    twin = hover_twin()
    known = {
        own: [f for f in flights.values() if (f.airframe, f.role) == (own, "commissioning") and f.name != without]
        for own in {f.airframe for f in flights.values()}
    }
    practice = [told_flight(twin, flights, row) for row in pd.read_csv(folder / "practice.csv").itertuples()]
    practice = [one for one in practice if one.flight.name != without]
    told = [one for one in practice if one.flight.airframe == airframe]
    places, seen = dict.fromkeys(ROTORS, OFTEN), dict[frozenset[tuple[str, str]], float]()
    for one in told:
        seen[one.causes] = seen.get(one.causes, 0.0) + AGAIN
        for rotor in (rotor for _, place in one.causes for rotor in place.split("+")):
            places[rotor] += 1.0
    total = sum(places.values())
    shaking = {kind: _shaking(kind, airframe, practice, known) for kind in KINDS}
    return Knowledge(
        twin,
        tuple(known[airframe]),
        tuple(told),
        {rotor: count / total for rotor, count in places.items()},
        seen,
        shaking,
    )


def told_flight(twin: FunctionTwin, flights: Mapping[str, Flight], row: Any) -> Told:
    """Return a practice flight as if it were sound."""
    flight, causes = flights[str(row.flight)], told_causes(str(row.condition), str(row.detail))
    changes = [change_of(twin, (f"{kind} {place}",), np.array([size]))[:N_STEADY] for kind, place, size in causes]
    doubt = TOLD_ERROR * np.sqrt(np.sum(np.square(changes), axis=0))
    acted = frozenset((kind, place) for kind, place, _ in causes)
    return Told(flight, flight.readings[:N_STEADY] - np.sum(changes, axis=0), doubt, acted)


def _shaking(name: str, airframe: str, practice: Sequence[Told], sound: Mapping[str, Sequence[Flight]]) -> FloatArray:
    """Return by how much a kind raises what shakes (n_readings,): expected beforehand, and seen in practice flights."""
    kind, groups = KINDS[name], [reading.split("_")[0] for reading in READINGS]
    expected = {"step": kind.step[0], "shake": kind.shake[0]}
    total = np.array([expected.get(group, 0.0) if k >= N_STEADY else 0.0 for k, group in enumerate(groups)])
    weight = np.ones(len(READINGS))
    for one in practice:
        if name not in {acted for acted, _ in one.causes}:
            continue
        share = SAME_AIRFRAME if one.flight.airframe == airframe else OTHER_AIRFRAME
        shift = one.flight.readings - usual_shaking(one.flight, sound[one.flight.airframe])
        shown = np.isfinite(shift) & (np.arange(len(READINGS)) >= N_STEADY)
        total[shown] += share * shift[shown]
        weight[shown] += share
    return total / weight


def change_of(twin: FunctionTwin, names: Sequence[str], sizes: FloatArray) -> FloatArray:
    """Return what parameters change of all readings (n_readings,): the twin says nothing of what shakes."""
    asked = dict(zip(names, sizes.tolist(), strict=True))
    found = np.zeros(len(READINGS))
    found[:N_STEADY] = twin.ask({}, NO_LOAD, asked) - twin.ask({}, NO_LOAD, {})
    return found


def hypotheses(known: Knowledge) -> list[Hypothesis]:
    """Return no cause, each cause alone, cuts and tapes on two rotors, one weight between two, something unknown."""
    nothing, none = np.zeros(len(READINGS)), np.zeros(0)
    found = [Hypothesis((), lambda _: nothing, none, none, SOUND_PRIOR, 0.0, nothing, nothing)]
    for name, kind in KINDS.items():
        places: Mapping[str, float] = known.places
        if name == "centre_of_mass_shift":
            places = dict.fromkeys(SIDES, 0.25)
        elif name == "payload_centre":
            places = {"centre": 1.0}
        found += [_hypothesis(known, [(name, place)], kind.prior * share) for place, share in places.items()]
    shares = {pair: known.places[pair[0]] * known.places[pair[1]] for pair in PAIRS}
    total = sum(shares.values())
    for (one, other), share in shares.items():
        found.append(_hypothesis(known, [("weight_near_rotor", f"{one}+{other}")], BETWEEN_TWO * share / total))
        for name, prior in ON_TWO_ROTORS.items():
            found.append(_hypothesis(known, [(name, one), (name, other)], prior * share / total))
    spread = np.array([UNKNOWN_SD] * N_STEADY)
    wide = np.concatenate([np.zeros(N_STEADY), np.full(len(READINGS) - N_STEADY, 0.6)])
    free = Hypothesis(
        (UNKNOWN,), lambda s: np.concatenate([s, nothing[N_STEADY:]]), np.zeros(N_STEADY), spread,
        UNKNOWN_PRIOR, 0.0, nothing, wide, is_signed=True,
    )  # fmt: skip
    return [*found, free]


def _hypothesis(known: Knowledge, causes: Sequence[tuple[str, str]], prior: float) -> Hypothesis:
    kind_name = causes[0][0]
    kind = KINDS[kind_name]
    columns = np.array([change_of(known.twin, (f"{name} {place}",), np.ones(1)) for name, place in causes])
    groups = [reading.split("_")[0] if k >= N_STEADY else "" for k, reading in enumerate(READINGS)]
    sd = {"step": kind.step[1], "shake": kind.shake[1], "tie": kind.tie}
    heading = np.where(np.array(READINGS) == "yaw_way", HEADING, 0.0)
    often = 1.0 + known.seen.get(frozenset(causes), 0.0)
    return Hypothesis(
        tuple(Named(name, place, kind.unit) for name, place in causes),
        lambda sizes: sizes @ columns,  # the twin is linear
        mean=np.full(len(causes), kind.mean),
        sd=np.full(len(causes), kind.sd),
        prior=prior * often,
        error=kind.error,
        extra_mean=known.shaking[kind_name],
        extra_sd=np.array([sd.get(group, 0.0) for group in groups]) + heading,
        is_signed=kind.mean == 0.0,
    )


def answer(flight: Flight, known: Knowledge) -> Answer:
    """Return what a flight says; the way out sizes the first cause, the way back says how far it closes the gap."""
    seen = references(flight, known.sound, known.told)
    judged = judge(flight.readings, seen, hypotheses(known))
    note = "closed: steady commands of the way back"
    return Answer(flight.name, tuple(judged), _closed(flight, judged[0], known), note, SHARPNESS)


def _closed(flight: Flight, first: Judged, known: Knowledge) -> float | None:
    """Return the share of the square of the gap of the way back that the first cause, sized on the way out, closes.

    None where nothing acts, and for a weight on a thread: it shows by how both ways differ, so neither can be held out.
    """
    if first.hypothesis.causes in {(), (UNKNOWN,)} or first.hypothesis.causes[0].kind == "weight_on_string":
        return None
    ways = [np.mean([getattr(one, way) for one in known.sound], axis=0) for way in ("out", "back")]
    drift = ways[1] - ways[0]
    moved = flight.readings.copy()
    moved[: len(flight.out)] = flight.out + drift / 2.0
    alone = judge(moved, references(flight, known.sound, known.told), [first.hypothesis])[0]
    change = first.hypothesis.change(alone.sizes[:, 0])[: len(flight.out)]
    base = references(flight, known.sound, known.told)[alone.reference].readings[: len(flight.out)]
    gap = flight.back - drift / 2.0 - base
    return max(0.0, 1.0 - float(np.sum((gap - change) ** 2) / np.sum(gap**2)))


def answers(folder: Path) -> list[Answer]:
    """Return the answer of every blind flight."""
    flights = read_flights(folder)
    known = {airframe: learn(folder, flights, airframe) for airframe in sorted({f.airframe for f in flights.values()})}
    return [answer(flight, known[flight.airframe]) for flight in flights.values() if flight.role == "blind"]
