"""A damaged structure seen from its regions: small enough to be solved exactly for thousands of states.

A region's condensed stiffness is T_i = L_i L_i'. With its strain measure y_i = mu_i L_i' u_b and K_0 u_0 = f,

    y_i / mu_i - sum_j H_ij y_j = g_i,   H_ij = L_i' K_0^-1 L_j,   g_i = L_i' u_0,
    output s = s_0 + sum_i p_i' y_i + sum_i mu_i / (1 - mu_i) q_i,   p_i = L_i' K_0^-1 c,

q_i being what the loads inside region i do to the output. The system is symmetric positive definite; since the regions'
stiffness is part of K_0, H <= I. L_i is turned so that H_ii is diagonal: a region alone needs no matrix, and the
scaled system I - w^1/2 H_ij w^1/2, w = mu / (1 - mu H_ii), is solved by conjugate gradients for many states at once.

Source: M. A. Woodbury, Inverting modified matrices, Princeton (1950); D. B. P. Huynh, D. J. Knezevic, A. T. Patera,
ESAIM M2AN 47 (2013) 213-251 (components with ports).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg as linalg
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.components.regions import Condensed, checked_damage
from femlib.components.structure import DamagedStructure, Eliminated, checked_rows
from femlib.errors import InputError, SolveError, frozen_floats

MOST_MEASURES = 15_000
"""So many need 1.8 GB."""
AT_ONCE = 128
"""States or forces solved together."""
TOLERANCE = 1e-12
"""Residual of the conjugate gradients over the load."""
MOST_STEPS = 1000
TINY = 1e-300
"""Keeps the quotients of a state that is already solved finite."""


@dataclass(frozen=True, slots=True, eq=False)
class PortFlexibility:
    """The equations of the module's docstring, exact; R measures in all.

    Attributes
    ----------
    parameters, outputs : tuple of str
        Names of the damage parameters (n_parameters,) and of the outputs (n_outputs,).
    first : IntArray
        Where each region's measures begin, and R (n_parameters + 1,).
    own : FloatArray
        Diagonals of H_ii (R,).
    across : FloatArray
        H_ij (R, R), zero within a region.
    load : FloatArray
        g (R,).
    readout : FloatArray
        p (n_outputs, R).
    pristine : FloatArray
        s_0 (n_outputs,).
    interior : FloatArray
        q (n_outputs, n_parameters).
    directions : csr_array
        L (n_free, R): forces on the free degrees of freedom.
    """

    parameters: tuple[str, ...]
    outputs: tuple[str, ...]
    first: IntArray
    own: FloatArray
    across: FloatArray
    load: FloatArray
    readout: FloatArray
    pristine: FloatArray
    interior: FloatArray
    directions: sparse.csr_array

    @property
    def owner(self) -> IntArray:
        """Region of each measure (R,)."""
        return np.repeat(np.arange(len(self.parameters)), np.diff(self.first))

    def solve(self, states: FloatArray) -> FloatArray:
        """Return the outputs (n_states, n_outputs) at unit load of damage states (n_states, n_parameters), exactly.

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)
        outputs = self.pristine + (damage / (1.0 - damage)) @ self.interior.T
        for k in range(0, len(damage), AT_ONCE):
            outputs[k : k + AT_ONCE] += self.measures(damage[k : k + AT_ONCE], self.load) @ self.readout.T
        return np.asarray(outputs)

    def measures(self, damage: FloatArray, right: FloatArray, tolerance: float = TOLERANCE) -> FloatArray:
        """Return y (n_states, R) of checked states (n_states, n_parameters) for a right side (R,).

        Raises
        ------
        SolveError
            If the conjugate gradients do not reach `tolerance`.
        """
        mu = damage[:, self.owner]
        root = np.sqrt(mu / (1.0 - mu * self.own))
        remainder = root * right
        solution, direction = np.zeros_like(root), remainder
        square = np.einsum("sn,sn->s", remainder, remainder)
        target = tolerance**2 * square
        for _ in range(MOST_STEPS):
            if (square <= target).all():
                return np.asarray(root * solution)
            image = direction - root * ((root * direction) @ self.across)
            step = square / np.maximum(np.einsum("sn,sn->s", direction, image), TINY)
            solution = solution + step[:, None] * direction
            remainder = remainder - step[:, None] * image
            next_square = np.einsum("sn,sn->s", remainder, remainder)
            direction = remainder + (next_square / np.maximum(square, TINY))[:, None] * direction
            square = next_square
        raise SolveError(
            f"port system did not converge to {tolerance} in {MOST_STEPS} steps (left: {np.sqrt(square.max()):.2g}); "
            "expected damages away from 1; lower them"
        )


def port_flexibility(
    structure: DamagedStructure, load: FloatArray, rows: sparse.csr_array, outputs: Sequence[str]
) -> PortFlexibility:
    """Return a structure's equations at its ports, for one load case.

    Costs R^2 numbers of memory and, beyond `MOST_PORTS` ports, one solve with the undamaged factors for each measure.

    Parameters
    ----------
    structure : DamagedStructure
        The full model.
    load : FloatArray
        Nodal forces (n_dofs,) at unit load [N].
    rows : csr_array
        Map (n_outputs, n_dofs) from displacements to outputs.
    outputs : sequence of str
        Names of the outputs.

    Raises
    ------
    InputError
        If a load is not finite, names and rows differ in number, or the ports are too many to be held.
    """
    checked_rows(rows, structure.supports.n_dofs)
    if len(outputs) != rows.shape[0]:
        raise InputError(
            f"{len(outputs)} output names but {rows.shape[0]} rows; expected one name per row; complete them"
        )
    force = frozen_floats(load, "load", (structure.supports.n_dofs,))[structure.supports.free]
    free_rows = sparse.csr_array(rows)[:, structure.supports.free]
    # the same elimination as the structure's own solutions: whoever asks both factorises once
    eliminated = structure.eliminated(structure.active(np.zeros((1, len(structure.parameters)))))
    factors = eliminated.factors
    # column 0: the state; then each output's dual
    motions = factors.solve(np.concatenate([force[:, None], free_rows.toarray().T], axis=1))
    roots = [_root(condensed) for condensed in structure.condensed]
    first = np.concatenate([[0], np.cumsum([root.shape[1] for root in roots])]).astype(np.int64)
    if first[-1] > MOST_MEASURES:
        raise InputError(
            f"the regions have {first[-1]} port measures; expected at most {MOST_MEASURES}, whose couplings fit into "
            "memory; coarsen the mesh or take fewer regions"
        )
    directions = _directions(structure.condensed, roots, len(force))
    own, across, directions = _diagonalised(_coupling(eliminated, directions), first, directions)
    seen = directions.T @ motions
    interior = [condensed.interior_load(force) @ motions[:, 1:] for condensed in structure.condensed]
    return PortFlexibility(
        parameters=structure.parameters,
        outputs=tuple(outputs),
        first=first,
        own=own,
        across=across,
        load=seen[:, 0],
        readout=np.ascontiguousarray(seen[:, 1:].T),
        pristine=free_rows @ motions[:, 0],
        interior=np.array(interior).reshape(-1, len(outputs)).T,
        directions=directions,
    )


def _root(condensed: Condensed) -> FloatArray:
    """Return L of T = L L' (n_ports, rank), without the rigid motions, which cost no energy."""
    values, vectors = np.linalg.eigh(condensed.stiffness)
    elastic = values > 1e-12 * values[-1]
    return np.asarray(vectors[:, elastic] * np.sqrt(values[elastic]))


def _directions(condensed: Sequence[Condensed], roots: Sequence[FloatArray], n_free: int) -> sparse.csr_array:
    """Return all L side by side as forces (n_free, R)."""
    rows = [np.repeat(c.ports, root.shape[1]) for c, root in zip(condensed, roots, strict=True)]
    first = np.cumsum([0, *(root.shape[1] for root in roots)])
    columns = [start + np.tile(np.arange(root.shape[1]), len(root)) for start, root in zip(first, roots, strict=False)]
    none = np.zeros(0)
    triplets = (
        np.concatenate([none, *(root.ravel() for root in roots)]),
        (np.concatenate([none, *rows]).astype(np.int64), np.concatenate([none, *columns]).astype(np.int64)),
    )
    return sparse.csr_array(sparse.coo_array(triplets, shape=(n_free, int(first[-1]))))


def _coupling(eliminated: Eliminated, directions: sparse.csr_array) -> FloatArray:
    """Return H = L' K_0^-1 L (R, R).

    L acts on the ports alone and there K_0^-1 is the inverse of the condensed stiffness: where all ports are eliminated
    last, H is that of a dense matrix and costs no solve with the factors. For two regions: 0.4 CPU s instead of 2.5.
    """
    n, factors = directions.shape[1], eliminated.factors
    if len(factors.ports):
        at_ports = directions[factors.ports].toarray()
        return np.asarray(at_ports.T @ linalg.solve(eliminated.ports.schur, at_ports, assume_a="pos"))
    by_column, across = sparse.csc_array(directions), np.empty((n, n))
    for k in range(0, n, AT_ONCE):
        across[:, k : k + AT_ONCE] = directions.T @ factors.solve(by_column[:, k : k + AT_ONCE].toarray())
    return across


def _diagonalised(
    coupling: FloatArray, first: IntArray, directions: sparse.csr_array
) -> tuple[FloatArray, FloatArray, sparse.csr_array]:
    """Turn each region's measures so that H_ii is diagonal; return the diagonals, H without them, and L turned.

    `coupling` is overwritten: at 6,000 measures a copy would be 0.3 GB.
    """
    own, turns = np.empty(len(coupling)), []
    for begin, end in pairwise(first):
        block = slice(begin, end)
        held = coupling[block, block]
        own[block], turn = np.linalg.eigh(0.5 * (held + held.T))
        coupling[block] = turn.T @ coupling[block]
        coupling[:, block] = coupling[:, block] @ turn
        coupling[block, block] = 0.0
        turns.append(turn)
    for k in range(0, len(coupling), AT_ONCE):  # symmetric to the last digit, in strips
        mean = 0.5 * (coupling[k : k + AT_ONCE] + coupling[:, k : k + AT_ONCE].T)
        coupling[k : k + AT_ONCE], coupling[:, k : k + AT_ONCE] = mean, mean.T
    turned = directions @ sparse.block_diag(turns, format="csr") if turns else directions
    return own, coupling, sparse.csr_array(turned)
