"""A million noisy readings to Parquet: time and the most memory held, beside a tenth of the rows."""

import multiprocessing
import resource
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from benchmarks.cpu import Stopwatch
from benchmarks.tables import Line, markdown
from femlib.dataset import Recipe, Sampling, random_states, stream_dataset
from femlib.wing import reduce_wing, uav_wing

# model, distinct states, readings of each, jobs
SIZES = (
    ("full wing", 500, 200, 1),
    ("full wing", 500, 2_000, 1),
    ("full wing", 500, 2_000, 2),
    ("reduced wing", 100_000, 1, 1),
    ("reduced wing", 1_000_000, 1, 1),
)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line per size, each measured in a process of its own."""
    for model, n_states, n_readings, n_jobs in SIZES:
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
            yield process.submit(streamed, model, n_states, n_readings, n_jobs, 1.0).result()


def streamed(model: str, n_states: int, n_readings: int, n_jobs: int, refinement: float) -> Line:
    """Stream random joint damage of two regions and return seconds, the file's size and this process's peak memory."""
    wing = uav_wing(refinement=refinement)
    solved = reduce_wing(wing) if model == "reduced wing" else wing
    usable = [name for name, keep in zip(wing.gauges.names, wing.gauges.is_usable, strict=True) if keep]
    ready = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    states = random_states(["mu1", "mu2"], n_states, seed=0)
    watch = Stopwatch()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rows.parquet"
        sampling = Sampling(recipe=Recipe(n_readings), gauges=usable)
        data = stream_dataset(path, solved, states, sampling, n_jobs=n_jobs)
        megabytes = path.stat().st_size / 1e6
    cpu, wall = watch.read()
    return {
        "size": f"{model}, {n_states:,} states x {n_readings:,} readings",
        "seed": 0,
        "threads": n_jobs,
        "rows": data.n_rows,
        "cpu_seconds": round(cpu, 2),
        "wall_seconds": round(wall, 2),
        "megabytes": round(megabytes, 1),
        "ready_megabytes": ready // 1024,
        "peak_megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    }


def summary(lines: Sequence[Line]) -> str:
    """Return the table of docs/wing.md."""
    head = ("model, states, readings", "rows", "jobs", "CPU s", "clock s", "file, MB", "before, MB", "at most, MB")
    keys = ("size", "rows", "threads", "cpu_seconds", "wall_seconds", "megabytes", "ready_megabytes", "peak_megabytes")
    return markdown(head, ([line[key] for key in keys] for line in lines))
