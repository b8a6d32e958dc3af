"""What a long proof has proven so far, in a file: a killed search goes on where it was last saved.

Line 1 names the format and the sha256 of line 2, a JSON object: to which problem, question, grid and version it
belongs, what was spent, the best tree, and the solved cuts of the root with lower bounds of both sides (`KnownRow`).
Written whole or not at all. The sum finds accidents, not forgers: a resumed search believes the bounds of its file, so
that a proof which was resumed rests on whoever kept the file. A proof log does not: its search begins again.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from octmip.encoding import IntegerCosts, NodeRow
from octmip.errors import DataError
from octmip.formats.files import PathLike, read_bytes, write_bytes

FIRST = "octmip-checkpoint 2"
MOST = 2**63 - 1

Pair = tuple[int, int]


class KnownRow(NamedTuple):
    """What is proven of the root, as the native core hands it out and takes it back; costs on its grid, above the base.

    Attributes
    ----------
    level
        depth of the trees that are searched.
    whole
        bound of the trees one level shallower.
    order, incumbents
        (cost, cut) of each feature's best tree, one level shallower and at this level.
    cuts
        solved cuts: feature, samples left of it, bounds of both sides.
    bound
        of all trees.
    best
        objective, the base included, and rows of the best tree.
    sets
        open sets of sensors (held, banned); None without a budget.
    n_nodes
        cuts evaluated.
    """

    level: int
    whole: int
    order: list[Pair]
    incumbents: list[Pair]
    cuts: list[tuple[int, int, int, int]]
    bound: int
    best: tuple[int, list[NodeRow]]
    sets: list[tuple[list[bool], list[bool]]] | None
    n_nodes: int


@dataclass(frozen=True, slots=True)
class Kept:
    """The state of a search.

    Attributes
    ----------
    seconds
        wall time spent [s], of all the searches before it too.
    n_nodes
        cuts evaluated, likewise.
    bound
        proven lower bound; -inf without one.
    tree
        rows of the best tree of the problem; None without one.
    grid
        rows of the tree from which the whole-numbered costs were made; None: of one leaf.
    known
        what is proven of the root; None before its search has begun.
    """

    seconds: float
    n_nodes: int
    bound: float
    tree: Sequence[NodeRow] | None
    grid: Sequence[NodeRow] | None
    known: KnownRow | None


def grid_digest(costs: IntegerCosts) -> str:
    """Return the sha256 of whole-numbered costs."""
    sha = hashlib.sha256(repr((costs.exponent, costs.penalty, costs.costs.shape)).encode())
    for array in (costs.weights, costs.rows, costs.costs):
        sha.update(array.astype("<i8").tobytes())
    return sha.hexdigest()


def write_checkpoint(path: PathLike, identity: Mapping[str, str], kept: Kept) -> None:
    """Write a checkpoint, whole or not at all.

    Raises
    ------
    DataError
        the file cannot be written.
    """
    content = dict(identity) | {
        "seconds": kept.seconds,
        "nodes": kept.n_nodes,
        "bound": kept.bound.hex(),
        "tree": kept.tree,
        "grid tree": kept.grid,
        "known": kept.known,
    }
    line = json.dumps(content, separators=(",", ":")).encode()
    write_bytes(path, f"{FIRST} {hashlib.sha256(line).hexdigest()}\n".encode() + line + b"\n")


def read_checkpoint(path: PathLike, identity: Mapping[str, str]) -> tuple[Kept, str] | None:
    """Return what a checkpoint holds and the digest of its grid; None where there is no file.

    Raises
    ------
    DataError
        the file cannot be read, is damaged, or belongs to another problem, question or version.
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
        return _kept(content), str(content["grid"])
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        raise unusable(path, f"holds something else than a search writes ({error!r})") from error


def unusable(path: PathLike, reason: str) -> DataError:
    """Return the error of a checkpoint from which no search can go on."""
    return DataError(f"checkpoint {path} {reason}; give another file, or remove this one to begin again")


def _check_identity(path: PathLike, content: Any, identity: Mapping[str, str]) -> None:
    meaning = {
        "version": "version of octmip",
        "data": "samples, labels and weights",
        "question": "depth, costs, limits and sensors",
        "off": "prunes",
    }
    for name, wanted in identity.items():
        if name in meaning and content[name] != wanted:
            got = f"{meaning[name]} {content[name]!r}; expected {wanted!r}"
            raise unusable(path, f"belongs to another search: it has the {got}")


def _kept(content: Mapping[str, Any]) -> Kept:
    seconds, bound = float(content["seconds"]), float.fromhex(content["bound"])
    if not (math.isfinite(seconds) and seconds >= 0) or math.isnan(bound) or bound == math.inf:
        raise ValueError(f"seconds {seconds}, bound {bound}")
    tree, grid = (None if content[name] is None else _rows(content[name]) for name in ("tree", "grid tree"))
    known = None if content["known"] is None else _known(content["known"])
    return Kept(seconds, _whole(content["nodes"]), bound, tree, grid, known)


def _known(row: Any) -> KnownRow:
    row = KnownRow(*row)
    objective, rows = row.best
    return KnownRow(
        level=_whole(row.level),
        whole=_whole(row.whole),
        order=[(_whole(cost), _whole(place)) for cost, place in row.order],
        incumbents=[(_whole(cost), _whole(place)) for cost, place in row.incumbents],
        cuts=[(_whole(f), _whole(k), _whole(left), _whole(right)) for f, k, left, right in row.cuts],
        bound=_whole(row.bound),
        best=(_whole(objective), _rows(rows)),
        sets=None if row.sets is None else [(_flags(held), _flags(banned)) for held, banned in row.sets],
        n_nodes=_whole(row.n_nodes),
    )


def _rows(rows: Any) -> list[NodeRow]:
    """Return the rows of an axis-aligned tree: every row but the first is the child of one before it, once."""
    found: list[NodeRow] = []
    children: list[int] = []
    for number, (kind, feature, cut, left, right, label, terms, offset) in enumerate(rows):
        if _whole(kind) > 1 or terms or offset:
            raise ValueError(f"row {number} is neither a leaf nor a split over one feature")
        if kind == 1:
            if not number < _whole(left) or not number < _whole(right):
                raise ValueError(f"row {number} has the children {left} and {right}")
            children += [left, right]
        found.append((kind, _whole(feature), _whole(cut), left, right, _whole(label), [], 0.0))
    if sorted(children) != list(range(1, len(found))) or not found:
        raise ValueError(f"{len(found)} rows are no tree")
    return found


def _flags(flags: Any) -> list[bool]:
    if not all(isinstance(flag, bool) for flag in flags):
        raise ValueError("sets of sensors are not true and false")
    return list(flags)


def _whole(number: Any) -> int:
    if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number <= MOST:
        raise ValueError(f"{number!r} is no whole number of 0 or more within 63 bits")
    return number
