"""Values as a message can show them: short, on one line, nothing that a terminal would obey."""

import itertools
from collections.abc import Iterable
from html import escape

MOST_NAME = 1000
"""Characters of a name: a page, a drawing or a message must bear it."""
SHOWN = 60
"""Characters of a value that a message shows."""


class InWords:
    """What says itself in a few lines, by `str`: a notebook shows them as they are."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return f'<pre style="font-family:monospace">{escape(str(self))}</pre>'


def shown(value: object) -> str:
    """Return a value as a message can show it: short, on one line, nothing that a terminal would obey."""
    if isinstance(value, int) and abs(value) >= 10**SHOWN:
        return f"a whole number of more than {SHOWN} digits"
    if isinstance(value, list | tuple | dict) and value:
        return f"{'an object' if isinstance(value, dict) else 'a list'} of {len(value)}"
    words = repr(value[: SHOWN + 1] if isinstance(value, str) else value)
    return words if len(words) <= SHOWN else f"{words[:SHOWN]}..."


def several(values: Iterable[object], most: int = 12) -> str:
    """Return the first few of some values as a message can show them."""
    found = [shown(value) for value in itertools.islice(values, most + 1)]
    return f"{', '.join(found[:most])}{', ...' if len(found) > most else ''}"


def place(path: tuple[str | int, ...]) -> str:
    """Return where a value stands, as ``solution.bound`` or ``training.leaf_counts[0][1]``."""
    steps = (f"[{step}]" if isinstance(step, int) else f".{_plain(step)}" for step in path[-8:])
    return ("..." if len(path) > 8 else "") + "".join(steps).removeprefix(".") or "the content"


def _plain(step: str) -> str:
    return step if step.isidentifier() and len(step) <= SHOWN else shown(step)
