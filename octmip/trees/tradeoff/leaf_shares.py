"""Leaf probabilities that hold on fresh rows: the greatest share of each leaf, corrected by rows that took no part.

A tree is chosen to fit its training rows, so that the share s of the greatest class of a leaf is too high for others.
Refits on all folds but one say by how much: each row that was held out was given a share s_i by the refit's leaf and
was of that class or not (h_i = 1 or 0). The line

    P(hit | s) = a + b s,     a, b = argmin sum_i w_i (h_i - a - b s_i)^2

then corrects the leaves of the tree itself. A refit is the first tree of the local search, which takes a small part of
the time of a proof: it fits its training rows nearly as closely, so its shares are nearly as much too high. Where rows
are too few for a line, the shares are drawn towards equal ones by Laplace's rule of succession.

Source: the line is Platt's recalibration without the logistic, since shares are probabilities already: J. Platt,
Probabilistic outputs for support vector machines (1999); rows held out by folds: M. Stone, Cross-validatory choice
and assessment of statistical predictions (1974).
"""

from dataclasses import replace

import numpy as np

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.methods.options import SearchOptions
from octmip.trees.nodes.tree import Node, leaf_index
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import refuse_unknown
from octmip.trees.solver import solve
from octmip.trees.tradeoff.folds import part_of, stratified_folds
from octmip.trees.uncertainty import LeafDistribution
from octmip.trees.uncertainty.leaf_distribution import fitted_line

FOLDS = 10
LEAST_ROWS = 100
"""Rows below which no line is fitted."""
EFFORT = SearchOptions(restarts=1, perturbations=0)
"""Of the local search for a refit."""


def leaves_on_fresh_rows(
    problem: Problem, tree: Node, *, seconds: float = 60.0, seed: int = 0, n_jobs: int = 1
) -> LeafDistribution:
    """Return the leaf distribution of a tree, corrected by ten refits on all folds but one.

    With fewer than `LEAST_ROWS` samples, or where no fold leaves a problem, nothing is refitted and the shares are
    smoothed by one sample of each class; `LeafDistribution.made` says which.

    Parameters
    ----------
    problem
        that the tree solves.
    seconds
        limit of all refits together [s].
    seed
        of folds and refits.
    n_jobs
        threads of each refit.

    Raises
    ------
    KeyboardInterrupt
        at Ctrl-C, at the end of the refit that it stops.
    """
    samples = problem.samples
    refuse_unknown(problem, "leaves_on_fresh_rows")
    shares, hits, weights = [], [], []
    limits = Limits(seconds=seconds / FOLDS)
    folds = stratified_folds(problem, FOLDS, seed) if samples.n_samples >= LEAST_ROWS else []
    for k, (train, held) in enumerate(folds):
        try:
            part = part_of(problem, train, f"the training rows of fold {k}")
        except ProblemError:  # a class whose rows are all held out: the other folds tell
            continue
        solution = solve(part, "search", limits, seed=seed, n_jobs=n_jobs, options=EFFORT)
        if solution.stop is Stop.INTERRUPTED:
            raise KeyboardInterrupt("the leaf probabilities are not corrected yet")
        if solution.tree is None:  # out of time
            continue
        leaf = LeafDistribution.of(solution.tree, part).probabilities[leaf_index(solution.tree, samples.features[held])]
        shares.append(leaf.max(axis=1))
        hits.append(leaf.argmax(axis=1) == samples.codes[held])
        weights.append(samples.weights[held])
    if not shares or not np.concatenate(weights).any():
        # A weight above 1 stands for so many rows, so that rows repeated and rows weighed are smoothed alike.
        return LeafDistribution.of(tree, problem, strength=samples.n_classes * min(1.0, float(samples.weights.mean())))
    line = fitted_line(np.concatenate(shares), np.concatenate(hits), np.concatenate(weights))
    return replace(LeafDistribution.of(tree, problem), line=line)
