"""The mesh of an Abaqus or CalculiX deck: nodes, shells, lines and sets, of a flat deck or of parts and instances.

meshio 5.3.5 turns its shells into other kinds, keeps the last of several *NODE cards, and mixes sets up. Names are the
same in capitals or not, as in both programs, and are kept as the deck first writes them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.checked import fortran_number
from femlib.errors import InputError
from femlib.structure.abaqus_cards import MIDDLE, WIDTHS, Card, cards_of, kind_of
from femlib.structure.file_mesh import FileMesh, masks, wrong_kind

MAKERS = ("NCOPY", "NFILL", "NMAP", "ELCOPY", "SYSTEM", "SUBSTRUCTURE GENERATE")
"""Cards that make or move nodes and elements, and are not read."""
LEFT_OUT = {
    "BOUNDARY": "supports", "CLOAD": "loads", "DLOAD": "loads", "DSLOAD": "loads", "TEMPERATURE": "loads",
    "EQUATION": "constraints", "MPC": "constraints", "COUPLING": "constraints", "KINEMATIC COUPLING": "constraints",
    "DISTRIBUTING COUPLING": "constraints", "RIGID BODY": "constraints", "TIE": "constraints",
    "CONTACT PAIR": "contact", "CYCLIC SYMMETRY MODEL": "constraints", "EMBEDDED ELEMENT": "constraints",
    "SHELL TO SOLID COUPLING": "constraints",
    "NONSTRUCTURAL MASS": "masses", "FOUNDATION": "springs", "PRE-TENSION SECTION": "loads",
}  # fmt: skip
"""Cards that change the structure and are no part of a mesh."""
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


def read_deck(path: Path) -> FileMesh:
    """Return the mesh of a deck.

    Raises
    ------
    InputError
        If a card is not as the format has it, generates by a rule that is not read, or names what is not there.
    """
    left_out: dict[str, int] = {}
    deck = Deck(path, left_out)
    for card in cards_of(path):
        try:
            deck.take(card)
        except (ValueError, IndexError, KeyError, OverflowError) as error:
            if isinstance(error, InputError):
                raise
            reason = f"{error} is not in the deck before it" if isinstance(error, KeyError) else str(error)
            raise InputError(
                f"{path} could not be read as abaqus (card *{card.keyword}: {reason[:120]}); expected a whole deck; "
                "write it again"
            ) from error
    return _mesh_of(deck.part, left_out)


class Deck:
    """The cards of a deck, taken one after another.

    Attributes
    ----------
    part : Part
        The whole: the flat deck, or all instances, their numbers moved so that they differ.
    """

    def __init__(self, path: Path, left_out: dict[str, int]) -> None:
        self.path, self.left_out = path, left_out
        self.part = self.own = Part()
        self.parts: dict[str, Part] = {}
        self.first: dict[str, tuple[str, int]] = {}  # of an instance: its part, and what is added to its numbers
        self.instance: Card | None = None

    def take(self, card: Card) -> None:
        """Take the next card."""
        name = card.options.get("NAME", "")
        if card.keyword in MAKERS:
            raise InputError(
                f"{self.path} has a card *{card.keyword}, which is not read; expected nodes and elements as they lie; "
                "write them out in the mesh program"
            )
        if card.keyword == "PART":
            self.own = self.parts[name.upper()] = Part()
        elif card.keyword in ("END PART", "ASSEMBLY"):
            self.own = self.part
        elif card.keyword == "INSTANCE":
            self.instance, self.own = card, Part()
        elif card.keyword == "END INSTANCE":
            self._place()
        elif card.keyword in TAKEN:
            TAKEN[card.keyword](self, card)
        elif card.keyword in LEFT_OUT:
            self._say(f"*{card.keyword} ({LEFT_OUT[card.keyword]})", max(len(card.rows), 1))

    def _place(self) -> None:
        """Add the instance that ends here, its own nodes and elements after its part's."""
        assert self.instance is not None
        options = self.instance.options
        part = _joined(self.parts[options["PART"].upper()] if "PART" in options else Part(), self.own)
        move = _motion(self.instance.rows)
        numbers = [0, *self.part.nodes, *self.part.elements]
        by = max(numbers) if self.part.nodes else 0
        self.part.nodes |= {by + k: tuple(move(place)) for k, place in part.nodes.items()}
        for number, (kind, nodes) in part.elements.items():
            self.part.elements[by + number] = (kind, tuple(by + n for n in nodes))
        for kind, sets in part.sets.items():
            for name, members in sets.items():
                several = sum(own == options.get("PART", "").upper() for own, _ in self.first.values()) > 0
                own = f"{options['NAME']}.{name}" if several or self._name(kind, name) in self.part.sets[kind] else name
                _extend(self.part.sets[kind], own, [by + n for n in members])
        self.first[options["NAME"].upper()] = (options.get("PART", "").upper(), by)
        self.own, self.instance = self.part, None

    def _name(self, kind: str, name: str) -> str:
        """Return a set's name as the deck first wrote it."""
        return next((own for own in self.own.sets[kind] if own.upper() == name.upper()), name)

    def _add(self, kind: str, name: str | None, members: Sequence[int]) -> None:
        if name:
            _extend(self.own.sets[kind], self._name(kind, name), members)

    def _nodes(self, card: Card) -> None:
        if card.options.get("SYSTEM", "R").upper() != "R":
            raise InputError(f"{self.path} has nodes in cylindrical or spherical axes; expected x, y, z; write them so")
        for row in card.rows:
            place = [fortran_number(word) if word else 0.0 for word in (*row[1:4], "", "", "")[:3]]
            self.own.nodes[int(row[0])] = tuple(place)
        self._add("NSET", card.options.get("NSET"), [int(row[0]) for row in card.rows])

    def _nodes_between(self, card: Card) -> None:
        """Add nodes on a straight line between two: *NGEN."""
        if card.options.get("LINE", "") not in ("", "S", "s"):
            raise InputError(f"{self.path} has nodes on a curve by *NGEN; expected a straight line; write them out")
        for row in card.rows:
            first, last, step = int(row[0]), int(row[1]), int(row[2]) if len(row) > 2 and row[2] else 1
            numbers = _counted(first, last, step)
            ends = np.array([self.own.nodes[first], self.own.nodes[last]])
            for k, number in enumerate(numbers):
                self.own.nodes[number] = tuple((ends[0] + k / max(len(numbers) - 1, 1) * (ends[1] - ends[0])).tolist())
            self._add("NSET", card.options.get("NSET"), numbers)

    def _elements(self, card: Card) -> None:
        own = card.options["TYPE"]
        kind, said = kind_of(own)
        if said:
            self._left_out(card, said)
            return
        if not kind:
            raise wrong_kind(str(self.path), len(card.rows), own)
        numbers = []
        for number, nodes in _element_rows(card.rows, WIDTHS[kind]):
            if number in self.own.elements:
                raise ValueError(f"element {number} is there twice")
            self.own.elements[number] = (kind, nodes)
            numbers.append(number)
        self._add("ELSET", card.options.get("ELSET"), numbers)

    def _left_out(self, card: Card, what: str) -> None:
        """Count elements that are no part of a mesh; their nodes are a node set of their name."""
        self._say(f"{card.options['TYPE'].upper()} ({what})", len(card.rows))
        nodes = [int(word) for row in card.rows for word in row[1:] if word]
        self._add("NSET", card.options.get("ELSET"), nodes)
        for row in card.rows:
            self.own.elements[int(row[0])] = ("", tuple(int(word) for word in row[1:] if word))
        self._add("ELSET", card.options.get("ELSET"), [int(row[0]) for row in card.rows])

    def _elements_again(self, card: Card) -> None:
        """Add elements that repeat one along a row, in rows and in layers: *ELGEN."""
        for row in card.rows:
            words = [int(word) if word else 1 for word in row]
            kind, nodes = self.own.elements[words[0]]
            found = [(words[0], nodes)]
            for n, step, jump in zip(*(iter(words[1:]),) * 3, strict=False):
                if n * len(found) > MOST_GENERATED:
                    raise ValueError(f"{n * len(found)} elements are generated; expected {MOST_GENERATED} at most")
                found = [(e + k * jump, tuple(a + k * step for a in own)) for k in range(n) for e, own in found]
            self.own.elements |= {number: (kind, own) for number, own in found}
            self._add("ELSET", card.options.get("ELSET"), [number for number, _ in found])

    def _set(self, card: Card) -> None:
        kind, options = card.keyword, card.options
        name = options[kind]
        sets, known = self.own.sets[kind], self.own.nodes if kind == "NSET" else self.own.elements
        by = self.first[options["INSTANCE"].upper()][1] if "INSTANCE" in options else 0
        members: list[int] = []
        if kind == "NSET" and "ELSET" in options:
            of = self.own.sets["ELSET"][self._name("ELSET", options["ELSET"])]
            members = [node for element in of for node in self.own.elements[element][1]]
        elif "GENERATE" in options:
            for row in card.rows:
                words = [by + int(row[0]), by + int(row[1] if len(row) > 1 and row[1] else row[0])]
                step = int(row[2]) if len(row) > 2 and row[2] else 1
                members += [number for number in _counted(*words, step) if number in known]
        else:
            for word in (word for row in card.rows for word in row if word):
                members += self._named(word, kind, by, sets, known, name)
        self._add(kind, name, members)

    def _named(
        self, word: str, kind: str, by: int, sets: Mapping[str, list[int]], known: Mapping[int, object], name: str
    ) -> list[int]:
        """Return what a word of a set names: a number, one of an instance, or another set."""
        instance, dot, rest = word.partition(".")
        if dot and instance.upper() in self.first:
            by, word = self.first[instance.upper()][1], rest
        if word.lstrip("-").isdigit() and by + int(word) in known:
            return [by + int(word)]
        if self._name(kind, word) in sets:
            return sets[self._name(kind, word)]
        raise InputError(
            f"{self.path}, set {name!r} names {word!r}, which is not in the deck before it; expected it; "
            "correct the set"
        )

    def _section(self, card: Card) -> None:
        """Note what of a shell's section moves it off its nodes, or turns its material."""
        offset = card.options.get("OFFSET", "0")
        if offset.upper() not in ("MIDDLE SURFACE", "MID") and offset.strip("+-0.eE"):
            self._say("OFFSET of *SHELL SECTION (shells beside their nodes)")
        if "ORIENTATION" in card.options:
            self._say("ORIENTATION of *SHELL SECTION (directions of the material)")

    def _say(self, what: str, n: int = 1) -> None:
        self.left_out[what] = self.left_out.get(what, 0) + n


TAKEN: dict[str, Callable[[Deck, Card], None]] = {
    "NODE": Deck._nodes,
    "NGEN": Deck._nodes_between,
    "ELEMENT": Deck._elements,
    "ELGEN": Deck._elements_again,
    "NSET": Deck._set,
    "ELSET": Deck._set,
    "SHELL SECTION": Deck._section,
}


def _extend(sets: dict[str, list[int]], name: str, members: Sequence[int]) -> None:
    sets.setdefault(name, []).extend(members)


def _joined(first: Part, second: Part) -> Part:
    """Return both parts as one."""
    sets = {kind: first.sets[kind] | second.sets[kind] for kind in first.sets}
    return Part(first.nodes | second.nodes, first.elements | second.elements, sets)


def _counted(first: int, last: int, step: int) -> list[int]:
    """Return the numbers from `first` to `last`."""
    if step == 0 or abs(last - first) // abs(step) > MOST_GENERATED:
        raise ValueError(f"{first} to {last} by {step}; expected at most {MOST_GENERATED} numbers")
    return list(range(first, last + (1 if step > 0 else -1), step))


def _motion(rows: Sequence[Sequence[str]]) -> Callable[[tuple[float, ...]], FloatArray]:
    """Return what moves a place as an instance says: a shift, then a turn [deg] about the line through two points."""
    numbers = [[fortran_number(word) if word else 0.0 for word in row] for row in rows]
    shift = np.array((numbers[0] + [0.0] * 3)[:3] if numbers else [0.0] * 3)
    if len(numbers) < 2:
        return lambda place: np.array(place) + shift
    start, end, angle = np.array(numbers[1][:3]), np.array(numbers[1][3:6]), np.radians(numbers[1][6])
    axis = (end - start) / np.linalg.norm(end - start)
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return lambda place: start + turn @ (np.array(place) + shift - start)


def _element_rows(rows: Sequence[Sequence[str]], width: int) -> Iterator[tuple[int, tuple[int, ...]]]:
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


def _mesh_of(part: Part, left_out: dict[str, int]) -> FileMesh:
    """Return the mesh of the whole, elements in blocks of a kind."""
    place = {number: k for k, number in enumerate(part.nodes)}
    kinds = list(dict.fromkeys(kind for kind, _ in part.elements.values() if kind))
    position: dict[int, int] = {}
    blocks = []
    for kind in kinds:
        own = {number: nodes for number, (its, nodes) in part.elements.items() if its == kind}
        position |= {number: len(position) + k for k, number in enumerate(own)}
        order = MIDDLE.get(kind)
        rows = [[place[n] for n in (nodes if order is None else [nodes[k] for k in order])] for nodes in own.values()]
        blocks.append((kind, np.array(rows, dtype=np.int64)))
    elements = {}
    for name, members in part.sets["ELSET"].items():
        known = [position[n] for n in members if n in position]
        if known or not members:
            elements[name] = known
    nodes = {
        name: np.array(list(dict.fromkeys(place[n] for n in own)), dtype=np.int64)
        for name, own in part.sets["NSET"].items()
    }
    points = np.array(list(part.nodes.values()), dtype=np.float64).reshape(-1, 3)
    return FileMesh(points, blocks, dict(masks(elements, len(position))), nodes, left_out)
