"""Plausibility of readings beside the twin's predictions: other units, a reversed sign, copies, placeholders.

What no physics explains and a mistake in the file does is refused; what may be real is used, with a warning. Readings
are compared unit by unit. Strain is known well enough that a factor of 8 is another unit; of other readings, which may
resonate or slip, only a factor of `UNIT_FACTOR_ELSE` is.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.twin import MICROSTRAIN, ONE_LOAD, Load, amounts_of, load_words

Floats = NDArray[np.float64]

UNIT_FACTOR = 8.0
"""Readings and twin further apart than this factor are in other units (9.81 among them), not in another physics."""
UNIT_FACTOR_ELSE = 80.0
"""The same for readings that are no strain: a prefix (milli, kilo) is 1000, degrees and radians are 57."""
ABSURD_FACTOR = 100.0
"""One reading beyond so many times the greatest prediction was never measured."""
ABSURD_FACTOR_ELSE = 1e4
"""The same for readings that are no strain."""
SMALLEST_SIGNAL = 20.0
"""Predictions below this [microstrain] say nothing about the unit."""
SMALLEST_SHARE = 0.02
"""Predictions below this share of the greatest one say nothing about the unit, of readings that are no strain."""
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
        (n_rows, n_gauges) in `units`; NaN is missing.
    healthy
        (n_rows, n_gauges) what the twin predicts of the healthy state.
    units
        (n_gauges,) of the readings.
    sign
        what a positive reading is, as the twin says.
    """

    numbers: tuple[int, ...]
    tests: tuple[str, ...]
    gauges: tuple[str, ...]
    load_names: tuple[str, ...]
    loads: tuple[Load, ...]
    readings: Floats
    healthy: Floats
    units: tuple[str, ...]
    sign: str

    def of_units(self) -> "list[Sheet]":
        """Return the sheet of the gauges of each unit."""
        return [self._of([k for k, own in enumerate(self.units) if own == unit]) for unit in dict.fromkeys(self.units)]

    def _of(self, gauges: list[int]) -> "Sheet":
        return replace(
            self,
            gauges=tuple(self.gauges[k] for k in gauges),
            units=tuple(self.units[k] for k in gauges),
            readings=self.readings[:, gauges],
            healthy=self.healthy[:, gauges],
        )

    @property
    def unit(self) -> str:
        """Unit of the first gauge: of all of them in a sheet of one unit."""
        return self.units[0]

    @property
    def is_microstrain(self) -> bool:
        """Whether the first gauge reads microstrain."""
        return self.unit == MICROSTRAIN

    @property
    def smallest_signal(self) -> float:
        """Predictions below this say nothing about the unit."""
        return SMALLEST_SIGNAL if self.is_microstrain else SMALLEST_SHARE * float(np.abs(self.healthy).max(initial=0.0))

    @property
    def unit_factor(self) -> float:
        """Readings and twin further apart than this factor are in other units."""
        return UNIT_FACTOR if self.is_microstrain else UNIT_FACTOR_ELSE

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
        used = np.isfinite(y) & (np.abs(x) > self.smallest_signal)
        x, y = x[used], y[used]
        largest = float(np.abs(y).max(initial=0.0))
        if largest == 0.0:
            return float("nan"), float("nan")
        y = y / largest  # squares of absurd readings overflow
        product = float(x @ y)
        return largest * product / float(x @ x), product / float(np.linalg.norm(x) * np.linalg.norm(y))


def refuse_nonsense(sheet: Sheet) -> None:
    """Raise DataError for the first thing that no physics explains."""
    of_units = sheet.of_units()
    for check, sheets in (
        (_refuse_silence, [sheet]),
        (_refuse_equal, [sheet]),
        (_refuse_units, of_units),
        (_refuse_column_units, of_units),
        (_refuse_absurd, of_units),
        (_refuse_sign, of_units),
        (_refuse_divided, of_units),
        (_refuse_twin_columns, [sheet]),
        (_refuse_copies, [sheet]),
    ):
        for one in sheets:
            check(one)


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
    tested = (typical > sheet.smallest_signal) & seen
    if not tested.any():
        return
    ratio = float(np.median(size[tested] / typical[tested]))
    if sheet.unit_factor**-1 < ratio < sheet.unit_factor:
        return
    row = int(np.flatnonzero(tested)[0])
    expected, cure = f"expected {sheet.unit}", "convert them"
    if sheet.is_microstrain and sheet.load_names == ONE_LOAD:
        expected += ", and a load factor that is 1 in steady level flight (no newtons, no per cent)"
    elif sheet.load_names and (np.ptp(sheet.healthy, axis=0).any() or len(set(sheet.loads)) == 1):
        cure += f", or {' or '.join(sheet.load_names)} where it is the load that is in another unit than the twin's"
    at = f" at {sheet.words(row)}" if sheet.words(row) else ""
    raise DataError(
        f"row {sheet.numbers[row]}, columns {sheet.gauges[0]} to {sheet.gauges[-1]}: readings are {ratio:.3g} times "
        f"what the twin predicts (median {size[row]:.3g} against {typical[row]:.3g}{at}); {expected}; {cure}"
    )


def _refuse_absurd(sheet: Sheet) -> None:
    factor = ABSURD_FACTOR if sheet.is_microstrain else ABSURD_FACTOR_ELSE
    limit = factor * max(float(np.abs(sheet.healthy).max()), sheet.smallest_signal)
    bad = np.argwhere(np.abs(sheet.readings) > limit)
    if len(bad) and limit > 0.0:
        row, gauge = (int(k) for k in bad[0])
        raise DataError(
            f"row {sheet.numbers[row]}, column {sheet.gauges[gauge]} is {sheet.readings[row, gauge]:g}, more than "
            f"{factor:g} times the greatest that the twin predicts; expected {sheet.unit}; leave it empty if it was "
            "not recorded"
        )


def _refuse_sign(sheet: Sheet) -> None:
    _, correlation = sheet.slope(np.ones(len(sheet.tests), dtype=bool))
    if not correlation < TURNED:
        return
    expected, cure = sheet.sign or f"the twin's sign of readings in {sheet.unit}", "reverse the sign of the readings"
    if sheet.load_names == ONE_LOAD and sheet.is_microstrain:
        expected += ", and positive load factors for lift"
    if len(sheet.load_names) == 1:
        cure += f" or of the column {sheet.load_names[0]}"
    raise DataError(
        f"{sheet.where}: readings have the opposite sign of the twin's (correlation {correlation:.2f}); expected "
        f"{expected}; {cure}"
    )


def _refuse_divided(sheet: Sheet) -> None:
    """Refuse readings divided by the load factor: right at load factor 1, half of what they should be at 2."""
    if sheet.load_names != ONE_LOAD or not sheet.is_microstrain:
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
        if correlation > 0.9 and not sheet.unit_factor**-1 < slope < sheet.unit_factor:
            first = int(np.flatnonzero(np.isfinite(sheet.readings[:, k]))[0])
            raise DataError(
                f"row {sheet.numbers[first]}, column {name}: its readings follow the twin at {slope:.3g} times its "
                f"size while the other gauges fit; expected {sheet.unit} in every column; convert this one"
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
        for one in sheet.of_units()
        for k, name in enumerate(one.gauges)
        if one.slope(rows, [k])[1] < TURNED
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
