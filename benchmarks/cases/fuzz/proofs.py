"""Corrupted proof logs, trees and data: none may be accepted that changes what is claimed.

Small random problems of classes (half of them with readings missing), of splits over two features, and of numbers (many
samples, or targets far off) are solved with a log. Then one thing is corrupted at random, and what the checker (or, for
a tree, the certificate) still accepts is held against enumeration: a log may only be accepted while its claim is true
of the problem that it is checked against.
"""

import dataclasses
import re
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.corruptions import HEADER, LINE_CHANGES, Generator, changed_data, raise_bound, raise_claim
from benchmarks.kinds.classes import LARGE_LEAVES_KIND
from benchmarks.kinds.numbers import NUMBER_KINDS
from benchmarks.tables import Line, markdown
from octmip.errors import OctmipError
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Solution
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.options import ExactOptions
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, ValueLeaf
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve
from tests.oracles.rational import least_cost
from tests.oracles.regression_runs import Runs
from tests.oracles.strategies import random_problem, with_missing
from tests.oracles.two_feature_problems import random_two_feature_problem

N_CORRUPTIONS, CHUNK = 1000, 100
CORRUPTIONS = ("log", "log", "log", "log", "claim raised", "data", "data and header", "tree")
ROUNDING = Fraction(1, 10**15)
"""Share of an optimum: costs of a log are whole multiples of a unit of float64."""
DIGEST = re.compile(r'expected "(data [0-9a-f]{64})"')
Change = Callable[[Generator, list[str]], None]


@dataclass(frozen=True, slots=True)
class Logs:
    """One kind of proof log.

    Attributes
    ----------
    stream
        of seeds: corruption i is drawn from default_rng([stream, i]).
    draw
        returns a small random problem.
    least
        returns the least objective of a problem, by enumeration.
    changes
        ways to corrupt the lines of a log.
    raise_claim
        raises the claim of a log, and with it the bounds that bear it.
    """

    stream: int
    draw: Callable[[Generator], Problem]
    least: Callable[[Problem], Fraction]
    changes: tuple[Change, ...]
    raise_claim: Change


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each kind and chunk of corruptions: counts by outcome, and the seeds wrongly accepted."""
    for kind, logs in KINDS.items():
        for first in range(0, N_CORRUPTIONS, CHUNK):
            outcomes = [corrupted(kind, seed) for seed in range(first, first + CHUNK)]
            wrong = [first + i for i, (_, outcome) in enumerate(outcomes) if outcome == "wrong"]
            counts = Counter(f"{kind}, {corruption}: {outcome}" for corruption, outcome in outcomes)
            size = f"{kind}, corruptions {first} to {first + CHUNK - 1}"
            yield {"size": size, "seed": logs.stream, "counts": counts, "wrong": wrong}


def summary(lines: Sequence[Line]) -> str:
    """Return the table of corruptions by outcome."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    wrong = [f"{line['size']}: {seed}" for line in lines for seed in line["wrong"]]
    said = f"{counts.total()} corruptions, {len(wrong)} wrongly accepted {wrong}."
    what = dict.fromkeys(key.rpartition(":")[0] for key in sorted(counts))
    rows = [[*one.split(", "), counts[f"{one}: refused"], counts[f"{one}: true"]] for one in what]
    return f"{said}\n\n{markdown(['logs', 'corrupted', 'refused', 'accepted, and still true'], rows)}"


def corrupted(kind: str, seed: int) -> tuple[str, str]:
    """Corrupt one thing and return its name and "refused", "true" (accepted, and still true) or "wrong"."""
    logs = KINDS[kind]
    rng = np.random.default_rng([logs.stream, seed])
    problem = logs.draw(rng)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        solution = solve(problem, "exact", options=ExactOptions(proof=path))
        check_proof(problem, path, bound=solution.bound)
        assert solution.is_optimal or kind == "numbers", "the log proves less than the optimum"
        corruption = str(rng.choice(CORRUPTIONS))
        if corruption == "tree":
            return corruption, _of_tree(rng, problem, solution)
        if corruption.startswith("data"):
            return corruption, _of_data(rng, logs, problem, path, is_header_changed=corruption != "data")
        lines = path.read_text().split("\n")
        change = logs.raise_claim if corruption != "log" else logs.changes[int(rng.integers(len(logs.changes)))]
        change(rng, lines)
        path.write_text("\n".join(lines))
        return corruption, _judged(logs, problem, path)


def _judged(logs: Logs, problem: Problem, path: Path) -> str:
    """Return whether a log is refused, or accepted for a bound that is true or wrong."""
    try:
        bound = check_proof(problem, path).bound
    except OctmipError:
        return "refused"
    return "true" if Fraction(bound) <= logs.least(problem) * (1 + ROUNDING) else "wrong"


def _of_data(rng: Generator, logs: Logs, problem: Problem, path: Path, *, is_header_changed: bool) -> str:
    changed = changed_data(rng, problem)
    if is_header_changed:
        path.write_text(_with_fitting_digest(changed, path))
        return _judged(logs, changed, path)
    outcome = _judged(logs, changed, path)
    # Any change of the data is to be refused, even where the bound stays true.
    return "wrong" if outcome != "refused" and changed.digest() != problem.digest() else outcome


def _with_fitting_digest(changed: Problem, path: Path) -> str:
    """Return a log with the digest of the data that its refusal asks for."""
    lines = path.read_text().split("\n")
    try:
        check_proof(changed, path)
    except OctmipError as error:
        asked = DIGEST.search(str(error))
        lines[1] = asked[1] if asked else lines[1]
    return "\n".join(lines)


def _of_tree(rng: Generator, problem: Problem, solution: Solution) -> str:
    tree = _other_tree(rng, problem, solution.tree)
    try:
        certificate = certify(problem, dataclasses.replace(solution, tree=tree))
    except OctmipError:
        return "refused"
    return "true" if certificate.objective == solution.objective else "wrong"


def _other_tree(rng: Generator, problem: Problem, tree: Node) -> Node:
    if isinstance(tree, Leaf | ValueLeaf) or rng.random() < 0.3:
        return _other_node(rng, problem, tree)
    if str(rng.choice(["left", "right"])) == "left":
        return dataclasses.replace(tree, left=_other_tree(rng, problem, tree.left))
    return dataclasses.replace(tree, right=_other_tree(rng, problem, tree.right))


def _other_node(rng: Generator, problem: Problem, node: Node) -> Node:
    if isinstance(node, Split):
        return dataclasses.replace(
            node, threshold=float(rng.normal()), feature=int(rng.integers(problem.samples.n_features))
        )
    if isinstance(node, HyperplaneSplit):
        return dataclasses.replace(node, offset=node.offset + float(rng.normal()))
    if isinstance(node, ValueLeaf):
        return dataclasses.replace(node, value=node.value + float(rng.normal()))
    return Leaf(int(rng.integers(problem.samples.n_classes)))


def _classes(rng: Generator) -> Problem:
    problem = random_problem(rng, max_samples=9)
    return with_missing(rng, problem) if rng.random() < 0.5 else problem


def _two_features(rng: Generator) -> Problem:
    return random_two_feature_problem(rng, depth=2 - int(rng.random() < 0.2), max_samples=9)


def _numbers(rng: Generator) -> Problem:
    return NUMBER_KINDS[str(rng.choice(["many_numbers", "far_numbers"]))].draw(rng)


def _least_of_numbers(problem: Problem) -> Fraction:
    return Runs(problem).least()


def _other_place(rng: Generator, lines: list[str]) -> None:
    """Move the edge or the value of t where a node is cut."""
    cuts = [row for row in range(HEADER, len(lines)) if lines[row].startswith(("T ", "R "))]
    if cuts:
        row = int(rng.choice(cuts))
        tag, *numbers = lines[row].split(" ")
        moved = [repr(float(number) + float(rng.normal(scale=0.3))) for number in numbers]
        lines[row] = " ".join([tag, *moved])


def _raise_claim_of_lines(rng: Generator, lines: list[str]) -> None:
    """Raise the claim, and with it the bounds and costs of the records."""
    more = int(rng.integers(1, 3))
    lines[HEADER - 1] = f"claim {int(lines[HEADER - 1].split(' ')[1]) + more}"
    for row, line in enumerate(lines):
        tag, *numbers = line.split(" ")
        if tag in ("N", "W"):
            lines[row] = f"{tag} {int(numbers[0]) + more} {numbers[1]}"
        elif tag == "E" and rng.random() < 0.5:
            lines[row] = " ".join([tag, *(f"{w.split(':')[0]}:{int(w.split(':')[1]) + more}" for w in numbers if w)])


def _other_leaves(rng: Generator, lines: list[str]) -> None:
    """Change the least size of leaves of a record, or of all of a size."""
    rows = [row for row, line in enumerate(lines) if line.startswith("N ")]
    size, other = lines[int(rng.choice(rows))].split(" ")[2], str(int(rng.integers(1, 5)))
    chosen = rows if rng.random() < 0.5 else [int(rng.choice(rows))]
    for row in chosen:
        words = lines[row].split(" ")
        lines[row] = " ".join([*words[:2], other if words[2] == size else words[2], words[3]])


def _raise_all(rng: Generator, lines: list[str]) -> None:
    """Raise the claim and the bounds of all records, or of those of a size of leaves."""
    if rng.random() < 0.3:
        return raise_claim(rng, lines)
    more, sizes = int(rng.integers(1, 3)), [line.split(" ")[2] for line in lines if line.startswith("N ")]
    size = str(rng.choice([*sizes, ""]))
    lines[HEADER - 1] = f"claim {int(lines[HEADER - 1].split(' ')[1]) + more}"
    for row, line in enumerate(lines):
        words = line.split(" ")
        if words[0] == "N" and size in ("", words[2]):
            lines[row] = " ".join([*words[:3], str(int(words[3]) + more)])
    return None


KINDS = {
    "classes": Logs(40, _classes, least_cost, LINE_CHANGES, raise_claim),
    "large leaves": Logs(43, LARGE_LEAVES_KIND.draw, least_cost, (*LINE_CHANGES, _other_leaves), _raise_all),
    "two features": Logs(41, _two_features, least_cost, (*LINE_CHANGES, _other_place), _raise_claim_of_lines),
    "numbers": Logs(42, _numbers, _least_of_numbers, (*LINE_CHANGES, raise_bound), raise_claim),
}
