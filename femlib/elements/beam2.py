"""Two-node Timoshenko beam: exact for a prismatic beam that is loaded at its ends.

Source: Y. Luo, Adv. Theor. Appl. Mech. 1 (2008) 95-106, as pyfe3d's BeamC, the section's shear factors multiplying its
shear moduli. A beam whose axis lies beside its nodes is carried by rigid arms: u = u_node + theta x arm.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.elements.rotations import skew
from femlib.errors import InputError, frozen_floats, is_number, needed_by

if TYPE_CHECKING:
    from pyfe3d import BeamC

N_NODES = 2
N_DOFS = 12
LEAST_ACROSS = 1e-3
"""Share of a section's direction that must lie across the beam: .06 degrees."""


@dataclass(frozen=True, slots=True, eq=False)
class BeamSection:
    """Cross section and material of a beam.

    Attributes
    ----------
    young, shear : float
        Moduli [Pa].
    area : float
        Area [m^2].
    inertia_y, inertia_z : float
        Second moments of area about the section's y and z [m^4]; inertia_z resists bending along y.
    torsion : float
        Torsion constant J [m^4].
    y_axis : FloatArray
        Global direction (3,) whose part across the beam is the section's y.
    density : float
        Mass density [kg/m^3].
    shear_factor_y, shear_factor_z : float
        Share of the area that carries shear along y and z.
    offset : FloatArray
        From the nodes to the beam's axis (3,), in global axes [m].
    sides : tuple of float
        Edges along y and z [m] of a full rectangle, for decks of other programs; () for any other section.

    Raises
    ------
    InputError
        If a modulus or a moment is not positive, or the direction is zero.

    Examples
    --------
    >>> tube = BeamSection(70e9, 27e9, area=1e-4, inertia_y=1e-8, inertia_z=1e-8, torsion=2e-8, y_axis=(0, 1, 0))
    >>> round(tube.shear_factor_y, 3)
    0.833
    """

    young: float
    shear: float
    area: float
    inertia_y: float
    inertia_z: float
    torsion: float
    y_axis: FloatArray
    density: float = 0.0
    shear_factor_y: float = 5.0 / 6.0
    shear_factor_z: float = 5.0 / 6.0
    offset: FloatArray = (0.0, 0.0, 0.0)  # type: ignore[assignment]  # frozen as an array below
    sides: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        positive = ("young", "shear", "area", "inertia_y", "inertia_z", "torsion", "shear_factor_y", "shear_factor_z")
        for name in positive:
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                raise InputError(
                    f"beam {name} is {value!r}; expected a positive number in SI units; correct the section"
                )
        if not is_number(self.density) or self.density < 0.0:
            raise InputError(f"beam density is {self.density!r} kg/m^3; expected 0 or more; correct the section")
        for name in ("y_axis", "offset"):
            object.__setattr__(self, name, frozen_floats(getattr(self, name), f"beam {name}", (3,)))
        if not self.y_axis.any():
            raise InputError("beam y_axis is zero; expected a direction across the beam; give one")


def rectangular_beam(
    young: float,
    poisson: float,
    along_y: float,
    along_z: float,
    y_axis: Sequence[float] | FloatArray,
    density: float = 0.0,
    offset: Sequence[float] | FloatArray = (0.0, 0.0, 0.0),
) -> BeamSection:
    """Return the section of a full rectangle with edges `along_y` and `along_z` [m].

    Source of the torsion constant: W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain (2002), table
    10.7, case 4; within 2e-3 of the series.

    >>> arm = rectangular_beam(70e9, 0.3, along_y=0.02, along_z=0.02, y_axis=(0, 1, 0), density=2700.0)
    >>> arm.area, arm.inertia_z
    (0.0004, 1.3333333333333335e-08)
    """
    for name, value in (("young", young), ("along_y", along_y), ("along_z", along_z)):
        if not is_number(value) or value <= 0.0:
            raise InputError(f"beam {name} is {value!r}; expected a positive number in SI units; correct the section")
    if not is_number(poisson) or not -1.0 < poisson < 0.5:
        raise InputError(f"beam poisson is {poisson!r}; expected more than -1 and less than 0.5; correct the section")
    a, b = max(along_y, along_z) / 2.0, min(along_y, along_z) / 2.0
    return BeamSection(
        young=young,
        shear=young / (2.0 * (1.0 + poisson)),
        area=along_y * along_z,
        inertia_y=along_y * along_z**3 / 12.0,
        inertia_z=along_z * along_y**3 / 12.0,
        torsion=a * b**3 * (16.0 / 3.0 - 3.36 * b / a * (1.0 - b**4 / (12.0 * a**4))),
        y_axis=np.asarray(y_axis, dtype=np.float64),
        density=density,
        offset=np.asarray(offset, dtype=np.float64),
        sides=(along_y, along_z),
    )


def stiffness(points: FloatArray, sections: Sequence[BeamSection], section: IntArray) -> FloatArray:
    """Return the stiffness matrices (n, 12, 12) in global axes of beams with ends (n, 2, 3) [m].

    Raises
    ------
    InputError
        If a beam has no length or runs along its section's y axis.
    """
    return _matrices(points, sections, section, "update_KC0", ())


def mass(points: FloatArray, sections: Sequence[BeamSection], section: IntArray) -> FloatArray:
    """Return the consistent mass matrices (n, 12, 12) in global axes, arguments as `stiffness`."""
    return _matrices(points, sections, section, "update_M", (0,))


def _matrices(
    points: FloatArray, sections: Sequence[BeamSection], section: IntArray, update: str, options: tuple[int, ...]
) -> FloatArray:
    matrices = np.zeros((len(points), N_DOFS, N_DOFS))
    if not len(points):
        return matrices
    _check_places(points, sections, section)
    properties = [_property(own) for own in sections]
    whole = element_library().INT
    for ends, kind, matrix in zip(points, section, matrices, strict=True):
        rows, columns, values = np.zeros(N_DOFS**2, dtype=whole), np.zeros(N_DOFS**2, dtype=whole), np.zeros(N_DOFS**2)
        beam = _placed(ends + sections[kind].offset, sections[kind].y_axis)
        getattr(beam, update)(rows, columns, values, properties[kind], *options)
        np.add.at(matrix, (rows, columns), values)
        arm = _arms(sections[kind].offset)
        matrix[:] = arm.T @ matrix @ arm
    return matrices


@cache
def element_library() -> Any:
    """Return pyfe3d, imported with the first beam: shells need none.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    with needed_by("a beam element"):
        import_module("pyfe3d.beamprop")
        return import_module("pyfe3d")


def _check_places(points: FloatArray, sections: Sequence[BeamSection], section: IntArray) -> None:
    along = points[:, 1] - points[:, 0]
    length = np.linalg.norm(along, axis=1)
    none = np.flatnonzero(length <= 1e-12 * max(float(np.abs(points).max()), 1e-300))
    if none.size:
        raise InputError(
            f"beam {none[0]} at {np.round(points[none[0], 0], 4).tolist()} m has a length of {length[none[0]]:.3g} m; "
            "expected two ends apart; remove it or merge its nodes"
        )
    y_axis = np.array([own.y_axis for own in sections])[section]
    across = np.linalg.norm(np.cross(along, y_axis), axis=1) / (length * np.linalg.norm(y_axis, axis=1))
    bad = np.flatnonzero(across < LEAST_ACROSS)
    if bad.size:
        raise InputError(
            f"beam {bad[0]} at {np.round(points[bad[0], 0], 4).tolist()} m runs along its section's y_axis "
            f"{y_axis[bad[0]].tolist()}; expected a direction across it; choose another y_axis"
        )


def _property(section: BeamSection) -> Any:
    prop = element_library().beamprop.BeamProp()
    prop.A, prop.E, prop.G, prop.J = section.area, section.young, section.shear, section.torsion
    prop.G12, prop.G13 = section.shear_factor_y * section.shear, section.shear_factor_z * section.shear
    prop.Iyy, prop.Izz = section.inertia_y, section.inertia_z
    prop.intrho = section.density * section.area
    prop.intrhoy2, prop.intrhoz2 = section.density * section.inertia_z, section.density * section.inertia_y
    return prop


def _placed(ends: FloatArray, y_axis: FloatArray) -> "BeamC":
    """Return an element that sees only its own six coordinates."""
    library = element_library()
    beam: BeamC = library.BeamC(library.BeamCProbe())
    beam.c1, beam.c2 = 0, 6
    flat = np.ascontiguousarray(ends, dtype=np.float64).ravel()
    beam.update_rotation_matrix(*y_axis.tolist(), flat)
    beam.update_probe_xe(flat)
    return beam


def _arms(offset: FloatArray) -> FloatArray:
    """Return the map (12, 12) from the nodes' motions to those of the beam's ends."""
    arm = np.eye(N_DOFS)
    arm[0:3, 3:6] = arm[6:9, 9:12] = -skew(offset)  # theta x arm = -arm x theta
    return arm
