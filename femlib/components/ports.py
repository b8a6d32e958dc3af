"""The ports of damage components: from damages to the forces that stand for them.

In the words of the package's docstring, a condensed load l gives the forces sum_i mu_i T_i u_b with S(mu) u_b = l.
The spectrum of the ports is made at the first damaged state, for the price of some six states solved one by one.
Always: whether a state came first or last, alone or among many, must not change its last digit. Regions that share
ports have no spectrum; their states are solved one by one, a Cholesky factorisation each.
"""

from collections.abc import Sequence

import numpy as np
import scipy.linalg as linalg

from femlib.arrays import FloatArray, IntArray
from femlib.components.spectrum import PortSpectrum


class Ports:
    """Condensed stiffness at the ports; its spectrum is kept once it was made.

    Attributes
    ----------
    schur : FloatArray
        Undamaged stiffness condensed on the ports, S_0 (n_ports, n_ports).
    losses : tuple of (IntArray, FloatArray)
        For each component its places among the ports and its T there.
    """

    def __init__(self, schur: FloatArray, losses: tuple[tuple[IntArray, FloatArray], ...]) -> None:
        self.schur = schur
        self.losses = losses
        self._spectrum: PortSpectrum | None = None

    @property
    def is_diagonal(self) -> bool:
        """Whether the spectrum has been made."""
        return self._spectrum is not None

    def forces(self, damage: FloatArray, load: FloatArray) -> FloatArray:
        """Return sum_i mu_i T_i u_b (n_states, *load.shape) for damages (n_states, n_components).

        `load` (n_ports,) or (n_ports, n_loads) is condensed on the ports.
        """
        damaged = damage.any(axis=1)
        forces = np.zeros((len(damage), *load.shape))
        if damaged.any():
            forces[damaged] = self._of_damaged(damage[damaged], load)
        return forces

    def _of_damaged(self, damage: FloatArray, load: FloatArray) -> FloatArray:
        if self._spectrum is None and are_apart([place for place, _ in self.losses]):
            self._spectrum = PortSpectrum.of(self.schur, self.losses)
        if self._spectrum is not None:
            return self._spectrum.forces(damage, load)
        return np.stack([one_by_one(self.schur, self.losses, mu, load) for mu in damage])


def one_by_one(
    schur: FloatArray, losses: Sequence[tuple[IntArray, FloatArray]], mu: FloatArray, load: FloatArray
) -> FloatArray:
    """Return the forces (n_ports, ...) of one state (n_components,) from a factorisation of S(mu)."""
    loss = np.zeros_like(schur)
    for amount, (place, stiffness) in zip(mu, losses, strict=True):
        loss[np.ix_(place, place)] += amount * stiffness
    return np.asarray(loss @ linalg.cho_solve(linalg.cho_factor(schur - loss, overwrite_a=True), load))


def are_apart(places: Sequence[IntArray]) -> bool:
    """Return whether no two components share a port."""
    together = np.concatenate([*places, np.zeros(0, dtype=np.int64)])
    return len(np.unique(together)) == len(together)
