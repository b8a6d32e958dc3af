"""Score diagnoses against the opened keys; every figure with its interval and its number of cases."""

import json
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import beta

from benchmarks.blind.cases import fingerprint

CLEAR = 5.0
SAME_UNIT = {
    "modulus", "temperature_uniform", "gauge_gain", "gauge_bias", "gauge_drift", "load_factor_error", "common_gain",
    "payload_inertia", "skin_thickness",
}  # fmt: skip
"""Effects whose size means the same in key and diagnosis."""


@dataclass(frozen=True)
class Figure:
    """One row of the table: a share or mean with a 95 % interval."""

    name: str
    value: float
    low: float
    high: float
    n: int

    def words(self):
        """Return the row's numbers."""
        if not self.n:
            return "-"
        return f"{self.value:.3f} ({self.low:.3f}-{self.high:.3f}), n = {self.n}"


def share(name, hits):
    """Return a share with its exact binomial interval (Clopper and Pearson (1934), Biometrika 26)."""
    hits = np.asarray(list(hits), dtype=bool)
    k, n = int(hits.sum()), len(hits)
    if n == 0:
        return Figure(name, np.nan, np.nan, np.nan, 0)
    low = float(beta.ppf(0.025, k, n - k + 1)) if k else 0.0
    high = float(beta.ppf(0.975, k + 1, n - k)) if k < n else 1.0
    return Figure(name, k / n, low, high, n)


def statistic(name, values, take=np.mean, seed=0):
    """Return a statistic with its bootstrap interval."""
    values = np.asarray([v for v in values if v is not None and np.isfinite(v)], dtype=float)
    if not len(values):
        return Figure(name, np.nan, np.nan, np.nan, 0)
    rng = np.random.default_rng(seed)
    draws = [take(values[rng.integers(len(values), size=len(values))]) for _ in range(1000)]
    return Figure(name, float(take(values)), *np.quantile(draws, [0.025, 0.975]).tolist(), len(values))


def open_keys(folder, keys):
    """Return the answers by case after checking each against its seal."""
    answers = json.loads(keys.read_text())
    seals = json.loads((folder / "seals.json").read_text())
    broken = [name for name, answer in answers.items() if fingerprint(answer) != seals.get(name)]
    if broken:
        raise SystemExit(f"{len(broken)} answers do not match their seals, first {broken[0]}: the keys were changed")
    return answers


def names_of(answer):
    """Return the sorted true names."""
    return sorted(truth["name"] for truth in answer["case"]["truths"])


def is_right(groups, truth):
    """Return whether groups of names that cannot be told apart hold the true names one by one."""
    if len(groups) != len(truth):
        return False
    if not groups:
        return True
    first, rest = truth[0], truth[1:]
    return any(first in group and is_right(groups[:k] + groups[k + 1 :], rest) for k, group in enumerate(groups))


def right_probability(found, truth):
    """Return the probability of the causes that hold the truth."""
    return sum(c["probability"] for c, g in zip(found["which"], found["names"], strict=True) if is_right(g, truth))


def figures(found, answers):
    """Return the table of gap.md for diagnoses (a list) and opened keys."""
    cases = [(f, answers[f["name"]]) for f in found]
    by = {
        s: [(f, a) for f, a in cases if a["case"]["stratum"].startswith(s)]
        for s in ("none", "noise", "single", "pair", "outside")
    }
    single, pair = by["single"], by["pair"]
    clear = [(f, a) for f, a in single if a["d_prime"] >= CLEAR]
    covered = [(f, a) for f, a in single + pair + by["none"] if a["d_prime"] >= CLEAR or not a["case"]["truths"]]
    correlated = [(f, a) for f, a in by["noise"] if a["case"]["noise"] == "correlated"]
    other = [(f, a) for f, a in by["noise"] if a["case"]["noise"] != "correlated"]
    strange = [(f, a) for f, a in by["outside"] if a["d_prime"] > 3.0]
    return [
        share("top-1 by ambiguity group, d' >= 5", [top(f, a) for f, a in clear]),
        share("top-1 by ambiguity group, all", [top(f, a) for f, a in single]),
        share("pairs, both right, all", [top(f, a) for f, a in pair]),
        share("pairs, both right, d' of each part clear (inclusion)", [_both(f, a) for f, a in pair]),
        share("95 % set: coverage", [any(is_right(g, names_of(a)) for g in f["credible"]) for f, a in covered]),
        statistic("95 % set: size", [len(f["credible"]) for f, _ in covered]),
        share("false alarm, white noise", [bool(f["which"][0]["effects"]) for f, _ in by["none"]]),
        share("false alarm, correlated noise", [bool(f["which"][0]["effects"]) for f, _ in correlated]),
        share("false alarm, heavy or heteroscedastic noise", [bool(f["which"][0]["effects"]) for f, _ in other]),
        auroc("outside the library, AUROC (d' > 3)", strange, [c for s in ("none", "single", "pair") for c in by[s]]),
        statistic("mean probability on the true group, d' >= 5", [right_probability(f, names_of(a)) for f, a in clear]),
        share("90 % interval coverage of the size", [h for f, a in single for h in size_hits(f, a)]),
        statistic("closed on a held-out load, median", [closed(f, a) for f, a in clear], np.median),
        statistic("closed on a held-out load, 10th percentile", [closed(f, a) for f, a in clear], _tenth),
        statistic("localisation precision (> 4 sigma)", [p for f, a in single for p in localised(f, a)[:1]]),
        statistic("localisation recall (> 4 sigma)", [r for f, a in single for r in localised(f, a)[1:]]),
        calibration("expected calibration error", single + by["none"] + pair),
        statistic("CPU seconds, known state", [f["seconds"] for f, a in cases if a["case"]["is_known"]], np.median),
        statistic(
            "CPU seconds, unknown state", [f["seconds"] for f, a in cases if not a["case"]["is_known"]], np.median
        ),
    ]


def top(found, answer):
    """Return whether the first cause is the truth, up to what it says cannot be told apart."""
    return is_right(found["names"][0], names_of(answer))


def _both(found, answer):
    """Return whether both true names have an inclusion probability above one half, or a tied name has."""
    groups = [set(g) for g in found["names"][0]]
    return all(any(name in g for g in groups) for name in names_of(answer))


def _tenth(values):
    return float(np.quantile(values, 0.1))


def size_hits(found, answer):
    """Return whether the interval of the first cause holds the true size, where name, place and unit agree."""
    truth = answer["case"]["truths"][0]
    parameters = found["which"][0]["parameters"]
    if len(parameters) != 1 or truth["name"] not in SAME_UNIT or parameters[0]["effect"] != truth["name"]:
        return []
    if truth["name"].startswith("gauge") and parameters[0]["place"] != truth["place"]:
        return []
    return [parameters[0]["low"] <= truth["size"] <= parameters[0]["high"]]


def closed(found, answer):
    """Return the share of the squared change at the held load that the correction takes away (an oracle: 1)."""
    truth, correction = np.array(answer["held_change"]), np.array(found["correction"])
    before = float(truth @ truth)
    return 1.0 - float((truth - correction) @ (truth - correction)) / before if before > 0 else None


def localised(found, answer):
    """Return precision and recall of significant entries against those the truth moves by more than 4 sigma."""
    if not answer["case"]["is_known"]:
        return []
    gauges = answer["gauges"]
    moved = {
        f"{gauge}, {cell}": abs(value)
        for cell, values in answer["entries"].items()
        for gauge, value in zip(gauges, values, strict=True)
    }
    flagged = set(found["significant"])
    large = {name for name, value in moved.items() if value > 4.0}
    true_positive = sum(moved.get(name, 0.0) > 0.5 for name in flagged)
    if not large:
        return []
    return [true_positive / len(flagged) if flagged else 0.0, sum(name in flagged for name in large) / len(large)]


def auroc(name, positive, negative):
    """Return the chance that a foreign effect gets a higher unknown probability than any other case."""
    a = np.array([f["unknown_probability"] for f, _ in positive])
    b = np.array([f["unknown_probability"] for f, _ in negative])
    if not len(a) or not len(b):
        return Figure(name, np.nan, np.nan, np.nan, 0)

    def area(x, y):
        return float(np.mean((x[:, None] > y[None, :]) + 0.5 * (x[:, None] == y[None, :])))

    rng = np.random.default_rng(0)
    draws = [area(rng.choice(a, len(a)), rng.choice(b, len(b))) for _ in range(500)]
    return Figure(name, area(a, b), *np.quantile(draws, [0.025, 0.975]).tolist(), len(a))


def calibration(name, cases, bins=5):
    """Return the expected calibration error of the first cause's probability."""
    stated = np.array([f["which"][0]["probability"] for f, _ in cases])
    hits = np.array([top(f, a) for f, a in cases], dtype=float)
    if not len(stated):
        return Figure(name, np.nan, np.nan, np.nan, 0)

    def error(index):
        order = index[np.argsort(stated[index])]
        return float(
            sum(len(p) * abs(stated[p].mean() - hits[p].mean()) for p in np.array_split(order, bins)) / len(order)
        )

    rng = np.random.default_rng(0)
    draws = [error(rng.integers(len(stated), size=len(stated))) for _ in range(300)]
    return Figure(name, error(np.arange(len(stated))), *np.quantile(draws, [0.025, 0.975]).tolist(), len(stated))


def strata(found, answers, edges=(0, 3, 5, 10, 30, np.inf)):
    """Return top-1 of single effects by d'."""
    rows = []
    for low, high in pairwise(edges):
        part = [(f, answers[f["name"]]) for f in found if answers[f["name"]]["case"]["stratum"].startswith("single")]
        part = [(f, a) for f, a in part if low <= a["d_prime"] < high]
        rows.append(share(f"top-1 of single effects, d' {low:g} to {high:g}", [top(f, a) for f, a in part]))
    return rows
