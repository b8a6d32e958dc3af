"""Families: the kinds of trees that cross-validation chooses among, each with the path of its best trees.

What generalises best differs from table to table: the best tree of few levels, proven; a deeper one that is searched;
CART's, pruned. Thresholds at few quantiles learn less by heart than thresholds anywhere, and are too coarse where rows
are many. So the last family has any depth and any threshold, and its search begins at the trees of all the others.
The families were settled on one half of 72 public tables and judged on the other: docs/results/tables.md.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from octmip.trees.answer.scope import within
from octmip.trees.answer.solution import Solution
from octmip.trees.encoding import Coarse
from octmip.trees.methods.cart import greedy_solution
from octmip.trees.methods.options import Options, SearchOptions
from octmip.trees.nodes.tree import Node, depth
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import MAX_DEPTH
from octmip.trees.runs.registry import Method, Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff.path import PenaltyPath, trace_impurity, trace_run

PROVEN_DEPTHS, PROVEN_CUTS = (3, 4), 5
SEARCHED_DEPTH, SEARCHED_CUTS = 8, 10
CUTS_OF_NUMBERS = 10
UNPROVEN_DEPTHS = (1, 2, 3)
"""Of hyperplanes and linear leaves."""
MOST_BOUND_SECONDS = 10.0
"""For the bound of a searched tree; without a limit its proof could take for ever."""
SOLVES_OF_BOUND = 20
"""It may take the nodes of so many solves of a path."""
SPLITS_OF_CART = 20
"""So many may CART's tree have for each node that a search may take: a split is that much less work."""


@dataclass(frozen=True, slots=True)
class Family:
    """Trees of one kind.

    Attributes
    ----------
    depth
        levels of splits.
    method
        of `octmip.solve`, by which each tree of the path is found; "cart": the prunings of CART's tree.
    n_cuts
        a feature is cut at so many quantiles at most; None: anywhere.
    options
        of the method, instead of those of the run but for its cluster and checkpoint.
    by_impurity
        CART's tree is pruned by its Gini impurity, as scikit-learn prunes it, and not by its cost.
    """

    depth: int
    method: Method
    n_cuts: int | None = None
    options: Options | None = None
    by_impurity: bool = False

    @property
    def words(self) -> str:
        """The kind of trees, for a sentence."""
        if self.method == "cart":
            return "CART's tree, pruned by impurity" if self.by_impurity else "CART's tree, pruned"
        found = "searched" if self.method == "search" else "optimal"
        levels = "any depth" if self.depth == MAX_DEPTH else f"depth {self.depth} or less"
        cuts = "" if self.n_cuts is None else f", at most {self.n_cuts} cuts of a feature"
        return f"{found}, {levels}{cuts}"

    def run(self, run: Run) -> Run:
        """Return a run of this method: the options of the family beside those of the run."""
        shared = {"cluster": run.options.cluster, "checkpoint": run.options.checkpoint}
        options = run.options if self.options is None else replace(self.options, **shared)
        return replace(run, method=self.method, options=options)


def default_families(problem: Problem) -> tuple[Family, ...]:
    """Return the families that the default choice is made among; those that are quickest come first.

    Of numbers deep trees are CART's alone: a search of them takes a hundred times as long as one of classes.
    """
    is_class = problem.loss.predicts == "class"
    is_plain = problem.shape.split == "axis" and problem.shape.leaf_model == "constant"
    quick = SearchOptions(restarts=1, perturbations=0 if is_class else None)
    if is_plain:
        found = [Family(depth, "exact", PROVEN_CUTS if is_class else CUTS_OF_NUMBERS) for depth in PROVEN_DEPTHS]
        if is_class:
            found += [Family(SEARCHED_DEPTH, "search", SEARCHED_CUTS, quick), Family(MAX_DEPTH, "search", None, quick)]
    else:
        found = [Family(depth, "search", None, quick) for depth in UNPROVEN_DEPTHS]
    by_impurity = [Family(MAX_DEPTH, "cart", by_impurity=True)] if is_class else []
    return (Family(MAX_DEPTH, "cart"), *by_impurity, *found)


def trace_families(
    problem: Problem, families: Sequence[Family], run: Run, most_solves: int, seconds: float = math.inf
) -> list[PenaltyPath]:
    """Return the path of each family, begun with the trees of those before that belong to it too.

    Paths are over the readings of the problem; what a path of few cuts proves it proves among trees that cut there.

    Parameters
    ----------
    seconds
        families that have not begun by then, and those that have not ended, have no path [s]; the first always ends,
        as steps of paths that were cut short would not stand for equal trees.

    Raises
    ------
    ProblemError, SolverError
        as `trace_path`.
    """
    start = time.perf_counter()
    paths: list[PenaltyPath] = []
    known: dict[int | None, list[Node]] = {}
    grown: Solution | None = None  # CART's tree, which its families prune
    grids: dict[int, Coarse] = {}
    for family in families:
        left = start + seconds - time.perf_counter()
        if paths and left <= 0:
            break
        n_cuts, free = family.n_cuts, problem.replace(depth=family.depth, leaf_penalty=0.0)
        if n_cuts is not None and n_cuts not in grids:
            grids[n_cuts] = Coarse.of(problem, n_cuts)
        cut = free if n_cuts is None else (grids[n_cuts].problem).replace(depth=family.depth)
        own_seconds = max(0.0, min(run.limits.seconds, left)) if paths else run.limits.seconds
        limits = replace(run.limits, seconds=own_seconds)
        if family.method == "cart":
            limits = replace(limits, nodes=SPLITS_OF_CART * limits.nodes)
        limited = family.run(replace(run, limits=limits))
        if family.method == "cart" and grown is None:
            within = replace(limits, seconds=max(0.0, min(limits.seconds, left)))
            grown = solve_run(cut, replace(limited, limits=within))
        own = [tree for tree in known.get(n_cuts, ()) if depth(tree) <= family.depth]
        path = (
            trace_impurity(cut, limited, grown)
            if family.by_impurity and grown is not None
            else trace_run(cut, limited, own, most_solves, grown, least_width=2)
        )
        if paths and time.perf_counter() > start + seconds:
            break
        known[n_cuts] = [*known.get(n_cuts, ()), *(best.tree for best in path.trees)]
        if n_cuts is not None:
            over = grids[n_cuts].over_readings
            path = replace(path, problem=free, trees=tuple(replace(t, tree=over(t.tree)) for t in path.trees))
            known[None] = [*known.get(None, ()), *(best.tree for best in path.trees)]
        paths.append(path)
        if path.is_interrupted:
            break
    return paths


def solve_in_family(
    problem: Problem, family: Family, run: Run, known: Node, nodes_of_path: float = math.inf
) -> Solution:
    """Return the best tree of a family for a problem with its depth; `known` is one over readings, at least as good.

    A bound holds for the trees that cut where the family does, and `details["scope"]` says so; where that is, for each
    feature, stands in `details["cuts"]`. Of CART's prunings `known` itself is returned. Where a tree is searched, a
    proof gives the bound, and its tree where it is finished: for some seconds, in so many times `nodes_of_path`, what a
    solve of the path might take.

    Raises
    ------
    SolverError
        a solver failed.
    """
    if family.method == "cart":
        return _bounded(problem, greedy_solution(problem, known, run.seed), run, nodes_of_path, keeps_tree=True)
    grid = None if family.n_cuts is None else Coarse.of(problem, family.n_cuts)
    cut, tree = (problem, known) if grid is None else (grid.problem, grid.over_intervals(known))
    found = solve_run(cut, family.run(run), tree)
    if family.method == "search":
        found = _bounded(cut, found, run, nodes_of_path)
    if grid is None:
        return found
    cuts = [places.tolist() for places in grid.cuts]
    scope = {} if math.isinf(found.bound) else {"scope": within(problem, grid.scope), "cuts": cuts}
    return replace(found, tree=grid.over_readings(found.tree), details={**found.details, **scope})


def _bounded(
    problem: Problem, found: Solution, run: Run, nodes_of_path: float, *, keeps_tree: bool = False
) -> Solution:
    """Return a solution with the bound of a proof that ends soon; proven optimal, the proof's own unless it is kept."""
    if problem.shape.split != "axis" or not problem.is_provable:
        return found
    seconds = max(0.0, min(MOST_BOUND_SECONDS, run.limits.seconds - found.seconds))
    if seconds == 0:
        return found
    limits = replace(run.limits, seconds=seconds, nodes=SOLVES_OF_BOUND * nodes_of_path)
    proof = solve_run(problem, replace(run, method="exact", limits=limits), found.tree)
    if proof.meets_bound and not keeps_tree:
        return proof
    # A proof that is cut off has found trees by the time that it had: kept is the tree that one seed always gives.
    return replace(found, bound=min(proof.bound, found.objective), seconds=found.seconds + proof.seconds)
