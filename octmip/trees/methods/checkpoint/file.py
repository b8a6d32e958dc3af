"""Checkpoints: what a long search has found so far, in a file, from which a killed one goes on.

Line 1 names the format and the sha256 of line 2, a JSON object: to which method, problem, question and version it
belongs, the tree from which its whole-numbered costs were made, and the state of the search (`exact_state`,
`two_feature_state`). Written whole or not at all. The sum finds accidents, not forgers: a resumed search believes the
bounds of its file, so that a proof which was resumed rests on whoever kept the file. A proof log does not: its search
begins again.
"""

import hashlib
import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from octmip.errors import DataError, ProblemError
from octmip.input.files import PathLike, check_writable, keep_bytes, read_bytes
from octmip.trees import _native
from octmip.trees.encoding import IntegerCosts, NodeRow, Ranks, integer_costs, rows_from_tree, tree_from_rows
from octmip.trees.methods.native_call import feasible_incumbent
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.problem_file import question_digest
from octmip.trees.tree import Node

T = TypeVar("T")
FIRST = "octmip-checkpoint 5"
MOST, INDEX = 2**63 - 1, 2**32 - 1
"""Largest whole numbers and indices that the native core takes."""
MEANING = {
    "version": "version of octmip",
    "method": "method",
    "data": "samples, labels and weights",
    "question": "depth, costs, limits and sensors",
    "options": "options of the search",
}
"""What an entry says to which search a checkpoint belongs."""
CHECKPOINT_SECONDS = 60.0
"""Seconds between two checkpoints."""


def every_of(options: ExactOptions) -> float:
    """Return the seconds between two checkpoints, `CHECKPOINT_SECONDS` where none are given."""
    return CHECKPOINT_SECONDS if options.every is None else float(options.every)


def unusable(path: PathLike, reason: str) -> DataError:
    """Return the error of a checkpoint from which no search can go on."""
    return DataError(f"checkpoint {path} {reason}; give another file, or remove this one to begin again")


@dataclass(slots=True)
class Checkpoint:
    """The file of one search.

    Attributes
    ----------
    problem, ranks
        the problem and its ranks.
    path
        of the file.
    every
        seconds between two times that it is written.
    method
        the solver.
    options
        what the state depends on beside the problem: prunes that are off, a seed.
    started
        time of `time.perf_counter` at which this search began.
    spent
        seconds of the searches before this one.
    """

    problem: Problem
    ranks: Ranks
    path: PathLike
    every: float
    method: str
    options: tuple[object, ...]
    started: float
    spent: float = 0.0

    def read(self, state_of: Callable[[Mapping[str, Any]], T]) -> tuple[Node | None, IntegerCosts, T] | None:
        """Return the tree that made the costs, these, and the state as `state_of` reads it; None without a file.

        Raises
        ------
        DataError
            the file cannot be read or written, is damaged, or belongs to another problem, question, method or version.
        """
        check_writable(self.path)
        if not Path(self.path).exists():
            return None
        first, _, line = read_bytes(self.path).removesuffix(b"\n").partition(b"\n")
        wanted = f"{FIRST} {hashlib.sha256(line).hexdigest()}"
        if first != wanted.encode():
            what = "is damaged" if first.startswith(FIRST.encode()) else "is no checkpoint"
            got = first[:100].decode("ascii", "replace")
            raise unusable(self.path, f"{what}: line 1 is {got!r}; expected {wanted!r}")
        try:
            content = json.loads(line)
            self._check_identity(content)
            self.spent, digest, state = seconds_of(content), str(content["grid"]), state_of(content)
            rows = None if content["grid tree"] is None else tree_rows(content["grid tree"])
        except DataError:
            raise
        except (ValueError, LookupError, TypeError, AttributeError, OverflowError, RecursionError) as error:
            raise unusable(self.path, f"holds something else than a search writes ({error!r})") from error
        tree = None if rows is None else self.tree(rows)
        costs = integer_costs(self.problem, tree)
        if digest != grid_digest(costs):
            raise unusable(self.path, "holds costs on another grid than its tree makes")
        return tree, costs, state

    def write(self, grid: Node | None, costs: IntegerCosts, state: Mapping[str, Any]) -> None:
        """Write the file, whole or not at all; where that fails, warn: the search goes on, and writes again later.

        `costs` are those that the tree `grid` makes, and the state is in their unit.
        """
        content = {
            **self._identity(),
            "seconds": self.spent + time.perf_counter() - self.started,
            "grid": grid_digest(costs),
            "grid tree": None if grid is None else rows_from_tree(grid, self.ranks),
            **state,
        }
        line = json.dumps(content, separators=(",", ":")).encode()
        keep_bytes(self.path, f"{FIRST} {hashlib.sha256(line).hexdigest()}\n".encode() + line + b"\n")

    def tree(self, rows: Sequence[NodeRow], *, is_within: bool = True) -> Node:
        """Return the tree of a checkpoint's rows, refused where it is none of the problem (or over its budget)."""
        problem = self.problem if is_within else replace(self.problem, sensor_budget=None)
        try:
            tree = feasible_incumbent(problem, tree_from_rows(rows, self.ranks))
        except (ProblemError, IndexError) as error:
            raise unusable(self.path, f"holds a tree that is none of this problem ({error})") from error
        assert tree is not None
        return tree

    def resumed_from(self, n_nodes: int) -> dict[str, object]:
        """Return what earlier searches have spent, for the details of a solution."""
        return {"resumed_from": {"seconds": self.spent, "nodes": n_nodes}}

    def _identity(self) -> dict[str, str]:
        return {
            "version": _native.__version__,
            "method": self.method,
            "data": self.problem.digest(),
            "question": question_digest(self.problem),
            "options": hashlib.sha256(repr(self.options).encode()).hexdigest(),
        }

    def _check_identity(self, content: Any) -> None:
        for name, wanted in self._identity().items():
            if content[name] != wanted:
                got = f"{MEANING[name]} {content[name]!r}; expected {wanted!r}"
                raise unusable(self.path, f"belongs to another search: it has the {got}")


def grid_digest(costs: IntegerCosts) -> str:
    """Return the sha256 of whole-numbered costs."""
    sha = hashlib.sha256(repr((costs.exponent, costs.penalty, costs.costs.shape)).encode())
    for array in (costs.weights, costs.rows, costs.costs):
        sha.update(array.astype("<i8").tobytes())
    return sha.hexdigest()


def seconds_of(content: Mapping[str, Any]) -> float:
    """Return the entry "seconds" of a checkpoint: wall time spent by all searches before [s]."""
    seconds = float(content["seconds"])
    if not (math.isfinite(seconds) and seconds >= 0):
        raise ValueError(f"seconds {seconds}")
    return seconds


def tree_rows(rows: Any) -> list[NodeRow]:
    """Return the rows of a tree: every row but the first is the child of one before it, once.

    Raises
    ------
    ValueError, TypeError
        they are none.
    """
    found: list[NodeRow] = []
    children: list[int] = []
    for number, row in enumerate(rows):
        given = dict(row)
        terms, offset = given.pop("terms", None), given.pop("offset", 0.0)
        places = {name: whole(place, INDEX) for name, place in given.items()}
        if places.keys() == {"label"} and terms is None:
            found.append({"label": places["label"]})
            continue
        left, right = places["left"], places["right"]
        if not number < left or not number < right:
            raise ValueError(f"row {number} has the children {left} and {right}")
        children += [left, right]
        if terms is None:
            found.append({"feature": places["feature"], "cut": places["cut"], "left": left, "right": right})
        else:
            plane = [(whole(j, INDEX), finite(value)) for j, value in terms]
            found.append({"terms": plane, "offset": finite(offset), "left": left, "right": right})
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
