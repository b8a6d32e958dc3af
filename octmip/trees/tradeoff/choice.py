"""Choosing a tree by cross-validation: its kind, depth and leaf penalty, as Bertsimas & Dunn choose their alpha.

For every fold the penalty path of every family of trees (octmip.trees.tradeoff.family) is traced on the other folds:
all the trees that are best for some alpha, with the interval of alpha on which each is. So the mean validation cost is
known for *every* alpha, a step function whose steps are the ends of those intervals, and no grid has to be guessed:

    V(F, alpha) = sum over folds f of the cost on f of the best tree of the other folds at (F, alpha)  /  all weight

The pair of least V is chosen, or the simplest within some standard errors of it, alpha in the middle of its step, and
the tree is fitted to all samples. alpha is the penalty divided by the baseline (the cost of the best single leaf), so
that one alpha means the same for any number of samples. What the chosen tree costs on new rows is corrected for its
being chosen: octmip.trees.tradeoff.validation. Sources: Bertsimas & Dunn (2017), Optimal classification trees, section
2.4; the rule of one standard error: Breiman, Friedman, Olshen & Stone (1984), Classification and Regression Trees,
section 3.4.3.

The folds are independent: they run through joblib, so in whatever `joblib.parallel_config` says (threads, processes, a
Dask cluster), and come out the same in all of them unless a time limit strikes.
"""

import math
import time
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from joblib import Parallel, delayed, effective_n_jobs
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.trees.cluster import opened
from octmip.trees.methods.merging import merged
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.problem import Problem
from octmip.trees.run import Run
from octmip.trees.solution import Limits, Solution
from octmip.trees.solver import Method
from octmip.trees.tradeoff.family import Family, default_families, solve_in_family, trace_families
from octmip.trees.tradeoff.folds import Fold, Rows, checked_folds, fold_numbers, part_of, stratified_folds
from octmip.trees.tradeoff.path import MOST_SOLVES, PenaltyPath, middle
from octmip.trees.tradeoff.validation import Expectation, Judged
from octmip.trees.tree import Node, depth, predict, predict_values

Rule = Literal["least", "half_se", "one_se"]
RULES: Mapping[Rule, float] = {"least": 0.0, "half_se": 0.5, "one_se": 1.0}
"""Standard errors above the least validation cost within which the simplest is chosen."""
DEFAULT_RULE: Rule = "half_se"
N_FOLDS = 5
DEFAULT_SOLVES = 8
"""Of each path of the default choice."""
PATH_WORK = 5e7
"""Nodes times readings that a solve of a path may take, some tenths of a second: a limit that no other work moves."""
SHARE_OF_PATHS = 0.7
"""Of the time limit of a default choice; the rest is the chosen tree's."""


@dataclass(frozen=True, slots=True)
class Step:
    """A family of trees and an interval of alpha on which the cross-validated cost does not change.

    Attributes
    ----------
    family
        the kind of trees.
    alpha_low, alpha_high
        ends of the interval; the last of each depth has no upper one (inf).
    validation_cost
        mean over all samples of weight * cost when they were not trained on, divided by mean weight.
    standard_error
        of that mean, from the spread of the samples.
    complexity
        features summed over the splits of the tree fitted to all samples, in the middle of the interval.
    training_cost
        of that tree, per unit of weight like `validation_cost`.
    """

    family: Family
    alpha_low: float
    alpha_high: float
    validation_cost: float
    standard_error: float
    complexity: int
    training_cost: float

    @property
    def depth(self) -> int:
        """The depth of the family."""
        return self.family.depth

    @property
    def kind(self) -> str:
        """The family, in words."""
        return self.family.words

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
    expectation
        what the tree and CART, pruned by the same folds, cost on new rows; None where no rows are left to say.
    """

    problem: Problem
    solution: Solution
    chosen: Step
    steps: tuple[Step, ...]
    paths: tuple[PenaltyPath, ...]
    fold: NDArray[np.int64]
    rule: Rule
    expectation: Expectation | None

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

    def table(self) -> list[dict[str, float | bool | str]]:
        """Return one row per step, plain numbers, for a data frame or a file."""
        names = (
            "depth",
            "kind",
            "alpha_low",
            "alpha_high",
            "validation_cost",
            "standard_error",
            "complexity",
            "training_cost",
        )
        return [{**{name: getattr(step, name) for name in names}, "chosen": step is self.chosen} for step in self.steps]

    def to_json(self) -> dict[str, Any]:
        """Return what files and `--json` say of the choice."""
        step = self.chosen
        return {
            "kind": step.kind,
            "depth": self.problem.depth,
            "leaf_penalty": self.problem.leaf_penalty,
            "rule": self.rule,
            "n_folds": int(self.fold.max()) + 1,
            "validation_cost": step.validation_cost,
            "families": list(dict.fromkeys(step.kind for step in self.steps)),
            "expected": self.expectation and self.expectation.to_json(),
        }


def choose_tree(
    problem: Problem,
    depths: Sequence[int] | None = None,
    *,
    families: Sequence[Family] | None = None,
    folds: int | Sequence[tuple[ArrayLike, ArrayLike]] = 5,
    rule: Rule = "least",
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    most_solves: int = MOST_SOLVES,
    seconds: float = math.inf,
    seed: int = 0,
    n_jobs: int | None = None,
    options: Options = NO_OPTIONS,
) -> Choice:
    """Return the tree of cross-validated kind, depth and leaf penalty, fitted to all samples.

    Parameters
    ----------
    problem
        its `leaf_penalty` is not used; its `depth` is the largest that is tried.
    depths
        the depths that are tried; None: 1 to the problem's.
    families
        the kinds of trees that are tried, instead of `depths` and `method`; the problem's depth is not used then.
    folds
        the number of stratified folds, or pairs of training and validation rows (B&D use a single pair).
    rule
        "least" validation cost, the simplest of equals; "half_se", "one_se": the simplest within half a standard error
        of it, or one.
    method
        of `octmip.solve`.
    limits
        of each solve; there are at most (folds + 1) * depths * most_solves.
    most_solves
        of each path, see `trace_path`.
    seconds
        for everything together: families for which there is no time are left out, but for the first [s].
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
    start = time.perf_counter()
    kinds = [Family(d, method) for d in _checked_depths(problem, depths)] if families is None else list(families)
    pairs = checked_folds(problem, folds) if isinstance(folds, Sequence) else stratified_folds(problem, folds, seed)
    if rule not in RULES:
        raise ProblemError(f"rule is {rule!r}; expected one of {', '.join(RULES)}")
    parts = [part_of(problem, rows, f"the training rows of fold {k}") for k, (rows, _) in enumerate(pairs)]
    # A fold is one task of a cluster, and is not divided any further.
    run = Run(method, limits, seed, options=replace(options, cluster=None))
    with opened(options, n_jobs) as shared:
        turns = math.ceil((len(parts) + 1) / effective_n_jobs(n_jobs))
        tasks = (
            delayed(trace_families)(part, kinds, run, most_solves, SHARE_OF_PATHS * seconds / turns)
            for part in (*parts, problem)
        )
        traced = Parallel(n_jobs=n_jobs)(tasks)
        if any(path.is_interrupted for paths in traced for path in paths):
            raise KeyboardInterrupt
        *of_folds, paths = traced
        n_kinds = min(map(len, traced))  # those that all had time for
        judged = [_judged(problem, paths[f], kinds[f], [fold[f] for fold in of_folds], pairs) for f in range(n_kinds)]
        steps = tuple(step for found, _ in judged for step in found)
        together = _together([one for _, one in judged], steps)
        chosen = steps[together.best(RULES[rule])]
        final, known = _fitted(problem, chosen, paths[kinds.index(chosen.family)])
        left = replace(
            limits, nodes=math.inf, seconds=max(0.0, min(limits.seconds, start + seconds - time.perf_counter()))
        )
        solution = solve_in_family(final, chosen.family, Run(method, left, seed, options=shared), known)
    is_cart = np.array([step.family.method == "cart" for step in steps])
    expectation = together.expectation(RULES[rule], is_cart, seed)
    choice = Choice(final, solution, chosen, steps, tuple(paths), fold_numbers(problem, pairs), rule, expectation)
    return replace(choice, solution=replace(solution, details={**solution.details, "choice": choice.to_json()}))


def choose_default(
    problem: Problem,
    *,
    seconds: float = math.inf,
    seed: int = 0,
    n_jobs: int | None = None,
    options: Options = NO_OPTIONS,
) -> Choice | None:
    """Return the tree that holds on new rows as far as five folds can tell; None where rows are too few to tell.

    Equal samples are one of their common weight, so that none judges a tree which was trained on its like, and a sample
    of weight 2 is as two of them; the choice's `problem` holds them so. The families are those of `default_families`,
    the parameters those of `choose_tree`. A solve of a path is limited by its work and not by time, so one seed gives
    one tree wherever it runs, unless `seconds` strike.

    Raises
    ------
    ProblemError, SolverError, KeyboardInterrupt
        as `choose_tree`.
    """
    problem, _ = merged(problem)
    pairs = _usable_folds(problem, seed)
    if len(pairs) < 2 or problem.baseline == 0:
        return None
    return choose_tree(
        problem,
        families=default_families(problem),
        folds=pairs,
        rule=DEFAULT_RULE,
        limits=Limits(nodes=max(100.0, PATH_WORK / problem.features.size)),
        most_solves=DEFAULT_SOLVES,
        seconds=seconds,
        seed=seed,
        n_jobs=n_jobs,
        options=options,
    )


def _usable_folds(problem: Problem, seed: int) -> list[Fold]:
    """Return five folds but for those whose training rows make no problem, such as of one class only."""
    usable = []
    for train, held in (
        stratified_folds(problem, min(N_FOLDS, problem.n_samples), seed) if problem.n_samples > 1 else ()
    ):
        try:
            part_of(problem, train, "the training rows")
        except ProblemError:
            continue
        usable.append((train, held))
    return usable if any(problem.weights[held].any() for _, held in usable) else []


def _checked_depths(problem: Problem, depths: Sequence[int] | None) -> list[int]:
    levels = sorted(set(range(1, problem.depth + 1) if depths is None else depths))
    if not levels or levels[0] < 1 or levels[-1] > problem.depth:
        raise ProblemError(f"depths is {depths!r}; expected one or more from 1 to {problem.depth}, the problem's depth")
    return levels


def _fitted(problem: Problem, chosen: Step, path: PenaltyPath) -> tuple[Problem, Node]:
    """Return the problem that a step means over all samples, and the tree of the path that answers it.

    A tree that was not proven seldom has all the levels it might: a proof among trees of as many as it has ends sooner.
    """
    penalty = chosen.alpha * problem.baseline
    known = path.best_at(penalty).tree
    levels = max(1, depth(known)) if chosen.family.method in ("cart", "search") else chosen.depth
    return replace(problem, depth=levels, leaf_penalty=penalty), known


def _judged(
    problem: Problem, path: PenaltyPath, family: Family, of_folds: Sequence[PenaltyPath], pairs: Sequence[Fold]
) -> tuple[list[Step], Judged]:
    """Return the steps of one family, neighbours of equal validation cost as one, and what they were judged by."""
    held = [rows for _, rows in pairs]
    weights = [problem.weights[rows] for rows in held]
    losses = [_held_losses(problem, fold, rows) for fold, rows in zip(of_folds, held, strict=True)]
    costs = [np.array([math.fsum(column) for column in fold.T]) for fold in losses]
    ends = sorted({c.penalty_low / f.problem.baseline for f in of_folds for c in f.trees})
    known: list[tuple[float, list[int], NDArray[np.float64]]] = []
    for low, high in pairwise([*ends, math.inf]):
        at = [_index_at(f, middle(low, high) if high > low else low) for f in of_folds]
        cost = np.array([fold[k] for fold, k in zip(costs, at, strict=True)])
        if not known or (cost != known[-1][2]).any():
            known.append((low, at, cost))
    judged = Judged(losses, weights, np.array([at for _, at, _ in known]), np.arange(len(known)))
    sums, steps = judged.sums(), []
    ends_of = [*(low for low, _, _ in known[1:]), math.inf]
    means, errors = sums.means().tolist(), sums.standard_errors().tolist()
    for (low, _, _), high, mean, error in zip(known, ends_of, means, errors, strict=True):
        tree = path.best_at(middle(low, high) * problem.baseline)
        steps.append(Step(family, low, high, mean, error, tree.complexity, tree.cost / float(problem.weights.sum())))
    return steps, judged


def _together(judged: Sequence[Judged], steps: Sequence[Step]) -> Judged:
    """Return the steps of all families as one, ranked from the simplest; among equals by cost, proven before CART."""
    losses = [np.concatenate(fold, axis=1) for fold in zip(*(one.losses for one in judged), strict=True)]
    before = np.cumsum([[0] * len(losses), *([fold.shape[1] for fold in one.losses] for one in judged[:-1])], axis=0)
    trees = np.concatenate([one.trees + first for one, first in zip(judged, before, strict=True)])
    keys = [
        (step.complexity, step.validation_cost, step.family.method == "cart", step.depth, -step.alpha_low)
        for step in steps
    ]
    rank = np.empty(len(steps), dtype=np.int64)
    rank[sorted(range(len(steps)), key=keys.__getitem__)] = np.arange(len(steps))
    return Judged(losses, judged[0].weights, trees, rank)


def _held_losses(problem: Problem, path: PenaltyPath, rows: Rows) -> NDArray[np.float64]:
    """Return weight times cost of the held-out rows by every tree of a path, shape (n_rows, n_trees)."""
    part = problem.weights[rows], problem.codes[rows]
    how = predict if problem.loss.predicts == "class" else predict_values
    features = problem.features[rows]
    return np.stack([problem.loss.row_costs(*part, how(best.tree, features)) for best in path.trees], axis=1)


def _index_at(path: PenaltyPath, alpha: float) -> int:
    """Return the index of the tree that is best at an alpha of the path's own problem."""
    lows = [best.penalty_low for best in path.trees]
    return bisect_right(lows, alpha * path.problem.baseline) - 1
