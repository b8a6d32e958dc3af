"""Edges of shells: normals of the smooth surface at their ends, and how the ends' rotations bend them.

The middle of an edge from i to j moves beside the mean of its ends by

    d = kappa / 8 (b x n) (V_j . theta_j - V_i . theta_i),   b = x_j - x_i,

n the shell's normal, V those of the smooth surface at the ends, kappa = 1 for quadrilaterals (Allman's displacements)
and 3 / 2 for triangles (Felippa's alpha_b). An edge of several shells moves as their mean, a beam by
b x (theta_j - theta_i) / 8.

Sources: D. J. Allman, Computers & Structures 19 (1984) 1-8; C. A. Felippa, Comput. Methods Appl. Mech. Engrg 192 (2003)
2125-2168.
"""

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.elements.rotations import skew
from femlib.mesh import Mesh, shell_sides

SMOOTH = np.cos(np.radians(40.0))
"""Elements whose normals are nearer than this are of one smooth surface."""
OF_TRIANGLES = 1.5
"""kappa of triangles."""


def bends(mesh: Mesh, ends: IntArray) -> FloatArray:
    """Return the motion (n, 2, 3, 3) of the middles of edges or beams with ends (n, 2) by each end's rotation."""
    along = mesh.nodes[ends[:, 1]] - mesh.nodes[ends[:, 0]]
    signs = np.array([-1.0, 1.0])[:, None, None]
    found = signs * skew(along)[:, None] / 8.0
    vectors = mesh.area_vectors()
    flat = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    sides, element, normals = _sides(mesh)
    kappa = np.where(element < len(mesh.quads), 1.0, OF_TRIANGLES)
    order = np.argsort(_named(mesh, sides), kind="stable")
    named, wanted = _named(mesh, sides)[order], _named(mesh, ends)
    first, last = (np.searchsorted(named, wanted, side=side) for side in ("left", "right"))
    of_edge = np.repeat(np.arange(len(ends)), last - first)
    own = order[np.arange(len(of_edge)) - np.repeat(np.cumsum(last - first) - last, last - first)]
    is_turned = (sides[own, 0] != ends[of_edge, 0])[:, None, None]
    at_ends = np.where(is_turned, normals[own][:, ::-1], normals[own])
    push = kappa[element[own], None] * np.cross(along[of_edge], flat[element[own]]) / 8.0
    each = signs * push[:, None, :, None] * at_ends[:, :, None, :]
    has_shell = last > first
    found[has_shell] = 0.0
    np.add.at(found, of_edge, each / (last - first)[of_edge, None, None, None])
    return found


def _named(mesh: Mesh, ends: IntArray) -> IntArray:
    """Return one number (n,) for each pair of nodes (n, 2), whatever its order."""
    return np.asarray(np.sort(ends, axis=1) @ np.array([len(mesh.nodes), 1]))


def _sides(mesh: Mesh) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the sides of all shells (n, 2), each one's element (n,), and the normals at its ends (n, 2, 3)."""
    normals = [np.stack([own, np.roll(own, -1, axis=1)], axis=2).reshape(-1, 2, 3) for own in corner_normals(mesh)]
    return *shell_sides(mesh.quads, mesh.trias), np.concatenate(normals)


def corner_normals(mesh: Mesh) -> list[FloatArray]:
    """Return unit normals (n_quads, 4, 3), (n_trias, 3, 3): means of the elements there of one smooth surface."""
    vectors = mesh.area_vectors()
    unit = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    k = len(mesh.quads)
    sides, element = shell_sides(mesh.quads, mesh.trias)
    corner = sides[:, 0]
    at = sparse.csr_array(
        (np.ones(len(corner)), (np.arange(len(corner)), corner)), shape=(len(corner), len(mesh.nodes))
    )
    pairs = sparse.coo_array(at @ at.T)
    one, other = element[pairs.row], element[pairs.col]
    cosine = np.einsum("ni,ni->n", unit[one], unit[other])
    share = np.where(np.abs(cosine) > SMOOTH, np.sign(cosine), 0.0)
    summed = np.zeros((len(corner), 3))
    np.add.at(summed, pairs.row, share[:, None] * unit[other])
    summed /= np.linalg.norm(summed, axis=1, keepdims=True)
    return [summed[: 4 * k].reshape(-1, 4, 3), summed[4 * k :].reshape(-1, 3, 3)]
