"""Leaf probabilities that hold on fresh rows: the greatest share of each leaf, corrected by rows that took no part.

A tree is chosen to fit its training rows, so that the share s of the greatest class of a leaf is too high for others.
Refits on all folds but one say by how much: each row that was held out was given a share s_i by the refit's leaf and
was of that class or not (h_i = 1 or 0). The line

    P(hit | s) = a + b s,     a, b = argmin sum_i w_i (h_i - a - b s_i)^2

then corrects the leaves of the tree itself. A refit is a tree of the same problem by the same method, so its shares are
as much too high as those of the tree.

Source: the line is Platt's recalibration without the logistic, since shares are probabilities already: J. Platt,
Probabilistic outputs for support vector machines (1999); rows held out by folds: M. Stone, Cross-validatory choice
and assessment of statistical predictions (1974).
"""

from dataclasses import replace

import numpy as np

from octmip.problem import Problem
from octmip.run import Method
from octmip.solution import Limits
from octmip.solver import solve
from octmip.tradeoff.folds import part_of, stratified_folds
from octmip.tree import Node, leaf_index
from octmip.uncertainty import LeafDistribution
from octmip.uncertainty.leaf_distribution import fitted_line

FOLDS, REPEATS = 10, 2


def leaves_on_fresh_rows(
    problem: Problem,
    tree: Node,
    *,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
) -> LeafDistribution:
    """Return the leaf distribution of a tree, corrected by 20 refits (two times ten folds).

    Parameters
    ----------
    problem
        that the tree solves.
    method, limits, n_jobs
        of each refit, as of `octmip.solve`: those that found the tree.
    seed
        of folds and refits.

    Raises
    ------
    ProblemError
        a fold makes no problem: fewer than 10 samples, or a class that too few have.
    """
    plain = LeafDistribution.of(tree, problem)
    shares, hits, weights = [], [], []
    for repeat in range(REPEATS):
        for k, (train, held) in enumerate(stratified_folds(problem, FOLDS, seed + repeat)):
            part = part_of(problem, train, f"the training rows of fold {k}")
            refit = solve(part, method, limits, seed=seed, n_jobs=n_jobs).tree
            if refit is None:  # out of time: the others tell
                continue
            leaf = LeafDistribution.of(refit, part).probabilities[leaf_index(refit, problem.features[held])]
            shares.append(leaf.max(axis=1))
            hits.append(leaf.argmax(axis=1) == problem.codes[held])
            weights.append(problem.weights[held])
    if not shares:
        return plain
    return replace(plain, line=fitted_line(np.concatenate(shares), np.concatenate(hits), np.concatenate(weights)))
