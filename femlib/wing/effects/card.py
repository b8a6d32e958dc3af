"""Base of the effects of the wing: the card that a diagnosis reads, and gauge strains from nodal forces.

Near the twin every structural effect acts like extra nodal forces f per unit of its size: thermal and inertial
effects by their own forces, a change of stiffness dK by f = -dK u (first order, u the twin's displacements). The
signature is then

    rows K(mu)^-1 f     [microstrain per unit].

A force is the same in every state, and solved once for all of them.

Source of the first-order step: R. T. Haftka and Z. Guerdal, Elements of Structural Optimization (1992), section 7.2.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from femlib.arrays import FloatArray
from femlib.wing.effects.response import Response

Force = Callable[[str], FloatArray]
"""From a place to nodal forces (n_dofs,) [N, N m] per unit of size at load factor 1."""
Strains = Callable[[Mapping[str, float], float, str, float], FloatArray]
"""From state, load factor, place and time to the change of the gauge strains (n_gauges,) [microstrain] per unit."""


@dataclass(frozen=True, slots=True, eq=False)
class WingEffect:
    """An effect that a real wing may have and the model lacks.

    Attributes
    ----------
    name, parameter, unit : str
        Name in snake_case, what the size measures, its unit.
    prior_sd : float
        Scale of the size before any data, in `unit`.
    prior_source : str
        Why this scale.
    separated_by : str
        What separates the effect from its nearest confounder.
    load_power : int or None
        The signature is proportional to load_factor**load_power; None where it is no single power.
    strains : callable
        The signature.
    place_names : tuple of str
        Where it may act; ("",) for the whole.
    is_one_sided : bool
        Whether the size cannot be negative.
    prior_mean : float
        Expected size, in `unit`.
    uses_time : bool
        Whether the signature depends on the time since the start of the campaign.
    superposes : bool
        Whether the answers to steps of the load add up, each from its own time on (Boltzmann's principle).
    signature_error : float
        Relative sd of the signature at each gauge: two meshes or codes differ by some parts in a hundred.
    n_between : int
        Number of places next to one between which the effect may lie, where places sample a continuum (a span, shapes
        of a distribution); 0 where each place is its own.
    bounds : tuple of float
        Lowest and highest size that is possible, in `unit`.
    seen_by : tuple of str
        Quantities beside strain under load that show it, as a diagnosis names them.
    words, words_at, action : str
        What an engineer calls it, the same with its {place}, and what to do about it.
    says : tuple of str
        What a positive and a negative size mean, {size} for the size.
    """

    name: str
    parameter: str
    unit: str
    prior_sd: float
    prior_source: str
    separated_by: str
    load_power: int | None
    strains: Strains
    place_names: tuple[str, ...] = ("",)
    is_one_sided: bool = False
    prior_mean: float = 0.0
    uses_time: bool = False
    superposes: bool = False
    signature_error: float = 0.1
    n_between: int = 0
    bounds: tuple[float, float] = (-math.inf, math.inf)
    seen_by: tuple[str, ...] = ()
    words: str = ""
    words_at: str = ""
    action: str = ""
    says: tuple[str, str] = ("", "")

    def places(self, twin: Any) -> tuple[str, ...]:
        """Return the places where the effect may act."""
        return self.place_names

    def signature(
        self, twin: Any, state: Mapping[str, float], load_factor: float, place: str = "", time: float = 0.0
    ) -> FloatArray:
        """Return the change of the gauge strains (n_gauges,) in microstrain per unit of size."""
        return self.strains(state, load_factor, place, time)


def strains_of(response: Response, name: str, force: Force) -> Strains:
    """Return the signature of an effect of a name that acts like forces in proportion to the load."""
    return lambda state, load_factor, place, time: (
        load_factor * response.strains_of_fixed(state, name, place, force(place))
    )
