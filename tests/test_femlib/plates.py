"""Small meshes that the tests share."""

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly import Shells
from femlib.material import Laminate
from femlib.mesh import Mesh

DISTORTED = np.array([[0, 0], [10, 0], [10, 5], [0, 5], [2, 1.5], [8, 1], [7, 3.5], [3, 4]], dtype=float) * 0.1
"""The patch of five quadrilaterals: four corners, four inner nodes [m]."""
PATCH_QUADS = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]])
PATCH_TRIAS = np.concatenate([PATCH_QUADS[:, [0, 1, 2]], PATCH_QUADS[:, [0, 2, 3]]])


def rotation(seed: int) -> FloatArray:
    """Return a random rotation (3, 3)."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def patch(laminate: Laminate, shape: str, turn: FloatArray | None = None) -> Shells:
    """Return the distorted patch of quadrilaterals ("quad4") or triangles ("tria3"), turned in space."""
    nodes = np.column_stack([DISTORTED, np.zeros(len(DISTORTED))])
    if turn is not None:
        nodes = nodes @ turn.T
    none4, none3 = np.zeros((0, 4), dtype=np.int64), np.zeros((0, 3), dtype=np.int64)
    quads, trias = (PATCH_QUADS, none3) if shape == "quad4" else (none4, PATCH_TRIAS)
    count = len(quads) + len(trias)
    mesh = Mesh(nodes, quads, trias, ("plate",), np.zeros(count, dtype=np.int64))
    axis = np.array([1.0, 0.0, 0.0]) if turn is None else turn[:, 0]
    return Shells(mesh, (laminate,), np.zeros(count, dtype=np.int64), np.ones(count), axis)


def grid_mesh(x: FloatArray, y: FloatArray) -> Mesh:
    """Return a flat mesh of quadrilaterals on grid lines, node i * len(y) + j at (x_i, y_j)."""
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((len(x), len(y)))], axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(len(x), len(y))
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    return Mesh(points, quads, np.zeros((0, 3), dtype=np.int64), ("plate",), np.zeros(len(quads), dtype=np.int64))
