"""The time that a user waits: one plain call on 1,750 x 20 at depth 2, and a million samples at depth 2."""

import resource
import statistics
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.data import Table, published, synthetic_uav
from benchmarks.tables import Line
from octmip.trees.problem import Problem
from octmip.trees.solver import solve

CALLS = 21


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield the median of many calls, problem and certificate included, and one call on a million samples."""
    for size, table in (
        ("a call on the published strains, mu1, depth 2", published("mu1", 0)),
        ("a call on the published strains, mu2, depth 2", published("mu2", 0)),
        ("a call on the synthetic UAV B, depth 2", synthetic_uav("B")),
    ):
        timed = [_call(table, 1) for _ in range(CALLS)]
        seconds = {key: statistics.median(line[key] for line in timed) for key in ("wall_seconds", "cpu_seconds")}
        yield {"size": size, "seed": 0, "threads": 1, "calls": CALLS, **timed[0], **seconds}
    table = _million()
    for n_jobs in threads:
        line = _call(table, n_jobs)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        yield {"size": "1,000,000 x 10, depth 2", "seed": 0, "threads": n_jobs, "peak_megabytes": peak, **line}


def _million() -> Table:
    rng = np.random.default_rng(0)
    features = rng.normal(size=(1_000_000, 10))
    score = (features[:, 0] > 0.3).astype(int) + (features[:, 1] > -0.5) * (features[:, 2] > 0)
    noise = rng.random(1_000_000) < 0.1
    return Table(features, np.where(noise, rng.integers(0, 3, 1_000_000), score))


def _call(table: Table, n_jobs: int) -> Line:
    watch = Stopwatch()
    solution = solve(Problem(table.features, table.labels, depth=2), n_jobs=n_jobs)
    cpu, wall = watch.read()
    return {
        "outcome": "proven" if solution.is_optimal else "not proven",
        "objective": solution.objective,
        "bound": solution.bound,
        "cpu_seconds": round(cpu, 5),
        "wall_seconds": round(wall, 5),
    }


def summary(lines: Sequence[Line]) -> str:
    """Return the table of calls."""
    rows = [
        f"| {line['size']} | {line['threads']} | {line['objective']:g}, {line['outcome']} | {line['cpu_seconds']:.3g} "
        f"| {line['wall_seconds']:.3g} | {line.get('peak_megabytes', '')} |"
        for line in lines
    ]
    return "\n".join(["| call | threads | errors | CPU s | wall s | peak MB |", "|---|---|---|---|---|---|", *rows])
