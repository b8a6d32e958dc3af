"""Finished solves in a file: a study that is started again, or goes on after a kill, makes only those that are missing.

Line 1 names the format and the version of octmip. Every other line is one solve: the first digits of the sha256 of its
rest, then a JSON object with the key of what was asked (problem, method, limits, seed, options, incumbent) and the
solution. A line is written at once and ends with a line feed, so of a run that was killed all whole lines stand. The
sums find accidents, not forgers: trees are certified again, bounds are believed.
"""

import hashlib
import importlib
import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from octmip.errors import DataError, OctmipError, WriteError
from octmip.input.files import PathLike, check_writable, read_bytes, warn_not_kept, write_bytes
from octmip.trees.problem import Problem
from octmip.trees.problem_file import question_digest
from octmip.trees.registry import Run
from octmip.trees.solution import Solution, Stop
from octmip.trees.tree import Node
from octmip.trees.tree_nodes import decode_tree, encode_tree

FORMAT = "octmip-solves 1"
N_DIGITS = 16
"""Digits of a line's sum."""
UNASKED = ("cluster",)
"""Options that change where a solve is made, not what it finds."""


@dataclass(slots=True)
class SolvesFile:
    """The solves of a file.

    Attributes
    ----------
    path
        of the file; it is made where there is none.
    version
        of octmip: what another version found is refused.
    found
        solutions as JSON objects, by key.
    """

    path: PathLike
    version: str
    found: dict[str, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_writable(self.path)
        if not Path(self.path).exists():
            write_bytes(self.path, f"{self._first}\n".encode())
            return
        first, *lines = read_bytes(self.path).split(b"\n")
        if first.decode("ascii", "replace") != self._first:
            raise self._unusable(f"line 1 is {first[:60].decode('ascii', 'replace')!r}; expected {self._first!r}")
        for number, line in enumerate(lines[:-1], start=2):  # what follows the last line feed was cut off by a kill
            digits, _, rest = line.partition(b" ")
            if hashlib.sha256(rest).hexdigest()[:N_DIGITS].encode() != digits:
                raise self._unusable(f"line {number} is damaged: its sum is not that of its rest")
            try:
                entry = json.loads(rest)
                self.found[str(entry["key"])] = dict(entry["solution"])
            except (ValueError, KeyError, TypeError) as error:
                raise self._unusable(f"line {number} is no solve ({error!r})") from error
        if lines and lines[-1]:
            whole = read_bytes(self.path)[: -len(lines[-1])]
            write_bytes(self.path, whole)

    @property
    def _first(self) -> str:
        return f"{FORMAT} {self.version}"

    def _unusable(self, reason: str) -> DataError:
        return DataError(
            f"solves {self.path}: {reason}; expected a file that the same version of octmip wrote; give another, or "
            "remove this one to begin again"
        )

    def find(self, problem: Problem, key: str) -> Solution | None:
        """Return the solution that has this key, None where there is none.

        Raises
        ------
        DataError
            it is none of this problem.
        """
        entry = self.found.get(key)
        if entry is None:
            return None
        try:
            return _solution(problem, entry)
        except (LookupError, ValueError, TypeError, AttributeError, OctmipError) as error:
            raise self._unusable(f"the solve {key[:N_DIGITS]} is no solution of its problem ({error})") from error

    def keep(self, problem: Problem, key: str, solution: Solution) -> None:
        """Add a solution; where the file cannot be written, warn: the solution is known all the same."""
        self.found[key] = _entry(problem, solution)
        line = json.dumps({"key": key, "solution": self.found[key]}, separators=(",", ":")).encode()
        written = hashlib.sha256(line).hexdigest()[:N_DIGITS].encode() + b" " + line + b"\n"
        try:
            _append(self.path, written)
        except OSError as error:
            reason = error.strerror or "it was cut off"
            warn_not_kept(WriteError(f"solves {self.path} cannot be written: {reason}; make room"))


def _append(path: PathLike, line: bytes) -> None:
    """Append a line at once, to the disk; where there is room for a part of it only, nothing."""
    file = os.open(path, os.O_WRONLY | os.O_APPEND)
    try:
        before = os.fstat(file).st_size
        if os.write(file, line) < len(line):
            os.ftruncate(file, before)
            raise OSError
        os.fsync(file)
    finally:
        os.close(file)


def kept_solve(
    problem: Problem,
    run: Run,
    path: PathLike,
    incumbent: Node | Solution | None,
    solve: Callable[[Problem, Run, Node | Solution | None], Solution],
) -> Solution:
    """Return the solution that a file of solves has, or make it by `solve` and add it there.

    Raises
    ------
    DataError
        the file cannot be read or written, or holds something else.
    """
    asked = replace(run, options=replace(run.options, solves=None))
    version = importlib.import_module("octmip.trees._native").__version__  # only here: the package begins without it
    kept, key = SolvesFile(path, version), key_of(problem, asked, incumbent)
    if (found := kept.find(problem, key)) is not None:
        return found
    solution = solve(problem, asked, incumbent)
    if solution.stop is not Stop.INTERRUPTED:
        kept.keep(problem, key, solution)
    return solution


def key_of(problem: Problem, run: Run, incumbent: Node | Solution | None) -> str:
    """Return the sha256 of what a solve was asked; the number of threads is not in it, as the tree is the same."""
    tree = incumbent.tree if isinstance(incumbent, Solution) else incumbent
    limits = [float(value).hex() for value in (run.limits.seconds, run.limits.gap, run.limits.nodes, run.limits.memory)]
    options = sorted((name, repr(value)) for name, value in run.options.given().items() if name not in UNASKED)
    asked = [problem.digest(), question_digest(problem), run.method, run.seed, limits, options]
    start = None if tree is None else encode_tree(tree, *_numbers(problem))
    return hashlib.sha256(json.dumps([*asked, start]).encode()).hexdigest()


def _numbers(problem: Problem) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    return tuple(range(problem.n_features)), tuple(range(problem.n_classes))


def _entry(problem: Problem, solution: Solution) -> dict[str, Any]:
    return {
        "tree": None if solution.tree is None else encode_tree(solution.tree, *_numbers(problem)),
        "floats": [value.hex() for value in (solution.objective, solution.bound, solution.seconds, solution.tolerance)],
        "stop": str(solution.stop),
        "nodes": solution.n_nodes,
        "solver": solution.solver,
        "version": solution.version,
        "seed": solution.seed,
        "details": dict(solution.details),
    }


def _solution(problem: Problem, entry: Mapping[str, Any]) -> Solution:
    objective, bound, seconds, tolerance = (float.fromhex(value) for value in entry["floats"])
    if math.isnan(bound) or math.isnan(objective):
        raise ValueError("objective and bound are no numbers")
    return Solution(
        tree=None if entry["tree"] is None else decode_tree(entry["tree"], *_numbers(problem)),
        objective=objective,
        bound=bound,
        stop=Stop(entry["stop"]),
        seconds=seconds,
        n_nodes=entry["nodes"],
        solver=entry["solver"],
        version=entry["version"],
        seed=entry["seed"],
        tolerance=tolerance,
        details=dict(entry["details"]) | {"kept": True},
    )
