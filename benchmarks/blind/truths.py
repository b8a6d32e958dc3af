"""What may be wrong with an asset: each truth draws itself, and changes the mean readings of a case."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Truth:
    """One drawn effect.

    Attributes:
        name: in the list of names that diagnosis and scorer share; "outside" for what is in no library.
        size: in the unit of that list.
        place: a gauge, a pair, a zone.
    """

    name: str
    size: float
    place: str = ""
    extra: dict = field(default_factory=dict)


SCALES = {
    "modulus": 2.0, "skin_thickness": 3.0, "temperature_uniform": 8.0, "temperature_gradient": 6.0,
    "lift_distribution": 4.0, "payload_inertia": 0.3, "damage_outside_library": 25.0, "gauge_gain": 3.0,
    "gauge_bias": 25.0, "gauge_drift": 80.0, "load_factor_error": 1.5, "common_gain": 1.2,
}  # fmt: skip
ONE_SIDED = {"payload_inertia", "damage_outside_library", "misalignment"}
FACTS = ("swapped_pair", "dead_gauge")
OUTSIDE = ("hot_spot", "quadratic_gauges", "rib_field", "patchy_gain", "hysteresis")
SINGLES = (*SCALES, *FACTS, "misalignment")


def draw(name, rng, asset):
    """Return a truth of this name, its size log-uniform between 0.3 and 3 of its scale."""
    factor = float(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))
    sign = 1.0 if name in ONE_SIDED else float(rng.choice([-1.0, 1.0]))
    gauge = str(rng.choice(asset.gauges))
    if name == "payload_inertia":
        return Truth(name, factor * SCALES[name], f"{rng.uniform(0.4, 0.95):.3f}")
    if name == "damage_outside_library":
        return Truth(name, factor * SCALES[name], f"{rng.uniform(0.28, 0.74):.3f}:{rng.choice([0.2, 0.4, 0.6])}")
    if name == "swapped_pair":
        a, b = rng.choice(len(asset.gauges), 2, replace=False)
        return Truth(name, 1.0, f"{asset.gauges[min(a, b)]}/{asset.gauges[max(a, b)]}")
    if name == "dead_gauge":
        return Truth(name, 1.0, gauge)
    if name == "misalignment":
        return Truth(name, factor * 4.0, gauge)  # degrees; its loss is what counts
    if name.startswith("gauge"):
        return Truth(name, sign * factor * SCALES[name], gauge)
    return Truth(name, sign * factor * SCALES[name])


def draw_outside(rng, asset):
    """Return a truth that no library holds."""
    kind = str(rng.choice(OUTSIDE))
    factor = float(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))
    return Truth("outside", factor, kind, {"seed": int(rng.integers(2**31)), "centre": float(rng.uniform(0.3, 0.7))})


def change(truth, asset, state, load, time, before):
    """Return what a truth adds to mean readings `before` (n_gauges,) at a state, load factor and time [s]."""
    name, size = truth.name, truth.size
    zero = np.zeros(len(asset.gauges))
    if name == "modulus":
        return before / (1.0 + 0.01 * size) - before
    if name in ("common_gain", "load_factor_error"):
        return 0.01 * size * (before if name == "common_gain" else load * asset.strain(state))
    if name in ("temperature_uniform", "temperature_gradient"):
        return size * asset.field(name, state)
    if name in ("lift_distribution", "skin_thickness"):
        return size * load * asset.field(name, state)
    if name in ("payload_inertia", "damage_outside_library"):
        return size * load * asset.field(f"{name}:{truth.place}", state)
    if name == "swapped_pair":
        a, b = (asset.gauges.index(g) for g in truth.place.split("/"))
        zero[a], zero[b] = before[b] - before[a], before[a] - before[b]
        return zero
    if name == "outside":
        return _outside(truth, asset, state, load, before)
    g = asset.gauges.index(truth.place)
    turned = 1.0 - 1.33 * np.sin(np.radians(size)) ** 2
    zero[g] = {
        "gauge_gain": 0.01 * size * before[g],
        "gauge_bias": size,
        "gauge_drift": size * time / 3600.0,
        "dead_gauge": -before[g],
        "misalignment": (turned - 1.0) * before[g],
    }[name]
    return zero


def _outside(truth, asset, state, load, before):
    rng = np.random.default_rng(truth.extra["seed"])
    size, n = truth.size, len(asset.gauges)
    if truth.place == "hot_spot":
        return 12.0 * size * asset.field(f"hot_spot:{truth.extra['centre']:.2f}", state)
    if truth.place == "quadratic_gauges":
        return size * 25.0 * (before / 2000.0) ** 2 * rng.choice([-1.0, 1.0])
    if truth.place == "rib_field":
        return size * 15.0 * load / 3.0 * np.sin(2 * np.pi * asset.eta * 12.0 + rng.uniform(0, 6.28))
    if truth.place == "patchy_gain":
        return before * size * 0.02 * rng.standard_normal(n) * (rng.random(n) < 0.6)
    return size * 15.0 * np.sqrt(np.abs(load) / 3.0) * np.sign(rng.standard_normal(n))  # hysteresis


def parts(names):
    """Return the names in the order of action: the structure first, then the load, then the chain."""
    chain = {"gauge_gain", "gauge_bias", "gauge_drift", "misalignment", "swapped_pair", "dead_gauge", "common_gain"}
    return sorted(names, key=lambda truth: (truth.name in chain, truth.name in FACTS))
