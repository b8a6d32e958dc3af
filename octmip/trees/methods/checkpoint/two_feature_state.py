"""The state of a two-feature proof: the open nodes of its search between two batches, and the best tree.

A search that goes on makes every batch that this one would have made, and so ends with the same tree and bound. The
nodes are the native core's bytes, compressed: what they mean is known there alone.
"""

import base64
import zlib
from collections.abc import Mapping
from typing import Any, NamedTuple

from octmip.trees.encoding import IntegerCosts, NodeRow
from octmip.trees.methods.checkpoint.file import Checkpoint, tree_rows, unusable, whole

LEVEL = 1
"""Of the compression: nodes shrink to a fifth, and faster than a disk takes them."""
MOST_PACKED = 100
"""Times its size that a packed state may unpack to, at most."""


class TwoFeatureState(NamedTuple):
    """The state of a search: bytes, intervals of slopes, best cost and rows, bound, nodes; costs on its grid."""

    state: bytes
    n_intervals: int
    best: tuple[int, list[NodeRow]] | None
    bound: int
    n_nodes: int

    def to_json(self, costs: IntegerCosts) -> dict[str, Any]:
        """Return the state as the entries of a checkpoint."""
        packed = base64.b85encode(zlib.compress(self.state, LEVEL)).decode("ascii")
        return {"bound": costs.value(self.bound).hex(), "nodes": [packed, *self[1:]]}

    def check(self, checkpoint: Checkpoint, costs: IntegerCosts) -> None:
        """Raise a DataError where the best tree costs more than the state says."""
        if self.best is not None:
            cost, rows = self.best
            if costs.whole_objective(checkpoint.problem, checkpoint.tree(rows)) > cost:
                raise unusable(checkpoint.path, f"claims a tree of cost {cost} that costs more")


def two_feature_state_of(content: Mapping[str, Any]) -> TwoFeatureState:
    """Return the state that the object of a checkpoint holds.

    Raises
    ------
    ValueError, LookupError, TypeError
        it holds something else.
    """
    state, n_intervals, best, bound, n_nodes = content["nodes"]
    try:
        packed, unpacker = base64.b85decode(state), zlib.decompressobj()
        found = unpacker.decompress(packed, MOST_PACKED * len(packed))
    except zlib.error as error:
        raise ValueError(f"its nodes cannot be unpacked: {error}") from error
    if not unpacker.eof:
        raise ValueError(f"its nodes unpack to more than {MOST_PACKED} times their size")
    return TwoFeatureState(
        found,
        whole(n_intervals),
        None if best is None else (whole(best[0]), tree_rows(best[1])),
        whole(bound),
        whole(n_nodes),
    )
