"""SQL of random trees in six databases: `python -m benchmarks.run sql_engines --limit 3600`, about half an hour.

Each table has four columns of random types, cells missing or not, and twenty random trees over them: of classes (texts,
whole numbers, numbers, Booleans) and of numbers. Every database reads the table by itself and answers every tree; the
right answer is `predict` over the table that pandas reads.
"""

import re
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.tables import Line
from octmip.interfaces.report.markdown import markdown_table
from octmip.monitor.export import sql_expression
from tests.oracles.random_columns import ANSWERS, TYPES, answers_of, random_table, random_tree
from tests.oracles.sql_engines import ENGINES, same

N_TABLES, N_COLUMNS, N_TREES = 500, 4, 20
STREAM = 60


def results(limit: float, threads: Sequence[int], seeds: int = N_TABLES, only: str = "") -> Iterator[Line]:
    """Yield a line for each table, until `limit` seconds are over; `only` is a pattern of its number."""
    start = time.monotonic()
    for seed in range(seeds):
        if re.search(only, str(seed)) and time.monotonic() - start < limit:
            yield outcome(seed)


def outcome(seed: int, n_trees: int = N_TREES) -> Line:
    """Return for each database how many trees of a table it answers otherwise than `predict`, or its error."""
    rng = np.random.default_rng([STREAM, seed])
    kinds = tuple(rng.choice(list(TYPES), N_COLUMNS, replace=False).tolist())
    with tempfile.TemporaryDirectory() as folder:
        table = random_table(rng, Path(folder) / "table.parquet", kinds, doubled=bool(rng.random() < 0.2))
        classes = [ANSWERS[rng.integers(len(ANSWERS))] if rng.random() < 0.8 else () for _ in range(n_trees)]
        trees = [random_tree(rng, table, len(names), int(rng.integers(5))) for names in classes]
        right = [answers_of(tree, table, names) for tree, names in zip(trees, classes, strict=True)]
        asked = [sql_expression(tree, table.columns, names) for tree, names in zip(trees, classes, strict=True)]
        wrong: dict[str, int | str] = {}
        for name, (run, version) in ENGINES.items():
            if not version():
                continue
            try:
                rows = run(table.path, asked)
            except Exception as error:  # whatever a database raises is its answer
                wrong[name] = str(error)[:200]
                continue
            found = zip(zip(*rows, strict=True), right, strict=True)
            wrong[name] = sum(not all(map(same, got, expected)) for got, expected in found)
    versions = {name: version() for name, (_, version) in ENGINES.items() if version()}
    return {"size": ", ".join(kinds), "seed": seed, "trees": n_trees, "wrong": wrong, "versions": versions}


def summary(lines: Sequence[Line]) -> str:
    """Return trees that read a table with a column of each type, by database: wrong of tried."""
    tried, wrong = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for line in lines:
        for engine, found in line["wrong"].items():
            for kind in (*line["size"].split(", "), "all"):
                tried[kind, engine] += line["trees"]
                wrong[kind, engine] += line["trees"] if isinstance(found, str) else found
    engines = list(dict.fromkeys(engine for _, engine in tried))
    kinds = [kind for kind in (*TYPES, "all") if (kind, engines[0]) in tried]
    return markdown_table([{"column": k} | {e: f"{wrong[k, e]} of {tried[k, e]}" for e in engines} for k in kinds])
