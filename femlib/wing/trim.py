"""Static aeroelastic trim: lift moves along the span as the wing twists, while the wing carries the same weight.

theta with cos theta = y / s, half-span s, chord c, dynamic pressure q, A_n coefficients of the circulation
4 s V sum A_n sin(n theta) over odd n, alpha the change of the root's angle, eps(theta) the twist of the sections.

    sum_n A_n sin(n theta) (n m + sin theta) = m sin theta (alpha + eps),   m = 2 pi c / (8 s)

A_1 alone is the ellipse and carries the lift P = 2 pi q s^2 A_1. The rigid wing has the ellipse; what the sections'
twist adds is linear in it, and the twist is linear in the lift of each harmonic and in the moment of the camber,
c_m q c^2 a length about the quarter chord. Hence one small system in A_n / A_1. It holds at one load factor: the
moment does not grow with the load. Without A_1 held it is singular at the pressures of divergence.

Price: a section twists as the line from its leading to its trailing edge; no stall, no Mach number.
Source: H. Glauert, The Elements of Aerofoil and Airscrew Theory (1926), chapter 11; R. L. Bisplinghoff, H. Ashley,
R. L. Halfman, Aeroelasticity (1955), chapter 8.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.components import checked_damage
from femlib.errors import InputError, is_number
from femlib.geometry import Planform
from femlib.mesh import DOFS_PER_NODE
from femlib.rom import ReducedModel
from femlib.sensors import checked_strains
from femlib.wing.loads import EFFECTIVE_MASS
from femlib.wing.model import Wing, checked_load_factor
from femlib.wing.reduced import reduce_wing

N_HARMONICS = 6
"""Odd harmonics of the lift; two more change the strains of a damaged wing by 0.04 % at 35 m/s."""
SECTION_MOMENT = -0.106
"""Coefficient c_m of the moment of NACA 4415 about the quarter chord, nose up, by thin-aerofoil theory."""


@dataclass(frozen=True, slots=True)
class FlightPoint:
    """Flight condition: air, speed and mass of the aircraft.

    Attributes
    ----------
    airspeed : float
        [m/s]. Assumed: at 35 m/s a load factor of 4 asks for a lift coefficient of 1.0, below the stall.
    density : float
        Of the air [kg/m^3].
    mass : float
        That the whole wing carries at load factor 1 [kg].
    """

    airspeed: float = 35.0
    density: float = 1.225
    mass: float = EFFECTIVE_MASS

    def __post_init__(self) -> None:
        for name in ("airspeed", "density", "mass"):
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                raise InputError(f"flight point {name} is {value!r}; expected a positive number; correct it")


@dataclass(frozen=True, slots=True, eq=False)
class TrimmedWing:
    """A wing in trim at one dynamic pressure and load factor, as the model that `femlib.rom.capability` asks for.

    Attributes
    ----------
    lifts : FloatArray
        Nodal forces (n_harmonics + 1, n_dofs) [N] of each harmonic at load factor 1 and A_n = A_1, then of the moment
        at a dynamic pressure of 1 Pa.
    models : tuple of ReducedModel
        The wing under each of them.
    answers : tuple of FloatArray
        Change of A_n / A_1 per pressure (n_harmonics, n_parts) [1/Pa] by the twist of each model's parts.
    rise : FloatArray
        Change of A_n (n_harmonics,) by the root's angle.
    pressure : float
        Dynamic pressure [Pa].
    load_factor : float
        Load factor.
    """

    lifts: FloatArray
    models: tuple[ReducedModel, ...]
    answers: tuple[FloatArray, ...]
    rise: FloatArray
    pressure: float
    load_factor: float

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters: the columns of a state array."""
        return self.models[0].parameters

    @property
    def motion(self) -> FloatArray:
        """Displacements (n_dofs, n_parts) [m, rad] of the parts."""
        return np.concatenate([np.asarray(model.motion) for model in self.models], axis=1)

    def shares(self, states: FloatArray) -> FloatArray:
        """Return the amplitudes (n_states, n_harmonics + 1) of `lifts` in trim over the load factor, the first 1.

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)
        return self._shares([model.parts(damage) for model in self.models])

    def parts(self, mu: FloatArray) -> FloatArray:
        """Return the amplitudes (n_states, n_parts) of `motion` in trim over the load factor of checked damages."""
        parts = [model.parts(mu) for model in self.models]
        weights = self._shares(parts).T[:, :, None]
        return np.concatenate([weight * own for weight, own in zip(weights, parts, strict=True)], axis=1)

    def lift(self, state: FloatArray) -> FloatArray:
        """Return the nodal forces (n_dofs,) [N] in trim over the load factor of one state (n_parameters,)."""
        return np.asarray(self.shares(state[None])[0] @ self.lifts)

    def strains_microstrain(self, states: FloatArray) -> FloatArray:
        """Return the gauge strains (n_states, n_gauges) in trim of damage fractions (n_states, n_parameters).

        Raises
        ------
        InputError
            If a damage is outside [0, 1), or a strain is beyond linear analysis.
        """
        each = np.stack([model.solve(states)[:, :-1] for model in self.models], axis=1)
        return checked_strains(self.load_factor * np.einsum("sk,skg->sg", self.shares(states), each))

    def divergence_pressures(self, states: FloatArray) -> FloatArray:
        """Return the least dynamic pressures (n_states,) [Pa] at which the twist has no end; inf for none.

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)
        matrices = self._answers([model.parts(damage) for model in self.models])
        return np.array([divergence_pressure(matrix[:, :-1]) for matrix in matrices])

    def _shares(self, parts: list[FloatArray]) -> FloatArray:
        """Solve A = e_1 + q (C A + C_m q / n) + rise alpha with A_1 = 1 for alpha and the other A."""
        pushed, camber = self.pressure * self._answers(parts), self.pressure / self.load_factor
        matrix = np.eye(len(self.rise)) - pushed[:, :, :-1]
        matrix[:, :, 0] = -self.rise
        found = np.linalg.solve(matrix, pushed[:, :, :1] + camber * pushed[:, :, -1:])[:, :, 0]
        found[:, 0] = 1.0  # alpha's place, that of A_1
        return np.column_stack([found, np.full(len(found), camber)])

    def _answers(self, parts: list[FloatArray]) -> FloatArray:
        """Return C and C_m (n_states, n_harmonics, n_harmonics + 1) [1/Pa]: change of A_m / A_1 by twist."""
        return np.stack([own @ answer.T for own, answer in zip(parts, self.answers, strict=True)], axis=2)


def trim_wing(
    wing: Wing,
    flight: FlightPoint | None = None,
    load_factor: float = 3.0,
    is_induced: bool = True,
    n_harmonics: int = N_HARMONICS,
) -> TrimmedWing:
    """Return the wing in trim at the speed and density of a flight point; its weight is that of the wing's lift.

    Without `is_induced` each strip lifts by 2 pi, as if it stood alone.

    Raises
    ------
    InputError
        As `reduce_wing`, or if the load factor is 0.
    """
    point, factor = FlightPoint() if flight is None else flight, checked_load_factor(load_factor)
    if factor == 0.0:
        raise InputError("load_factor is 0; expected another, to which the moment of the camber is set in proportion")
    orders = 2 * np.arange(n_harmonics) + 1
    lifts = np.array([*(harmonic_lift(wing, int(order)) for order in orders), camber_moment(wing)])
    models = tuple(reduce_wing(wing, lift=lift).model for lift in lifts)
    by_twist, rise = lifting_line(wing.planform, wing.grid.eta, orders, is_induced)
    per_pressure = 2.0 * np.pi * wing.span**2 / wing.lift[2::DOFS_PER_NODE].sum()
    rows = per_pressure * by_twist @ twist_rows(wing)
    answers = tuple(rows @ np.asarray(model.motion, dtype=np.float64) for model in models)
    return TrimmedWing(lifts, models, answers, rise, 0.5 * point.density * point.airspeed**2, factor)


def lifting_line(
    planform: Planform, eta: FloatArray, orders: IntArray, is_induced: bool = True
) -> tuple[FloatArray, FloatArray]:
    """Return A_n (n_orders, n_eta) per twist [1/rad] at span fractions `eta`, linear between, and per root angle."""
    theta = (np.arange(len(orders)) + 0.5) * np.pi / (2 * len(orders))
    slope = 2.0 * np.pi * planform.chord(np.cos(theta)) / (8.0 * planform.span)
    own = np.outer(slope, orders) * is_induced + np.sin(theta)[:, None]
    between = np.array([np.interp(np.cos(theta), eta, unit) for unit in np.eye(len(eta))]).T
    angles = np.column_stack([between, np.ones(len(theta))])
    found = np.linalg.solve(np.sin(np.outer(theta, orders)) * own, (slope * np.sin(theta))[:, None] * angles)
    return found[:, :-1], found[:, -1]


def divergence_pressure(answers: FloatArray) -> float:
    """Return the least q > 0 [Pa] with A = q C A of answers C (n, n) [1/Pa]; inf if there is none."""
    roots = np.linalg.eigvals(answers)
    real = roots.real[np.abs(roots.imag) <= 1e-9 * np.abs(roots)]
    most = float(real.max(initial=0.0))
    return 1.0 / most if most > 0.0 else float("inf")


def twist_rows(wing: Wing) -> FloatArray:
    """Return the map (n_eta, n_dofs) from displacements to the sections' twist [rad], nose up."""
    grid, rows = wing.grid, np.zeros((len(wing.grid.eta), len(wing.lift)))
    stations, chord = np.arange(len(grid.eta)), wing.planform.chord(grid.eta)
    rows[stations, DOFS_PER_NODE * grid.upper[:, 0] + 2] = 1.0 / chord
    rows[stations, DOFS_PER_NODE * grid.upper[:, -1] + 2] = -1.0 / chord
    return rows


def camber_moment(wing: Wing) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] of the moment of the camber at 1 Pa: couples of leading and trailing edge."""
    grid, forces = wing.grid, np.zeros_like(wing.lift)
    edges = np.concatenate([grid.eta[:1], 0.5 * (grid.eta[1:] + grid.eta[:-1]), grid.eta[-1:]])
    force = SECTION_MOMENT * wing.planform.chord(grid.eta) * wing.span * np.diff(edges)
    forces[DOFS_PER_NODE * grid.upper[:, [0, -1]] + 2] = np.outer(force, [1.0, -1.0])
    return forces


def harmonic_lift(wing: Wing, order: int) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] of A_n = A_1 at load factor 1 of an odd order; total zero but for order 1."""
    theta = np.arccos(np.clip(wing.structure.shells.mesh.nodes[:, 1] / wing.span, 0.0, 1.0))
    return wing.lift if order == 1 else moved_lift(wing, np.sin(order * theta) / np.maximum(np.sin(theta), 1e-6))


def moved_lift(wing: Wing, place: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] at load factor 1: lift times (place - its mean under the lift), total zero.

    `place` (n_nodes,) is any coordinate of the nodes.
    """
    vertical = wing.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    mean = float(vertical @ place / vertical.sum())
    moved = np.zeros((len(vertical), DOFS_PER_NODE))
    moved[:, 2] = vertical * (place - mean)
    return moved.ravel()
