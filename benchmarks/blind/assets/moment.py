"""When and how the readings of one cell are taken."""

from dataclasses import dataclass

from femlib.arrays import FloatArray

State = tuple[float, ...]
"""Damage by parameter, fractions."""
History = tuple[tuple[float, float], ...]
"""(load factor, time [s]) of every change of the load."""


@dataclass(frozen=True, eq=False)
class Moment:
    """When and how the readings of one cell are taken.

    Attributes
    ----------
    state
        damage.
    load
        load factor.
    times
        (n,) of each reading since the start of the campaign [s].
    history
        every change of the load until now, this cell's own last.
    """

    state: State
    load: float
    times: FloatArray
    history: History
