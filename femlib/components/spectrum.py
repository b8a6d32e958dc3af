"""The ports of regions that do not touch, in coordinates that make a damage diagonal.

For region i let S_i be the block of S_0 at its own ports, and

    X_i' S_i X_i = 1,   X_i' T_i X_i = diag(h),   u_b = X xi,

so that S(mu) u_b = l reads (1 - mu h) xi + E xi = X' l. E, what the regions do to each other, lives on few directions:
E = B C B', B orthonormal and block by block. With D = 1 / (1 - mu h), by Woodbury,

    xi = D (g - B C eta),   (1 + B' D B C) eta = B' D g,   g = X' l,

a small system for each state. Directions whose coupling is below `CUT` are dropped.
Source: M. A. Woodbury, Inverting modified matrices, Princeton (1950).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as linalg

from femlib.arrays import FloatArray, IntArray

CUT = 1e-11
"""Singular value of the coupling, over the stiffness (1 in these coordinates), below which it is dropped."""
AT_ONCE = 64
"""States solved together: bounds memory."""


@dataclass(frozen=True, slots=True, eq=False)
class PortSpectrum:
    """The equations of the module's docstring; N ports, R coupled directions.

    Attributes
    ----------
    owner : IntArray
        Region of each coordinate (N,).
    loss : FloatArray
        h (N,), from 0 to 1.
    turn : FloatArray
        X (n_ports, N).
    pull : FloatArray
        Forces T_i X_i / h of each coordinate, which are S_i X_i (n_ports, N).
    basis : FloatArray
        B (N, R).
    coupling : FloatArray
        C (R, R).
    """

    owner: IntArray
    loss: FloatArray
    turn: FloatArray
    pull: FloatArray
    basis: FloatArray
    coupling: FloatArray

    @classmethod
    def of(cls, schur: FloatArray, losses: Sequence[tuple[IntArray, FloatArray]]) -> "PortSpectrum":
        """Return the spectrum of S_0 (n_ports, n_ports) and the components' places and T; no port is shared."""
        owner = np.concatenate([np.full(len(place), k) for k, (place, _) in enumerate(losses)])
        loss, turn, pull = np.zeros(len(owner)), np.zeros_like(schur), np.zeros_like(schur)
        for k, (place, stiffness) in enumerate(losses):
            own = schur[np.ix_(place, place)]
            columns = np.flatnonzero(owner == k)
            loss[columns], axes = linalg.eigh(stiffness, own)
            turn[np.ix_(place, columns)] = axes
            pull[np.ix_(place, columns)] = own @ axes
        across = turn.T @ schur @ turn
        across[owner[:, None] == owner[None, :]] = 0.0
        bases = []
        for k in range(len(losses)):
            left, size, _ = linalg.svd(across[np.ix_(owner == k, owner != k)], full_matrices=False)
            bases.append(left[:, size > CUT])
        basis = linalg.block_diag(*bases)
        return cls(owner, loss, turn, pull, basis, basis.T @ across @ basis)

    def forces(self, damage: FloatArray, load: FloatArray) -> FloatArray:
        """Return sum_i mu_i T_i u_b (n_states, *load.shape) for damages (n_states, n_components)."""
        g = (self.turn.T @ load).reshape(len(self.turn), -1)
        parts = [self._forces(damage[k : k + AT_ONCE], g) for k in range(0, len(damage), AT_ONCE)]
        return np.concatenate(parts).reshape(len(damage), *load.shape)

    def _forces(self, damage: FloatArray, g: FloatArray) -> FloatArray:
        lost = damage[:, self.owner] * self.loss
        soft = (1.0 / (1.0 - lost))[:, :, None]
        seen = self.basis.T @ (soft * self.basis)  # (n_states, R, R)
        alone = self.basis.T @ (soft * g)
        eta = np.linalg.solve(np.eye(len(self.coupling)) + seen @ self.coupling, alone)
        moved = soft * (g - self.basis @ (self.coupling @ eta))
        return np.asarray(self.pull @ (lost[:, :, None] * moved))
