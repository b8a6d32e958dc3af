"""The asset of the sealed cases: the wing on another mesh, with what a second model of one wing differs by.

Everything about effects is this package's own: forces, constants, the order in which structure and measuring chain
act. It imports the wing's geometry and solver, never a signature of the diagnosis or of `femlib.wing.effects`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, TypeVar, cast

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from benchmarks.blind.assets import forces
from femlib.arrays import FloatArray, IntArray
from femlib.assembly import thermal_load
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import Wing, bend, uav_wing
from femlib.wing.structure import WingMaterials

State = tuple[float, ...]
"""Damage by parameter, fractions."""
Map = Callable[[FloatArray], FloatArray]
T = TypeVar("T")

REFINEMENT = 1.3
COMMON, OWN = 0.006, 0.008
"""Relative difference of two good codes on one wing: common to all gauges, and each gauge's own."""
STATES: tuple[State, ...] = ((0.0, 0.0), (0.2, 0.0), (0.0, 0.4), (0.25, 0.45), (0.6, 0.2), (0.1, 0.7), (0.35, 0.1))
TREE_STATES: tuple[State, ...] = tuple((round(0.2 * i, 1), round(0.2 * j, 1)) for i in range(5) for j in range(5))
PARAMETERS = ("mu1", "mu2")
STEP = 0.02
"""Step of the damage from which the change of the strains with it is taken."""
THICKER = 0.08
"""The skin's stiffness is raised by this share to see what it does."""
BENT_REFINEMENT = 0.4
"""Mesh of the nonlinear solution, which gives relative changes alone."""
BENT_LOADS = (1.5, 3.0)
LENGTH = 0.07
"""Typical length of a debond, span fractions: the bond is gone over 0.3 to 3 times this."""


@dataclass(frozen=True)
class Flaw:
    """One local fault of a structure, drawn once per set.

    Attributes
    ----------
    name
        "damage_outside_library" [%] or "spar_skin_debond" [-].
    place
        where, in the words of `forces`.
    size
        how much.
    """

    name: str
    place: str
    size: float


def neighbours(state: State) -> tuple[State, ...]:
    """Return the states a step of damage further, one for each parameter."""
    return tuple(tuple(round(v + STEP * (k == p), 9) for k, v in enumerate(state)) for p in range(len(state)))


class Asset(ABC):
    """An asset as the cases see it, whatever code computes its strains.

    Attributes
    ----------
    family
        name of the code and mesh.
    gauges, eta, row
        of the gauges that lie in no region: name, span fraction, chordwise row.
    states
        damage states of the tests.
    payloads, hot_spots, lifts
        names of the fields that were drawn for this set.
    flaws
        local faults that were drawn for it.
    """

    family: str = ""
    states: tuple[State, ...] = STATES
    n_places: ClassVar[Mapping[str, int]] = {
        "payload_inertia": 8,
        "hot_spot": 4,
        "damage_outside_library": 10,
        "spar_skin_debond": 8,
    }

    def __init__(self, seed: int, refinement: float) -> None:
        self.refinement = refinement
        self.wing = uav_wing(refinement=refinement)
        gauges = self.wing.gauges
        self.columns = np.flatnonzero(gauges.is_usable)
        self.gauges = tuple(gauges.names[k] for k in self.columns)
        self.eta = gauges.eta[self.columns]
        self.row = gauges.chord_fraction[self.columns]
        self._kept: dict[Hashable, object] = {}
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

    def kept(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what `make` returns, made once."""
        if key not in self._kept:
            self._kept[key] = make()
        return cast(T, self._kept[key])

    @abstractmethod
    def strain(self, state: State) -> FloatArray:
        """Return the strains (n_gauges,) at load factor 1 [microstrain, compressive positive]."""

    @abstractmethod
    def field(self, name: str, state: State) -> FloatArray:
        """Return the change of the strains (n_gauges,) per unit of a field, at load factor 1 or whatever the load."""

    @abstractmethod
    def softness(self, state: State) -> FloatArray:
        """Return b (n_gauges,) where skins stiffer by the share s have strain / (1 + b s)."""

    @abstractmethod
    def flaw(self, flaw: Flaw) -> FloatArray:
        """Return the change of the healthy wing's strains (n_gauges,) by a flaw at load factor 1."""

    def bending(self) -> FloatArray:
        """Return the relative changes (2, n_gauges) of strain by large deflection per L and per L^2."""
        return self.kept("bending", lambda: _bending(min(BENT_REFINEMENT, self.refinement), self.columns))


class FemlibAsset(Asset):
    """The wing on a finer mesh, its gauges reading (1 + own difference) times its strain."""

    family = "femlib, other mesh"

    def __init__(self, seed: int, refinement: float = REFINEMENT) -> None:
        super().__init__(seed, refinement)
        every = [*STATES, *TREE_STATES, *(near for state in STATES for near in neighbours(state))]
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
        cards = WingMaterials()
        wing = uav_wing(
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


def log_uniform(rng: np.random.Generator) -> float:
    """Return a factor between 0.3 and 3, its logarithm uniform."""
    return float(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))


def _bending(refinement: float, columns: IntArray) -> FloatArray:
    wing = uav_wing(refinement=refinement)
    straight = wing.strain_microstrain({}, 1.0)[columns]
    bent = [bend(wing, {}, load).strain_microstrain[columns] / (load * straight) - 1.0 for load in BENT_LOADS]
    powers = np.array([[load, load**2] for load in BENT_LOADS])
    return np.linalg.solve(powers, np.array(bent))
