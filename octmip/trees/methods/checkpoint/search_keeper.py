"""The checkpoint of a local search: turns of restarts that are finished, each with its tree and random stream.

A restart begins every turn from these alone, in a search that goes on from a checkpoint as in one that never stopped:
so both end with the same tree. What was under way is done again.
"""

import hashlib
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from octmip.errors import ProblemError
from octmip.formats.files import PathLike, check_writable
from octmip.trees.encoding import NodeRow, Ranks, tree_from_rows
from octmip.trees.methods.checkpoint.envelope import (
    INDEX,
    flag,
    identity_of,
    read_checkpoint,
    seconds_of,
    tree_rows,
    unusable,
    whole,
    write_checkpoint,
)
from octmip.trees.methods.native_call import feasible_incumbent
from octmip.trees.problem import Problem

STREAM = 2**64 - 1
"""Largest state of a random stream."""


class Turn(NamedTuple):
    """A restart after a turn: number, random stream, counts of deep blocks, whether its tree is proven best, rows."""

    number: int
    stream: int
    deep_tries: tuple[int, int]
    is_best: bool
    rows: list[NodeRow]


class FinishedTurns(NamedTuple):
    """What a search has finished.

    Attributes
    ----------
    first
        number of the first restart of the group in work.
    rounds
        finished turns of the group's two rounds and of the last round of all.
    best
        the best restart of the groups before.
    n_visits
        nodes visited.
    """

    first: int
    rounds: list[list[Turn]]
    best: Turn | None
    n_visits: int


@dataclass(slots=True)
class SearchKeeper:
    """Reads and writes the checkpoint of a search.

    Attributes
    ----------
    problem, searched, ranks
        the problem, the smaller one that is searched, and its ranks.
    path
        of the file.
    every
        seconds between two times that it is written.
    options
        seed, restarts, perturbations and rows of the incumbent.
    started
        time of `time.perf_counter` at which this search began.
    """

    problem: Problem
    searched: Problem
    ranks: Ranks
    path: PathLike
    every: float
    options: tuple[object, ...]
    started: float
    spent: float = 0.0

    def read(self) -> FinishedTurns | None:
        """Return what the checkpoint holds, None where there is no file.

        Raises
        ------
        DataError
            it cannot be read or written, is damaged, or belongs to another search.
        """
        check_writable(self.path)
        found = read_checkpoint(
            self.path, self._identity(), lambda content: (seconds_of(content), self._turns(content))
        )
        if found is None:
            return None
        self.spent, turns = found
        try:
            for turn in [*(turn for turns in turns.rounds for turn in turns), *([turns.best] if turns.best else [])]:
                feasible_incumbent(self.searched, tree_from_rows(turn.rows, self.ranks))
        except (ProblemError, IndexError) as error:
            raise unusable(self.path, f"holds a tree that is none of this problem ({error})") from error
        return turns

    def write(self, turns: FinishedTurns) -> None:
        """Write the checkpoint, whole or not at all."""
        seconds = self.spent + time.perf_counter() - self.started
        write_checkpoint(self.path, self._identity(), {"seconds": seconds, "turns": turns})

    def _identity(self) -> dict[str, str]:
        options = hashlib.sha256(repr(self.options).encode()).hexdigest()
        return identity_of(self.problem, "search", options)

    def _turns(self, content: Mapping[str, Any]) -> FinishedTurns:
        first, rounds, best, n_visits = content["turns"]
        begun, gone_on, last = ([self._turn(turn) for turn in turns] for turns in rounds)
        best = None if best is None else self._turn(best)
        return FinishedTurns(whole(first), [begun, gone_on, last], best, whole(n_visits))

    def _turn(self, turn: Any) -> Turn:
        number, stream, (helped, tried), is_best, rows = turn
        rows = tree_rows(rows, has_planes=self.problem.split != "axis")
        return Turn(
            whole(number), whole(stream, STREAM), (whole(helped, INDEX), whole(tried, INDEX)), flag(is_best), rows
        )
