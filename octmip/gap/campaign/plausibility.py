"""Plausibility of readings beside the twin's predictions: other units, a reversed sign, copies, placeholders.

What no physics explains and a mistake in the file does is refused; what may be real is used, with a warning. Readings
are compared unit by unit. Strain is known well enough that a factor of 8 is another unit; of other readings, which may
resonate or slip, only a factor of `UNIT_FACTOR_ELSE` is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign
from octmip.twin import MICROSTRAIN, ONE_LOAD, load_of, load_words

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
"""Different readings in a column below which its slope says little."""
SCATTERED = 12
"""Readings that differ from the middle of their repeats, below which two columns with coarse steps may be equal."""


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Readings beside predictions.

    Attributes
    ----------
    campaign
        the readings.
    healthy
        (n_rows, n_gauges) what the twin predicts of the healthy state.
    sign
        what a positive reading is, as the twin says.
    chosen
        indices of the gauges that are looked at.
    """

    campaign: Campaign
    healthy: Floats
    sign: str
    chosen: tuple[int, ...]

    def of_units(self) -> "list[Sheet]":
        """Return the sheet of the gauges of each unit."""
        units = self.campaign.units
        return [
            replace(self, chosen=tuple(k for k in self.chosen if units[k] == unit)) for unit in dict.fromkeys(units)
        ]

    @property
    def readings(self) -> Floats:
        """(n_rows, n_chosen)."""
        return self.campaign.readings[:, self.chosen]

    @property
    def predicted(self) -> Floats:
        """(n_rows, n_chosen) of the healthy state."""
        return self.healthy[:, self.chosen]

    @property
    def unit(self) -> str:
        """Unit of the first gauge: of all of them in a sheet of one unit."""
        return self.campaign.units[self.chosen[0]]

    @property
    def is_microstrain(self) -> bool:
        """Whether the first gauge reads microstrain."""
        return self.unit == MICROSTRAIN

    @property
    def smallest_signal(self) -> float:
        """Predictions below this say nothing about the unit."""
        return SMALLEST_SIGNAL if self.is_microstrain else SMALLEST_SHARE * float(np.abs(self.predicted).max())

    @property
    def unit_factor(self) -> float:
        """Readings and twin further apart than this factor are in other units."""
        return UNIT_FACTOR if self.is_microstrain else UNIT_FACTOR_ELSE

    def where(self, rows: Sequence[int] = (0, -1)) -> str:
        """Return rows, by default all, and the gauges in words."""
        first, last = (self.campaign.row_number(range(len(self.healthy))[row]) for row in (rows[0], rows[-1]))
        names = [self.campaign.gauges[k] for k in self.chosen]
        at = f"row {first}" if first == last else f"rows {first} to {last}"
        return f"{at}, columns {names[0]} to {names[-1]}"

    def words(self, row: int) -> str:
        """Return the load of a row in words."""
        names = self.campaign.load_names
        return load_words(names, load_of(names, tuple(self.campaign.applied[row].tolist())))

    def slope(self, rows: NDArray[np.bool_] | None = None) -> tuple[float, float]:
        """Return readings over predictions by least squares, and their correlation; NaN where nothing is predicted."""
        kept = slice(None) if rows is None else rows
        x, y = self.predicted[kept].ravel(), self.readings[kept].ravel()
        used = np.isfinite(y) & (np.abs(x) > self.smallest_signal)
        x, y = x[used], y[used]
        largest = float(np.abs(y).max(initial=0.0))
        if largest == 0.0:
            return float("nan"), float("nan")
        y = y / largest  # squares of absurd readings overflow
        product = float(x @ y)
        return largest * product / float(x @ x), product / float(np.linalg.norm(x) * np.linalg.norm(y))

    def gauges(self) -> "list[tuple[str, Sheet]]":
        """Return every gauge's name and a sheet of it alone."""
        return [(self.campaign.gauges[k], replace(self, chosen=(k,))) for k in self.chosen]


def refuse_nonsense(sheet: Sheet) -> None:
    """Raise DataError for the first thing that no physics explains."""
    for check in (_refuse_units, _refuse_column_units, _refuse_absurd, _refuse_sign, _refuse_divided):
        for one in sheet.of_units():
            check(one)
    _refuse_twin_columns(sheet)


def _refuse_units(sheet: Sheet) -> None:
    """Compare the size of each row with the healthy prediction: a factor of 1000 is a unit, not an effect."""
    typical = np.median(np.abs(sheet.predicted), axis=1)
    tested = (typical > sheet.smallest_signal) & np.isfinite(sheet.readings).any(axis=1)
    if not tested.any():
        return
    size = np.nanmedian(np.abs(sheet.readings[tested]), axis=1)
    ratio = float(np.median(size / typical[tested]))
    if sheet.unit_factor**-1 < ratio < sheet.unit_factor:
        return
    row, names = int(np.flatnonzero(tested)[0]), sheet.campaign.load_names
    expected, cure = f"expected {sheet.unit}", "convert them"
    if sheet.is_microstrain and names == ONE_LOAD:
        expected += ", and a load factor that is 1 in steady level flight (no newtons, no per cent)"
    elif names and (np.ptp(sheet.predicted, axis=0).any() or len(sheet.campaign.loads) == 1):
        cure += f", or {' or '.join(names)} where it is the load that is in another unit than the twin's"
    at = f" at {sheet.words(row)}" if sheet.words(row) else ""
    raise DataError(
        f"{sheet.where([row])}: readings are {ratio:.3g} times what the twin predicts (median {size[0]:.3g} against "
        f"{typical[row]:.3g}{at}); {expected}; {cure}"
    )


def _refuse_absurd(sheet: Sheet) -> None:
    factor = ABSURD_FACTOR if sheet.is_microstrain else ABSURD_FACTOR_ELSE
    limit = factor * max(float(np.abs(sheet.predicted).max()), sheet.smallest_signal)
    bad = np.argwhere(np.abs(sheet.readings) > limit)
    if len(bad) and limit > 0.0:
        row, k = (int(part) for part in bad[0])
        raise DataError(
            f"row {sheet.campaign.row_number(row)}, column {sheet.campaign.gauges[sheet.chosen[k]]} is "
            f"{sheet.readings[row, k]:g}, more than {factor:g} times the greatest that the twin predicts; expected "
            f"{sheet.unit}; leave it empty if it was not recorded"
        )


def _refuse_sign(sheet: Sheet) -> None:
    _, correlation = sheet.slope()
    if not correlation < TURNED:
        return
    expected, cure = sheet.sign or f"the twin's sign of readings in {sheet.unit}", "reverse the sign of the readings"
    names = sheet.campaign.load_names
    if names == ONE_LOAD and sheet.is_microstrain:
        expected += ", and positive load factors for lift"
    if len(names) == 1:
        cure += f" or of the column {names[0]}"
    raise DataError(
        f"{sheet.where()}: readings have the opposite sign of the twin's (correlation {correlation:.2f}); expected "
        f"{expected}; {cure}"
    )


def _refuse_divided(sheet: Sheet) -> None:
    """Refuse readings divided by the load factor: right at load factor 1, half of what they should be at 2."""
    applied = sheet.campaign.applied[:, :1].ravel()
    greatest = float(np.abs(applied).max(initial=0.0))
    if sheet.campaign.load_names != ONE_LOAD or not sheet.is_microstrain or greatest < 2.0:
        return
    slopes = [sheet.slope(applied == load)[0] * load for load in np.unique(applied[applied != 0.0]).tolist()]
    if all(abs(slope - 1.0) < DIVIDED for slope in slopes):
        row = int(np.flatnonzero(np.abs(applied) == greatest)[0])
        raise DataError(
            f"{sheet.where([row])}: readings at {sheet.words(row)} are 1/{greatest:g} of what the twin predicts; "
            "expected microstrain at that load, not divided by the load factor; multiply them by it"
        )


def _refuse_column_units(sheet: Sheet) -> None:
    for name, one in sheet.gauges():
        slope, correlation = one.slope()
        is_stuck = len(np.unique(one.readings)) < DISTINCT  # reported with the noise
        if not is_stuck and correlation > 0.9 and not one.unit_factor**-1 < slope < one.unit_factor:
            first = sheet.campaign.row_number(int(np.flatnonzero(np.isfinite(one.readings))[0]))
            raise DataError(
                f"row {first}, column {name}: its readings follow the twin at {slope:.3g} times its size while the "
                f"other gauges fit; expected {sheet.unit} in every column; convert this one"
            )


def _refuse_twin_columns(sheet: Sheet) -> None:
    """Two gauges of an analogue chain never agree to the last digit: one column was copied."""
    first: dict[bytes, str] = {}
    for name, one in sheet.gauges():
        if _scattered(one) < SCATTERED:
            continue  # stuck, empty or coarse: two displays may show the same
        twin = first.setdefault(np.nan_to_num(one.readings, nan=-1e300).tobytes(), name)
        if twin != name:
            rows = sheet.where().partition(",")[0]
            raise DataError(
                f"{rows}: columns {twin} and {name} hold the same readings; expected each gauge's own; one was copied "
                "over the other: export them again"
            )


def _scattered(sheet: Sheet) -> int:
    """Return how many readings of the one gauge differ from the median of their repeats."""
    cells = (sheet.readings[cell.rows, 0] for cell in sheet.campaign.cells if len(cell.rows) > 1)
    recorded = (values[np.isfinite(values)] for values in cells)
    return sum(int((values != np.median(values)).sum()) for values in recorded if values.size)


def warnings_on(sheet: Sheet) -> list[str]:
    """Return a sentence on each thing that may be real but should be looked at, and on what is missing."""
    empty = [name for name, one in sheet.gauges() if not np.isfinite(one.readings).any()]
    notes = [f"Column {name} holds no reading; the gauge is not used." for name in empty]
    missing = float(np.isnan(sheet.readings).mean()) - len(empty) / len(sheet.chosen)
    if missing > 1e-9:
        notes.append(f"{100 * missing:.2g} % of the readings are missing; every mean uses what was recorded.")
    notes += [
        f"Column {name} has the opposite sign of the twin at every load: its bridge may be wired the wrong way round."
        for name, one in sheet.gauges()
        if one.slope()[1] < TURNED
    ]
    return [*notes, *_outliers(sheet)]


def _outliers(sheet: Sheet) -> list[str]:
    """Return a sentence on readings far from the other repeats, the first few by row and column."""
    left = np.full_like(sheet.readings, np.nan)
    for cell in (cell for cell in sheet.campaign.cells if len(cell.rows) >= FEW):
        enough = np.flatnonzero(cell.count >= FEW)
        here = sheet.readings[np.ix_(cell.rows, enough)]
        left[np.ix_(cell.rows, enough)] = here - np.nanmedian(here, axis=0)
    known = np.flatnonzero(np.isfinite(left).any(axis=0))
    sd = 1.4826 * np.nanmedian(np.abs(left[:, known]), axis=0)
    far = np.argwhere(np.abs(left[:, known]) > FAR_OUT * np.where(sd > 0.0, sd, np.inf))
    if not len(far):
        return []
    shown = "; ".join(
        f"row {sheet.campaign.row_number(row)}, column {sheet.campaign.gauges[known[k]]}: "
        f"{sheet.readings[row, known[k]]:g}"
        for row, k in far[:FEW].tolist()
    )
    return [
        f"{len(far)} reading{'s are' if len(far) > 1 else ' is'} more than {FAR_OUT:g} standard deviations from the "
        f"other repeats ({shown}): clear the cell if it is the logger's placeholder for no reading."
    ]
