"""Corrupted proof logs of two-feature trees, their trees and data: none may be accepted that changes what is claimed.

As `fuzz_proofs`, with the logs of `octmip.methods.two_feature` and enumeration over lines.
"""

import dataclasses
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.corruptions import HEADER, LINE_CHANGES, changed_data, summary
from benchmarks.oracles.two_feature import best_objective
from benchmarks.oracles.two_feature_problems import random_two_feature_problem
from octmip.certificate import certify
from octmip.errors import OctmipError
from octmip.formats.problem_file import data_digest
from octmip.methods.two_feature import two_feature_branch_and_bound
from octmip.problem import Problem
from octmip.proof import check_proof
from octmip.solution import Solution
from octmip.tree import HyperplaneSplit, Leaf, Node, Split

__all__ = ["corrupted", "results", "summary"]
N_CORRUPTIONS, CHUNK = 1000, 100
STREAM = 41  # of seeds: corruption i is drawn from default_rng([STREAM, i])
Generator = np.random.Generator


def results(limit: float, threads: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yield a line for each chunk of corruptions: what was refused, what accepted, and what wrongly so."""
    for first in range(0, N_CORRUPTIONS, CHUNK):
        outcomes = [corrupted(seed) for seed in range(first, first + CHUNK)]
        wrong = [first + i for i, (_, outcome) in enumerate(outcomes) if outcome == "wrong"]
        counts = Counter(f"{corruption}: {outcome}" for corruption, outcome in outcomes)
        yield {"size": f"corruptions {first} to {first + CHUNK - 1}", "seed": STREAM, "counts": counts, "wrong": wrong}


def corrupted(seed: int) -> tuple[str, str]:
    """Corrupt one thing and return its name and "refused", "true" (accepted, and still true) or "wrong"."""
    rng = np.random.default_rng([STREAM, seed])
    problem = random_two_feature_problem(rng, depth=2 - int(rng.random() < 0.2), max_samples=9)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        solution = two_feature_branch_and_bound(problem, proof=path)
        check_proof(problem, path, bound=solution.bound)
        corruption = str(rng.choice(["log", "log", "log", *CORRUPTIONS]))
        return corruption, CORRUPTIONS[corruption](rng, problem, solution, path)


def _judged(problem: Problem, path: Path) -> str:
    """Return whether a log is refused, or accepted for a bound that is true or wrong."""
    try:
        bound = check_proof(problem, path).bound
    except OctmipError:
        return "refused"
    return "true" if bound <= best_objective(problem) * (1 + 1e-15) else "wrong"


def _log(rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
    lines = path.read_text().split("\n")
    changes = [*LINE_CHANGES, _other_place]
    changes[int(rng.integers(len(changes)))](rng, lines)
    path.write_text("\n".join(lines))
    return _judged(problem, path)


def _other_place(rng: Generator, lines: list[str]) -> None:
    """Move the edge or the value of t where a node is cut."""
    cuts = [row for row in range(HEADER, len(lines)) if lines[row].startswith(("T ", "R "))]
    if cuts:
        row = int(rng.choice(cuts))
        tag, *numbers = lines[row].split(" ")
        moved = [repr(float(number) + float(rng.normal(scale=0.3))) for number in numbers]
        lines[row] = " ".join([tag, *moved])


def _raised_claim(rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
    lines = path.read_text().split("\n")
    more = int(rng.integers(1, 3))
    lines[HEADER - 1] = f"claim {int(lines[HEADER - 1].split(' ')[1]) + more}"
    for row, line in enumerate(lines):
        tag, *numbers = line.split(" ")
        if tag in ("N", "W"):
            lines[row] = f"{tag} {int(numbers[0]) + more} {numbers[1]}"
        elif tag == "E" and rng.random() < 0.5:
            lines[row] = " ".join([tag, *(f"{w.split(':')[0]}:{int(w.split(':')[1]) + more}" for w in numbers if w)])
    path.write_text("\n".join(lines))
    return _judged(problem, path)


def _data(rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
    changed = changed_data(rng, problem)
    outcome = _judged(changed, path)
    # Any change of the data is to be refused, even where the bound stays true.
    return "wrong" if outcome != "refused" and changed.digest() != problem.digest() else outcome


def _data_and_header(rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
    changed = changed_data(rng, problem)
    lines = path.read_text().split("\n")
    lines[1] = f"data {data_digest(changed)}"
    path.write_text("\n".join(lines))
    return _judged(changed, path)


def _tree(rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
    assert solution.tree is not None
    try:
        certificate = certify(problem, dataclasses.replace(solution, tree=_other_tree(rng, problem, solution.tree)))
    except OctmipError:
        return "refused"
    return "true" if certificate.objective == solution.objective else "wrong"


def _other_tree(rng: Generator, problem: Problem, tree: Node) -> Node:
    if isinstance(tree, Leaf) or rng.random() < 0.3:
        if isinstance(tree, Split):
            return dataclasses.replace(tree, threshold=float(rng.normal()))
        if isinstance(tree, HyperplaneSplit):
            return dataclasses.replace(tree, offset=tree.offset + float(rng.normal()))
        return Leaf(int(rng.integers(problem.n_classes)))
    side = str(rng.choice(["left", "right"]))
    return dataclasses.replace(tree, **{side: _other_tree(rng, problem, getattr(tree, side))})


CORRUPTIONS: dict[str, Callable[[Generator, Problem, Solution, Path], str]] = {
    "log": _log,
    "claim raised": _raised_claim,
    "data": _data,
    "data and header": _data_and_header,
    "tree": _tree,
}
