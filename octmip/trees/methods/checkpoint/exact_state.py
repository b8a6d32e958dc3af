"""The state of an exact axis-aligned search as a checkpoint keeps it.

What was spent, the best tree, and the solved cuts of the root with lower bounds of both sides (`KnownRow`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from octmip.trees.encoding import NodeRow
from octmip.trees.methods.checkpoint.file import flag, tree_rows, whole

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
class ExactState:
    """The state of a search.

    Attributes
    ----------
    n_nodes
        cuts evaluated, of all the searches before it too.
    bound
        proven lower bound; -inf without one.
    tree
        rows of the best tree of the problem; None without one.
    known
        what is proven of the root; None before its search has begun.
    """

    n_nodes: int
    bound: float
    tree: Sequence[NodeRow] | None
    known: KnownRow | None

    def to_json(self) -> dict[str, Any]:
        """Return the state as the entries of a checkpoint."""
        return {"nodes": self.n_nodes, "bound": self.bound.hex(), "tree": self.tree, "known": self.known}


def exact_state_of(content: Mapping[str, Any]) -> ExactState:
    """Return the state of an exact search that the object of a checkpoint holds.

    Raises
    ------
    ValueError, KeyError, TypeError
        it holds something else.
    """
    bound = float.fromhex(content["bound"])
    if math.isnan(bound) or bound == math.inf:
        raise ValueError(f"bound {bound}")
    tree = None if content["tree"] is None else tree_rows(content["tree"])
    known = None if content["known"] is None else _known(content["known"])
    return ExactState(whole(content["nodes"]), bound, tree, known)


def _known(row: Any) -> KnownRow:
    row = KnownRow(*row)
    objective, rows = row.best
    return KnownRow(
        level=whole(row.level),
        whole=whole(row.whole),
        order=[(whole(cost), whole(place)) for cost, place in row.order],
        incumbents=[(whole(cost), whole(place)) for cost, place in row.incumbents],
        cuts=[(whole(f), whole(k), whole(left), whole(right)) for f, k, left, right in row.cuts],
        bound=whole(row.bound),
        best=(whole(objective), tree_rows(rows)),
        sets=None if row.sets is None else [(_flags(held), _flags(banned)) for held, banned in row.sets],
        n_nodes=whole(row.n_nodes),
    )


def _flags(flags: Any) -> list[bool]:
    return [flag(value) for value in flags]
