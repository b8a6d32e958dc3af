"""Messages of ROS 1 and 2, decoded many at once where they are laid out alike.

Texts and the lengths of texts and sequences say where the numbers of a message lie. Messages of one size whose texts
and lengths are those of the first are laid out as the first is, and are one array. rosbags decodes that first one too:
where the two differ, and where messages differ from one another, rosbags decodes every one.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.serde.utils import SIZEMAP

from octmip.recordings.readers.messages import MOST_FIELDS, Columns, columns_of, field_of, joined
from octmip.recordings.recording import Floats

MOST_LAYOUTS = 4
"""Layouts in a batch; messages that have others are decoded one by one."""
OTHER_NAMES = {"byte": "int8", "char": "uint8"}
"""Types of numbers that NumPy calls otherwise."""


class Decoder:
    """Decodes messages of one type, of ROS 2 (CDR) or of ROS 1; `store` has the type's definition."""

    def __init__(self, store: Any, kind: str, is_cdr: bool) -> None:
        self.store, self.kind, self.is_cdr = store, kind, is_cdr
        self.decode = store.deserialize_cdr if is_cdr else store.deserialize_ros1

    def __call__(self, messages: Sequence[bytes]) -> Columns:
        """Return the numbers of a batch."""
        sizes, left, parts = np.array([len(one) for one in messages]), np.ones(len(messages), dtype=bool), list[Any]()
        for _ in range(MOST_LAYOUTS):
            rows = np.flatnonzero(left & (sizes == sizes[left.argmax()]))
            same, columns = self._alike([messages[k] for k in rows.tolist()])
            parts += [(place, (rows[same], numbers)) for place, numbers in columns.items()]
            left[rows[same]] = False
            if not left.any():
                break
        rows = np.flatnonzero(left)
        others = columns_of([self.decode(messages[k], self.kind) for k in rows.tolist()])
        return joined([*parts, *((place, (rows[at], numbers)) for place, (at, numbers) in others.items())])

    def _alike(self, messages: Sequence[bytes]) -> tuple[NDArray[np.bool_], dict[str, Floats]]:
        """Return which messages of one size are laid out as the first, and the numbers of these."""
        first = columns_of([self.decode(messages[0], self.kind)])
        layout = _Layout(self.store, messages[0], self.is_cdr)
        layout.add((Nodetype.NAME, self.kind), "")
        content, size = np.frombuffer(b"".join(messages), dtype=np.uint8), len(messages[0])
        known = content.reshape(len(messages), size)[:, np.array(layout.fixed, dtype=int)]
        at, same = size * np.arange(len(messages)), np.asarray((known == known[0]).all(axis=1))
        places = layout.places.items() if layout.at <= size else ()
        found = {name: field_of(content, at[same], *place).astype(np.float64) for name, place in places}
        is_right = found.keys() == first.keys() and all(
            np.array_equal(own[:1], first[name][1], equal_nan=True) for name, own in found.items()
        )
        return (same, found) if is_right else (np.zeros_like(same), {})


class _Layout:
    """Where the numbers of a message lie, and the bytes by which that is known."""

    def __init__(self, store: Any, message: bytes, is_cdr: bool) -> None:
        self.store, self.message, self.begin = store, message, 4 if is_cdr else 0
        self.at, self.order = self.begin, ">" if is_cdr and not message[1] else "<"
        self.places, self.fixed = dict[str, tuple[int, str]](), [*range(self.begin)]

    def _move(self, size: int, n: int = 1, is_fixed: bool = False) -> int:
        """Go behind n numbers of a size, which CDR aligns; return where they begin."""
        start = self.at + (-(self.at - self.begin) % size if self.begin else 0)
        self.at = start + n * size
        self.fixed += range(start, self.at) if is_fixed else ()
        return start

    def _length(self) -> int:
        start = self._move(4, is_fixed=True)
        return int.from_bytes(self.message[start : self.at], "big" if self.order == ">" else "little")

    def add(self, form: Any, place: str, is_shown: bool = True) -> None:
        """Add a field of a message at the end of those that are there."""
        kind, what = form
        if kind == Nodetype.NAME:
            for key, inner in self.store.get_msgdef(what).fields:
                self.add(inner, f"{place}.{key}" if place else key, is_shown and not key.startswith("__"))
        elif kind == Nodetype.BASE and what[0] == "string":
            self._move(1, self._length(), is_fixed=True)
        elif kind == Nodetype.BASE:
            start = self._move(SIZEMAP[what[0]])
            if is_shown:
                self.places[place] = start, f"{self.order}{np.dtype(OTHER_NAMES.get(what[0], what[0])).str[1:]}"
        else:
            inner, n = what[0], what[1] if kind == Nodetype.ARRAY else self._length()
            if n > MOST_FIELDS and inner[0] == Nodetype.BASE and inner[1][0] != "string":
                self._move(SIZEMAP[inner[1][0]], n)
            else:
                for k in range(n):
                    self.add(inner, f"{place}.{k}", is_shown and n <= MOST_FIELDS)
