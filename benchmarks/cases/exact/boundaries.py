"""Depth 2 up to a million rows of ten columns, by the boundary between the two classes: what is easy and what is hard.

Normal features. The classes are parted by a tree of two levels, by a sum of five columns with noise, by the product of
two columns with noise, or by chance. Only the proof is timed, from `branch_and_bound` with no tree to start from.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.cpu import Stopwatch, cpu_limit
from benchmarks.tables import Line, markdown
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.problem import Problem

SIZES = (16_000, 64_000, 250_000, 1_000_000)
N_FEATURES = 10

Draw = Callable[[np.random.Generator, NDArray[np.float64]], NDArray[np.bool_]]


def _tree(random: np.random.Generator, x: NDArray[np.float64]) -> NDArray[np.bool_]:
    inside = np.where(x[:, 0] > 0.3, x[:, 1] > -0.5, x[:, 2] > 0)
    return np.asarray(inside ^ (random.random(len(x)) < 0.1))


def _sum(random: np.random.Generator, x: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(x[:, :5].sum(axis=1) + random.normal(size=len(x)) > 0)


def _product(random: np.random.Generator, x: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(x[:, 0] * x[:, 1] + random.normal(size=len(x)) > 0)


def _chance(random: np.random.Generator, x: NDArray[np.float64]) -> NDArray[np.bool_]:
    return random.random(len(x)) < 0.5


BOUNDARIES: dict[str, Draw] = {"a tree": _tree, "a sum": _sum, "a product": _product, "chance": _chance}


def problem_of(boundary: str, n: int) -> Problem:
    """Return a problem of so many rows whose classes this boundary parts."""
    random = np.random.default_rng(0)
    features = random.normal(size=(n, N_FEATURES))
    return Problem(features, BOUNDARIES[boundary](random, features), depth=2)


def results(limit: float, threads: Sequence[int], sizes: Sequence[int] = SIZES) -> Iterator[Line]:
    """Yield a line for each boundary and size; larger ones are left out after one that reaches its limit."""
    for boundary in BOUNDARIES:
        for n in sizes:
            problem = problem_of(boundary, n)
            watch = Stopwatch()
            solution = branch_and_bound(problem, **cpu_limit(limit))
            seconds = watch.read()[0]
            yield {
                "size": f"{boundary}, {n:,} rows",
                "seed": 0,
                "boundary": boundary,
                "n": n,
                "outcome": "proven" if solution.is_optimal else "not proven",
                "objective": solution.objective,
                "bound": solution.bound,
                "evaluations": solution.n_nodes,
                "cpu_seconds": round(seconds, 3),
            }
            if not solution.is_optimal:
                break


def summary(lines: Sequence[Line]) -> str:
    """Return a row for each boundary: CPU seconds by size, and the exponent that they grow with."""
    sizes = sorted({line["n"] for line in lines})
    rows = []
    for boundary in dict.fromkeys(line["boundary"] for line in lines):
        found = {line["n"]: line for line in lines if line["boundary"] == boundary}
        rows.append([boundary, *(_cell(found.get(n)) for n in sizes), f"{_exponent(found.values()):.2f}"])
    return markdown(["boundary", *(f"{n:,} rows" for n in sizes), "exponent"], rows)


def _exponent(lines: Iterable[Line]) -> float:
    """Return b of seconds = a n^b, least squares on logarithms of the proven sizes."""
    proven = [[line["n"], line["cpu_seconds"]] for line in lines if line["outcome"] == "proven"]
    if len(proven) < 2:
        return np.nan
    sizes, seconds = np.log(np.array(proven)).T
    return float(np.polyfit(sizes, seconds, 1)[0])


def _cell(line: Line | None) -> str:
    if line is None:
        return ""
    is_proven = line["outcome"] == "proven"
    return f"{line['cpu_seconds']:.3g}" if is_proven else f"{line['bound']:g} of {line['objective']:g} not proven"
