"""Strains of another program's shells beside femlib's, element by element: what may be compared, and what may not.

Another program's strain has an element, a height over the reference surface, and axes. femlib reads its own at the
same centre, height and axes by three gauges at 0, 45 and 90 degrees:

    gamma_xy = 2 e_45 - e_x - e_y

Axes are those of Nastran's elements: of a triangle x runs from the first corner to the second; of a quadrilateral, with
the unit vectors d and e of its diagonals from corners 1 and 2, x = d - e and y = d + e. For a rectangle x is its first
side. Source: MSC Nastran Quick Reference Guide, CQUAD4 and CTRIA3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray, IntArray
from femlib.errors import InputError, frozen_floats, frozen_ints
from femlib.sensors import StrainGauge
from femlib.structure.model import MICRO, Structure

CENTRES = 0
"""Number that Nastran's tables give the centre of an element among its corners' nodes."""
MOST_ELEMENTS = 2000
"""Elements that are compared at once: each takes six gauges."""
COLUMNS = ("xx", "yy", "xy")


@dataclass(frozen=True, slots=True, eq=False)
class ForeignStrains:
    """Strains at the centres of shells, tension positive, in the axes of Nastran's elements.

    Attributes
    ----------
    elements : IntArray
        Numbers (n,) of elements in the other program; each may come several times, at several heights.
    heights : FloatArray
        Heights (n,) over the reference surface, along the normal by the order of the corners [m].
    strains : FloatArray
        (n, 3) xx, yy and the engineering shear strain xy, twice the tensor's.

    Examples
    --------
    >>> ForeignStrains([7, 7], [-1e-3, 1e-3], [[1e-4, -3e-5, 0.0], [2e-4, -6e-5, 0.0]]).elements.tolist()
    [7, 7]
    """

    elements: IntArray | Any  # given as lists too
    heights: FloatArray | Any
    strains: FloatArray | Any

    def __post_init__(self) -> None:
        object.__setattr__(self, "elements", frozen_ints(self.elements, "elements", (-1,)))
        n = len(self.elements)
        object.__setattr__(self, "heights", frozen_floats(self.heights, "heights", (n,)))
        object.__setattr__(self, "strains", frozen_floats(self.strains, "strains", (n, 3)))


def strains_of_op2(table: Any, metres: float, step: int = 0) -> ForeignStrains:
    """Return the strains at the centres in a table of pyNastran: `op2.op2_results.strain.cquad4_strain[1]`, or ctria3.

    Parameters
    ----------
    table
        a RealPlateStrainArray.
    metres
        of the deck's unit of length: 0.001 for mm. An OP2 has no units.
    step
        which of its times, load steps or modes.

    Raises
    ------
    InputError
        If it holds stresses, strains of plies (PCOMP), strains and curvatures of the reference surface (STRCUR), or no
        such step.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> data = [[[-1.0, 1e-4, 0, 0, 0, 0, 0, 0], [1.0, 2e-4, 0, 0, 0, 0, 0, 0]]]
    >>> rows = {"element_node": [[7, 0], [7, 0]], "data": data}
    >>> table = SimpleNamespace(is_stress=False, is_fiber_distance=True, **rows)
    >>> strains_of_op2(table, metres=1e-3).heights.tolist()
    [-0.001, 0.001]
    """
    if getattr(table, "is_stress", True) or not hasattr(table, "element_node"):
        raise InputError(
            "the table holds stresses, or strains of plies; expected those of plates; ask Nastran for "
            "STRAIN(FIBER) = ALL, and take cquad4_strain or ctria3_strain"
        )
    if not table.is_fiber_distance:
        raise InputError(
            "the table holds strains and curvatures of the reference surface (STRCUR); expected strains at two "
            "heights; ask Nastran for STRAIN(FIBER) = ALL"
        )
    places, data = np.asarray(table.element_node), np.asarray(table.data, dtype=np.float64)
    if not 0 <= step < len(data):
        raise InputError(f"step {step} of a table of {len(data)}; expected 0 to {len(data) - 1}; name another")
    own = places[:, 1] == CENTRES
    return ForeignStrains(places[own, 0], metres * data[step, own, 0], data[step, own, 1:4])


def strains_beside(
    structure: Structure, moved: FloatArray, foreign: ForeignStrains, element_of: Mapping[int, int]
) -> pd.DataFrame:
    """Return a row for each foreign strain: element, height [m], both programs' strains and differences [microstrain].

    Parameters
    ----------
    structure
        femlib's.
    moved
        its displacements (n_nodes, 6) [m, rad].
    foreign
        the other program's strains.
    element_of
        femlib's number of a shell by the other program's: `femlib.structure.nastran.shell_numbers(deck)`.

    Raises
    ------
    InputError
        If an element is not in the mesh, a height lies outside its shell, or there are more than 2,000 elements.
    """
    mesh = structure.built.mesh
    numbers = [element_of.get(int(number), -1) for number in foreign.elements]
    pairs = zip(foreign.elements.tolist(), numbers, strict=True)
    lost = next((number for number, k in pairs if not 0 <= k < mesh.n_elements), None)
    if lost is not None:
        raise InputError(
            f"element {lost} is not in the mesh; expected one of {len(element_of)}; leave the others out of the result"
        )
    if len(set(numbers)) > MOST_ELEMENTS:
        raise InputError(
            f"{len(set(numbers))} elements; expected at most {MOST_ELEMENTS}; choose some by their numbers"
        )
    gauges: list[StrainGauge] = []
    for number, k, height in zip(foreign.elements.tolist(), numbers, foreign.heights.tolist(), strict=True):
        gauges += _rosette(structure, k, height, number)
    strains = (structure.strain_rows(gauges) @ np.asarray(moved).ravel()).reshape(-1, 3)
    own = np.column_stack([strains[:, 0], strains[:, 2], 2.0 * strains[:, 1] - strains[:, 0] - strains[:, 2]])
    found: dict[str, Any] = {"element": foreign.elements, "height": foreign.heights}
    for what, values in (("foreign", foreign.strains), ("own", own), ("difference", own - foreign.strains)):
        found |= {f"{what}_{name}": MICRO * values[:, k] for k, name in enumerate(COLUMNS)}
    return pd.DataFrame(found)


def nastran_axes(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the axes x and y (3,) of a shell by its corners (3 or 4, 3), as Nastran's elements have them.

    Examples
    --------
    >>> x, y = nastran_axes(np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]))
    >>> x.round(3).tolist(), y.round(3).tolist()
    ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    """
    if len(corners) == 3:
        x = corners[1] - corners[0]
        y = corners[2] - corners[0] - x * ((corners[2] - corners[0]) @ x) / (x @ x)
    else:
        d, e = corners[2] - corners[0], corners[3] - corners[1]
        d, e = d / np.linalg.norm(d), e / np.linalg.norm(e)
        x, y = d - e, d + e
    return x / np.linalg.norm(x), y / np.linalg.norm(y)


def _rosette(structure: Structure, element: int, height: float, number: int) -> Sequence[StrainGauge]:
    """Return gauges at 0, 45 and 90 degrees at an element's centre, at a height."""
    built = structure.built
    corners = built.mesh.nodes[built.mesh.corners_of(element)]
    side = height / (built.laminates[built.section[element]].thickness / 2.0)
    if not abs(side) <= 1.0 + 1e-6:
        raise InputError(
            f"element {number} has a strain at {height:g} m, which is {abs(side):.3g} of half its thickness; expected "
            "a height within the shell; give the unit of length of the deck"
        )
    x, y = nastran_axes(corners)
    sets = tuple(name for name, own in structure.mesh.element_sets.items() if own[element])
    side = float(np.clip(side, -1.0, 1.0))
    return [
        StrainGauge(f"{number} {height} {along}", corners.mean(axis=0), along, sets, side) for along in (x, x + y, y)
    ]
