"""Materials and laminates: from moduli to the shell stiffness A, B, D.

A shell of plies at heights z has, per unit width, membrane forces N and moments M

    N = A eps + B kappa,   M = B eps + D kappa,   (A, B, D) = sum over plies of integral (1, z, z^2) Q dz,

and transverse shear forces `shear @ gamma`, order (yz, xz), of the energy that the stresses in equilibrium have.
Sources: R. M. Jones, Mechanics of Composite Materials (1999), eqs 4.22-4.24; K. Rohwer (1988, see `_shear`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, frozen_floats, is_number
from femlib.strength import Strength

SAME = 1e-9
"""Moduli that differ by less than this share are the same but for rounding."""


@dataclass(frozen=True, slots=True)
class Ply:
    """One orthotropic layer in plane stress.

    Attributes
    ----------
    young_1, young_2 : float
        Moduli along and across the fibres [Pa].
    poisson_12 : float
        Contraction across the fibres under stress along them [-].
    shear_12, shear_13, shear_23 : float
        Shear moduli [Pa].
    thickness : float
        Thickness [m].
    angle : float
        Fibre direction against the shell's axis [rad].
    density : float
        Mass density [kg/m^3].
    expansion_1, expansion_2 : float
        Thermal expansion along and across the fibres [1/K].
    strength : Strength, optional
        Stresses that it bears, where it is asked when the ply fails.

    Raises
    ------
    InputError
        If a modulus or the thickness is not positive, or the Poisson ratio breaks positive definiteness.

    Examples
    --------
    >>> Ply(135e9, 9e9, 0.3, 5e9, 5e9, 3e9, thickness=0.0002, angle=np.pi / 4, density=1600.0).strength is None
    True
    """

    young_1: float
    young_2: float
    poisson_12: float
    shear_12: float
    shear_13: float
    shear_23: float
    thickness: float
    angle: float = 0.0
    density: float = 0.0
    expansion_1: float = 0.0
    expansion_2: float = 0.0
    strength: Strength | None = None

    def __post_init__(self) -> None:
        for name in ("young_1", "young_2", "shear_12", "shear_13", "shear_23", "thickness"):
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                raise InputError(
                    f"ply {name} is {value!r}; expected a positive number in SI units; correct the material card"
                )
        for name in ("poisson_12", "angle", "density", "expansion_1", "expansion_2"):
            value = getattr(self, name)
            if not is_number(value):
                raise InputError(f"ply {name} is {value!r}; expected a finite number in SI units; correct the card")
        if self.density < 0.0:
            raise InputError(f"ply density is {self.density} kg/m^3; expected 0 or more; correct the material card")
        if self.poisson_12**2 * self.young_2 >= self.young_1:
            raise InputError(
                f"ply poisson_12 is {self.poisson_12}; expected less than sqrt(young_1 / young_2) in size, "
                "or the stiffness is not positive definite; correct the material card"
            )

    def plane_stress(self) -> FloatArray:
        """Return the stiffness (3, 3) [Pa] of strains (xx, yy, xy) in the shell's axes."""
        rest = 1.0 - self.poisson_12**2 * self.young_2 / self.young_1
        q12 = self.poisson_12 * self.young_2 / rest
        along = np.array([[self.young_1 / rest, q12, 0.0], [q12, self.young_2 / rest, 0.0], [0.0, 0.0, self.shear_12]])
        turn = self.strain_turn()
        return np.asarray(turn.T @ along @ turn)

    def transverse_shear(self) -> FloatArray:
        """Return the stiffness (2, 2) [Pa] of the shear strains (yz, xz) in the shell's axes."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[c, -s], [s, c]])
        return np.asarray(turn.T @ np.diag([self.shear_23, self.shear_13]) @ turn)

    def free_strain(self) -> FloatArray:
        """Return the strain (3,) [1/K] of one kelvin of free expansion in the shell's axes."""
        fibre = np.array([self.expansion_1, self.expansion_2, 0.0])
        return np.linalg.solve(self.strain_turn(), fibre)

    def strain_turn(self) -> FloatArray:
        """Return the rotation (3, 3) of engineering strains from the shell's axes to the fibre's."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])


@dataclass(frozen=True, slots=True, eq=False)
class Laminate:
    """Shell stiffness, mass and thermal forces per unit area of a stack of plies.

    Attributes
    ----------
    membrane, coupling, bending : FloatArray
        A [N/m], B [N] and D [N m], each (3, 3).
    shear : FloatArray
        Transverse shear stiffness (2, 2) of (yz, xz) [N/m], correction included.
    thickness : float
        Total thickness [m]; the reference surface lies in the middle.
    mass, mass_moment, rotary_inertia : float
        Integrals of density times 1, z, z^2 [kg/m^2, kg/m, kg].
    thermal_force, thermal_moment : FloatArray
        Force (3,) [N/m/K] and moment (3,) [N/K] of one kelvin of hindered uniform warming.
    gradient_force, gradient_moment : FloatArray
        The same of a temperature z * (1 K/m): (3,) [N/(K/m)/m] and (3,) [N m/(K/m)/m].
    plies : tuple of Ply
        What it was stacked from, bottom first, for export; empty if not known.

    Examples
    --------
    >>> shell = laminate([Ply(135e9, 9e9, 0.3, 5e9, 5e9, 3e9, 0.0002, density=1600.0)] * 4)
    >>> round(shell.mass, 3), len(shell.plies)  # [kg/m^2]
    (1.28, 4)
    """

    membrane: FloatArray
    coupling: FloatArray
    bending: FloatArray
    shear: FloatArray
    thickness: float
    mass: float
    mass_moment: float
    rotary_inertia: float
    thermal_force: FloatArray
    thermal_moment: FloatArray
    gradient_force: FloatArray
    gradient_moment: FloatArray
    plies: tuple[Ply, ...] = ()

    def __post_init__(self) -> None:
        if not is_number(self.thickness) or not self.thickness > 0.0:
            raise InputError(f"laminate thickness is {self.thickness} m; expected a positive number; correct the plies")
        shapes: tuple[tuple[str, tuple[int, ...]], ...] = (
            *((name, (3, 3)) for name in ("membrane", "coupling", "bending")),
            ("shear", (2, 2)),
            *((name, (3,)) for name in ("thermal_force", "thermal_moment", "gradient_force", "gradient_moment")),
        )
        for name, shape in shapes:
            object.__setattr__(self, name, frozen_floats(getattr(self, name), f"laminate {name}", shape))
        for name in ("mass", "mass_moment", "rotary_inertia"):
            if not is_number(getattr(self, name)):
                raise InputError(
                    f"laminate {name} is {getattr(self, name)!r}; expected a finite number; correct the plies"
                )
        self._check_positive()

    @property
    def is_isotropic(self) -> bool:
        """Whether the stiffness is the same in every direction of the surface."""
        square = (self.membrane, self.coupling, self.bending)
        sizes = (self.membrane, self.membrane * self.thickness, self.bending)
        turned = all(_is_isotropic(m, float(np.abs(s).max())) for m, s in zip(square, sizes, strict=True))
        shear = self.shear - 0.5 * np.trace(self.shear) * np.eye(2)
        return turned and float(np.abs(shear).max()) <= SAME * float(np.abs(self.shear).max())

    def _check_positive(self) -> None:
        """Raise InputError if some deformation would cost no energy."""
        unit = self.thickness  # strains and curvatures times thickness are of one size
        block = np.block([[self.membrane, self.coupling / unit], [self.coupling / unit, self.bending / unit**2]])
        for name, matrix in (("membrane, coupling and bending", block), ("shear", self.shear)):
            if not np.allclose(matrix, matrix.T, rtol=1e-8, atol=1e-10 * np.abs(matrix).max()):
                raise InputError(f"laminate {name} is not symmetric; expected a stiffness; correct its entries")
            if not np.linalg.eigvalsh(matrix)[0] > 0.0:
                raise InputError(
                    f"laminate {name} is not positive definite; expected a stiffness that every deformation costs "
                    "energy; correct the plies"
                )


def _is_isotropic(matrix: FloatArray, size: float) -> bool:
    off = (matrix[0, 0] - matrix[1, 1], matrix[0, 2], matrix[1, 2], matrix[0, 0] - matrix[0, 1] - 2.0 * matrix[2, 2])
    return all(abs(value) <= SAME * size for value in off)


def laminate(plies: Sequence[Ply]) -> Laminate:
    """Stack plies from the bottom to the top face.

    Raises
    ------
    InputError
        If there is no ply.

    Examples
    --------
    >>> plies = [Ply(135e9, 9e9, 0.3, 5e9, 5e9, 3e9, 0.0002, angle) for angle in (0.0, np.pi / 2, np.pi / 2, 0.0)]
    >>> shell = laminate(plies)  # symmetric: no coupling
    >>> round(shell.thickness, 4), bool(abs(shell.coupling).max() < 1e-6)
    (0.0008, True)
    """
    if not isinstance(plies, Sequence) or not all(isinstance(ply, Ply) for ply in plies):
        raise InputError(f"laminate got a {type(plies).__name__}; expected a list of Ply; put them in a list")
    if not plies:
        raise InputError("laminate got 0 plies; expected at least one; list them from the bottom to the top face")
    heights = np.concatenate([[0.0], np.cumsum([ply.thickness for ply in plies])])
    heights -= heights[-1] / 2.0
    powers = [np.diff(heights ** (k + 1)) / (k + 1) for k in range(3)]
    stiff = np.array([ply.plane_stress() for ply in plies])
    free = np.array([ply.plane_stress() @ ply.free_strain() for ply in plies])
    density = np.array([ply.density for ply in plies])
    membrane, coupling, bending = (np.einsum("p,pij->ij", power, stiff) for power in powers)
    mass, mass_moment, rotary_inertia = (float(power @ density) for power in powers)
    return Laminate(
        membrane=membrane,
        coupling=coupling,
        bending=bending,
        shear=_shear(plies, heights, membrane, coupling, bending),
        thickness=float(heights[-1] - heights[0]),
        mass=mass,
        mass_moment=mass_moment,
        rotary_inertia=rotary_inertia,
        thermal_force=powers[0] @ free,
        thermal_moment=powers[1] @ free,
        gradient_force=powers[1] @ free,
        gradient_moment=powers[2] @ free,
        plies=tuple(plies),
    )


def _shear(
    plies: Sequence[Ply], heights: FloatArray, membrane: FloatArray, coupling: FloatArray, bending: FloatArray
) -> FloatArray:
    """Return the stiffness (2, 2) of (yz, xz) whose energy is that of the shear stresses in equilibrium.

    Moments that grow along x or along y alone (two cylindrical bendings) have stresses s(z) = Q (z - A^-1 B) D*^-1 M
    and so shear stresses t(z) = -integral of their slopes from the bottom, t = f (Q_y, Q_x); the flexibility is the
    integral of f' G^-1 f. One layer has 5/6 of its shear stiffness; a stack of stiff and soft layers may have a
    fraction of it. Source: K. Rohwer, Improved transverse shear stiffnesses for layered finite elements,
    DFVLR-Forschungsbericht 88-32 (1988). Price: the pair of directions that bend cylindrically is the laminate's own
    axes; an unequal stack turned against them differs a little.
    """
    offset: FloatArray = np.asarray(np.linalg.solve(membrane, coupling), dtype=np.float64)
    inverse = np.linalg.inv(bending - coupling @ offset)
    places, weights = np.polynomial.legendre.leggauss(3)  # exact: f is a parabola in each ply
    flexibility, below = np.zeros((2, 2)), np.zeros((3, 3))
    for ply, bottom, top in zip(plies, heights[:-1], heights[1:], strict=True):
        stiff, soft = ply.plane_stress(), np.linalg.inv(ply.transverse_shear())
        for place, weight in zip(places.tolist(), weights.tolist(), strict=True):
            z = bottom + 0.5 * (1.0 + place) * (top - bottom)
            f = _across(below + _grown(stiff, offset, bottom, z) @ inverse)
            flexibility += 0.5 * weight * (top - bottom) * f.T @ soft @ f
        below = below + _grown(stiff, offset, bottom, top) @ inverse
    return np.asarray(np.linalg.inv(flexibility), dtype=np.float64)


def _grown(stiff: FloatArray, offset: FloatArray, bottom: float, z: float) -> FloatArray:
    """Return the integral of Q (z - A^-1 B) from the bottom of a ply to a height."""
    return np.asarray(stiff @ (0.5 * (z * z - bottom * bottom) * np.eye(3) - (z - bottom) * offset))


def _across(f: FloatArray) -> FloatArray:
    """Return the shear stresses (yz, xz) of unit forces (Q_y, Q_x) from the stresses (xx, yy, xy) of unit moments."""
    return np.array([[f[1, 1], f[2, 0]], [f[2, 1], f[0, 0]]])


def isotropic_plate(
    young: float,
    poisson: float,
    thickness: float,
    density: float = 0.0,
    expansion: float = 0.0,
    strength: Strength | None = None,
) -> Laminate:
    """Return the laminate of one isotropic layer: modulus [Pa], thickness [m], density [kg/m^3], expansion [1/K].

    Raises
    ------
    InputError
        If a number is not finite, or Poisson's ratio is not between -1 and 0.5.

    Examples
    --------
    >>> steel = isotropic_plate(210e9, poisson=0.3, thickness=0.002, density=7850.0)
    >>> round(float(steel.bending[0, 0]), 1), round(steel.mass, 3)  # [N m], [kg/m^2]
    (153.8, 15.7)
    """
    if not is_number(young):
        raise InputError(f"young is {young!r}; expected a positive number of Pa; correct the material card")
    if not is_number(poisson) or not -1.0 < poisson < 0.5:
        raise InputError(f"poisson is {poisson!r}; expected more than -1 and less than 0.5; correct the material card")
    shear = young / (2.0 * (1.0 + poisson))
    ply = Ply(young, young, poisson, shear, shear, shear, thickness, 0.0, density, expansion, expansion, strength)
    return laminate([ply])
