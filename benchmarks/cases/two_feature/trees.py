"""Optimal two-feature trees of depth 2, proven: published strains and UCI sets, objective = misclassified samples.

`python -m benchmarks.run two_feature_trees --limit 300 --threads 2`. A sample of n published rows (seed 0) is
that of `default_rng(n).permutation(1750)[:n]`.
"""

from collections.abc import Iterator, Sequence

from benchmarks.tables import Line, markdown
from benchmarks.two_feature import CASES, measure
from octmip.trees.problem import Problem


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each case and number of threads."""
    for name, table in CASES:
        data = table()
        problem = Problem(data.features, data.labels, depth=2, split="hyperplane", split_size=2)
        for count in threads:
            yield {"size": name, "seed": 0, "threads": count, "limit": limit} | measure(problem, limit, count)


def summary(lines: Sequence[Line]) -> str:
    """Return the table: optimum, nodes and CPU seconds."""
    head = ("case", "threads", "objective", "bound", "nodes", "CPU s")
    keys = ("size", "threads", "objective", "bound", "n_nodes", "cpu_seconds")
    return markdown(head, ([line[key] for key in keys] for line in lines))
