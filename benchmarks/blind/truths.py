"""Truths, the things that may be wrong with an asset: each draws its name, size and place."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TypedDict

import numpy as np

from benchmarks.blind.assets.asset import Asset, log_uniform


class Extra(TypedDict, total=False):
    """Further data of a change outside the library: the seed of its own draws."""

    seed: int


@dataclass(frozen=True)
class Truth:
    """One drawn effect.

    Attributes
    ----------
    name
        in the list of names that diagnosis and scorer share; "outside" for what is in no library.
    size
        in the unit of that list.
    place
        a gauge, a pair, a zone, a lift shape; the kind of what is outside.
    extra
        what else the change needs.
    """

    name: str
    size: float
    place: str = ""
    extra: Extra = field(default_factory=Extra)


SCALES = {
    "modulus": 2.0, "skin_thickness": 3.0, "temperature_uniform": 8.0, "temperature_gradient": 6.0,
    "lift_distribution": 4.0, "torsion": 5.0, "payload_inertia": 0.3, "large_deflection": 1.0, "creep": 2.0,
    "planform": 1.0, "gauge_gain": 3.0, "gauge_bias": 25.0, "gauge_drift": 80.0, "misalignment": 1.0,
    "position_offset": 3.0, "crosstalk": 1.2, "load_factor_error": 1.5, "common_gain": 1.2,
}  # fmt: skip
"""Typical sizes; drawn between 0.3 and 3 times these."""
ONE_SIDED = {"payload_inertia", "large_deflection", "creep", "misalignment"}
FLAWS = ("damage_outside_library", "spar_skin_debond")
DISCRETE = ("swapped_pair", "dead_gauge")
TRACELESS = "root_flexibility"
SINGLES = (*SCALES, *FLAWS, *DISCRETE)
CHANNEL = ("stuck_gauge", "clipping")
"""Faults of a channel that show in the noise, not effects with a size."""
CHAIN = {
    "gauge_gain", "gauge_bias", "gauge_drift", "misalignment", "position_offset", "crosstalk", "common_gain", *DISCRETE
}  # fmt: skip


def draw(name: str, rng: np.random.Generator, asset: Asset) -> Truth:
    """Return a truth of this name, its size log-uniform between 0.3 and 3 of its scale."""
    if name in FLAWS:
        flaw = [f for f in asset.flaws if f.name == name][int(rng.integers(asset.n_places[name]))]
        return Truth(name, flaw.size, flaw.place)
    place = _place(name, rng, asset)
    if name in DISCRETE:
        return Truth(name, 1.0, place)
    sign = 1.0 if name in ONE_SIDED else float(rng.choice([-1.0, 1.0]))
    return Truth(name, sign * log_uniform(rng) * SCALES[name], place)


def _place(name: str, rng: np.random.Generator, asset: Asset) -> str:
    if name == "lift_distribution":
        return str(rng.choice(asset.lifts))
    if name == "payload_inertia":
        return str(rng.choice(asset.payloads))
    gauge = int(rng.integers(len(asset.gauges)))
    if name == "swapped_pair":
        a, b = sorted(rng.choice(len(asset.gauges), 2, replace=False))
        return f"{asset.gauges[a]}/{asset.gauges[b]}"
    if name == "crosstalk":
        source = gauge + 1 if gauge == 0 or (gauge + 1 < len(asset.gauges) and rng.random() < 0.5) else gauge - 1
        return f"{asset.gauges[gauge]}<{asset.gauges[source]}"
    one_gauge = name.startswith("gauge") or name in ("misalignment", "position_offset", "dead_gauge")
    return asset.gauges[gauge] if one_gauge else ""


def draw_outside(rng: np.random.Generator, asset: Asset) -> Truth:
    """Return a truth that no library holds, of a kind that its family has."""
    kind = str(rng.choice(asset.outside))
    size = log_uniform(rng) * float(rng.choice([-1.0, 1.0]))
    seed = int(rng.integers(2**31))
    return Truth("outside", size, kind, {"seed": seed})


def draw_channel(rng: np.random.Generator, asset: Asset) -> Truth:
    """Return a fault of a channel."""
    kind = str(rng.choice(CHANNEL))
    return Truth(kind, float(rng.uniform(0.7, 0.9)) if kind == "clipping" else 1.0, str(rng.choice(asset.gauges)))


def in_order(truths: Iterable[Truth]) -> list[Truth]:
    """Return the truths in the order of action: the structure first, then the load, then the measuring chain."""
    return sorted(truths, key=lambda truth: (truth.name in CHAIN, truth.name in DISCRETE))
