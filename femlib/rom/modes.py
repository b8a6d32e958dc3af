"""The modes of a reduced model: two balanced bases, one for the state and one for the outputs' sensitivity to it.

The state y(mu) and the dual z(mu) of each output (S z = p, S = diag(1 / mu) - H of femlib.components.flexibility) are
solved exactly in random joint states. For region i with snapshots Y_i and Z_i, both over the root of their number,

    Z_i' Y_i = U Sigma V',   Phi_i = Y_i V Sigma^-1/2,   Psi_i = Z_i U Sigma^-1/2,   Psi_i' Phi_i = I.

A singular value is the effect of its mode on the outputs, in their unit, so the modes of all regions are ordered and
cut together. The reduced equations are Psi' (S Phi a - g) = 0: the output's error is the product of two residuals, the
state's on Psi and the dual's on Phi. On the wing with 28 regions (refinement 0.4) 112 such modes were as exact as 240
of one common basis for states and duals.

Source: C. W. Rowley, Int. J. Bifurcation and Chaos 15 (2005) 997-1013 (balancing by snapshots of state and adjoint).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.components import DamagedStructure, PortFlexibility, port_flexibility
from femlib.components.flexibility import AT_ONCE
from femlib.errors import InputError, is_number, is_whole
from femlib.rom.bound import ErrorBound, couplings
from femlib.rom.model import ReducedModel
from femlib.rom.sweeps import eigen_turn

SNAPSHOT_TOLERANCE = 1e-8
FEW_REGIONS = 3
"""Up to so many, no mode leads: batches are solved by the regions in turns."""
LEADING = 48
"""Modes solved together with more regions: with 72 a query takes as long in fewer turns."""
WORST_TURN = 1e8
"""Condition of eigenvectors beyond which a region's modes are left as they are."""


@dataclass(frozen=True, slots=True)
class ReductionSettings:
    """Settings of the accuracy of a reduced model.

    Attributes
    ----------
    tolerance : float, optional
        Modes whose singular value is below this share of the largest are dropped. If not given, 1e-6 with up to
        `FEW_REGIONS` regions and 2e-6 with more.
    n_states, n_dual_states : int
        Random joint states in which the state is solved, and all outputs' duals.
    most_damage : float
        The random states' damages are uniform from 0 to this. Beyond it the bound still holds, the accuracy falls.
    seed : int
        Seed of the states.

    Examples
    --------
    >>> ReductionSettings(tolerance=1e-4).n_states
    600
    """

    tolerance: float | None = None
    n_states: int = 600
    n_dual_states: int = 24
    most_damage: float = 0.98
    seed: int = 0

    def __post_init__(self) -> None:
        counted = all(is_whole(n) and n >= 1 for n in (self.n_states, self.n_dual_states))
        fine = self.tolerance is None or (is_number(self.tolerance) and 0.0 < self.tolerance < 1.0)
        if not (fine and counted and is_number(self.most_damage) and 0.0 < self.most_damage < 1.0):
            raise InputError(
                f"reduction settings are tolerance {self.tolerance}, n_states {self.n_states}, "
                f"n_dual_states {self.n_dual_states}, most_damage {self.most_damage}; "
                "expected a tolerance and a damage between 0 and 1, at least 1 state of each kind; correct them"
            )

    def tolerance_for(self, n_regions: int) -> float:
        """Return the tolerance for so many regions."""
        if self.tolerance is not None:
            return self.tolerance
        return 1e-6 if n_regions <= FEW_REGIONS else 2e-6


@dataclass(frozen=True, slots=True, eq=False)
class Modes:
    """Balanced modes, the leading ones in the order of what they do to the outputs.

    Attributes
    ----------
    owner : IntArray
        Region of each mode (N,).
    trial, test : FloatArray
        Phi and Psi (R, N), zero outside the owner's measures.
    n_leading : int
        Modes from here on stand region by region, turned to the eigenvectors of their block of C.
    """

    owner: IntArray
    trial: FloatArray
    test: FloatArray
    n_leading: int


def reduce_structure(
    structure: DamagedStructure,
    load: FloatArray,
    rows: sparse.csr_array,
    outputs: Sequence[str],
    settings: ReductionSettings | None = None,
    provenance: dict[str, str] | None = None,
    with_motion: bool = False,
) -> ReducedModel:
    """Return a reduced model of outputs rows @ u for one load case.

    Parameters
    ----------
    structure, load, rows, outputs
        As those of `port_flexibility`.
    settings : ReductionSettings, optional
        How fine; the defaults if not given.
    provenance : dict, optional
        What to remember of the full model.
    with_motion : bool
        Keep what gives all displacements, in single precision. They are as exact as the outputs ask: take the work
        load' u among the outputs if they matter.

    Examples
    --------
    >>> import scipy
    >>> from femlib.structure.example import clamped_strip
    >>> full = clamped_strip()
    >>> load, rows = full.point_load("tip", (0.0, 0.0, 100.0)), scipy.sparse.csr_array(np.eye(1, 60, 56))  # z of a tip
    >>> model = reduce_structure(full.damaged, load, rows, ["tip"])
    >>> (1e3 * model.solve([[0.0], [0.5]])).round(2).ravel().tolist()  # [mm]
    [2.88, 4.56]
    """
    chosen = ReductionSettings() if settings is None else settings
    exact = port_flexibility(structure, load, rows, outputs)
    modes = balanced_modes(exact, chosen)
    motion = _motion(structure, load, exact, modes) if with_motion else None
    return _projected(exact, modes, dict(provenance or {}) | {"settings": repr(chosen)}, motion)


def reduce_ports(exact: PortFlexibility, settings: ReductionSettings | None = None) -> ReducedModel:
    """Return a reduced model of a structure's equations at its ports.

    >>> import scipy
    >>> from femlib.components import port_flexibility
    >>> from femlib.structure.example import clamped_strip
    >>> full = clamped_strip()
    >>> load, rows = full.point_load("tip", (0.0, 0.0, 100.0)), scipy.sparse.csr_array(np.eye(1, 60, 56))  # z of a tip
    >>> model = reduce_ports(port_flexibility(full.damaged, load, rows, ["tip"]))
    >>> (1e3 * model.solve([[0.0], [0.5]])).round(2).ravel().tolist()  # [mm]
    [2.88, 4.56]
    """
    chosen = ReductionSettings() if settings is None else settings
    return _projected(exact, balanced_modes(exact, chosen), {"settings": repr(chosen)}, None)


def _projected(
    exact: PortFlexibility, modes: Modes, provenance: dict[str, str], motion: FloatArray | None
) -> ReducedModel:
    """Return the equations on the modes."""
    image, dual_image = (exact.across @ basis + exact.own[:, None] * basis for basis in (modes.trial, modes.test))
    return ReducedModel(
        parameters=exact.parameters,
        outputs=exact.outputs,
        pristine=exact.pristine,
        owner=modes.owner,
        load=modes.test.T @ exact.load,
        coupling=modes.test.T @ image,
        readout=exact.readout @ modes.trial,
        interior=exact.interior,
        bound=ErrorBound(
            _residual_rows(exact, modes.owner, exact.load[:, None], image, modes.trial),
            _residual_rows(exact, modes.owner, exact.readout.T, dual_image, modes.test),
            np.minimum(exact.own, 1.0),  # what is above is rounding
            *couplings(exact.own, exact.across, exact.first),
        ),
        provenance=provenance,
        n_leading=modes.n_leading,
        motion=motion,
    )


def _motion(structure: DamagedStructure, load: FloatArray, exact: PortFlexibility, modes: Modes) -> FloatArray:
    """Return the displacements (n_dofs, N + n_parameters + 1) of each mode, each region's interior loads, the load."""
    force = load[structure.supports.free]
    interior = [condensed.interior_load(force) for condensed in structure.condensed]
    forces = np.column_stack([exact.directions @ modes.trial, *interior, force])
    active = structure.active(np.zeros((1, len(structure.parameters))))
    moved = structure.supports.expand(structure.eliminated(active).factors.solve(forces))
    return np.asarray(moved, dtype=np.float32)


def balanced_modes(exact: PortFlexibility, settings: ReductionSettings) -> Modes:
    """Return the modes that a structure's random joint states ask for."""
    rng = np.random.default_rng(settings.seed)
    n = len(exact.parameters)
    states = rng.uniform(0.0, settings.most_damage, (settings.n_states, n))
    dual_states = rng.uniform(0.0, settings.most_damage, (settings.n_dual_states, n))
    solved = _solved(exact, states, exact.load) / np.sqrt(settings.n_states)
    duals = [_solved(exact, dual_states, right) for right in exact.readout]
    stacked = np.concatenate([np.zeros((0, len(exact.load))), *duals]) / np.sqrt(settings.n_dual_states)
    return _balanced(exact, solved, stacked, settings.tolerance_for(n))


def _solved(exact: PortFlexibility, states: FloatArray, right: FloatArray) -> FloatArray:
    parts = [exact.measures(states[k : k + AT_ONCE], right, SNAPSHOT_TOLERANCE) for k in range(0, len(states), AT_ONCE)]
    return np.concatenate(parts)


def _balanced(exact: PortFlexibility, solved: FloatArray, duals: FloatArray, tolerance: float) -> Modes:
    """Return the balanced modes of snapshots (n, R) of the state and of the duals."""
    trial, test, values, owner = [], [], [], []
    for k, (begin, end) in enumerate(pairwise(exact.first)):
        # triangular factors stand for the snapshots: their products, and so U, Sigma and V', are the same
        state, dual = (_triangular(snapshots[:, begin:end]) for snapshots in (solved, duals))
        left, value, right = np.linalg.svd(dual @ state.T, full_matrices=False)
        kept = value > 1e-13 * value.max(initial=0.0)
        root = np.sqrt(value[kept])
        trial.append(state.T @ right[kept].T / root)
        test.append(dual.T @ left[:, kept] / root)
        values.append(value[kept])
        owner.append(np.full(len(root), k))
    strength = np.concatenate([np.zeros(0), *values])
    order = np.argsort(-strength, kind="stable")
    order = order[strength[order] > tolerance * strength.max(initial=0.0)]
    owners = np.concatenate([np.zeros(0, dtype=np.int64), *owner])
    n_leading = 0 if len(exact.parameters) <= FEW_REGIONS else LEADING
    phi, psi = (_gathered(blocks, exact.first)[:, order] for blocks in (trial, test))
    return _turned(exact, Modes(owners[order], phi, psi, n_leading))


def _turned(exact: PortFlexibility, modes: Modes) -> Modes:
    """Turn the modes that do not lead to the eigenvectors of their region's block of C, and put them by region."""
    first = modes.n_leading
    lead = np.arange(min(first, len(modes.owner)))
    order = np.concatenate([lead, first + np.argsort(modes.owner[first:], kind="stable")])
    owner, trial, test = modes.owner[order], modes.trial[:, order], modes.test[:, order]
    for k in np.unique(owner[first:]):
        own = (owner == k) & (np.arange(len(owner)) >= first)
        turn = eigen_turn(test[:, own].T @ (exact.own[:, None] * trial[:, own]))  # H_ii is diagonal
        if np.linalg.cond(turn) < WORST_TURN:
            trial[:, own] = trial[:, own] @ turn
            test[:, own] = test[:, own] @ np.linalg.inv(turn).T
    return Modes(owner, trial, test, first)


def _gathered(blocks: list[FloatArray], first: IntArray) -> FloatArray:
    """Return the block-diagonal matrix (R, all modes)."""
    gathered = np.zeros((int(first[-1]), sum(block.shape[1] for block in blocks)))
    column = 0
    for begin, block in zip(first, blocks, strict=False):
        gathered[begin : begin + len(block), column : column + block.shape[1]] = block
        column += block.shape[1]
    return gathered


def _residual_rows(
    exact: PortFlexibility, owner: IntArray, right: FloatArray, image: FloatArray, modes: FloatArray
) -> tuple[FloatArray, ...]:
    """Return each region's rows of (right side, image of all modes, its own modes)."""
    rows = []
    for k, (begin, end) in enumerate(pairwise(exact.first)):
        block = slice(begin, end)
        rows.append(np.concatenate([right[block], image[block], modes[block][:, owner == k]], axis=1))
    return tuple(rows)


def _triangular(matrix: FloatArray) -> FloatArray:
    """Return R of matrix = Q R: the same lengths and products of its columns with fewer rows."""
    return np.asarray(np.linalg.qr(matrix, mode="r"))
