"""The course: three obstacles, a tight line that takes turns of 3 g and a wide one that never asks for more than 2 g.

Both lines are cosine bumps y = A (1 + cos(pi (x - x_j) / l)) / 2 round each obstacle j at x_j. A turn of curvature c at
V = 25 m/s loads the wing with sqrt(1 + (c V^2 / g)^2), and a bump's largest curvature is A (pi / l)^2 / 2. The aircraft
changes from line to line within a few steps, and as all that lies between the lines is free, any mixture is a way.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP_LENGTH = 8.0
"""Flown in a step of 0.32 s [m]."""
SPACING = 226.0
OBSTACLES = (0.5 * SPACING, 1.5 * SPACING, 2.5 * SPACING)
"""Places of the obstacles along the course [m]."""
GOAL = 3 * SPACING
TIGHT, WIDE = (30.0, 57.8), (69.5, 0.5 * SPACING)
"""Height A and half length l of the bumps of each line [m]."""
SWITCH = 0.08
"""Share of the way between the lines that is crossed in a step."""


def _bump(x: Floats, size: tuple[float, float], order: int) -> Floats:
    """Return a line's height (order 0) or slope (1) at x."""
    height, half = size
    away = np.min(np.abs(x[..., None] - np.array(OBSTACLES)), axis=-1)
    sign = np.sign(x - np.array(OBSTACLES)[np.argmin(np.abs(x[..., None] - np.array(OBSTACLES)), axis=-1)])
    phase = np.pi * np.minimum(away, half) / half
    if order == 0:
        return np.asarray(height * (1 + np.cos(phase)) / 2)
    return np.asarray(-sign * height * np.pi / half * np.sin(phase) / 2)


def advance(x: Floats, width: Floats, is_cautious: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return x and width (n,) one step later."""
    new = np.clip(width + np.where(is_cautious, SWITCH, -SWITCH), 0.0, 1.0)
    across = (new - width) * (_bump(x, WIDE, 0) - _bump(x, TIGHT, 0))  # at most 5.6 of the 8 m
    along = np.sqrt(STEP_LENGTH**2 - across**2)

    def forward(at: Floats) -> Floats:
        slope = (1 - new) * _bump(at, TIGHT, 1) + new * _bump(at, WIDE, 1)
        return np.asarray(along / np.sqrt(1 + slope**2))

    return np.asarray(x + forward(x + 0.5 * forward(x))), new
