"""CalculiX on the bricks: deck, run, strains of the skin's outer half."""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.blind.assets.springs.solids import TIE, Solids
from benchmarks.ccx import run_deck
from femlib.arrays import FloatArray, IntArray

SKIN, WOOD = (1.11e9, 0.31, 2.0e-6), (3.25e9, 0.30, 5.0e-6)
"""Modulus [Pa], Poisson's ratio, expansion [1/K]."""


@dataclass(frozen=True, eq=False)
class Deck:
    """One run.

    Attributes
    ----------
    wing
        bricks and ties.
    stiff
        factor on the modulus of each brick (n_bricks,).
    force
        vertical force at each node (n_nodes,) [N].
    warm
        temperature of each node (n_nodes,) [K].
    is_bent
        whether CalculiX follows the deformed shape.
    soft
        factor on the springs of each tie (n_ties,).
    """

    wing: Solids
    stiff: FloatArray
    force: FloatArray
    warm: FloatArray
    is_bent: bool = False
    soft: Mapping[int, float] = field(default_factory=dict)


def strains(deck: Deck, skin: float) -> FloatArray:
    """Return aft and spanwise strain (2, n_bays, n_upper) in the outer half of the upper skin, tension positive."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wing.inp"
        path.write_text("\n".join(lines(deck, skin)) + "\n", encoding="ascii")
        run_deck(path)
        return read(deck.wing, path.with_suffix(".dat"))


def read(wing: Solids, path: Path) -> FloatArray:
    """Return the same from a result file: points 5 to 8 of a brick lie toward its outer side."""
    found: dict[int, list[list[float]]] = {}
    for line in path.read_text(encoding="ascii").splitlines():
        words = line.split()
        if words[:1] == ["strains"]:
            found.clear()  # a new increment: the last one counts
        elif len(words) == 8 and words[0].isdigit():
            found.setdefault(int(words[0]) - 1, []).append([float(words[2]), float(words[3])])
    upper = _upper(wing)
    rows = np.array([np.mean(found[int(brick)][4:8], axis=0) for brick in upper.ravel()])
    return rows.reshape(*upper.shape, 2).transpose(2, 0, 1)


def _upper(wing: Solids) -> IntArray:
    return wing.grid[:, : wing.grid.shape[1] // 2]


def lines(deck: Deck, skin: float) -> list[str]:
    """Return the deck."""
    wing = deck.wing
    text = ["*NODE, NSET=ALL", *(f"{k + 1}, {x:.9e}, {y:.9e}, {z:.9e}" for k, (x, y, z) in enumerate(wing.nodes))]
    text += ["*ELEMENT, TYPE=C3D8I", *(_row(k + 1, brick + 1) for k, brick in enumerate(wing.bricks))]
    text += _materials(deck, skin) + _ties(deck)
    root = np.flatnonzero(wing.nodes[:, 1] < 1e-9)
    text += ["*NSET, NSET=ROOT", *(f"{k + 1}," for k in root), "*BOUNDARY", "ROOT, 1, 3"]
    text += ["*ELSET, ELSET=READ", *(f"{k + 1}," for k in _upper(wing).ravel())]
    text += ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 0."]
    text += ["*STEP, NLGEOM", "*STATIC", "1., 1."] if deck.is_bent else ["*STEP", "*STATIC"]
    text += ["*TEMPERATURE", *(f"{k + 1}, {t:.9e}" for k, t in enumerate(deck.warm))]
    text += ["*CLOAD", *(f"{k + 1}, 3, {deck.force[k]:.9e}" for k in np.flatnonzero(deck.force))]
    return [*text, "*EL PRINT, ELSET=READ", "E", "*END STEP"]


def _row(number: int, nodes: IntArray) -> str:
    return f"{number}, " + ", ".join(str(int(n)) for n in nodes)


def _materials(deck: Deck, skin: float) -> list[str]:
    is_wood = np.array([part != "skin" for part in deck.wing.part])
    kinds, member = np.unique(np.column_stack([is_wood, np.round(deck.stiff, 6)]), axis=0, return_inverse=True)
    text = []
    for number, (wood, stiff) in enumerate(kinds):
        young, poisson, expansion = WOOD if wood else (skin * SKIN[0], *SKIN[1:])
        text += [f"*ELSET, ELSET=E{number}", *(f"{k + 1}," for k in np.flatnonzero(member.ravel() == number))]
        text += [f"*MATERIAL, NAME=M{number}", "*ELASTIC", f"{stiff * young:.9e}, {poisson}"]
        text += ["*EXPANSION, ZERO=0", f"{expansion:.9e}", f"*SOLID SECTION, ELSET=E{number}, MATERIAL=M{number}"]
    return text


def _ties(deck: Deck) -> list[str]:
    """Return three springs at each tie, one set for each axis and stiffness."""
    sets: dict[float, list[int]] = {}
    for k in range(len(deck.wing.ties)):
        sets.setdefault(deck.soft.get(k, 1.0), []).append(k)
    text, number = [], len(deck.wing.bricks)
    for s, (soft, members) in enumerate(sets.items()):
        for axis in (1, 2, 3):
            text.append(f"*ELEMENT, TYPE=SPRING2, ELSET=S{s}X{axis}")
            for k in members:
                number += 1
                a, b = deck.wing.ties[k] + 1
                text.append(f"{number}, {a}, {b}")
            text += [f"*SPRING, ELSET=S{s}X{axis}", f"{axis}, {axis}", f"{soft * TIE:.6e}"]
    return text
