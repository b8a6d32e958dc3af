"""The structure of the examples in docstrings: a strip of four shells, whose first one may be damaged.

It is 4 m long, 1 m wide and 50 mm thick, of aluminium that narrows by nothing when it is pulled, and clamped at its
foot. Its sets are `strip` (all shells) and `root` (the first), `foot` and `tip` (the nodes at either end).
"""

import numpy as np

from femlib.material import isotropic_plate
from femlib.structure.model import Structure
from femlib.structure.named_mesh import NamedMesh


def clamped_strip(*clamped: str) -> Structure:
    """Return the strip, clamped at the foot, or at the sets of nodes that are named."""
    nodes = np.array([[x, y, 0.0] for x in range(5) for y in range(2)])
    quads = np.array([[k, k + 2, k + 3, k + 1] for k in (0, 2, 4, 6)])
    trias, lines = np.zeros((0, 3), dtype=int), np.zeros((0, 2), dtype=int)
    elements = {"strip": np.ones(4, dtype=bool), "root": np.arange(4) == 0}
    ends = {"foot": np.array([0, 1]), "tip": np.array([8, 9])}
    mesh = NamedMesh(nodes, quads, trias, lines, elements, ends)
    plate = isotropic_plate(70e9, 0.0, 0.05, 2700.0, expansion=2e-5)
    return Structure(mesh, {"strip": plate}, dict.fromkeys(clamped or ("foot",), "clamped"), damage=["root"])
