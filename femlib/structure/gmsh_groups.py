"""Physical groups of gmsh's MSH 4.1, all of them: meshio 5.3.5 has those with names alone, without turned entities.

gmsh writes the number of a group below zero at an entity that it turns, as in Physical Surface("skin") = {1, -2}. The
elements belong to the group and have the other side on top; MSH 2.2 holds them so. Source: gmsh 4.15 reference manual,
section "MSH file format", $Entities.
"""

import io
import re
from collections.abc import Callable
from typing import Any

import numpy as np

ENTITIES = re.compile(rb"\s*\$MeshFormat\s+4\.1 (?P<is_binary>[01]) (?P<size>[48])\s.*?\$Entities\r?\n", re.DOTALL)
CORNERS = {"line": 2, "triangle": 3, "quad": 4}


def add_groups(mesh: Any, content: bytes) -> None:
    """Give meshio's mesh of a file (its content) all groups, "physical:3" where one has no name, its elements turned.

    Raises
    ------
    StopIteration, ValueError
        If the file ends within its entities.
    """
    found = ENTITIES.match(content)
    if found is None:
        return
    groups = _groups(content[found.end() :], found["is_binary"] == b"1", f"u{int(found['size'])}")
    names = {(int(dimension), int(tag)): name for name, (tag, dimension) in mesh.field_data.items()}
    for k, (block, entity) in enumerate(zip(mesh.cells, mesh.cell_data["gmsh:geometrical"], strict=True)):
        own = groups[block.dim].get(int(entity[0]), []) if len(entity) else []
        for tag in own:
            name = names.get((block.dim, abs(tag)), f"physical:{abs(tag)}")
            mesh.cell_sets.setdefault(name, [None] * len(mesh.cells))[k] = np.arange(len(block.data))
        n = next((n for kind, n in CORNERS.items() if block.type.startswith(kind)), 0)
        if own and own[0] < 0:
            block.data = np.concatenate([block.data[:, :n][:, ::-1], block.data[:, n:]], axis=1)


def _groups(content: bytes, is_binary: bool, size: str) -> list[dict[int, list[int]]]:
    """Return the groups of each entity, by its number, for points, curves, surfaces and volumes."""
    take = _binary(content) if is_binary else _words(content)
    groups: list[dict[int, list[int]]] = [{}, {}, {}, {}]
    for dimension, n in enumerate(take(size, 4)):
        for _ in range(int(n)):
            (tag,) = take("i4", 1)
            take("f8", 6 if dimension else 3)  # the box around it
            groups[dimension][int(tag)] = [int(own) for own in take("i4", int(take(size, 1)[0]))]
            if dimension:
                take("i4", int(take(size, 1)[0]))  # what bounds it
    return groups


def _binary(content: bytes) -> Callable[[str, int], list[float]]:
    stream = io.BytesIO(content)
    return lambda kind, n: np.frombuffer(stream.read(n * np.dtype(kind).itemsize), kind, n).tolist()


def _words(content: bytes) -> Callable[[str, int], list[float]]:
    words = iter(content.partition(b"$EndEntities")[0].split())
    return lambda kind, n: [float(next(words)) for _ in range(n)]
