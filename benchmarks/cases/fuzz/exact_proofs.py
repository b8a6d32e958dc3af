"""Corrupted proof logs, trees and data: none may be accepted that changes what is claimed.

Small random problems are solved with a log; then one thing is corrupted at random, and what the checker (or, for a
tree, the certificate) still accepts is held against enumeration: a log may only be accepted while its claim is true of
the problem that it is checked against.
"""

import dataclasses
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.corruptions import HEADER, LINE_CHANGES, changed_data, summary
from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.strategies import random_problem
from benchmarks.tables import Line
from octmip.certificate import certify
from octmip.errors import OctmipError
from octmip.formats.problem_file import data_digest
from octmip.methods.exact import branch_and_bound
from octmip.problem import Problem
from octmip.proof import check_proof
from octmip.solution import Solution
from octmip.tree import Leaf, Node, Split

__all__ = ["corrupted", "results", "summary"]
N_CORRUPTIONS, CHUNK = 1000, 100
STREAM = 40  # of seeds: corruption i is drawn from default_rng([STREAM, i])
Generator = np.random.Generator


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk of corruptions: what was refused, what accepted, and what wrongly so."""
    for first in range(0, N_CORRUPTIONS, CHUNK):
        outcomes = [corrupted(seed) for seed in range(first, first + CHUNK)]
        wrong = [first + i for i, (_, outcome) in enumerate(outcomes) if outcome == "wrong"]
        counts = Counter(f"{kind}: {outcome}" for kind, outcome in outcomes)
        yield {"size": f"corruptions {first} to {first + CHUNK - 1}", "seed": STREAM, "counts": counts, "wrong": wrong}


def corrupted(seed: int) -> tuple[str, str]:
    """Corrupt one thing and return its kind and "refused", "true" (accepted, and still true) or "wrong"."""
    rng = np.random.default_rng([STREAM, seed])
    problem = random_problem(rng, max_samples=9)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        solution = branch_and_bound(problem, proof=path)
        check_proof(problem, path, bound=solution.bound)
        kind = str(rng.choice(["log", "log", "log", *KINDS]))
        return kind, KINDS[kind](rng, problem, solution, path)


def _log(rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
    lines = path.read_text().split("\n")
    LINE_CHANGES[int(rng.integers(len(LINE_CHANGES)))](rng, lines)
    path.write_text("\n".join(lines))
    return _judged(problem, path)


def _raised_claim(rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
    lines = path.read_text().split("\n")
    _claim(rng, lines)
    path.write_text("\n".join(lines))
    return _judged(problem, path)


def _judged(problem: Problem, path: Path) -> str:
    """Return whether a log is refused, or accepted for a bound that is true or wrong."""
    try:
        bound = check_proof(problem, path).bound
    except OctmipError:
        return "refused"
    return "true" if bound <= optimum(problem).objective * (1 + 1e-15) else "wrong"


def _claim(rng: Generator, lines: list[str]) -> None:
    """Raise the claim, and with it the bound of every record that bears it."""
    old = lines[HEADER - 1].split(" ")[1]
    new = str(int(old) + int(rng.integers(1, 3)))
    lines[HEADER - 1] = f"claim {new}"
    for row, line in enumerate(lines):
        if line.startswith("N ") and line.split(" ")[3] == old:
            lines[row] = " ".join([*line.split(" ")[:3], new])


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
    tree = _other_tree(rng, problem, solution.tree)
    try:
        certificate = certify(problem, dataclasses.replace(solution, tree=tree))
    except OctmipError:
        return "refused"
    return "true" if certificate.objective == solution.objective else "wrong"


def _other_tree(rng: Generator, problem: Problem, tree: Node) -> Node:
    if isinstance(tree, Leaf) or rng.random() < 0.3:
        if isinstance(tree, Split):
            return dataclasses.replace(
                tree, threshold=float(rng.normal()), feature=int(rng.integers(problem.n_features))
            )
        return Leaf(int(rng.integers(problem.n_classes)))
    if str(rng.choice(["left", "right"])) == "left":
        return dataclasses.replace(tree, left=_other_tree(rng, problem, tree.left))
    return dataclasses.replace(tree, right=_other_tree(rng, problem, tree.right))


KINDS: dict[str, Callable[[Generator, Problem, Solution, Path], str]] = {
    "log": _log,
    "claim raised": _raised_claim,
    "data": _data,
    "data and header": _data_and_header,
    "tree": _tree,
}
