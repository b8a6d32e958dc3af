"""The mesh of a Nastran bulk data file: nodes in any coordinate system, shells, lines, sets of properties and supports.

Material, thickness and section belong to `Structure`, so that PSHELL, PCOMP and MAT1 are not read. What else changes
the structure is counted and said.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.checked import fortran_number, reason_of
from femlib.errors import InputError
from femlib.structure.file_mesh import FileMesh, assembled, wrong_kind
from femlib.structure.nastran_cards import Card, cards_of

SHELLS = {
    "CQUAD4": ("quad", range(4, 8), (8, 9), range(14, 18)),
    "CQUADR": ("quad", range(4, 8), (8, 9), range(14, 18)),
    "CTRIA3": ("triangle", range(4, 7), (7, 8), range(14, 17)),
    "CTRIAR": ("triangle", range(4, 7), (7, 8), range(14, 17)),
    "CQUAD8": ("quad8", (*range(4, 10), 12, 13), (18, 19), range(14, 18)),
    "CQUAD9": ("quad9", (*range(4, 10), 12, 13, 14), (18, 19), ()),  # gmsh's name
    "CTRIA6": ("triangle6", range(4, 10), (12, 13), range(14, 17)),
    "CQUAD4K": ("quad", range(4, 8), (8, 9), ()),  # MYSTRAN's plates of Kirchhoff
    "CTRIA3K": ("triangle", range(4, 7), (7, 8), ()),
}
"""Kind and the fields of nodes, of the material's direction and the offset, and of the thickness at corners."""
LINES = {
    "CBAR": ("line", (4, 5)), "CBEAM": ("line", (4, 5)), "CBEND": ("line", (4, 5)), "CROD": ("line", (4, 5)),
    "CTUBE": ("line", (4, 5)), "CONROD": ("line", (3, 4)), "CBEAM3": ("line3", (4, 5, 6)),
}  # fmt: skip
LEFT_OUT = {
    r"CONM[12]": ("masses", range(3, 4)), r"CMASS[12]": ("masses", (4, 6)), r"CMASS[34]|NSM.*": ("masses", ()),
    r"CELAS[12]": ("springs", (4, 6)), r"CELAS[34]": ("springs", ()), r"CBUSH(1D|2D)?": ("springs", (4, 5)),
    r"CGAP|CFAST|CWELD|CSEAM|CINTC": ("joints", ()), r"CDAMP\d|CVISC": ("dampers", ()),
    r"RBE1|RBE2(GS)?|RBE3|RBAR1?|RROD|RSPLINE|RSSCON|RTRPLT1?|RJOINT": ("rigid elements", ()),
    r"MPC|MPCADD|MPCY|BGSET|BCTSET|BCTPARA": ("constraints", ()),
    r"SPC": ("supports", (3, 6)), r"SPC1": ("supports", range(4, 400)), r"SPCADD|SUPORT1?|BNDFIX1?": ("supports", ()),
    r"FORCE|MOMENT": ("loads", (3,)),
    r"FORCE[12]|MOMENT[12]|PLOAD[1-4]?|LOAD|GRAV|ACCEL1?|RFORCE1?|TEMP(D|P1|RB|BC)?|DEFORM": ("loads", ()),
    r"SPCD|SLOAD|DAREA|[TR]LOAD[12]|DLOAD|LSEQ|PRESAX": ("loads", ()),
}  # fmt: skip
"""What is no part of a mesh and changes the structure, and the fields of nodes that its set names."""
SILENT = re.compile(
    r"MAT.*|P(SHELL|COMP.*|BAR.*|BEAM.*|ROD|TUBE|BEND|BUSH.*|ELAST?|MASS|SOLID|LSOLID|SHEAR|DAMP.*|GAP|FAST|WELD|VISC|PLANE)"
    r"|PARAM|MDLPRM|CORD.*|GRID|GRDSET|EIG.*|SET\d|D(ESVAR|V[PCM]REL\d|RESP\d|CONSTR|CONADD|OPTPRM|EQATN|TABLE|LINK|VGRID)"
    r"|TABLE.*|TABD.*|FREQ\d?|TSTEP.*|NLPARM.*|PLOTEL|[SE]POINT|[AOQCBU]SET\d?|AE.*|CAERO.*|PAERO.*|SPLINE.*|FLFACT|FLUTTER"
    r"|MK?AERO\d|TRIM|DOPTPRM|ECHO.*"
)
"""Cards that leave the mesh as it is, and its material and sections to `Structure`."""
REFUSED = re.compile(r"C(HEXA|TETRA|PENTA|PYRAM|IHEX|TRIAX|QUADX|SHEAR|QUAD$|CONEAX|PLST|PLSN|HAC|RAC|AX).*")
"""Elements that are no shells and no lines."""
BESIDE = {"PSHELL": 16, "PCOMPP": 3}
"""Properties of OptiStruct that may move shells off their nodes, and the field that says it."""
DEFAULTS = ("BAROR", "BEAMOR")
"""Cards that hold for others before them too."""
SYSTEM = r"CORD[12][RCS]"
"""Coordinate systems that nodes may stand in."""
FARTHEST = 1e12
"""Coordinate in the file's unit, at most."""
DEEPEST = 100
"""Coordinate systems that are defined in each other, at most."""


def read_bulk(path: Path) -> FileMesh:
    """Return the mesh of a bulk data file, with or without BEGIN BULK and ENDDATA.

    Raises
    ------
    InputError
        If a field is none of its card's, a number is there twice with other values, or a node or system is not there.
    """
    bulk, names, is_rounded = _taken(path)
    if is_rounded:
        bulk.say("last digits of nodes (gmsh rounds them; set its Mesh.BdfFieldFormat to 2)", len(bulk.grids))
    return bulk.mesh(names)


def shell_numbers(path: str | Path) -> dict[int, int]:
    """Return the number of each shell in the mesh that `femlib.read` makes of a bulk data file, by the file's number.

    Raises
    ------
    InputError
        As `femlib.read`.
    """
    elements = _taken(Path(path))[0].elements
    found = [[number for number, (kind, _, _) in elements.items() if kind.startswith(its)] for its in ("quad", "tri")]
    kinds = dict.fromkeys(kind for kind, _, _ in elements.values())
    if {"quad8", "quad9", "triangle6"} & kinds.keys():
        raise InputError(f"{path} has shells with nodes between corners; expected linear ones; write CQUAD4 and CTRIA3")
    return {number: k for k, number in enumerate((*found[0], *found[1]))}


def _taken(path: Path) -> "tuple[Bulk, dict[int, str], bool]":
    """Return what the cards of a file say, the names of its properties, and whether gmsh rounded its nodes."""
    cards, names, is_rounded = cards_of(path)
    bulk = Bulk(path)
    for card in sorted(cards, key=lambda own: own.name not in DEFAULTS):
        try:
            bulk.take(card)
        except (ValueError, IndexError, OverflowError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"{path} could not be read as nastran (card {card.name[:8]} {card.text(2)[:16]}: "
                f"{reason_of(error)[:100]}); expected whole bulk data; write it again"
            ) from error
    return bulk, names, is_rounded


class Bulk:
    """What the cards of a file say, by number."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.grids: dict[int, tuple[int | None, tuple[float, float, float]]] = {}
        self.systems: dict[int, Card] = {}
        self.elements: dict[int, tuple[str, tuple[int, ...], int]] = {}
        self.node_sets: dict[str, list[int]] = {}
        self.left_out: dict[str, int] = {}
        self.default_system = 0
        self.default_property: dict[str, int] = {}

    def say(self, what: str, n: int = 1) -> None:
        """Count something that is left out."""
        self.left_out[what] = self.left_out.get(what, 0) + n

    def take(self, card: Card) -> None:
        """Take the next card."""
        if card.name == "GRID":
            self._grid(card)
        elif card.name == "GRDSET":
            self.default_system = card.whole(3)
            self._held(card)
        elif card.name.startswith("CORD"):
            self._systems(card)
        elif card.name in DEFAULTS:
            self.default_property[f"C{card.name[:-2]}"] = card.whole(3)
        elif card.name in SHELLS:
            self._shell(card)
        elif card.name in LINES:
            self._line(card)
        elif card.name in ("PCOMP", "PCOMPG"):
            self._stack(card)
        elif (place := BESIDE.get(card.name, 0)) and _is_beside(card.text(place)):
            self.say(f"{'Z0' if place == 3 else 'ZOFFS'} of {card.name} (shells beside their nodes)")
        elif card.name.startswith(("=", "BEGIN")):
            what = "fields that repeat the line before" if card.name[0] == "=" else "superelements"
            raise InputError(
                f"{self.path} has {what} ({card.name[:12]}); expected one plain model; write all its cards"
            )
        elif REFUSED.fullmatch(card.name):
            raise wrong_kind(str(self.path), 1, card.name)
        elif not SILENT.fullmatch(card.name):
            self._other(card)

    def _grid(self, card: Card) -> None:
        word = card.text(3)
        place = (card.real(4), card.real(5), card.real(6))
        own = (int(word) if word else None, place)
        if not all(abs(value) < FARTHEST for value in place):
            raise ValueError(f"{max(place, key=abs)} is no coordinate")
        if self.grids.setdefault(card.whole(2), own) != own:
            raise ValueError("it is there twice, at two places")
        self._held(card)

    def _held(self, card: Card) -> None:
        if card.text(8) not in ("", "0"):
            self.say("PS of GRID (supports)")

    def _systems(self, card: Card) -> None:
        if not re.fullmatch(SYSTEM, card.name):  # of materials; a node in one is refused
            self.systems[card.whole(2)] = card
            return
        numbers = [card.real(k) for k in (3, 4, 5, 6, 7, 8, 9, 12, 13, 14)]
        if not all(abs(value) < FARTHEST for value in numbers):
            raise ValueError(f"{max(numbers, key=abs)} is no coordinate")
        self.systems[card.whole(2)] = card
        if card.name.startswith("CORD1") and card.text(6):  # two of them in one line
            self.systems[card.whole(6)] = Card(card.name, card.fields[4:])

    def _element(self, card: Card, kind: str, nodes: Sequence[int], place: int) -> None:
        number = card.whole(2)
        default = self.default_property.get(card.name) or number
        own = (kind, tuple(nodes), card.whole(place, default) if place else 0)
        if self.elements.setdefault(number, own) != own:
            raise ValueError("it is there twice, with other nodes or properties")

    def _shell(self, card: Card) -> None:
        kind, fields, (turn, offset), thick = SHELLS[card.name]
        self._element(card, kind, [card.whole(k) for k in fields], 3)
        if card.text(turn) and ("." not in card.text(turn) or card.real(turn)):
            self.say("THETA or MCID (directions of the material)")
        if _is_beside(card.text(offset)):
            self.say("ZOFFS (shells beside their nodes)")
        if any(card.text(k) for k in thick):
            self.say("T1 to T4 (thickness at corners)")

    def _stack(self, card: Card) -> None:
        """Say that plies lie beside their nodes: their bottom Z0 is not half the thickness below them."""
        if not card.text(3):
            return
        first = 1 if card.name == "PCOMP" else 2  # material, thickness, ...; a number of the ply before them
        last, total = 0.0, 0.0
        for start in range(8, len(card.fields), 4 if first == 1 else 8):
            if any(card.fields[start : start + 4]):  # a ply with an angle alone is one too
                word = card.fields[start + first]
                last = fortran_number(word) if word else last
                total += last
        total *= 2.0 if card.text(9).upper().startswith("SY") and first == 1 else 1.0  # SYM, SYMEM, SYBEND, SYSMEAR
        if abs(card.real(3) + total / 2.0) > 1e-6 * total:
            self.say(f"Z0 of {card.name} (plies beside their nodes)")

    def _line(self, card: Card) -> None:
        kind, fields = LINES[card.name]
        self._element(card, kind, [card.whole(k) for k in fields], 0 if card.name == "CONROD" else 3)
        if card.name in ("CBAR", "CBEAM"):
            if any(card.real(k) for k in range(14, 20)):
                self.say(f"W1A to W3B of {card.name} (beams beside their nodes)")
            if card.text(12).strip("0") or card.text(13).strip("0"):
                self.say(f"PA, PB of {card.name} (released ends)")

    def _other(self, card: Card) -> None:
        if not card.name.isalnum():
            raise ValueError("no name of a card, which ends at the first comma or stands in eight columns")
        every = (own for names, own in LEFT_OUT.items() if re.fullmatch(names, card.name))
        what, fields = next(every, ("not read", ()))
        self.say(f"{card.name[:8]} ({what})")
        nodes = _numbers([card.text(k) for k in fields if k - 2 < 10 * len(card.fields)])
        if nodes:
            name = "SPC" if what == "supports" else card.name
            self.node_sets.setdefault(f"{name}:{card.text(2)}", []).extend(nodes)

    def mesh(self, names: dict[int, str]) -> FileMesh:
        """Return the mesh, elements in blocks of a kind, a set for each property."""
        sets: dict[str, list[int]] = {}
        for number, (_, _, ref) in self.elements.items():
            for name in (f"property:{ref}", names.get(ref, "")) if ref else ():
                if name:
                    sets.setdefault(name, []).append(number)
        nodes = dict(zip(self.grids, self._points().tolist(), strict=True))
        elements = {number: own[:2] for number, own in self.elements.items()}
        found = assembled(self.path, nodes, elements, self.node_sets, sets)
        found.left_out = self.left_out
        return found

    def _points(self) -> FloatArray:
        """Return the nodes (n, 3) in global axes."""
        points = np.array([place for _, place in self.grids.values()], dtype=np.float64).reshape(-1, 3)
        used = np.array([self.default_system if own is None else own for own, _ in self.grids.values()])
        for system in np.unique(used).tolist():
            if system:
                points[used == system] = self._placed(system, points[used == system], DEEPEST)
        return points

    def _placed(self, system: int, places: FloatArray, depth: int) -> FloatArray:
        """Return places (n, 3) of a coordinate system in global axes."""
        if not system:
            return places
        if system not in self.systems or not depth:
            raise InputError(
                f"{self.path} has nodes in the coordinate system {system}, which "
                f"{'is not in it' if depth else 'is defined by itself'}; expected a CORD card; write the whole file"
            )
        card = self.systems[system]
        if not re.fullmatch(SYSTEM, card.name):
            raise InputError(
                f"{self.path} has nodes in a system {card.name}; expected CORD1 or CORD2, R, C or S; write them so"
            )
        if card.name[4] == "1":
            numbers = [card.whole(k) for k in (3, 4, 5)]
            a, b, c = (self._placed_node(number, depth - 1) for number in numbers)
        else:
            three = np.array([[card.real(k) for k in row] for row in ((4, 5, 6), (7, 8, 9), (12, 13, 14))])
            a, b, c = self._placed(card.whole(3), three, depth - 1)
        return a + _cartesian(card.name[5], places) @ _axes(a, b, c, f"{self.path}: {card.name} {system}")

    def _placed_node(self, number: int, depth: int) -> FloatArray:
        if number not in self.grids:
            raise InputError(f"{self.path} has a CORD1 card at node {number}, which is not in it; expected its GRID")
        own, place = self.grids[number]
        system = self.default_system if own is None else own
        return np.asarray(self._placed(system, np.array([place]), depth)[0])


def _is_beside(word: str) -> bool:
    """Whether an offset is one: a number that is not zero, or OptiStruct's TOP and BOTTOM."""
    return bool(word.upper().strip("+-0.ED"))


def _axes(a: FloatArray, b: FloatArray, c: FloatArray, where: str) -> FloatArray:
    """Return the axes (3, 3), a row each, with z from a to b and c in the plane of x and z."""
    z = b - a
    y = np.cross(z, c - a)
    if not np.linalg.norm(y) > 0.0:
        raise InputError(f"{where} has three points on one line; expected a plane; correct the card")
    axes = np.array([np.cross(y, z), y, z])
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def _cartesian(kind: str, places: FloatArray) -> FloatArray:
    """Return places (n, 3) of a system: R: x, y, z; C: r, theta, z; S: r, theta, phi."""
    if kind == "R":
        return places
    turn = np.radians(places[:, 1:])
    if kind == "C":
        along = [places[:, 0] * np.cos(turn[:, 0]), places[:, 0] * np.sin(turn[:, 0]), places[:, 2]]
    else:
        out = places[:, 0] * np.sin(turn[:, 0])
        along = [out * np.cos(turn[:, 1]), out * np.sin(turn[:, 1]), places[:, 0] * np.cos(turn[:, 0])]
    return np.column_stack(along)


def _numbers(words: Sequence[str]) -> list[int]:
    """Return the numbers of a list with THRU and BY."""
    own = [word.upper() for word in words if word]
    found: list[int] = []
    k = 0
    while k < len(own):
        if own[k] == "THRU" and found and k + 1 < len(own):
            step = int(own[k + 3]) if own[k + 2 : k + 3] == ["BY"] else 1
            last, first = int(own[k + 1]), found[-1]
            if not 0 <= last - first <= 10_000_000 * max(step, 1):
                raise ValueError(f"{first} THRU {last}; expected growing numbers")
            found += range(first + step, last + 1, step)
            k += 4 if own[k + 2 : k + 3] == ["BY"] else 2
        else:
            found.append(int(own[k]))
            k += 1
    return found
