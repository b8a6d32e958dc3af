"""Random tables of every type that columns of databases have, and random trees over them.

The right answer of a tree is `predict` over the features of the same table, which pandas reads from the same Parquet
file; the databases read the file by themselves.
"""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from octmip.formats.columns import Columns
from octmip.trees.digits import midpoint
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Side, Split, ValueLeaf, predict, predict_values
from tests.oracles.sql_engines import ROW

Rng = np.random.Generator
Values = Callable[[Rng, int], Any]
WORDS = ("red", "blue", "it's", 'a "quoted" one', "Ä", "b/c */ --", "Blue", "100 %", " blank ", "line\nend")
DAY = 86_400_000_000


def _floats(rng: Rng, n: int) -> NDArray[np.float64]:
    size = float(rng.choice([1.0, 1e-9, 1e9, 1e300, 1e-300]))
    few = rng.normal(size=max(2, n // 3)) * size
    return np.asarray(rng.choice(np.concatenate([few, np.nextafter(few, np.inf), [0.0, -0.0]]), n))


def _whole(kind: Any) -> Values:
    ends = np.iinfo(kind)
    low, high = max(ends.min, -(2**53)), min(ends.max, 2**53)
    near = [v for v in (low, low + 1, 0, 1, 2, high - 1, high) if low <= v <= high]
    return lambda rng, n: np.array(rng.choice(near, n), dtype=kind)


def _times(unit: int) -> Values:
    """Return times in microseconds since 1970, in steps of some, now and then at midnight."""

    def drawn(rng: Rng, n: int) -> NDArray[np.int64]:
        days = rng.integers(-30_000, 40_000, 4)
        within = rng.choice([0, DAY // 2, int(rng.integers(DAY)) // unit * unit, unit, DAY - unit], n)
        return np.asarray(rng.choice(days, n) * DAY + within)

    return drawn


def _iso(rng: Rng, n: int) -> list[str]:
    """Return ISO texts of one column: dates alone, or with a time in several spellings."""
    stamps = pd.to_datetime(_times(1000)(rng, n), unit="us")
    clock = rng.choice(["", " %H:%M", "T%H:%M:%S", " %H:%M:%S.%f", "T%H:%M:%SZ"])
    return list(stamps.strftime(f"%Y-%m-%d{clock}"))


TYPES: dict[str, tuple[pa.DataType, Values]] = {
    "float64": (pa.float64(), _floats),
    "float32": (pa.float32(), lambda rng, n: rng.choice(rng.normal(size=6).astype(np.float32), n)),
    "int8": (pa.int8(), _whole(np.int8)),
    "int16": (pa.int16(), _whole(np.int16)),
    "int32": (pa.int32(), _whole(np.int32)),
    "int64": (pa.int64(), _whole(np.int64)),
    "uint8": (pa.uint8(), _whole(np.uint8)),
    "uint16": (pa.uint16(), _whole(np.uint16)),
    "uint32": (pa.uint32(), _whole(np.uint32)),
    "uint64": (pa.uint64(), _whole(np.uint64)),
    "Boolean": (pa.bool_(), lambda rng, n: rng.random(n) < 0.5),
    "decimal": (pa.decimal128(12, 3), lambda rng, n: [Decimal(int(v)) / 1000 for v in rng.integers(-9999, 9999, n)]),
    "text": (pa.string(), lambda rng, n: list(rng.choice(rng.choice(WORDS, 4, replace=False), n))),
    "category": (pa.dictionary(pa.int8(), pa.string()), lambda rng, n: list(rng.choice(WORDS[:5], n))),
    "numbers as text": (pa.string(), lambda rng, n: [f"{v:.3g}" for v in rng.normal(size=n) * 100]),
    "date": (pa.date32(), lambda rng, n: rng.choice(rng.integers(-30_000, 40_000, 6), n).astype(np.int32)),
    "ISO text": (pa.string(), _iso),
    "timestamp[ms]": (pa.timestamp("ms"), lambda rng, n: _times(1000)(rng, n) // 1000),
    "timestamp[us]": (pa.timestamp("us"), _times(1)),
    "timestamp[ns]": (pa.timestamp("ns"), lambda rng, n: _times(1)(rng, n) * 1000),
    "timestamp[us] of UTC": (pa.timestamp("us", "UTC"), _times(1)),
}
"""Type and values of a column, by its name in the table of docs/howto/export.md."""
MISSING = {"numbers as text": "?", "ISO text": ""}
NAN = ("float64", "float32")


def column_of(rng: Rng, kind: str, n: int, missing: float) -> pa.Array:
    """Return a column of some type, a share of its cells missing: NULL, or NaN or a word where the type has these."""
    dtype, values = TYPES[kind]
    drawn = list(values(rng, n))
    gone = rng.random(n) < missing
    gone[: min(2, n)] = False
    word = MISSING.get(kind) if rng.random() < 0.5 else float("nan") if kind in NAN and rng.random() < 0.7 else None
    cells = [word if lost else value for value, lost in zip(drawn, gone, strict=True)]
    if kind.startswith("timestamp"):
        return pa.array(cells, pa.int64()).cast(dtype)
    if kind == "date":
        return pa.array(cells, pa.int32()).cast(dtype)
    return pa.array(cells, pa.string()).dictionary_encode() if kind == "category" else pa.array(cells, dtype)


@dataclass(frozen=True, eq=False)
class RandomTable:
    """A table as a Parquet file, and how its columns become features."""

    path: Path
    kinds: tuple[str, ...]
    columns: Columns
    features: NDArray[np.float64]


def random_table(rng: Rng, path: Path, kinds: tuple[str, ...], n: int = 40, doubled: bool = False) -> RandomTable:
    """Write a table with a column of each of some types, and return it."""
    missing = [float(rng.choice([0.0, 0.2])) for _ in kinds]
    names = [f"{kind} {k}" for k, kind in enumerate(kinds)]
    cells = [column_of(rng, kind, n, share) for kind, share in zip(kinds, missing, strict=True)]
    pq.write_table(pa.table({**dict(zip(names, cells, strict=True)), ROW: pa.array(range(n))}), path)
    frame = pq.read_table(path).to_pandas(ignore_metadata=True).drop(columns=ROW)
    categories: Any = rng.choice(["yes-no", "subsets", "order"])
    columns = Columns.learn(frame, categories=categories, doubled=doubled)
    return RandomTable(path, kinds, columns, columns.encode(frame))


ANSWERS: tuple[tuple[Any, ...], ...] = (
    ("it's", "bad", 'a "good" one', "Ä", "x -- y"),
    (-3, 0, 7, 2**40, 12),
    (0.1, 1e-300, 2.5, -1e22, 1 / 3),
    (False, True),
)
"""Classes: texts, whole numbers, numbers, Booleans."""


def random_tree(rng: Rng, table: RandomTable, n_classes: int, depth: int) -> Node:
    """Return a random tree over the features of a table: of numbers where there are no classes."""
    has_sides = table.columns.lack_numbers
    values = table.features
    added = _summands(table)

    def terms() -> tuple[tuple[int, ...], tuple[float, ...]]:
        chosen = sorted(rng.choice(added, min(2, len(added)), replace=False).tolist())
        return tuple(chosen), tuple(rng.normal(size=len(chosen)).tolist())

    def leaf() -> Leaf:
        if n_classes:
            return Leaf(int(rng.integers(n_classes)))
        number = float(rng.normal() * 10.0 ** rng.integers(-5, 6))
        return ValueLeaf(number, *(terms() if added and rng.random() < 0.3 else ((), ())))

    def grown(levels: int) -> Node:
        if not levels or rng.random() < 0.15:
            return leaf()
        if added and not has_sides and rng.random() < 0.1:
            features, coefficients = terms()
            totals = (values[:, features] * coefficients).sum(axis=1)
            return HyperplaneSplit(features, coefficients, float(rng.choice(totals)), grown(levels - 1), leaf())
        feature = int(rng.integers(values.shape[1]))
        seen = np.unique(values[:, feature][~np.isnan(values[:, feature])])
        at = int(rng.integers(len(seen)))
        threshold = midpoint(seen[at], seen[min(at + 1, len(seen) - 1)])
        side: Side | None = ("left", "right")[int(rng.integers(2))] if has_sides else None
        asked = None if has_sides and rng.random() < 0.1 else threshold
        return Split(feature, asked, grown(levels - 1), grown(levels - 1), missing=side)

    return grown(depth)


def _summands(table: RandomTable) -> list[int]:
    """Return the features that a sum may add: no dates, which databases count in different ways, none missing."""
    forms = {column.name: column.form for column in table.columns.columns}
    return [
        j
        for j, feature in enumerate(table.columns.features)
        if not forms[feature.column] and not np.isnan(table.features[:, j]).any()
    ]


def answers_of(tree: Node, table: RandomTable, classes: tuple[Any, ...]) -> list[Any]:
    """Return what `predict` answers for every row."""
    if not classes:
        return list(predict_values(tree, table.features).tolist())
    return [classes[code] for code in predict(tree, table.features).tolist()]
