"""The best single split over two features: all 190 pairs of 20 gauges, and many samples."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.data import Table
from benchmarks.tables import Line
from benchmarks.two_feature import measure, strains
from octmip.trees.problem import Problem


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each case; one thread does all the work, whatever is asked for."""
    for target in ("mu1", "mu2"):
        yield _line(f"published {target}, 1750 x 20", strains(target, 1750, 20), limit)
    rng = np.random.default_rng(0)
    features = rng.normal(size=(100_000, 10))
    labels = (features[:, 0] + 0.5 * features[:, 1] + rng.normal(size=len(features)) > 0).astype(int)
    yield _line("normal, 100000 x 10", Table(features, labels), limit)


def _line(size: str, table: Table, limit: float) -> Line:
    problem = Problem(table.features, table.labels, depth=1, split="hyperplane", split_size=2)
    return {"size": size, "seed": 0, "threads": 1, "limit": limit} | measure(problem, limit, 1)


def summary(lines: Sequence[Line]) -> str:
    """Return the table of optima and CPU seconds."""
    rows = [f"| {line['size']} | {line['objective']:g} | {line['cpu_seconds']:.3f} |" for line in lines]
    return "\n".join(["| case | optimum | CPU s |", "|---|---|---|", *rows])
