"""The mesh of an Abaqus or CalculiX deck: nodes, shells, lines and sets, of a flat deck or of parts and instances.

meshio 5.3.5 turns its shells into other kinds, keeps the last of several *NODE cards, and mixes sets up. Names are the
same in capitals or not, as in both programs, and are kept as the deck first writes them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from femlib.checked import fortran_number, reason_of
from femlib.errors import InputError
from femlib.structure.abaqus_cards import MIDDLE, WIDTHS, Card, cards_of, kind_of
from femlib.structure.abaqus_part import (
    FARTHEST,
    MOST_GENERATED,
    Part,
    counted,
    element_rows,
    extend,
    joined,
    mesh_of,
    motion,
)
from femlib.structure.file_mesh import FileMesh, wrong_kind

BEHIND_ASSEMBLY = 10**9
"""What is added to the numbers of instances at least: those of the assembly's own nodes and elements are below it."""
MAKERS = ("NCOPY", "NFILL", "NMAP", "ELCOPY", "SYSTEM", "SUBSTRUCTURE GENERATE")
"""Cards that make or move nodes and elements, and are not read."""
LEFT_OUT = {
    "BOUNDARY": "supports", "CLOAD": "loads", "DLOAD": "loads", "DSLOAD": "loads", "TEMPERATURE": "loads",
    "EQUATION": "constraints", "MPC": "constraints", "COUPLING": "constraints", "KINEMATIC COUPLING": "constraints",
    "DISTRIBUTING COUPLING": "constraints", "RIGID BODY": "constraints", "TIE": "constraints",
    "CONTACT PAIR": "contact", "CYCLIC SYMMETRY MODEL": "constraints", "EMBEDDED ELEMENT": "constraints",
    "SHELL TO SOLID COUPLING": "constraints",
    "NONSTRUCTURAL MASS": "masses", "FOUNDATION": "springs", "PRE-TENSION SECTION": "loads",
    "RELEASE": "released ends", "BEAM SECTION OFFSET": "beams beside their nodes", "FASTENER": "joints",
    "IMPERFECTION": "nodes beside their places", "MODEL CHANGE": "elements that come and go", "CONTACT": "contact",
    "INITIAL CONDITIONS": "loads", "ADJUST": "nodes beside their places",
}  # fmt: skip
"""Cards that change the structure and are no part of a mesh."""


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
        with _told(path, card):
            deck.take(card)
    return mesh_of(path, deck.whole(), left_out)


@contextmanager
def _told(path: Path, card: Card) -> Iterator[None]:
    """Name the card whose data cannot be taken."""
    try:
        yield
    except (ValueError, IndexError, KeyError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        reason = f"{error} is not in the deck before it" if isinstance(error, KeyError) else reason_of(error)
        raise InputError(
            f"{path} could not be read as abaqus (card *{card.keyword}: {reason[:120]}); expected a whole deck; write "
            "it again"
        ) from error


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
        self.first: dict[str, int] = {}  # of an instance: what is added to its numbers
        self.instance: Card | None = None
        self.is_by_meshio = False
        self.waiting: list[Card] = []  # sets of the part, which may name what comes behind them
        self.of_parts: dict[
            tuple[str, str], list[tuple[str, str, list[int]]]
        ] = {}  # their sets: instance, part, members

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
            self._fill()
            self.own = self.part
        elif card.keyword == "INSTANCE":
            self._fill()
            self.instance, self.own = card, Part()
        elif card.keyword == "END INSTANCE":
            self._fill()
            self._place()
        elif card.keyword in ("NSET", "ELSET"):
            self.waiting.append(card)
        elif card.keyword in TAKEN:
            if unknown := next((word for row in card.rows for word in row if word.startswith("<")), ""):
                raise InputError(
                    f"{self.path} has {unknown} on a card *{card.keyword}, a parameter, which is not read; expected "
                    "numbers; write the deck with them in its place"
                )
            TAKEN[card.keyword](self, card)
        elif card.keyword in LEFT_OUT:
            self._say(f"*{card.keyword} ({LEFT_OUT[card.keyword]})", max(len(card.rows), 1))

    def whole(self) -> Part:
        """Return all nodes and elements, the sets of parts beside those of the assembly.

        A set of a part has its name where no other part and no set of the assembly has it, with the instance before it
        where there are several.
        """
        self._fill()
        if not self.first:  # parts alone: each lies where it is
            for name in self.parts:
                self.instance, self.own = Card("INSTANCE", {"NAME": name, "PART": name}, ()), Part()
                self._place()
        for (kind, name), owners in self.of_parts.items():
            is_free = self._name(kind, name) not in self.part.sets[kind] and len({part for _, part, _ in owners}) == 1
            for instance, _, members in owners:
                if is_free:
                    extend(self.part.sets[kind], name, members)
                if not is_free or len(owners) > 1:
                    extend(self.part.sets[kind], f"{instance}.{name}", members)
        return self.part

    def _fill(self) -> None:
        """Take the sets that wait, those that name others after them."""
        waiting, self.waiting = self.waiting, []
        while waiting:
            later = []
            for card in waiting:
                try:
                    with _told(self.path, card):
                        self._set(card)
                except InputError:
                    later.append(card)
            if len(later) == len(waiting):
                with _told(self.path, later[0]):
                    self._set(later[0])
            waiting = later

    def _place(self) -> None:
        """Add the instance that ends here, its own nodes and elements after its part's."""
        if self.instance is None:
            raise ValueError("no *INSTANCE is open")
        options = self.instance.options
        name, of = options["NAME"], options.get("PART", "").upper()
        part = joined(self.parts[of] if of else Part(), self.own)
        move = motion(self.instance.rows)
        by = max([BEHIND_ASSEMBLY, *self.part.nodes, *self.part.elements])
        self.part.nodes |= {by + k: tuple(move(place)) for k, place in part.nodes.items()}
        for number, (kind, nodes) in part.elements.items():
            self.part.elements[by + number] = (kind, tuple(by + n for n in nodes))
        for kind, sets in part.sets.items():
            for own, members in sets.items():
                moved = [by + n for n in members]
                self.of_parts.setdefault((kind, own), []).append((name, of or name, moved))
        self.first[name.upper()] = by
        self.own, self.instance = self.part, None

    def _name(self, kind: str, name: str) -> str:
        """Return a set's name as the deck first wrote it."""
        return next((own for own in self.own.sets[kind] if own.upper() == name.upper()), name)

    def _add(self, kind: str, name: str | None, members: Sequence[int]) -> None:
        if name:
            extend(self.own.sets[kind], self._name(kind, name), members)

    def _heading(self, card: Card) -> None:
        self.is_by_meshio = any("written by meshio" in word for row in card.rows for word in row)

    def _nodes(self, card: Card) -> None:
        if card.options.get("SYSTEM", "R").upper() != "R":
            raise InputError(f"{self.path} has nodes in cylindrical or spherical axes; expected x, y, z; write them so")
        for row in card.rows:
            number = int(row[0])
            place = tuple(fortran_number(word) if word else 0.0 for word in (*row[1:4], "", "", "")[:3])
            if any(abs(value) > FARTHEST for value in place):
                raise ValueError(f"{max(place, key=abs)} is no coordinate")
            if self.own.nodes.setdefault(number, place) != place:
                self._say("*NODE (places of nodes that are given again)")
                self.own.nodes[number] = place
        self._add("NSET", card.options.get("NSET"), [int(row[0]) for row in card.rows])

    def _nodes_between(self, card: Card) -> None:
        """Add nodes on a straight line between two: *NGEN."""
        if card.options.get("LINE", "") not in ("", "S", "s"):
            raise InputError(f"{self.path} has nodes on a curve by *NGEN; expected a straight line; write them out")
        for row in card.rows:
            first, last, step = int(row[0]), int(row[1]), int(row[2]) if len(row) > 2 and row[2] else 1
            numbers = counted(first, last, step)
            ends = np.array([self.own.nodes[first], self.own.nodes[last]])
            for k, number in enumerate(numbers):
                self.own.nodes[number] = tuple((ends[0] + k / max(len(numbers) - 1, 1) * (ends[1] - ends[0])).tolist())
            self._add("NSET", card.options.get("NSET"), numbers)

    def _elements(self, card: Card) -> None:
        own = card.options["TYPE"]
        kind, said = kind_of(own, self.is_by_meshio)
        if said:
            self._left_out(card, said)
            return
        if not kind:
            raise wrong_kind(str(self.path), len(card.rows), own)
        if own.upper().startswith("M3D"):
            self._say(f"bending of {own.upper()} (membranes are read as shells)", len(card.rows))
        numbers = []
        for number, nodes in element_rows(self._numbered(card), WIDTHS[kind]):
            if number in self.own.elements:
                raise ValueError(f"element {number} is there twice")
            own_order = MIDDLE.get(kind) if not self.is_by_meshio else None
            self.own.elements[number] = (kind, tuple(nodes[k] for k in own_order) if own_order else nodes)
            numbers.append(number)
        self._add("ELSET", card.options.get("ELSET"), numbers)

    def _left_out(self, card: Card, what: str) -> None:
        """Count elements that are no part of a mesh; their nodes are a node set of their name."""
        self._say(f"{card.options['TYPE'].upper()} ({what})", len(card.rows))
        rows = self._numbered(card)
        nodes = [int(word) for row in rows for word in row[1:] if word]
        self._add("NSET", card.options.get("ELSET"), nodes)
        for row in rows:
            self.own.elements[int(row[0])] = ("", tuple(int(word) for word in row[1:] if word))
        self._add("ELSET", card.options.get("ELSET"), [int(row[0]) for row in rows])

    def _numbered(self, card: Card) -> list[list[str]]:
        """Return rows with the nodes of instances, such as Plate-1.3, by their numbers in the whole."""
        return [[self._number(word) for word in row] for row in card.rows]

    def _number(self, word: str) -> str:
        instance, dot, rest = word.rpartition(".")
        by = self.first.get(instance.upper()) if dot and rest.isdigit() else None
        return word if by is None else str(by + int(rest))

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
        by = self.first[options["INSTANCE"].upper()] if "INSTANCE" in options else 0
        members: list[int] = []
        if kind == "NSET" and "ELSET" in options:
            of = self.own.sets["ELSET"][self._name("ELSET", options["ELSET"])]
            members = [node for element in of for node in self.own.elements[element][1]]
        elif "GENERATE" in options:
            for row in card.rows:
                words = [by + int(row[0]), by + int(row[1] if len(row) > 1 and row[1] else row[0])]
                step = int(row[2]) if len(row) > 2 and row[2] else 1
                members += [number for number in counted(words[0], words[1], step) if number in known]
        else:
            before = f"{options['INSTANCE']}." if "INSTANCE" in options else ""
            for word in (word for row in card.rows for word in row if word):
                members += self._named(before + word, kind, sets, known, name)
        self._add(kind, name, members)

    def _named(
        self, word: str, kind: str, sets: Mapping[str, list[int]], known: Mapping[int, object], name: str
    ) -> list[int]:
        """Return what a word of a set names: a number, one of an instance, or another set, of an instance too."""
        number = self._number(word)
        if number.lstrip("-").isdigit() and int(number) in known:
            return [int(number)]
        for (its, of_part), owners in self.of_parts.items():
            for own, _, members in owners:
                if its == kind and f"{own}.{of_part}".upper() == word.upper():
                    return members
        if self._name(kind, word) in sets:
            return sets[self._name(kind, word)]
        raise InputError(
            f"{self.path}, set {name!r} names {word!r}, which is not in the deck; expected it; correct the set"
        )

    def _section(self, card: Card) -> None:
        """Note what of a shell's section moves it off its nodes, or turns its material."""
        for name in ("OFFSET", "OFFSET1", "OFFSET2"):
            offset = card.options.get(name, "0").upper()
            if offset not in ("MIDDLE SURFACE", "MID") and offset.strip("+-0.E"):
                self._say(f"{name} of *{card.keyword} (elements beside their nodes)")
        if "ORIENTATION" in card.options:
            self._say(f"ORIENTATION of *{card.keyword} (directions of the material)")
        if "NODAL THICKNESS" in card.options:
            self._say(f"NODAL THICKNESS of *{card.keyword} (thickness at nodes)")

    def _say(self, what: str, n: int = 1) -> None:
        self.left_out[what] = self.left_out.get(what, 0) + n


TAKEN: dict[str, Callable[[Deck, Card], None]] = {
    "HEADING": Deck._heading,
    "NODE": Deck._nodes,
    "NGEN": Deck._nodes_between,
    "ELEMENT": Deck._elements,
    "ELGEN": Deck._elements_again,
    "SHELL SECTION": Deck._section,
    "SHELL GENERAL SECTION": Deck._section,
    "BEAM SECTION": Deck._section,
}
