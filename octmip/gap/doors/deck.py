"""An input deck with @parameters@ as a twin: the names are filled in, a solver runs, its results are searched.

A deck is any text file in which @name@ stands for a parameter, a state or a load. Its card (`Card`) has one key more,
"deck": {"command": ["ccx", "{job}"], "output": "{job}.dat", "find": {...}}. The solver runs in a folder of its own,
where the deck lies as {job} with its own ending. "find" gives a regular expression for each reading: its first group is
the number, and its last match in the "output" file counts. "scale" multiplies the number, as in
{"u": {"match": "...", "scale": 1e3}}. Other files that the deck needs must be named in it by absolute paths.
"""

import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from octmip.errors import DataError, TwinError
from octmip.formats.checked import Anything, ListOf, MapOf, Number, Record, Text
from octmip.formats.files import read_bytes, read_json_object
from octmip.gap.doors.card import Card, card_from, place_of_card
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.doors.script import LONGEST, run_program

JOB = "job"
"""Name of the deck in its folder, without its ending."""
RUN = Record({"command": ListOf(Text(), least=1), "output": Text(), "find": MapOf(Anything())}, closed=True)
FOUND = Record({"match": Text(), "scale": Number()}, closed=True)
"""Entries of "deck", and of a reading in "find"."""


@dataclass(frozen=True, slots=True)
class Solver:
    """How a deck is run and its readings are found.

    Attributes
    ----------
    command
        the words of the command; {job} is the deck without its ending.
    output
        file that the solver writes, {job} as before; "" for what it prints.
    find
        (regular expression, scale) of every reading by name.
    """

    command: tuple[str, ...]
    output: str
    find: Mapping[str, tuple[str, float]]


def deck_twin(path: str | Path, card: str | Path | None = None, seconds: float = LONGEST) -> FunctionTwin:
    """Return the twin of a deck.

    Parameters
    ----------
    path
        the deck with @names@.
    card
        the file of its card; by default the one beside it, its name with .json added.
    seconds
        after which a run is ended.

    Raises
    ------
    DataError
        no such file, a @name@ that the card does not have, a reading that is not found anywhere.
    """
    text = read_bytes(path).decode("utf-8", errors="surrogateescape")
    known, solver = _card_and_solver(place_of_card(path, card))
    names = {*known.parameters, *known.states, *known.loads}
    used = set(re.findall(r"@(\w+)@", text))
    if not used <= names:
        raise DataError(
            f"deck {path} holds @{min(used - names)}@, which is no parameter, state or load of its card; expected "
            f"among {sorted(names)}"
        )

    def function(parameters: Mapping[str, float], loads: Mapping[str, float]) -> dict[str, float]:
        given = {**parameters, **loads}
        filled = re.sub(r"@(\w+)@", lambda found: repr(float(given[found[1]])), text)
        return _run(filled, Path(path), solver, seconds)

    return FunctionTwin(function, known)


def _card_and_solver(path: Path) -> tuple[Card, Solver]:
    content = read_json_object(path)
    try:
        own = RUN.take(_with(content.pop("deck"), output=""))
        find = {name: _place(found) for name, found in own["find"].items()}
    except (KeyError, DataError, re.error) as error:
        wrong = f"the key {error} is missing" if isinstance(error, KeyError) else str(error)
        raise DataError(
            f"card {path} of a deck: {wrong}; expected a card with the key 'deck', an object of 'command', 'output' "
            "and 'find'; correct it"
        ) from error
    solver = Solver(tuple(own["command"]), own["output"], find)
    known = card_from(path, content)
    missing = [name for name in known.readings if name not in find]
    if missing:
        raise DataError(f"card {path} does not say where reading {missing[0]!r} is found; add it to 'find'")
    return known, solver


def _with(given: Any, **values: object) -> Any:
    """Return an entry with values that it may leave out."""
    return values | given if isinstance(given, dict) else given


def _place(found: Any) -> tuple[str, float]:
    """Return expression and scale; a text alone has the scale 1."""
    place = FOUND.take(_with({"match": found} if isinstance(found, str) else found, scale=1.0))
    if re.compile(place["match"]).groups < 1:
        raise DataError(f"the expression {place['match']!r} has no group")
    return place["match"], place["scale"]


def _run(filled: str, path: Path, solver: Solver, seconds: float) -> dict[str, float]:
    with tempfile.TemporaryDirectory(prefix="octmip-deck-") as folder:
        (Path(folder) / f"{JOB}{path.suffix or '.inp'}").write_bytes(filled.encode("utf-8", errors="surrogateescape"))
        words = [word.replace("{job}", JOB) for word in solver.command]
        said = run_program(words, f"deck {path}", seconds, folder=folder)
        if solver.output:
            written = Path(folder) / solver.output.replace("{job}", JOB)
            if not written.is_file():
                raise TwinError(f"deck {path}: {words[0]} wrote no {written.name}; expected its results there")
            said = written.read_text(errors="replace")
    return {name: _found(said, name, *place, path) for name, place in solver.find.items()}


def _found(said: str, name: str, match: str, scale: float, path: Path) -> float:
    numbers = re.findall(match, said, flags=re.MULTILINE)
    if not numbers:
        raise TwinError(f"deck {path}: reading {name!r} is not in the results; expected a match of {match!r}")
    last = numbers[-1] if isinstance(numbers[-1], str) else numbers[-1][0]
    try:
        return scale * float(last.replace("D", "E"))
    except ValueError as error:
        raise TwinError(f"deck {path}: reading {name!r} is {last!r} in the results; expected a number") from error
