"""The states of the two searches that can go on in the middle: what is closed, and the trees and costs it is about.

An exact axis-aligned search keeps the solved cuts of the root with lower bounds of both sides (`KnownRow`). A
two-feature proof keeps its open nodes between two batches (`TwoFeatureState`): a search that goes on makes every batch
that this one would have made, and so ends with the same tree and bound. The nodes are the native core's bytes: what
they mean is known there alone.

Costs are whole numbers on a grid that a tree has made, which a state therefore keeps. A resumed search believes the
bounds of its file, so that its proof rests on whoever kept the file. A proof log does not: its search begins again.
"""

import base64
import contextlib
import hashlib
import math
import zlib
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from octmip.errors import OctmipError, ProblemError
from octmip.input.checked import Whole
from octmip.trees.encoding import IntegerCosts, NodeRow, Ranks, integer_costs, rows_from_tree, tree_from_rows
from octmip.trees.methods.checkpoint.entry import Entry, decoded_tree, encoded_tree
from octmip.trees.methods.native_call import feasible_incumbent
from octmip.trees.methods.options import ExactOptions
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem

CHECKPOINT_SECONDS = 60.0
"""Seconds between two states that are kept."""
LEVEL = 1
"""Of the compression: nodes shrink to a fifth, and faster than a disk takes them."""
MOST_PACKED = 100
"""Times its size that a packed state may unpack to, at most."""
REFUSED = ("known: ", "failed to extract field KnownRow")
"""How the native core begins when it cannot take a state."""
WHOLE = Whole()

Pair = tuple[int, int]
BEST = 6
"""Place of the best tree in a `KnownRow`."""


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
        objective, the base included, and rows of the best tree, which may be over the budget.
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


class ExactState(NamedTuple):
    """A search: proven lower bound (-inf without one), best tree within the budget, what is proven of the root."""

    bound: float
    tree: Node | None
    known: KnownRow | None


class TwoFeatureState(NamedTuple):
    """A search: bytes, intervals of slopes, best cost and rows, bound, nodes; costs on its grid."""

    state: bytes
    n_intervals: int
    best: tuple[int, list[NodeRow]] | None
    bound: int
    n_nodes: int


class StateEntry(NamedTuple):
    """The state in the entry of a solve.

    Attributes
    ----------
    entry
        of the solve.
    problem, ranks
        of the search: perhaps over rows that were made for it.
    every
        seconds between two states that are kept.
    """

    entry: Entry
    problem: Problem
    ranks: Ranks
    every: float

    def read_exact(self) -> tuple[Node | None, ExactState] | None:
        """Return the tree that made the costs and the state; None where there is none yet.

        Raises
        ------
        DataError
            as `_read`; or the bound is above the tree's objective.
        """
        if (read := self._read()) is None:
            return None
        grid, costs, content = read
        with self._decoding():
            bound = float(content["bound"])
            if math.isnan(bound):
                raise ValueError("bound nan")
            numbers, tree, best = _numbers(content["known"]), content["tree"], content["best"]
        tree, best = self._tree(tree), self._tree(best, is_within=False)
        if tree is not None and bound > self.problem.objective(tree):
            raise self.entry.file.unusable(f"claims the bound {bound} above that of its tree")
        with self._decoding():
            known = None
            if best is not None:
                known = KnownRow(*numbers[:BEST], self._counted(costs, best), *numbers[BEST:])  # type: ignore[call-arg]
        return grid, ExactState(bound, tree, known)

    def write_exact(self, grid: Node | None, costs: IntegerCosts, state: ExactState, n_nodes: int) -> None:
        """Keep a state; `costs` are those that the tree `grid` makes."""
        known, best = state.known, None
        if known is not None:
            best = tree_from_rows(known.best[1], self.ranks)
        content = {
            "bound": state.bound,
            "tree": encoded_tree(self.problem, state.tree),
            "known": known and [*known[:BEST], *known[BEST + 1 :]],
            "best": encoded_tree(self.problem, best),
        }
        self._write(grid, costs, n_nodes, content)

    def read_two_feature(self) -> tuple[Node | None, IntegerCosts, TwoFeatureState] | None:
        """Return the tree that made the costs, these, and the state; None where there is none yet."""
        if (read := self._read()) is None:
            return None
        grid, costs, content = read
        with self._decoding():
            n_intervals, bound, n_nodes = _numbers(content["numbers"])
            state, best = _unpacked(content["packed"]), content["best"]
        best = self._tree(best)
        found = None if best is None else self._counted(costs, best)
        return grid, costs, TwoFeatureState(state, n_intervals, found, bound, n_nodes)

    def write_two_feature(self, grid: Node | None, costs: IntegerCosts, state: TwoFeatureState) -> None:
        """Keep a state; `costs` are those that the tree `grid` makes."""
        best = None if state.best is None else tree_from_rows(state.best[1], self.ranks)
        content = {
            "packed": base64.b85encode(zlib.compress(state.state, LEVEL)).decode("ascii"),
            "numbers": [state.n_intervals, state.bound, state.n_nodes],
            "best": encoded_tree(self.problem, best),
        }
        self._write(grid, costs, state.n_nodes - self.entry.nodes, content)

    @contextlib.contextmanager
    def going_on(self) -> Iterator[None]:
        """Let the native core go on from a state; what of it the core cannot take is said in a sentence."""
        try:
            yield
        except (ValueError, TypeError) as error:
            if not str(error).startswith(REFUSED):
                raise
            reason = str(error).removeprefix(REFUSED[0])
            raise self.entry.file.unusable(f"holds what cannot be proven: {reason}") from error

    def _counted(self, costs: IntegerCosts, tree: Node) -> tuple[int, list[NodeRow]]:
        """Return the cost of a tree, counted again, and its rows."""
        return costs.whole_objective(self.problem, tree), rows_from_tree(tree, self.ranks)

    def _read(self) -> tuple[Node | None, IntegerCosts, Mapping[str, Any]] | None:
        """Return the tree that made the costs, these, and what else is kept; None where nothing is.

        Raises
        ------
        DataError
            it is no state of a search of this problem.
        """
        content = self.entry.found.get("state")
        if content is None:
            return None
        with self._decoding():
            encoded, digest = content["grid tree"], content["grid"]
        grid = self._tree(encoded)
        costs = integer_costs(self.problem, grid)
        if digest != grid_digest(costs):
            raise self.entry.file.unusable("holds costs on another grid than its tree makes")
        return grid, costs, content

    def _write(self, grid: Node | None, costs: IntegerCosts, n_nodes: int, content: Mapping[str, Any]) -> None:
        made = {"grid": grid_digest(costs), "grid tree": encoded_tree(self.problem, grid)}
        self.entry.save(n_nodes, {**made, **content})

    def _tree(self, encoded: Any, *, is_within: bool = True) -> Node | None:
        """Return a tree that is kept, refused where it is none of the problem (or over its budget)."""
        problem = self.problem if is_within else self.problem.replace(sensor_budget=None)
        with self._decoding():
            return feasible_incumbent(problem, decoded_tree(problem, encoded))

    @contextlib.contextmanager
    def _decoding(self) -> Iterator[None]:
        try:
            yield
        except ProblemError as error:
            raise self.entry.file.unusable(f"holds a tree that is none of this problem ({error})") from error
        except (OctmipError, ValueError, LookupError, TypeError, AttributeError, OverflowError) as error:
            raise self.entry.unusable(error) from error


def every_of(options: ExactOptions) -> float:
    """Return the seconds between two states that are kept."""
    return CHECKPOINT_SECONDS if options.every is None else float(options.every)


def grid_digest(costs: IntegerCosts) -> str:
    """Return the sha256 of whole-numbered costs."""
    sha = hashlib.sha256(repr((costs.exponent, costs.penalty, costs.costs.shape)).encode())
    for array in (costs.weights, costs.rows, costs.costs):
        sha.update(array.astype("<i8").tobytes())
    return sha.hexdigest()


def _numbers(value: Any) -> Any:
    """Return nested lists of whole numbers, truth values and nulls as tuples."""
    if isinstance(value, list):
        return tuple(map(_numbers, value))
    return value if value is None or isinstance(value, bool) else WHOLE.take(value)


def _unpacked(packed: str) -> bytes:
    content, unpacker = base64.b85decode(packed), zlib.decompressobj()
    try:
        found = unpacker.decompress(content, MOST_PACKED * len(content))
    except zlib.error as error:
        raise ValueError(f"its nodes cannot be unpacked: {error}") from error
    if not unpacker.eof:
        raise ValueError(f"its nodes unpack to more than {MOST_PACKED} times their size")
    return found
