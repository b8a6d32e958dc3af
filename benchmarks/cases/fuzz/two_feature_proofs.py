"""Corrupted proof logs of two-feature trees, their trees and data: none may be accepted that changes what is claimed.

As `fuzz_proofs`, with the logs of `octmip.trees.methods.two_feature` and enumeration over lines.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.corruptions import HEADER, LINE_CHANGES, Generator, ProofFuzz, summary
from benchmarks.oracles.two_feature import best_objective
from benchmarks.oracles.two_feature_problems import random_two_feature_problem
from benchmarks.tables import Line
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split

__all__ = ["corrupted", "results", "summary"]


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk of corruptions: what was refused, what accepted, and what wrongly so."""
    return FUZZ.results()


def corrupted(seed: int) -> tuple[str, str]:
    """Corrupt one thing and return its name and "refused", "true" (accepted, and still true) or "wrong"."""
    return FUZZ.corrupted(seed)


def _drawn(rng: Generator) -> Problem:
    return random_two_feature_problem(rng, depth=2 - int(rng.random() < 0.2), max_samples=9)


def _solved(problem: Problem, path: Path) -> Solution:
    return two_feature_branch_and_bound(problem, options=ExactOptions(proof=path))


def _other_place(rng: Generator, lines: list[str]) -> None:
    """Move the edge or the value of t where a node is cut."""
    cuts = [row for row in range(HEADER, len(lines)) if lines[row].startswith(("T ", "R "))]
    if cuts:
        row = int(rng.choice(cuts))
        tag, *numbers = lines[row].split(" ")
        moved = [repr(float(number) + float(rng.normal(scale=0.3))) for number in numbers]
        lines[row] = " ".join([tag, *moved])


def _raise_claim(rng: Generator, lines: list[str]) -> None:
    """Raise the claim, and with it the bounds and costs of the records."""
    more = int(rng.integers(1, 3))
    lines[HEADER - 1] = f"claim {int(lines[HEADER - 1].split(' ')[1]) + more}"
    for row, line in enumerate(lines):
        tag, *numbers = line.split(" ")
        if tag in ("N", "W"):
            lines[row] = f"{tag} {int(numbers[0]) + more} {numbers[1]}"
        elif tag == "E" and rng.random() < 0.5:
            lines[row] = " ".join([tag, *(f"{w.split(':')[0]}:{int(w.split(':')[1]) + more}" for w in numbers if w)])


def _changed_split(rng: Generator, problem: Problem, node: Node) -> Node:
    if isinstance(node, Split):
        return dataclasses.replace(node, threshold=float(rng.normal()))
    if isinstance(node, HyperplaneSplit):
        return dataclasses.replace(node, offset=node.offset + float(rng.normal()))
    return Leaf(int(rng.integers(problem.n_classes)))


FUZZ = ProofFuzz(41, _drawn, _solved, best_objective, (*LINE_CHANGES, _other_place), _raise_claim, _changed_split)
