"""A structure as a function of parameters: what the prediction and its gradient need."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.assembly import Shells, Supports
from femlib.calibration.varying import Varying, VaryingRows
from femlib.errors import InputError


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """The structure at one set of parameter values.

    Stiffness and mass are sums over elements, K = sum_e s_e d_e K_e and M = sum_e m_e M_e + M_points, with the matrices
    K_e and M_e of `shells`: a parameter acts through the factors s, d, m, through loads, and through output rows.

    Attributes
    ----------
    shells : Shells
        Mesh and sections; their matrices at the factor that `shells.scale` has.
    supports : Supports
        What is held.
    stiffness, mass : Varying
        Factors s and m (n_elements,) on the elements' stiffness and mass.
    states : mapping
        Factors d (n_elements,) of the named states, such as 1 - mu in a damage region.
    loads : mapping
        Nodal forces (n_dofs,) by name.
    outputs : mapping
        Rows by name.
    point_mass : csc_array, optional
        Mass matrix (n_dofs, n_dofs) of what is carried.
    """

    shells: Shells
    supports: Supports
    stiffness: Varying
    mass: Varying
    states: Mapping[str, Varying]
    loads: Mapping[str, Varying]
    outputs: Mapping[str, VaryingRows]
    point_mass: sparse.csc_array | None = field(default=None)

    def __post_init__(self) -> None:
        mesh = self.shells.mesh
        for what, found, size in (
            *(("stiffness", v, mesh.n_elements) for v in (self.stiffness,)),
            *(("mass", v, mesh.n_elements) for v in (self.mass,)),
            *((f"state {name}", v, mesh.n_elements) for name, v in self.states.items()),
            *((f"load {name}", v, mesh.n_dofs) for name, v in self.loads.items()),
        ):
            if np.shape(found.value) != (size,):
                raise InputError(f"{what} has shape {np.shape(found.value)}; expected ({size},); make it of this mesh")
        for name, rows in self.outputs.items():
            if rows.value.shape[1] != mesh.n_dofs:
                raise InputError(
                    f"output {name} has {rows.value.shape[1]} columns; expected {mesh.n_dofs}, one for each degree of "
                    "freedom; make it of this mesh"
                )
        for what, found in (("stiffness", self.stiffness), *((f"state {n}", v) for n, v in self.states.items())):
            if not (found.value > 0.0).all():
                bad = int(np.flatnonzero(~(found.value > 0.0))[0])
                raise InputError(
                    f"{what} of element {bad} is {found.value[bad]}; expected more than 0; narrow the "
                    "parameters' ranges"
                )


class ParametricStructure(Protocol):
    """A structure with parameters."""

    def design(self, values: Mapping[str, float]) -> Design:
        """Return the structure at parameter values by name."""
        ...


def element_masses(shells: Shells) -> FloatArray:
    """Return the mass (n_elements,) [kg] of each element at the factor 1."""
    areal = np.array([laminate.mass for laminate in shells.laminates])[shells.section]
    return np.asarray(areal * np.linalg.norm(shells.mesh.area_vectors(), axis=1))
