"""Capability: the greatest factor on a load that a structure bears in any damage state, in milliseconds.

Three limits, each a factor on the load, of which the least counts: a ply fails (`femlib.strength`: closed form along
the ray of loads), the shells buckle (`femlib.rom.buckling`), a displacement reaches what is allowed. Strains are those
of the reduced model at the corners that came near failing first in sampled states.

Finer meshes of single regions turn the factors of plies into those of fine meshes (`femlib.rom.zones`). The error is
checked, not bounded: `error` is the largest distance from the full model, on the same mesh, over states that were drawn
apart from the sampled ones; `mesh_error` is measured on finer meshes of components and of pairs of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import buckling_modes
from femlib.assembly.stresses import Block, Faces, block_factors, blocks_of, corner_strains
from femlib.components import DamagedStructure
from femlib.components.regions import checked_damage
from femlib.errors import InputError, is_number, is_whole
from femlib.rom.buckling import ReducedBuckling, Sampled, reduce_buckling
from femlib.rom.model import ReducedModel
from femlib.rom.zones import Finer, Zones, measured_zones, zone_needs, zone_of_corners

LIMITS = ("ply", "buckling", "deflection")
NEAR = 1.25
"""A corner is kept if in some sampled state its factor is within this of the least."""
FAR = 1e3
"""A limit this many times beyond the least is none: a strip that only bends does not buckle."""
MOST_KEPT = 400
"""Corners and heights kept, those that came nearest."""
WORST, HALF = 0.9, 0.5
"""Damages of a region alone in the states whose buckling modes are solved; the drawn states have the first at most."""


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """What a structure must not reach.

    Attributes
    ----------
    row : FloatArray
        Map (n_dofs,) from displacements to the deflection that is limited.
    most_deflection : float
        Its limit [m], of either sign.
    criterion : str
        Of failing plies, one of `femlib.strength.CRITERIA`.
    faces : sequence, optional
        Plies and heights of each laminate, as for `femlib.assembly.stresses.blocks_of`.
    length : float
        Length that the strains of plies are means over [m]; 0 for those of points, which have no limit in the corner of
        a damage region.
    """

    row: FloatArray
    most_deflection: float
    criterion: str = "max strain"
    faces: Sequence[Faces] | None = None
    length: float = 0.0

    def __post_init__(self) -> None:
        if not is_number(self.most_deflection) or self.most_deflection <= 0.0:
            raise InputError(f"most_deflection is {self.most_deflection!r}; expected more than 0 m; correct it")


@dataclass(frozen=True, slots=True, eq=False)
class Capability:
    """Greatest factors on a load.

    Attributes
    ----------
    model : ReducedModel
        Gives the parts of a state.
    blocks : tuple of Block
        The kept corners; their rows are `strains`.
    strains : NDArray[np.float32]
        Strains (n, 3, n_parts) in fibre axes of the model's parts.
    buckling : ReducedBuckling
        The reduced buckling equations.
    deflection : FloatArray
        The limited deflection over its limit, of each part (n_parts,).
    criterion : str
        Of failing plies.
    error : float
        Largest relative error of a limit against the full model over the checked states; NaN if none.
    mesh_error : float
        Estimated relative error of the plies' factors by the mesh, `Zones.error`; NaN without finer meshes.
    zones : Zones, optional
        What finer meshes make of the plies' factors.
    zone : IntArray, optional
        Zone of each row of `strains` (n,).
    """

    model: ReducedModel
    blocks: tuple[Block, ...]
    strains: NDArray[np.float32]
    buckling: ReducedBuckling
    deflection: FloatArray
    criterion: str
    error: float = float("nan")
    mesh_error: float = float("nan")
    zones: Zones | None = None
    zone: IntArray | None = None

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters: the columns of a state array."""
        return self.model.parameters

    def limits(self, states: ArrayLike) -> FloatArray:
        """Return the factors (n_states, 3) at which each of `LIMITS` is reached, of states (n_states, n_parameters).

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)
        return np.array([self._limits(row) for row in damage]).reshape(-1, len(LIMITS))

    def load_factors(self, states: ArrayLike) -> FloatArray:
        """Return the greatest factors (n_states,) that states (n_states, n_parameters) bear, as `limits`."""
        damage = checked_damage(states, self.parameters)
        return np.array([self._load_factor(row) for row in damage]).reshape(-1)

    def failure_probability(self, states: ArrayLike, factor: float, spread: float) -> FloatArray:
        """Return the probability (n_states,) that states do not bear a factor, of lognormal limits.

        `spread` is the standard deviation of a limit's logarithm: of moduli, strengths and loads together.
        """
        if not is_number(factor) or not is_number(spread) or factor <= 0.0 or spread <= 0.0:
            raise InputError(f"factor is {factor!r} and spread {spread!r}; expected numbers above 0; correct them")
        return np.asarray(ndtr(np.log(factor / self.load_factors(states)) / spread))

    def _load_factor(self, damage: FloatArray) -> float:
        """Return the least limit; that of buckling is found only where it is the least."""
        parts = self.model.parts(damage[None])[0]
        least = min(self._strained(damage, parts))
        return least if self.buckling.holds(damage, parts, least) else self.buckling.factor(damage, parts)

    def _limits(self, damage: FloatArray) -> tuple[float, float, float]:
        parts = self.model.parts(damage[None])[0]
        ply, deflection = self._strained(damage, parts)
        return ply, self.buckling.factor(damage, parts), deflection

    def _strained(self, damage: FloatArray, parts: FloatArray) -> tuple[float, float]:
        """Return the factors at which a ply fails and at which the deflection is reached."""
        own = self.strains.reshape(-1, len(parts)) @ parts.astype(self.strains.dtype)  # one product, not one a corner
        factors = block_factors(self.blocks, own.reshape(-1, 3).astype(np.float64), self.criterion)
        if self.zones is not None:
            factors /= self.zones.grown(damage)[self.zone]
        return float(factors.min()), 1.0 / max(abs(float(self.deflection @ parts)), 1e-300)


def reduce_capability(
    structure: DamagedStructure,
    model: ReducedModel,
    limits: Limits,
    load: FloatArray,
    n_states: int = 300,
    n_checks: int = 6,
    seed: int = 0,
    finer: Finer | None = None,
) -> Capability:
    """Return the capability under the load that a reduced model was made for.

    Parameters
    ----------
    structure : DamagedStructure
        The full model, of shells alone whose plies have strengths.
    model : ReducedModel
        Its reduced model, with motion.
    limits : Limits
        What must not be reached.
    load : FloatArray
        Load at factor 1 (n_dofs,) [N, N m] that the model stands for.
    n_states, n_checks : int
        Random states that are sampled by the reduced model, and that are checked against the full one.
    seed : int
        Of both.
    finer : Finer, optional
        As for `femlib.rom.zones.measured_zones`.

    Raises
    ------
    InputError
        If the model holds no motion, or a ply has no strength.
    """
    if model.motion is None:
        raise InputError("this reduced model holds no displacements; reduce the structure with with_motion=True")
    if not is_whole(n_states) or not is_whole(n_checks) or n_states < 1 or n_checks < 0:
        raise InputError(f"n_states is {n_states!r} and n_checks {n_checks!r}; expected 1 or more and 0 or more")
    rng = np.random.default_rng(seed)
    motion = np.asarray(model.motion, dtype=np.float64)
    each = np.eye(len(model.parameters))
    alone = np.concatenate([0.0 * each[:1], WORST * each, HALF * each])
    drawn = np.concatenate([alone, drawn_states(rng, n_states, len(model.parameters))])
    solved, forced = (Sampled(states, model.parts(states)) for states in (alone, drawn))
    every = blocks_of(structure.shells, limits.faces)
    of_parts = np.stack([corner_strains(structure.shells, column, limits.length) for column in motion.T], axis=2)
    zones = None
    if finer is not None:
        own = zone_of_corners(structure)
        zones = measured_zones(
            structure,
            lambda state: zone_needs(every, of_parts @ model.parts(state[None])[0], limits.criterion, own),
            finer,
        )
    kept = _kept(every, of_parts, limits.criterion, forced, zones)
    strains = np.concatenate([np.moveaxis(block.strain(of_parts), -1, 1) for block in kept])
    strains = strains.astype(np.float32)  # as the model's motion is; the product takes what memory takes to be read
    zone = None if zones is None else zones.of_corner[np.concatenate([block.corners for block in kept])]
    buckling = reduce_buckling(structure, motion, solved, forced)
    deflection = limits.row @ motion / limits.most_deflection
    off = float("nan") if zones is None else zones.error
    found = Capability(
        model, kept, strains, buckling, deflection, limits.criterion, mesh_error=off, zones=zones, zone=zone
    )
    states = drawn_states(rng, n_checks, len(model.parameters))
    full = [full_limits(structure, limits, load, state, zones) for state in states]
    if not n_checks:
        return found
    most = FAR * np.min(full, axis=1, keepdims=True)
    errors = np.abs(np.minimum(found.limits(states), most) / np.minimum(full, most) - 1.0)
    return replace(found, error=float(errors.max()))


def drawn_states(rng: np.random.Generator, n: int, n_parameters: int) -> FloatArray:
    """Return random states (n, n_parameters): one region damaged, two, three, or all, by up to 90 %, in turns."""
    states = np.zeros((n, n_parameters))
    for k, row in enumerate(states):
        most = (1, 2, 3, n_parameters)[k % 4]
        hit = rng.choice(n_parameters, min(most, n_parameters), replace=False)
        row[hit] = rng.uniform(0.0, WORST, len(hit))
    return states


def full_limits(
    structure: DamagedStructure, limits: Limits, load: FloatArray, state: FloatArray, zones: Zones | None = None
) -> FloatArray:
    """Return the factors (3,) of `LIMITS` of one state (n_parameters,) by the full model."""
    shells = structure.shells
    moved = structure.solve(state[None], load)[0]
    left = structure.stiffness_left(state)
    modes = buckling_modes(shells, structure.supports, load, 1, left, limit=np.finfo(float).max, is_refined=False)
    factor = modes[0].factor if modes else float("inf")
    return np.array(
        [
            first_ply(structure, limits, moved, None if zones is None else zones.grown(state)),
            factor,
            limits.most_deflection / max(abs(float(limits.row @ moved)), 1e-300),
        ]
    )


def first_ply(structure: DamagedStructure, limits: Limits, moved: FloatArray, grown: FloatArray | None = None) -> float:
    """Return the factor on displacements (n_dofs,) at which the first ply fails; `grown` as `Zones.grown`."""
    needs = _needs(structure, limits, moved)
    return 1.0 / float((needs if grown is None else needs * grown).max())


def full_needs(structure: DamagedStructure, limits: Limits, load: FloatArray, states: FloatArray) -> FloatArray:
    """Return `zone_needs` (n_states, n_zones) of states (n_states, n_parameters) by the full model."""
    return np.array([_needs(structure, limits, moved) for moved in structure.solve(states, load)])


def _needs(structure: DamagedStructure, limits: Limits, moved: FloatArray) -> FloatArray:
    strains = corner_strains(structure.shells, moved, limits.length)
    every = blocks_of(structure.shells, limits.faces)
    return zone_needs(every, strains, limits.criterion, zone_of_corners(structure))


def _kept(
    every: Sequence[Block], of_parts: FloatArray, criterion: str, forced: Sampled, zones: Zones | None
) -> tuple[Block, ...]:
    """Return the corners that come near failing first in sampled states; `of_parts` (n_corners, 6, n_parts)."""
    near = [np.full(len(block.corners), np.inf) for block in every]
    for state, part in zip(forced.states, forced.parts, strict=True):
        strains = of_parts @ part
        factors = [block.factors(block.strain(strains), criterion) for block in every]
        if zones is not None:
            grown = zones.grown(state)[zones.of_corner]
            factors = [own / grown[block.corners] for block, own in zip(every, factors, strict=True)]
        least = min(float(own.min()) for own in factors)
        near = [np.minimum(old, own / least) for old, own in zip(near, factors, strict=True)]
    most = min(NEAR, float(np.sort(np.concatenate(near))[: MOST_KEPT + 1][-1]))
    kept = [replace(b, corners=b.corners[own <= most]) for b, own in zip(every, near, strict=True)]
    return tuple(block for block in kept if len(block.corners))
