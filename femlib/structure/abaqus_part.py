"""Nodes, elements and sets of a part of an Abaqus or CalculiX deck, and the mesh that they make."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.checked import fortran_number
from femlib.structure.file_mesh import FileMesh, assembled

FARTHEST = 1e12
"""Coordinate in the file's unit, at most."""
SHORTEST = 1e-100
"""Distance of two points that a line goes through, at least; the square of a shorter one may be zero."""
MOST_GENERATED = 10_000_000
"""Nodes, elements or numbers that one card may generate."""


@dataclass(slots=True)
class Part:
    """Nodes and elements of a part or of a flat deck, by number, in the order of the deck.

    Attributes
    ----------
    nodes : places (3,) by number.
    elements : kind, nodes by number.
    sets : members by kind ("NSET", "ELSET"), then by name.
    """

    nodes: dict[int, tuple[float, ...]] = field(default_factory=dict)
    elements: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)
    sets: dict[str, dict[str, list[int]]] = field(default_factory=lambda: {"NSET": {}, "ELSET": {}})


def extend(sets: dict[str, list[int]], name: str, members: Sequence[int]) -> None:
    """Add members to a set."""
    sets.setdefault(name, []).extend(members)


def joined(first: Part, second: Part) -> Part:
    """Return both parts as one."""
    sets = {kind: first.sets[kind] | second.sets[kind] for kind in first.sets}
    return Part(first.nodes | second.nodes, first.elements | second.elements, sets)


def counted(first: int, last: int, step: int) -> list[int]:
    """Return the numbers from `first` to `last`."""
    if step == 0 or abs(last - first) // abs(step) > MOST_GENERATED:
        raise ValueError(f"{first} to {last} by {step}; expected at most {MOST_GENERATED} numbers")
    return list(range(first, last + (1 if step > 0 else -1), step))


def motion(rows: Sequence[Sequence[str]]) -> Callable[[tuple[float, ...]], FloatArray]:
    """Return what moves a place as an instance says: a shift, then a turn [deg] about the line through two points."""
    numbers = [[fortran_number(word) if word else 0.0 for word in row] for row in rows]
    if any(abs(value) > FARTHEST for row in numbers for value in row):
        raise ValueError(f"it is moved by {numbers}")
    shift = np.array((numbers[0] + [0.0] * 3)[:3] if numbers else [0.0] * 3)
    if len(numbers) < 2:
        return lambda place: np.array(place) + shift
    start, end, angle = np.array(numbers[1][:3]), np.array(numbers[1][3:6]), np.radians(numbers[1][6])
    length = float(np.linalg.norm(end - start))
    if length < SHORTEST:
        raise ValueError(f"it is turned about a line through one point, {start.tolist()}; expected two")
    axis = (end - start) / length
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return lambda place: start + turn @ (np.array(place) + shift - start)


def element_rows(rows: Sequence[Sequence[str]], width: int) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Give number and nodes of elements, whose lines go on until they have `width` nodes.

    A beam may have one node more, which says how its section stands: it is no end of it.
    """
    got: list[int] = []
    for row in rows:
        got += [int(word) for word in row if word]
        if len(got) > width:
            is_turned = width in (2, 3) and len(got) == width + 2
            if len(got) != width + 1 and not is_turned:
                raise ValueError(f"element {got[0]} has {len(got) - 1} nodes, expected {width}")
            yield got[0], tuple(got[1 : width + 1])
            got = []
    if got:
        raise ValueError(f"element {got[0]} has {len(got) - 1} nodes, expected {width}")


def mesh_of(path: Path, part: Part, left_out: dict[str, int]) -> FileMesh:
    """Return the mesh of the whole, elements in blocks of a kind."""
    known = {number for number, (kind, _) in part.elements.items() if kind}
    sets = {name: own for name, own in part.sets["ELSET"].items() if not own or not known.isdisjoint(own)}
    found = assembled(path, part.nodes, part.elements, part.sets["NSET"], sets)
    found.left_out = left_out
    return found
