"""Sets of texts in one split against enumeration: `python -m benchmarks.run fuzz_subsets`, 3,000 small tables."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from benchmarks.cpu import Stopwatch
from benchmarks.oracles.subsets import least_errors
from benchmarks.tables import Line
from octmip.formats.columns import Columns
from octmip.trees.certificate import certify
from octmip.trees.problem import Problem
from octmip.trees.solver import solve

COUNT, CHUNK, STREAM = 3_000, 500, 47
MOST_TEXTS = 6


def fault(seed: int) -> str:
    """Return what is wrong with the best tree of the table of a seed, '' when nothing is."""
    rng = np.random.default_rng([STREAM, seed])
    frame, labels, depth = table(rng)
    columns = Columns.learn(frame, categories="subsets")
    names, of_column = columns.feature_names, columns.column_of_feature
    problem = Problem(columns.encode(frame), labels, depth=depth, feature_names=names, sensor_of_feature=of_column)
    solution = solve(problem)
    certify(problem, solution)
    rows = list(frame.astype(object).where(frame.notna(), None).itertuples(index=False, name=None))
    least = least_errors([tuple(row) for row in rows], labels.tolist(), depth)
    if solution.is_optimal and solution.objective == least:
        return ""
    return f"objective {solution.objective}, bound {solution.bound}; the least errors are {least}"


def table(rng: np.random.Generator) -> tuple[pd.DataFrame, "np.ndarray[tuple[int], np.dtype[np.int64]]", int]:
    """Return a random table of one or two columns of texts, some cells missing, labels and a depth."""
    n, depth = int(rng.integers(4, 15)), int(rng.choice([1, 2, 2, 3]))
    n_texts = [int(k) for k in rng.integers(2, MOST_TEXTS + 1 - 2 * (depth == 3), int(rng.integers(1, 3)))]
    frame = pd.DataFrame({f"c{j}": np.array(list("abcdef"))[rng.integers(0, k, n)] for j, k in enumerate(n_texts)})
    if rng.random() < 0.3:
        frame.loc[rng.random(n) < 0.3, "c0"] = None
    frame.loc[:1, "c0"] = ["a", "b"]  # a column of one text is no feature
    if rng.random() < 0.5:
        frame["x"] = rng.integers(0, 4, n).astype(float)
    labels = rng.integers(0, int(rng.integers(2, 4)), n)
    labels[:2] = 0, 1
    return frame, labels, depth


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each chunk of tables."""
    for first in range(0, COUNT, CHUNK):
        watch = Stopwatch()
        found = {seed: fault(seed) for seed in range(first, first + CHUNK)}
        wrong = {seed: said for seed, said in found.items() if said}
        yield {"size": CHUNK, "seed": first, "wrong": wrong, "cpu_seconds": round(watch.read()[0], 2)}


def summary(lines: list[Line]) -> str:
    """Return the count of tables, and every wrong answer."""
    wrong = {seed: said for line in lines for seed, said in line["wrong"].items()}
    seconds = sum(line["cpu_seconds"] for line in lines)
    head = f"{sum(line['size'] for line in lines)} tables, {len(wrong)} wrong, {seconds:.0f} CPU s"
    return "\n".join([head, *(f"seed {seed}: {said}" for seed, said in wrong.items())])
