"""Campaign: what was measured, one row per reading, grouped into cells of one test, one state and one load.

Readings are in the twin's units and signs at their load (never divided by it); NaN is "not recorded". A state
parameter that is NaN is unknown: it is marginalised, not guessed. All rows of one test share one state.

Beside it: `Fault`, what one channel does wrong.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.twin import MICROSTRAIN, ONE_LOAD, Load, amounts_of, load_of, load_words


@dataclass(frozen=True, slots=True, eq=False)
class Fault:
    """Readings of one channel that are left out.

    Attributes
    ----------
    kind
        "stuck", "clipped" or "jump".
    gauge
        name of the channel.
    rows
        (n,) rows of the campaign.
    words
        a sentence on it.
    value
        where it stands still or ends, or by how much it jumps, in the unit of its readings.
    first
        first row of it; of a jump the first one after it.
    """

    kind: str
    gauge: str
    rows: NDArray[np.int64]
    words: str
    value: float
    first: int


FEWEST_DEGREES = 2
"""Repeats beyond the first of each cell, of one gauge over all cells, with fewer of which nothing is known of noise."""
ROUNDING = 1e-12
"""Standard deviation over the greatest reading up to which repeats are equal: means round in the last digits."""
ENOUGH_FOR_HALVES = 16
"""Repeats from which a cell is averaged in two halves where time matters."""


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """The mean of the repeats of one test at one load, or of half of them where an effect depends on time.

    Attributes
    ----------
    test
        name of the test.
    load
        of all its rows: a float where the campaign has one load, else all of them by name.
    state
        (n_parameters,) values; NaN where unknown.
    rows
        (n_repeats,) rows of the campaign, in the order of recording.
    mean
        (n_gauges,) mean reading; NaN where nothing was recorded.
    count
        (n_gauges,) recorded repeats.
    time
        mean time since the first reading of the campaign [s]; 0 where no time was recorded.
    moments
        (n_repeats,) when they were read, in steps from one reading to the next, the campaign's first at 1.
    number
        which of the campaign's cells it is, or is half of.
    load_names
        names of the loads.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> [(cell.load, cell.mean.tolist()) for cell in gathered(twin, [Recorded([[3.0], [1.0]], {"force": 1.0})]).cells]
    [(1.0, [2.0])]
    """

    test: str
    load: Load
    state: NDArray[np.float64]
    rows: NDArray[np.int64]
    mean: NDArray[np.float64]
    count: NDArray[np.int64]
    time: float
    moments: NDArray[np.float64]
    number: int
    load_names: tuple[str, ...] = ONE_LOAD

    @property
    def load_factor(self) -> float:
        """The load, where the campaign has one.

        Raises
        ------
        DataError
            it has several or none.
        """
        if isinstance(self.load, float):
            return self.load
        raise DataError(f"{self.name}: the campaign has {len(self.load_names)} loads; expected one; ask for Cell.load")

    @property
    def load_words(self) -> str:
        """The load in words, such as "load factor 2"; "" where nothing is applied."""
        return load_words(self.load_names, self.load)

    @property
    def is_known(self) -> bool:
        """Whether every state parameter was given."""
        return bool(np.isfinite(self.state).all())

    @property
    def name(self) -> str:
        """Test and load in words."""
        return f"{self.test} at {self.load_words}" if self.load_words else self.test

    def of_gauges(self, order: Sequence[int]) -> "Cell":
        """Return the means of these gauges, in their order."""
        return replace(self, mean=self.mean[list(order)], count=self.count[list(order)])


@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """Readings of the real asset.

    Attributes
    ----------
    gauges
        (n_gauges,) names, as the twin names them.
    parameters
        (n_parameters,) names of the state parameters.
    test
        (n_rows,) name of the test of each row.
    load_factor
        (n_rows,), or (n_rows, n_loads) where `load_names` are not one.
    states
        (n_rows, n_parameters); NaN is unknown.
    readings
        (n_rows, n_gauges) in the twin's units; NaN is missing.
    time
        (n_rows,) [s], or all NaN.
    temperature
        (n_rows,) [deg C], or all NaN.
    notes
        what the reader should know about the file, as sentences.
    numbers
        (n_rows,) line of each row in its file; empty when it came from no file.
    load_names
        names of the loads and settings.
    units
        (n_gauges,) of the readings; empty: all are microstrain.
    Derived:
        cells: the means, in the order of first appearance.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> gathered(twin, [Recorded([[2.1], [1.9]], {"force": 1.0})]).readings.tolist()
    [[2.1], [1.9]]
    """

    gauges: tuple[str, ...]
    parameters: tuple[str, ...]
    test: tuple[str, ...]
    load_factor: NDArray[np.float64]
    states: NDArray[np.float64]
    readings: NDArray[np.float64]
    time: NDArray[np.float64]
    temperature: NDArray[np.float64]
    notes: tuple[str, ...] = ()
    numbers: tuple[int, ...] = ()
    load_names: tuple[str, ...] = ONE_LOAD
    units: tuple[str, ...] = ()
    cells: tuple[Cell, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n = len(self.test)
        shapes = {
            "load_factor": (n,) if len(self.load_names) == 1 else (n, len(self.load_names)),
            "states": (n, len(self.parameters)),
            "readings": (n, len(self.gauges)),
            "time": (n,),
            "temperature": (n,),
        }
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.shape != shape:
                raise DataError(
                    f"campaign {name} has shape {array.shape}; expected {shape}, one row for each test name"
                )
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if n == 0 or not self.gauges:
            raise DataError(f"the campaign has {n} rows and {len(self.gauges)} gauges; expected at least one of each")
        self._check_rows()
        object.__setattr__(self, "cells", tuple(self._cells()))

    def _check_rows(self) -> None:
        applied = self.applied
        if not np.isfinite(applied).all():
            row, column = (int(k) for k in np.argwhere(~np.isfinite(applied))[0])
            name = self.load_names[column]
            raise DataError(
                f"row {row + 1}, column {name} is {applied[row, column]}; expected a finite number; give the "
                f"{name.replace('_', ' ')} of every reading"
            )
        if np.isinf(self.readings).any():
            row, column = (int(k) for k in np.argwhere(np.isinf(self.readings))[0])
            raise DataError(f"row {row + 1}, column {self.gauges[column]} is infinite; leave it empty if not recorded")
        if not np.isfinite(self.readings).any():
            raise DataError("the campaign holds no reading at all; expected numbers in the gauge columns")

    @property
    def applied(self) -> NDArray[np.float64]:
        """(n_rows, n_loads) of all loads."""
        return self.load_factor.reshape(len(self.test), len(self.load_names))

    def _load(self, row: int) -> Load:
        return load_of(self.load_names, tuple(self.applied[row].tolist()))

    def _cells(self) -> list[Cell]:
        keys: dict[tuple[object, ...], list[int]] = {}
        for row, test in enumerate(self.test):
            state = tuple(None if np.isnan(value) else float(value) for value in self.states[row])
            keys.setdefault((test, self._load(row), state), []).append(row)
        moments = self.moments
        rows_of = [np.array(rows, dtype=np.int64) for rows in keys.values()]
        start = float(np.nanmin(self.time)) if np.isfinite(self.time).any() else 0.0
        return [self._cell(rows, number, moments, start) for number, rows in enumerate(rows_of)]

    def _cell(self, rows: NDArray[np.int64], number: int, moments: NDArray[np.float64], start: float) -> Cell:
        readings, first = self.readings[rows], int(rows[0])
        count = np.isfinite(readings).sum(axis=0)
        time = self.time[rows][np.isfinite(self.time[rows])]
        return Cell(
            test=self.test[first],
            load=self._load(first),
            state=self.states[first],
            rows=rows,
            mean=np.where(count > 0, np.nansum(readings, axis=0) / np.maximum(count, 1), np.nan),
            count=count,
            time=float(time.mean()) - start if time.size else 0.0,
            moments=moments[rows],
            number=number,
            load_names=self.load_names,
        )

    def averages(self, split: bool) -> tuple[Cell, ...]:
        """Return the cells, or the earlier and later half of each where `split` and time was recorded."""
        if not split or not self.has_time:
            return self.cells
        moments, start, found = self.moments, float(np.nanmin(self.time)), list[Cell]()
        for cell in self.cells:
            rows = cell.rows[np.argsort(self.time[cell.rows], kind="stable")]
            halves = (rows[: len(rows) // 2], rows[len(rows) // 2 :]) if len(rows) >= ENOUGH_FOR_HALVES else ()
            found += [self._cell(half, cell.number, moments, start) for half in halves] or [cell]
        return tuple(found)

    @property
    def moments(self) -> NDArray[np.float64]:
        """(n_rows,) when each was read, in typical steps from one reading to the next, the first at 1.

        Rows count where no time was recorded: they are in the order of reading.
        """
        rows = np.arange(1.0, len(self.test) + 1.0)
        steps = np.diff(np.sort(self.time)) if self.has_time else np.zeros(0)
        steps = steps[steps > 0.0]
        return np.asarray(1.0 + (self.time - self.time.min()) / float(np.median(steps))) if steps.size else rows

    def unit_of(self, gauge: str) -> str:
        """Return the unit of a gauge's readings."""
        return self.units[self.gauges.index(gauge)] if self.units else MICROSTRAIN

    def row_number(self, row: int) -> int:
        """Return the number by which a reader finds a row: its line in the file, else its place counted from 1."""
        return self.numbers[row] if self.numbers else row + 1

    @property
    def has_time(self) -> bool:
        """Whether every row has a time."""
        return bool(np.isfinite(self.time).all())

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads, ascending."""
        return tuple(sorted({cell.load for cell in self.cells}, key=amounts_of))

    def load_words(self, load: Load) -> str:
        """Return a load of this campaign in words, such as "load factor 2"."""
        return load_words(self.load_names, load)

    @property
    def has_repeats(self) -> bool:
        """Whether the repeats of all cells together are enough to estimate the noise."""
        beyond = np.sum([np.maximum(cell.count - 1, 0) for cell in self.cells], axis=0)
        return int(beyond.max()) >= FEWEST_DEGREES

    def spreads(self) -> NDArray[np.float64]:
        """Return the standard deviation of the repeats of every cell (n_cells, n_gauges), NaN of fewer than two.

        It is 0 where repeats are equal but for the rounding of their mean.
        """
        found = np.full((len(self.cells), len(self.gauges)), np.nan)
        for k, cell in enumerate(self.cells):
            some = np.flatnonzero(cell.count > 1)
            found[k, some] = np.nanstd(self.readings[np.ix_(cell.rows, some)], axis=0, ddof=1)
        least = ROUNDING * np.abs(np.nan_to_num(self.readings)).max(axis=0)
        return np.where(found <= least, 0.0, found)

    @property
    def scatters(self) -> bool:
        """Whether some repeats differ."""
        return bool((self.spreads() > 0.0).any())

    def without(self, cells: set[int]) -> "Campaign":
        """Return the campaign without the cells of these positions in `cells` (held-out data)."""
        return self.of_rows(np.sort(np.concatenate([cell.rows for k, cell in enumerate(self.cells) if k not in cells])))

    def of_rows(self, rows: NDArray[np.int64]) -> "Campaign":
        """Return some of the rows (n,), in their order."""
        by_row = ("load_factor", "states", "readings", "time", "temperature")
        return replace(
            self,
            test=tuple(self.test[k] for k in rows.tolist()),
            numbers=tuple(self.numbers[k] for k in rows.tolist()) if self.numbers else (),
            **{name: getattr(self, name)[rows] for name in by_row},
        )
