"""How often a wrong tension reading is found: faults put into copies of sound tests, and who is accused.

Each draw takes a series, gives a share of its tests a fault drawn from `FAULTS` and asks who is accused.
`python -m benchmarks.real.damper.faults --data ../shared/damper` prints the table of docs/gap/damper.md.
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.main_program import run_main
from benchmarks.real.damper.accused import accused
from benchmarks.real.damper.series import Recording, read_folder
from femlib.arrays import FloatArray

Draw = np.random.Generator
Fault = Callable[[Recording, Sequence[Recording], Draw], FloatArray]
DRAWS = 40
SHARES = (0.1, 0.3, 0.6)


def one_end(change: Callable[[FloatArray, Draw], FloatArray]) -> Fault:
    """Return the fault that changes the reading of one end, drawn."""

    def fault(test: Recording, others: Sequence[Recording], draw: Draw) -> FloatArray:
        end = int(draw.integers(2))
        tension = test.tension.copy()
        tension[end] = change(tension[end], draw)
        return tension

    return fault


def both_ends(change: Callable[[FloatArray, Draw], FloatArray]) -> Fault:
    """Return the fault that changes both ends."""
    return lambda test, others, draw: change(test.tension, draw)


def from_another(test: Recording, others: Sequence[Recording], draw: Draw) -> FloatArray:
    """Return another test's tensions, repeated as often as needed."""
    other = others[int(draw.integers(len(others)))].tension
    return np.asarray(np.resize(np.tile(other, (1, 1 + len(test.time) // other.shape[1])), (2, len(test.time))))


def held(reading: FloatArray, draw: Draw) -> FloatArray:
    """Return a reading that stands still from a drawn moment on."""
    start = int(len(reading) * draw.uniform(0.0, 0.6))
    return np.where(np.arange(len(reading)) < start, reading, reading[start])


def dropped(reading: FloatArray, draw: Draw) -> FloatArray:
    """Return a reading that falls to zero in spells, a tenth of the time."""
    out = reading.copy()
    for start in draw.integers(0, len(reading), 5):
        out[start : start + len(reading) // 50] = 0.0
    return out


def later(reading: FloatArray, draw: Draw) -> FloatArray:
    """Return a reading a tenth of a second or two late."""
    return np.asarray(np.roll(reading, int(draw.integers(13, 26)), axis=-1))


def peak(reading: FloatArray) -> float:
    """Return the tension at the tight end."""
    return float(np.quantile(reading, 0.95))


FAULTS: Mapping[str, Fault] = {
    "one end x 0.8 or 1.2": one_end(lambda r, d: r * d.choice([0.8, 1.2])),
    "one end x 0.5 or 2": one_end(lambda r, d: r * d.choice([0.5, 2.0])),
    "both ends x 0.8 or 1.2": both_ends(lambda r, d: r * d.choice([0.8, 1.2])),
    "both ends in newtons": both_ends(lambda r, d: r * 4.448),
    "zero of one end off by 10 %": one_end(lambda r, d: r + d.choice([-0.1, 0.1]) * peak(r)),
    "zeros of both ends off by 10 %": both_ends(lambda r, d: r + d.choice([-0.1, 0.1]) * peak(r)),
    "drifting zero, 10 % over the test": one_end(
        lambda r, d: r + d.choice([-0.1, 0.1]) * peak(r) * np.linspace(0, 1, len(r))
    ),
    "ends exchanged": lambda test, others, draw: test.tension[::-1].copy(),
    "sign turned": one_end(lambda r, d: -r),
    "dead (noise about zero)": one_end(lambda r, d: d.normal(0.0, 1.0, len(r))),
    "stands still from a moment on": one_end(held),
    "another test's reading": from_another,
    "noise of 10 %": one_end(lambda r, d: r + d.normal(0.0, 0.1 * peak(r), len(r))),
    "drop-outs, a tenth of the time": one_end(dropped),
    "clipped at 70 %": one_end(lambda r, d: np.minimum(r, 0.7 * peak(r))),
    "late by 0.1 to 0.2 s": both_ends(later),
}


def corrupted(tests: Sequence[Recording], which: Sequence[int], fault: Fault, draw: Draw) -> list[Recording]:
    """Return the tests with the fault in some of them."""
    sound = [test for k, test in enumerate(tests) if k not in which]
    return [replace(test, tension=fault(test, sound, draw)) if k in which else test for k, test in enumerate(tests)]


def rates(tests: Sequence[Recording], fault: Fault, share: float, draws: int, seed: int = 0) -> tuple[float, float]:
    """Return the share of wrong readings that are found, and of right ones that are accused."""
    found, falsely = [], []
    for draw in (np.random.default_rng([seed, k]) for k in range(draws)):
        count = max(1, round(share * len(tests)))
        which = set(draw.choice(len(tests), count, replace=False).tolist())
        wrong = accused(corrupted(tests, sorted(which), fault, draw)) > 0.5
        found += [bool(wrong[k]) for k in which]
        falsely += [bool(wrong[k]) for k in range(len(tests)) if k not in which]
    return float(np.mean(found)), float(np.mean(falsely))


def main() -> None:
    """Print the table: fault, found and falsely accused by share of wrong tests, over both series."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--draws", type=int, default=DRAWS)
    asked = parser.parse_args()
    tests = read_folder(asked.data)
    series = [[test for test in tests if test.series == name] for name in sorted({test.series for test in tests})]
    print("| fault | " + " | ".join(f"{share:.0%} of the tests wrong" for share in SHARES) + " |")
    print("|---|" + "---|" * len(SHARES))
    for name, fault in FAULTS.items():
        cells = []
        for share in SHARES:
            each = np.array([rates(group, fault, share, asked.draws) for group in series])
            cells.append(" / ".join(f"{number:.2f}" for number in each.mean(axis=0)))
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    run_main(main)
