"""Sets of texts in one split: small tables of texts, some cells missing, against a list of all trees."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.kinds.classes import complaint
from benchmarks.kinds.kind import Generator, Question
from octmip.formats.columns import Columns
from octmip.trees.answer.solution import Solution
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve
from tests.oracles.subsets import least_errors

MOST_TEXTS = 6


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table, and the problem that it is read as."""

    rows: Sequence[tuple[Any, ...]]
    labels: Sequence[int]
    problem: Problem


class Texts:
    """Trees of least errors whose splits ask for any set of the texts of a column."""

    stream, share, is_proven = 47, 0.3, True
    methods: Mapping[str, float] = MappingProxyType({"exact": 1.0})

    def draw(self, rng: Generator) -> TextTable:
        """Return a random table of one or two columns of texts, some with a column of numbers."""
        n, depth = int(rng.integers(4, 15)), int(rng.choice([1, 2, 2, 3]))
        n_texts = [int(k) for k in rng.integers(2, MOST_TEXTS + 1 - 2 * (depth == 3), int(rng.integers(1, 3)))]
        frame = pd.DataFrame({f"c{j}": np.array(list("abcdef"))[rng.integers(0, k, n)] for j, k in enumerate(n_texts)})
        if rng.random() < 0.3:
            frame.loc[rng.random(n) < 0.3, "c0"] = None
        frame.loc[:1, "c0"] = ["a", "b"]  # a column of one text is no feature
        if rng.random() < 0.5:
            frame["x"] = rng.integers(0, 4, n).astype(float)
        labels = rng.integers(0, int(rng.integers(2, 4)), n)
        labels[:2] = 0, 1
        columns = Columns.learn(frame, categories="subsets")
        names, of_column = columns.feature_names, columns.column_of_feature
        problem = Problem(columns.encode(frame), labels, depth=depth, feature_names=names, sensor_of_feature=of_column)
        rows = frame.astype(object).where(frame.notna(), None).itertuples(index=False, name=None)
        return TextTable([tuple(row) for row in rows], labels.tolist(), problem)

    def truth(self, problem: TextTable) -> Fraction:
        """Return the least errors of any tree."""
        assert problem.problem.shape.depth is not None
        return Fraction(least_errors(problem.rows, problem.labels, problem.problem.shape.depth))

    def has_log(self, problem: TextTable, method: str) -> bool:
        """Return False: a log knows columns of 0 and 1, as those of other problems."""
        return False

    def ask(self, question: Question, problem: TextTable, log: Path | None) -> Solution:
        """Return the answer to a question."""
        return solve(problem.problem, "exact", limits=question.limits, seed=question.seed)

    def complaint(self, problem: TextTable, answer: Solution, truth: Fraction, log: Path) -> str:
        """Return what is wrong with a solution; '' when nothing is."""
        return complaint(problem.problem, answer, truth)
