"""A damage region as a component with ports, and the states that name how much stiffness each has lost."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real

import numpy as np
import scipy.sparse as sparse
from numpy.typing import ArrayLike

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly import Shells, Supports, factorise
from femlib.errors import InputError, frozen_floats


@dataclass(frozen=True, slots=True, eq=False)
class Component:
    """One region whose stiffness falls with its parameter.

    Attributes
    ----------
    name, parameter : str
        Names of the region and of its damage parameter.
    elements : BoolArray
        Which elements belong to it (n_elements,), as truth values.
    """

    name: str
    parameter: str
    elements: BoolArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "elements", np.array(self.elements))


@dataclass(frozen=True, slots=True, eq=False)
class Condensed:
    """A region condensed on its ports, in numbers of the free degrees of freedom.

    Attributes
    ----------
    ports, interior : IntArray
        Free degrees of freedom shared with the rest (n_ports,), and the region's own (n_interior,).
    stiffness : FloatArray
        T (n_ports, n_ports) of the module's docstring.
    carry : FloatArray
        K_bi K_ii^-1 (n_ports, n_interior): from interior loads to port forces.
    """

    ports: IntArray
    interior: IntArray
    stiffness: FloatArray
    carry: FloatArray

    def interior_load(self, force: FloatArray) -> FloatArray:
        """Return the forces (n_free,) that stand for the interior loads: w at mu / (1 - mu) = 1 without its T term."""
        stand_in = np.zeros_like(force)
        stand_in[self.interior] = force[self.interior]
        stand_in[self.ports] = self.carry @ force[self.interior]
        return stand_in


def condense(shells: Shells, supports: Supports, component: Component) -> Condensed:
    """Return a region condensed on the degrees of freedom that it shares with the rest of the structure."""
    stiffness = supports.reduce(shells.stiffness(component.elements))
    own = np.flatnonzero(np.diff(stiffness.indptr))
    is_port = shells.touched(~component.elements)[supports.free[own]]
    ports, interior = own[is_port], own[~is_port]
    if not len(ports):
        raise InputError(
            f"region {component.name} shares no moving node with the rest of the structure; expected a part of it that "
            "the rest holds; where everything is damaged alike, divide the displacements by 1 - mu"
        )
    across = stiffness[interior][:, ports].toarray()
    carry = across.T
    if len(interior):
        inside = sparse.csc_array(stiffness[interior][:, interior])
        carry = factorise(inside, supports.groups[interior]).solve(across).T
    condensed = stiffness[ports][:, ports].toarray() - carry @ across
    return Condensed(ports, interior, 0.5 * (condensed + condensed.T), carry)


def damage_row(state: Mapping[str, float], parameters: Sequence[str]) -> FloatArray:
    """Return a named state as a row (n_parameters,); parameters that the state does not name are undamaged.

    Raises
    ------
    InputError
        If the state names an unknown parameter.

    Examples
    --------
    >>> damage_row({"mu2": 0.4}, ["mu1", "mu2"]).tolist()
    [0.0, 0.4]
    """
    if not isinstance(state, Mapping):
        raise InputError(f"state is a {type(state).__name__}; expected damages by parameter name; write {{'mu1': 0.4}}")
    unknown = sorted(set(state) - set(parameters))
    if unknown:
        raise InputError(f"state names {unknown}; expected some of {list(parameters)}; correct the parameter's name")
    wrong = {name: value for name, value in state.items() if not isinstance(value, Real) or isinstance(value, bool)}
    if wrong:
        raise InputError(f"state has {wrong}; expected fractions of stiffness lost; give numbers, 0.4 for 40 %")
    return np.array([float(state.get(name, 0.0)) for name in parameters])


def checked_damage(states: ArrayLike, parameters: Sequence[str]) -> FloatArray:
    """Return states (n_states, n_parameters) as floats after checking that every damage lies in [0, 1).

    >>> checked_damage([[0.0, 0.4]], ["mu1", "mu2"]).shape
    (1, 2)
    """
    damage = frozen_floats(states, "states", (-1, len(parameters)))
    bad = (damage < 0.0) | (damage >= 1.0)
    if bad.any():
        row, column = (int(k) for k in np.argwhere(bad)[0])
        raise InputError(
            f"state {row} has {parameters[column]} = {damage[row, column]:g}; expected a loss of stiffness from 0 to "
            "below 1 (a loss of 1 leaves a mechanism); give it as a fraction, not in percent"
        )
    return damage


def refuse_overlap(components: Sequence[Component], n_elements: int) -> None:
    """Raise InputError if a region is empty or of another mesh, or two share an element or a parameter."""
    if not isinstance(components, Sequence) or not all(isinstance(c, Component) for c in components):
        raise InputError(
            f"components are a {type(components).__name__}; expected a tuple of Component; put them in one"
        )
    for component in components:
        got = np.shape(component.elements)
        if got != (n_elements,):
            raise InputError(
                f"region {component.name} has elements of shape {got}; expected ({n_elements},), one boolean "
                "for each element of the mesh; make them from that mesh"
            )
        kind = np.asarray(component.elements).dtype
        if kind != np.bool_:
            raise InputError(
                f"region {component.name} has elements of {kind}; expected booleans, one for each element of the "
                "mesh; write elements == 1 for zeros and ones"
            )
    parameters = [component.parameter for component in components]
    if len(set(parameters)) != len(parameters):
        raise InputError(f"components have the parameters {parameters}; expected a different one for each; rename one")
    for k, second in enumerate(components):
        if not second.elements.any():
            raise InputError(f"region {second.name} holds no element; expected at least one; move it onto the mesh")
        for first in components[:k]:
            shared = int(np.sum(first.elements & second.elements))
            if shared:
                raise InputError(
                    f"regions {first.name} and {second.name} share {shared} elements; "
                    "expected none; move their edges apart"
                )
