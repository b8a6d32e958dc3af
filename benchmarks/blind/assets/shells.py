"""Families that stand on femlib's wing: its geometry and its shells, on another mesh or in another code."""

from abc import ABC
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import ClassVar

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from benchmarks.blind.assets import forces
from benchmarks.blind.assets.asset import (
    DAMAGED,
    LENGTH,
    PARAMETERS,
    STATES,
    Asset,
    Flaw,
    log_uniform,
    neighbours,
)
from benchmarks.blind.assets.moment import State
from femlib.arrays import FloatArray, IntArray
from femlib.assembly import thermal_load
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import Wing, bend, tapered_wing
from femlib.wing.structure import tapered_materials

Map = Callable[[FloatArray], FloatArray]

REFINEMENT = 1.3
COMMON, OWN = 0.006, 0.008
"""Relative difference of two good codes on one wing: common to all gauges, and each gauge's own."""
THICKER = 0.08
"""The skin's stiffness is raised by this share to see what it does."""
BENT_REFINEMENT = 0.4
"""Mesh of the nonlinear solution, which gives relative changes alone."""
BENT_LOADS = (1.5, 3.0)


class ShellAsset(Asset, ABC):
    """An asset on femlib's mesh.

    Attributes
    ----------
    refinement, wing, columns
        the wing on its mesh; the gauges that lie in no region.
    own
        what another good code would find over femlib's strains (n_gauges,).
    """

    def __init__(self, seed: int, refinement: float) -> None:
        super().__init__()
        self.refinement = refinement
        self.wing = tapered_wing(refinement=refinement)
        gauges = self.wing.gauges
        self.columns = np.flatnonzero(gauges.is_usable)
        self.gauges = tuple(gauges.names[k] for k in self.columns)
        self.eta = gauges.eta[self.columns]
        self.row = gauges.chord_fraction[self.columns]
        self.span = self.wing.span
        rng = np.random.default_rng([seed, 77])
        self.own = 1.0 + COMMON * rng.standard_normal() + OWN * rng.standard_normal(len(self.gauges))
        self.payloads = [
            f"payload_inertia:{eta:.3f}" for eta in rng.uniform(0.4, 0.95, self.n_places["payload_inertia"])
        ]
        self.hot_spots = [f"hot_spot:{eta:.2f}" for eta in rng.uniform(0.3, 0.7, self.n_places["hot_spot"])]
        self.lifts = [f"lift_distribution:{kind}" for kind in forces.LIFT_KINDS]
        self.flaws = [*self._patches(rng), *self._debonds(rng)]

    def _patches(self, rng: np.random.Generator) -> Iterator[Flaw]:
        for _ in range(self.n_places["damage_outside_library"]):
            place = f"{rng.uniform(0.28, 0.74):.3f}:{rng.choice([0.2, 0.4, 0.6])}"
            yield Flaw("damage_outside_library", place, float(min(90.0, 25.0 * log_uniform(rng))))

    def _debonds(self, rng: np.random.Generator) -> Iterator[Flaw]:
        for _ in range(self.n_places["spar_skin_debond"]):
            centre, width = rng.uniform(0.25, 0.75), LENGTH * log_uniform(rng)
            place = f"{rng.choice(['upper', 'lower'])}:{centre - width / 2:.3f}:{centre + width / 2:.3f}"
            yield Flaw("spar_skin_debond", place, 1.0)

    @property
    def field_names(self) -> list[str]:
        """Names of all fields."""
        plain = ["temperature_uniform", "temperature_gradient", "torsion"]
        return [*plain, *self.lifts, *self.payloads, *self.hot_spots]

    def bent(self, load: float) -> FloatArray:
        """Return the relative change of the strains (n_gauges,) by large deflection: of first and second order."""
        first, second = self.kept("bending", lambda: _bending(min(BENT_REFINEMENT, self.refinement), self.columns))
        return np.asarray(first * load + second * load**2)


class FemlibAsset(ShellAsset):
    """The wing on a finer mesh, its gauges reading (1 + own difference) times its strain."""

    family = "femlib, other mesh"
    outside: ClassVar[tuple[str, ...]] = ("quadratic_gauges", "rib_field", "passing_sun")

    def __init__(self, seed: int, refinement: float = REFINEMENT) -> None:
        super().__init__(seed, refinement)
        every = [*STATES, DAMAGED, *(near for state in STATES for near in neighbours(state))]
        self.every = tuple(dict.fromkeys(every))

    def strain(self, state: State) -> FloatArray:
        """Return the strains (n_gauges,) at load factor 1 [microstrain, compressive positive]."""
        strains = self.kept("strain", lambda: self._answers(self.wing, self.wing.lift))
        return np.asarray(self.own * strains[self.every.index(state)])

    def field(self, name: str, state: State) -> FloatArray:
        """Return the change of the strains (n_gauges,) per unit of a field."""
        return np.asarray(self.kept(name, lambda: self._field(name))[self.every.index(state)])

    def softness(self, state: State) -> FloatArray:
        """Return b (n_gauges,) where skins stiffer by the share s have strain / (1 + b s)."""
        return np.asarray(self.kept("softness", self._softness)[self.every.index(state)])

    def flaw(self, flaw: Flaw) -> FloatArray:
        """Return the change of the healthy wing's strains (n_gauges,) by a flaw at load factor 1."""
        return self.kept(flaw, lambda: self._flaw(flaw))

    def _answers(self, wing: Wing, force: FloatArray) -> FloatArray:
        """Return the strains (n_states, n_gauges) of all states under nodal forces (n_dofs,)."""
        active = tuple(range(len(PARAMETERS)))
        answers = wing.structure.output_map(np.asarray(force), wing.strain_rows, active)
        return 1e6 * answers.solve(np.array(self.every))[:, self.columns]

    def _field(self, name: str) -> FloatArray:
        if not forces.is_thermal(name):
            return self._answers(self.wing, forces.force(self.wing, name))
        shells, warmth = self.wing.structure.shells, forces.warming(self.wing, name)
        still = np.zeros(len(warmth))
        total = self._answers(self.wing, thermal_load(shells, warmth, still))
        for component, damage in zip(self.wing.structure.components, np.array(self.every).T, strict=True):
            lost = np.where(component.elements, warmth, 0.0)  # damaged skin pushes less
            if lost.any():
                total = total - damage[:, None] * self._answers(self.wing, thermal_load(shells, lost, still))
        return total

    def _softness(self) -> FloatArray:
        cards = tapered_materials()
        wing = tapered_wing(
            refinement=self.refinement, materials=replace(cards, skin_young=cards.skin_young * (1 + THICKER))
        )
        return (self._answers(self.wing, self.wing.lift) / self._answers(wing, wing.lift) - 1.0) / THICKER

    def _flaw(self, flaw: Flaw) -> FloatArray:
        """Solve the flawed wing again, by conjugate gradients that the sound wing's factors precondition."""
        structure = self.wing.structure
        supports = structure.supports
        sound = self.kept("sound", lambda: supports.reduce(structure.shells.stiffness()))
        factors = structure.eliminated(tuple(range(len(PARAMETERS)))).factors
        lost = self._patch(flaw) if flaw.name == "damage_outside_library" else self._sliding(flaw)
        force = self.wing.lift[supports.free]
        before = factors.solve(force)
        flawed = LinearOperator(sound.shape, matvec=lambda x: sound @ x - lost(x), dtype=np.float64)
        precondition = LinearOperator(sound.shape, matvec=factors.solve, dtype=np.float64)
        after, failure = cg(flawed, force, x0=before, rtol=1e-9, maxiter=300, M=precondition)
        assert failure == 0, f"{flaw} did not converge"
        moved = self.wing.strain_rows @ supports.expand(after - before)
        return 1e6 * moved[self.columns]

    def _patch(self, flaw: Flaw) -> Map:
        """Return what a foreign damage takes from the stiffness, as a map of free displacements."""
        structure = self.wing.structure
        lost = structure.supports.reduce(structure.shells.stiffness(forces.foreign_patch(self.wing, flaw.place)))
        return lambda x: 0.01 * flaw.size * (lost @ x)

    def _sliding(self, flaw: Flaw) -> Map:
        """Return what sliding of the web along the skin takes from the stiffness, as a map of free displacements.

        The row of web elements at the flange gets spanwise freedoms of its own at the nodes of the length.
        """
        structure = self.wing.structure
        supports = structure.supports
        row, nodes = forces.bond(self.wing, flaw.place)
        at = np.searchsorted(supports.free, DOFS_PER_NODE * nodes + 1)
        stiff = supports.reduce(structure.shells.stiffness(row))
        columns = stiff[:, at].toarray()
        return lambda x: columns @ np.linalg.solve(columns[at], columns.T @ x)


def _bending(refinement: float, columns: IntArray) -> FloatArray:
    wing = tapered_wing(refinement=refinement)
    straight = wing.strain_microstrain({}, 1.0)[columns]
    bent = [bend(wing, {}, load).strain_microstrain[columns] / (load * straight) - 1.0 for load in BENT_LOADS]
    powers = np.array([[load, load**2] for load in BENT_LOADS])
    return np.linalg.solve(powers, np.array(bent))
