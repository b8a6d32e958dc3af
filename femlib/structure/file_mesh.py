"""What a mesh file holds, whatever its format: nodes, blocks of elements, sets, and what is left out of the mesh."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.errors import MeshError

MOST_VALUES = 1000
"""An array of cells or points with more values than that numbers them and names no set."""


@dataclass(slots=True, eq=False)
class FileMesh:
    """A mesh before it is checked.

    Attributes
    ----------
    points : FloatArray
        Nodes (n_nodes, 2 or 3) in the file's unit.
    blocks : list of tuple
        Kind (meshio's name: quad, triangle6, line, vertex, ...) and nodes (n, width) of elements.
    element_sets : dict
        Members as truth values (n_elements,) by name, elements in the order of their blocks.
    node_sets : dict
        Nodes by name.
    left_out : dict
        How many of what the file has beside them, by its name, such as "CONM2 (masses)"; what changes the structure.
    without_set : dict
        Why an array of the file names no set, by its name.
    metres : float
        In the file's unit of length, where it says one.
    """

    points: FloatArray
    blocks: list[tuple[str, IntArray]]
    element_sets: dict[str, BoolArray]
    node_sets: dict[str, IntArray]
    left_out: dict[str, int] = field(default_factory=dict)
    without_set: dict[str, str] = field(default_factory=dict)
    metres: float = 1.0


def value_sets(label: str, values: FloatArray | IntArray, told: dict[str, str]) -> dict[str, BoolArray]:
    """Return a set for each value of an array of whole numbers on cells or points, "label:value".

    An array that names none gets its reason in `told`.
    """
    if values.ndim == 2 and values.shape[1] == 1:
        values = values[:, 0]
    if values.ndim != 1:
        told[label] = f"{values.shape[1]} numbers each"
    elif values.dtype.kind not in "biu":
        told[label] = f"{values.dtype.name}, no whole numbers"
    else:
        kinds = np.unique(values)
        if len(kinds) <= MOST_VALUES:
            return {f"{label}:{int(value)}": values == value for value in kinds}
        told[label] = f"{len(kinds)} values, a numbering"
    return {}


def masks(sets: Mapping[str, Iterable[int]], n: int) -> dict[str, BoolArray]:
    """Return sets of positions as truth values (n,)."""
    found = {}
    for name, members in sets.items():
        found[name] = np.zeros(n, dtype=bool)
        found[name][np.fromiter(members, dtype=np.int64)] = True
    return found


def wrong_kind(name: str, n: int, kind: str) -> MeshError:
    """Return the refusal of elements that are no shells and no lines."""
    return MeshError(
        f"{name} has {n} element{'s' * (n != 1)} of kind {kind}; expected shells and lines alone; mesh the middle "
        "surfaces of volumes with shells, and put shells in the place of others"
    )
