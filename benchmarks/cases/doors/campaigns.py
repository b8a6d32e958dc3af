"""Campaigns as displays and loggers give them: `python -m benchmarks.run campaigns`, about ten minutes.

A machine of two to six readings, each proportional to a force, is read 2 to 12 times at two to five forces. Its display
has steps of 0.2 to 10 standard deviations of its noise. A sound machine, within 1 % of its twin, is never told to
repair or to widen a channel, and seldom accused. A stuck, clipped or biased channel is found.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import Line, markdown
from octmip.errors import DataError
from octmip.gap import Recorded, diagnose, function_twin, gathered
from octmip.interfaces.report.diagnosis.recommendation import recommend

SOUND, FAULTY = 500, 200
DISPLAYS = (
    "one step",
    "a coarse channel",
    "tared zero",
    "one load equal",
    "all repeats equal",
    "counts",
    "noise grows",
)
FAULTS = ("stuck always", "stuck from a row on", "clipped", "biased")
FALSE_WORDS = re.compile("repair|widen", re.IGNORECASE)


@dataclass(frozen=True)
class Drawn:
    """One campaign.

    Attributes
    ----------
    kind : its display, or its fault.
    gains : (n_gauges,) readings by force, of the twin.
    forces : (n_loads,).
    blocks : readings (n_repeats, n_gauges) at each force.
    run : the same of a sound commissioning run, or nothing.
    gauge : the faulty channel.
    """

    kind: str
    gains: NDArray[np.float64]
    forces: tuple[float, ...]
    blocks: tuple[NDArray[np.float64], ...]
    run: tuple[NDArray[np.float64], ...]
    gauge: int = -1


def drawn(seed: int, faulty: bool = False) -> Drawn:
    """Return the campaign of a seed: of a sound machine, or with one faulty channel."""
    rng = np.random.default_rng([65, int(faulty), seed])
    kind = (FAULTS if faulty else DISPLAYS)[seed % (len(FAULTS) if faulty else len(DISPLAYS))]
    gains = rng.choice([-1.0, 1.0], n_gauges := int(rng.integers(2, 7))) * rng.uniform(0.2, 1.0, n_gauges)
    forces = np.arange(int(rng.integers(0, 2)), int(rng.integers(4 if faulty else 2, 6)) + 1) * 100.0
    forces = np.unique([0.0, *forces]) if kind == "tared zero" else forces
    sd = float(np.exp(rng.uniform(np.log(0.002), np.log(0.03)))) * float(np.abs(gains).max() * forces[-1])
    step = sd * float(np.exp(rng.uniform(np.log(0.02 if faulty else 0.2), np.log(1.0 if faulty else 10.0))))
    step = float(f"{step:.0e}")
    if kind == "counts":
        gains, sd, step = gains / step, sd / step, 1.0
    repeats, asset = int(rng.integers(2, 13)), gains * (1.0 + 0.01 * rng.standard_normal(n_gauges))

    def campaign() -> tuple[NDArray[np.float64], ...]:
        return tuple(_read(rng, kind, asset * force, force / forces[-1], repeats, sd, step) for force in forces)

    blocks, run = campaign(), campaign() if rng.random() < 0.5 or faulty else ()
    gauge = int(rng.integers(n_gauges)) if faulty else -1
    if faulty:
        _spoil(rng, kind, blocks, gauge, sd, step)
    return Drawn(kind, gains, tuple(forces.tolist()), blocks, run, gauge)


def _read(
    rng: np.random.Generator, kind: str, truth: NDArray[np.float64], share: float, repeats: int, sd: float, step: float
) -> NDArray[np.float64]:
    """Return what a display shows of a load that is a share of the greatest (n_repeats, n_gauges)."""
    scatter = sd * (0.1 + 0.9 * share if kind == "noise grows" else 1.0)
    values = truth + scatter * rng.standard_normal((repeats, len(truth)))
    steps = np.full(len(truth), step)
    if kind == "a coarse channel":
        steps[1:] = float(f"{0.01 * sd:.0e}")
    if kind == "all repeats equal" or (kind == "one load equal" and share > 0.9):
        values[:] = values[0]
    shown = np.round(values / steps) * steps
    return np.zeros_like(shown) if kind == "tared zero" and share == 0.0 else shown


def _spoil(
    rng: np.random.Generator, kind: str, blocks: Sequence[NDArray[np.float64]], gauge: int, sd: float, step: float
) -> None:
    """Put a fault into one channel, in place."""
    own = np.concatenate([block[:, gauge] for block in blocks])
    size, n = np.sign(own[-1]) * np.abs(own).max(), len(blocks[0])
    first = 0 if kind == "stuck always" else int(rng.integers(len(own) // 4, len(own) // 2))
    if kind.startswith("stuck"):
        own[first:] = own[first]
    elif kind == "clipped":
        rail = np.round(size * rng.uniform(0.4, 0.8) / step) * step
        own = np.sign(size) * np.minimum(own * np.sign(size), abs(rail))
    else:
        own += np.round((6.0 * sd + 0.1 * abs(size)) / step) * step
    for k, block in enumerate(blocks):
        block[:, gauge] = own[k * n : (k + 1) * n]


def answered(case: Drawn) -> tuple[str, str]:
    """Return the outcome of a diagnosis, and its first sentence."""
    names = [f"g{k}" for k in range(len(case.gains))]
    twin = function_twin(
        lambda p, loads: case.gains * loads["force"] * (100.0 / p["stiffness"]),
        dict.fromkeys(names, "mm"),
        {"stiffness": (100.0, 80.0, 120.0, "N/mm")},
        ["force"],
    )
    read, run = (
        [Recorded(y, {"force": f}) for y, f in zip(b, case.forces, strict=False)] for b in (case.blocks, case.run)
    )
    try:
        found = diagnose(gathered(twin, read), twin, commissioning=gathered(twin, run) if run else None)
    except DataError as error:
        return "refused", str(error)
    except Exception as error:  # what this study counts
        return f"traceback: {type(error).__name__}", str(error)
    told, channel = recommend(found), names[case.gauge]
    if case.gauge >= 0:
        where = {part.place for part in found.which[0].parameters} if case.kind == "biased" else set()
        named = {"stuck": found.noise.stuck, "clipped": found.noise.clipped}.get(case.kind.split()[0], where)
        return ("found" if channel in named else "missed"), told
    if FALSE_WORDS.search(told.partition(";")[0]):
        return "told to repair or widen", told
    return ("accused" if found.which[0].effects else "sound"), told


def results(limit: float, threads: Sequence[int], seeds: int | None = None) -> Iterator[Line]:
    """Yield a line for each kind of campaign; `seeds` is the number of sound ones, with two faulty ones to five."""
    sound = seeds or SOUND
    for faulty, count in ((False, sound), (True, max(1, sound * FAULTY // SOUND))):
        outcomes: dict[str, Counter[str]] = {}
        for seed in range(count):
            case = drawn(seed, faulty)
            outcomes.setdefault(case.kind, Counter())[answered(case)[0]] += 1
        for kind, found in outcomes.items():
            yield {"size": kind, "faulty": faulty, "campaigns": found.total(), "outcomes": dict(found)}


def summary(lines: Sequence[Line]) -> str:
    """Return kinds by outcomes."""
    outcomes = list(dict.fromkeys(outcome for line in lines for outcome in line["outcomes"]))
    rows = [[line["size"], line["campaigns"], *(line["outcomes"].get(o, 0) for o in outcomes)] for line in lines]
    return markdown(["campaign", "number", *outcomes], rows)
