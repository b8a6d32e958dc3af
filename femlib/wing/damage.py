"""Effective damage regions: patches of skin whose stiffness falls by the factor 1 - mu."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.errors import InputError, is_number

SURFACES = ("top", "bottom", "web")


@dataclass(frozen=True, slots=True)
class DamageRegion:
    """A rectangle in span and chord fractions on a skin, or a length of the spar web.

    Attributes
    ----------
    name : str
        Name of the region, "R1".
    parameter : str
        Name of its damage parameter in a state, "mu1".
    eta_min, eta_max, chord_min, chord_max : float
        Edges as span and chord fractions; the mesh has grid lines there. The web has no chord: its edges are 0 and 1.
    surface : str
        "top", "bottom" or "web".
    """

    name: str
    parameter: str
    eta_min: float
    eta_max: float
    chord_min: float
    chord_max: float
    surface: str = "top"

    def __post_init__(self) -> None:
        if self.surface not in SURFACES:
            raise InputError(
                f"damage region {self.name} is on {self.surface!r}; expected one of {list(SURFACES)}; correct it"
            )
        edges = (self.eta_min, self.eta_max, self.chord_min, self.chord_max)
        if not all(map(is_number, edges)) or not self._is_on_the_wing():
            raise InputError(
                f"damage region {self.name} has eta {self.eta_min} to {self.eta_max} and x/c {self.chord_min} to "
                f"{self.chord_max}; expected increasing edges between 0 and 1; move it onto the wing"
            )

    def _is_on_the_wing(self) -> bool:
        return 0.0 <= self.eta_min < self.eta_max <= 1.0 and 0.0 <= self.chord_min < self.chord_max <= 1.0

    def contains(self, eta: FloatArray, chord: FloatArray) -> BoolArray:
        """Return whether points lie inside or on the edge."""
        within = (self.eta_min <= eta) & (eta <= self.eta_max)
        return np.asarray(within & (self.chord_min <= chord) & (chord <= self.chord_max))


def checked_regions(regions: Sequence[DamageRegion]) -> tuple[DamageRegion, ...]:
    """Return regions as a tuple after checking that names and parameters are each their own.

    Raises
    ------
    InputError
        If it is no list of regions, or two share a name or a parameter, or one is called as a part of the wing.
    """
    if not isinstance(regions, Sequence) or not all(isinstance(region, DamageRegion) for region in regions):
        raise InputError(f"regions are {regions!r}; expected a list of DamageRegion; put it in a list")
    for what in ("name", "parameter"):
        words = [getattr(region, what) for region in regions]
        double = sorted({word for word in words if words.count(word) > 1})
        if double:
            raise InputError(f"damage regions share the {what} {double}; expected a different one for each; rename one")
    taken = sorted({region.name for region in regions} & {*SURFACES, "ribs"})
    if taken:
        raise InputError(f"damage regions are called {taken}, as parts of the wing are; expected others; rename them")
    return tuple(regions)


_BAYS = ((1 / 12, 2 / 12), (3 / 12, 4 / 12), (5 / 12, 6 / 12), (8 / 12, 9 / 12), (11 / 12, 1.0))
"""Span fractions of five rib bays, apart from one another so that each region is a component of its own."""
_REAR, _NOSE, _FORE, _AFT, _TAIL, _ALL = (0.43, 0.55), (0.0, 0.12), (0.12, 0.24), (0.345, 0.55), (0.75, 1.0), (0.0, 1.0)

UAV_REGIONS = (
    DamageRegion("R1", "mu1", *_BAYS[1], 0.31, 0.74),
    DamageRegion("R2", "mu2", *_BAYS[3], 0.40, 0.57),
)
"""The two regions of the study: rib bays of the top skin aft of the spar. Edges along the chord fitted."""
TAPERED_REGIONS = (
    DamageRegion("R1", "mu1", 0.24, 0.39, 0.345, 0.55),
    DamageRegion("R2", "mu2", 0.67, 0.83, 0.345, 0.43),
)
"""The same for `tapered_wing`: freely placed, all edges fitted."""


def damage_library() -> tuple[DamageRegion, ...]:
    """Return the 28 regions R1 to R28 with parameters mu1 to mu28: the study's two, then 26 over skins and web.

    The published library has 28 effective regions over the airframe; their places were not published. These are
    assumed: five rib bays of the top skin's nose, aft and tail strips, of the bottom skin's fore and aft strips, and
    of the web.
    """
    return library_of(UAV_REGIONS, _BAYS)


def library_of(study: tuple[DamageRegion, ...], bays: tuple[tuple[float, float], ...]) -> tuple[DamageRegion, ...]:
    """Return 28 regions: the study's two, then strips over five bays (span fractions)."""
    top = [("top", _REAR, bay) for bay in (bays[0], bays[2], bays[4])]
    top += [("top", _NOSE, bay) for bay in bays] + [("top", _TAIL, bay) for bay in (bays[1], bays[2], bays[3])]
    bottom = [("bottom", strip, bay) for strip in (_FORE, _AFT) for bay in bays]
    web = [("web", _ALL, bay) for bay in bays]
    more = [
        DamageRegion(f"R{number}", f"mu{number}", *bay, *strip, surface)
        for number, (surface, strip, bay) in enumerate([*top, *bottom, *web], start=len(study) + 1)
    ]
    return (*study, *more)
