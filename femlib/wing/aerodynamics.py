"""The lift that a vortex lattice finds at a load factor, as nodal forces.

The angle of attack is sought at which the lattice carries n W; camber lifts without it, so the distribution and its
centre of pressure change with the load factor and the forces are not proportional to it. Each panel's force is spread
evenly over the panel's span and over its chord about the vortex, and every hat function of the grid takes its integral:
resultant and moments stay exactly. Half goes to each skin.

Source: J. Katz, A. Plotkin, Low-Speed Aerodynamics (2001), section 12.3 (vortex lattice), as in AeroSandbox. Price: no
stall, no drag of friction, no change of the flow as the wing bends.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, SolveError, is_number, needed_by
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.loads import EFFECTIVE_MASS, GRAVITY
from femlib.wing.model import Wing, checked_load_factor
from femlib.wing.planform import SECTION

STRIPS = 40
"""Panels over the half-span, crowded toward root and tip; 20 change the root moment by 0.4 %."""
ROWS = 8
"""Panels over the chord."""
MOST_TRIES = 12


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
class AeroLoad:
    """The air's forces on the half wing.

    Attributes
    ----------
    load_factor : float
        Lift over weight.
    angle_of_attack : float
        Of the root's chord [rad].
    forces : FloatArray
        Nodal forces (n_dofs,) at this load factor [N]: give them as `lift` at load factor 1.
    """

    load_factor: float
    angle_of_attack: float
    forces: FloatArray


def vortex_lattice(wing: Wing, load_factor: float, flight: FlightPoint | None = None) -> AeroLoad:
    """Return the air's forces at a load factor, from AeroSandbox's vortex lattice.

    Raises
    ------
    InputError
        If AeroSandbox is not installed or the load factor is not finite.
    SolveError
        If no angle of attack carries the load.
    """
    point = FlightPoint() if flight is None else flight
    wanted = checked_load_factor(load_factor) * point.mass * GRAVITY
    lattice = _Lattice(_aerosandbox(), wing, point)
    angles, lifts = [0.0, 0.1], [lattice.solved(0.0)["L"], lattice.solved(0.1)["L"]]
    for _ in range(MOST_TRIES):
        angle = angles[-1] + (wanted - lifts[-1]) * (angles[-1] - angles[-2]) / (lifts[-1] - lifts[-2])
        lift = lattice.solved(angle)["L"]
        if abs(lift - wanted) <= 1e-9 * point.mass * GRAVITY:
            return AeroLoad(load_factor, angle, lattice.nodal_forces())
        angles, lifts = [angles[-1], angle], [lifts[-1], lift]
    raise SolveError(f"no angle of attack carries load factor {load_factor} at {point.airspeed} m/s; fly faster")


def _aerosandbox() -> Any:
    with needed_by("the vortex lattice (the elliptic lift needs nothing more)"):
        import aerosandbox
    return aerosandbox


class _Lattice:
    """AeroSandbox's lattice of the wing and its mirror image."""

    def __init__(self, asb: Any, wing: Wing, point: FlightPoint) -> None:
        self.asb, self.wing, self.point = asb, wing, point
        planform = wing.planform
        name = f"naca{SECTION.camber * 100:.0f}{SECTION.camber_position * 10:.0f}{SECTION.thickness * 100:02.0f}"
        sections = [
            asb.WingXSec(
                xyz_le=[*planform.position(eta, 0.0).tolist(), 0.0],
                chord=float(planform.chord(eta)),
                airfoil=asb.Airfoil(name),
            )
            for eta in (0.0, 1.0)
        ]
        self.airplane = asb.Airplane(wings=[asb.Wing(symmetric=True, xsecs=sections)])
        self.found: Any = None

    def solved(self, angle: float) -> Any:
        """Solve at an angle of attack [rad] and return AeroSandbox's resultants."""
        air = self.asb.OperatingPoint(velocity=self.point.airspeed, alpha=np.degrees(angle))
        factor = self.point.density / float(air.atmosphere.density())
        self.found = self.asb.VortexLatticeMethod(
            self.airplane, air, spanwise_resolution=STRIPS, chordwise_resolution=ROWS
        )
        result = self.found.run()
        return {"L": factor * float(result["L"])}

    def nodal_forces(self) -> FloatArray:
        """Return the last solution as nodal forces (n_dofs,) of the half wing."""
        found, planform, grid = self.found, self.wing.planform, self.wing.grid
        right = found.vortex_centers[:, 1] > 0.0
        centre = found.vortex_centers[right]
        y = np.stack([found.front_left_vertices[right, 1], found.front_right_vertices[right, 1]])
        spans = np.sort(np.clip(y / planform.span, 0.0, 1.0), axis=0)
        chord = planform.chord(centre[:, 1] / planform.span)
        fraction = centre[:, 0] / chord + planform.spar_fraction
        reach = np.minimum(0.5 / ROWS, np.minimum(fraction, 1.0 - fraction))
        factor = self.point.density / float(found.op_point.atmosphere.density())
        loads = np.zeros((grid.n_nodes, DOFS_PER_NODE))
        for k, force in enumerate(factor * found.forces_geometry[right]):
            along = hat_means(grid.eta, spans[0, k], spans[1, k])
            across = hat_means(grid.chord, fraction[k] - reach[k], fraction[k] + reach[k])
            share = 0.5 * np.outer(along, across)[:, :, None] * force
            for skin in (grid.upper, grid.lower):
                np.add.at(loads[:, :3], skin, share)
        return loads.ravel()


def hat_means(lines: FloatArray, start: float, end: float) -> FloatArray:
    """Return the means over [start, end] of the hat functions of grid lines (n,); sum 1, centre of mass kept."""
    stops = np.concatenate([[start], lines[(lines > start) & (lines < end)], [end]])
    middles, widths = 0.5 * (stops[1:] + stops[:-1]), np.diff(stops)
    cell = np.clip(np.searchsorted(lines, middles) - 1, 0, len(lines) - 2)
    outer = (middles - lines[cell]) / (lines[cell + 1] - lines[cell])
    means = np.zeros(len(lines))
    np.add.at(means, cell, widths * (1.0 - outer))
    np.add.at(means, cell + 1, widths * outer)
    return means / (end - start)
