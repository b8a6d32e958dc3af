"""Large deflection of any linear element: its motion is a rigid one times a small one, and only the small one strains.

letter = word: X corners before, x corners now, R the nodes' rotations, Q the element's rigid rotation, bar = mean over
the corners; all deformation is stated in the axes before the motion, so that the element's own stiffness K serves:

    placed_i = Q^T (x_i - bar x),   d_i = placed_i - (X_i - bar X),   theta_i = log(Q^T R_i),   f = K (d, theta).

Q is the rotation that fits the placed corners to X best (least squares of d), so it does not depend on how the corners
are numbered, and its spin w = Gamma dx is exact:

    sum_i X_i x placed_i = 0   ->   S w = sum_i X_i x dx_i,   S = -sum_i [X_i][placed_i],   [a] b = a x b.

With P the projection that takes the rigid part out of a variation and H the way from spins to d(theta), the forces are
P^T H^T f turned by Q, and their exact variation is the tangent; nothing is left out, so Newton converges
quadratically.

Source: B. Nour-Omid, C. C. Rankin, Comput. Methods Appl. Mech. Engng 93 (1991) 353-384, eqs 17 to 46 (projection,
tangent); C. A. Felippa, B. Haugen, ibid. 194 (2005) 2285-2335, sections 4 and 5, table 5 (H, L). The variation of Gamma
itself, which both leave out, is kept here.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.elements.rotations import log_rotation, moment_variation, skew, spin_to_vector

DOFS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Elements moved far: the rigid rotation of each and what remains.

    Attributes
    ----------
    turn : FloatArray
        Q (m, 3, 3).
    before, placed : FloatArray
        Corners about their mean (m, n, 3) before the motion, and now but turned back [m].
    deformation : FloatArray
        (d, theta) of each corner (m, n, 6) [m, rad] in global axes before the motion.
    """

    turn: FloatArray
    before: FloatArray
    placed: FloatArray
    deformation: FloatArray


def motion(points: FloatArray, displacement: FloatArray, rotation: FloatArray) -> Motion:
    """Return the motion of elements with corners (m, n, 3) displaced by (m, n, 3) [m] and turned by (m, n, 3, 3)."""
    before = points - points.mean(axis=1, keepdims=True)
    now = points + displacement
    now = now - now.mean(axis=1, keepdims=True)
    turn = _best_rotation(before, now)
    placed = now @ turn
    theta = log_rotation(turn[:, None].transpose(0, 1, 3, 2) @ rotation)
    return Motion(turn, before, placed, np.concatenate([placed - before, theta], axis=2))


def forces(motion: Motion, stiffness: FloatArray, offset: FloatArray) -> FloatArray:
    """Return the nodal forces (m, n, 6) in global axes of elements with stiffness (m, 6 n, 6 n).

    `offset` (m, 6 n) are forces that turn with the element and are subtracted, as those of hindered expansion.
    """
    pulled = _pulled(motion, stiffness, offset)[1]
    return _turned(motion, _balanced(pulled, motion))


def tangent(motion: Motion, stiffness: FloatArray, offset: FloatArray) -> FloatArray:
    """Return d(forces) / d(displacement, spin) (m, 6 n, 6 n) in global axes, symmetrised.

    The asymmetry vanishes where forces and loads balance and the loads have no moments, so it costs no convergence.
    """
    raw, pulled = _pulled(motion, stiffness, offset)
    m, n = pulled.shape[:2]
    gamma = _spin_rows(motion)
    projection = _projection(motion, gamma)
    vectors = spin_to_vector(motion.deformation[:, :, 3:])
    follow = _blockwise(vectors, projection)
    matrix = follow.transpose(0, 2, 1) @ stiffness @ follow
    turning = moment_variation(motion.deformation[:, :, 3:], raw[:, :, 3:]) @ vectors
    matrix += projection.transpose(0, 2, 1) @ _blockwise(turning, projection, only=True)
    matrix += _geometric(motion, pulled, gamma, projection)
    big = np.zeros((m, DOFS * n, DOFS * n))
    for block in range(2 * n):
        rows = slice(3 * block, 3 * block + 3)
        big[:, rows, rows] = motion.turn
    matrix = big @ matrix @ big.transpose(0, 2, 1)
    return np.asarray(0.5 * (matrix + matrix.transpose(0, 2, 1)))


def _pulled(motion: Motion, stiffness: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return K (d, theta) - offset, and the same with moments on spins (m, n, 6)."""
    shape = motion.deformation.shape
    flat = motion.deformation.reshape(shape[0], DOFS * shape[1])
    raw = (np.einsum("eij,ej->ei", stiffness, flat) - offset).reshape(shape)
    vectors = spin_to_vector(motion.deformation[:, :, 3:])
    moments = np.einsum("enji,enj->eni", vectors, raw[:, :, 3:])
    return raw, np.concatenate([raw[:, :, :3], moments], axis=2)


def _balanced(pulled: FloatArray, motion: Motion) -> FloatArray:
    """Return P^T of forces (m, n, 6): no resultant, no moment about the placed corners."""
    force = pulled[:, :, :3]
    moved = force - force.mean(axis=1, keepdims=True) - np.cross(_lever(motion, pulled)[:, None], motion.before)
    return np.concatenate([moved, pulled[:, :, 3:]], axis=2)


def _lever(motion: Motion, pulled: FloatArray) -> FloatArray:
    """Return z = S^-T moment (m, 3) of forces (m, n, 6) about the placed corners: Gamma_i^T moment = [X_i]^T z."""
    moment = (np.cross(motion.placed, pulled[:, :, :3]) + pulled[:, :, 3:]).sum(axis=1)
    return np.asarray(np.linalg.solve(_inertia(motion).transpose(0, 2, 1), moment[:, :, None])[:, :, 0])


def _turned(motion: Motion, balanced: FloatArray) -> FloatArray:
    m, n = balanced.shape[:2]
    return (balanced.reshape(m, n, 2, 3) @ motion.turn.transpose(0, 2, 1)[:, None]).reshape(m, n, DOFS)


def _inertia(motion: Motion) -> FloatArray:
    """Return S (m, 3, 3)."""
    return -np.asarray((skew(motion.before) @ skew(motion.placed)).sum(axis=1))


def _spin_rows(motion: Motion) -> FloatArray:
    """Return Gamma (m, 3, 6 n): the element's spin from the corners' variations."""
    m, n = motion.before.shape[:2]
    rows = np.zeros((m, 3, n, DOFS))
    arms = skew(motion.before).transpose(0, 2, 1, 3)
    rows[:, :, :, :3] = np.linalg.solve(_inertia(motion), arms.reshape(m, 3, 3 * n)).reshape(m, 3, n, 3)
    return rows.reshape(m, 3, DOFS * n)


def _projection(motion: Motion, gamma: FloatArray) -> FloatArray:
    """Return P (m, 6 n, 6 n): variations without their rigid part."""
    m, n = motion.before.shape[:2]
    rigid = np.zeros((m, n, DOFS, 3))
    rigid[:, :, :3] = -skew(motion.placed)
    rigid[:, :, 3:] = np.eye(3)
    mean = np.zeros((n, DOFS, n, DOFS))
    mean[:, :3, :, :3] = np.eye(3)[None, :, None, :] / n
    whole = np.eye(DOFS * n) - mean.reshape(DOFS * n, DOFS * n)
    return np.asarray(whole - rigid.reshape(m, DOFS * n, 3) @ gamma)


def _blockwise(blocks: FloatArray, matrix: FloatArray, only: bool = False) -> FloatArray:
    """Return `matrix` (m, 6 n, k), its rotation rows multiplied by `blocks` (m, n, 3, 3), the others kept or zero."""
    m, n = blocks.shape[:2]
    parts = matrix.reshape(m, n, DOFS, matrix.shape[2])
    result = np.zeros_like(parts) if only else parts.copy()
    result[:, :, 3:] = blocks @ parts[:, :, 3:]
    return result.reshape(matrix.shape)


def _geometric(motion: Motion, pulled: FloatArray, gamma: FloatArray, projection: FloatArray) -> FloatArray:
    """Return the variation of the forces at a constant deformation (m, 6 n, 6 n), in the axes before the motion."""
    m, n = pulled.shape[:2]
    balanced = _balanced(pulled, motion)
    turned = skew(balanced.reshape(m, 2 * n, 3)).reshape(m, DOFS * n, 3)
    matrix = -turned @ gamma
    # surplus = sum placed x force + moment: its variation by d(placed), then that of Gamma = S^-1 [X] itself
    force = skew(pulled[:, :, :3])
    surplus = (np.cross(motion.placed, pulled[:, :, :3]) + pulled[:, :, 3:]).sum(axis=1)
    lever = np.linalg.solve(_inertia(motion).transpose(0, 2, 1), surplus[:, :, None])[:, :, 0]
    inner = force + skew(np.cross(motion.before, lever[:, None]))
    rows = np.zeros((m, 3, n, DOFS))
    rows[:, :, :, :3] = inner.transpose(0, 2, 1, 3)
    return np.asarray(matrix + gamma.transpose(0, 2, 1) @ rows.reshape(m, 3, DOFS * n) @ projection)


def _best_rotation(before: FloatArray, now: FloatArray) -> FloatArray:
    """Return the rotations (m, 3, 3) with now = Q before as nearly as can be (least squares)."""
    left, _, right = np.linalg.svd(now.transpose(0, 2, 1) @ before)
    signs = np.ones((len(before), 3))
    signs[:, 2] = np.sign(np.linalg.det(left) * np.linalg.det(right))
    return np.asarray((left * signs[:, None]) @ right)
