"""A structure of the user's own: a named mesh with sections, supports and damage regions."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sparse

from femlib import sensors
from femlib.arrays import FloatArray, Judged, judged
from femlib.assembly import (
    MOST_ERROR,
    BucklingMode,
    Judge,
    Mode,
    Quality,
    Shells,
    Stresses,
    Supports,
    buckling_modes,
    natural_modes,
    ply_stresses,
)
from femlib.assembly.buckling import is_buckled
from femlib.assembly.built_up import BuiltUp
from femlib.assembly.peaks import MOST_PEAK_ERROR, checked_peak
from femlib.assembly.quality import refuse_error, relative_distance
from femlib.assembly.refined import MOST_UNKNOWNS
from femlib.components import DamagedStructure, damage_row
from femlib.errors import InputError, SolveError, frozen_floats
from femlib.kept import Kept, ReadOnly
from femlib.mesh import DOFS_PER_NODE
from femlib.rom import ReductionSettings
from femlib.rom.capability import Capability
from femlib.sensors import StrainGauge, checked_strains
from femlib.structure import loads
from femlib.structure.named_mesh import NamedMesh
from femlib.structure.parts import Parts, Section, Spring, component_of, held_dofs, parts_of
from femlib.structure.strength import structure_capability, structure_limits

MICRO = 1e6
MOST_GAUGE_ERROR = 0.1
"""Estimated error of gauge strains beyond which they are refused."""
JUDGED = 0.8
"""Damage of all regions in which the mesh of a capability is judged."""
LIGHT = 1e-3
"""Share of the load that a structure bears under which its mesh is judged: errors are relative, and nothing buckles."""


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """A supported structure of shells, beams, springs and masses, with damage regions.

    Attributes
    ----------
    mesh : NamedMesh
        Nodes, elements, and their sets; from `read`.
    sections : mapping
        A `Laminate` for each set of shells, a `BeamSection` for each set of lines that are beams.
    supports : mapping
        What is held of each node set: "clamped", "pinned", or directions as "x z ry", in global axes. On rollers
        hold the rotation about the shells' normal too: with it free an edge is 2.35 % too soft on 8 x 4 elements.
    damage : sequence of str
        Element sets, or springs by name, whose stiffness may be lost; their names are the damage parameters.
    masses : mapping
        Mass of each node set [kg], shared equally by its nodes.
    springs : sequence of Spring
        Springs to the ground or between nodes.
    axis : FloatArray
        Global direction (3,) whose projection on a shell is its laminate's axis.
    parts : Parts
        The parts, numbered shells, beams, springs.
    damaged : DamagedStructure
        The same, ready to be solved in any damage state.
    judge : Judge
        What estimates the error of its solutions.

    Raises
    ------
    InputError
        If a name is unknown, a set empty, a shell without section, or a part can move freely.

    Examples
    --------
    >>> import meshio
    >>> from femlib.material import isotropic_plate
    >>> points = [[x, y, 0] for x in range(5) for y in range(2)]
    >>> quads = [[k, k + 2, k + 3, k + 1] for k in (0, 2, 4, 6)]
    >>> sets = {"cell_sets": {"strip": [[0, 1, 2, 3]], "root": [[0]]}, "point_sets": {"foot": [0, 1], "tip": [8, 9]}}
    >>> from femlib import read
    >>> mesh = read(meshio.Mesh(points, [("quad", quads)], **sets))
    >>> plate = isotropic_plate(70e9, 0.0, 0.05, 2700.0, expansion=2e-5)
    >>> structure = Structure(mesh, {"strip": plate}, {"foot": "clamped"}, damage=["root"])
    >>> load = structure.point_load("tip", (0.0, 0.0, 100.0))
    >>> [round(1e3 * float(structure.solve(state, load)[-1, 2]), 2) for state in ({}, {"root": 0.5})]  # at the tip [mm]
    [2.88, 4.56]
    """

    mesh: NamedMesh
    sections: Mapping[str, Section]
    supports: Mapping[str, str]
    damage: Sequence[str] = ()
    masses: Mapping[str, float] = field(default_factory=lambda: ReadOnly({}))
    springs: Sequence[Spring] = ()
    axis: FloatArray = (1.0, 0.0, 0.0)  # type: ignore[assignment]  # frozen as an array below
    parts: Parts = field(init=False, repr=False)
    damaged: DamagedStructure = field(init=False, repr=False)
    judge: Judge = field(init=False, repr=False)
    _buckled: Kept[str, bool] = field(init=False, repr=False, default_factory=Kept)
    _gauge_errors: Kept[str, float] = field(init=False, repr=False, default_factory=Kept)

    def __post_init__(self) -> None:
        if not isinstance(self.mesh, NamedMesh):
            raise InputError(f"mesh is a {type(self.mesh).__name__}; expected a NamedMesh; make it with read")
        object.__setattr__(self, "axis", frozen_floats(self.axis, "axis", (3,)))
        for name in ("sections", "supports", "masses"):
            if not isinstance(getattr(self, name), Mapping):
                raise InputError(f"{name} are a {type(getattr(self, name)).__name__}; expected them by set name")
            object.__setattr__(self, name, ReadOnly(getattr(self, name)))
        if isinstance(self.damage, str):
            raise InputError(f"damage is {self.damage!r}; expected a list of set names; put it in a list")
        parts = parts_of(self.mesh, self.sections, self.masses, self.springs, self.axis)
        object.__setattr__(self, "parts", parts)
        held = held_dofs(self.mesh, self.supports)
        if not held.size and not len(parts.built.springs.grounded):
            raise InputError(
                "the structure has no support; expected nodes that are held, or springs to the ground; give supports"
            )
        supports = Supports.holding(parts.built.mesh, held, parts.built.links, parts.built.springs.grounded)
        components = tuple(component_of(self.mesh, parts, name) for name in self.damage)
        object.__setattr__(self, "damaged", DamagedStructure(parts.built, supports, components))
        object.__setattr__(self, "judge", Judge(parts.built, supports))

    @property
    def built(self) -> BuiltUp:
        """Shells, beams, springs and point masses."""
        return self.parts.built

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters: the columns of a state array."""
        return self.damaged.parameters

    @property
    def total_mass(self) -> float:
        """Mass of everything [kg]."""
        along_x = np.tile([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], len(self.mesh.nodes))
        return float(along_x @ (self.built.mass() @ along_x))

    @property
    def model_hash(self) -> str:
        """SHA-256 of everything that the stiffness depends on."""
        digest = hashlib.sha256()
        stiffness = self.built.stiffness()
        for array in (self.mesh.nodes, stiffness.data, stiffness.indices, self.damaged.supports.free):
            digest.update(np.ascontiguousarray(array).tobytes())
        for component in self.damaged.components:
            digest.update(component.name.encode() + component.elements.tobytes())
        return digest.hexdigest()

    def pressure(self, name: str, pressure: float) -> FloatArray:
        """Return nodal forces (n_dofs,) of a pressure [Pa] on an element set, positive toward the shells' top sides."""
        return loads.pressure_load(self.mesh, self.built, name, pressure)

    def point_load(self, name: str, force: Sequence[float], moment: Sequence[float] = (0.0, 0.0, 0.0)) -> FloatArray:
        """Return nodal forces (n_dofs,) of a force [N] and a moment [N m], shared equally by the nodes of a set."""
        return loads.point_load(self.mesh, name, force, moment)

    def line_load(self, name: str, force: Sequence[float]) -> FloatArray:
        """Return nodal forces (n_dofs,) of a force per length (3,) [N/m] along the lines or edges of a set."""
        return loads.line_load(self.mesh, self.built, name, force)

    def gravity(self, acceleration: Sequence[float] = (0.0, 0.0, -9.80665)) -> FloatArray:
        """Return the weight (n_dofs,) of all parts and masses under an acceleration (3,) [m/s^2]."""
        return loads.gravity_load(self.built, acceleration)

    def solve(self, state: Mapping[str, float], load: FloatArray, limit: float = MOST_ERROR) -> Judged:
        """Return the displacements (n_nodes, 6) [m, rad] of a state of named damage fractions under nodal forces.

        Their `error` is the larger of both estimates of `femlib.assembly.quality`.

        Raises
        ------
        InputError
            If the state names an unknown parameter, a damage is outside [0, 1), or the load is not finite.
        SolveError
            If the displacements are larger than the structure, or estimated to be farther off than `limit`.
        """
        moved, quality = self._judged(state, load)
        quality.refuse(limit)
        return judged(moved, quality.displacement_error)

    def _judged(self, state: Mapping[str, float], load: FloatArray) -> tuple[FloatArray, Quality]:
        """Return displacements (n_nodes, 6) of a state and what they are worth."""
        if not len(self.damaged.supports.free):
            raise InputError("every node is held in all directions; expected some that can move; refine or give up one")
        row = damage_row(state, self.parameters)
        pristine, moved = self.damaged.solve(np.stack([0.0 * row, row]), load)
        places = moved.reshape(-1, DOFS_PER_NODE)
        size = self.built.mesh.size
        most = float(np.abs(places[:, :3]).max())
        if not most <= size:
            raise SolveError(
                f"the structure moves by {most:.3g} m, more than its size of {size:.3g} m; expected small motion; "
                "check that lengths are in m, forces in N, moduli in Pa"
            )
        self._check_buckling(load, pristine)
        return places, self.judge.quality(np.asarray(load), moved, pristine, self.stiffness_left(state))

    def _check_buckling(self, load: FloatArray, pristine: FloatArray) -> None:
        """Refuse a load under which the undamaged shells would have buckled, on meshes where that is quickly told."""
        supports = self.damaged.supports
        if len(supports.free) > MOST_UNKNOWNS or not np.any(load):
            return
        name = hashlib.sha256(np.asarray(load, dtype=np.float64).tobytes()).hexdigest()
        if self._buckled.get(name, lambda: is_buckled(self.built, supports, pristine)):
            raise SolveError(
                "the load is beyond the buckling load of the shells, where displacements in proportion to it say "
                "nothing; expected a load that they carry unbuckled; lower it, or stiffen what it compresses"
            )

    def strain_rows(self, gauges: Sequence[StrainGauge]) -> sparse.csr_array:
        """Return the map (n_gauges, n_dofs) from displacements to strain, tension positive [-].

        A gauge's `patches` are names of element sets.

        Raises
        ------
        InputError
            If a gauge names an unknown set, lies off its shells or measures along their normal.
        """
        return self._rows_on(self.built, gauges)

    def _rows_on(self, built: Shells, gauges: Sequence[StrainGauge]) -> sparse.csr_array:
        thickness = np.array([own.thickness for own in built.laminates])[built.section]
        return sensors.strain_rows(built.mesh, thickness, [self.on_patches(gauge) for gauge in gauges])

    def strain_microstrain(
        self,
        state: Mapping[str, float],
        load: FloatArray,
        gauges: Sequence[StrainGauge],
        limit: float = MOST_ERROR,
        gauge_limit: float = MOST_GAUGE_ERROR,
    ) -> Judged:
        """Return the gauge strains (n_gauges,) of a state of named damage fractions, tension positive.

        Their `error` is `gauge_error`, or that of the displacements if it is larger.

        Raises
        ------
        InputError, SolveError
            As `solve` and `strain_rows`, or if a strain is beyond linear analysis, or they are estimated to be farther
            off than `gauge_limit`.
        """
        moved = self.solve(state, load, limit)
        strains = checked_strains(MICRO * (self.strain_rows(gauges) @ np.asarray(moved).ravel()))
        error = self.gauge_error(load, gauges)
        refuse_error(error, "gauge strains", gauge_limit)
        return judged(strains, max(error, moved.error))

    def gauge_error(self, load: FloatArray, gauges: Sequence[StrainGauge]) -> float:
        """Return the estimated relative error of the undamaged structure's gauge strains, by a finer mesh.

        A difference of second order, over all gauges as roots of sums of squares; 0 where no finer mesh was made.
        """
        name = hashlib.sha256(np.asarray(load, dtype=np.float64).tobytes() + repr(gauges).encode()).hexdigest()
        return self._gauge_errors.get(name, lambda: self._gauge_distance(load, gauges))

    def _gauge_distance(self, load: FloatArray, gauges: Sequence[StrainGauge]) -> float:
        fine, finer = self.judge.finer_solution(load), self.judge.finer
        if fine is None or finer is None:
            return 0.0
        pristine = self.damaged.solve(np.zeros((1, len(self.parameters))), load)[0]
        own, other = self.strain_rows(gauges) @ pristine, self._rows_on(finer.shells, gauges) @ fine
        return relative_distance(own, other, finer.share)

    def stresses(
        self,
        state: Mapping[str, float],
        load: FloatArray,
        limit: float = MOST_ERROR,
        strain_limit: float = MOST_PEAK_ERROR,
        length: float = 0.0,
    ) -> Stresses:
        """Return strains and stresses of all plies at the shells' corners, with the estimated error of the largest.

        The error is this state's by a finer mesh; where none was made, the root of the energy's.

        Parameters
        ----------
        state, load, limit
            As for `solve`.
        strain_limit : float
            Estimated error of the largest strains beyond which they are refused.
        length : float
            Length that strains are means over [m]: a singular corner has no strain of its own.

        Raises
        ------
        InputError, SolveError
            As `solve`, or if the strains are estimated to be farther off than `strain_limit`.
        """
        moved, quality = self._judged(state, load)
        quality.refuse(limit)
        left = self.stiffness_left(state)
        error = checked_peak(self.judge, moved.ravel(), np.asarray(load, np.float64), left, strain_limit, length)
        return ply_stresses(self.built, moved.ravel(), left, error, length=length)

    def reactions(self, state: Mapping[str, float], load: FloatArray, limit: float = MOST_ERROR) -> Judged:
        """Return the forces and moments (n_nodes, 6) [N, N m] of the supports, springs aside; raises as `solve`."""
        moved = self.solve(state, load, limit)
        held = self.damaged.reactions(np.asarray(moved).ravel(), load, self.stiffness_left(state))
        return judged(held, moved.error)

    def buckling_modes(
        self, state: Mapping[str, float], load: FloatArray, n_modes: int = 1, limit: float = MOST_ERROR
    ) -> list[BucklingMode]:
        """Return the modes of least positive factor on a load in a state, each with its estimated error.

        Raises
        ------
        InputError, SolveError
            As `femlib.assembly.buckling_modes`, or if the state names an unknown parameter.
        """
        factor = self.stiffness_left(state)
        return buckling_modes(self.built, self.damaged.supports, load, n_modes, factor, limit)

    def capability(
        self,
        load: FloatArray,
        place: str,
        direction: Sequence[float],
        most_deflection: float,
        criterion: str = "max strain",
        settings: ReductionSettings | None = None,
        n_states: int = 300,
        n_checks: int = 6,
        length: float = 0.0,
        strain_limit: float = MOST_PEAK_ERROR,
    ) -> Capability:
        """Return the greatest factors on a load that damage states of a structure of shells bear, by a reduced model.

        A ply fails, the shells buckle, or a node set moves in the mean by `most_deflection` [m] along a direction (3,);
        see `femlib.structure.strength`. The structure, sound and with `JUDGED` of each region lost, is refused as by
        `stresses` with `length` and `strain_limit`; the larger of the two errors is `mesh_error`.
        """
        limits = replace(structure_limits(self.mesh, place, direction, most_deflection, criterion), length=length)
        found = structure_capability(self.damaged, load, limits, settings, n_states, n_checks)
        sound = float(found.load_factors(np.zeros((1, len(self.parameters))))[0])
        light = LIGHT * sound * np.asarray(load)
        states = [dict.fromkeys(self.parameters, lost) for lost in (0.0, JUDGED)]
        error = max(self.stresses(s, light, strain_limit=strain_limit, length=length).error for s in states)
        return replace(found, mesh_error=error)

    def natural_modes(
        self, n_modes: int, state: Mapping[str, float] | None = None, limit: float = MOST_ERROR
    ) -> list[Mode]:
        """Return the lowest natural modes of a state, lowest first, each with the estimated error of its frequency.

        Raises
        ------
        InputError
            If nothing has mass, or as `solve`.
        SolveError
            If an error is estimated beyond `limit`.
        """
        if not self.total_mass > 0.0:
            raise InputError("the structure has no mass; expected a density or a point mass; give the sections theirs")
        return natural_modes(self.built, self.damaged.supports, n_modes, self.stiffness_left(state or {}), limit=limit)

    def stiffness_left(self, state: Mapping[str, float]) -> FloatArray:
        """Return the share of its stiffness that each part (n_parts,) keeps in a state."""
        return self.damaged.left_in(state)

    def quality(self, state: Mapping[str, float], load: FloatArray) -> Quality:
        """Return what a solution is worth, however little: `solve` refuses it beyond 3 %."""
        return self._judged(state, load)[1]

    def on_patches(self, gauge: StrainGauge) -> StrainGauge:
        """Return a gauge that names the patches of the shell mesh that its element sets are made of."""
        mesh = self.built.mesh
        inside = np.zeros(mesh.n_elements, dtype=bool)
        for name in gauge.patches:
            inside |= self.mesh.elements_of(name)[: mesh.n_elements]
        if not inside.any():
            raise InputError(
                f"gauge {gauge.name} is on {list(gauge.patches)}, which hold beams alone; expected shells; move it"
            )
        patches = np.unique(mesh.patch_of_element[inside])
        return replace(gauge, patches=tuple(mesh.patches[k] for k in patches))
