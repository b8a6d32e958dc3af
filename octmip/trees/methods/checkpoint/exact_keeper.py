"""Keeper: the checkpoint of one exact search, from its trees to rows on the problem's ranks and back."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from octmip.errors import ProblemError
from octmip.formats.files import check_writable
from octmip.trees.encoding import IntegerCosts, NodeRow, Ranks, integer_costs, rows_from_tree, tree_from_rows
from octmip.trees.methods.checkpoint.envelope import identity_of, read_checkpoint, unusable, write_checkpoint
from octmip.trees.methods.checkpoint.exact_state import Kept, KnownRow, grid_digest, kept_of, state_of
from octmip.trees.methods.native_call import feasible_incumbent, switched_off
from octmip.trees.problem import Problem
from octmip.trees.tree import Node


@dataclass(frozen=True, slots=True)
class Found:
    """What a search knows: its best tree, the tree that made its grid of costs, the state of the root, the bound."""

    tree: Node | None
    grid: Node | None
    known: KnownRow | None
    bound: float


@dataclass(slots=True)
class Keeper:
    """Reads and writes the checkpoint of a search that began at `started` (of `time.perf_counter`)."""

    problem: Problem
    ranks: Ranks
    path: str | Path
    started: float
    off: list[str] = field(default_factory=switched_off)
    spent: Kept | None = None  # by earlier searches

    def read(self) -> Found | None:
        """Return what the checkpoint holds, None where there is no file.

        Raises
        ------
        DataError
            it cannot be read or written, is damaged, or belongs to another search.
        """
        check_writable(self.path)
        found = read_checkpoint(self.path, self._identity(), lambda content: (kept_of(content), str(content["grid"])))
        if found is None:
            return None
        self.spent, digest = found
        try:
            grid, tree = (self._tree(rows) for rows in (self.spent.grid, self.spent.tree))
            costs = integer_costs(self.problem, grid)
            if digest != grid_digest(costs):
                raise unusable(self.path, "holds costs on another grid than its tree makes")
            known = self._known(costs, self.spent.known)
        except (ProblemError, IndexError) as error:
            raise unusable(self.path, f"holds a tree that is none of this problem ({error})") from error
        return Found(tree, grid, known, self.spent.bound)

    def write(self, costs: IntegerCosts, found: Found, n_nodes: int) -> None:
        """Write the checkpoint whole: the best tree within the budget, the root's state, what was spent in all."""
        best = found.tree
        if found.known is not None:
            known = tree_from_rows(found.known.best[1], self.ranks)
            if self.problem.sensor_cost_of(known) <= self.problem.sensor_limit:
                best = min((tree for tree in (known, best) if tree is not None), key=self.problem.objective)
            n_nodes = max(n_nodes, found.known.n_nodes)
        spent = self.spent or Kept(0.0, 0, -math.inf, None, None, None)
        kept = Kept(
            seconds=spent.seconds + time.perf_counter() - self.started,
            n_nodes=spent.n_nodes + n_nodes,
            bound=found.bound,
            tree=None if best is None else rows_from_tree(best, self.ranks),
            grid=None if found.grid is None else rows_from_tree(found.grid, self.ranks),
            known=found.known,
        )
        write_checkpoint(self.path, self._identity(), {"grid": grid_digest(costs)} | state_of(kept))

    def _identity(self) -> dict[str, str]:
        return identity_of(self.problem, "exact") | {"off": " ".join(sorted(self.off))}

    def _known(self, costs: IntegerCosts, row: KnownRow | None) -> KnownRow | None:
        """Return the root's state with the cost of its best tree counted again."""
        if row is None:
            return None
        best = self._tree(row.best[1], is_within=False)
        assert best is not None
        return row._replace(best=(costs.whole_objective(self.problem, best), rows_from_tree(best, self.ranks)))

    def _tree(self, rows: Sequence[NodeRow] | None, *, is_within: bool = True) -> Node | None:
        """Return the tree of a checkpoint's rows, refused where it is none of the problem."""
        if rows is None:
            return None
        tree = tree_from_rows(rows, self.ranks)
        return feasible_incumbent(self.problem if is_within else replace(self.problem, sensor_budget=None), tree)
