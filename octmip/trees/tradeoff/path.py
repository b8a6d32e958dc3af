"""The penalty path: the best tree for every price of a split, with its proof.

    z(lambda) = min over trees T of  R(T) + lambda C(T),     R cost without a penalty, C features summed over splits

is a minimum of straight lines: concave, piecewise linear, never falling. Its pieces are the trees on the lower convex
hull of the points (C, R); no other tree is best for any penalty, so the others are dropped. A hull is found by solving
at the slopes between trees already on it: either a tree below the line appears and the edge divides in two, or the edge
is there to stay. V trees of an exact method take at most 2 V + 1 solves, and none is missed.
Source: Eisner & Severance (1976), Mathematical techniques for efficient record segmentation in large shared databases.

The mixed-integer forms go another way, because a small alpha beside error counts is lost in HiGHS's tolerances: not the
penalty is varied but the number of splits, C = 1, 2, ...: minimise R subject to C(T) <= C.
Source: Bertsimas & Dunn (2017), Optimal classification trees, section 2.4; alpha = lambda / baseline.

CART is grown once, and its prunings are the path (octmip.trees.methods.pruning).

Every solve starts from the best tree found so far, those of smaller depth included. Where the number of splits is
varied, CART's tree and one of search are found first, and of all trees known the best pruning to that number is the
start: so no point of the path is worse than CART.
"""

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.encoding.costs import rounded_down
from octmip.trees.methods.options import NO_OPTIONS, MipOptions, Options, SearchOptions
from octmip.trees.methods.ordering import ordered
from octmip.trees.methods.pruning import priced_prunings, pruned, prunings
from octmip.trees.nodes.prediction import predict, predict_values
from octmip.trees.nodes.tree import Node, complexity
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Method, Run, chosen_method
from octmip.trees.runs.solver_call import FIRST_RESTARTS, SEARCH_SHARE
from octmip.trees.solver import solve_run

BY_SPLITS = ("oct", "oct_h", "flow")
MOST_SOLVES = 32
_ROUNDING = Fraction(1, 2**50)  # of an objective: it is rounded three times


@dataclass(frozen=True, slots=True)
class PathTree:
    """A tree that is best for an interval of penalties.

    Attributes
    ----------
    tree
        the tree.
    cost
        sum of weights * costs over the training samples, no penalty.
    complexity
        features summed over its splits.
    penalty_low, penalty_high
        for `Shape.leaf_penalty` between these it is the best of all.
    is_proven
        whether no tree of the problem is better for any penalty of the interval (by more than rounding).
    """

    tree: Node
    cost: float
    complexity: int
    penalty_low: float
    penalty_high: float
    is_proven: bool

    @property
    def penalty(self) -> float:
        """The middle of the interval; twice its lower end where it has no upper one."""
        return middle(self.penalty_low, self.penalty_high)


@dataclass(frozen=True, slots=True, eq=False)
class PenaltyPath:
    """The best trees of one problem for every penalty.

    Attributes
    ----------
    problem
        the problem, `leaf_penalty` 0.
    trees
        by rising penalty, so from the largest tree to the single leaf.
    bounds
        (penalty, lower bound of z there) of what was solved, by rising penalty; -inf without a proof.
    n_solves
        how many solves it took.
    is_whole
        whether every edge of the hull was looked at; False when `most_solves` or Ctrl-C ended it before.
    is_interrupted
        whether Ctrl-C ended it.
    """

    problem: Problem
    trees: tuple[PathTree, ...]
    bounds: tuple[tuple[float, float], ...]
    n_solves: int
    is_whole: bool
    is_interrupted: bool

    def best_at(self, penalty: float) -> PathTree:
        """Return the best tree for a penalty; where two are equally good, the smaller tree.

        Raises
        ------
        ProblemError
            the penalty is negative or not a number.
        """
        if not penalty >= 0:
            raise ProblemError(f"penalty is {penalty}; expected a number of 0 or more; correct it")
        return next(c for c in reversed(self.trees) if c.penalty_low <= penalty)

    def bound_at(self, penalty: float) -> float:
        """Return a lower bound of z at a penalty: z is concave, so above the chord between any two of its bounds."""
        bound = _bound_at(self.bounds, penalty)
        return rounded_down(bound) if isinstance(bound, Fraction) else bound


def trace_path(
    problem: Problem,
    *,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    incumbents: Iterable[Node] = (),
    most_solves: int = MOST_SOLVES,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: Options = NO_OPTIONS,
) -> PenaltyPath:
    """Return the trees that are best for some penalty.

    Parameters
    ----------
    problem
        its `leaf_penalty` is not used.
    method
        of `octmip.solve`; methods that prove give proven intervals.
    limits
        of each solve.
    incumbents
        trees of this problem, taken into account from the beginning.
    most_solves
        the path ends after so many solves; the edges of the hull that could gain most come first.
    seed, n_jobs, progress, options
        of each solve.

    Raises
    ------
    ProblemError
        `most_solves` is below 1, or the method does not fit the problem.
    SolverError
        a solver failed.
    """
    return trace_run(problem, Run(method, limits, seed, n_jobs, options, progress), incumbents, most_solves)


def trace_run(
    problem: Problem,
    run: Run,
    incumbents: Iterable[Node] = (),
    most_solves: int = MOST_SOLVES,
    grown: Solution | None = None,
    least_width: int = 1,
) -> PenaltyPath:
    """Return what `trace_path` returns (and raise what it raises) for the fields of a run.

    Of method "cart" `grown` is the tree to prune, where it is there already. Of methods that vary the penalty an edge
    of the hull is looked at where its trees differ by `least_width` in complexity: with 2 no solve is spent where no
    tree can lie between the two, and the path is seldom whole.
    """
    if most_solves < 1:
        raise ProblemError(f"most_solves is {most_solves}; expected 1 or more; raise it")
    free = problem.replace(leaf_penalty=0.0)
    with run.options.of_study().opened(run.n_jobs) as options:
        tracer = _Tracer(free, replace(run, options=options), grown)
        for tree in (free.best_leaf(), *incumbents):
            tracer.add(tree)
        name = chosen_method(problem, run.method)
        if name in BY_SPLITS or name == "cart":
            is_whole = (tracer.by_pruning if name == "cart" else tracer.by_splits)(most_solves)
        else:
            is_whole = tracer.by_penalty(most_solves, least_width)
    return tracer.path(is_whole)


def trace_impurity(problem: Problem, run: Run, grown: Solution) -> PenaltyPath:
    """Return the prunings of CART's grown tree by its Gini impurity, whose price takes the place of the penalty.

    Trees of equal cost differ in it, so it keeps splits which the cost cuts away first. Nothing is proven.
    """
    free, start = problem.replace(leaf_penalty=0.0), time.perf_counter()
    found = [(0.0, grown.tree), *priced_prunings(free, grown.tree, by_impurity=True)]
    ends = [*(price for price, _ in found), math.inf]
    trees = []
    for (_, tree), (low, high) in zip(found, pairwise(ends), strict=True):
        if low < high:
            trees.append(PathTree(tree, _objective(free, tree), complexity(tree), low, high, False))
        if time.perf_counter() > start + run.limits.seconds:
            break
    return PenaltyPath(free, tuple(trees), (), 1, len(trees) == len(found), grown.stop is Stop.INTERRUPTED)


def _objective(problem: Problem, tree: Node) -> float:
    """Return the objective of a tree, the samples routed by the native core: the same number, sooner for many rows."""
    route = predict if problem.loss.predicts == "class" else predict_values
    return problem.objective_of(tree, route(tree, problem.samples.features))


def middle(low: float, high: float) -> float:
    """Return the middle of an interval of penalties; twice `low` where it has no upper end."""
    return (low + high) / 2 if math.isfinite(high) else 2 * low


@dataclass(frozen=True, slots=True)
class _Vertex:
    """A tree and its point of the hull."""

    complexity: int
    cost: float
    tree: Node

    def slope_to(self, smaller: "_Vertex") -> float:
        """Return the penalty at which a smaller tree costs the same."""
        return (smaller.cost - self.cost) / (self.complexity - smaller.complexity)

    def price(self, penalty: float) -> float:
        return self.cost + penalty * self.complexity


@dataclass(slots=True)
class _Tracer:
    """The search for the hull of one problem; its known trees and bounds only grow."""

    free: Problem
    run: Run  # of every solve
    grown: Solution | None  # CART's tree, where it is there already
    best: dict[int, _Vertex] = field(default_factory=dict)  # by complexity
    bounds: dict[float, float] = field(default_factory=dict)  # by penalty
    tolerance: float = 0.0
    n_solves: int = 0
    is_interrupted: bool = False

    def add(self, tree: Node) -> None:
        tree = ordered(self.free, tree)  # a pruning need not keep the order that its tree keeps
        known = _Vertex(complexity(tree), _objective(self.free, tree), tree)
        if known.complexity not in self.best or known.cost < self.best[known.complexity].cost:
            self.best[known.complexity] = known

    def by_penalty(self, most_solves: int, least_width: int) -> bool:
        """Divide the edges of the hull, the largest first; return whether all have been looked at."""
        self._solve_at(0.0)
        while not self.is_interrupted:
            hull = self.hull()
            edges = [(a, b) for a, b in pairwise(hull) if a.slope_to(b) not in self.bounds]
            wide = [(a, b) for a, b in edges if a.complexity - b.complexity >= least_width]
            if not wide or self.n_solves >= most_solves:
                return not edges
            # No tree between two neighbours of the hull can lie outside their triangle; its legs say how large it is.
            larger, smaller = max(wide, key=lambda e: (e[0].complexity - e[1].complexity) * (e[1].cost - e[0].cost))
            self._solve_at(larger.slope_to(smaller))
        return False

    def by_splits(self, most_solves: int) -> bool:
        """Allow one split more at a time; return whether all numbers of splits have been solved."""
        bounds = [(0, self.free.baseline)]  # without a split there is only the leaf
        largest = (2**self.free.shape.depth - 1) * self.free.shape.max_split_size
        largest = largest if self.free.shape.max_splits is None else min(largest, self.free.shape.max_splits)
        if not self._first_trees():
            return False
        options = self.run.options.of_kind(MipOptions, f"method {self.run.method!r}", without=("cluster",))
        for most in range(1, min(largest, most_solves) + 1):
            starts = [pruned(self.free, known.tree, most) for known in self.best.values()]
            start = min(starts, key=lambda tree: (self.free.objective(tree), complexity(tree)))
            solution = self._solve(self.free.replace(max_splits=most), start, options)
            # Fewer splits are allowed too, so bounds of larger numbers hold for smaller ones; never the other way.
            bounds.append((most, solution.bound))
            if self.is_interrupted:
                return False
        if largest > most_solves:
            return False  # nothing is known of larger trees
        for penalty in (0.0, *(a.slope_to(b) for a, b in pairwise(self.hull()))):
            at = [Fraction(bound) + Fraction(penalty) * count for count, bound in bounds if math.isfinite(bound)]
            self.bounds[penalty] = rounded_down(min(at)) if len(at) == len(bounds) else -math.inf
        return True

    def by_pruning(self, _: int) -> bool:
        """Add the prunings of one tree until the time is up; return whether all are there."""
        start = time.perf_counter()
        grown = self.grown or self._solve(self.free, self.free.best_leaf(), self.run.options)
        self.is_interrupted |= grown.stop is Stop.INTERRUPTED
        self.add(grown.tree)
        for tree in prunings(self.free, grown.tree):
            self.add(tree)
            if time.perf_counter() > start + self.run.limits.seconds:
                return False
        return not self.is_interrupted

    def _first_trees(self) -> bool:
        """Add the trees of CART and of a search that takes as long as before a proof; return whether Ctrl-C let it."""
        limits = replace(self.run.limits, seconds=SEARCH_SHARE * self.run.limits.seconds)
        kept = self.run.options.checkpoint
        cart = replace(self.run, method="cart", limits=limits, options=Options(checkpoint=kept))
        few = SearchOptions(checkpoint=kept, restarts=FIRST_RESTARTS)
        for run in (cart, replace(cart, method="search", options=few)):
            first = solve_run(self.free, run)
            if first.tree is not None:
                self.add(first.tree)
            self.is_interrupted |= first.stop is Stop.INTERRUPTED
        return not self.is_interrupted

    def _solve_at(self, penalty: float) -> None:
        start = min(self.best.values(), key=lambda known: (known.price(penalty), known.complexity)).tree
        solution = self._solve(self.free.replace(leaf_penalty=penalty), start, self.run.options)
        if not self.is_interrupted:
            self.bounds[penalty] = solution.bound

    def _solve(self, problem: Problem, start: Node, options: Options) -> Solution:
        solution = solve_run(problem, replace(self.run, options=options), start)
        self.n_solves += 1
        self.is_interrupted |= solution.stop is Stop.INTERRUPTED
        self.tolerance = max(self.tolerance, solution.tolerance)
        if solution.tree is not None:
            self.add(solution.tree)
        return solution

    def hull(self) -> list[_Vertex]:
        """Return the lower convex hull from the cheapest tree (the smallest of equals) to the single leaf."""
        at = min(self.best.values(), key=lambda known: (known.cost, known.complexity))
        hull = [at]
        while smaller := [known for known in self.best.values() if known.complexity < at.complexity]:
            at = min(smaller, key=lambda known: (hull[-1].slope_to(known), known.complexity))
            hull.append(at)
        return hull

    def path(self, is_whole: bool) -> PenaltyPath:
        hull, bounds = self.hull(), tuple(sorted(self.bounds.items()))
        ends = [0.0, *(a.slope_to(b) for a, b in pairwise(hull)), math.inf]
        trees = []
        for known, (low, high) in zip(hull, pairwise(ends), strict=True):
            # z is concave and the tree's line touches it at both ends of the interval, so all along it. Past the
            # last end nothing changes any more: the leaf has no split to pay for.
            finite = [penalty for penalty in (low, high) if math.isfinite(penalty)]
            is_proven = bool(bounds) and self._is_proven(known, finite)
            trees.append(PathTree(known.tree, known.cost, known.complexity, low, high, is_proven))
        return PenaltyPath(self.free, tuple(trees), bounds, self.n_solves, is_whole, self.is_interrupted)

    def _is_proven(self, known: _Vertex, penalties: Sequence[float]) -> bool:
        """Whether no tree is better at any of some penalties."""
        bounds = tuple(sorted(self.bounds.items()))
        if not any(math.isfinite(bound) for _, bound in bounds):  # of a search: the price need not be exact
            return False
        cost = self.free.exact_objective(known.tree)
        prices = [cost + Fraction(penalty) * known.complexity for penalty in penalties]
        return all(self._meets(_bound_at(bounds, at), price) for at, price in zip(penalties, prices, strict=True))

    def _meets(self, bound: Fraction | float, price: Fraction) -> bool:
        return bound >= price * (1 - _ROUNDING) - Fraction(self.tolerance)


def _bound_at(bounds: Sequence[tuple[float, float]], penalty: float) -> Fraction | float:
    """Return the best bound that concavity and monotony of z allow at a penalty from bounds elsewhere, exactly."""
    below = [(at, bound) for at, bound in bounds if at <= penalty]
    above = [(at, bound) for at, bound in bounds if at > penalty]
    known = [bound for _, bound in below if math.isfinite(bound)]
    best: Fraction | float = Fraction(max(known)) if known else -math.inf
    for low, bound_low in below:
        for high, bound_high in above:
            if math.isfinite(bound_low) and math.isfinite(bound_high):
                share = (Fraction(penalty) - Fraction(low)) / (Fraction(high) - Fraction(low))
                best = max(best, (1 - share) * Fraction(bound_low) + share * Fraction(bound_high))
    return best
