"""The asset of the sealed cases: the wing on another mesh, with what a second model of one wing differs by.

Everything about effects is this module's own: forces, constants, the order in which structure and measuring chain
act. It imports the wing's geometry and solver, never a signature of the diagnosis or of `femlib.wing.effects`.
"""

from dataclasses import dataclass, field

import numpy as np

from femlib.assembly import thermal_load
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import uav_wing

REFINEMENT = 1.3
COMMON, OWN = (
    0.006,
    0.008,
)  # relative difference of two good codes on one wing: common to all gauges, and each gauge's own
GRAVITY = 9.80665
STATES = ((0.0, 0.0), (0.2, 0.0), (0.0, 0.4), (0.25, 0.45), (0.6, 0.2), (0.1, 0.7), (0.35, 0.1))
PARAMETERS = ("mu1", "mu2")


@dataclass(eq=False)
class Asset:
    """The wing on a finer mesh, its gauges reading (1 + own difference) times its strain.

    Attributes:
        seed: of the difference, one for all cases of a set.
    """

    seed: int
    refinement: float = REFINEMENT
    _cache: dict = field(default_factory=dict, repr=False)

    def __post_init__(self):
        self.wing = uav_wing(refinement=self.refinement)
        usable = self.wing.gauges.is_usable
        self.columns = np.flatnonzero(usable)
        self.gauges = tuple(name for name, ok in zip(self.wing.gauges.names, usable, strict=True) if ok)
        rng = np.random.default_rng([self.seed, 77])
        self.own = 1.0 + COMMON * rng.standard_normal() + OWN * rng.standard_normal(len(self.gauges))
        self.eta = self.wing.gauges.eta[self.columns]

    def strain(self, state):
        """Return the strains (n_gauges,) at load factor 1 [microstrain, compressive positive]."""
        return self._kept(("strain", state), lambda: self.of_force(state, self.wing.lift) * self.own)

    def field(self, name, state):
        """Return the change of the strains (n_gauges,) per unit of a structural effect, at load factor 1."""
        return self._kept(
            (name, state), lambda: self.of_force(state, getattr(self, "_" + name.split(":")[0])(name, state))
        )

    def of_force(self, state, force):
        """Return strains (n_gauges,) under nodal forces (n_dofs,)."""
        outputs = self.wing.structure.solve_outputs(np.array([state]), np.asarray(force), self.wing.strain_rows)
        return 1e6 * outputs[0][self.columns]

    def _kept(self, key, make):
        if key not in self._cache:
            self._cache[key] = make()
        return self._cache[key]

    def _moved(self, state):
        return self._kept(("moved", state), lambda: self.wing.solve(dict(zip(PARAMETERS, state, strict=True)), 1.0))

    # -- nodal forces of structural effects, each per unit of its size ------------------------------------------------

    def _temperature_uniform(self, name, state):
        return self._warm(state, np.ones(self.wing.structure.shells.mesh.n_elements))

    def _temperature_gradient(self, name, state):
        height = self.wing.structure.shells.mesh.centroids()[:, 2]
        patches = self.wing.structure.shells.mesh.patches
        inner = np.isin(self.wing.structure.shells.mesh.patch_of_element, [patches.index("web"), patches.index("ribs")])
        return self._warm(state, np.where(inner, 0.0, np.where(height > 0, 0.5, -0.5)))

    def _hot_spot(self, name, state):
        """Sun on a third of the chord between two ribs: no effect of any library."""
        mesh = self.wing.structure.shells.mesh
        eta = mesh.centroids()[:, 1] / self.wing.span
        centre = float(name.split(":")[1])
        top = mesh.centroids()[:, 2] > 0
        return self._warm(state, np.where(top, np.exp(-(((eta - centre) / 0.06) ** 2)), 0.0))

    def _warm(self, state, warming):
        shells = self.wing.structure.shells
        scale = np.ones(len(warming))
        for component, damage in zip(self.wing.structure.components, state, strict=True):
            scale[component.elements] = 1.0 - damage
        return thermal_load(shells, warming * scale, np.zeros(len(warming)))

    def _lift_distribution(self, name, state):
        """More lift outboard: a part that grows with the square of the span and drops at the tip, as twist gives."""
        lift = self.wing.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
        eta = self.wing.structure.shells.mesh.nodes[:, 1] / self.wing.span
        shape = lift * eta**2 * (1.0 - 0.5 * eta**6)
        shape -= lift * shape.sum() / lift.sum()
        force = np.zeros((len(lift), DOFS_PER_NODE))
        force[:, 2] = shape * (0.01 * (lift @ eta) / (shape @ eta))
        return force.ravel()

    def _skin_thickness(self, name, state):
        shells = self.wing.structure.shells
        patches = shells.mesh.patches
        u = self._moved(state).ravel()
        inner = np.isin(shells.mesh.patch_of_element, [patches.index("web"), patches.index("ribs")])
        pull = shells.stiffness(~inner) @ u
        for component, damage in zip(self.wing.structure.components, state, strict=True):
            pull = pull - damage * (shells.stiffness(component.elements) @ u)
        return -0.01 * pull

    def _payload_inertia(self, name, state):
        mesh = self.wing.structure.shells.mesh
        eta = float(name.split(":")[1])
        point = np.array([0.0, eta * self.wing.span, 0.0])
        near = np.argsort(np.linalg.norm(mesh.nodes - point, axis=1))[:6]
        force = np.zeros((len(mesh.nodes), DOFS_PER_NODE))
        force[near, 2] = -GRAVITY / len(near)
        return force.ravel()

    def _damage_outside_library(self, name, state):
        """A loss of stiffness of a patch of the upper skin, 0.1 of the span by 0.35 of the chord, per per cent."""
        shells = self.wing.structure.shells
        centre = shells.mesh.centroids()
        eta, aft = (float(part) for part in name.split(":")[1:])
        patch = (np.abs(centre[:, 1] / self.wing.span - eta) < 0.05) & (centre[:, 2] > 0.0)
        local = 0.43561 - (0.43561 - 0.261112) * centre[:, 1] / self.wing.span
        patch &= np.abs(centre[:, 0] / local + 0.3 - aft) < 0.175
        patch &= np.isin(shells.mesh.patch_of_element, [shells.mesh.patches.index("top")])
        return 0.01 * (shells.stiffness(patch) @ self._moved(state).ravel())
