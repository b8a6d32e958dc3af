"""Every change that the generator may draw for an asset, with its size's prior."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.assets.asset import Asset
from benchmarks.blind.truths import DISCRETE, FLAWS, ONE_SIDED, SCALES, SINGLES, Truth

LEAST, MOST = 0.3, 3.0
ROUNDED = ("buckled_panel", "loose_rib", "slack_joint")
"""Kinds from outside that do not grow with the size: tried at sizes of their own, each free to scale by a little."""
PATTERNS = ("quadratic_gauges", "patchy_gain", "hysteresis")
"""Kinds from outside with a weight of its own for each gauge."""
VARIANTS = 12


@dataclass(frozen=True)
class Candidate:
    """A change with its size still open.

    Attributes
    ----------
    truth
        the change at the size that its signature is taken at.
    scale
        size of one unit of the columns, in the truth's own unit.
    least, most
        of the size's amount, in units of the columns.
    is_signed
        whether it may be negative.
    log_prior
        of name and place, within its kind of case.
    """

    truth: Truth
    scale: float
    least: float
    most: float
    is_signed: bool
    log_prior: float

    def at(self, size: float) -> Truth:
        """Return the truth of a size in units of the columns."""
        return Truth(self.truth.name, self.scale * size, self.truth.place, self.truth.extra)


def singles(asset: Asset) -> list[Candidate]:
    """Return the effects that the library holds too: names alike, then the places of each."""
    names = [name for name in SINGLES if asset.n_places.get(name) != 0]
    found = []
    for name in names:
        places = list(_places(name, asset))
        prior = float(-np.log(len(names)) - np.log(len(places)))
        found += [_single(name, place, size, prior) for place, size in places]
    return found


def _single(name: str, place: str, size: float, prior: float) -> Candidate:
    if name in FLAWS or name in DISCRETE:
        return Candidate(Truth(name, size, place), size, 1.0, 1.0, False, prior)
    return Candidate(Truth(name, SCALES[name], place), SCALES[name], LEAST, MOST, name not in ONE_SIDED, prior)


def _places(name: str, asset: Asset) -> Iterator[tuple[str, float]]:
    """Return places and, where it is drawn with the place, sizes."""
    gauges = asset.gauges
    if name in FLAWS:
        yield from ((flaw.place, flaw.size) for flaw in asset.flaws if flaw.name == name)
    elif name == "swapped_pair":
        yield from ((f"{a}/{b}", 1.0) for k, a in enumerate(gauges) for b in gauges[k + 1 :])
    elif name == "crosstalk":
        pairs = [(k, j) for k in range(len(gauges)) for j in (k - 1, k + 1) if 0 <= j < len(gauges)]
        yield from ((f"{gauges[k]}<{gauges[j]}", 1.0) for k, j in pairs)
    elif name == "lift_distribution":
        yield from ((lift, 1.0) for lift in asset.lifts)
    elif name == "payload_inertia":
        yield from ((mass, 1.0) for mass in asset.payloads)
    elif name.startswith("gauge") or name in ("misalignment", "position_offset", "dead_gauge"):
        yield from ((gauge, 1.0) for gauge in gauges)
    else:
        yield "", 1.0


def outside(kind: str, asset: Asset) -> list[Candidate]:
    """Return variants of a kind from outside the library that has a shape, not a weight for each gauge."""
    spots: Sequence[str] = asset.hot_spots if kind in ("hot_spot", "passing_sun") and asset.hot_spots else [""]
    seeds = range(VARIANTS) if kind in ("rib_field", "buckled_panel", "loose_rib") else range(1)
    sizes = np.geomspace(LEAST, MOST, 8).tolist() if kind in ROUNDED else [1.0]
    made = [Truth("outside", size, kind, {"seed": s, "spot": p}) for s in seeds for p in spots for size in sizes]
    prior = float(-np.log(len(asset.outside)) - np.log(len(made)))
    low, high = (0.85, 1.18) if kind in ROUNDED else (LEAST, MOST)
    return [Candidate(truth, truth.size, low, high, kind not in ROUNDED, prior) for truth in made]
