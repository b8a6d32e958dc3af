"""The wing as solid bricks: a skin whose outer side is the section, a web and ribs that springs tie to it.

x runs aft of the web, y outboard, z up [m]. The tail behind 90 % of the chord carries nothing; a strip closes the skin.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from femlib.arrays import FloatArray, IntArray

TAIL, WEB = 0.90, 0.30
LINES = (TAIL, 0.82, 0.73, 0.64, 0.545, 0.485, 0.425, 0.39, 0.35, WEB, 0.255, 0.21, 0.165, 0.12, 0.07, 0.03, 0.008, 0.0)
"""Chord fractions of the grid lines from the tail to the nose: edges of the regions and the web are among them."""
RIB_LINES = slice(1, 14)
"""Lines on which a rib has columns: it ends before the tail and before the nose."""
N_LEVELS = 4
STEP, STEP_AWAY = 0.014, 0.03
SENSED = (0.2, 0.86)
TIE = 2.0e8
"""Stiffness of a joint at one pair of nodes, along each axis [N/m]."""
UPPER = len(LINES) - 1
"""Edges of the loop on the upper skin."""


@dataclass(frozen=True)
class Shape:
    """What the drawing says, and how it was built.

    Attributes
    ----------
    span, root_chord, tip_chord
        [m].
    n_ribs
        with the root's and the tip's.
    skin, taper
        thickness of the skin at the root [m], and that of the tip over it.
    plate
        thickness of web and ribs [m].
    refinement
        divides the steps along the span.
    """

    span: float = 1.8288
    root_chord: float = 0.43561
    tip_chord: float = 0.261112
    n_ribs: int = 11
    skin: float = 3.81e-3
    taper: float = 0.31
    plate: float = 3.0e-3
    refinement: float = 1.0

    def chord(self, eta: FloatArray) -> FloatArray:
        """Return the chord [m] at span fractions."""
        return self.root_chord + (self.tip_chord - self.root_chord) * eta


@dataclass(frozen=True, eq=False)
class Solids:
    """Nodes, bricks and ties.

    Attributes
    ----------
    nodes
        (n_nodes, 3) [m].
    bricks
        nodes (n_bricks, 8) of each; of the skin the inner side first.
    part
        "skin", "web" or "ribs" of each brick (n_bricks,).
    grid
        bricks (n_bays, n_loop) of the skin: bays along the span, edges of the loop from the upper tail to the nose and
        back below; the last edge closes the tail.
    eta, chord_fraction
        middles of the bays (n_bays,) and of the loop's edges (n_loop,).
    outer
        nodes (n_stations, n_loop) of the skin's outer side.
    stations
        (n_stations,) span fractions.
    ties
        pairs (n_ties, 2) of nodes, each joined by springs along all axes.
    tie_of
        "upper", "lower" (web to a skin) or "rib" of each tie (n_ties,).
    tie_eta
        (n_ties,) where it is.
    """

    nodes: FloatArray
    bricks: IntArray
    part: Sequence[str]
    grid: IntArray
    eta: FloatArray
    chord_fraction: FloatArray
    outer: IntArray
    stations: FloatArray
    ties: IntArray
    tie_of: Sequence[str]
    tie_eta: FloatArray


def loop() -> FloatArray:
    """Return the section's outer side (n_loop, 2) in chords, x from the web: upper tail, nose, lower tail."""
    x = np.array(LINES)
    half = 0.75 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    line = np.where(x < 0.4, 0.25 * (0.8 * x - x**2), (0.2 + 0.8 * x - x**2) / 9.0)  # NACA 4415
    upper, lower = np.stack([x - WEB, line + half], axis=1), np.stack([x - WEB, line - half], axis=1)
    return np.concatenate([upper, lower[-2::-1]])


def inward(points: FloatArray, distance: float) -> FloatArray:
    """Return a closed polygon (n, 2), counter-clockwise, with its sides moved inward."""
    side = np.roll(points, -1, axis=0) - points
    normal = np.stack([-side[:, 1], side[:, 0]], axis=1) / np.linalg.norm(side, axis=1)[:, None]
    middle = normal + np.roll(normal, 1, axis=0)
    return np.asarray(points + 2.0 * distance * middle / (middle**2).sum(axis=1)[:, None])


def span_lines(shape: Shape, edges: Iterable[float]) -> FloatArray:
    """Return the stations: ribs, edges of the regions, and steps between them."""
    fixed = np.unique(np.round([*np.linspace(0.0, 1.0, shape.n_ribs), *edges], 9))
    lines = [fixed[:1]]
    for a, b in pairwise(fixed.tolist()):
        step = STEP if SENSED[0] <= 0.5 * (a + b) <= SENSED[1] else STEP_AWAY
        lines.append(np.linspace(a, b, max(1, int(np.ceil((b - a) * shape.refinement / step - 1e-9))) + 1)[1:])
    return np.concatenate(lines)


def solids(shape: Shape, edges: Iterable[float]) -> Solids:
    """Return the wing as bricks."""
    eta = span_lines(shape, edges)
    outside = loop()
    n, n_loop = len(eta), len(outside)
    chord = shape.chord(eta)
    skin = shape.skin * (1.0 - (1.0 - shape.taper) * eta)
    sections = [c * outside for c in chord]
    insides = [inward(points, t) for points, t in zip(sections, skin, strict=True)]
    y = np.repeat(shape.span * eta, n_loop)
    nodes = [np.column_stack([p[:, 0], y_, p[:, 1]]) for p, y_ in (
        (np.concatenate(sections), y), (np.concatenate(insides), y))]  # fmt: skip
    outer = np.arange(n * n_loop).reshape(n, n_loop)
    skin_bricks = _layer(_around(outer + outer.size), _around(outer))
    made = _Maker(np.concatenate(nodes))
    at = LINES.index(WEB)
    ends = (outer.size + outer[:, at], outer.size + outer[:, -1 - at])
    web = made.plate(*ends, np.array([shape.plate, 0.0, 0.0]))
    made.tie_ends(web[0], ends, eta, ("upper", "lower"))
    ribs = [_rib(made, shape, outer, web, eta, int(row)) for row in _rib_rows(shape, eta)]
    bricks = np.concatenate([skin_bricks.reshape(-1, 8), _layer(*web).reshape(-1, 8), *ribs])
    grid = np.arange(skin_bricks[..., 0].size).reshape(n - 1, n_loop)
    n_web = (n - 1) * (N_LEVELS - 1)
    part = ["skin"] * grid.size + ["web"] * n_web + ["ribs"] * (len(bricks) - grid.size - n_web)
    closed = np.concatenate([outside, outside[:1]])
    fraction = 0.5 * (closed[1:, 0] + closed[:-1, 0]) + WEB
    return Solids(
        made.nodes, _right_handed(made.nodes, bricks), part, grid, 0.5 * (eta[1:] + eta[:-1]), fraction, outer, eta,
        np.array(made.ties), made.tie_of, np.array(made.tie_eta),
    )  # fmt: skip


def without(wing: Solids, gone: FloatArray) -> Solids:
    """Return the wing without the ties that are marked (n_ties,)."""
    kept = np.flatnonzero(~np.asarray(gone, dtype=bool))
    return replace(
        wing, ties=wing.ties[kept], tie_of=[wing.tie_of[k] for k in kept.tolist()], tie_eta=wing.tie_eta[kept]
    )


class _Maker:
    """Nodes and ties while they are made."""

    def __init__(self, nodes: FloatArray) -> None:
        self.nodes = nodes
        self.ties: list[tuple[int, int]] = []
        self.tie_of: list[str] = []
        self.tie_eta: list[float] = []

    def plate(self, upper: IntArray, lower: IntArray, thickness: FloatArray) -> tuple[IntArray, IntArray]:
        """Return both sides (n, N_LEVELS) of a plate of which the first stands between two lines of nodes (n,)."""
        level = np.linspace(0.0, 1.0, N_LEVELS)[None, :, None]
        middle = self.nodes[upper][:, None] * (1.0 - level) + self.nodes[lower][:, None] * level
        sides = []
        for shift in (0.0, thickness):
            sides.append(len(self.nodes) + np.arange(middle[..., 0].size).reshape(middle.shape[:2]))
            self.nodes = np.concatenate([self.nodes, (middle + shift).reshape(-1, 3)])
        return sides[0], sides[1]

    def tie_ends(self, side: IntArray, ends: tuple[IntArray, IntArray], eta: FloatArray, of: tuple[str, str]) -> None:
        """Tie the first and last level of a plate's side to the lines of nodes that it stands between.

        One side alone, whose nodes lie where theirs do: springs between two places would resist a mere turn.
        """
        for level, end, name in ((0, ends[0], of[0]), (-1, ends[1], of[1])):
            self.tie(side[:, level], end, eta, name)

    def tie(self, first: IntArray, second: IntArray, eta: FloatArray, name: str) -> None:
        """Tie pairs of nodes."""
        for a, b, e in zip(first.tolist(), second.tolist(), eta.tolist(), strict=True):
            self.ties.append((a, b))
            self.tie_of.append(name)
            self.tie_eta.append(e)


def _rib(
    made: _Maker, shape: Shape, outer: IntArray, web: tuple[IntArray, IntArray], eta: FloatArray, row: int
) -> IntArray:
    """Make a rib before the web and one behind it, tied to the skins and to the web; return its bricks (n, 8)."""
    pieces = []
    at = LINES.index(WEB)
    for lines in (np.arange(RIB_LINES.start, at + 1), np.arange(at, RIB_LINES.stop)):
        ends = (outer.size + outer[row, lines], outer.size + outer[row, -1 - lines])
        sides = made.plate(*ends, np.array([0.0, -shape.plate, 0.0]))
        here = np.full(len(lines), eta[row])
        made.tie_ends(sides[0], ends, here, ("rib", "rib"))
        column = int(np.flatnonzero(lines == at)[0])
        made.tie(sides[0][column, 1:-1], web[0][row, 1:-1], np.full(N_LEVELS - 2, eta[row]), "rib")
        pieces.append(_layer(*sides).reshape(-1, 8))
    return np.concatenate(pieces)


def _rib_rows(shape: Shape, eta: FloatArray) -> IntArray:
    """Return the stations of the ribs but the root's, which is clamped."""
    return np.searchsorted(eta, np.linspace(0.0, 1.0, shape.n_ribs)[1:] - 1e-9)


def _layer(inner: IntArray, outer: IntArray) -> IntArray:
    """Return the bricks (n - 1, m - 1, 8) between two sheets of nodes (n, m)."""
    faces = [np.stack([s[:-1, :-1], s[:-1, 1:], s[1:, 1:], s[1:, :-1]], axis=-1) for s in (inner, outer)]
    return np.concatenate(faces, axis=-1)


def _around(sheet: IntArray) -> IntArray:
    """Return a sheet (n, m) of a closed loop with its first column once more behind the last."""
    return np.concatenate([sheet, sheet[:, :1]], axis=1)


def _right_handed(nodes: FloatArray, bricks: IntArray) -> IntArray:
    """Return the bricks with both faces turned where the second lay on the wrong side of the first."""
    corner = nodes[bricks]
    a, b, up = corner[:, 1] - corner[:, 0], corner[:, 3] - corner[:, 0], corner[:, 4] - corner[:, 0]
    wrong = np.einsum("ij,ij->i", np.cross(a, b), up) < 0.0
    return np.where(wrong[:, None], bricks[:, [0, 3, 2, 1, 4, 7, 6, 5]], bricks)
