"""Read a folder of damper tests: `tests.csv`, and one CSV a test.

A column is known by how its name begins (`displacement`, `force`, `velocity`, `tension`, `time`), its unit by how it
ends (`_in`, `_kip`, `_lb`; also mm, m, N, kN and lbf, which are converted). What a file lacks is no error as long as
time, displacement and force are there: velocity is then differentiated, a tension that is not recorded is NaN. Tests
sampled faster than `FASTEST` are averaged in blocks: no effect that is looked for is faster.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray
from octmip.errors import DataError

FASTEST = 160.0
"""Samples a second above which neighbours are averaged, to about 128 Hz."""
WANTED = 128.0

UNITS = {
    "displacement": {"in": 1.0, "mm": 1 / 25.4, "m": 1 / 0.0254},
    "velocity": {"in_s": 1.0, "mm_s": 1 / 25.4, "m_s": 1 / 0.0254},
    "force": {"kip": 1.0, "lb": 1e-3, "lbf": 1e-3, "kn": 1 / 4.4482216, "n": 1e-3 / 4.4482216},
    "tension": {"lb": 1.0, "lbf": 1.0, "kip": 1e3, "n": 1 / 4.4482216, "kn": 1e3 / 4.4482216},
    "amplitude": {"in": 1.0, "mm": 1 / 25.4, "m": 1 / 0.0254},
    "frequency": {"hz": 1.0},
    "time": {"s": 1.0, "ms": 1e-3},
}
"""Factor to in, in/s, kip, lb, Hz and s, by the end of a column's name; a name without a unit has these."""
NUMBER = {1: "one column", 2: "two columns"}


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """One test.

    Attributes
    ----------
    name, series
        as in tests.csv; a table without series is one series, "all".
    frequency, amplitude, nominal
        [Hz], [in] and [lb] as in tests.csv; measured from the displacement where the table does not say, nominal NaN.
    time, displacement, velocity, force
        (n_samples,) [s], [in], [in/s], [kip].
    tension
        (2, n_samples) at ends a and b [lb]; NaN where it was not recorded.
    is_turned
        whether the file's force has the other sign. A damper takes work, so its force is counted along the motion.
    """

    name: str
    series: str
    frequency: float
    amplitude: float
    nominal: float
    time: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    tension: FloatArray
    is_turned: bool = False

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))


def factor(kind: str, column: str) -> float:
    """Return the factor from a column's unit, the longest known end of its name, to that of this program."""
    known = UNITS[kind]
    ends = [unit for unit in known if column.lower().endswith("_" + unit)]
    return known[max(ends, key=len)] if ends else 1.0


def columns_of(table: pd.DataFrame, kind: str, path: Path, most: int = 1) -> list[FloatArray]:
    """Return the columns of that kind in the units of this program, in the order of their names, `most` at most."""
    names = sorted(str(name) for name in table.columns if str(name).lower().startswith(kind))
    if len(names) > most:
        raise DataError(
            f"{path} has more than {NUMBER[most]} whose name begins with {kind!r}: {names}; expected {most} at most; "
            "rename what is not meant"
        )
    return [_numbers(table, kind, name) for name in names]


def condition_of(table: pd.DataFrame, kind: str) -> FloatArray | None:
    """Return the first column of tests.csv whose name holds a kind (nominal_tension_lb), None where there is none."""
    names = sorted(str(name) for name in table.columns if kind in str(name).lower())
    return _numbers(table, kind, names[0]) if names else None


def _numbers(table: pd.DataFrame, kind: str, name: str) -> FloatArray:
    numbers = pd.to_numeric(table[name], errors="coerce").to_numpy(dtype=np.float64)
    return np.asarray(numbers * factor(kind, name))


def table_of(path: Path, **options: Any) -> pd.DataFrame:
    """Return a CSV file as a table."""
    try:
        table: pd.DataFrame = pd.read_csv(path, skipinitialspace=True, **options)
    except (ValueError, OSError) as error:
        raise DataError(f"{path} is no table ({error}); expected a header and numbers below it; correct it") from error
    return table


def read_folder(folder: Path) -> list[Recording]:
    """Return the tests of a folder, in the order of its table."""
    path = folder / "tests.csv"
    if not path.is_file():
        raise DataError(
            f"{path} is not there: the table of tests; got a folder without it; give --data a folder of tests"
        )
    table = table_of(path, dtype={"test": str, "series": str})
    if "test" not in table or not len(table):
        raise DataError(f"{path} needs a column 'test' with a name a row; got columns {list(table.columns)}; add it")
    conditions = {kind: condition_of(table, kind) for kind in ("frequency", "amplitude", "tension")}
    series = table["series"].fillna("all") if "series" in table else pd.Series("all", index=table.index)
    found = []
    for k, name in enumerate(table["test"]):
        told = {kind: float("nan") if column is None else float(column[k]) for kind, column in conditions.items()}
        found.append(read_test(folder / f"{name}.csv", str(name), str(series[k]), told))
    return found


def read_test(path: Path, name: str, series: str, told: dict[str, float]) -> Recording:
    """Return one test; `told` has what tests.csv says of frequency, amplitude and tension."""
    if not path.is_file():
        raise DataError(f"{path} is not there, but tests.csv names test {name!r}; add the file or drop the row")
    table = table_of(path)
    columns = {kind: columns_of(table, kind, path) for kind in ("time", "displacement", "force", "velocity")}
    if missing := [kind for kind in ("time", "displacement", "force") if not columns[kind]]:
        raise DataError(f"{path} has no column that begins with {missing[0]!r}; got {list(table.columns)}; add it")
    blank = np.full(len(table), np.nan)
    cells = [*columns_of(table, "tension", path, most=2), blank, blank][:2]
    if [str(name)[:9].lower() for name in table.columns if str(name).lower().startswith("tension")] == ["tension_b"]:
        cells.reverse()  # only the other end was recorded
    block = evenly(np.array([*((*columns[kind], blank)[0] for kind in columns), *cells]), path)
    time, displacement, force, velocity, *tension = block
    if not np.isfinite(velocity).all():
        velocity = np.gradient(displacement, time)
    frequency, amplitude = told["frequency"], told["amplitude"]
    if not frequency > 0.0:
        frequency = main_frequency(time, displacement)
    if not amplitude > 0.0:
        amplitude = float(np.ptp(displacement) / 2.0)
    is_turned = bool(force @ np.gradient(displacement) < 0.0)
    force = -force if is_turned else force
    ends = np.array(tension)
    return Recording(
        name, series, frequency, amplitude, told["tension"], time, displacement, velocity, force, ends, is_turned
    )


def evenly(block: FloatArray, path: Path) -> FloatArray:
    """Return rows (time, displacement, force, ...) in order of time, on even steps, not faster than `FASTEST`."""
    block = block[:, np.isfinite(block[:3]).all(axis=0)]
    block = block[:, np.unique(block[0], return_index=True)[1]]
    if block.shape[1] < 64:
        raise DataError(
            f"{path} has {block.shape[1]} complete samples; at least 64 are needed; give the whole recording"
        )
    step = float(np.median(np.diff(block[0])))
    if np.ptp(np.diff(block[0])) > step:
        even = np.arange(block[0, 0], block[0, -1], step)
        block = np.vstack([even, *(np.interp(even, block[0], row) for row in block[1:])])
    width = round(1.0 / (step * WANTED)) if step * FASTEST < 1.0 else 1
    n = block.shape[1] // width
    return np.asarray(block[:, : n * width].reshape(len(block), n, width).mean(axis=2))


def main_frequency(time: FloatArray, displacement: FloatArray) -> float:
    """Return the frequency of the largest line in the spectrum of the displacement [Hz]."""
    power = np.abs(np.fft.rfft(displacement - displacement.mean(), 8 * len(time)))
    return float(np.fft.rfftfreq(8 * len(time), float(np.median(np.diff(time))))[int(power.argmax())])
