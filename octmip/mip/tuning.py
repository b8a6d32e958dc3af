"""Tuning: which trees are optimal for some price of a split, by depth D and number of splits C.

A small alpha beside error counts is lost in HiGHS's tolerances. So the price is not varied; the number of splits is:

    for D = 1 .. depth, for C = 1 .. 2^D - 1:   minimise cost  subject to  sum_t d_t <= C   (OCT-H: sum_jt s_jt <= C)

each solved from the best tree found so far that it allows. A tree of cost R and complexity C is optimal for the
penalties lambda at which R + lambda C is least: the trees on the lower convex hull of the points (C, R). The others
are dropped. On a validation set the tree of least cost is chosen, and with it the middle of its interval of penalties.

Source: Bertsimas & Dunn (2017), Optimal classification trees, section 2.4; alpha = lambda / baseline.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, Protocol

from octmip.cart import greedy_tree
from octmip.errors import ProblemError
from octmip.mip.engine import objective_of, tidy
from octmip.mip.flow import solve_flow
from octmip.mip.oct import solve_oct
from octmip.mip.oct_h import solve_oct_h
from octmip.problem import Problem
from octmip.solution import Limits, Solution
from octmip.tree import Leaf, Node, complexity, depth


class _Solver(Protocol):
    def __call__(
        self,
        problem: Problem,
        *,
        limits: Limits,
        incumbent: Node | None,
        seed: int,
        n_jobs: int,
        max_splits: int | None,
    ) -> Solution: ...


_SOLVERS: dict[str, _Solver] = {"flow": solve_flow, "oct": solve_oct, "oct_h": solve_oct_h}


@dataclass(frozen=True, slots=True)
class Candidate:
    """A tree that is best for an interval of penalties.

    Attributes:
        tree: the tree.
        cost: sum of weights * costs over the training samples, no penalty.
        complexity: features summed over its splits.
        penalty_low, penalty_high: between these `Problem.leaf_penalty` the tree is the best of all candidates.
        validation_cost: the same cost on the validation samples; nan without them.
        is_proven: whether no tree of its depth and complexity costs less (over the scope of the method).
    """

    tree: Node
    cost: float
    complexity: int
    penalty_low: float
    penalty_high: float
    validation_cost: float
    is_proven: bool


@dataclass(frozen=True, slots=True)
class Tuning:
    """The candidates by falling complexity, which one is chosen, and what was solved on the way.

    Attributes:
        candidates: trees that are best for some penalty.
        chosen: the one of least validation cost (training cost without validation), the simplest of equals.
        penalty: middle of its interval; alpha is this divided by the problem's baseline.
        solved: (depth, C, cost, bound) of each problem, in order.
    """

    candidates: tuple[Candidate, ...]
    chosen: Candidate
    penalty: float
    solved: tuple[tuple[int, int, float, float], ...]


def tune(
    problem: Problem,
    validation: Problem | None = None,
    *,
    method: Literal["flow", "oct", "oct_h"] = "flow",
    most_splits: int | None = None,
    limits: Limits = Limits(),  # noqa: B008  (frozen)
    seed: int = 0,
    n_jobs: int = 1,
) -> Tuning:
    """Return the trees that are best for some penalty, over all depths up to the problem's and all numbers of splits.

    Args:
        problem: its `leaf_penalty` is not used.
        validation: samples of the same features and class_names to choose by.
        most_splits: the largest C; None: 2^depth - 1.
        limits: of each problem that is solved.

    Raises:
        ProblemError: the validation samples do not fit the problem.
        SolverError: HiGHS failed.
    """
    if validation is not None and (
        validation.n_features != problem.n_features or validation.class_names != problem.class_names
    ):
        raise ProblemError(
            f"validation has {validation.n_features} features and classes {validation.class_names} but the problem has "
            f"{problem.n_features} and {problem.class_names}; give both the same, class_names included"
        )
    free = replace(problem, leaf_penalty=0.0)
    pool: dict[int, tuple[float, Node, bool]] = {0: _scored(free, Leaf(int(free.class_costs().argmin())), True)}
    solved = []
    for level, most in _steps(problem.depth, most_splits):
        at_level = replace(free, depth=level)
        start = _best_start(at_level, pool, most, seed)
        solution = _SOLVERS[method](at_level, limits=limits, incumbent=start, seed=seed, n_jobs=n_jobs, max_splits=most)
        solved.append((level, most, solution.objective, solution.bound))
        assert solution.tree is not None
        entry = _scored(free, tidy(free, solution.tree), solution.is_optimal)
        pool[most] = min(pool.get(most, entry), entry, key=lambda scored: scored[0])
    candidates = tuple(_hull(pool, validation))
    chosen = min(candidates, key=lambda c: (c.validation_cost if validation else c.cost, c.complexity))
    high = chosen.penalty_high if math.isfinite(chosen.penalty_high) else 2 * chosen.penalty_low
    return Tuning(candidates, chosen, (chosen.penalty_low + high) / 2, tuple(solved))


def _steps(deepest: int, most_splits: int | None) -> Iterator[tuple[int, int]]:
    for level in range(1, deepest + 1):
        for most in range(1, 2**level):
            if most_splits is None or most <= most_splits:
                yield level, most


def _scored(problem: Problem, tree: Node, is_proven: bool) -> tuple[float, Node, bool]:
    return objective_of(problem, tree), tree, is_proven


def _best_start(problem: Problem, pool: dict[int, tuple[float, Node, bool]], most: int, seed: int) -> Node:
    """Return the best tree known that the problem allows: of CART and all found so far."""
    greedy = greedy_tree(problem, seed=seed).tree
    assert greedy is not None
    known = [tidy(problem, greedy), *(tree for _, tree, _ in pool.values())]
    allowed = [tree for tree in known if depth(tree) <= problem.depth and complexity(tree) <= most]
    return min(allowed, key=lambda tree: (objective_of(problem, tree), complexity(tree)))


def _hull(pool: dict[int, tuple[float, Node, bool]], validation: Problem | None) -> Iterator[Candidate]:
    """Yield the candidates on the lower convex hull of cost over complexity, from the largest tree to the leaf."""
    best: dict[int, tuple[float, Node, bool]] = {}
    for scored in pool.values():
        size = complexity(scored[1])
        if size not in best or scored[0] < best[size][0]:
            best[size] = scored
    size = min(best, key=lambda c: (best[c][0], c))
    low = 0.0
    while True:
        smaller = [(slope(best, size, other), other) for other in best if other < size]
        high, following = min(smaller, default=(math.inf, 0))
        cost, tree, is_proven = best[size]
        seen = objective_of(replace(validation, leaf_penalty=0.0), tree) if validation is not None else math.nan
        yield Candidate(tree, cost, size, low, high, seen, is_proven)
        if not smaller:
            return
        size, low = following, high


def slope(best: dict[int, tuple[float, Node, bool]], size: int, smaller: int) -> float:
    """Return the penalty at which a smaller tree costs the same as a larger one."""
    return (best[smaller][0] - best[size][0]) / (size - smaller)
