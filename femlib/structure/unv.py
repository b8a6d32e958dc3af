"""The mesh of a universal file (.unv) of I-DEAS, NX, Salome or gmsh: nodes, shells, lines, groups.

Datasets stand between lines of -1. Read are the unit of length (164), nodes (781, 2411), elements (2412) and groups
(2435, 2452, 2467, 2477), all of numbers apart by spaces. Source: Structural Dynamics Research Corporation (1994).
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

from femlib.checked import fortran_number
from femlib.errors import InputError
from femlib.files import read_bytes
from femlib.structure.file_mesh import FileMesh, assembled, wrong_kind

NODES, ELEMENTS, GROUPS, OLD_ELEMENTS = ("781", "2411"), ("2412",), ("2435", "2452", "2467", "2477"), ("71", "780")
UNITS = "164"
KINDS = {
    **dict.fromkeys(("11", "21", "22"), "line"),
    **dict.fromkeys(("23", "24"), "line3"),
    **dict.fromkeys(("41", "51", "61", "74", "91"), "triangle"),
    **dict.fromkeys(("42", "52", "62", "72", "92"), "triangle6"),
    **dict.fromkeys(("44", "54", "64", "71", "94"), "quad"),
    **dict.fromkeys(("45", "55", "65", "75", "95"), "quad8"),
}
"""Kinds by the element's descriptor; quadratic ones name corners and middles in turn."""
LEFT_OUT = {
    **dict.fromkeys(("121", "122"), "rigid elements"),
    **dict.fromkeys(("136", "137"), "springs"),
    **dict.fromkeys(("139", "141"), "dampers"),
    "161": "masses",
}
SETS_LEFT_OUT = {"754": "constraints", "755": "supports", "790": "loads", "791": "supports", "792": "temperatures"}
BEAMS = ("11", "21", "22", "23", "24")
QUADRATIC = ("line3", "triangle6", "quad8")
WIDTHS = {"line": 2, "line3": 3, "triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8}
NODE, ELEMENT = 7, 8
"""What a member of a group is."""


def read_universal(path: Path) -> FileMesh:
    """Return the mesh of a universal file.

    Raises
    ------
    InputError
        If a line is none of its dataset's, or an element names a node that is not there.
    """
    nodes, groups = dict[int, list[float]](), dict[str, list[tuple[int, int]]]()
    elements, left_out, per_metre = dict[int, tuple[str, list[int]]](), dict[str, int](), 1.0
    for dataset, first, lines in _datasets(path):
        try:
            if dataset in NODES:
                _take_nodes(lines, nodes)
            elif dataset in ELEMENTS:
                _take_elements(lines, elements, left_out)
            elif dataset in GROUPS:
                _take_groups(lines, groups)
            elif dataset == UNITS:
                per_metre = fortran_number(lines[1].split()[0]) or 1.0
        except (ValueError, IndexError, StopIteration, RuntimeError) as error:
            raise InputError(
                f"{path} could not be read as unv (dataset {dataset} behind line {first}: {str(error)[:100]}); "
                "expected whole records; write it again"
            ) from error
        if dataset in OLD_ELEMENTS:
            raise InputError(f"{path} has elements in dataset {dataset}; expected 2412; write it by a newer I-DEAS")
        if dataset in SETS_LEFT_OUT:
            left_out[SETS_LEFT_OUT[dataset]] = left_out.get(SETS_LEFT_OUT[dataset], 0) + 1
    odd = [kind for kind, _ in elements.values() if kind not in WIDTHS]
    if odd:
        raise wrong_kind(str(path), odd.count(odd[0]), odd[0])
    members = {name: [n for what, n in own if what == ELEMENT and n in elements] for name, own in groups.items()}
    alone = {name: [n for what, n in own if what == NODE and n in nodes] for name, own in groups.items()}
    alone = {name: own for name, own in alone.items() if own and not members[name]}
    found = assembled(path, nodes, elements, alone, {name: own for name, own in members.items() if own})
    found.left_out, found.metres = left_out, 1.0 / per_metre
    return found


def _datasets(path: Path) -> Iterator[tuple[str, int, list[str]]]:
    """Yield the number of each dataset, the line of its number, and its lines."""
    lines = read_bytes(path, "a mesh file").decode("latin-1").splitlines()
    marks = [k for k, line in enumerate(lines) if line[:6].strip() == "-1" and line.strip() == "-1"]
    if len(marks) % 2:
        raise InputError(
            f"{path} has {len(marks)} lines of -1; expected two about each dataset; was it cut? write it again"
        )
    for start, end in zip(marks[::2], marks[1::2], strict=True):
        yield "".join(lines[start + 1 : start + 2]).strip(), start + 2, lines[start + 2 : end]


def _take_nodes(lines: Sequence[str], nodes: dict[int, list[float]]) -> None:
    for head, places in zip(lines[::2], lines[1::2], strict=True):
        numbers = [fortran_number(word) for word in places.split()]
        if len(numbers) != 3:
            raise ValueError(f"a node has {len(numbers)} coordinates")
        nodes[int(head.split()[0])] = numbers


def _take_elements(lines: Sequence[str], elements: dict[int, tuple[str, list[int]]], left_out: dict[str, int]) -> None:
    rows = iter(lines)
    for head in rows:
        number, descriptor, *_, n_nodes = head.split()[:6]
        if descriptor in BEAMS:
            next(rows)  # its orientation and cross-sections
        corners: list[int] = []
        while len(corners) < int(n_nodes):
            corners += [int(word) for word in next(rows).split()]
        if descriptor in LEFT_OUT:
            left_out[LEFT_OUT[descriptor]] = left_out.get(LEFT_OUT[descriptor], 0) + 1
            continue
        kind = KINDS.get(descriptor, f"descriptor {descriptor}")
        if len(corners) != WIDTHS.get(kind, len(corners)):
            raise ValueError(f"element {number} has {len(corners)} nodes, a {kind} {WIDTHS[kind]}")
        elements[int(number)] = (kind, corners[::2] + corners[1::2] if kind in QUADRATIC else corners)


def _take_groups(lines: Sequence[str], groups: dict[str, list[tuple[int, int]]]) -> None:
    rows = iter(lines)
    for head in rows:
        number, n_members = int(head.split()[0]), int(head.split()[7])
        own, numbers = groups.setdefault(next(rows).strip() or f"group:{number}", []), list[int]()
        while len(numbers) < 4 * n_members:
            numbers += [int(word) for word in next(rows).split()]
        own += zip(numbers[::4], numbers[1::4], strict=True)
