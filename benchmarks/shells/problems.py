"""The standard list by name: problems by elements a side, and strips by how much finer than the published mesh."""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import product

from benchmarks.shells.case import Case
from benchmarks.shells.curved import SLANT, pinched_cylinder, pinched_hemisphere, scordelis_lo_roof
from benchmarks.shells.plates import cook_membrane, morley_skew_plate, pagano_plate, razzaque_skew_plate, square_plate
from benchmarks.shells.strips import curved_beam, raasch_hook, twisted_beam

Problem = Callable[[int], Case]

CONVERGING: Mapping[str, Problem] = {
    "Scordelis-Lo roof": scordelis_lo_roof,
    "the same on a slanted mesh": lambda n: scordelis_lo_roof(n, SLANT),
    "pinched cylinder": pinched_cylinder,
    "pinched hemisphere": pinched_hemisphere,
    "Morley skew plate": morley_skew_plate,
    "Razzaque skew plate": razzaque_skew_plate,
    "Cook's membrane": cook_membrane,
    "square plate, simply supported": lambda n: square_plate(n, False),
    "square plate, clamped": lambda n: square_plate(n, True),
}
"""By elements a side."""
LAMINATED: Mapping[str, Problem] = {
    f"Pagano [0/90/90/0], a/h {slenderness}": partial(pagano_plate, slenderness=slenderness)
    for slenderness in (4, 10, 20, 100)
}
"""By elements a side of the quarter."""


def _strips() -> dict[str, Problem]:
    found: dict[str, Problem] = {
        "curved beam in its plane": lambda k: curved_beam("u", 6 * k, k),
        "curved beam out of its plane": lambda k: curved_beam("w", 6 * k, k),
    }
    for thickness, direction in product((0.32, 0.0032), "vw"):
        found[f"twisted beam, t {thickness}, {direction}"] = _twisted(thickness, direction)
    return found | {"Raasch's hook": lambda k: raasch_hook(9 * k, k)}


def _twisted(thickness: float, direction: str) -> Problem:
    return lambda k: twisted_beam(thickness, direction, 12 * k, 2 * k)


STRIPS: Mapping[str, Problem] = _strips()
"""By how many times finer than 6 x 1 (curved beam), 12 x 2 (twisted beam) and 9 x 1 elements (hook)."""
