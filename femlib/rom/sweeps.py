"""Many states of a few regions at once: each region is solved exactly by itself, under what the others sent last.

A region's modes are turned so that its own block of C is diagonal but for complex pairs a +- i b, which stand as
((a, b), (-b, a)). Then

    a_i = mu_i (1 - mu_i C_ii)^-1 (b_i + sum_j C_ij a_j)

is a matter of single numbers, and the regions take turns (Gauss-Seidel) until nothing changes. Regions far apart need
two or three turns.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from femlib.arrays import FloatArray, IntArray

TOLERANCE = 1e-11
"""Change of the amplitudes in the last turn over the largest amplitude."""
MOST_TURNS = 30
LEAST_PAIR = 1e-9
"""An imaginary part below this is rounding."""


def eigen_turn(block: FloatArray) -> FloatArray:
    """Return X (n, n) for which X^-1 block X is diagonal but for complex pairs ((a, b), (-b, a))."""
    values, vectors = np.linalg.eig(block)
    columns = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag == 0.0:
            columns.append(vector.real)
        elif value.imag > 0.0:
            columns += [vector.real, vector.imag]
    return np.array(columns).reshape(block.shape).T


@dataclass(frozen=True, slots=True, eq=False)
class Sweeps:
    """The reduced equations, region by region.

    Attributes
    ----------
    modes : tuple of slice
        The modes of each region, which follow one another.
    real, imaginary : FloatArray
        Eigenvalues of the regions' blocks (N,): a, a and b, -b for a pair.
    partner : IntArray
        The other mode of a pair, or the mode itself (N,).
    load : FloatArray
        b (N,).
    across : FloatArray
        C without those eigenvalues (N, N).
    """

    modes: tuple[slice, ...]
    real: FloatArray
    imaginary: FloatArray
    partner: IntArray
    load: FloatArray
    across: FloatArray

    @classmethod
    def of(cls, owner: IntArray, load: FloatArray, coupling: FloatArray, n_regions: int) -> "Sweeps":
        """Return the sweeps of a model whose modes follow one another by region and are turned by `eigen_turn`.

        What rounding leaves between the modes of a region counts as sent from outside, so that the result is the same.
        """
        ends = np.searchsorted(owner, np.arange(n_regions + 1))  # a region that no load strains has no mode
        modes = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        every = np.arange(len(owner))
        within = np.where(owner[:, None] == owner, np.abs(coupling), 0.0)
        within[every, every] = 0.0
        strongest = within.argmax(axis=1) if len(owner) else every
        partner = np.where(within[every, strongest] > LEAST_PAIR, strongest, every)
        imaginary = np.where(partner == every, 0.0, coupling[every, partner])
        across = coupling.copy()
        across[every, partner] = across[every, every] = 0.0
        return cls(modes, coupling.diagonal().copy(), imaginary, partner, load, across)

    def amplitudes(self, damage: FloatArray) -> FloatArray | None:
        """Return a (N, n_states) of checked damages (n_parameters, n_states), or None if the turns do not settle.

        States run along the rows: numpy's loops are then long.
        """
        alone = [self._alone(mu, modes) for mu, modes in zip(damage, self.modes, strict=True)]
        amplitudes = np.zeros((len(self.load), damage.shape[1]))
        for _ in range(MOST_TURNS):
            change = 0.0
            for modes, (real, imaginary) in zip(self.modes, alone, strict=True):
                sent = self.across[modes] @ amplitudes
                sent += self.load[modes, None]
                new = real * sent
                if imaginary is not None:
                    new += imaginary * sent[self.partner[modes] - modes.start]
                change = max(change, float(np.abs(new - amplitudes[modes]).max(initial=0.0)))
                amplitudes[modes] = new
            if change <= TOLERANCE * np.abs(amplitudes).max(initial=0.0):
                return amplitudes
        return None

    def _alone(self, mu: FloatArray, modes: slice) -> tuple[FloatArray, FloatArray | None]:
        """Return mu (1 - mu C_ii)^-1 of damages (n_states,): its real part, and the part that crosses a pair."""
        rest = 1.0 - self.real[modes, None] * mu
        if not self.imaginary[modes].any():
            return np.asarray(mu / rest), None
        turn = self.imaginary[modes, None] * mu
        scale = mu / (rest * rest + turn * turn)
        return np.asarray(scale * rest), np.asarray(scale * turn)
