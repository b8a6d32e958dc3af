"""The guaranteed error bound of a reduced model.

With the residuals r = g - S y_N of the state and d = p - S z_N of an output's dual, and S >= diag((1 - mu) / mu),

    s - s_N = z_N' r + d' S^-1 r,   |d' S^-1 r| <= |r|_* |d|_*,   |r|_*^2 = sum_i mu_i / (1 - mu_i) |r_i|^2.

The bound S >= diag((1 - mu) / mu) has no constant to be estimated: it says that the regions' stiffness is a part of the
structure's. Norms are read from triangular factors made once, so that they do not cancel.

Source: N. A. Pierce, M. B. Giles, SIAM Review 42 (2000) 247-264 (adjoint correction); G. Rozza, D. B. P. Huynh,
A. T. Patera, Arch. Comput. Methods Engng 15 (2008) 229-275 (residual bounds).
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class ErrorBound:
    """Residual norms of states and duals.

    Attributes
    ----------
    primal : tuple of FloatArray
        For each region the triangular factor (k, 1 + N + n_own) of its load, H Phi and its own Phi.
    dual : tuple of FloatArray
        For each region the triangular factor (k, n_outputs + N + n_own) of the outputs' p, H Psi and its own Psi.
    """

    primal: tuple[FloatArray, ...]
    dual: tuple[FloatArray, ...]

    def remainder(
        self, mu: FloatArray, owner: IntArray, modes: IntArray, amplitudes: FloatArray, duals: FloatArray
    ) -> FloatArray:
        """Return |r|_* |d|_* for each output (n_outputs,).

        Parameters
        ----------
        mu : FloatArray
            Damages (n_parameters,).
        owner : IntArray
            Region of each mode (N,).
        modes : IntArray
            Modes in use (m,), all those of the damaged regions.
        amplitudes : FloatArray
            Of the state on these modes (m,).
        duals : FloatArray
            Of the outputs' duals on these modes (m, n_outputs).
        """
        n_outputs = duals.shape[1]
        state, dual = 0.0, np.zeros(n_outputs)
        for k in np.flatnonzero(mu):
            own = owner[modes] == k
            weight = mu[k] / (1.0 - mu[k])
            state += weight * np.square(_residual(self.primal[k], 1, modes, amplitudes[:, None], own, mu[k])).sum()
            dual += weight * np.square(_residual(self.dual[k], n_outputs, modes, duals, own, mu[k])).sum(axis=0)
        return np.asarray(np.sqrt(state * dual))


def _residual(
    factor: FloatArray, n_right: int, modes: IntArray, amplitudes: FloatArray, own: BoolArray, damage: float
) -> FloatArray:
    """Return a region's residual (k, n_right) but for a rotation: right side + image - own / mu."""
    n_own = int(own.sum())
    held = factor[:, factor.shape[1] - n_own :]
    return np.asarray(factor[:, :n_right] + factor[:, n_right + modes] @ amplitudes - held @ amplitudes[own] / damage)
