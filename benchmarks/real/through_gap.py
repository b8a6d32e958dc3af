"""The same flights and stretches through `octmip.gap.diagnose`: the other column of the tables in docs/gap.

`python -m benchmarks.real.through_gap SET --data FOLDER` judges every practice and commissioning case, each left out of
what it is judged by, and prints the probability of the truth: by the diagnosis, and by the folder's own evidence where
the set has one (the beam has none).
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real import beam
from benchmarks.real.answer import Answer
from benchmarks.real.by_diagnosis import COUNT, UNKNOWN, asked, said
from benchmarks.real.evidence import Named
from benchmarks.real.quadrotor import diagnosis as quadrotor
from benchmarks.real.quadrotor.flight import read_flights
from benchmarks.real.quadrotor.normal import WITHIN
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, Odds

Causes = frozenset[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Told:
    """A case whose truth is told.

    Attributes
    ----------
    case, truth
        name, and what acted.
    plain, gap
        probabilities of sets of causes by the evidence of this folder, None where it has none, and by the diagnosis.
    """

    case: str
    truth: Causes
    plain: Mapping[Causes, float] | None
    gap: Mapping[Causes, float]


def by_gap(
    readings: FloatArray, tests: Sequence[FloatArray], twin: FunctionTwin, noise: Sequence[float], odds: Odds
) -> dict[Causes, float]:
    """Return the probability of each set of causes (kind, place) by `octmip.gap.diagnose`, several tests as the run."""
    found = said(asked(readings, tests, twin, noise, odds), lambda effect: Named(*_named(effect), ""))
    return {frozenset((c.kind, c.place) for c in one.causes): one.probability for one in found}


def _named(effect: str) -> tuple[str, str]:
    kind, _, place = effect.partition(" ")
    return kind, place


def shares_of(answer: Answer) -> dict[Causes, float]:
    """Return the probability of each set of causes in an answer."""
    shares: dict[Causes, float] = {}
    for one in answer.judged:
        causes = frozenset((cause.kind, cause.place) for cause in one.causes)
        shares[causes] = shares.get(causes, 0.0) + one.probability
    return shares


def told_flights(folder: Path) -> Iterator[Told]:
    """Yield every practice and commissioning flight, judged without itself."""
    flights = read_flights(folder)
    practice = pd.read_csv(folder / "practice.csv", index_col="flight")
    for name, flight in flights.items():
        if flight.role == "blind":
            continue
        known = quadrotor.learn(folder, flights, flight.airframe, name)
        causes = quadrotor.told_causes(*map(str, practice.loc[name])) if name in practice.index else []
        shares = {
            f"{one.causes[0].kind} {one.causes[0].place}": one.prior
            for one in quadrotor.hypotheses(known)
            if len(one.causes) == 1 and one.causes[0].kind != "unknown"
        }
        usual = np.mean(list(shares.values()))
        odds = Odds(COUNT, UNKNOWN, effects={effect: float(share / usual) for effect, share in shares.items()})
        n = len(WITHIN)
        tests = [*(one.readings[:n] for one in known.sound), *(one.steady for one in known.told)]
        gap = by_gap(flight.readings[:n], tests, known.twin, list(WITHIN.values()), odds)
        truth = frozenset((kind, place) for kind, place, _ in causes)
        yield Told(name, truth, shares_of(quadrotor.answer(flight, known)), gap)


def told_stretches(folder: Path) -> Iterator[Told]:
    """Yield every practice and commissioning stretch of the beam, judged without itself."""
    tests = pd.read_csv(folder / "tests.csv", index_col="segment")
    practice = pd.read_csv(folder / "practice.csv", index_col="segment")
    chosen = tests[tests.role != "blind"]
    stretches = {str(case): beam.read_stretch(folder, str(case), str(one)) for case, one in chosen.series.items()}
    for case, stretch in stretches.items():
        found = beam.answer(stretch, beam.learn_from(folder, stretches, case))
        acted = case in practice.index and practice.condition[case] != "sound"
        if acted:
            print(case, practice.detail[case], found.first.sizes.round(1).tolist())
        yield Told(case, frozenset({("support_moved", "support")} if acted else set()), None, shares_of(found))


def main() -> None:
    """Read the arguments and print a line for each case that is told, then what both sum to."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.through_gap", description=__doc__)
    parser.add_argument("set", choices=("beam", "quadrotor"))
    parser.add_argument("--data", type=Path, required=True, help="folder of the set")
    given = parser.parse_args()
    told = list((told_stretches if given.set == "beam" else told_flights)(given.data))
    for one in told:
        acted = "; ".join(f"{kind} {place}" for kind, place in sorted(one.truth)) or "sound"
        by = {name: shares.get(one.truth, 0.0) for name, shares in _evidence(one).items()}
        print(f"{one.case} {acted}: {', '.join(f'{name} {share:.3f}' for name, share in by.items())}")
    for name in _evidence(told[0]):
        print(f"{name}: {summary([(one.truth, _evidence(one)[name]) for one in told])}")


def _evidence(one: Told) -> dict[str, Mapping[Causes, float]]:
    return ({} if one.plain is None else {"plain": one.plain}) | {"gap": one.gap}


def summary(told: Sequence[tuple[Causes, Mapping[Causes, float]]]) -> str:
    """Return how many first hypotheses hold the truth, a place of it, and the mean log probability of the truth."""
    first = [max(shares, key=lambda causes: shares[causes], default=frozenset()) for _, shares in told]
    whole = sum(one == truth for one, (truth, _) in zip(first, told, strict=True))
    place = sum(bool(_places(one) & _places(truth)) for one, (truth, _) in zip(first, told, strict=True) if truth)
    log = np.mean([np.log(max(shares.get(truth, 0.0), LEAST)) for truth, shares in told])
    acted = sum(bool(truth) for truth, _ in told)
    return f"whole truth first {whole} of {len(told)}, a place of it {place} of {acted}, mean log probability {log:.2f}"


LEAST = 1e-3
"""Probability that the truth has at least in the mean of logarithms."""


def _places(causes: Causes) -> set[str]:
    return {rotor for _, place in causes for rotor in place.split("+")}


if __name__ == "__main__":
    main()
