"""DataFlash of ArduPilot (.bin) by pymavlink: messages of fields, in order of TimeUS.

The unit is the log's own: pymavlink applies the factors of the formats c, C, e, E and L, and writes the log's other
multipliers before the unit ("0.01 m"), without multiplying. Number and unit belong together so, and octmip converts.

pymavlink knows formats, units and instances; its `recv_msg` takes the next header of a known message behind the one
before, and so is every message found here, all at once.
"""

import contextlib
import functools
import os
import re
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, needed_by
from octmip.recordings.recording import Channel, Recording

os.environ.setdefault("PYMAVLINK_FAST_INDEX", "0")  # the fast index prints past Python on standard output
with needed_by("a recording of DataFlash"):
    from pymavlink.DFReader import FORMAT_TO_STRUCT, DFReader_binary

TIME, MICROSECOND, HEAD, FORMAT = "TimeUS", 1e-6, 3, 0x80
ABOUT = frozenset({"FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE"})
"""Messages that say what others mean, and those of text."""
GARBAGE = 528
"""Bytes of which pymavlink expects no message at the end of a log once it could not unpack one."""
BLOCK = 1 << 24
"""Bytes that are searched for headers at once."""


class _Log(DFReader_binary):  # type: ignore[misc]
    """A log without its clock of GPS, for which every message would be unpacked, and without the list of messages."""

    def init_clock(self) -> None:
        self.offsets: list[list[int]] = []
        self._rewind(keep_messages=True)


def read(path: Path) -> Recording:
    """Return the fields of a log as MESSAGE/FIELD, of an instance as MESSAGE[1]/FIELD."""
    with contextlib.closing(_Log(str(path))) as log:
        content, forms = np.memmap(path, dtype=np.uint8, mode="r"), log.formats
        at = _messages(content, forms)
        kinds = content[at + 2]
        if len({content[k : k + forms[FORMAT].len].tobytes() for k in at[kinds == FORMAT]}) > len(forms):
            raise DataError(f"{path}: two formats of one message; expected one; split the log between them")
        rows: dict[str, tuple[Any, NDArray[np.int64]]] = {}
        for number in np.unique(kinds):
            form, own = forms[number], at[kinds == number]
            if form.name in ABOUT or TIME not in form.columns:
                continue
            if form.instance_field is None:
                rows[form.name] = form, own
                continue
            raw = _field(content, form, own, form.instance_field)
            for value in dict.fromkeys(raw.tolist()):
                part = own[raw == value]
                log.offset = int(part[0])
                name = f"{form.name}[{getattr(log.recv_msg(), form.instance_field)}]"
                rows[name] = form, np.sort(np.append(part, rows[name][1])) if name in rows else part
    start = min((int(_field(content, form, own[:1], TIME)[0]) for form, own in rows.values()), default=0)

    def loaded(name: str, field: str) -> Channel:
        form, own = rows[name]
        stamps = _field(content, form, own, TIME).astype(np.int64) - start
        unit = form.get_unit(field) or ""
        return Channel(f"{name}/{field}", unit, np.asarray(stamps * MICROSECOND), _field(content, form, own, field))

    loaders = {
        f"{name}/{field}": functools.partial(loaded, name, field)
        for name, (form, _) in rows.items()
        for field in form.columns
        if field not in (TIME, form.instance_field)
    }
    return Recording("DataFlash", loaders)


def _messages(content: Any, forms: Mapping[int, Any]) -> NDArray[np.int64]:
    """Return where messages begin, as `recv_msg` finds them: each at the next head of a known kind behind the last."""
    size, is_whole = np.zeros(256, dtype=np.int64), np.zeros(256, dtype=bool)
    for number, form in forms.items():
        is_whole[number] = struct.calcsize(form.msg_struct) == form.len - HEAD
        size[number] = form.len if is_whole[number] else HEAD  # what it cannot unpack it searches for others
    heads = []
    for first in range(0, max(len(content) - 2, 0), BLOCK):
        part = content[first : first + BLOCK + 2]
        heads.append(first + np.flatnonzero((part[:-2] == 0xA3) & (part[1:-1] == 0x95) & (size[part[2:]] > 0)))
    at = np.concatenate([*heads, np.zeros(0, dtype=np.int64)]).astype(np.int64)
    follower = np.searchsorted(at, at + size[content[at + 2]])
    jumps, runs, k = np.flatnonzero(follower != np.arange(1, len(at) + 1)), list[NDArray[np.int64]](), 0
    while k < len(at):  # from jump to jump: the heads between are other messages' bytes
        place = np.searchsorted(jumps, k)
        last = int(jumps[place]) if place < len(jumps) else len(at) - 1
        runs.append(at[k : last + 1])
        k = int(follower[last])
    at = np.concatenate([*runs, np.zeros(0, dtype=np.int64)])
    least = np.array([(forms[k].len if is_whole[k] else HEAD + GARBAGE) if k in forms else 0 for k in range(256)])
    ends = np.flatnonzero(at + least[content[at + 2]] > len(content))
    at = at[: ends[0]] if len(ends) else at
    return np.asarray(at[is_whole[content[at + 2]]])


def _field(content: Any, form: Any, at: NDArray[np.int64], field: str) -> NDArray[Any]:
    """Return a field (n,) of messages of one format as pymavlink gives it, (n, 32) of an array."""
    k = form.columns.index(field)
    codes = [FORMAT_TO_STRUCT[letter][0] for letter in form.msg_fmts]
    begin, size = HEAD + struct.calcsize("<" + "".join(codes[:k])), struct.calcsize("<" + codes[k])
    kind = "<i2" if form.msg_fmts[k] == "a" else re.sub(r"<(\d+)s", r"S\1", "<" + codes[k])
    values = content[at[:, None] + np.arange(begin, begin + size)].view(kind)
    values = values[:, 0] if values.shape[1] == 1 else values
    factor = form.msg_mults[k]
    return np.asarray(values if factor is None else values / (1.0 / factor))
