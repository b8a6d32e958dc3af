"""Folds: the samples that a tree is trained on, and those that it is judged by."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.trees.question.problem import Problem

Rows = NDArray[np.int64]
Fold = tuple[Rows, Rows]  # rows to train on, rows held out


def stratified_folds(problem: Problem, n_folds: int, seed: int) -> list[Fold]:
    """Return folds of nearly equal size (they differ by one sample at most), each class dealt out evenly among them.

    Raises
    ------
    ProblemError
        fewer than 2 folds, or more than samples.
    """
    samples = problem.samples
    is_whole = isinstance(n_folds, int | np.integer) and not isinstance(n_folds, bool)
    if not is_whole or not 2 <= n_folds <= samples.n_samples:
        raise ProblemError(
            f"folds is {n_folds}; expected a whole number from 2 to {samples.n_samples}, at least one sample in each"
        )
    shuffled = np.random.default_rng(seed).permutation(samples.n_samples)
    # Class after class like a pack of cards: every fold gets its share of each, and no two folds differ by over one.
    dealt = shuffled[np.argsort(samples.codes[shuffled], kind="stable")]
    fold = np.empty(samples.n_samples, dtype=np.int64)
    fold[dealt] = np.arange(samples.n_samples) % n_folds
    return [(np.flatnonzero(fold != k), np.flatnonzero(fold == k)) for k in range(n_folds)]


def checked_folds(problem: Problem, pairs: Sequence[tuple[ArrayLike, ArrayLike]]) -> list[Fold]:
    """Return folds that were given as pairs of training rows and validation rows.

    Raises
    ------
    ProblemError
        there is none, or one is no pair, a row does not exist, is in both parts of its fold, is held out
        twice, or all the rows held out weigh nothing.
    """
    if len(pairs) == 0 or any(len(pair) != 2 for pair in pairs):
        raise ProblemError(
            f"folds has {len(pairs)} entries; expected a number of folds, or pairs of training rows and validation rows"
        )
    folds = [
        (_rows(problem, train, k, "training"), _rows(problem, held, k, "validation"))
        for k, (train, held) in enumerate(pairs)
    ]
    for k, (train, held) in enumerate(folds):
        is_held = np.zeros(problem.samples.n_samples, dtype=np.bool_)
        is_held[held] = True
        both = np.sort(train[is_held[train]])
        if len(both):
            raise ProblemError(
                f"fold {k} trains on {len(both)} of the rows that judge it (row {both[0]}); separate them"
            )
    counts = np.bincount(np.concatenate([held for _, held in folds]), minlength=problem.samples.n_samples)
    if (counts > 1).any():
        raise ProblemError(
            f"row {int((counts > 1).argmax())} is held out in {counts.max()} folds; hold each row out once"
        )
    if not problem.samples.weights[counts > 0].any():
        raise ProblemError("the rows held out all have weight 0; hold out some that count")
    return folds


def fold_numbers(problem: Problem, folds: Sequence[Fold]) -> Rows:
    """Return the fold in which each sample is held out, -1 where in none, shape (n_samples,)."""
    numbers = np.full(problem.samples.n_samples, -1, dtype=np.int64)
    for k, (_, held) in enumerate(folds):
        numbers[held] = k
    numbers.flags.writeable = False
    return numbers


def part_of(problem: Problem, rows: Rows, name: str) -> Problem:
    """Return the problem of some of the samples; `name` says in errors which they are.

    Raises
    ------
    ProblemError
        they make no problem (one class only, too few for a leaf), or a single leaf already costs nothing.
    """
    try:
        part = problem.of_rows(rows)
    except ProblemError as error:
        raise ProblemError(f"{name} make no problem: {error}") from error
    if part.baseline == 0:
        raise ProblemError(
            f"{name} cost nothing in a single leaf (costs or weights are 0); expected rows by which "
            "trees differ; choose others"
        )
    return part


def _rows(problem: Problem, given: ArrayLike, k: int, part: str) -> Rows:
    rows = np.asarray(given)
    if rows.ndim != 1 or rows.dtype.kind not in "iu" or len(rows) == 0:
        raise ProblemError(f"fold {k} has {part} rows {given!r}; expected the numbers of one or more rows")
    is_outside = rows.min() < 0 or rows.max() >= problem.samples.n_samples
    if is_outside or np.bincount(rows, minlength=1).max() > 1:
        raise ProblemError(
            f"fold {k} has {part} rows from {rows.min()} to {rows.max()}, {len(np.unique(rows))} different of "
            f"{len(rows)}; expected different ones from 0 to {problem.samples.n_samples - 1}"
        )
    return rows.astype(np.int64)
