"""Checkpoints: what a long search has found so far, in a file, from which a killed one goes on.

Line 1 names the format and the sha256 of line 2, a JSON object: to which method, problem, question and version it
belongs, and the state of the search (`exact_state`, `search_keeper`, `two_feature_keeper`). Written whole or not at
all. The sum finds accidents, not forgers: a resumed search believes the bounds of its file, so that a proof which was
resumed rests on whoever kept the file. A proof log does not: its search begins again.
"""

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from octmip.errors import DataError
from octmip.formats.files import PathLike, keep_bytes, read_bytes
from octmip.formats.problem_file import question_digest
from octmip.trees import _native
from octmip.trees.encoding import NodeRow
from octmip.trees.methods.options import ExactOptions, SearchOptions
from octmip.trees.problem import Problem

T = TypeVar("T")
FIRST = "octmip-checkpoint 3"
MOST, INDEX = 2**63 - 1, 2**32 - 1
"""Largest whole numbers and indices that the native core takes."""
MEANING = {
    "version": "version of octmip",
    "method": "method",
    "data": "samples, labels and weights",
    "question": "depth, costs, limits and sensors",
    "options": "options of the search",
    "off": "prunes",
}
"""What an entry says to which search a checkpoint belongs."""
CHECKPOINT_SECONDS = 60.0
"""Seconds between two checkpoints."""


def every_of(options: SearchOptions | ExactOptions) -> float:
    """Return the seconds between two checkpoints, `CHECKPOINT_SECONDS` where none are given."""
    return CHECKPOINT_SECONDS if options.every is None else float(options.every)


def resumed_from(seconds: float, n_nodes: int) -> dict[str, object]:
    """Return what earlier searches have spent, for the details of a solution."""
    return {"resumed_from": {"seconds": seconds, "nodes": n_nodes}}


def identity_of(problem: Problem, method: str, options: str = "") -> dict[str, str]:
    """Return the entries that say to which search a checkpoint belongs."""
    return {
        "version": _native.__version__,
        "method": method,
        "data": problem.digest(),
        "question": question_digest(problem),
        "options": options,
    }


def write_checkpoint(path: PathLike, identity: Mapping[str, str], state: Mapping[str, Any]) -> None:
    """Write a checkpoint, whole or not at all; where that fails, warn: the search goes on, and writes again later."""
    line = json.dumps(dict(identity) | dict(state), separators=(",", ":")).encode()
    keep_bytes(path, f"{FIRST} {hashlib.sha256(line).hexdigest()}\n".encode() + line + b"\n")


def read_checkpoint(
    path: PathLike, identity: Mapping[str, str], state_of: Callable[[Mapping[str, Any]], T]
) -> T | None:
    """Return the state of a search that a checkpoint holds, as `state_of` reads it; None where there is no file.

    Raises
    ------
    DataError
        the file cannot be read, is damaged, or belongs to another problem, question, method or version.
    """
    if not Path(path).exists():
        return None
    first, _, line = read_bytes(path).removesuffix(b"\n").partition(b"\n")
    wanted = f"{FIRST} {hashlib.sha256(line).hexdigest()}"
    if first != wanted.encode():
        what = "is damaged" if first.startswith(FIRST.encode()) else "is no checkpoint"
        got = first[:100].decode("ascii", "replace")
        raise unusable(path, f"{what}: line 1 is {got!r}; expected {wanted!r}")
    try:
        content = json.loads(line)
        _check_identity(path, content, identity)
        return state_of(content)
    except DataError:
        raise
    except (ValueError, LookupError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        raise unusable(path, f"holds something else than a search writes ({error!r})") from error


def unusable(path: PathLike, reason: str) -> DataError:
    """Return the error of a checkpoint from which no search can go on."""
    return DataError(f"checkpoint {path} {reason}; give another file, or remove this one to begin again")


def _check_identity(path: PathLike, content: Any, identity: Mapping[str, str]) -> None:
    for name, wanted in identity.items():
        if name in MEANING and content[name] != wanted:
            got = f"{MEANING[name]} {content[name]!r}; expected {wanted!r}"
            raise unusable(path, f"belongs to another search: it has the {got}")


def seconds_of(content: Mapping[str, Any]) -> float:
    """Return the entry "seconds" of a checkpoint: wall time spent by all searches before [s]."""
    seconds = float(content["seconds"])
    if not (math.isfinite(seconds) and seconds >= 0):
        raise ValueError(f"seconds {seconds}")
    return seconds


def tree_rows(rows: Any, *, has_planes: bool = False) -> list[NodeRow]:
    """Return the rows of a tree: every row but the first is the child of one before it, once.

    Raises
    ------
    ValueError, TypeError
        they are none, or have planes where trees are axis-aligned.
    """
    found: list[NodeRow] = []
    children: list[int] = []
    for number, (*places, terms, offset) in enumerate(rows):
        kind, feature, cut, left, right, label = (whole(place, INDEX) for place in places)
        if kind > 1 + has_planes or (kind != 2 and (terms or offset)):
            raise ValueError(f"row {number} is neither a leaf nor a split of such a tree")
        if kind > 0:
            if not number < left or not number < right:
                raise ValueError(f"row {number} has the children {left} and {right}")
            children += [left, right]
        plane = [(whole(j, INDEX), finite(value)) for j, value in terms]
        found.append((kind, feature, cut, left, right, label, plane, finite(offset)))
    if sorted(children) != list(range(1, len(found))) or not found:
        raise ValueError(f"{len(found)} rows are no tree")
    return found


def flag(value: Any) -> bool:
    """Return true or false, refused where it is neither."""
    if not isinstance(value, bool):
        raise ValueError(f"{value!r} is neither true nor false")
    return value


def finite(number: Any) -> float:
    """Return a finite number, refused where it is none."""
    if not isinstance(number, (int, float)) or isinstance(number, bool) or not math.isfinite(number):
        raise ValueError(f"{number!r} is no finite number")
    return float(number)


def whole(number: Any, most: int = MOST) -> int:
    """Return a whole number of 0 or more, refused where it is none or larger than `most`."""
    if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number <= most:
        raise ValueError(f"{number!r} is no whole number of 0 or more up to {most}")
    return number
