"""Shared by the fuzzers of proof logs: ways to corrupt the lines of a log or the data, and the table of outcomes."""

import dataclasses
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.formats.problem_file import data_digest
from octmip.trees.certificate import certify
from octmip.trees.problem import Problem
from octmip.trees.proof import check_proof
from octmip.trees.solution import Solution
from octmip.trees.tree import Leaf, Node

Generator = np.random.Generator
HEADER = 5  # lines
N_CORRUPTIONS, CHUNK = 1000, 100
CORRUPTIONS = ("log", "claim raised", "data", "data and header", "tree")
LOGS = 3  # a log is corrupted so many times as often as anything else


def body_row(rng: np.random.Generator, lines: list[str]) -> int:
    """Return a row below the header."""
    return int(rng.integers(HEADER, len(lines) - 1))


def character(rng: np.random.Generator, lines: list[str]) -> None:
    """Replace one character."""
    row = int(rng.integers(len(lines) - 1))
    column = int(rng.integers(max(len(lines[row]), 1)))
    lines[row] = lines[row][:column] + chr(rng.integers(32, 127)) + lines[row][column + 1 :]


def delete(rng: np.random.Generator, lines: list[str]) -> None:
    """Leave out a line of the body."""
    del lines[body_row(rng, lines)]


def repeat(rng: np.random.Generator, lines: list[str]) -> None:
    """Repeat a line of the body."""
    row = body_row(rng, lines)
    lines.insert(row, lines[row])


def swap(rng: np.random.Generator, lines: list[str]) -> None:
    """Exchange two lines of the body."""
    one, other = body_row(rng, lines), body_row(rng, lines)
    lines[one], lines[other] = lines[other], lines[one]


def cut_short(rng: np.random.Generator, lines: list[str]) -> None:
    """Leave out the end."""
    del lines[body_row(rng, lines) :]


def number(rng: np.random.Generator, lines: list[str]) -> None:
    """Change a whole number a little."""
    row = body_row(rng, lines)
    tokens = lines[row].split(" ")
    place = int(rng.integers(len(tokens)))
    if tokens[place].isdigit():
        tokens[place] = str(max(0, int(tokens[place]) + int(rng.integers(-2, 3))))
    lines[row] = " ".join(tokens)


def raise_claim(rng: np.random.Generator, lines: list[str]) -> None:
    """Raise the claim of an axis-aligned log, and with it the bound of every record that bears it."""
    old = lines[HEADER - 1].split(" ")[1]
    new = str(int(old) + int(rng.integers(1, 3)))
    lines[HEADER - 1] = f"claim {new}"
    for row, line in enumerate(lines):
        if line.startswith("N ") and line.split(" ")[3] == old:
            lines[row] = " ".join([*line.split(" ")[:3], new])


def changed_data(rng: np.random.Generator, problem: Problem) -> Problem:
    """Return the problem with one feature value (or its being there), label or weight changed."""
    features, codes, weights = problem.features.copy(), problem.codes.copy(), problem.weights.copy()
    row = int(rng.integers(problem.n_samples))
    name = str(rng.choice(["features", "codes", "weights"]))
    if name == "features":
        is_lost = problem.split == "axis" and rng.random() < 0.3
        features[row, int(rng.integers(problem.n_features))] = np.nan if is_lost else rng.normal()
    elif name == "codes":
        codes[row] = (codes[row] + 1) % problem.n_classes
        codes = problem.codes if len(set(codes.tolist())) < 2 else codes
    else:
        weights[row] += 1.0
    labels = np.array(problem.class_names)[codes]
    return dataclasses.replace(problem, features=features, targets=labels, weights=weights)


def summary(lines: Sequence[Line]) -> str:
    """Return the table of corruptions by outcome."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    wrong = [seed for line in lines for seed in line["wrong"]]
    rows = [f"| {kind} | {counts[kind]} |" for kind in sorted(counts)]
    head = [
        f"{sum(counts.values())} corruptions, {len(wrong)} wrongly accepted {wrong}.",
        "",
        "| what: outcome | count |",
    ]
    return "\n".join([*head, "|---|---|", *rows])


# Any one of these is done to the lines of a log.
LINE_CHANGES = (character, delete, repeat, swap, cut_short, number)


@dataclass(frozen=True)
class ProofFuzz:
    """Corruption of one solver's proof logs, trees and data.

    Attributes
    ----------
    stream
        of seeds: corruption i is drawn from default_rng([stream, i]).
    draw
        returns a small random problem.
    solve
        solves it and writes the log.
    least
        returns the least objective of a problem, by enumeration.
    line_changes
        ways to corrupt the lines of a log.
    raise_claim
        raises the claim of a log, and with it the bounds that bear it.
    changed_split
        returns the node with another split, or another leaf.
    """

    stream: int
    draw: Callable[[Generator], Problem]
    solve: Callable[[Problem, Path], Solution]
    least: Callable[[Problem], float]
    line_changes: Sequence[Callable[[Generator, list[str]], None]]
    raise_claim: Callable[[Generator, list[str]], None]
    changed_split: Callable[[Generator, Problem, Node], Node]

    def results(self) -> Iterator[Line]:
        """Yield a line for each chunk of corruptions: counts by corruption and outcome, and those wrongly accepted."""
        for first in range(0, N_CORRUPTIONS, CHUNK):
            outcomes = [self.corrupted(seed) for seed in range(first, first + CHUNK)]
            wrong = [first + i for i, (_, outcome) in enumerate(outcomes) if outcome == "wrong"]
            counts = Counter(f"{corruption}: {outcome}" for corruption, outcome in outcomes)
            size = f"corruptions {first} to {first + CHUNK - 1}"
            yield {"size": size, "seed": self.stream, "counts": counts, "wrong": wrong}

    def corrupted(self, seed: int) -> tuple[str, str]:
        """Corrupt one thing and return its name and "refused", "true" (accepted, and still true) or "wrong"."""
        rng = np.random.default_rng([self.stream, seed])
        problem = self.draw(rng)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "proof.log"
            solution = self.solve(problem, path)
            check_proof(problem, path, bound=solution.bound)
            corruption = str(rng.choice([*[CORRUPTIONS[0]] * LOGS, *CORRUPTIONS]))
            return corruption, self._outcome(corruption, rng, problem, solution, path)

    def _outcome(self, corruption: str, rng: Generator, problem: Problem, solution: Solution, path: Path) -> str:
        if corruption == "tree":
            return self._of_tree(rng, problem, solution)
        if corruption.startswith("data"):
            return self._of_data(rng, problem, path, corruption == "data and header")
        lines = path.read_text().split("\n")
        if corruption == "log":
            self.line_changes[int(rng.integers(len(self.line_changes)))](rng, lines)
        else:
            self.raise_claim(rng, lines)
        path.write_text("\n".join(lines))
        return self._judged(problem, path)

    def _judged(self, problem: Problem, path: Path) -> str:
        """Return whether a log is refused, or accepted for a bound that is true or wrong."""
        try:
            bound = check_proof(problem, path).bound
        except OctmipError:
            return "refused"
        return "true" if bound <= self.least(problem) * (1 + 1e-15) else "wrong"

    def _of_data(self, rng: Generator, problem: Problem, path: Path, is_header_changed: bool) -> str:
        changed = changed_data(rng, problem)
        if is_header_changed:
            lines = path.read_text().split("\n")
            lines[1] = f"data {data_digest(changed)}"
            path.write_text("\n".join(lines))
            return self._judged(changed, path)
        outcome = self._judged(changed, path)
        # Any change of the data is to be refused, even where the bound stays true.
        return "wrong" if outcome != "refused" and changed.digest() != problem.digest() else outcome

    def _of_tree(self, rng: Generator, problem: Problem, solution: Solution) -> str:
        assert solution.tree is not None
        tree = self._other_tree(rng, problem, solution.tree)
        try:
            certificate = certify(problem, dataclasses.replace(solution, tree=tree))
        except OctmipError:
            return "refused"
        return "true" if certificate.objective == solution.objective else "wrong"

    def _other_tree(self, rng: Generator, problem: Problem, tree: Node) -> Node:
        if isinstance(tree, Leaf) or rng.random() < 0.3:
            return self.changed_split(rng, problem, tree)
        if str(rng.choice(["left", "right"])) == "left":
            return dataclasses.replace(tree, left=self._other_tree(rng, problem, tree.left))
        return dataclasses.replace(tree, right=self._other_tree(rng, problem, tree.right))
