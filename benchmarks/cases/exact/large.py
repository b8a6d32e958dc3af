"""A million rows: time and memory of a proof, of searches and of scikit-learn's tree.

The data are `three_classes`, in a table that nobody can write to, as the command hands it over. Each row is
measured in a process of its own: processor seconds of the call alone, the largest resident memory up to its end, the
table itself included, and predictions a second.
"""

import multiprocessing
import resource
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.tree import DecisionTreeClassifier

from benchmarks.cpu import cpu_seconds
from benchmarks.data import three_classes
from benchmarks.tables import Line, markdown
from octmip import Limits, Problem, predict
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search

FLOAT32 = "proof, depth 2, float32 table"
SIZES = ((1_000_000, 10), (1_000_000, 50))
Floats = NDArray[Any]
"""float64, or float32 where so little is read."""
Classes = NDArray[np.int64]
Answer = tuple[str, int, Callable[[Floats], object]]


def results(limit: float, threads: Sequence[int], sizes: Sequence[tuple[int, int]] = SIZES) -> Iterator[Line]:
    """Yield a line for each size and way; a search ends at the limit."""
    del threads
    for n, p in sizes:
        for way in WAYS:
            with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
                found = process.submit(measured, n, p, way, limit).result()
            yield {"size": f"{n} x {p}", "seed": 0, "solver": way, **found}


def measured(n: int, p: int, way: str, limit: float) -> Line:
    """Return errors, outcome, seconds and memory of one way."""
    made = three_classes(n, p)
    features, labels = made.features.astype(np.float32 if way == FLOAT32 else np.float64, copy=False), made.labels
    del made
    features.flags.writeable = False
    table = _megabytes()
    before, start = cpu_seconds(), time.perf_counter()
    outcome, errors, labels_of = WAYS[way](features, labels, limit)
    spent, wall = cpu_seconds() - before, time.perf_counter() - start
    most = _megabytes()
    before = cpu_seconds()
    labels_of(features)
    return {
        "outcome": outcome,
        "objective": errors,
        "cpu_seconds": round(spent, 2),
        "wall_seconds": round(wall, 2),
        "table_megabytes": table,
        "megabytes": most,
        "predictions_per_second": round(n / max(1e-9, cpu_seconds() - before)),
    }


def _proof(features: Floats, labels: Classes, limit: float) -> Answer:
    solution = branch_and_bound(Problem(features, labels, depth=2), limits=Limits(seconds=limit))
    tree = solution.tree
    assert tree is not None
    outcome = "proven" if solution.is_optimal else f"not proven, bound {solution.bound:g}"
    return outcome, round(solution.objective), lambda rows: predict(tree, rows)


def _search(depth: int) -> Callable[[Floats, Classes, float], Answer]:
    def answer(features: Floats, labels: Classes, limit: float) -> Answer:
        problem = Problem(features, labels, depth=depth)
        solution = local_search(problem, options=SearchOptions(restarts=1), limits=Limits(seconds=limit))
        tree = solution.tree
        assert tree is not None
        return str(solution.stop), round(solution.objective), lambda rows: predict(tree, rows)

    return answer


def _sklearn(depth: int) -> Callable[[Floats, Classes, float], Answer]:
    def answer(features: Floats, labels: Classes, limit: float) -> Answer:
        del limit
        tree = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(features, labels)
        return "greedy", int((tree.predict(features) != labels).sum()), tree.predict

    return answer


WAYS: dict[str, Callable[[Floats, Classes, float], Answer]] = {
    "proof, depth 2": _proof,
    FLOAT32: _proof,
    "search, depth 4": _search(4),
    "scikit-learn, depth 4": _sklearn(4),
    "search, depth 8": _search(8),
    "scikit-learn, depth 8": _sklearn(8),
}


def _megabytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024


def summary(lines: Sequence[Line]) -> str:
    """Return the table."""
    head = ("size", "way", "errors", "CPU s", "wall s", "MB before", "MB at most", "predictions a second, millions")
    keys = ("cpu_seconds", "wall_seconds", "table_megabytes", "megabytes")
    rows = []
    for line in lines:
        figures = [f"{line[key]:.4g}" for key in keys]
        errors, speed = f"{line['objective']}, {line['outcome']}", f"{line['predictions_per_second'] / 1e6:.1f}"
        rows.append([line["size"], line["solver"], errors, *figures, speed])
    return markdown(head, rows)
