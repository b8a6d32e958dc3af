"""Two quadrotors: what may have been changed on an airframe, by the flights of it that are known to be sound.

`python -m benchmarks.real.quadrotor --data FOLDER` judges each flight whose truth is told without itself. Readings are
the steady commands of the hovers, how the yaw command differs between both ways, and how commands and sensors shake.

    thrust, roll, pitch, yaw:    f = f_0 + weight / 4 (1, y, x, 0) + ...,    c_i = f_i (1 + loss_i) + blocked_i

Lengths are in units of the arm along x or y; commands are in grams of one rotor. A weight at a rotor lies under its
blades: it blocks the flow (loss of thrust) and takes its swirl, so that the other rotors have to turn against it.
"""

import argparse
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.real.beam import Causes, folder_asked, shares_of, summary
from femlib.arrays import FloatArray
from octmip.gap import Diagnosis, FunctionTwin, Odds, Recorded, diagnose, function_twin, gathered
from octmip.twin import Loads

NO_LOAD = Loads((), ())
GRAMS = 15.0 / 65536.0
"""Nominal thrust of one rotor by its command [g]."""
AXES = ("thrust", "roll", "pitch", "yaw")
STEADY = (*AXES, "yaw_way")
SHAKEN = {"A": ("ax", "ay", "az"), "B": ("gyro_roll", "gyro_pitch", "gyro_yaw", "acc_z")}
"""Channels of both logs that shake."""
HEIGHT, SETTLE, LEAVE, HALFWAY = 0.42, 0.4, 0.15, 14.5
"""Least height of the hover [m]; cut off its beginning and end [s]; time between the two hovers [s]."""
OUT, BACK = (6.2, 9.2), (20.1, 23.1)
"""Stretches in which the flight moves along x, forward and back [s]."""
WITHIN, STEP_SD, SHAKE_SD = (0.07, 0.07, 0.07, 0.08, 0.16), 0.8, 0.6
"""Standard deviation of each steady reading [g], and of the logarithms of what shakes: neighbours tell much the same,
and a flight that was changed differs between both ways by more than a sound one."""
PATTERNS = {
    "M1": np.array([1.0, -1.0, 1.0, 1.0]), "M2": np.array([1.0, -1.0, -1.0, -1.0]),
    "M3": np.array([1.0, 1.0, -1.0, 1.0]), "M4": np.array([1.0, 1.0, 1.0, -1.0]),
}  # fmt: skip
"""What one more gram from a rotor is in four times thrust, roll, pitch and yaw."""
PAIRS = tuple(combinations(PATTERNS, 2))
SIDES = {"M3+M4": (0, 1, 0, 0), "M1+M2": (0, -1, 0, 0), "M1+M4": (0, 0, 1, 0), "M2+M3": (0, 0, -1, 0)}
ARM, HOVER = 32.5, 9.3
"""Place of a rotor along x and y [mm]; thrust of one rotor in hover [g]."""
CUT, TAPE, TILT = 0.032, 0.05, 0.3
"""Thrust that a rotor loses by a millimetre cut off, and by a piece of tape, relative; yaw command of a degree [g]."""
BLOCKED, SWIRL = 0.5, 1.0
"""Thrust that a gram under the blades costs, and swirl that it takes, both in grams of that rotor."""
DRAGGED, LIFTED = 0.45, 0.2
"""A weight on a thread longer than the flight is high is dragged along: difference of the yaw command between both ways
for a gram, and share of it that hangs."""
WEIGHTS = {"W1": 0.5, "W2": 1.2, "W3": 1.9}
"""The weights of practice [g], which are not told: the thrust that they took."""


@dataclass(frozen=True, slots=True)
class Kind:
    """What is expected of a kind before any reading.

    Attributes
    ----------
    prior
        probability, all places together.
    size, most, unit
        usual size, and the greatest.
    error
        relative error of what it changes of the steady commands.
    step, shake
        (mean, standard deviation) by which it raises the logarithms of the steps of commands and of what shakes.
    """

    prior: float
    size: float
    most: float
    unit: str
    error: float
    step: tuple[float, float]
    shake: tuple[float, float]


KINDS = {
    "blade_cut": Kind(0.25, 3.5, 12.0, "mm", 0.3, (0.35, 0.5), (0.1, 0.4)),
    "weight_near_rotor": Kind(0.17, 1.2, 6.0, "g", 0.35, (0.3, 0.45), (-0.1, 0.25)),
    "weight_on_string": Kind(0.12, 1.5, 6.0, "g", 0.5, (0.2, 0.4), (0.15, 0.3)),
    "tape_on_blade": Kind(0.06, 1.0, 4.0, "-", 0.4, (-0.3, 0.5), (0.3, 0.3)),
    "blade_bent": Kind(0.004, 1.0, 4.0, "-", 0.4, (0.35, 0.5), (0.3, 0.4)),
    "motor_weak": Kind(0.002, 6.0, 30.0, "%", 0.2, (0.03, 0.2), (0.03, 0.1)),
    "arm_bent": Kind(0.002, 1.0, 5.0, "deg", 0.2, (0.03, 0.2), (0.03, 0.1)),
    "centre_of_mass_shift": Kind(0.004, 1.0, 6.0, "mm", 0.2, (0.03, 0.3), (0.03, 0.2)),
    "payload_centre": Kind(0.004, 1.5, 8.0, "g", 0.2, (0.03, 0.3), (0.03, 0.2)),
}
ON_TWO = {"blade_cut": 0.15, "tape_on_blade": 0.07}
"""Probability that two rotors have one each, of the same size."""
BETWEEN_TWO = 0.03
"""Probability of one weight between two rotors."""
COUNT, UNKNOWN = (0.20, 0.72, 0.03), (0.015, 0.005, 0.001)
OFTEN, AGAIN = 1.0, 4.0
"""What a place counts before practice, each told cause there counting one more; by how much more often than before, in
units of its prior, a cause acts for each practice flight that had it."""
OTHER_AIRFRAME = 0.4
"""What a practice flight of the other airframe says of how a kind shakes, over one of the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """Readings (n_readings,) of one flight of an airframe, and which log it kept."""

    airframe: str
    log: str
    role: str
    readings: FloatArray


def commands(table: pd.DataFrame) -> FloatArray:
    """Return thrust, roll / 2, pitch / 2 and yaw commands (n, 4) [g]: the mixing solved for them in log A."""
    if "m1" in table:
        m1, m2, m3, m4 = table[["m1", "m2", "m3", "m4"]].to_numpy(dtype=float).T
        columns = [m1 + m2 + m3 + m4, m3 + m4 - m1 - m2, m1 + m4 - m2 - m3, m1 - m2 + m3 - m4]
        return np.asarray(np.column_stack(columns) / 4.0 * GRAMS)
    given = table[["cmd_thrust", "cmd_roll", "cmd_pitch", "cmd_yaw"]].to_numpy(dtype=float)
    return np.asarray(given * np.array([1.0, 0.5, 0.5, 1.0]) * GRAMS)


def read_flights(folder: Path) -> dict[str, Flight]:
    """Return all flights of a folder by name."""
    found = {}
    for row in pd.read_csv(folder / "tests.csv").itertuples():
        table = pd.read_csv(folder / f"{row.flight}.csv.gz")
        time, steady = table["time"].to_numpy(dtype=float), commands(table)
        both = [_hover(time, table["z"].to_numpy(dtype=float), is_back) for is_back in (False, True)]
        mean = np.mean([part.mean(axis=0) for part in _parts(time, steady, both)], axis=0)
        out, back = (float(part.mean()) for part in _parts(time, steady[:, 3], [OUT, BACK]))
        shaking = [*steady.T, *table[list(SHAKEN[str(row.log)])].to_numpy(dtype=float).T]
        steps = [np.mean([np.mean(np.diff(p) ** 2) for p in _parts(time, one, both)]) for one in shaking]
        readings = np.array([*mean, out - back, *(0.5 * np.log(steps))])
        found[str(row.flight)] = Flight(str(row.airframe), str(row.log), str(row.role), readings)
    return found


def _hover(time: FloatArray, height: FloatArray, is_back: bool) -> tuple[float, float]:
    """Return begin and end of the hover on the way out, or of that on the way back [s]."""
    part = time[(height > HEIGHT) & ((time > HALFWAY) == is_back)]
    return float(part[0]) + SETTLE, float(part[-1]) - LEAVE


def _parts(time: FloatArray, signal: FloatArray, stretches: Sequence[tuple[float, float]]) -> list[FloatArray]:
    """Return the samples of a signal in each stretch [s], both ends included."""
    return [signal[(time >= begin) & (time <= end)] for begin, end in stretches]


def hover(parameters: Mapping[str, float]) -> FloatArray:
    """Return thrust, roll, pitch and yaw commands and the difference of yaw between the ways (5,) [g]."""
    steady, way = np.array([HOVER + parameters["payload_centre centre"] / 4.0, 0.0, 0.0, 0.0]), 0.0
    for place, side in SIDES.items():
        steady += HOVER / ARM * parameters[f"centre_of_mass_shift {place}"] * np.array(side)
    for one, other in PAIRS:
        middle = (PATTERNS[one] + PATTERNS[other]) / 2.0
        steady += parameters[f"weight_near_rotor {one}+{other}"] * (1.0 + BLOCKED) / 4.0 * middle
    for rotor, pattern in PATTERNS.items():
        places = [rotor, *(f"{one}&{other}" for one, other in PAIRS if rotor in (one, other))]
        cut, tape = (sum(parameters[f"{kind} {place}"] for place in places) for kind in ON_TWO)
        weight, string = parameters[f"weight_near_rotor {rotor}"], parameters[f"weight_on_string {rotor}"]
        steady += (weight + LIFTED * string) / 4.0 * np.array([1.0, 1.0, 1.0, 0.0]) * pattern
        steady[3] += weight * SWIRL / 4.0 * pattern[3] + TILT * parameters[f"arm_bent {rotor}"]
        loss = CUT * cut + TAPE * (tape + parameters[f"blade_bent {rotor}"])
        loss += parameters[f"motor_weak {rotor}"] / 100.0
        steady += (HOVER * loss + BLOCKED * weight) / 4.0 * pattern
        way += DRAGGED * string * pattern[1]
    return np.array([*steady, way])


def places_of(kind: str) -> list[str]:
    """Return where a kind may act: on two rotors (`M1&M2`) one each, between two (`M1+M2`) one."""
    if kind in ("centre_of_mass_shift", "payload_centre"):
        return list(SIDES) if kind == "centre_of_mass_shift" else ["centre"]
    joined = "&" if kind in ON_TWO else "+" if kind == "weight_near_rotor" else ""
    return [*PATTERNS, *(joined.join(pair) for pair in PAIRS if joined)]


def quadrotor_twin(usual: FloatArray, raised: Mapping[str, FloatArray], log: str) -> FunctionTwin:
    """Return the twin of an airframe: its usual shaking (n_shaken,), and by how much each kind raises it in full."""

    def model(parameters: Mapping[str, float], _: Mapping[str, float]) -> FloatArray:
        shaken = usual.copy()
        for name, size in parameters.items():
            kind = name.split(" ")[0]
            shaken += raised[kind] * (1.0 - np.exp(-2.0 * abs(size) / KINDS[kind].size))
        return np.concatenate([hover(parameters), shaken])

    ranges = {
        f"{name} {place}": (0.0, -one.most if name == "arm_bent" else 0.0, one.most, one.unit)
        for name, one in KINDS.items()
        for place in places_of(name)
    }
    shakes = (*(f"step_{axis}" for axis in AXES), *(f"shake_{name}" for name in SHAKEN[log]))
    return function_twin(model, {**dict.fromkeys(STEADY, "g"), **dict.fromkeys(shakes, "1")}, ranges, loads=())


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """An effect that is known to `signature_error` (n_readings,)."""

    own: Any
    signature_error: FloatArray

    def __getattr__(self, name: str) -> Any:
        return getattr(self.own, name)


def practice_of(folder: Path) -> dict[str, dict[str, float]]:
    """Return the size of every cause of the practice flights by name: `kind place`."""
    found = {}
    for row in pd.read_csv(folder / "practice.csv").itertuples():
        sizes = {}
        for cause, words in zip(str(row.condition).split("; "), str(row.detail).split("; "), strict=True):
            weight = re.search(r"W\d", words)
            cut = sum(float(number) for number in re.findall(r"([\d.]+) mm", words))
            sizes[cause.replace(" at ", " ")] = cut or (WEIGHTS[weight[0]] if weight else 1.0)
        found[str(row.flight)] = sizes
    return found


def odds_of(practice: Sequence[Mapping[str, float]]) -> Odds:
    """Return the odds of all effects, after the practice flights of an airframe."""
    count = dict.fromkeys(PATTERNS, OFTEN)
    for rotor in (rotor for one in practice for cause in one for rotor in cause.split(" ")[1].split("+")):
        count[rotor] += 1.0
    rotors = {rotor: own / sum(count.values()) for rotor, own in count.items()}
    pairs = {pair: rotors[pair[0]] * rotors[pair[1]] for pair in PAIRS}
    shares = {}
    for name in KINDS:
        for place in places_of(name):
            often = AGAIN * sum(frozenset(one) == causes_of(f"{name} {place}") for one in practice)
            shares[f"{name} {place}"] = _prior(name, place, rotors, pairs) * (1.0 + often)
    mean = float(np.mean(list(shares.values())))
    return Odds(COUNT, UNKNOWN, effects={name: share / mean for name, share in shares.items()})


def _prior(name: str, place: str, rotors: Mapping[str, float], pairs: Mapping[tuple[str, str], float]) -> float:
    """Return the probability of a kind at a place, by the probability of each rotor and of each two."""
    if place in rotors:
        return KINDS[name].prior * rotors[place]
    if name in ("centre_of_mass_shift", "payload_centre"):
        return KINDS[name].prior / len(places_of(name))
    one, other = re.split("[+&]", place)
    return ON_TWO.get(name, BETWEEN_TWO) * pairs[one, other] / sum(pairs.values())


def causes_of(effect: str) -> Causes:
    """Return the causes that an effect stands for: one on each of two rotors are two."""
    kind, _, place = effect.partition(" ")
    return frozenset(f"{kind} {own}".strip() for own in place.split("&"))


def raised_by(
    flights: Mapping[str, Flight], practice: Mapping[str, Mapping[str, float]], airframe: str, log: str
) -> dict[str, FloatArray]:
    """Return by how much each kind raises what shakes (n_shaken,): as expected, and as practice flights showed."""
    sound = {own: _shaking(flights, own, log).mean(axis=0) for own in sorted({f.airframe for f in flights.values()})}
    found = {}
    for name, kind in KINDS.items():
        total = np.repeat([kind.step[0], kind.shake[0]], [len(AXES), len(SHAKEN[log])])
        weight = 1.0
        for flight, causes in practice.items():
            one = flights.get(flight)
            if one is not None and one.log == log and any(cause.startswith(f"{name} ") for cause in causes):
                share = 1.0 if one.airframe == airframe else OTHER_AIRFRAME
                total = total + share * (one.readings[len(STEADY) :] - sound[one.airframe])
                weight += share
        found[name] = total / weight
    return found


def _shaking(flights: Mapping[str, Flight], airframe: str, log: str) -> FloatArray:
    """Return what shakes (n_flights, n_shaken) in the sound flights of an airframe with a log."""
    own = [one for one in flights.values() if (one.airframe, one.log, one.role) == (airframe, log, "commissioning")]
    return np.array([one.readings[len(STEADY) :] for one in own])


def diagnosis_of(name: str, flights: Mapping[str, Flight], practice: Mapping[str, Mapping[str, float]]) -> Diagnosis:
    """Return what a flight says beside the others: sound ones, and practice flights less their known change."""
    flight, others = flights[name], {own: one for own, one in flights.items() if own != name}
    raised = raised_by(others, practice, flight.airframe, flight.log)
    twin = quadrotor_twin(_shaking(others, flight.airframe, flight.log).mean(axis=0), raised, flight.log)
    same = {own: one for own, one in others.items() if one.airframe == flight.airframe}
    tests = [_as(flight.log, one) for one in same.values() if one.role == "commissioning"]
    told = {own: practice[own] for own in same if own in practice}
    for own, causes in told.items():
        tests.append(_as(flight.log, same[own]) - (twin.ask({}, NO_LOAD, causes) - twin.ask({}, NO_LOAD, {})))
    shaken = [STEP_SD] * len(AXES) + [SHAKE_SD] * len(SHAKEN[flight.log])
    noise = dict(zip(twin.gauges, (*WITHIN, *shaken), strict=True))
    run = gathered(twin, [Recorded(one, {}, f"sound_{k}") for k, one in enumerate(tests)])
    effects = {key: Known(one, _error(key, raised, flight.log)) for key, one in twin.effects.items()}
    campaign = gathered(twin, [Recorded(flight.readings)])
    return diagnose(campaign, twin, effects, run, noise_sd=noise, odds=odds_of(list(told.values())))


def _as(log: str, one: Flight) -> FloatArray:
    """Return the readings (n_readings,) of a flight for a log: of another one nothing that shakes is known."""
    if one.log == log:
        return one.readings
    return np.concatenate([one.readings[: len(STEADY)], np.full(len(AXES) + len(SHAKEN[log]), np.nan)])


def _error(effect: str, raised: Mapping[str, FloatArray], log: str) -> FloatArray:
    """Return to what an effect is known at each reading (n_readings,), relative."""
    name = effect.split(" ")[0]
    kind = KINDS[name]
    sd = np.repeat([kind.step[1], kind.shake[1]], [len(AXES), len(SHAKEN[log])])
    return np.concatenate(
        [np.full(len(STEADY), kind.error), np.minimum(sd / np.maximum(np.abs(raised[name]), 0.03), 50.0)]
    )


def told_flights(folder: Path) -> Iterator[tuple[str, Causes, Mapping[Causes, float]]]:
    """Yield every practice and commissioning flight, what acted, and the probabilities of causes without itself."""
    flights, practice = read_flights(folder), practice_of(folder)
    for name in (name for name, one in flights.items() if one.role != "blind"):
        shares: dict[Causes, float] = {}
        for effects, share in shares_of(diagnosis_of(name, flights, practice)).items():
            causes = frozenset().union(*map(causes_of, effects))
            shares[causes] = shares.get(causes, 0.0) + share
        yield name, frozenset(practice.get(name, {})), shares


def main() -> None:
    """Print a line for each flight that is told, then what all sum to."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.quadrotor", description=__doc__)
    folder = folder_asked(parser, "tests.csv")
    told = []
    for name, truth, shares in told_flights(folder):
        first = max(shares, key=lambda causes: shares[causes])
        print(f"{name} {', '.join(sorted(truth)) or 'sound'}: {shares.get(truth, 0.0):.3f}; {', '.join(sorted(first))}")
        told.append((truth, shares))
    print(summary(told))


if __name__ == "__main__":
    main()
