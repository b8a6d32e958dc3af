"""A case of a set through `octmip.gap.diagnose`, and what it says in the form of the answers."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from octmip.gap import Diagnosis, FunctionTwin, Odds, Recorded, diagnose, gathered
from octmip.gap.inference.inference import Judged
from octmip.twin import Effect

COUNT, UNKNOWN = (0.30, 0.45, 0.20), (0.03, 0.01, 0.002)
"""Odds of no, one and two effects; of something unknown alone and beside one or two."""
Z90 = 1.645


@dataclass(frozen=True, slots=True)
class Named:
    """A cause as the answer names it."""

    kind: str
    place: str
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class Said:
    """Causes that act together, their probability, and their sizes (k, 3: middle, low, high of 90 %)."""

    causes: tuple[Named, ...]
    probability: float
    sizes: FloatArray


def asked(
    readings: FloatArray,
    tests: Sequence[FloatArray],
    twin: FunctionTwin,
    noise: Sequence[float],
    odds: Odds,
    effects: Mapping[str, Effect] | None = None,
) -> Diagnosis:
    """Return the diagnosis of one row of readings (n,), several tests of the sound asset as the run.

    `noise` is the standard deviation of each reading, and `effects` the library, by default the twin's parameters.
    """
    run = gathered(twin, [Recorded(one, {}, f"sound_{k}") for k, one in enumerate(tests)])
    named = dict(zip(twin.gauges, noise, strict=True))
    library = effects if effects is not None else twin.effects
    return diagnose(gathered(twin, [Recorded(readings)]), twin, library, run, noise_sd=named, odds=odds)


def said(found: Diagnosis, named: Callable[[str], Named]) -> tuple[Said, ...]:
    """Return the hypotheses of a diagnosis, most probable first; `named` says what the answer calls an effect."""
    shares: dict[tuple[str, ...], float] = {}
    first: dict[tuple[str, ...], Judged] = {}
    for one in found.posterior.judged:
        key = ("",) if one.has_unknown else tuple(sorted(one.effects))
        shares[key] = shares.get(key, 0.0) + one.probability
        first.setdefault(key, one)
    by_name = {tuple(sorted(c.effects)): c for c in found.which}
    rows = []
    for key in sorted(shares, key=lambda key: -shares[key]):
        causes = (Named("unknown", "", ""),) if key == ("",) else tuple(named(name) for name in key)
        sizes = {p.effect: (p.size, p.low, p.high) for p in by_name[key].parameters} if key in by_name else {}
        fitted = {} if key == ("",) else _fitted(first[key])
        rows.append(
            Said(causes, shares[key], np.array([sizes.get(n, fitted.get(n, (0, 0, 0))) for n in key]).reshape(-1, 3))
        )
    return tuple(rows)


def _fitted(one: Judged) -> dict[str, tuple[float, float, float]]:
    """Return by effect the size of a hypothesis and its 90 % interval, as fitted."""
    found, candidates = one.fit, one.model.inputs.candidates
    sd = np.sqrt(np.diag(found.covariance))
    rows = zip(one.members, found.size.tolist(), sd.tolist(), strict=True)
    return {candidates[j].name: (size, size - Z90 * s, size + Z90 * s) for j, size, s in rows}
