"""Plausibility of readings beside the twin's predictions: other units, a reversed sign, copies, placeholders.

What no physics explains and a mistake in the file does is refused; what may be real is used, with a warning.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.twin import Load, amounts_of, load_words

Floats = NDArray[np.float64]

UNIT_FACTOR = 8.0
"""Readings and twin further apart than this factor are in other units (9.81 among them), not in another physics."""
ABSURD_FACTOR = 100.0
"""One reading beyond so many times the greatest prediction was never measured."""
SMALLEST_SIGNAL = 20.0
"""Predictions below this [microstrain] say nothing about the unit."""
TURNED = -0.9
"""Correlation of readings and twin below which the sign is reversed."""
DIVIDED = 0.1
"""Readings within this share of prediction over load factor were divided by the load factor."""
FAR_OUT = 15.0
"""Robust standard deviations from the other repeats beyond which a reading is reported as an outlier."""
FEW = 3
"""Repeats that an outlier needs beside it; most outliers that are reported."""
DISTINCT = 6
"""Different readings in a column below which two columns may be equal by chance."""


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Readings beside predictions.

    Attributes
    ----------
    numbers
        (n_rows,) line of each row in the file.
    tests
        (n_rows,) names.
    gauges
        (n_gauges,) names.
    load_names
        of the loads.
    loads
        (n_rows,) what was applied.
    readings
        (n_rows, n_gauges) [microstrain]; NaN is missing.
    healthy
        (n_rows, n_gauges) what the twin predicts of the healthy state [microstrain].
    """

    numbers: tuple[int, ...]
    tests: tuple[str, ...]
    gauges: tuple[str, ...]
    load_names: tuple[str, ...]
    loads: tuple[Load, ...]
    readings: Floats
    healthy: Floats

    @property
    def where(self) -> str:
        """All rows and gauges in words."""
        return f"rows {self.numbers[0]} to {self.numbers[-1]}, columns {self.gauges[0]} to {self.gauges[-1]}"

    def cells(self) -> list[NDArray[np.int64]]:
        """Return the rows of each test at each load."""
        found: dict[tuple[str, Load], list[int]] = {}
        for row, key in enumerate(zip(self.tests, self.loads, strict=True)):
            found.setdefault(key, []).append(row)
        return [np.array(rows, dtype=np.int64) for rows in found.values()]

    def words(self, row: int) -> str:
        """Return the load of a row in words."""
        return load_words(self.load_names, self.loads[row])

    def slope(self, rows: NDArray[np.bool_], gauges: list[int] | slice = slice(None)) -> tuple[float, float]:
        """Return readings over predictions by least squares, and their correlation; NaN where nothing is predicted."""
        x, y = self.healthy[rows][:, gauges].ravel(), self.readings[rows][:, gauges].ravel()
        used = np.isfinite(y) & (np.abs(x) > SMALLEST_SIGNAL)
        x, y = x[used], y[used]
        largest = float(np.abs(y).max(initial=0.0))
        if largest == 0.0:
            return float("nan"), float("nan")
        y = y / largest  # squares of absurd readings overflow
        product = float(x @ y)
        return largest * product / float(x @ x), product / float(np.linalg.norm(x) * np.linalg.norm(y))


def refuse_nonsense(sheet: Sheet) -> None:
    """Raise DataError for the first thing that no physics explains."""
    checks: tuple[Callable[[Sheet], None], ...] = (
        _refuse_silence,
        _refuse_equal,
        _refuse_units,
        _refuse_column_units,
        _refuse_absurd,
        _refuse_sign,
        _refuse_divided,
        _refuse_twin_columns,
        _refuse_copies,
    )
    for check in checks:
        check(sheet)


def _refuse_silence(sheet: Sheet) -> None:
    if not np.isfinite(sheet.readings).any():
        raise DataError(f"{sheet.where}: no reading at all; expected numbers; export the table with its values")


def _refuse_equal(sheet: Sheet) -> None:
    finite = sheet.readings[np.isfinite(sheet.readings)]
    if finite.size > 1 and np.ptp(finite) == 0.0:
        raise DataError(
            f"{sheet.where}: all {finite.size} readings are equal ({finite[0]:g}); expected measured values; the "
            "logger recorded nothing: check it and repeat the test"
        )


def _refuse_units(sheet: Sheet) -> None:
    """Compare the size of each row with the healthy prediction: a factor of 1000 is a unit, not an effect."""
    typical = np.median(np.abs(sheet.healthy), axis=1)
    seen = np.isfinite(sheet.readings).any(axis=1)
    size = np.full(len(typical), np.nan)
    size[seen] = np.nanmedian(np.abs(sheet.readings[seen]), axis=1)
    tested = (typical > SMALLEST_SIGNAL) & seen
    if not tested.any():
        return
    ratio = float(np.median(size[tested] / typical[tested]))
    if UNIT_FACTOR**-1 < ratio < UNIT_FACTOR:
        return
    row = int(np.flatnonzero(tested)[0])
    raise DataError(
        f"row {sheet.numbers[row]}, columns {sheet.gauges[0]} to {sheet.gauges[-1]}: readings are {ratio:.3g} times "
        f"what the twin predicts (median {size[row]:.3g} against {typical[row]:.3g} at "
        f"{sheet.words(row)}); expected microstrain, and a load factor that is 1 in steady level flight (no newtons, "
        "no per cent); convert them"
    )


def _refuse_absurd(sheet: Sheet) -> None:
    limit = ABSURD_FACTOR * max(float(np.abs(sheet.healthy).max()), SMALLEST_SIGNAL)
    bad = np.argwhere(np.abs(sheet.readings) > limit)
    if len(bad):
        row, gauge = (int(k) for k in bad[0])
        raise DataError(
            f"row {sheet.numbers[row]}, column {sheet.gauges[gauge]} is {sheet.readings[row, gauge]:g}, more than "
            f"{ABSURD_FACTOR:g} times the greatest strain that the twin predicts; expected microstrain; leave it empty "
            "if it was not recorded"
        )


def _refuse_sign(sheet: Sheet) -> None:
    _, correlation = sheet.slope(np.ones(len(sheet.tests), dtype=bool))
    if correlation < TURNED:
        raise DataError(
            f"{sheet.where}: readings have the opposite sign of the twin's (correlation {correlation:.2f}); expected "
            "compressive strain positive, and positive load factors for lift; reverse the sign of the readings or of "
            "the column load_factor"
        )


def _refuse_divided(sheet: Sheet) -> None:
    """Refuse readings divided by the load factor: right at load factor 1, half of what they should be at 2."""
    if len(sheet.load_names) != 1:
        return
    applied = np.array([amounts_of(load)[0] for load in sheet.loads])
    loads = [load for load in sorted(set(applied.tolist())) if load != 0.0]
    if not loads or max(np.abs(loads)) < 2.0:
        return
    slopes = [sheet.slope(applied == load)[0] * load for load in loads]
    if all(abs(slope - 1.0) < DIVIDED for slope in slopes):
        row = int(np.flatnonzero(np.abs(applied) == max(np.abs(loads)))[0])
        raise DataError(
            f"row {sheet.numbers[row]}, columns {sheet.gauges[0]} to {sheet.gauges[-1]}: readings at "
            f"{sheet.words(row)} are 1/{abs(applied[row]):g} of what the twin predicts; expected microstrain at "
            "that load, not divided by the load factor; multiply them by it"
        )


def _refuse_column_units(sheet: Sheet) -> None:
    rows = np.ones(len(sheet.tests), dtype=bool)
    for k, name in enumerate(sheet.gauges):
        if len(np.unique(sheet.readings[:, k])) < DISTINCT:
            continue  # stuck: reported with the noise
        slope, correlation = sheet.slope(rows, [k])
        if correlation > 0.9 and not UNIT_FACTOR**-1 < slope < UNIT_FACTOR:
            first = int(np.flatnonzero(np.isfinite(sheet.readings[:, k]))[0])
            raise DataError(
                f"row {sheet.numbers[first]}, column {name}: its readings follow the twin at {slope:.3g} times its "
                "size while the other gauges fit; expected microstrain in every column; convert this one"
            )


def _refuse_twin_columns(sheet: Sheet) -> None:
    """Two gauges of an analogue chain never agree to the last digit: one column was copied."""
    filled = np.nan_to_num(sheet.readings, nan=-1e300)
    first: dict[bytes, int] = {}
    for k, name in enumerate(sheet.gauges):
        if len(np.unique(filled[:, k])) < DISTINCT:
            continue  # stuck, empty or coarse: reported elsewhere
        twin = first.setdefault(np.ascontiguousarray(filled[:, k]).tobytes(), k)
        if twin != k:
            raise DataError(
                f"rows {sheet.numbers[0]} to {sheet.numbers[-1]}: columns {sheet.gauges[twin]} and {name} hold the "
                "same readings; expected each gauge's own; one was copied over the other: export them again"
            )


def _refuse_copies(sheet: Sheet) -> None:
    repeated = [rows for rows in sheet.cells() if len(rows) > 1]
    if not repeated:
        return
    for rows in repeated:
        spread = sheet.readings[rows] - sheet.readings[rows[0]]
        if np.nanmax(np.abs(spread), initial=0.0) > 0.0:
            return
    rows = repeated[0]
    raise DataError(
        f"rows {sheet.numbers[rows[0]]} to {sheet.numbers[rows[-1]]}, columns {sheet.gauges[0]} to {sheet.gauges[-1]}: "
        "the repeats of a load are copies of one reading, here and at every other load; expected readings that "
        "scatter, from which the noise is estimated; export every repeat"
    )


def warnings_on(sheet: Sheet) -> list[str]:
    """Return a sentence on each thing that may be real but should be looked at, and on what is missing."""
    return [*_missing(sheet), *_turned_gauges(sheet), *_outliers(sheet)]


def _missing(sheet: Sheet) -> list[str]:
    empty = [name for k, name in enumerate(sheet.gauges) if not np.isfinite(sheet.readings[:, k]).any()]
    notes = [f"Column {name} holds no reading; the gauge is not used." for name in empty]
    missing = float(np.isnan(sheet.readings).mean()) - len(empty) / len(sheet.gauges)
    if missing > 1e-9:
        notes.append(f"{100 * missing:.2g} % of the readings are missing; every mean uses what was recorded.")
    return notes


def _turned_gauges(sheet: Sheet) -> list[str]:
    rows = np.ones(len(sheet.tests), dtype=bool)
    return [
        f"Column {name} has the opposite sign of the twin at every load: its bridge may be wired the wrong way round."
        for k, name in enumerate(sheet.gauges)
        if sheet.slope(rows, [k])[1] < TURNED
    ]


def _outliers(sheet: Sheet) -> list[str]:
    """Return a sentence on readings far from the other repeats, the first few by row and column."""
    left = np.full_like(sheet.readings, np.nan)
    for rows in sheet.cells():
        here = sheet.readings[rows]
        enough = np.isfinite(here).sum(axis=0) >= FEW
        left[np.ix_(rows, np.flatnonzero(enough))] = here[:, enough] - np.nanmedian(here[:, enough], axis=0)
    if not np.isfinite(left).any():
        return []
    known = np.isfinite(left).any(axis=0)
    sd = np.full(left.shape[1], np.nan)
    sd[known] = 1.4826 * np.nanmedian(np.abs(left[:, known]), axis=0)
    far = np.argwhere(np.abs(left) > FAR_OUT * np.where(sd > 0.0, sd, np.inf))
    if not len(far):
        return []
    shown = "; ".join(
        f"row {sheet.numbers[row]}, column {sheet.gauges[gauge]}: {sheet.readings[row, gauge]:g}"
        for row, gauge in far[:FEW].tolist()
    )
    return [
        f"{len(far)} reading{'s are' if len(far) > 1 else ' is'} more than {FAR_OUT:g} standard deviations from the "
        f"other repeats ({shown}); used as recorded: clear the cell if it is the logger's placeholder for no reading."
    ]
