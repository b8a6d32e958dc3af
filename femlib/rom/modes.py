"""The modes of a reduced model: what each component does when it is damaged alone and in company.

For component i alone, (1 / mu - H_ii) y = b has its solutions in the Krylov space of H_ii and b, whatever mu. The
loads b are the state's and every output's dual (local and dual snapshots), then what the other components put on it in
joint states (joint snapshots). The solutions at a few mu are compressed by a singular value decomposition.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as linalg
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Factors
from femlib.components import Condensed, DamagedStructure
from femlib.errors import InputError
from femlib.rom.model import ReducedModel

DAMAGES = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)
"""Damages at which the components are solved for their modes."""


@dataclass(frozen=True, slots=True)
class ReductionSettings:
    """How fine the reduced model is.

    Attributes
    ----------
    tolerance : float
        Singular values below this share of the largest are dropped.
    n_krylov : int
        Powers of H_ii in a component's space. With 5 the strain inside a region was 100 microstrain off at 95 % damage.
    n_joint : int
        Random joint states from which the components learn of each other; 0 = local and dual modes only.
    dual_weight : float
        Weight of the outputs' duals beside the state's own load, 0 to leave them out. Duals square the accuracy a mode
        buys, at many modes more: a gauge inside a region needs its own.
    seed : int
        Seed of the joint states.
    """

    tolerance: float = 1e-5
    n_krylov: int = 30
    n_joint: int = 20
    dual_weight: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        if not 0.0 < self.tolerance < 1.0 or self.n_krylov < 1 or self.n_joint < 0:
            raise InputError(
                f"reduction settings are tolerance {self.tolerance}, n_krylov {self.n_krylov}, n_joint {self.n_joint}; "
                "expected a tolerance between 0 and 1, at least 1 power and 0 or more joint states; correct them"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """The modes of one component and what they do to the whole structure.

    Attributes
    ----------
    basis : FloatArray
        Orthonormal modes in the component's strain measure (rank, n_modes).
    moved : FloatArray
        Displacements of all free degrees of freedom under each mode, K_0^-1 L basis (n_free, n_modes).
    """

    basis: FloatArray
    moved: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """A component's strain measure: L of T = L L' (n_ports, rank) and its ports."""

    ports: IntArray
    root: FloatArray

    @classmethod
    def of(cls, condensed: Condensed) -> "Measure":
        """Return the measure without the rigid motions, which cost no energy."""
        values, vectors = np.linalg.eigh(condensed.stiffness)
        elastic = values > 1e-12 * values[-1]
        return cls(condensed.ports, vectors[:, elastic] * np.sqrt(values[elastic]))

    def of_motion(self, motion: FloatArray) -> FloatArray:
        """Return L' u at the ports (rank, ...) of free displacements (n_free, ...)."""
        return np.asarray(self.root.T @ motion[self.ports])

    def respond(self, factors: Factors, measures: FloatArray) -> FloatArray:
        """Return K_0^-1 L x (n_free, n) for measures x (rank, n)."""
        forces = np.zeros((len(factors.order), measures.shape[1]))
        forces[self.ports] = self.root @ measures
        return factors.solve(forces)


def reduce_structure(
    structure: DamagedStructure,
    load: FloatArray,
    rows: sparse.csr_array,
    outputs: Sequence[str],
    settings: ReductionSettings | None = None,
    provenance: dict[str, str] | None = None,
) -> ReducedModel:
    """Return a reduced model of outputs rows @ u for one load case.

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
    settings : ReductionSettings, optional
        How fine; the defaults if not given.
    provenance : dict, optional
        What to remember of the full model.
    """
    chosen = ReductionSettings() if settings is None else settings
    factors = structure.eliminated(()).factors
    free_rows = sparse.csr_array(rows)[:, structure.supports.free]
    force = load[structure.supports.free]
    # column 0: the state; then each output's dual
    motions = factors.solve(np.concatenate([force[:, None], free_rows.toarray().T], axis=1))
    measures = [Measure.of(condensed) for condensed in structure.condensed]
    loads = [measure.of_motion(motions) for measure in measures]
    wanted = [_weighted(load, chosen.dual_weight) for load in loads]
    spaces = [_space(m, factors, b, chosen) for m, b in zip(measures, wanted, strict=True)]
    if chosen.n_joint and len(measures) > 1:
        joint = _joint_loads(measures, loads, spaces, chosen)
        spaces = [_space(m, factors, b, chosen) for m, b in zip(measures, joint, strict=True)]
    interior = np.stack([c.interior_load(force) @ motions[:, 1:] for c in structure.condensed], axis=1)
    coupling, residual = _projected(measures, loads, spaces)
    gathered = np.concatenate([s.basis.T @ b for s, b in zip(spaces, loads, strict=True)])
    return ReducedModel(
        parameters=structure.parameters,
        outputs=tuple(outputs),
        pristine=free_rows @ motions[:, 0],
        owner=np.repeat(np.arange(len(spaces)), [s.basis.shape[1] for s in spaces]),
        load=gathered[:, 0],
        coupling=coupling,
        readout=gathered[:, 1:].T,
        interior=interior,
        residual=residual,
        provenance=dict(provenance or {}) | {"settings": repr(chosen)},
    )


def _space(measure: Measure, factors: Factors, loads: FloatArray, settings: ReductionSettings) -> Space:
    """Return the modes of a component for loads (rank, n), from the Krylov space that begins with them."""
    krylov, moved = np.zeros((len(loads), 0)), np.zeros((len(factors.order), 0))
    block = _compressed(loads, 0.1 * settings.tolerance)
    for _ in range(settings.n_krylov):
        if block.shape[1] == 0:
            break
        krylov = np.concatenate([krylov, block], axis=1)
        moved = np.concatenate([moved, measure.respond(factors, block)], axis=1)
        block = _beyond(krylov, measure.of_motion(moved[:, -block.shape[1] :]))
    own = krylov.T @ measure.of_motion(moved)
    own = 0.5 * (own + own.T)
    right = krylov.T @ loads
    # mu (I - mu H)^-1 b over mu: the size of y varies with the state, its shape counts
    solved = [np.linalg.solve(np.eye(len(own)) - mu * own, right) for mu in DAMAGES]
    modes = _compressed(np.concatenate(solved, axis=1), settings.tolerance)
    # turned so that H_ii is diagonal: a component alone is then solved without a matrix
    modes = modes @ np.linalg.eigh(modes.T @ own @ modes)[1]
    return Space(krylov @ modes, moved @ modes)


def _beyond(held: FloatArray, image: FloatArray) -> FloatArray:
    """Return an orthonormal basis of the part of `image` (rank, n) that the orthonormal columns `held` do not span."""
    fresh = image - held @ (held.T @ image)
    left, values, _ = np.linalg.svd(fresh, full_matrices=False)
    # H <= 1, so a part below 1e-10 is rounding, whatever the size of the rest
    fresh = left[:, values > 1e-10]
    fresh = fresh - held @ (held.T @ fresh)  # once more: normalising a small part magnifies what one pass left
    return np.asarray(np.linalg.qr(fresh)[0])


def _joint_loads(
    measures: list[Measure], loads: list[FloatArray], spaces: list[Space], settings: ReductionSettings
) -> list[FloatArray]:
    """Return for each component its loads in random joint states, what the others put on it included (rank, n)."""
    rng = np.random.default_rng(settings.seed)
    coupling, _ = _projected(measures, loads, spaces)
    right = np.concatenate([s.basis.T @ b for s, b in zip(spaces, loads, strict=True)])
    owner = np.repeat(np.arange(len(spaces)), [s.basis.shape[1] for s in spaces])
    joint = [[_weighted(load, settings.dual_weight)] for load in loads]
    damages = np.concatenate([_pairs(len(measures)), rng.uniform(0.1, 0.95, (settings.n_joint, len(measures)))])
    for state in damages:
        mu = np.maximum(state, 1e-9)[owner]
        amplitudes = linalg.solve(np.diag(1.0 / mu) - coupling, right, assume_a="pos")
        shares = [s.moved @ amplitudes[owner == k] for k, s in enumerate(spaces)]
        total = np.sum(shares, axis=0)
        for k, (measure, load) in enumerate(zip(measures, loads, strict=True)):
            if state[k] > 0.0:
                seen = load + measure.of_motion(total - shares[k])
                joint[k].append(_weighted(seen, settings.dual_weight))
    return [np.concatenate(parts, axis=1) for parts in joint]


def _pairs(n: int) -> FloatArray:
    """Return the states (n_pairs, n) in which two of n components are half or heavily damaged."""
    states = [np.where(np.isin(np.arange(n), (i, j)), 0.85, 0.0) for i in range(n) for j in range(i)]
    return np.array(states)


def _projected(
    measures: list[Measure], loads: list[FloatArray], spaces: list[Space]
) -> tuple[FloatArray, tuple[FloatArray, ...]]:
    """Return H on all modes (N, N), and each component's triangular factor of what its modes cannot hold."""
    moved = np.concatenate([space.moved for space in spaces], axis=1)
    rows, residual = [], []
    for measure, load, space in zip(measures, loads, spaces, strict=True):
        image = measure.of_motion(moved)
        rows.append(space.basis.T @ image)
        seen = np.concatenate([load, image], axis=1)
        residual.append(np.asarray(np.linalg.qr(seen - space.basis @ (space.basis.T @ seen), mode="r")))
    coupling = np.concatenate(rows)
    return 0.5 * (coupling + coupling.T), tuple(residual)


def _compressed(columns: FloatArray, tolerance: float) -> FloatArray:
    """Return an orthonormal basis of columns, but for the part below `tolerance` of the largest singular value."""
    if columns.shape[1] == 0:
        return columns
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, values > tolerance * values[0]])


def _weighted(loads: FloatArray, dual_weight: float) -> FloatArray:
    """Return the state's load (column 0) at unit length, and the duals at `dual_weight`, left out if it is zero."""
    if dual_weight == 0.0:
        loads = loads[:, :1]
    length = np.linalg.norm(loads, axis=0)
    weights = np.where(np.arange(loads.shape[1]) == 0, 1.0, dual_weight)
    return np.asarray(loads * (weights / np.where(length > 0.0, length, 1.0)))
