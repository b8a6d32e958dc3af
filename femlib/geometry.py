"""Lifting-surface geometry: a tapered planform about a straight spar, and NACA four-digit sections.

Axes: x aft [m] with the spar at x = 0, y outboard [m] with the root at y = 0, z up [m]. A point of the wing is named
by the span fraction eta = y / span and the chord fraction x/c from the leading edge.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from femlib.arrays import FloatArray
from femlib.errors import InputError, is_number

SHORTEST, LONGEST = 1e-3, 100.0
"""Lengths [m] of a half wing: outside them they are in another unit. The longest ever flown is 58."""


@dataclass(frozen=True, slots=True)
class Planform:
    """A half wing with linear taper, no twist, and a straight unswept spar.

    Attributes
    ----------
    span : float
        Half-span [m].
    root_chord, tip_chord : float
        Chords [m].
    spar_fraction : float
        Chord fraction of the spar, the straight line x = 0.
    """

    span: float
    root_chord: float
    tip_chord: float
    spar_fraction: float

    def __post_init__(self) -> None:
        for name in ("span", "root_chord", "tip_chord"):
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                raise InputError(f"planform {name} is {value!r} m; expected a positive length; correct it")
            if not SHORTEST <= value <= LONGEST:
                raise InputError(
                    f"planform {name} is {value!r} m; expected {SHORTEST:g} to {LONGEST:g} m; give lengths in metres"
                )
        if not is_number(self.spar_fraction) or not 0.0 < self.spar_fraction < 1.0:
            raise InputError(f"planform spar_fraction is {self.spar_fraction}; expected between 0 and 1; correct it")

    def chord(self, eta: npt.ArrayLike) -> FloatArray:
        """Return the chord [m] at span fractions `eta`."""
        return np.asarray(self.root_chord + (self.tip_chord - self.root_chord) * np.asarray(eta, dtype=np.float64))

    def position(self, eta: npt.ArrayLike, chord_fraction: npt.ArrayLike) -> FloatArray:
        """Return the points (..., 2) = (x, y) [m] at span and chord fractions."""
        eta, fraction = np.broadcast_arrays(
            np.asarray(eta, dtype=np.float64), np.asarray(chord_fraction, dtype=np.float64)
        )
        x = (fraction - self.spar_fraction) * self.chord(eta)
        return np.stack([x, self.span * eta], axis=-1)

    def area(self) -> float:
        """Return the planform area of the half wing [m^2]."""
        return 0.5 * self.span * (self.root_chord + self.tip_chord)

    def outline(self) -> FloatArray:
        """Return the closed polygon (5, 2) of the planform in (x, y) [m]."""
        return self.position([0.0, 1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0, 0.0])


@dataclass(frozen=True, slots=True)
class Naca4:
    """A NACA four-digit section with a closed trailing edge.

    The half-thickness is added along z instead of along the camber line's normal, so that both surfaces have their
    points at the same chord fraction and a vertical web joins them. Price: at most 0.5 % chord in the position along
    the surface near the leading edge of a 4415, and 0.1 % chord aft of x/c = 0.1.

    Source: E. N. Jacobs, K. E. Ward, R. M. Pinkerton, NACA Report 460 (1933), eqs for the four-digit series, with the
    last thickness coefficient -0.1036 that closes the trailing edge.
    """

    camber: float
    camber_position: float
    thickness: float

    def __post_init__(self) -> None:
        digits = (self.camber, self.camber_position, self.thickness)
        if not all(map(is_number, digits)) or not (0.0 < self.camber_position < 1.0 and 0.0 < self.thickness < 1.0):
            raise InputError(
                f"section has camber {self.camber!r} at {self.camber_position!r} and thickness {self.thickness!r}; "
                "expected fractions of the chord, the last two between 0 and 1; a 4415 is 0.04, 0.4, 0.15"
            )

    def heights(self, chord_fraction: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return (upper, lower) z / chord at chord fractions in [0, 1]."""
        x = np.asarray(chord_fraction, dtype=np.float64)
        if not ((x >= 0.0) & (x <= 1.0)).all():
            raise InputError("section heights were asked for outside the chord; expected x/c from 0 to 1; correct them")
        polynomial = 0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4
        half = 5.0 * self.thickness * polynomial
        p = self.camber_position
        fore = self.camber / p**2 * (2.0 * p * x - x**2)
        aft = self.camber / (1.0 - p) ** 2 * (1.0 - 2.0 * p + 2.0 * p * x - x**2)
        line = np.where(x < p, fore, aft)
        return np.asarray(line + half), np.asarray(line - half)


def grid_lines(stops: Sequence[float], largest_step: float) -> FloatArray:
    """Return sorted grid lines at every stop and evenly between, in steps of at most `largest_step`.

    Raises
    ------
    InputError
        If there are fewer than two different stops or the step is not positive.

    Examples
    --------
    >>> grid_lines([0.0, 1.0, 1.5], largest_step=0.4).round(3).tolist()
    [0.0, 0.333, 0.667, 1.0, 1.25, 1.5]
    """
    fixed = np.unique(np.round(np.asarray(stops, dtype=np.float64), 12))
    if fixed.size < 2 or not np.isfinite(fixed).all() or not (is_number(largest_step) and largest_step > 0.0):
        raise InputError(
            f"grid_lines got {fixed.size} different stops and largest_step {largest_step}; "
            "expected at least 2 finite stops and a positive step; give both ends of the interval"
        )
    pieces = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) / largest_step - 1e-9))) + 1)[:-1] for a, b in pairwise(fixed)
    ]
    return np.concatenate([*pieces, fixed[-1:]])
