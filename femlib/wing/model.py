"""The wing as a model: a damage state and a load factor in, displacements and gauge strains out.

Strain is compressive positive (the gauges sit on the compressed top skin), in microstrain, at the given load factor
and not divided by it. The model is linear in load.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial

import numpy as np
import scipy.sparse as sparse
from numpy.typing import ArrayLike

from femlib import sensors
from femlib.arrays import FloatArray
from femlib.assembly import MOST_ERROR, Supports, solution_quality
from femlib.assembly.quality import refuse_error
from femlib.components import Component, DamagedStructure, damage_row
from femlib.components.regions import checked_damage
from femlib.components.structure import MOST_PORTS
from femlib.errors import InputError, frozen_floats, is_number
from femlib.geometry import Planform
from femlib.kept import Kept, ReadOnly
from femlib.mesh import DOFS_PER_NODE
from femlib.rom.strains import checked_load_factor
from femlib.sensors import checked_strains
from femlib.wing.damage import TAPERED_REGIONS, UAV_REGIONS, DamageRegion, checked_regions
from femlib.wing.gauges import (
    GaugeSet,
    candidate_places,
    gauge_set,
    installed_places,
    tapered_candidates,
    tapered_places,
)
from femlib.wing.loads import EFFECTIVE_MASS, TAPERED_MASS, elliptic_lift
from femlib.wing.planform import N_RIBS, PLANFORM, SECTION
from femlib.wing.structure import WingGrid, WingMaterials, tapered_materials, wing_grid, wing_mesh, wing_shells

MICRO = 1e6
JUDGED_DAMAGE = 0.8
"""Damage of all regions at which the mesh is judged besides the sound wing."""
StrainMap = Callable[[FloatArray], FloatArray]
"""From states (n_states, n_parameters) to gauge strains (n_states, n_gauges)."""


@dataclass(frozen=True, slots=True, eq=False)
class Wing:
    """A clamped half wing with damage regions and strain gauges.

    Attributes
    ----------
    structure : DamagedStructure
        Shells, clamped root, damage components.
    grid : WingGrid
        Node numbers by span station and chord line.
    regions : tuple of DamageRegion
        Damage regions, in the order of the structure's components.
    gauges : GaugeSet
        Gauges, in the order of the strains.
    materials : WingMaterials
        Moduli and thicknesses.
    lift : FloatArray
        Nodal forces (n_dofs,) at load factor 1 [N].
    planform : Planform
        Outline; the designed one if not given.
    strain_rows : csr_array
        Map (n_gauges, n_dofs) from displacements to strain, compressive positive [-].
    element_rows : tuple of mapping
        For each gauge the elements that it averages and their rows, tension positive, as `sensors.element_rows`.
    """

    structure: DamagedStructure
    grid: WingGrid
    regions: tuple[DamageRegion, ...]
    gauges: GaugeSet
    materials: WingMaterials
    lift: FloatArray
    planform: Planform = PLANFORM
    strain_rows: sparse.csr_array = field(init=False, repr=False)
    element_rows: tuple[Mapping[int, FloatArray], ...] = field(init=False, repr=False)
    _strain_maps: Kept[float, StrainMap] = field(init=False, repr=False, default_factory=Kept)
    _mesh_errors: Kept[str, float] = field(init=False, repr=False, default_factory=Kept)

    def __post_init__(self) -> None:
        mesh = self.structure.shells.mesh
        rows = sensors.element_rows(mesh, self.thickness, self.strain_gauges)
        of_elements = tuple(ReadOnly(of_gauge) for of_gauge in rows)
        object.__setattr__(self, "element_rows", of_elements)
        object.__setattr__(self, "strain_rows", -sensors.assembled_rows(mesh, of_elements))

    @property
    def thickness(self) -> FloatArray:
        """Thickness of each element (n_elements,) [m]."""
        shells = self.structure.shells
        return np.array([laminate.thickness for laminate in shells.laminates])[shells.section]

    @property
    def strain_gauges(self) -> list[sensors.StrainGauge]:
        """The gauges on the shells: they read at the height of the skin's carbon face."""
        side = self.materials.face_height / (self.materials.skin_thickness / 2.0)
        return self.gauges.strain_gauges(("top",), side)

    @property
    def mesh_error(self) -> float:
        """Estimated relative error of the displacements under the wing's lift by the mesh, made once.

        The larger of the sound wing's and of that with every region damaged by `JUDGED_DAMAGE`, by energy alone.
        """
        return self._mesh_errors.get("", self._estimated)

    def _estimated(self) -> float:
        shells, errors = self.structure.shells, []
        for damage in (0.0, JUDGED_DAMAGE):
            state = np.full(len(self.parameters), damage)
            moved = self.structure.solve(state[None], self.lift)[0]
            quality = solution_quality(shells, moved, self.structure.stiffness_left(state))
            errors.append(quality.displacement_error)
        return max(errors)

    @property
    def span(self) -> float:
        """Half-span [m]."""
        return self.planform.span

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters: the columns of a state array."""
        return self.structure.parameters

    @property
    def gauge_names(self) -> tuple[str, ...]:
        """Names of the gauges, in the order of the strains."""
        return self.gauges.names

    @property
    def gauge_positions(self) -> FloatArray:
        """Places (n_gauges, 2) of the gauges, x aft of the spar and y outboard [m]."""
        return self.gauges.position[:, :2]

    @property
    def model_hash(self) -> str:
        """SHA-256 of everything the strains depend on: nodes, corners, materials, regions, loads, gauges."""
        digest = hashlib.sha256()
        mesh = self.structure.shells.mesh
        for array in (mesh.nodes, mesh.quads, mesh.trias, self.structure.shells.scale, self.lift, self.gauges.position):
            digest.update(np.ascontiguousarray(array).tobytes())
        named = {"materials": asdict(self.materials), "regions": [asdict(region) for region in self.regions]}
        digest.update(json.dumps(named, sort_keys=True).encode())
        return digest.hexdigest()

    def solve(self, state: Mapping[str, float], load_factor: float, lift: FloatArray | None = None) -> FloatArray:
        """Return the displacements (n_nodes, 6) [m, rad] of a state of named damage fractions.

        `lift` (n_dofs,) are other nodal forces and moments at load factor 1 [N, N m], such as those of
        `femlib.wing.inertia`.

        Raises
        ------
        InputError
            If the state names an unknown parameter, a damage is outside [0, 1), the load factor is not finite, or the
            answer is none that linear analysis can give: a motion beyond the wing's size, strain beyond
            `femlib.sensors.MOST_STRAIN`.
        SolveError
            If `mesh_error` is beyond 3 %.
        """
        row = damage_row(state, self.parameters)[None, :]
        load = self.load(load_factor, lift)
        refuse_error(self.mesh_error, "displacements", MOST_ERROR)
        moved = np.asarray(self.structure.solve(row, load)[0].reshape(-1, DOFS_PER_NODE))
        return checked_motion(moved, self.structure.shells.mesh.size)

    def strain_microstrain(
        self, state: Mapping[str, float], load_factor: float, lift: FloatArray | None = None
    ) -> FloatArray:
        """Return the gauge strains (n_gauges,) of a state of named damage fractions, compressive positive.

        Raises
        ------
        InputError
            As `solve`.
        """
        return np.asarray(self.strains_microstrain(damage_row(state, self.parameters)[None, :], load_factor, lift)[0])

    def strains_microstrain(self, states: FloatArray, load_factor: float, lift: FloatArray | None = None) -> FloatArray:
        """Return the gauge strains (n_states, n_gauges) of damage fractions (n_states, n_parameters).

        Raises
        ------
        InputError
            As `solve`.
        """
        if lift is not None:
            forces = self.load(load_factor, lift)
            refuse_error(self.mesh_error, "displacements", MOST_ERROR)
            return checked_strains(MICRO * self.structure.solve_outputs(states, forces, self.strain_rows))
        factor = checked_load_factor(load_factor)
        strain_map = self._strain_maps.get(1.0, lambda: self.strain_map(1.0))
        return checked_strains(factor * strain_map(states))

    def error_bound_microstrain(self, states: ArrayLike, load_factor: float) -> FloatArray:
        """Return zeros (n_states, n_gauges): a reduced wing's error is against this one."""
        damage, _ = checked_damage(states, self.parameters), checked_load_factor(load_factor)
        return np.zeros((len(damage), len(self.gauge_names)))

    def strain_map(self, load_factor: float, lift: FloatArray | None = None) -> StrainMap:
        """Return the map from states (n_states, n_parameters) to gauge strains (n_states, n_gauges) under one load.

        What a load has in common for all states is done once; the map goes to other processes.

        Parameters
        ----------
        load_factor : float
            Factor on the lift.
        lift : FloatArray, optional
            Nodal forces and moments (n_dofs,) at load factor 1 [N, N m]; the wing's own lift if not given.

        Raises
        ------
        InputError
            If the load factor or a force is not finite, or the forces are not as many as the degrees of freedom.
        """
        load, rows = MICRO * self.load(load_factor, lift), self.strain_rows
        refuse_error(self.mesh_error, "displacements", MOST_ERROR)
        everything = tuple(range(len(self.parameters)))
        if self.structure.n_ports(everything) > MOST_PORTS:
            return partial(_checked_map, partial(self.structure.solve_outputs, load=load, rows=rows))
        return partial(_checked_map, self.structure.output_map(load, rows, everything).solve)

    def load(self, load_factor: float, lift: FloatArray | None = None) -> FloatArray:
        """Return load factor times `lift` (n_dofs,), the wing's own if not given, after checking both."""
        wanted = self.lift if lift is None else frozen_floats(lift, "lift", self.lift.shape)
        return checked_load_factor(load_factor) * wanted

    def tip_stiffness(self) -> float:
        """Return force over deflection of a tip load at the spar [N/m]."""
        load, undamaged = self.tip_row(), np.zeros((1, len(self.parameters)))
        return 1.0 / float(load @ self.structure.solve(undamaged, load)[0])

    def tip_row(self) -> FloatArray:
        """Return the row (n_dofs,) that gives the mean lift of the tip's nodes at the spar [-]."""
        nodes = self.grid.columns(len(self.grid.eta) - 1)[self.grid.spar_column]
        row = np.zeros_like(self.lift)
        row[DOFS_PER_NODE * nodes + 2] = 1.0 / len(nodes)
        return row

    def outline(self) -> FloatArray:
        """Return the closed polygon (5, 2) of the planform in (x, y) [m]."""
        return self.planform.outline()

    def region_outline(self, region: DamageRegion) -> FloatArray:
        """Return the closed polygon (5, 2) of a region in (x, y) [m]."""
        eta = [region.eta_min, region.eta_max, region.eta_max, region.eta_min, region.eta_min]
        chord = [region.chord_min, region.chord_min, region.chord_max, region.chord_max, region.chord_min]
        return self.planform.position(eta, chord)


LEFT_OUT = ("g17", "g18", "g23", "g24")
"""Gauges that the study leaves out: region 1 holds g17, g18 stands just outboard, g23 and g24 ahead of region 2."""


def uav_wing(
    candidates: bool = False,
    refinement: float = 1.0,
    regions: tuple[DamageRegion, ...] = UAV_REGIONS,
    materials: WingMaterials | None = None,
    effective_mass: float = EFFECTIVE_MASS,
) -> Wing:
    """Return the UAV wing of the study, ready to solve.

    It has the published strains, stiffness and frequencies: damage regions are rib bays, gauges stand at one pitch, and
    the skin is softer outboard of mid-span, where a layup ends; fitted to published data (docs/wing.md).

    Parameters
    ----------
    candidates : bool
        Add the 58 candidate gauges to the 24 installed ones.
    refinement : float
        Divides the mesh steps; degrees of freedom grow with its square.
    regions : tuple of DamageRegion
        Damage regions; the study's two if not given, `damage_library()` for all 28.
    materials : WingMaterials, optional
        Moduli and thicknesses; the fitted ones if not given.
    effective_mass : float
        Mass that the wing carries at load factor 1 [kg].

    Raises
    ------
    InputError
        If the refinement or the mass is not positive, or regions or materials cannot be used.
    """
    cards, installed = WingMaterials() if materials is None else materials, installed_places()
    lines = installed[:16, 0]  # the rear row's gauges lie too near the front row's for lines of their own
    places = np.concatenate([installed, candidate_places()]) if candidates else installed
    return checked_wing(refinement, regions, cards, effective_mass, places, lines, LEFT_OUT)


def tapered_wing(
    candidates: bool = False,
    refinement: float = 1.0,
    regions: tuple[DamageRegion, ...] = TAPERED_REGIONS,
    materials: WingMaterials | None = None,
    effective_mass: float = TAPERED_MASS,
) -> Wing:
    """Return another wing of the same class: a skin with one straight taper, freely placed regions.

    It is farther from the published strains (docs/wing.md) and serves as a second structure with the same gauges' and
    regions' names.

    Parameters
    ----------
    candidates, refinement, effective_mass
        As `uav_wing`.
    regions : tuple of DamageRegion
        Damage regions; its two if not given.
    materials : WingMaterials, optional
        Moduli and thicknesses; `tapered_materials()` if not given.

    Raises
    ------
    InputError
        As `uav_wing`.
    """
    cards, installed = tapered_materials() if materials is None else materials, tapered_places()
    places = np.concatenate([installed, tapered_candidates()]) if candidates else installed
    return checked_wing(refinement, regions, cards, effective_mass, places, installed[:, 0], ())


def checked_wing(
    refinement: float,
    regions: tuple[DamageRegion, ...],
    cards: WingMaterials,
    effective_mass: float,
    places: FloatArray,
    lines: FloatArray,
    left_out: tuple[str, ...],
    edge_step: float = 0.0,
) -> Wing:
    """Return a wing with gauges at `places` (n_gauges, 2) and grid lines at the span fractions `lines`."""
    if not is_number(edge_step) or edge_step < 0.0:
        raise InputError(f"edge_step is {edge_step!r}; expected a length in m, 0 for no closer lines; correct it")
    for name, value in (("refinement", refinement), ("effective_mass", effective_mass)):
        if not is_number(value) or value <= 0.0:
            raise InputError(f"{name} is {value!r}; expected a positive finite number; correct it")
    if not isinstance(cards, WingMaterials):
        raise InputError(f"materials are {cards!r}; expected WingMaterials; change the fields that differ")
    kept = checked_regions(regions)
    grid = wing_grid(PLANFORM, N_RIBS, kept, lines, refinement, float(edge_step))
    gauges = gauge_set(PLANFORM, SECTION, kept, places, left_out)
    return _on_planform(PLANFORM, grid, kept, cards, gauges, elliptic_lift(grid, effective_mass))


def reshaped(wing: Wing, planform: Planform) -> Wing:
    """Return the same wing on another planform: grid lines and gauges at the same fractions, the same nodal lift."""
    gauges = gauge_set(planform, SECTION, wing.regions, wing.gauges.places, wing.gauges.left_out)
    return _on_planform(planform, wing.grid, wing.regions, wing.materials, gauges, wing.lift)


def _on_planform(
    planform: Planform,
    grid: WingGrid,
    regions: tuple[DamageRegion, ...],
    cards: WingMaterials,
    gauges: GaugeSet,
    lift: FloatArray,
) -> Wing:
    mesh = wing_mesh(planform, SECTION, grid, regions)
    shells = wing_shells(mesh, planform, cards, regions)
    supports = Supports.clamping(mesh, np.flatnonzero(mesh.nodes[:, 1] == 0.0))
    components = tuple(
        Component(r.name, r.parameter, mesh.patch_of_element == mesh.patches.index(r.name)) for r in regions
    )
    structure = DamagedStructure(shells, supports, components)
    return Wing(structure, grid, regions, gauges, cards, lift, planform)


def checked_motion(moved: FloatArray, size: float) -> FloatArray:
    """Return displacements (n_nodes, 6); InputError if a node would move by more than the wing's size [m]."""
    farthest = float(np.abs(moved[:, :3]).max())
    if not farthest <= size:
        raise InputError(
            f"a node would move by {farthest:.3g} m; expected at most {size:.3g} m, the wing's size, beyond which "
            "linear analysis is meaningless; lower the load factor, check the forces"
        )
    return moved


def _checked_map(strain_map: StrainMap, states: FloatArray) -> FloatArray:
    return checked_strains(strain_map(states))
