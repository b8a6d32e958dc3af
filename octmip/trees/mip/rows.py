"""Rows: a mixed-integer model as arrays, built a whole family of columns or rows at a time.

    minimise cost @ x + offset   subject to   row_lower <= A x <= row_upper,  lower <= x <= upper,  some x integer

A family of columns is an array of column indices, shaped like its subscripts: ``a = rows.columns("a", (p, branches))``.
A family of rows is given by its terms, each an array of columns (n_rows, n_terms) with coefficients of that shape:

    rows.add("one leaf", 1, 1, (z, 1.0))          # sum_t z[i, t] = 1 for every i
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count, product
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

Columns = NDArray[np.int64]
Term = tuple[Columns, NDArray[Any] | float]
LimitCheck = Callable[[], None]

BYTES_OF_ENTRY = 40  # row, column, value, and the passes that make a matrix of them
BYTES_OF_COLUMN = 80


@dataclass(slots=True, eq=False)
class Rows:
    """A mixed-integer model under construction.

    Attributes
    ----------
    limit_check
        called before every family with the size [bytes] of the model with it; may raise at a limit.
    """

    limit_check: Callable[[float], None] | None = None
    offset: float = 0.0
    n_columns: int = 0
    n_rows: int = 0
    families: dict[str, tuple[Columns, tuple[tuple[int, ...], ...]]] = field(default_factory=dict)
    row_families: list[tuple[str, int]] = field(default_factory=list)
    _columns: list[tuple[NDArray[np.float64], ...]] = field(default_factory=list)
    _entries: list[tuple[Columns, Columns, NDArray[np.float64]]] = field(default_factory=list)
    _bounds: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = field(default_factory=list)
    _n_entries: int = 0
    _matrix: sp.csr_array | None = None  # what `matrix` made of the entries so far

    def check_limits(self, columns: int = 0, entries: int = 0) -> None:
        """Call `limit_check` with the size of the model and so many more columns and entries."""
        if self.limit_check is not None:
            size = (self.n_columns + columns) * BYTES_OF_COLUMN + (self._n_entries + entries) * BYTES_OF_ENTRY
            self.limit_check(float(size))

    def columns(
        self,
        letter: str,
        axes: Sequence[Sequence[int]],
        lower: ArrayLike = 0.0,
        upper: ArrayLike = 1.0,
        *,
        cost: ArrayLike = 0.0,
        integer: bool = False,
    ) -> Columns:
        """Add a family of columns with the given subscripts and return their indices, one axis for each."""
        shape = tuple(len(axis) for axis in axes)
        size = math.prod(shape)
        self.check_limits(columns=size)
        index = np.arange(self.n_columns, self.n_columns + size, dtype=np.int64).reshape(shape)
        values = (lower, upper, cost, float(integer))
        self._columns.append(tuple(np.broadcast_to(np.asarray(v, dtype=float), shape).ravel() for v in values))
        self.families[letter] = (index, tuple(tuple(axis) for axis in axes))
        self.n_columns += size
        return index

    def add(self, name: str, lower: ArrayLike, upper: ArrayLike, *terms: Term) -> None:
        """Add a family of rows: ``lower <= sum of coefficients * columns <= upper``, one row for each term row.

        Rows without a coefficient that hold anyway are left out: they are none to some solvers.
        """
        n_rows = max(len(np.atleast_2d(columns)) for columns, _ in terms)
        self.check_limits(entries=n_rows * sum(np.atleast_2d(columns).shape[1] for columns, _ in terms))
        self._matrix = None
        low, high = (np.broadcast_to(np.asarray(end, dtype=float), (n_rows,)) for end in (lower, upper))
        is_row = (low > 0) | (high < 0)
        entries = []
        for columns, coefficients in terms:
            wide = np.atleast_2d(columns)
            full = np.broadcast_to(wide, (n_rows, wide.shape[1]))
            numbers = np.broadcast_to(np.asarray(coefficients, dtype=float), full.shape)
            is_row = is_row | (numbers != 0).any(axis=1)
            entries.append((full, numbers))
        place = self.n_rows + np.cumsum(is_row) - 1
        for full, numbers in entries:
            keep = numbers != 0
            self._entries.append((np.repeat(place, full.shape[1])[keep.ravel()], full[keep], numbers[keep]))
            self._n_entries += len(self._entries[-1][0])
        self._bounds.append((low[is_row], high[is_row]))
        self.row_families.append((name, int(is_row.sum())))
        self.n_rows += self.row_families[-1][1]

    def _stack(self, position: int) -> NDArray[np.float64]:
        return np.concatenate([block[position] for block in self._columns])

    @property
    def lower(self) -> NDArray[np.float64]:
        """Lower bounds of the columns."""
        return self._stack(0)

    @property
    def upper(self) -> NDArray[np.float64]:
        """Upper bounds of the columns."""
        return self._stack(1)

    @property
    def cost(self) -> NDArray[np.float64]:
        """Objective coefficients of the columns."""
        return self._stack(2)

    @property
    def is_integer(self) -> NDArray[np.bool_]:
        """Mask of the integer columns."""
        return self._stack(3) > 0

    @property
    def row_bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper bounds of the rows."""
        low, high = zip(*self._bounds, strict=True)
        return np.concatenate(low), np.concatenate(high)

    def matrix(self) -> sp.csr_array:
        """Return A (n_rows, n_columns); coefficients given twice are added."""
        if self._matrix is None or self._matrix.shape[1] != self.n_columns:
            row, column, value = (np.concatenate(part) for part in zip(*self._entries, strict=True))
            self._matrix = sp.coo_array((value, (row, column)), shape=(self.n_rows, self.n_columns)).tocsr()
            self._matrix.eliminate_zeros()
        return self._matrix

    @property
    def n_entries(self) -> int:
        """Number of coefficients given so far."""
        return self._n_entries

    def objective(self, values: NDArray[np.float64]) -> float:
        """Return the objective at `values` (n_columns,)."""
        return float(self.cost @ values) + self.offset

    def violation(self, values: NDArray[np.float64]) -> tuple[float, str]:
        """Return by how much `values` (n_columns,) break the worst row, bound or integrality, and which that is."""
        activity = self.matrix() @ values
        low, high = self.row_bounds
        by_row = np.maximum(low - activity, activity - high)
        by_column = np.maximum(self.lower - values, values - self.upper)
        by_column = np.maximum(by_column, np.where(self.is_integer, np.abs(values - np.round(values)), 0.0))
        if by_row.max(initial=0.0) >= by_column.max():
            return float(by_row.max(initial=0.0)), self.row_name(int(by_row.argmax())) if self.n_rows else ""
        return float(by_column.max()), self.column_names()[int(by_column.argmax())]

    def row_name(self, row: int) -> str:
        """Return the family of a row and its place in it."""
        return self.row_names()[row]

    def row_names(self) -> list[str]:
        """Return the names of all rows: family and place in it, ``left[7]``; a family may be added in parts."""
        places = defaultdict[str, Iterator[int]](count)
        return [f"{name}[{next(places[name])}]" for name, n_rows in self.row_families for _ in range(n_rows)]

    def column_names(self) -> list[str]:
        """Return the names of all columns: letter and subscripts, ``a[3,1]``."""
        return [
            f"{letter}[{','.join(map(str, key))}]"
            for letter, (_, axes) in self.families.items()
            for key in product(*axes)
        ]
