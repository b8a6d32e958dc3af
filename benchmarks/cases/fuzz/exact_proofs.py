"""Corrupted proof logs, trees and data: none may be accepted that changes what is claimed.

Small random problems, half of them with readings missing, are solved with a log; then one thing is corrupted at random,
and what the checker (or, for a tree, the certificate) still accepts is held against enumeration: a log may only be
accepted while its claim is true of the problem that it is checked against.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.corruptions import LINE_CHANGES, Generator, ProofFuzz, raise_claim, summary
from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.strategies import random_problem, with_missing
from benchmarks.tables import Line
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution
from octmip.trees.tree import Leaf, Node, Split

__all__ = ["corrupted", "results", "summary"]


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk of corruptions: what was refused, what accepted, and what wrongly so."""
    return FUZZ.results()


def corrupted(seed: int) -> tuple[str, str]:
    """Corrupt one thing and return its name and "refused", "true" (accepted, and still true) or "wrong"."""
    return FUZZ.corrupted(seed)


def _drawn(rng: Generator) -> Problem:
    problem = random_problem(rng, max_samples=9)
    return with_missing(rng, problem) if rng.random() < 0.5 else problem


def _solved(problem: Problem, path: Path) -> Solution:
    return branch_and_bound(problem, options=ExactOptions(proof=path))


def _least(problem: Problem) -> float:
    return optimum(problem).objective


def _changed_split(rng: Generator, problem: Problem, node: Node) -> Node:
    if isinstance(node, Split):
        return dataclasses.replace(node, threshold=float(rng.normal()), feature=int(rng.integers(problem.n_features)))
    return Leaf(int(rng.integers(problem.n_classes)))


FUZZ = ProofFuzz(40, _drawn, _solved, _least, LINE_CHANGES, raise_claim, _changed_split)
