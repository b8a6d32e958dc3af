"""The least number of errors of trees whose splits ask for any set of texts, of a small table: every tree is looked at.

Knows nothing of octmip: a split of a column of texts is a set of its texts, one of a column of numbers a threshold.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

Row = tuple[Any, ...]


def least_errors(rows: Sequence[Row], labels: Sequence[Any], depth: int) -> int:
    """Return the least errors on rows of cells, texts (None where missing) or numbers, at a depth."""
    here = len(labels) - max(labels.count(label) for label in set(labels)) if labels else 0
    if depth == 0 or here == 0:
        return here
    for is_left in _splits(rows):
        sides = [[k for k, left in enumerate(is_left) if left == side] for side in (True, False)]
        parts = [([rows[k] for k in side], [labels[k] for k in side]) for side in sides]
        here = min(here, sum(least_errors(*part, depth - 1) for part in parts))
    return here


def _splits(rows: Sequence[Row]) -> Iterator[list[bool]]:
    """Yield which rows each split sends left; both sides hold some."""
    for column in range(len(rows[0])):
        cells = [row[column] for row in rows]
        if all(isinstance(cell, float) for cell in cells):
            yield from ([cell <= cut for cell in cells] for cut in sorted(set(cells))[:-1])
            continue
        texts = sorted(set(cells), key=str)
        for size in range(1, len(texts)):
            yield from ([cell in chosen for cell in cells] for chosen in combinations(texts, size))
