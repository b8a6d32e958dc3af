"""Natural frequencies and modes of any damage state from few vectors, with guaranteed bounds on both sides.

letter = word: V the modes of sampled states, orthonormal in K_0; K(mu) = K_0 - sum mu_i K_i; M mass; lambda = omega^2.

Frequencies on V are never too low (Rayleigh, Ritz). How much too high they may be follows from T = K^-1 M, which is
selfadjoint in the energy of K and has the eigenvalues nu = 1 / lambda: a vector u of energy 1 has the quotient
theta = u' M u and the residual e^2 = |M u - theta K u|^2 in the norm of K^-1, and where no eigenvalue lies between
alpha < theta and nu_j (Kato, Temple),

    theta <= nu_j <= theta + e^2 / (theta - alpha),   alpha = 1 / (lower bound of lambda_(j+1)).

K(mu) >= c K(a) for any other state a, c = min over the regions of 1 and (1 - mu_i) / (1 - a_i); so e^2 is bounded by
what it is in K_0^-1, which products made once give, and lambda_(j+1) by that of every sampled state. Where the sampled
states do not part two modes, c lambda_j(a) itself is the bound.

Sources: F. Chatelin, Spectral Approximation of Linear Operators (1983), section 4.6 (Kato and Temple's inequality);
T. Horger, B. Wohlmuth, T. Dickopf, ESAIM M2AN 51 (2017) 443-465 (reduced bases for eigenvalues); the bound by sampled
states is femlib's.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as linalg
import scipy.sparse as sparse
from numpy.typing import ArrayLike

from femlib.arrays import FloatArray
from femlib.assembly import factorise
from femlib.assembly.modes import matrix_modes
from femlib.components import DamagedStructure
from femlib.components.regions import checked_damage
from femlib.errors import InputError, frozen_floats, is_whole

MOST_ALONE = 0.95
"""Damage of the sampled states in which one region is damaged."""
LEVELS = (0.5, 0.8, 0.95)
"""Damages of those in which all are damaged alike."""
ROUNDING = 1e-8
"""Relative rounding of a lambda of the full model, taken off the bounds: frequencies are never too low but for this."""
AT_ONCE = 64
"""Right sides solved together."""


@dataclass(frozen=True, slots=True, eq=False)
class ReducedModes:
    """Frequencies and modes of a structure's damage states.

    Attributes
    ----------
    parameters : tuple of str
        Names of the damage parameters.
    n_modes : int
        How many modes it answers for.
    basis : FloatArray
        V (n_dofs, N).
    losses : FloatArray
        V' K_i V (n_parameters, N, N).
    mass : FloatArray
        V' M V (N, N).
    products : FloatArray
        Products in K_0^-1 of M V, K_0 V and all K_i V ((n_parameters + 2) N, the same).
    sampled : FloatArray
        Sampled states (n_sampled, n_parameters).
    squares : FloatArray
        Their lambda (n_sampled, n_modes + 1) [1/s^2], by the full model.

    Examples
    --------
    >>> from femlib.structure.example import clamped_strip
    >>> full = clamped_strip()
    >>> model = reduce_modes(full.damaged, full.built.mass(), n_modes=1)
    >>> low, high = model.lower_bounds([[0.5]]), model.frequencies([[0.5]])
    >>> model.n_modes, bool(0.99 * high < low <= high)
    (1, True)
    """

    parameters: tuple[str, ...]
    n_modes: int
    basis: FloatArray
    losses: FloatArray
    mass: FloatArray
    products: FloatArray
    sampled: FloatArray
    squares: FloatArray

    def frequencies(self, states: ArrayLike) -> FloatArray:
        """Return the frequencies (n_states, n_modes) [Hz] of states (n_states, n_parameters); none is too low.

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)
        return _hertz(np.array([self._solved(mu)[0] for mu in damage]).reshape(len(damage), self.n_modes))

    def lower_bounds(self, states: ArrayLike) -> FloatArray:
        """Return frequencies (n_states, n_modes) [Hz] below which those of the full model are not, as `frequencies`."""
        damage = checked_damage(states, self.parameters)
        return _hertz(np.array([self._bounded(mu) for mu in damage]).reshape(len(damage), self.n_modes))

    def shapes(self, state: FloatArray) -> FloatArray:
        """Return the modes (n_modes, n_dofs) of one state (n_parameters,), scaled to a modal mass of 1 kg."""
        row = frozen_floats(state, "state", (len(self.parameters),))[None, :]
        return np.asarray((self.basis @ self._solved(checked_damage(row, self.parameters)[0])[1]).T)

    def _solved(self, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return lambda (n_modes,) and amplitudes (N, n_modes) of modal mass 1."""
        stiffness = np.eye(len(self.mass)) - np.einsum("i,ijk->jk", mu, self.losses)
        found, vectors = linalg.eigh(stiffness, self.mass, subset_by_index=(0, self.n_modes - 1))
        return np.asarray(found), np.asarray(vectors)

    def _bounded(self, mu: FloatArray) -> FloatArray:
        """Return lower bounds of lambda (n_modes,)."""
        found, vectors = self._solved(mu)
        known = self._known(mu)
        bounds = np.minimum(known[:-1], found)
        for j, (square, amplitudes) in enumerate(zip(found, vectors.T, strict=True)):
            if known[j + 1] <= square:
                continue
            energy = amplitudes / np.sqrt(square)  # of energy 1
            theta = 1.0 / square
            stacked = np.concatenate([energy, -theta * energy, *(theta * m * energy for m in mu)])
            residual = max(float(stacked @ self.products @ stacked), 0.0) + self._rounding(stacked)
            above = theta + residual / (1.0 - mu.max(initial=0.0)) / (theta - 1.0 / known[j + 1])
            bounds[j] = max(bounds[j], 1.0 / above)
        return np.asarray((1.0 - ROUNDING) * bounds)

    def _rounding(self, stacked: FloatArray) -> float:
        """Return what rounding may hide of a residual's square."""
        parts = np.sqrt(self.products.diagonal()) * np.abs(stacked)
        return float(np.finfo(float).eps * len(self.mass) * parts.max() ** 2)

    def _known(self, mu: FloatArray) -> FloatArray:
        """Return lower bounds (n_modes + 1,) of lambda by the sampled states."""
        shares = np.minimum(1.0, ((1.0 - mu) / (1.0 - self.sampled)).min(axis=1, initial=1.0))
        return np.asarray((shares[:, None] * self.squares).max(axis=0))


def reduce_modes(
    structure: DamagedStructure,
    mass: sparse.csc_array,
    n_modes: int = 4,
    tolerance: float = 5e-3,
    n_joint: int = 20,
    seed: int = 0,
) -> ReducedModes:
    """Return a reduced model of the lowest modes.

    The full model is solved in one state for each region, a few in which all are damaged alike, and random joint ones.

    Parameters
    ----------
    structure : DamagedStructure
        The full model.
    mass : csc_array
        Mass matrix (n_dofs, n_dofs), payload included; damage does not change it.
    n_modes : int
        How many modes.
    tolerance : float
        Vectors whose singular value is below this share of the largest are dropped.
    n_joint : int
        Random states of all regions, damaged by up to `MOST_ALONE`.
    seed : int
        Their seed.

    Raises
    ------
    InputError
        If a number cannot be used.

    Examples
    --------
    >>> from femlib.structure.example import clamped_strip
    >>> full = clamped_strip()
    >>> model = reduce_modes(full.damaged, full.built.mass(), n_modes=1)
    >>> model.frequencies([[0.0], [0.5]]).round(2).ravel().tolist()  # [Hz]
    [2.59, 1.99]
    """
    if not is_whole(n_joint) or n_joint < 0 or not 0.0 < tolerance < 1.0:
        raise InputError(
            f"tolerance is {tolerance!r} and n_joint {n_joint!r}; expected a share from 0 to 1 and a number of states; "
            "correct them"
        )
    sampled = _sampled(len(structure.parameters), n_joint, seed)
    squares, shapes = [], []
    for damage in sampled:
        stiffness = structure.shells.stiffness(factor=structure.stiffness_left(damage))
        modes = matrix_modes(stiffness, mass, structure.supports, n_modes + 1)
        squares.append([(2.0 * np.pi * mode.frequency) ** 2 for mode in modes])
        shapes += [mode.shape[structure.supports.free] for mode in modes]
    return _projected(structure, mass, np.array(squares), np.array(shapes).T, sampled, n_modes, tolerance)


def _projected(
    structure: DamagedStructure,
    mass: sparse.csc_array,
    squares: FloatArray,
    shapes: FloatArray,
    sampled: FloatArray,
    n_modes: int,
    tolerance: float,
) -> ReducedModes:
    """Return the model on the modes `shapes` (n_free, n) of the sampled states."""
    supports = structure.supports
    whole, heavy = supports.reduce(structure.shells.stiffness()), supports.reduce(mass)
    parts = [supports.reduce(structure.shells.stiffness(part.elements)) for part in structure.components]
    basis = orthonormal(shapes / np.sqrt(np.einsum("ij,ij->j", shapes, whole @ shapes)), whole, tolerance)
    n = basis.shape[1]
    blocks = [sparse.csc_array(matrix @ basis) for matrix in (heavy, whole, *parts)]
    images = sparse.csc_array(sparse.hstack(blocks))
    factors = factorise(whole, supports.groups)
    columns = []
    for first in range(0, images.shape[1], AT_ONCE):
        solved = factors.solve(images[:, first : first + AT_ONCE].toarray())
        columns.append(images.T @ solved)
    products = np.concatenate(columns, axis=1)
    losses = np.array([basis.T @ (part @ basis) for part in parts]).reshape(-1, n, n)
    return ReducedModes(
        structure.parameters,
        n_modes,
        supports.expand(basis),
        losses,
        np.asarray(basis.T @ (heavy @ basis)),
        0.5 * (products + products.T),
        sampled,
        squares,
    )


def _sampled(n: int, n_joint: int, seed: int) -> FloatArray:
    """Return the states (n_states, n) that the full model is solved in."""
    alone = MOST_ALONE * np.eye(n)
    alike = np.repeat(np.array(LEVELS)[:, None], n, axis=1)
    joint = np.random.default_rng(seed).uniform(0.0, MOST_ALONE, (n_joint, n))
    return np.concatenate([np.zeros((1, n)), alone, alike, joint])


def orthonormal(shapes: FloatArray, stiffness: sparse.csc_array, tolerance: float) -> FloatArray:
    """Return vectors (n, N) that span the leading part of `shapes` (n, m), orthonormal in the stiffness (n, n).

    Left out is what has less than `tolerance` of the largest singular value in that product.
    """
    for share in (tolerance, 0.5):  # the second time for the last digits
        values, vectors = np.linalg.eigh(shapes.T @ (stiffness @ shapes))
        kept = values > share**2 * values[-1]
        shapes = shapes @ (vectors[:, kept] / np.sqrt(values[kept]))
    return np.asarray(shapes)


def _hertz(squares: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(squares) / (2.0 * np.pi))
