"""What a mesh file holds, whatever its format: nodes, blocks of elements, sets, and what is left out of the mesh."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.errors import InputError, MeshError

MOST_VALUES = 1000
"""An array of cells or points with more values than that numbers them and names no set."""
CORNERS = {"quad8": 4, "quad9": 4, "triangle6": 3}
"""Corners of an element that may lack some of its middles."""


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


def assembled(
    path: Path,
    nodes: Mapping[int, Sequence[float]],
    elements: Mapping[int, tuple[str, Sequence[int]]],
    node_sets: Mapping[str, Iterable[int]],
    element_sets: Mapping[str, Iterable[int]],
) -> FileMesh:
    """Return the mesh of nodes and elements by number, in blocks of a kind, with sets of their numbers.

    Parameters
    ----------
    path : Path
        Of the file, for a message.
    nodes : mapping
        Places (3,) by number.
    elements : mapping
        Kind ("" for none that belongs to the mesh) and nodes by number; 0 is a middle that a quadratic element lacks,
        and becomes its first corner.
    node_sets, element_sets : mapping
        Members by name; what is not in the mesh is left out.

    Raises
    ------
    InputError
        If an element names a node that is not there.
    """
    place = {number: k for k, number in enumerate(nodes)}
    position: dict[int, int] = {}
    blocks = []
    for number, (kind, own) in elements.items():
        n_corners = CORNERS.get(kind, len(own))
        missing = [n for n in own if n and n not in place]
        if missing or not all(own[:n_corners]):
            raise InputError(
                f"{path}: element {number} has the nodes {list(own)}, of which {missing or 'a corner'} is not in the "
                "file; expected each of them once; write the whole file"
            )
    for kind in dict.fromkeys(kind for kind, _ in elements.values() if kind):
        rows = {number: [place[n or own[0]] for n in own] for number, (its, own) in elements.items() if its == kind}
        position |= {number: len(position) + k for k, number in enumerate(rows)}
        blocks.append((kind, np.array(list(rows.values()), dtype=np.int64)))
    masks = {}
    for name, members in element_sets.items():
        masks[name] = np.zeros(len(position), dtype=bool)
        masks[name][[position[n] for n in members if n in position]] = True
    alone = {
        name: np.array(list(dict.fromkeys(place[n] for n in own if n in place)), dtype=np.int64)
        for name, own in node_sets.items()
    }
    points = np.array(list(nodes.values()), dtype=np.float64).reshape(-1, 3)
    return FileMesh(points, blocks, masks, alone)


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


def wrong_kind(name: str, n: int, kind: str) -> MeshError:
    """Return the refusal of elements that are no shells and no lines."""
    return MeshError(
        f"{name} has {n} element{'s' * (n != 1)} of kind {kind}; expected shells and lines alone; mesh the middle "
        "surfaces of volumes with shells, and put shells in the place of others"
    )
