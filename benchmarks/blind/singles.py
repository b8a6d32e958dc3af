"""Every single effect of the library as an asset shows it, at its typical size."""

from collections.abc import Iterator

from benchmarks.blind.assets.asset import Asset
from benchmarks.blind.truths import FLAWS, SCALES, SINGLES, Truth


def singles(asset: Asset) -> list[Truth]:
    """Return the effects that the library holds too, each at all its places."""
    names = [name for name in SINGLES if asset.n_places.get(name) != 0]
    return [Truth(name, size, place) for name in names for place, size in _places(name, asset)]


def _places(name: str, asset: Asset) -> Iterator[tuple[str, float]]:
    """Return places, with the size of a flaw or what is typical of other effects."""
    gauges, size = asset.gauges, SCALES.get(name, 1.0)
    if name in FLAWS:
        yield from ((flaw.place, flaw.size) for flaw in asset.flaws if flaw.name == name)
    elif name == "swapped_pair":
        yield from ((f"{a}/{b}", size) for k, a in enumerate(gauges) for b in gauges[k + 1 :])
    elif name == "crosstalk":
        pairs = [(k, j) for k in range(len(gauges)) for j in (k - 1, k + 1) if 0 <= j < len(gauges)]
        yield from ((f"{gauges[k]}<{gauges[j]}", size) for k, j in pairs)
    elif name == "lift_distribution":
        yield from ((lift, size) for lift in asset.lifts)
    elif name == "payload_inertia":
        yield from ((mass, size) for mass in asset.payloads)
    elif name.startswith("gauge") or name in ("misalignment", "position_offset", "dead_gauge"):
        yield from ((gauge, size) for gauge in gauges)
    else:
        yield "", size
