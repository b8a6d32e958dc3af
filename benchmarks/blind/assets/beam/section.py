"""The section of the wing as thin straight edges between booms: NACA 4415, one web at 30 % of the chord.

x runs aft of the web, z up, both in chords. Two cells: nose and tail, both closed.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray

CAMBER, CAMBER_PLACE, THICKNESS, WEB = 0.04, 0.4, 0.15, 0.30
NOSE = 0.12 * (np.arange(6) / 5.0) ** 2
REST = (0.165, 0.21, 0.255, WEB, 0.345, 0.35, 0.39, 0.43, 0.49, 0.55, 0.64, 0.73, 0.82, 0.91, 1.0)
"""Chord fractions of the booms: the gauges' rows and the edges of the regions are among them."""
TOP, BOTTOM, INNER = 0, 1, 2
"""Edges of the upper skin, of the lower skin, of the web."""


@dataclass(frozen=True, eq=False)
class Section:
    """Booms and the edges between them.

    Attributes
    ----------
    x, z
        places (n_booms,) of the booms in chords.
    ends
        booms (n_edges, 2) of each edge.
    part
        `TOP`, `BOTTOM` or `INNER` of each edge (n_edges,).
    chord_fraction
        (n_edges,) of the edges' middles, from the leading edge.
    """

    x: FloatArray
    z: FloatArray
    ends: IntArray
    part: IntArray
    chord_fraction: FloatArray


def heights(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return upper and lower heights at chord fractions, thickness laid off square to the chord.

    Source: Jacobs, Ward & Pinkerton (1933), NACA Report 460, with the closed tail's last coefficient.
    """
    half = 5.0 * THICKNESS * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    fore = CAMBER / CAMBER_PLACE**2 * (2.0 * CAMBER_PLACE * x - x**2)
    aft = CAMBER / (1.0 - CAMBER_PLACE) ** 2 * (1.0 - 2.0 * CAMBER_PLACE + 2.0 * CAMBER_PLACE * x - x**2)
    line = np.where(x < CAMBER_PLACE, fore, aft)
    return line + half, line - half


def airfoil() -> Section:
    """Return the section: upper booms from nose to tail, then the lower ones between, then the middle of the web."""
    chord = np.concatenate([NOSE, REST])
    n = len(chord)
    upper, lower = heights(chord)
    web = int(np.flatnonzero(chord == WEB)[0])
    below = np.concatenate([[0], n + np.arange(n - 2), [n - 1]])
    middle = 2 * n - 2
    x = np.concatenate([chord, chord[1:-1], [WEB]]) - WEB
    z = np.concatenate([upper, lower[1:-1], [0.5 * (upper[web] + lower[web])]])
    skins = [np.stack([line[:-1], line[1:]], axis=1) for line in (np.arange(n), below)]
    ends = np.concatenate([*skins, [[web, middle], [middle, below[web]]]])
    part = np.repeat([TOP, BOTTOM, INNER], [n - 1, n - 1, 2])
    return Section(x, z, ends, part, x[ends].mean(axis=1) + WEB)
