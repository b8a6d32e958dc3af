"""The guaranteed error bound of a reduced model.

With the residuals r = g - S y_N of the state and d = p - S z_N of an output's dual, S = D - E, D the diagonal of S and
E what couples the regions,

    s - s_N = z_N' r + d' S^-1 r,   S^-1 = D^-1 + (S^-1 - D^-1).

Two bounds of the last term hold, and the smaller counts: since the regions' stiffness is a part of the structure's,
S >= diag((1 - mu) / mu), and |d' S^-1 r| <= |r| |d| in the inverse of that; and where E <= gamma D with gamma < 1,

    |d' S^-1 r - d' D^-1 r| <= gamma / (1 - gamma) |r|_D |d|_D,   |r|_D^2 = r' D^-1 r.

gamma is the least of two upper bounds, computed once for damages up to each of `LEVELS` (D falls as damage grows): the
largest eigenvalue of D^-1/2 E D^-1/2 with all regions damaged, and that of the matrix of the norms of its blocks for
the regions in question. Regions far apart hardly couple: then gamma is a hundredth and the bound nearly the error.

Source: N. A. Pierce, M. B. Giles, SIAM Review 42 (2000) 247-264 (adjoint correction); G. Rozza, D. B. P. Huynh,
A. T. Patera, Arch. Comput. Methods Engng 15 (2008) 229-275 (residual bounds); the second bound is femlib's.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg as linalg
from scipy.sparse.linalg import LinearOperator, eigsh

from femlib.arrays import BoolArray, FloatArray, IntArray

LEVELS = (0.5, 0.8, 0.9, 0.95, 0.98)
"""Largest damages that the couplings are known for; beyond the last the first bound alone counts."""
SAFETY = 1e-3
"""Relative excess of gamma over the computed eigenvalue, for its rounding and the iteration's."""
FEW = 40
"""Up to so many measures the eigenvalues are computed at once."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorBound:
    """What the residuals of states and duals are made of, and how strongly regions couple.

    Attributes
    ----------
    primal : tuple of FloatArray
        For each region the rows (R_k, 1 + N + n_own) of its load, H Phi and its own Phi.
    dual : tuple of FloatArray
        For each region the rows (R_k, n_outputs + N + n_own) of the outputs' p, H Psi and its own Psi.
    own : FloatArray
        Diagonal of H (R,).
    joint : FloatArray
        gamma with all regions damaged, by `LEVELS` (n_levels,).
    pairs : FloatArray
        Norms of the blocks of D^-1/2 E D^-1/2, by `LEVELS` (n_levels, n_regions, n_regions).
    """

    primal: tuple[FloatArray, ...]
    dual: tuple[FloatArray, ...]
    own: FloatArray
    joint: FloatArray
    pairs: FloatArray

    def bound(
        self,
        mu: FloatArray,
        owner: IntArray,
        modes: IntArray,
        amplitudes: FloatArray,
        duals: FloatArray,
        left: FloatArray,
    ) -> FloatArray:
        """Return upper bounds (n_outputs,) of |s - s_N|.

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
        left : FloatArray
            z_N' r (n_outputs,).
        """
        n_outputs = duals.shape[1]
        state = np.zeros(2)
        dual, both = np.zeros((2, n_outputs)), left.copy()
        first = np.concatenate([[0], np.cumsum([len(rows) for rows in self.primal])]).astype(np.int64)
        for k in np.flatnonzero(mu):
            used = owner[modes] == k
            r = _residual(self.primal[k], 1, modes, amplitudes[:, None], used, mu[k])
            d = _residual(self.dual[k], n_outputs, modes, duals, used, mu[k])
            diagonal = 1.0 / mu[k] - self.own[first[k] : first[k + 1], None]
            weights = (mu[k] / (1.0 - mu[k]), 1.0 / diagonal)
            state += [float((weight * r * r).sum()) for weight in weights]
            dual += [(weight * d * d).sum(axis=0) for weight in weights]
            both += ((r / diagonal) * d).sum(axis=0)
        plain, sharp = np.sqrt(state[:, None] * dual)
        gamma = self.coupling(mu)
        first_bound = np.abs(left) + plain
        if gamma >= 1.0:
            return np.asarray(first_bound)
        return np.asarray(np.minimum(first_bound, np.abs(both) + gamma / (1.0 - gamma) * sharp))

    def coupling(self, mu: FloatArray) -> float:
        """Return gamma of damages (n_parameters,), infinity beyond the last of `LEVELS`."""
        damaged = np.flatnonzero(mu)
        own = mu[damaged]
        if len(own) < 2:
            return 0.0
        levels = np.array(LEVELS)
        if own.max() > levels[-1]:
            return np.inf
        level = np.searchsorted(levels, np.maximum(own[:, None], own))
        # below a level m, D is at least m / mu times what it is there
        shares = np.sqrt(own[:, None] * own) / levels[level]
        blocks = shares * self.pairs[level, damaged[:, None], damaged]
        of_blocks = float(np.abs(np.linalg.eigvalsh(blocks)).max())
        return min(of_blocks, float(self.joint[np.searchsorted(levels, own.max())]))


def couplings(own: FloatArray, across: FloatArray, first: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return `joint` and `pairs` of an `ErrorBound`.

    Parameters
    ----------
    own : FloatArray
        Diagonal of H (R,).
    across : FloatArray
        H without it (R, R), zero within a region.
    first : IntArray
        Where each region's measures begin, and R (n_regions + 1,).
    """
    blocks = [slice(begin, end) for begin, end in pairwise(first.tolist())]
    joint, pairs = np.zeros(len(LEVELS)), np.zeros((len(LEVELS), len(blocks), len(blocks)))
    for number, level in enumerate(LEVELS):
        root = 1.0 / np.sqrt(1.0 / level - own)
        joint[number] = (1.0 + SAFETY) * max(_largest(across, root), 0.0)
        for i, row in enumerate(blocks):
            for j, column in enumerate(blocks[:i]):
                part = root[row, None] * across[row, column] * root[column]
                gram = part @ part.T if len(part) <= part.shape[1] else part.T @ part
                last = len(gram) - 1
                most = linalg.eigh(gram, eigvals_only=True, subset_by_index=(last, last)) if last >= 0 else [0.0]
                pairs[number, i, j] = pairs[number, j, i] = (1.0 + SAFETY) * np.sqrt(max(float(most[0]), 0.0))
    return joint, pairs


def _largest(across: FloatArray, root: FloatArray) -> float:
    """Return the largest eigenvalue of root across root."""
    n = len(root)
    if not across.any():  # one region: the iteration would have nothing to start from
        return 0.0
    if n <= FEW:
        return float(np.linalg.eigvalsh(root[:, None] * across * root).max(initial=0.0))
    scaled = LinearOperator((n, n), matvec=lambda v: root * (across @ (root * v)), dtype=np.float64)
    start = np.cos(np.arange(n, dtype=np.float64))  # fixed, so that every run gives the same
    return float(eigsh(scaled, 1, which="LA", v0=start, tol=0.1 * SAFETY, return_eigenvectors=False)[0])


def _residual(
    rows: FloatArray, n_right: int, modes: IntArray, amplitudes: FloatArray, own: BoolArray, damage: float
) -> FloatArray:
    """Return a region's residual (R_k, n_right): right side + image - own / mu."""
    n_own = int(own.sum())
    held = rows[:, rows.shape[1] - n_own :]
    return np.asarray(rows[:, :n_right] + rows[:, n_right + modes] @ amplitudes - held @ amplitudes[own] / damage)
