"""Score diagnoses against the opened keys; every figure with its interval, its number of cases and what it owes."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from benchmarks.blind.answers import Found
from benchmarks.blind.assets.families import in_order
from benchmarks.blind.cases import ALL_LOADS, CONFOUNDED, REPEATS
from benchmarks.blind.sealing import LEAST, Key
from benchmarks.blind.truths import TRACELESS
from benchmarks.figure import Figure, area, calibration, share, statistic, tenth
from benchmarks.noises import VARIANCE
from benchmarks.seals import is_right
from femlib.arrays import FloatArray

Pair = tuple[Found, Key]
"""A diagnosis and the opened key of its case."""
ByStratum = Mapping[str, Sequence[Pair]]

CLEAR = 5.0
"""d' from which an effect ought to be named."""
SEEN = 3.0
STATED = 0.95
"""Probability of a cause that a user acts on."""
OWN = 0.01
"""Without a commissioning run: what two models of one wing differ by per gauge."""
LARGE = 4.0
"""Standard deviations from which an entry ought to be located."""
SAME_UNIT = {
    "modulus", "skin_thickness", "temperature_uniform", "temperature_gradient", "torsion", "planform",
    "large_deflection", "payload_inertia", "gauge_gain", "gauge_bias", "gauge_drift", "misalignment", "crosstalk",
    "load_factor_error", "common_gain",
}  # fmt: skip
"""Effects whose size means the same in key and diagnosis. Not so: a lift shape or zone of another form, creep (the
diagnosis counts the time from the start of the campaign), an offset along a slope that two models do not share."""
PRIOR = {"none": 0.50, "single": 0.38, "pair": 0.07, "outside": 0.04}
"""Probability of each stratum before any data, as the diagnosis assumes it (docs/theory/gap.md). Its probabilities can
only be those of a world in which that is so; the cases are drawn otherwise, with many faults, and weighted back."""
ONE_GAUGE = {"gauge_gain", "gauge_bias", "gauge_drift", "misalignment", "crosstalk"}
INFINITY = float("inf")


def names_of(answer: Key) -> list[str]:
    """Return the sorted true names, those left out that no strain shows."""
    return sorted(truth["name"] for truth in answer["case"]["truths"] if truth["name"] != TRACELESS)


def top(found: Found, answer: Key) -> bool:
    """Return whether the first cause is the truth, up to what it says cannot be told apart.

    Of what is outside the library "unknown" is the truth.
    """
    truth = names_of(answer)
    return found["which"][0]["effects"] == ["unknown"] if truth == ["outside"] else is_right(found["names"][0], truth)


def all_confounded(found: Found) -> bool | None:
    """Return whether a first cause of modulus, load factor or common gain names all three; None for other causes."""
    groups = [set(group) & CONFOUNDED for group in found["names"][0]]
    return all(group == CONFOUNDED for group in groups if group) if any(groups) else None


def right_probability(found: Found, truth: Sequence[str]) -> float:
    """Return the probability of the causes that hold the truth."""
    return sum(c["probability"] for c, g in zip(found["which"], found["names"], strict=True) if is_right(g, truth))


def d_prime(found: Found, answer: Key) -> float:
    """Return how far the truths stand from what this diagnosis had to reckon with."""
    return answer["d_prime"]["calibrated" if found["calibrated"] else "bare"]


def least_part(found: Found, answer: Key) -> float:
    """Return how far the weakest effect stands from what the other can imitate, of what is outside from the library."""
    kind = "calibrated" if found["calibrated"] else "bare"
    parts = answer["d_prime_of_parts"][kind]
    return min([*parts, *([answer["from_library"][kind]] if "from_library" in answer else [])])


def is_standard(answer: Key) -> bool:
    """Return whether a case has the conditions of the table of figures: known healthy state, loads 0 to 3."""
    case = answer["case"]
    return case["is_known"] and len(case["states"]) == 1 and tuple(case["loads"]) == ALL_LOADS


def by_family(cases: Sequence[Pair]) -> dict[str, list[Pair]]:
    """Return the cases of each family of assets."""
    families = in_order({a["case"]["family"] for _, a in cases})
    return {name: [(f, a) for f, a in cases if a["case"]["family"] == name] for name in families}


def figures(cases: Sequence[Pair]) -> list[Figure]:
    """Return the table for pairs of diagnosis and opened key."""
    by = {
        s: [(f, a) for f, a in cases if a["case"]["stratum"].startswith(s)]
        for s in ("none", "noise", "single", "pair", "outside", "channel")
    }
    clear = [(f, a) for f, a in by["single"] if d_prime(f, a) >= CLEAR]
    return [
        *_naming(by, clear),
        *_alarms(by),
        *_beliefs(by, clear),
        *_closing(by, clear),
        statistic("CPU seconds, known state", [f["seconds"] for f, a in cases if a["case"]["is_known"]], np.median),
        statistic(
            "CPU seconds, unknown state", [f["seconds"] for f, a in cases if not a["case"]["is_known"]], np.median
        ),
    ]


def _naming(by: ByStratum, clear: Sequence[Pair]) -> list[Figure]:
    both = [(f, a) for f, a in by["pair"] if least_part(f, a) >= CLEAR]
    covered = [*by["none"], *clear, *both]
    return [
        share("top-1 by ambiguity group, d' >= 5", [top(f, a) for f, a in clear], (0.95, INFINITY)),
        share("top-1 by ambiguity group, all", [top(f, a) for f, a in by["single"]], (0.85, INFINITY)),
        share("of these at d' >= 3", [d_prime(f, a) >= SEEN for f, a in by["single"]]),
        share("right, or silent where d' < 3", [top(f, a) or _rightly_silent(f, a) for f, a in by["single"]]),
        share("pairs, both right, d' of each >= 5", [top(f, a) for f, a in both], (0.85, INFINITY)),
        share("pairs, both right, all", [top(f, a) for f, a in by["pair"]], (0.85, INFINITY)),
        share(
            "95 % set: coverage",
            [any(is_right(g, names_of(a)) for g in f["credible"]) for f, a in covered],
            (0.93, 0.99),
        ),
        statistic("95 % set: size", [len(f["credible"]) for f, _ in covered], must=(-INFINITY, 1.6)),
        share("exactly confounded effects named together", [all_confounded(f) for f, _ in clear], (1.0, INFINITY)),
    ]


def _is_named(found: Found) -> bool:
    """Return whether the first cause names effects of the library, at 0.95 or more."""
    first = found["which"][0]
    return first["probability"] >= STATED and bool(first["effects"]) and first["effects"] != ["unknown"]


def _rightly_silent(found: Found, answer: Key) -> bool:
    return d_prime(found, answer) < SEEN and not found["which"][0]["effects"]


def _alarms(by: ByStratum) -> list[Figure]:
    def alarms(part: Iterable[Pair]) -> list[bool]:
        return [bool(f["which"][0]["effects"]) for f, _ in part]

    of = {kind: [(f, a) for f, a in by["noise"] if a["case"]["noise"] == kind] for kind in _NAMED}
    other = [pair for kind, part in of.items() if kind != "AR(1) 0.3" for pair in part]
    return [
        share("false alarm, white noise", alarms(by["none"]), (-INFINITY, 0.02)),
        share("false alarm, correlated noise", alarms(of["AR(1) 0.3"]), (-INFINITY, 0.05)),
        share("false alarm, heavy, heteroscedastic or quantised noise", alarms(other)),
        share("noise named", [_NAMED[a["case"]["noise"]] in f["findings"] for f, a in by["noise"]]),
        share("stuck or clipped channel named", [_channel_named(f, a) for f, a in by["channel"]]),
    ]


_NAMED = {
    "AR(1) 0.3": "correlated_noise", "heavy": "heavy_tailed_noise", "heteroscedastic": "heteroscedastic_noise",
    "quantised": "quantisation",
}  # fmt: skip


def _channel_named(found: Found, answer: Key) -> bool:
    truth = answer["case"]["truths"][0]
    return "clipping" in found["findings"] if truth["name"] == "clipping" else truth["place"] in found["stuck"]


def _beliefs(by: ByStratum, clear: Sequence[Pair]) -> list[Figure]:
    outside = [f["unknown_probability"] for f, a in by["outside"] if d_prime(f, a) > SEEN]
    apart = [(f, a) for f, a in by["outside"] if least_part(f, a) >= CLEAR]
    usual = [f["unknown_probability"] for s in ("none", "single", "pair") for f, _ in by[s]]
    told = [(f, a) for s in PRIOR for f, a in by[s]]
    stated = [f["which"][0]["probability"] for f, _ in told]
    seen = [not names_of(a) or least_part(f, a) >= SEEN for f, a in told]
    named = [(f, a) for s in by if s != "channel" for f, a in by[s] if _is_named(f)]
    return [
        area("outside the library, AUROC (d' > 3)", outside, usual, (0.95, INFINITY)),
        area(
            "these, d' >= 5 from every effect of the library",
            [f["unknown_probability"] for f, _ in apart],
            usual,
            (0.95, INFINITY),
        ),
        share("these, called unexplained", ["unknown" in f["which"][0]["effects"] for f, _ in apart], (0.90, INFINITY)),
        statistic(
            "mean probability on the true group, d' >= 5",
            [right_probability(f, names_of(a)) for f, a in clear],
            must=(0.90, INFINITY),
        ),
        share("causes stated at 0.95 and more, wrong", [not top(f, a) for f, a in named]),
        share(
            "of those with each part at d' >= 5, wrong",
            [not top(f, a) for f, a in named if not names_of(a) or least_part(f, a) >= CLEAR],
        ),
        share("90 % interval coverage of the size", [size_held(f, a) for f, a in by["single"]], (0.86, 0.94)),
        calibration(
            "expected calibration error, strata as probable as the diagnosis takes them",
            stated,
            [top(f, a) for f, a in told],
            [PRIOR[s] / len(by[s]) for s in PRIOR for _ in by[s]],
            (-INFINITY, 0.05),
        ),
        calibration(
            "expected calibration error, none and d' >= 3 as they were drawn",
            [p for p, is_seen in zip(stated, seen, strict=True) if is_seen],
            [top(f, a) for (f, a), is_seen in zip(told, seen, strict=True) if is_seen],
            must=(-INFINITY, 0.05),
        ),
    ]


def _closing(by: ByStratum, clear: Sequence[Pair]) -> list[Figure]:
    places = [localised(f, a) for f, a in by["single"]]
    shares = [closed(f, a) for f, a in clear]
    return [
        statistic("closed on a held-out load, median", shares, np.median, (0.95, INFINITY)),
        statistic("closed on a held-out load, 10th percentile", shares, tenth, (0.80, INFINITY)),
        statistic("localisation precision (> 4 sigma)", [p[0] for p in places if p], must=(0.95, INFINITY)),
        statistic("localisation recall (> 4 sigma)", [p[1] for p in places if p], must=(0.95, INFINITY)),
    ]


def size_held(found: Found, answer: Key) -> bool | None:
    """Return whether the interval of the first cause holds the true size; None unless name, place and unit agree."""
    truth = answer["case"]["truths"][0]
    parameters = found["which"][0]["parameters"]
    if len(parameters) != 1 or truth["name"] not in SAME_UNIT or parameters[0]["effect"] != truth["name"]:
        return None
    if truth["name"] in ONE_GAUGE and parameters[0]["place"] != truth["place"]:
        return None
    return parameters[0]["low"] <= truth["size"] <= parameters[0]["high"]


def closed(found: Found, answer: Key) -> float | None:
    """Return the share of the squared change at the held load that the correction takes away (an oracle: 1)."""
    truth, correction = np.array(answer["held_change"]), np.array(found["correction"])
    if len(correction) != len(truth):
        return None
    before = float(truth @ truth)
    return 1.0 - float((truth - correction) @ (truth - correction)) / before if before > 0 else None


def localised(found: Found, answer: Key) -> tuple[float, float] | None:
    """Return precision and recall of significant entries against those that the truth moves by more than 4 sigma.

    None where nothing moves so far or the state is unknown.
    """
    if not answer["case"]["is_known"]:
        return None
    strain = np.array(answer["strain"])
    z: dict[str, float] = {}
    for cell, moved in answer["entries"].items():
        load = float(cell.split()[-1])
        sd = np.sqrt(_variance(strain, load, found["calibrated"]))
        z.update({f"{g}, {cell}": abs(v) for g, v in zip(answer["gauges"], np.array(moved) / sd, strict=True)})
    flagged = set(found["significant"])
    large = {name for name, value in z.items() if value > LARGE}
    if not large:
        return None
    hits = sum(z.get(name, 0.0) > 0.5 for name in flagged)
    return hits / len(flagged) if flagged else 0.0, sum(name in flagged for name in large) / len(large)


def _variance(strain: FloatArray, load: float, is_calibrated: bool) -> FloatArray:
    """Return the variance (n_gauges,) of a mean reading less the model's: noise, and what the model is good for."""
    noise = VARIANCE / REPEATS
    if is_calibrated:
        return np.full(len(strain), noise * (1.0 + load**2 / sum(other**2 for other in ALL_LOADS)))
    return noise + (load * OWN * strain) ** 2 * 2.0 + (load * LEAST) ** 2 * np.mean(strain**2)


def strata(cases: Sequence[Pair]) -> list[Figure]:
    """Return top-1 of single effects by d', by kind of state and by number of loads."""
    single = [(f, a) for f, a in cases if a["case"]["stratum"].startswith("single")]
    rows = []
    for low, high in pairwise((0, 3, 5, 10, 30, np.inf)):
        part = [(f, a) for f, a in single if low <= d_prime(f, a) < high]
        rows.append(share(f"top-1 of single effects, d' {low:g} to {high:g}", [top(f, a) for f, a in part]))
    clear = [(f, a) for f, a in single if d_prime(f, a) >= CLEAR]
    for name in ("single", "single, damaged", "single, unknown state"):
        words = {"single": "healthy", "single, damaged": "healthy and damaged"}.get(name, "unknown")
        hits = [top(f, a) for f, a in clear if a["case"]["stratum"] == name]
        rows.append(share(f"top-1, d' >= 5, {words} state", hits))
    for number in (4, 3, 2, 1):
        hits = [top(f, a) for f, a in clear if len(a["case"]["loads"]) == number]
        rows.append(share(f"top-1, d' >= 5, {number} load{'s' * (number > 1)}", hits))
    return rows


def by_effect(cases: Sequence[Pair]) -> list[Figure]:
    """Return top-1 of single effects with d' >= 5 for each true name."""
    clear = [(f, a) for f, a in cases if a["case"]["stratum"].startswith("single") and d_prime(f, a) >= CLEAR]
    names = sorted({names_of(a)[0] for _, a in clear})
    return [share(name, [top(f, a) for f, a in clear if names_of(a) == [name]]) for name in names]
