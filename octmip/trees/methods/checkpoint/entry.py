"""An entry of a checkpoint file: what a solve was asked, and what it has found.

The solution of a solve that has ended is taken as it is. One that a limit or Ctrl-C ended goes on from its tree, its
bound and, where its method keeps one, the state of its search. In a study a solve that a limit ended counts as ended:
its limits are then a part of what was asked, as is its start.
"""

import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from octmip.errors import DataError, OctmipError
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Limits, Solution, Stop, relative_gap
from octmip.trees.methods.checkpoint.file import Asked, CheckpointFile
from octmip.trees.methods.options import Opened, Options, Study
from octmip.trees.nodes.tree import Node
from octmip.trees.nodes.tree_nodes import decode_tree, encode_tree
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import Shape

ENDED = (Stop.OPTIMAL, Stop.FINISHED, Stop.NUMERICS)
"""Stops of a solve that finds no more, however long it goes on."""
KINDS: Mapping[str, Callable[[Any], Any]] = {
    "objective": float,
    "bound": float,
    "stop": Stop,
    "seconds": float,
    "n_nodes": int,
    "solver": str,
    "version": str,
    "seed": int,
    "tolerance": float,
    "details": dict,
}
"""What an entry holds of a solution beside the tree."""


@dataclass(slots=True, eq=False)
class Entry(Opened):
    """The entry of one solve.

    Attributes
    ----------
    file, asked
        where it stands.
    problem
        that is solved.
    found
        seconds and nodes that were spent, solution and state, as JSON holds them.
    started
        time of `time.perf_counter` at which this solve began.
    seconds, nodes
        spent by all solves before this one.
    """

    file: CheckpointFile
    asked: Asked
    problem: Problem
    found: dict[str, Any]
    started: float = field(default_factory=lambda: time.perf_counter())
    seconds: float = 0.0
    nodes: int = 0

    def __post_init__(self) -> None:
        if self.found:
            try:
                self.seconds, self.nodes = float(self.found["seconds"]), int(self.found["nodes"])
            except (LookupError, ValueError, TypeError, OverflowError) as error:
                raise self.unusable(error) from error

    def unusable(self, error: object) -> DataError:
        """Return the error of an entry that no solve wrote."""
        return self.file.unusable(f"holds something else than a solve of this problem writes ({error!r})")

    def solution(self) -> Solution | None:
        """Return the solution, certified; None where there is none yet.

        Raises
        ------
        DataError
            it is none of the problem.
        """
        if (entry := self.found.get("solution")) is None:
            return None
        try:
            solution = _solution(self.problem, entry)
            if solution.tree is not None:
                certify(self.problem, solution)
            return solution
        except (LookupError, ValueError, TypeError, AttributeError, OctmipError) as error:
            raise self.unusable(error) from error

    def is_ended(self, known: Solution, gap: float, start: Solution | None) -> bool:
        """Whether nothing is left to do beyond a known solution, for a gap that suffices and a tree to start from."""
        if start is not None and start.objective < known.objective:
            return False
        is_near = known.stop is Stop.GAP and relative_gap(known.objective, known.bound) <= gap
        return self.file.is_study or is_near or known.stop in ENDED

    def keep(self, solution: Solution) -> Solution:
        """Add the solution of this solve, and return it with what earlier ones have spent."""
        if not (self.file.is_study and solution.stop is Stop.INTERRUPTED):
            state = None if self.file.is_study else self.found.get("state")
            self._write(solution.n_nodes, solution=_encoded(self.problem, solution), state=state)
        if not self.seconds:
            return solution
        spent = {"seconds": self.seconds, "nodes": self.nodes}
        return replace(solution, details={**solution.details, "resumed_from": spent})

    def save(self, n_nodes: int, state: Mapping[str, Any]) -> None:
        """Write the state of a search that has evaluated so many nodes."""
        self._write(n_nodes, state=state)

    def _write(self, n_nodes: int, **changes: Any) -> None:
        spent = self.seconds + time.perf_counter() - self.started
        self.found |= {"seconds": spent, "nodes": self.nodes + n_nodes} | changes
        self.file.keep(self.asked, self.found)


def entry_of(problem: Problem, method: str, limits: Limits, seed: int, options: Options, start: Node | None) -> Entry:
    """Return the entry of a solve in the checkpoint of its options.

    Raises
    ------
    DataError
        as `CheckpointFile.find`.
    """
    given = options.checkpoint
    is_study = isinstance(given, Study)
    file = CheckpointFile(given.path if is_study else given, is_study)
    shape = [(one.name, getattr(problem.shape, one.name)) for one in fields(Shape) if one.name != "sensor_cost"]
    question = [problem.shape.any_depth, problem.loss, *((name, _in_full(problem, value)) for name, value in shape)]
    asked = {
        "data": problem.digest(),
        "question": _digest(question),
        "method": method,
        "options": _digest(sorted(options.asked().items())),
        "seed": str(seed),
    }
    if is_study:  # the number of threads is not in it, as the tree is the same
        numbers = [float(value) for value in (limits.seconds, limits.gap, limits.nodes, limits.memory)]
        asked["solve"] = _digest([*numbers, encoded_tree(problem, start)])
    return Entry(file, asked, problem, file.find(asked))


def _in_full(problem: Problem, value: object) -> object:
    """Return a value whose words would leave something out as one whose words say all."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return encoded_tree(problem, value) if isinstance(value, Node) else value


def _digest(value: object) -> str:
    return hashlib.sha256(repr(value).encode()).hexdigest()


def encoded_tree(problem: Problem, tree: Node | None) -> dict[str, Any] | None:
    """Return a tree as JSON holds it, features and classes by their index; None for none."""
    return None if tree is None else encode_tree(tree, *_numbers(problem))


def decoded_tree(problem: Problem, tree: Any) -> Node | None:
    """Return the tree that `encoded_tree` made."""
    return None if tree is None else decode_tree(tree, *_numbers(problem))


def _numbers(problem: Problem) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    is_class = problem.loss.predicts == "class"
    return tuple(range(problem.samples.n_features)), tuple(range(problem.samples.n_classes)) if is_class else ()


def _encoded(problem: Problem, solution: Solution) -> dict[str, Any]:
    return {name: getattr(solution, name) for name in KINDS} | {"tree": encoded_tree(problem, solution.tree)}


def _solution(problem: Problem, entry: Mapping[str, Any]) -> Solution:
    values = {name: kind(entry[name]) for name, kind in KINDS.items()}
    values["details"] |= {"kept": True}
    return Solution(tree=decoded_tree(problem, entry["tree"]), **values)
