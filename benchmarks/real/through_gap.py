"""Flights and stretches whose truth is told, each judged without itself.

`python -m benchmarks.real.through_gap SET --data FOLDER` prints the probability of the truth.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real import beam
from benchmarks.real.answer import Answer
from benchmarks.real.quadrotor import diagnosis as quadrotor
from benchmarks.real.quadrotor.diagnosis import Causes
from benchmarks.real.quadrotor.flight import read_flights

Told = tuple[str, Causes, Mapping[Causes, float]]
"""Name of a case, what acted, and the probabilities of sets of causes."""


def shares_of(answer: Answer) -> dict[Causes, float]:
    """Return the probability of each set of causes in an answer."""
    shares: dict[Causes, float] = {}
    for one in answer.judged:
        causes = frozenset((cause.kind, cause.place) for cause in one.causes)
        shares[causes] = shares.get(causes, 0.0) + one.probability
    return shares


def told_flights(folder: Path) -> Iterator[Told]:
    """Yield every practice and commissioning flight, judged without itself."""
    flights, practice = read_flights(folder), quadrotor.practice_of(folder)
    for name, flight in flights.items():
        if flight.role != "blind":
            found = quadrotor.answer(flight, quadrotor.learn(folder, flights, flight.airframe, name))
            yield name, frozenset((kind, place) for kind, place, _ in practice.get(name, [])), shares_of(found)


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
        yield case, frozenset({("support_moved", "support")} if acted else set()), shares_of(found)


def main() -> None:
    """Read the arguments and print a line for each case that is told, then what both sum to."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.through_gap", description=__doc__)
    parser.add_argument("set", choices=("beam", "quadrotor"))
    parser.add_argument("--data", type=Path, required=True, help="folder of the set")
    given = parser.parse_args()
    told = list((told_stretches if given.set == "beam" else told_flights)(given.data))
    for case, truth, shares in told:
        acted = "; ".join(f"{kind} {place}" for kind, place in sorted(truth)) or "sound"
        print(f"{case} {acted}: {shares.get(truth, 0.0):.3f}")
    print(summary([(truth, shares) for _, truth, shares in told]))


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
