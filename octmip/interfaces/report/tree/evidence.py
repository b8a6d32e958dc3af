"""What the data say about a tree beyond its file: a recount, the greedy tree, lower depths, samples held out."""

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import pandas as pd

from octmip.formats.tree_file import TreeFile
from octmip.trees.answer.certificate import Certificate, certify
from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.evidence.proof import ProofReport
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.nodes.tree import Node, depth
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Run
from octmip.trees.tradeoff.baselines import baselines_of
from octmip.trees.tradeoff.edits import EditPrice, tree_edits
from octmip.trees.tradeoff.frontier import frontier_run
from octmip.trees.tradeoff.held_out import Samples, Score, score_of

SHARE_OF_EDITS = 0.1
ENSEMBLES = ("boosting", "forest")
MOST_VALUES = 1_000_000
"""Readings up to which both are trained within seconds."""


@dataclass(frozen=True, slots=True, eq=False)
class HeldOut:
    """Samples that no tree was trained on, and the trees that are judged by them.

    Attributes
    ----------
    source
        where they come from, for a sentence: "test.csv".
    samples
        the samples.
    tree, greedy
        the page's own trees.
    """

    source: str
    samples: Samples
    tree: Node
    greedy: Node

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return len(self.samples.codes)


@dataclass(frozen=True, slots=True)
class DepthPoint:
    """The best tree of one depth and its proven bound, and the greedy tree, None where it was not grown."""

    depth: int
    objective: float
    bound: float
    greedy_objective: float | None

    @property
    def is_proven(self) -> bool:
        """Whether no tree of this depth is better."""
        return self.bound >= self.objective


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """All that is known of a tree with its data at hand.

    Attributes
    ----------
    problem
        the training samples, and what was asked.
    certificate
        what was recounted.
    greedy, greedy_certificate
        the greedy tree of the same settings.
    depths
        depths from 1 on; empty where that was left out.
    seconds
        time limit of each shallower depth [s].
    held_out
        None without any.
    proof
        the checked log, None without one.
    table
        the rows as they stand in the user's table, its index their place there from 0; None where the features are all
        there is.
    ensembles
        by name what a forest and boosting lose on the samples held out: the price of a tree that can be read; empty
        where that was left out.
    edits
        by path what other columns at the first splits cost; empty where that was left out, or no search knows.
    """

    problem: Problem
    certificate: Certificate
    greedy: Solution
    greedy_certificate: Certificate
    depths: tuple[DepthPoint, ...] = ()
    seconds: float = 0.0
    held_out: HeldOut | None = None
    proof: ProofReport | None = None
    table: pd.DataFrame | None = None
    ensembles: Mapping[str, Score] = field(default_factory=dict)
    edits: Mapping[str, tuple[EditPrice, ...]] = field(default_factory=dict)


def gather(file: TreeFile, problem: Problem, *, seconds: float = 10.0) -> Evidence:
    """Return the evidence of a tree file and its training samples.

    Parameters
    ----------
    file
        the tree and its claims.
    problem
        its training samples.
    seconds
        time for trees of lower depth, all together [s], and a tenth of it for other splits; 0 leaves them out.

    Raises
    ------
    CertificateError
        the tree is not what its file claims.
    """
    free = problem.replace(fixed_splits=None, path_rules=None, old_tree=None, max_changes=None)
    greedy = greedy_tree(free, seed=file.solution.seed)  # it knows no parts
    out = Evidence(problem, certify(problem, file.solution), greedy, certify(free, greedy))
    if seconds <= 0:
        return out
    out = replace(out, edits=tree_edits(problem, file.tree, SHARE_OF_EDITS * seconds))
    if problem.shape.has_parts:  # fewer levels may not hold them
        return out
    each = seconds / max(1, _levels(file, problem) - 1)
    run = Run(limits=Limits(seconds=each), seed=file.solution.seed)
    return replace(out, depths=_depths(file, problem, greedy, run), seconds=each)


def _depths(file: TreeFile, problem: Problem, greedy: Solution, run: Run) -> tuple[DepthPoint, ...]:
    """Return a point for each depth; the deepest is the tree of the file, and its bound holds for the others too."""
    shallower = range(1, _levels(file, problem))
    points = frontier_run(problem, "depth", shallower, run) if shallower else []
    solved = [(point.problem, point.solution) for point in points if point.solution.tree is not None]
    bound = -math.inf if file.solution.scope else file.solution.bound
    found = []
    for one, solution in solved:
        other = greedy_tree(one, seed=run.seed).objective if greedy.seconds <= run.limits.seconds else None
        proven = solution.objective if solution.meets_bound else max(solution.bound, bound)
        found.append(DepthPoint(one.shape.depth, solution.objective, proven, other))
    own = file.solution
    proven = own.objective if own.meets_bound else own.bound
    return (*found, DepthPoint(_levels(file, problem), own.objective, proven, greedy.objective))


def _levels(file: TreeFile, problem: Problem) -> int:
    """Return the depth that was asked for, of any depth that of the tree."""
    return max(1, depth(file.tree)) if problem.shape.any_depth else problem.shape.depth


def judged_by(evidence: Evidence, file: TreeFile, samples: Samples, source: str) -> Evidence:
    """Return the evidence with samples that the page's own trees have not seen, and what ensembles lose there."""
    held_out = HeldOut(source, samples, file.tree, evidence.greedy.tree)
    return replace(evidence, held_out=held_out, ensembles=_ensembles(evidence, samples, file.solution.seed))


def _ensembles(evidence: Evidence, samples: Samples, seed: int) -> dict[str, Score]:
    """Return what they lose, where the page was given time and the training takes seconds."""
    problem = evidence.problem
    if evidence.seconds <= 0 or problem.samples.features.size > MOST_VALUES:
        return {}
    train = baselines_of(problem)
    found = {}
    for name in ENSEMBLES:
        with contextlib.suppress(ValueError):  # scikit-learn's, of a class with one sample for instance
            found[name] = score_of(problem, train[name](seed), samples)
    return found
