"""Choosing depth and leaf penalty by cross-validation, as Bertsimas & Dunn choose their alpha.

For every fold the penalty path of every depth is traced on the other folds: all the trees that are best for some alpha,
with the interval of alpha on which each is. So the mean validation cost is known for *every* alpha, a step function
whose steps are the ends of those intervals, and no grid has to be guessed:

    V(D, alpha) = sum over folds f of the cost on f of the best tree of the other folds at (D, alpha)  /  all weight

The pair of least V is chosen, alpha in the middle of its step, and the tree is fitted to all samples. alpha is the
penalty divided by the baseline (the cost of the best single leaf), so that one alpha means the same for any number of
samples. Sources: Bertsimas & Dunn (2017), Optimal classification trees, section 2.4; the rule of one standard error:
Breiman, Friedman, Olshen & Stone (1984), Classification and Regression Trees, section 3.4.3.

The folds are independent: they run through joblib, so in whatever `joblib.parallel_config` says (threads, processes, a
Dask cluster), and come out the same in all of them unless a time limit strikes.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.cluster import opened
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.problem import Problem
from octmip.trees.run import Run
from octmip.trees.solution import Limits, Solution
from octmip.trees.solver import Method, solve_run
from octmip.trees.tradeoff.folds import Fold, Rows, checked_folds, fold_numbers, part_of, stratified_folds
from octmip.trees.tradeoff.path import MOST_SOLVES, PenaltyPath, middle, trace_depths
from octmip.trees.tree import Node, predict

Rule = Literal["least", "one_se"]
RULES: tuple[Rule, ...] = ("least", "one_se")


@dataclass(frozen=True, slots=True)
class Step:
    """A depth and an interval of alpha on which the cross-validated cost does not change.

    Attributes
    ----------
    depth
        the depth.
    alpha_low, alpha_high
        ends of the interval; the last of each depth has no upper one (inf).
    validation_cost
        mean over all samples of weight * cost when they were not trained on, divided by mean weight.
    standard_error
        of that mean, from its spread over the folds; nan for one fold.
    complexity
        features summed over the splits of the tree fitted to all samples, in the middle of the interval.
    training_cost
        of that tree, per unit of weight like `validation_cost`.
    """

    depth: int
    alpha_low: float
    alpha_high: float
    validation_cost: float
    standard_error: float
    complexity: int
    training_cost: float

    @property
    def alpha(self) -> float:
        """The middle of the interval; twice its lower end where it has no upper one."""
        return middle(self.alpha_low, self.alpha_high)


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """The tree that cross-validation chooses, and everything that it was chosen from.

    Attributes
    ----------
    problem
        the problem with the depth and the leaf_penalty chosen, all samples.
    solution
        its solution.
    chosen
        the step that was chosen; its alpha is the penalty divided by the baseline of `problem`.
    steps
        every depth, ascending, with every interval of alpha, ascending: the whole tradeoff.
    paths
        for each depth the trees fitted to all samples.
    fold
        (n_samples,) the fold in which each sample was held out, -1 for those that never were.
    rule
        how it was chosen.
    """

    problem: Problem
    solution: Solution
    chosen: Step
    steps: tuple[Step, ...]
    paths: tuple[PenaltyPath, ...]
    fold: NDArray[np.int64]
    rule: Rule

    @property
    def tree(self) -> Node:
        """The tree."""
        assert self.solution.tree is not None  # solved from a tree
        return self.solution.tree

    def step_at(self, depth: int, alpha: float) -> Step:
        """Return the step of a depth and an alpha.

        Raises
        ------
        ProblemError
            the depth was not tried, or alpha is negative.
        """
        steps = [step for step in self.steps if step.depth == depth and step.alpha_low <= alpha]
        if not steps:
            tried = sorted({step.depth for step in self.steps})
            raise ProblemError(
                f"there is no step of depth {depth} and alpha {alpha}; expected a depth of {tried} and alpha >= 0"
            )
        return steps[-1]

    def table(self) -> list[dict[str, float | bool]]:
        """Return one row per step, plain numbers, for a data frame or a file."""
        names = ("depth", "alpha_low", "alpha_high", "validation_cost", "standard_error", "complexity", "training_cost")
        return [{**{name: getattr(step, name) for name in names}, "chosen": step is self.chosen} for step in self.steps]


def choose_tree(
    problem: Problem,
    depths: Sequence[int] | None = None,
    *,
    folds: int | Sequence[tuple[Sequence[int], Sequence[int]]] = 5,
    rule: Rule = "least",
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    most_solves: int = MOST_SOLVES,
    seed: int = 0,
    n_jobs: int | None = None,
    options: Options = NO_OPTIONS,
) -> Choice:
    """Return the tree of cross-validated depth and leaf penalty, fitted to all samples.

    Parameters
    ----------
    problem
        its `leaf_penalty` is not used; its `depth` is the largest that is tried.
    depths
        the depths that are tried; None: 1 to the problem's.
    folds
        the number of stratified folds, or pairs of training and validation rows (B&D use a single pair).
    rule
        "least" validation cost, the simplest of equals; "one_se": the simplest within one standard error of it.
    method
        of `octmip.solve`.
    limits
        of each solve; there are at most (folds + 1) * depths * most_solves.
    most_solves
        of each path, see `trace_path`.
    seed
        of the folds and of every solve.
    n_jobs
        folds at a time, as joblib counts them; None: what `joblib.parallel_config` says, else one.
    options
        of the method, for instance ``restarts`` of the search; or ``cluster``, whose workers take the folds.

    Raises
    ------
    ProblemError
        folds, depths or rule are not as described, or the training rows of a fold make no problem.
    SolverError
        a solver failed.
    KeyboardInterrupt
        Ctrl-C; there is no choice from half the folds.
    """
    levels = _checked_depths(problem, depths)
    pairs = checked_folds(problem, folds) if isinstance(folds, Sequence) else stratified_folds(problem, folds, seed)
    if rule not in RULES or (rule == "one_se" and len(pairs) < 2):
        raise ProblemError(f"rule is {rule!r} with {len(pairs)} folds; expected 'least', or 'one_se' with 2 or more")
    trace = delayed(trace_depths)
    parts = [part_of(problem, rows, f"the training rows of fold {k}") for k, (rows, _) in enumerate(pairs)]
    # A fold is one task of a cluster, and is not divided any further.
    run = Run(method, limits, seed, options=options)
    own = replace(options, cluster=None)
    settings = {"method": method, "limits": limits, "most_solves": most_solves, "seed": seed, "options": own}
    with opened(options, n_jobs) as shared:
        *of_folds, paths = Parallel(n_jobs=n_jobs)(trace(part, levels, **settings) for part in (*parts, problem))
        if any(path.is_interrupted for traced in (*of_folds, paths) for path in traced):
            raise KeyboardInterrupt
        steps = tuple(step for d, path in enumerate(paths) for step in _steps(path, [f[d] for f in of_folds], pairs))
        chosen = _chosen(steps, rule)
        final = replace(problem, depth=chosen.depth, leaf_penalty=chosen.alpha * problem.baseline)
        known = paths[levels.index(chosen.depth)].best_at(final.leaf_penalty).tree
        solution = solve_run(final, replace(run, options=shared), known)
    return Choice(final, solution, chosen, steps, tuple(paths), fold_numbers(problem, pairs), rule)


def _checked_depths(problem: Problem, depths: Sequence[int] | None) -> list[int]:
    levels = sorted(set(range(1, problem.depth + 1) if depths is None else depths))
    if not levels or levels[0] < 1 or levels[-1] > problem.depth:
        raise ProblemError(f"depths is {depths!r}; expected one or more from 1 to {problem.depth}, the problem's depth")
    return levels


def _steps(path: PenaltyPath, of_folds: Sequence[PenaltyPath], pairs: Sequence[Fold]) -> Iterator[Step]:
    """Yield the steps of one depth; neighbours of equal validation cost are one."""
    problem = path.problem
    held = [rows for _, rows in pairs]
    weights = np.array([problem.weights[rows].sum() for rows in held])
    costs = [_held_costs(problem, fold, rows) for fold, rows in zip(of_folds, held, strict=True)]
    ends = sorted({c.penalty_low / f.problem.baseline for f in of_folds for c in f.trees})
    known: list[tuple[float, NDArray[np.float64]]] = []
    for low, high in pairwise([*ends, math.inf]):
        at = middle(low, high) if high > low else low
        cost = np.array([c[_index_at(f, at)] for f, c in zip(of_folds, costs, strict=True)])
        if not known or (cost != known[-1][1]).any():
            known.append((low, cost))
    for (low, cost), high in zip(known, [*(low for low, _ in known[1:]), math.inf], strict=True):
        tree = path.best_at(middle(low, high) * problem.baseline)
        mean, error = _mean_and_error(cost, weights)
        weight = float(problem.weights.sum())
        yield Step(problem.depth, low, high, mean, error, tree.complexity, tree.cost / weight)


def _held_costs(problem: Problem, path: PenaltyPath, rows: Rows) -> NDArray[np.float64]:
    """Return the cost on the held-out rows of every tree of a path, shape (n_trees,)."""
    codes, weights = problem.codes[rows], problem.weights[rows]
    predicted = (predict(best.tree, problem.features[rows]) for best in path.trees)
    return np.array([math.fsum(weights * problem.costs[codes, labels]) for labels in predicted])


def _index_at(path: PenaltyPath, alpha: float) -> int:
    """Return the index of the tree that is best at an alpha of the path's own problem."""
    lows = [best.penalty_low for best in path.trees]
    return bisect_right(lows, alpha * path.problem.baseline) - 1


def _mean_and_error(cost: NDArray[np.float64], weights: NDArray[np.float64]) -> tuple[float, float]:
    """Return the cost per unit of weight over all the folds, and its standard error from the spread between them."""
    mean = math.fsum(cost) / math.fsum(weights)
    if len(cost) < 2:
        return mean, math.nan
    # Folds of unequal weight count by their share (a ratio estimate); equal ones give the usual std / sqrt(n).
    n = len(cost)
    residual = (cost - mean * weights) / weights.mean()
    return mean, float(np.sqrt((residual**2).sum() / (n * (n - 1))))


def _chosen(steps: Sequence[Step], rule: Rule) -> Step:
    least = min(steps, key=lambda step: step.validation_cost)
    most = least.validation_cost + (least.standard_error if rule == "one_se" else 0.0)
    good = [step for step in steps if step.validation_cost <= most]
    return min(good, key=lambda step: (step.complexity, step.depth, step.validation_cost, -step.alpha_low))
