"""Record of a mission: its steps, and what the page may draw around them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.monitor import Refusal, Result

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class MissionStep:
    """One step: a reading, what a monitor made of it, and what was decided.

    Attributes
    ----------
    result
        of the reading, as `octmip.monitor.Monitor.run` yields it.
    load_factor
        at which the reading was taken.
    reading
        (n_gauges,) microstrain in the order of the library's gauges, NaN where nothing came.
    decision
        what was decided, in a few words; "" where nothing is.
    is_cautious
        whether this is the cautious one of the decisions.
    reason
        why, as a sentence.
    truth
        true state by parameter, where it is known (a simulation).
    at
        place on the course, where there is one.
    figures
        further figures of this step, by name.
    """

    result: Result | Refusal
    load_factor: float
    reading: Floats
    decision: str = ""
    is_cautious: bool = False
    reason: str = ""
    truth: Mapping[str, float] | None = None
    at: tuple[float, float] | None = None
    figures: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        reading = np.array(self.reading, dtype=np.float64)
        reading.flags.writeable = False
        object.__setattr__(self, "reading", reading)


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """The way of the asset, drawn from above.

    Attributes
    ----------
    lines
        planned lines by name, each (n, 2).
    obstacles
        (x, y, radius) of each.
    goal
        x at which the course ends; None: no line is drawn.
    """

    lines: Mapping[str, ArrayLike] = field(default_factory=dict)
    obstacles: tuple[tuple[float, float, float], ...] = ()
    goal: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """The part of the structure that a parameter is about.

    Attributes
    ----------
    parameter
        its name.
    outline
        (n, 2) corners [m], in the twin's own coordinates.
    """

    parameter: str
    outline: ArrayLike
