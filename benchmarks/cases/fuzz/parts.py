"""Parts of a tree against enumeration: `python -m benchmarks.run fuzz_parts`, 3,000 small problems of each kind.

Given splits, rules for paths, few changes of an old tree, and several of them with a number of splits at once. Where no
tree has what is asked for, the exact core must say so.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.kinds.classes import complaint
from benchmarks.kinds.parted import PART_KINDS, Parted
from benchmarks.oracles.parts import least_cost_with_parts
from benchmarks.tables import Line
from octmip.errors import ProblemError
from octmip.trees.solver import solve

COUNT, CHUNK = 3_000, 500


def fault(kind: Parted, seed: int) -> tuple[str, bool]:
    """Return what is wrong with the answer to the problem of a seed, and whether it has a tree."""
    problem = kind.drawn(np.random.default_rng([kind.stream, seed]))
    least = least_cost_with_parts(problem)
    try:
        solution = solve(problem, "exact")
    except ProblemError as error:
        is_right = least is None and str(error).startswith("no tree of depth")
        return "" if is_right else f"refused: {error}", False
    if least is None:
        return "a tree where there is none", False
    return ("" if solution.is_optimal else "not proven") or complaint(problem, solution, least), True


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each chunk of problems."""
    for name, kind in PART_KINDS.items():
        for first in range(0, COUNT, CHUNK):
            watch = Stopwatch()
            found = [fault(kind, seed) for seed in range(first, first + CHUNK)]
            yield {
                "size": f"{name}, seeds {first} to {first + CHUNK - 1}",
                "n_problems": CHUNK,
                "n_with_a_tree": sum(has_tree for _, has_tree in found),
                "wrong": {first + k: wrong for k, (wrong, _) in enumerate(found) if wrong},
                "cpu_seconds": round(watch.read()[0], 2),
            }


def summary(lines: list[Line]) -> str:
    """Return the count of problems, of those with a tree, and every wrong answer."""
    n, n_wrong = sum(line["n_problems"] for line in lines), sum(len(line["wrong"]) for line in lines)
    seconds = sum(line["cpu_seconds"] for line in lines)
    wrong = [f"{line['size']}: {line['wrong']}" for line in lines if line["wrong"]]
    has_tree = sum(line["n_with_a_tree"] for line in lines)
    return "\n".join([f"{n} problems, {has_tree} with a tree, {n_wrong} wrong, {seconds:.0f} CPU s", *wrong])
