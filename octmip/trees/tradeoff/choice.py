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

The folds run through joblib (threads, processes, a Dask cluster) and come out the same unless a time limit strikes.
"""

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.input.messages import InWords
from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.nodes.tree import Node, depth
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Method, Run
from octmip.trees.tradeoff.family import Family, default_families, solve_in_family, trace_families
from octmip.trees.tradeoff.folds import Fold, checked_folds, fold_numbers, part_of, stratified_folds
from octmip.trees.tradeoff.path import MOST_SOLVES, PenaltyPath
from octmip.trees.tradeoff.repeats import counted
from octmip.trees.tradeoff.steps import Step, all_together, judged_steps
from octmip.trees.tradeoff.validation import Expectation, Nearness

Rule = Literal["least", "paired", "one_se"]
RULES: Mapping[Rule, Nearness] = {
    "least": Nearness(0.0),
    "paired": Nearness(0.5, is_paired=True),
    "one_se": Nearness(1.0),
}
"""How near the least validation cost the simplest is chosen."""
DEFAULT_RULE: Rule = "paired"
N_FOLDS = 5
DEFAULT_SOLVES = 3
"""Of each path of the default choice."""
PATH_WORK = 5e7
"""Nodes times readings that a solve of a path may take, some tenths of a second: a limit that no other work moves."""
SHARE_OF_PATHS = 0.7
"""Of the time limit of a default choice; the rest is the chosen tree's."""


@dataclass(frozen=True, slots=True, eq=False)
class Choice(InWords):
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
    n_left_out
        how many families had no time.
    """

    problem: Problem
    solution: Solution
    chosen: Step
    steps: tuple[Step, ...]
    paths: tuple[PenaltyPath, ...]
    fold: NDArray[np.int64]
    rule: Rule
    expectation: Expectation | None
    n_left_out: int

    def __repr__(self) -> str:
        """Return what was chosen, and from how much, on one line."""
        shape = self.problem.shape
        found = {"kind": self.chosen.kind, "depth": shape.depth, "leaf_penalty": shape.leaf_penalty}
        found |= {"rule": self.rule, "n_steps": len(self.steps), "n_paths": len(self.paths)}
        return f"Choice({', '.join(f'{name}={value!r}' for name, value in found.items())})"

    def __str__(self) -> str:
        """Return what was chosen, the cost to expect on new rows, and the tree."""
        rows = "" if self.expectation is None else self.expectation.words()
        return f"{self!r}\n{rows}\n\n{self.tree}"

    @property
    def tree(self) -> Node:
        """The tree."""
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
            "depth": self.problem.shape.depth,
            "leaf_penalty": self.problem.shape.leaf_penalty,
            "rule": self.rule,
            "n_folds": int(self.fold.max()) + 1,
            "validation_cost": step.validation_cost,
            "families": list(dict.fromkeys(step.kind for step in self.steps)),
            "families_left_out": self.n_left_out,
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
    stage: Callable[[str], None] | None = None,
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
        "least" validation cost, the simplest of equals; "one_se": the simplest within a standard error of it; "paired":
        the simplest whose cost exceeds it by half a standard error of the difference or less.
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
    stage
        called with the share that is done, in words.

    Raises
    ------
    ProblemError
        folds, depths or rule are not as described, a split has to stand, or training rows of a fold make no problem.
    SolverError
        a solver failed.
    KeyboardInterrupt
        Ctrl-C before the paths over all samples and over one fold are there. Later it leaves the choice among what is
        finished, by the folds that are, and `Stop.INTERRUPTED`.
    """
    from joblib import effective_n_jobs  # only here: every command would wait for it

    start = time.perf_counter()
    if not problem.shape.is_leaf_allowed:
        asked = "fixed_splits" if any(part.features for part in problem.shape.fixed_splits or ()) else "max_changes"
        raise ProblemError(
            f"choose_tree compares trees of every price of a split, down to a leaf, and {asked} allows no leaf; "
            "expected parts that a leaf has; give solve a depth or a leaf_penalty, or leave it out"
        )
    kinds = [Family(d, method) for d in _checked_depths(problem, depths)] if families is None else list(families)
    pairs = checked_folds(problem, folds) if isinstance(folds, Sequence) else stratified_folds(problem, folds, seed)
    if rule not in RULES:
        raise ProblemError(f"rule is {rule!r}; expected one of {', '.join(RULES)}")
    parts = [part_of(problem, rows, f"the training rows of fold {k}") for k, (rows, _) in enumerate(pairs)]
    options = options.of_study()
    # A fold is one task of a cluster, and is not divided any further.
    run = Run(method, limits, seed, options=replace(options, cluster=None))
    with options.opened(n_jobs) as shared:
        turns = math.ceil((len(parts) + 1) / effective_n_jobs(n_jobs))
        trace = partial(
            trace_families,
            families=kinds,
            run=run,
            most_solves=most_solves,
            seconds=SHARE_OF_PATHS * seconds / turns,
        )
        until = start + SHARE_OF_PATHS * seconds
        in_time = _in_time([problem, *parts], effective_n_jobs(n_jobs), until)
        traced, is_interrupted = _traced(in_time, len(parts) + 1, trace, n_jobs, stage or (lambda words: None))
        paths, of_folds, pairs = _usable(traced, pairs, is_interrupted)
        n_kinds = min(map(len, (paths, *of_folds)))  # those that all had time for
        judged = [
            judged_steps(problem, paths[f], kinds[f], [fold[f] for fold in of_folds], pairs) for f in range(n_kinds)
        ]
        steps = tuple(step for found, _ in judged for step in found)
        together = all_together([one for _, one in judged], steps)
        chosen = steps[together.best(RULES[rule])]
        final, known = _fitted(problem, chosen, paths[kinds.index(chosen.family)])
        ends = -math.inf if is_interrupted else start + seconds
        left = replace(limits, nodes=math.inf, seconds=max(0.0, min(limits.seconds, ends - time.perf_counter())))
        run = Run(method, left, seed, options=shared)
        solution = solve_in_family(final, chosen.family, run, known, limits.nodes)
    is_cart = np.array([step.family.method == "cart" for step in steps])
    expectation = together.expectation(RULES[rule], is_cart, seed)
    fold, n_left_out = fold_numbers(problem, pairs), len(kinds) - n_kinds
    choice = Choice(final, solution, chosen, steps, tuple(paths), fold, rule, expectation, n_left_out)
    stop = Stop.INTERRUPTED if is_interrupted else solution.stop
    details = {**solution.details, "choice": choice.to_json()}
    return replace(choice, solution=replace(solution, stop=stop, details=details))


def choose_default(
    problem: Problem,
    *,
    seconds: float = math.inf,
    seed: int = 0,
    n_jobs: int | None = None,
    options: Options = NO_OPTIONS,
    stage: Callable[[str], None] | None = None,
) -> Choice | None:
    """Return the tree that holds on new rows as far as five folds can tell; None where rows are too few to tell.

    A sample of weight 2 is as two of them (octmip.trees.tradeoff.repeats); the choice's `problem` holds them so. The
    families are those of `default_families`, the parameters those of `choose_tree`. A solve of a path is limited by its
    work and not by time, so one seed gives one tree wherever it runs, unless `seconds` strike.

    Raises
    ------
    ProblemError, SolverError, KeyboardInterrupt
        as `choose_tree`.
    """
    problem = counted(problem)
    pairs = _usable_folds(problem, seed)
    if len(pairs) < 2 or problem.baseline == 0:
        return None
    return choose_tree(
        problem,
        families=default_families(problem),
        folds=pairs,
        rule=DEFAULT_RULE,
        limits=Limits(nodes=max(100.0, PATH_WORK / problem.samples.features.size)),
        most_solves=DEFAULT_SOLVES,
        seconds=seconds,
        seed=seed,
        n_jobs=n_jobs,
        options=options,
        stage=stage,
    )


def _usable_folds(problem: Problem, seed: int) -> list[Fold]:
    """Return five folds but for those whose training rows make no problem, such as of one class only."""
    usable = []
    for train, held in (
        stratified_folds(problem, min(N_FOLDS, problem.samples.n_samples), seed)
        if problem.samples.n_samples > 1
        else ()
    ):
        try:
            part_of(problem, train, "the training rows")
        except ProblemError:
            continue
        usable.append((train, held))
    return usable if any(problem.samples.weights[held].any() for _, held in usable) else []


def _in_time(problems: Sequence[Problem], n_at_once: int, until: float) -> Iterator[Problem]:
    """Yield the problem of all rows, that of a fold, and those of other folds while one more is likely to end in time.

    The time is up at `until` [s of `time.perf_counter`].
    """
    start = time.perf_counter()
    for k, problem in enumerate(problems):
        now = time.perf_counter()
        if k >= max(2, n_at_once) and now + (now - start) * n_at_once / (k - n_at_once + 1) > until:
            return
        yield problem


def _traced(
    problems: Iterable[Problem],
    n_problems: int,
    trace: Callable[[Problem], list[PenaltyPath]],
    n_jobs: int | None,
    stage: Callable[[str], None],
) -> tuple[list[list[PenaltyPath]], bool]:
    """Return the finished paths of each problem, after Ctrl-C of the first ones only, and whether it was heard."""
    from joblib import Parallel, delayed

    found: list[list[PenaltyPath]] = []
    start = time.perf_counter()
    try:
        # Problems are asked for one after the other, each when a worker is free.
        parallel = Parallel(n_jobs=n_jobs, return_as="generator", pre_dispatch="n_jobs", batch_size=1)
        for paths in parallel(delayed(trace)(problem) for problem in problems):
            found.append([path for path in paths if not path.is_interrupted])
            if len(found[-1]) < len(paths):
                return found, True
            left = (time.perf_counter() - start) * (n_problems / len(found) - 1)
            stage(f"cross-validating, {len(found)} of {n_problems} fits done (all rows, each fold), {left:.0f} s left")
    except KeyboardInterrupt:
        return found, True
    return found, False


def _usable(
    traced: Sequence[list[PenaltyPath]], pairs: Sequence[Fold], is_interrupted: bool
) -> tuple[list[PenaltyPath], list[list[PenaltyPath]], list[Fold]]:
    """Return the paths over all samples, those of the folds that have as many, or any where none has, and these folds.

    Raises
    ------
    KeyboardInterrupt
        there is no fold with a path.
    """
    paths, of_folds = (traced[0], traced[1:]) if traced else ([], [])
    most = len(paths) if any(len(fold) >= len(paths) for fold in of_folds) else 1
    if not is_interrupted:
        most = 1  # a family for which one fold has no time is left out, not the fold
    usable = [k for k, fold in enumerate(of_folds) if len(fold) >= most]
    if not paths or not usable:
        raise KeyboardInterrupt
    return paths, [of_folds[k] for k in usable], [pairs[k] for k in usable]


def _checked_depths(problem: Problem, depths: Sequence[int] | None) -> list[int]:
    most = problem.shape.depth
    levels = sorted(set(range(1, most + 1) if depths is None else depths))
    if not levels or levels[0] < 1 or levels[-1] > most:
        raise ProblemError(f"depths is {depths!r}; expected one or more from 1 to {most}, the problem's depth")
    return levels


def _fitted(problem: Problem, chosen: Step, path: PenaltyPath) -> tuple[Problem, Node]:
    """Return the problem that a step means over all samples, and the tree of the path that answers it.

    A tree that was not proven seldom has all the levels it might: a proof among trees of as many as it has ends sooner.
    A price in impurity is none in cost: the problem of such a pruning has no penalty.
    """
    penalty = chosen.alpha * problem.baseline
    known = path.best_at(penalty).tree
    levels = max(1, depth(known)) if chosen.family.method in ("cart", "search") else chosen.depth
    return problem.replace(depth=levels, leaf_penalty=0.0 if chosen.family.by_impurity else penalty), known
