"""Score sound assets: false alarms by kind of noise, two tests in unknown states, and wrong commissioning runs."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.blind.answers import Found
from benchmarks.blind.cases import SOUND
from benchmarks.blind.score import Pair, by_family
from benchmarks.figure import Figure, share, table

WHITE, OTHER, DOUBTED = (-np.inf, 0.02), (-np.inf, 0.05), (0.95, np.inf)


def sound_tables(told: Mapping[str, Sequence[Pair]]) -> list[str]:
    """Return the tables of a set of sound assets: the first selector by family and over all, the others over all."""
    found = []
    for title, is_calibrated in (("With the commissioning run", True), ("Without a commissioning run", False)):
        parts = {name: [(f, a) for f, a in cases if f["calibrated"] == is_calibrated] for name, cases in told.items()}
        (_, part), *others = parts.items()
        by = by_family(part)
        columns = {**(by if len(by) > 1 else {}), "all": part, **dict(others)}
        if part:
            found.append(table(f"Sound assets. {title}", {name: sound(rows) for name, rows in columns.items()}))
    return found


def sound(cases: Sequence[Pair]) -> list[Figure]:
    """Return the figures of sound assets."""
    strata = [s for s in SOUND if any(a["case"]["stratum"] == s for _, a in cases)]
    rows = []
    for stratum in strata:
        part = [f for f, a in cases if a["case"]["stratum"] == stratum]
        kind, _, what = stratum.partition(": ")
        if kind == "run":
            rows.append(share(f"run of a {_RUNS[what]} doubted", [bool(f["doubts"]) for f in part], DOUBTED))
            rows.append(share(f"asset accused beside the run of a {_RUNS[what]}", [accused(f) for f in part]))
        else:
            words = f"false alarm, {what}" if kind == "noise" else "false alarm, two tests in unknown states"
            rows.append(share(words, [accused(f) for f in part], WHITE if what == "white" else OTHER))
    right = [f for f, a in cases if a["case"]["run"] == "own" and f["calibrated"]]
    return [*rows, share("right run doubted", [bool(f["doubts"]) for f in right], OTHER)]


def accused(found: Found) -> bool:
    """Return whether the first cause names something that acts."""
    return bool(found["which"][0]["effects"])


_RUNS = {"damaged": "damaged wing", "warm": "wing 10 K warmer", "other wing": "different wing"}
