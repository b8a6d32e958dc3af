"""Optimal two-feature trees of depth 2 and 3: published strains and UCI sets, objective = misclassified samples.

`python -m benchmarks.run two_feature_trees --limit 300 --threads 2`. A sample of n published rows (seed 0) is
that of `default_rng(n).permutation(1750)[:n]`.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.data import Table, published, uci
from benchmarks.tables import Line, markdown
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Limits
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve


def _strains(target: str, n_samples: int, n_gauges: int) -> Table:
    """Return so many rows and the first gauges of the published strains."""
    table = published(target, 0)
    rows = np.random.default_rng(n_samples).permutation(len(table.labels))[:n_samples]
    rows = rows if n_samples < len(table.labels) else np.arange(n_samples)
    return Table(table.features[rows, :n_gauges], table.labels[rows])


def _strains_case(target: str, n_samples: int, n_gauges: int) -> tuple[str, Callable[[], Table]]:
    name = f"published {target}, {n_samples} x {n_gauges}"
    return name, partial(_strains, target, n_samples, n_gauges)


CASES: tuple[tuple[str, Callable[[], Table]], ...] = (
    _strains_case("mu1", 175, 2),
    _strains_case("mu1", 350, 2),
    _strains_case("mu1", 1750, 2),
    _strains_case("mu1", 175, 20),
    _strains_case("mu1", 350, 20),
    _strains_case("mu2", 175, 2),
    _strains_case("mu2", 350, 2),
    _strains_case("mu2", 875, 2),
    _strains_case("mu2", 1750, 2),
    _strains_case("mu2", 175, 5),
    *(
        (name, partial(uci, name))
        for name in ("iris", "wine", "seeds", "vertebral-column-3c", "banknote-authentication")
    ),
    _strains_case("mu1", 1750, 5),
    _strains_case("mu1", 1750, 20),
    ("breast-cancer-wisconsin-diagnostic", partial(uci, "breast-cancer-wisconsin-diagnostic")),
)

DEEPER = tuple(_strains_case(target, n_samples, 2) for target, n_samples in (("mu1", 350), ("mu1", 1750), ("mu2", 175)))
"""At depth 3, with two gauges: the paper's Fig. 7, and less of it."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each case and number of threads."""
    asked = [
        (f"{name}, depth {depth}", table, depth) for depth, cases in ((2, CASES), (3, DEEPER)) for name, table in cases
    ]
    for name, table, depth in asked:
        data = table()
        problem = Problem(data.features, data.labels, depth=depth, split="hyperplane", split_size=2)
        for count in threads:
            yield {"size": name, "seed": 0, "threads": count, "limit": limit} | _measured(problem, limit, count)


def summary(lines: Sequence[Line]) -> str:
    """Return the table: optimum, nodes and CPU seconds."""
    head = ("case", "threads", "objective", "bound", "nodes", "CPU s")
    keys = ("size", "threads", "objective", "bound", "n_nodes", "cpu_seconds")
    return markdown(head, ([line[key] for key in keys] for line in lines))


def _measured(problem: Problem, limit: float, n_threads: int) -> Line:
    """Solve, certify, and return the figures of one result line."""
    watch = Stopwatch()
    solution = solve(problem, "exact", limits=Limits(seconds=limit), n_jobs=n_threads)
    cpu, wall = watch.read()
    certify(problem, solution)
    return {
        "objective": solution.objective,
        "bound": solution.bound,
        "outcome": "proven" if solution.is_optimal else f"not proven ({solution.stop})",
        "n_nodes": solution.n_nodes,
        "cpu_seconds": round(cpu, 3),
        "wall_seconds": round(wall, 3),
    }
