"""Legacy .vtk files: unstructured grids, polygons and structured surfaces, in text or binary, versions 1 to 5.1.

Source: The VTK User's Guide (2010), legacy formats, and VTK 9.7's writer for OFFSETS and METADATA. meshio 5.3.5 has no
sets of SCALARS, no 64-bit numbers and no polygons; VTK's own reader takes memory that a damaged file merely promises.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.errors import InputError
from femlib.structure.file_mesh import FileMesh, value_sets

NUMBERS = {
    "unsigned_char": "u1", "char": "i1", "signed_char": "i1", "unsigned_short": "u2", "short": "i2",
    "unsigned_int": "u4", "int": "i4", "unsigned_long": "u8", "long": "i8", "float": "f4", "double": "f8",
    "vtkidtype": "i4", "vtktypeint8": "i1", "vtktypeuint8": "u1", "vtktypeint16": "i2", "vtktypeuint16": "u2",
    "vtktypeint32": "i4", "vtktypeuint32": "u4", "vtktypeint64": "i8", "vtktypeuint64": "u8",
    "vtktypefloat32": "f4", "vtktypefloat64": "f8",
}  # fmt: skip
"""numpy's kind of a number by the file's word; binary ones have the most significant byte first."""
KINDS = {1: "vertex", 2: "vertex", 3: "line", 4: "line", 5: "triangle", 8: "quad", 9: "quad"}
KINDS |= {21: "line3", 22: "triangle6", 23: "quad8", 28: "quad9", 34: "triangle7"}
"""Kind of an element by VTK's number of a cell's type."""
POLYGONS = {3: "triangle", 4: "quad"}
LISTS = {"VERTICES": 2, "LINES": 4, "POLYGONS": 7, "TRIANGLE_STRIPS": 6}
"""Type of the cells in each list of a polygon file."""
FIXED = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1, "EDGE_FLAGS": 1}
"""Numbers of a point or cell in an attribute whose line does not say how many."""
NUMBERING = ("GLOBAL_IDS", "PEDIGREE_IDS", "EDGE_FLAGS")
WORD = re.compile(rb"\S+")
Numbers = FloatArray | IntArray


def read_legacy(content: bytes, path: Path) -> FileMesh:
    """Return the mesh of a legacy .vtk file, a set for each value of a whole-numbered array on cells or points.

    Raises
    ------
    InputError
        If it is none, is cut off, or holds no unstructured grid, polygons or structured surface.
    """
    try:
        file = LegacyFile(content)
        if file.version[:4] != ["#", "vtk", "DataFile", "Version"]:
            raise ValueError("its first line is not '# vtk DataFile Version'")
        file.read()
        kinds, offsets, nodes = _cells(file)
        blocks, members = _blocks(kinds, offsets, nodes)
        told: dict[str, str] = {}
        elements: dict[str, BoolArray] = {}
        for name, values in file.arrays["CELL_DATA"].items():
            of_cell = value_sets(name, values, told)
            elements |= {key: mask[members] for key, mask in of_cell.items()}
    except (ValueError, KeyError, IndexError, OverflowError, MemoryError) as error:
        reason = f"no {error} in it" if isinstance(error, KeyError) else str(error) or type(error).__name__
        raise InputError(
            f"{path} could not be read as vtk ({reason[:120]}); expected a whole legacy VTK file; write it again"
        ) from error
    at_nodes: dict[str, BoolArray] = {}
    for name, values in file.arrays["POINT_DATA"].items():
        at_nodes |= value_sets(name, values, told)
    sets = {name: np.flatnonzero(mask) for name, mask in at_nodes.items()}
    return FileMesh(file.points, blocks, elements, sets, without_set=told)


def _cells(file: "LegacyFile") -> tuple[IntArray, IntArray, IntArray]:
    """Return type, first and last position (n_cells + 1,) and nodes of all cells."""
    if file.dimensions:
        corners = _structured(file.dimensions)
        return np.full(len(corners), 9), np.arange(0, corners.size + 1, 4), corners.ravel()
    if not file.cells:
        raise ValueError("it has no cells")
    first = np.cumsum([0, *(len(nodes) for _, _, nodes in file.cells)])
    kinds = [np.full(len(own) - 1, kind) if kind else file.types for kind, own, _ in file.cells]
    offsets = np.concatenate([[0], *(own[1:] + start for (_, own, _), start in zip(file.cells, first, strict=False))])
    found = np.concatenate([own for own in kinds if own is not None])
    nodes = np.concatenate([own for _, _, own in file.cells])
    if len(found) != len(offsets) - 1 or (np.diff(offsets) < 0).any() or offsets[-1] > len(nodes):
        raise ValueError(f"it has {len(offsets) - 1} cells and {len(found)} types of them")
    return found, offsets, nodes


def _structured(dimensions: list[int]) -> IntArray:
    """Return the corners (n, 4) of a structured grid with two directions of several nodes."""
    along = [n for n in dimensions if n > 1]
    if len(along) != 2:
        raise ValueError(f"its structured grid has {dimensions} nodes, which is no surface")
    node = np.arange(along[0] * along[1]).reshape(along[1], along[0])
    return np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], axis=-1).reshape(-1, 4)


def _blocks(kinds: IntArray, offsets: IntArray, nodes: IntArray) -> tuple[list[tuple[str, IntArray]], IntArray]:
    """Return blocks of elements of one kind and the cell that each element is (n_elements,)."""
    sizes, blocks, members = np.diff(offsets), [], [np.zeros(0, dtype=np.int64)]
    for kind, size in np.unique(np.column_stack([kinds, sizes]), axis=0).tolist():
        own = np.flatnonzero((kinds == kind) & (sizes == size))
        corners = nodes[offsets[own][:, None] + np.arange(size)]
        if kind in (2, 4) and size:  # several points or a path: an element each
            pieces = 1 if kind == 2 else 2
            corners = np.stack([corners[:, k : size - pieces + 1 + k] for k in range(pieces)], axis=-1)
            own, corners = np.repeat(own, corners.shape[1]), corners.reshape(-1, pieces)
        elif kind == 8:
            corners = corners[:, [0, 1, 3, 2]]
        name = POLYGONS.get(size, f"polygon of {size} corners") if kind == 7 else KINDS.get(kind, f"number {kind}")
        if kind:
            blocks.append((name, corners))
            members.append(own)
    return blocks, np.concatenate(members)


class LegacyFile:
    """A position in the content of a file, which moves on as it is read.

    Attributes
    ----------
    points, arrays : what was read: nodes, and arrays by "POINT_DATA" or "CELL_DATA" and name.
    cells : for each list of cells its type (None where CELL_TYPES says it), offsets and nodes.
    """

    def __init__(self, content: bytes) -> None:
        self.content, self.at = content, 0
        self.points: FloatArray = np.zeros((0, 3))
        self.cells: list[tuple[int | None, IntArray, IntArray]] = []
        self.types: IntArray | None = None
        self.dimensions: list[int] = []
        self.arrays: dict[str, dict[str, Numbers]] = {"POINT_DATA": {}, "CELL_DATA": {}, "": {}}
        self.where, self.n = "", 0
        self.version = self._line_of_text().split()
        self._line_of_text()
        self.is_binary = self._line_of_text().strip().upper() == "BINARY"

    def _line_of_text(self) -> str:
        end = self.content.find(b"\n", self.at)
        end = len(self.content) if end < 0 else end
        line, self.at = self.content[self.at : end], end + 1
        return line.decode("utf-8", errors="replace")

    def words(self) -> list[str]:
        """Return the words of the next line that has some; none at the end."""
        while self.at < len(self.content):
            words = self._line_of_text().split()
            if words:
                return words
        return []

    def numbers(self, kind: str, n: int) -> Numbers:
        """Return the next `n` numbers; ValueError if the file has fewer or other ones."""
        if kind.lower() == "string":
            return self._strings(n)
        if kind.lower() == "bit":
            return self._bits(n)
        own = np.dtype(NUMBERS[kind.lower()])
        if not self.is_binary:
            return self._text_numbers(own, n)
        end = self.at + n * own.itemsize
        if n < 0 or end > len(self.content):
            raise ValueError(f"{n} numbers of {kind} are promised, which the file does not have")
        found = np.frombuffer(self.content, own.newbyteorder(">"), n, self.at).astype(own)
        self.at = end
        return found

    def _text_numbers(self, own: np.dtype[Any], n: int) -> Numbers:
        words: list[bytes] = []
        end = self.at
        for found in WORD.finditer(self.content, self.at):
            if len(words) == n:
                break
            words.append(found[0])
            end = found.end()
        if len(words) != n:
            raise ValueError(f"{n} numbers are promised, the file ends after {len(words)}")
        self.at = end
        return np.array(words, dtype="S").astype(own) if words else np.zeros(0, dtype=own)

    def _bits(self, n: int) -> Numbers:
        if not self.is_binary:
            return self._text_numbers(np.dtype("u1"), n)
        packed = self.numbers("unsigned_char", (n + 7) // 8)
        return np.unpackbits(packed.astype(np.uint8))[:n].astype(np.int64)

    def _strings(self, n: int) -> FloatArray:
        """Pass over `n` texts: a line each, in binary with their length in the lowest bits of 1 to 8 bytes."""
        for _ in range(n):
            if not self.is_binary:
                self._line_of_text()
                continue
            width = {3: 1, 2: 2, 1: 4, 0: 8}[self.content[self.at] >> 6]
            head = int.from_bytes(self.content[self.at : self.at + width], "big")
            self.at += width + (head & ((1 << (8 * width - 2)) - 1))
        return np.full(n, np.nan)

    def read(self) -> None:
        """Read all sections; ValueError, KeyError or IndexError where one is not as the format has it."""
        while words := self.words():
            section = words[0].upper()
            if section == "METADATA":
                while self._line_of_text().strip():
                    pass
            elif section in SECTIONS:
                SECTIONS[section](self, words)
            elif section in LISTS:
                self.read_cells(words, LISTS[section])
            elif section in FIXED:
                values = self.numbers(words[2], FIXED[section] * self.n).reshape(self.n, -1)
                if section not in NUMBERING:
                    self.arrays[self.where][words[1]] = values
            else:
                raise ValueError(f"{words[0][:40]!r} is no section of the format")

    def read_cells(self, words: list[str], kind: int | None) -> None:
        """Read a list of cells: in version 5 offsets and nodes, before it the number of nodes before each cell's."""
        first, size, start = int(words[1]), int(words[2]), self.at
        if (head := self.words())[:1] == ["OFFSETS"]:
            offsets = self.numbers(head[1], first).astype(np.int64)
            nodes = self.numbers(self.words()[1], size).astype(np.int64)
            self.cells.append((kind, offsets, nodes))
            return
        self.at = start
        both, places, at = self.numbers("int", size).astype(np.int64), [], 0
        for _ in range(first):
            places.append(at)
            at += 1 + max(int(both[at]), 0)
        if at != size:
            raise ValueError(f"{words[0]} says {size} numbers, its {first} cells have {at}")
        is_node = np.ones(size, dtype=bool)
        is_node[places] = False
        offsets = np.concatenate([[0], np.cumsum(both[places])]) if places else np.zeros(1, dtype=np.int64)
        self.cells.append((kind, offsets, both[is_node]))

    def read_points(self, words: list[str]) -> None:
        """Read the nodes."""
        self.points = self.numbers(words[2], 3 * int(words[1])).reshape(-1, 3).astype(np.float64)

    def read_scalars(self, words: list[str]) -> None:
        """Read one to four numbers each; the line of their colours may be left out."""
        start = self.at
        if self.words()[:1] != ["LOOKUP_TABLE"]:
            self.at = start
        width = int(words[3]) if len(words) > 3 else 1
        self.arrays[self.where][words[1]] = self.numbers(words[2], width * self.n).reshape(self.n, width)

    def read_colours(self, words: list[str]) -> None:
        """Read colours: bytes in binary, in text their share of 255; one a cell is how VTK writes numbers of a byte."""
        is_table = words[0].upper() == "LOOKUP_TABLE"
        width, n = (4, int(words[2])) if is_table else (int(words[2]), self.n)
        values = self.numbers("unsigned_char" if self.is_binary else "double", width * n).reshape(n, width)
        if not is_table:
            self.arrays[self.where][words[1]] = np.rint(values * (1 if self.is_binary else 255)).astype(np.int64)

    def read_textures(self, words: list[str]) -> None:
        """Pass over texture coordinates."""
        self.numbers(words[3], int(words[2]) * self.n)

    def read_field(self, words: list[str]) -> None:
        """Read arrays, each with its own size; those before POINT_DATA and CELL_DATA belong to the file."""
        n_arrays = int(words[2])
        while n_arrays > 0 and (head := self.words()):
            if head[0] == "METADATA":
                while self._line_of_text().strip():
                    pass
                continue
            width, n = int(head[1]), int(head[2])
            values = self.numbers(head[3], width * n)
            if self.where and n == self.n:
                self.arrays[self.where][head[0]] = values.reshape(n, width)
            n_arrays -= 1

    def read_types(self, words: list[str]) -> None:
        """Read the types of the cells."""
        self.types = self.numbers("int", int(words[1])).astype(np.int64)

    def read_dimensions(self, words: list[str]) -> None:
        """Read the nodes along each direction of a structured grid."""
        self.dimensions = [int(word) for word in words[1:4]]

    def read_data(self, words: list[str]) -> None:
        """Note whose arrays follow, and how many there are."""
        self.where, self.n = words[0].upper(), int(words[1])

    def read_kind(self, words: list[str]) -> None:
        """Refuse a data set that is no surface."""
        if words[1].upper() not in ("UNSTRUCTURED_GRID", "POLYDATA", "STRUCTURED_GRID"):
            raise ValueError(f"its data set is {words[1]}, not UNSTRUCTURED_GRID, POLYDATA or STRUCTURED_GRID")


SECTIONS: dict[str, Callable[[LegacyFile, list[str]], None]] = {
    "DATASET": LegacyFile.read_kind,
    "POINTS": LegacyFile.read_points,
    "DIMENSIONS": LegacyFile.read_dimensions,
    "CELLS": lambda file, words: file.read_cells(words, None),
    "CELL_TYPES": LegacyFile.read_types,
    "POINT_DATA": LegacyFile.read_data,
    "CELL_DATA": LegacyFile.read_data,
    "SCALARS": LegacyFile.read_scalars,
    "COLOR_SCALARS": LegacyFile.read_colours,
    "LOOKUP_TABLE": LegacyFile.read_colours,
    "TEXTURE_COORDINATES": LegacyFile.read_textures,
    "FIELD": LegacyFile.read_field,
}
