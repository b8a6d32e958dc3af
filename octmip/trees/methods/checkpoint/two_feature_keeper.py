"""The checkpoint of a two-feature proof: the open nodes of its search between two batches, and the best tree.

A search that goes on makes every batch that this one would have made, and so ends with the same tree and bound. The
nodes are the native core's bytes, compressed: what they mean is known there alone.
"""

import base64
import hashlib
import time
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from octmip.errors import ProblemError
from octmip.formats.files import PathLike, check_writable
from octmip.trees.encoding import IntegerCosts, NodeRow, Ranks, integer_costs, rows_from_tree, tree_from_rows
from octmip.trees.methods.checkpoint.envelope import (
    identity_of,
    read_checkpoint,
    seconds_of,
    tree_rows,
    unusable,
    whole,
    write_checkpoint,
)
from octmip.trees.methods.checkpoint.exact_state import grid_digest
from octmip.trees.methods.native_call import feasible_incumbent
from octmip.trees.problem import Problem
from octmip.trees.tree import Node

LEVEL = 1
"""Of the compression: nodes shrink to a fifth, and faster than a disk takes them."""


MOST_PACKED = 100
"""Times its size that a packed state may unpack to, at most."""


class Nodes(NamedTuple):
    """The state of a search: bytes, intervals of slopes, best cost and rows, bound, nodes; costs on its grid."""

    state: bytes
    n_intervals: int
    best: tuple[int, list[NodeRow]] | None
    bound: int
    n_nodes: int


@dataclass(slots=True)
class TwoFeatureKeeper:
    """Reads and writes the checkpoint of a two-feature proof.

    Attributes
    ----------
    problem, ranks
        the problem and its ranks.
    path
        of the file.
    every
        seconds between two times that it is written.
    options
        seed, largest whole coefficients, prunes that are off.
    started
        time of `time.perf_counter` at which this search began.
    incumbent
        the tree from which the search began, and the costs on their grid were made.
    """

    problem: Problem
    ranks: Ranks
    path: PathLike
    every: float
    options: tuple[object, ...]
    started: float
    incumbent: Node | None = None
    spent: float = 0.0

    def read(self) -> Nodes | None:
        """Return what the checkpoint holds, None where there is no file; `incumbent` becomes that of its search.

        Raises
        ------
        DataError
            it cannot be read or written, is damaged, or belongs to another search.
        """
        check_writable(self.path)
        found = read_checkpoint(self.path, self._identity(), _content)
        if found is None:
            return None
        self.spent, digest, incumbent, nodes = found
        try:
            self.incumbent = None if incumbent is None else self._tree(incumbent)
            costs = integer_costs(self.problem, self.incumbent)
            if digest != grid_digest(costs):
                raise unusable(self.path, "holds costs on another grid than its tree makes")
            best = nodes.best
            if best is not None and costs.whole_objective(self.problem, self._tree(best[1])) > best[0]:
                raise unusable(self.path, f"claims a tree of cost {best[0]} that costs more")
        except (ProblemError, IndexError) as error:
            raise unusable(self.path, f"holds a tree that is none of this problem ({error})") from error
        return nodes

    def write(self, costs: IntegerCosts, nodes: Nodes) -> None:
        """Write the checkpoint, whole or not at all."""
        state = {
            "seconds": self.spent + time.perf_counter() - self.started,
            "bound": costs.value(nodes.bound).hex(),
            "grid": grid_digest(costs),
            "incumbent": None if self.incumbent is None else rows_from_tree(self.incumbent, self.ranks),
            "nodes": [base64.b85encode(zlib.compress(nodes.state, LEVEL)).decode("ascii"), *nodes[1:]],
        }
        write_checkpoint(self.path, self._identity(), state)

    def _identity(self) -> dict[str, str]:
        options = hashlib.sha256(repr(self.options).encode()).hexdigest()
        return identity_of(self.problem, "two-feature exact", options)

    def _tree(self, rows: list[NodeRow]) -> Node:
        tree = feasible_incumbent(self.problem, tree_from_rows(rows, self.ranks))
        assert tree is not None
        return tree


def _content(content: Mapping[str, Any]) -> tuple[float, str, list[NodeRow] | None, Nodes]:
    """Return seconds, digest of the grid, incumbent and nodes of a checkpoint."""
    state, n_intervals, best, bound, n_nodes = content["nodes"]
    incumbent = content["incumbent"]
    try:
        packed, unpacker = base64.b85decode(state), zlib.decompressobj()
        found = unpacker.decompress(packed, MOST_PACKED * len(packed))
    except zlib.error as error:
        raise ValueError(f"its nodes cannot be unpacked: {error}") from error
    if not unpacker.eof:
        raise ValueError(f"its nodes unpack to more than {MOST_PACKED} times their size")
    nodes = Nodes(
        found,
        whole(n_intervals),
        None if best is None else (whole(best[0]), tree_rows(best[1], has_planes=True)),
        whole(bound),
        whole(n_nodes),
    )
    rows = None if incumbent is None else tree_rows(incumbent, has_planes=True)
    return seconds_of(content), str(content["grid"]), rows, nodes
