"""The diagnosis of a folder of damper tests, and its answers as JSON."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from benchmarks.real.damper.accused import accused
from benchmarks.real.damper.closing import NOTHING, Closed, closed
from benchmarks.real.damper.cycles import Samples, samples_of
from benchmarks.real.damper.features import shown
from benchmarks.real.damper.lacking import Lacking, lacking
from benchmarks.real.damper.series import Recording
from octmip.errors import DataError

ACCUSED = 0.5
"""Probability from which a tension reading is called wrong."""
WORTH = 0.01
"""Share of the square of the force that an effect must be worth to be among those the twin lacks; else it is minor."""
FEWEST = 2
"""Sound tests with whole cycles that a series needs for a diagnosis of the twin by tension readings."""


@dataclass(frozen=True, slots=True, eq=False)
class SeriesVerdict:
    """One series: tests, probability of a wrong tension reading of each, samples, what the twin lacks, closing."""

    name: str
    tests: tuple[Recording, ...]
    wrong: tuple[float, ...]
    data: Samples
    lacking: Lacking
    closed: Closed


def diagnose_series(name: str, tests: Sequence[Recording]) -> SeriesVerdict:
    """Return the verdict on one series."""
    features = shown(tests)
    wrong = accused(tests, features)
    is_wrong = [bool(p > ACCUSED) for p in wrong]
    data = samples_of(tests, features, is_wrong)
    if not len(data.test):
        raise DataError(f"series {name!r} has no test with two reversals; in {len(tests)} tests; give whole cycles")
    found = lacking(data, tests)
    sound = [k for k, bad in enumerate(is_wrong) if not bad]
    use = sound if len(sound) >= FEWEST else range(len(tests))
    return SeriesVerdict(name, tuple(tests), tuple(wrong.tolist()), data, found, closed(tests, data, found, list(use)))


def diagnose_tests(tests: Sequence[Recording]) -> list[SeriesVerdict]:
    """Return the verdicts on the series, in the order in which they first appear."""
    names = list(dict.fromkeys(test.series for test in tests))
    return [diagnose_series(name, [test for test in tests if test.series == name]) for name in names]


def answers(verdicts: Sequence[SeriesVerdict]) -> dict[str, object]:
    """Return what is written: tests, effects by series, the cause that all series share, closed and its limit."""
    sizes = [(verdict.name, size) for verdict in verdicts for size in verdict.lacking.sizes]
    told = [({**rounded(asdict(size)), "series": name}, size.worth) for name, size in sizes]
    total = sum((verdict.closed for verdict in verdicts), NOTHING)
    return {
        "tests": [
            {"test": test.name, "tension_reading_wrong": p > ACCUSED, "probability": round(p, 4)}
            for verdict in verdicts
            for test, p in zip(verdict.tests, verdict.wrong, strict=True)
        ],
        "effects": [entry for entry, worth in told if worth >= WORTH],
        "minor_effects": [entry for entry, worth in told if worth < WORTH],
        "cause": cause(verdicts),
        "force_turned": [test.name for verdict in verdicts for test in verdict.tests if test.is_turned],
        "closed": round(total.share, 4),
        "closed_by_series": {verdict.name: round(verdict.closed.share, 4) for verdict in verdicts},
        "closed_by_regression": round(total.limit, 4),
    }


def cause(verdicts: Sequence[SeriesVerdict]) -> dict[str, object] | None:
    """Return the first effect that every series lacks, and whether its sizes agree within their intervals."""
    for first in [size for size in verdicts[0].lacking.sizes if size.worth >= WORTH]:
        same = [[size for size in verdict.lacking.sizes if size.name == first.name] for verdict in verdicts]
        if all(same):
            low, high = max(one[0].low for one in same), min(one[0].high for one in same)
            return {"name": first.name, "unit": first.unit, "sizes_agree": low <= high, "in_common": [low, high]}
    return None


def rounded(size: dict[str, object]) -> dict[str, object]:
    """Return an effect with its numbers to five digits."""
    return {key: float(np.format_float_positional(value, 5, fractional=False)) if isinstance(value, float) else value
            for key, value in size.items()}  # fmt: skip
