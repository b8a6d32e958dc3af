"""The sets of an Abaqus or CalculiX deck, which meshio 5.3 mixes up.

It numbers the sets of *ELEMENT cards by named cards, not by cards; keeps one card for a set that two cards fill; puts a
set of sets into lists that are not by block; and keeps the nodes of the last *NODE card alone. Here the cards are read
again for their sets; nodes and corners stay meshio's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from femlib.errors import InputError


@dataclass(frozen=True, slots=True)
class Card:
    """One keyword with its data.

    Attributes
    ----------
    keyword : str
        In capitals, without the star.
    options : mapping
        Values by option in capitals; "" where an option has none.
    rows : tuple of tuple of str
        Data lines, split at commas.
    """

    keyword: str
    options: Mapping[str, str]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class DeckSets:
    """Sets by name, as positions.

    Attributes
    ----------
    elements : mapping
        Positions among all elements, in the order of the *ELEMENT cards.
    nodes : mapping
        Positions among the nodes.
    """

    elements: Mapping[str, tuple[int, ...]]
    nodes: Mapping[str, tuple[int, ...]]


def cards_of(text: str) -> list[Card]:
    """Return the cards of a deck."""
    heads: list[tuple[str, dict[str, str]]] = []
    rows: list[list[tuple[str, ...]]] = []
    for line in text.splitlines():
        stripped = line.strip()
        if not stripped or stripped.startswith("**"):
            continue
        words = tuple(word.strip() for word in stripped.split(","))
        if stripped.startswith("*"):
            pairs = (word.partition("=") for word in words[1:] if word)
            heads.append((words[0][1:].upper(), {k.strip().upper(): v.strip() for k, _, v in pairs}))
            rows.append([])
        elif rows:
            rows[-1].append(tuple(word for word in words if word))
    return [Card(keyword, options, tuple(own)) for (keyword, options), own in zip(heads, rows, strict=True)]


def deck_sets(text: str, widths: Sequence[int], path: Path) -> DeckSets:
    """Return the sets of a deck whose *ELEMENT cards have `widths` nodes an element.

    Raises
    ------
    InputError
        If the deck has several *NODE cards, an *INCLUDE, a moved *INSTANCE, or a set that names what is not there.
    """
    cards = cards_of(text)
    _refuse_parts(cards, path)
    node_at: dict[str, int] = {}
    element_at: dict[str, int] = {}
    sets: dict[str, dict[str, list[int]]] = {"NSET": {}, "ELSET": {}}
    blocks = iter(widths)
    for card in cards:
        if card.keyword == "NODE" and card.rows:
            numbers = [row[0] for row in card.rows]
            node_at = {str(int(number)): k for k, number in enumerate(numbers)}
            _extend(sets["NSET"], card.options.get("NSET"), range(len(numbers)))
        elif card.keyword == "ELEMENT":
            words = [word for row in card.rows for word in row]
            numbers = words[:: next(blocks) + 1]
            first = len(element_at)
            element_at |= {str(int(number)): first + k for k, number in enumerate(numbers)}
            _extend(sets["ELSET"], card.options.get("ELSET"), range(first, first + len(numbers)))
        elif card.keyword in sets:
            known = node_at if card.keyword == "NSET" else element_at
            own = sets[card.keyword]
            _extend(own, card.options[card.keyword], _members(card, known, own, path))
    found = [{name: tuple(dict.fromkeys(own)) for name, own in sets[kind].items()} for kind in ("ELSET", "NSET")]
    return DeckSets(found[0], found[1])


def _refuse_parts(cards: Sequence[Card], path: Path) -> None:
    if sum(card.keyword == "NODE" and bool(card.rows) for card in cards) > 1:
        raise InputError(
            f"{path} has several *NODE cards, of which meshio keeps the last; expected one; merge the parts or cards"
        )
    for card in cards:
        if card.keyword == "INCLUDE":
            raise InputError(f"{path} includes another file; expected all cards in one; paste it in")
        if card.keyword == "INSTANCE" and card.rows:
            raise InputError(
                f"{path} moves the instance {card.options.get('NAME', '')!r}, which meshio leaves where its part is; "
                "expected parts in place; write a flat deck"
            )


def _extend(sets: dict[str, list[int]], name: str | None, members: Sequence[int]) -> None:
    if name:
        sets.setdefault(name, []).extend(members)


def _members(card: Card, known: Mapping[str, int], sets: Mapping[str, Sequence[int]], path: Path) -> list[int]:
    """Return the positions that an *NSET or *ELSET card names."""
    where = f"{path}, set {card.options[card.keyword]!r}"
    if "GENERATE" in card.options:
        triples = [[int(word) for word in row] for row in card.rows]
        ranges = (range(t[0], t[1] + 1, t[2] if len(t) > 2 else 1) for t in triples)
        return [known[str(n)] for span in ranges for n in span if str(n) in known]
    found: list[int] = []
    for word in (word for row in card.rows for word in row):
        if word in sets:
            found += sets[word]
        elif word in known:
            found.append(known[word])
        else:
            raise InputError(
                f"{where} names {word!r}, which is not in the deck before it; expected it; correct the set"
            )
    return found


def masks(sets: Mapping[str, Sequence[int]], n: int) -> dict[str, np.ndarray]:
    """Return the sets as truth values (n,)."""
    found = {}
    for name, members in sets.items():
        found[name] = np.zeros(n, dtype=bool)
        found[name][list(members)] = True
    return found
