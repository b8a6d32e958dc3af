"""A flight as readings: steady commands in the coordinates of the mixing, how they differ by the way, what shakes.

Both logs give the commands of thrust, roll, pitch and yaw: log B as such, log A through the mixing of its four motors.
They are counted in grams of one rotor, so that +1 of each is +1 g on M3's pattern (1, 1, -1, 1).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray

GRAMS = 15.0 / 65536.0
"""Nominal thrust of one rotor by its command [g]."""
AXES = ("thrust", "roll", "pitch", "yaw")
SHAKEN = {"A": ("ax", "ay", "az"), "B": ("gyro_roll", "gyro_pitch", "gyro_yaw", "acc_z")}
TIED = {"A": (("ax", "ay"), ("ax", "az"), ("ay", "az")), "B": (("gyro_roll", "gyro_pitch"), ("gyro_pitch", "gyro_yaw"))}
"""Channels whose steps go together or against each other, by which rotor is out of balance."""
HEIGHT, SETTLE, LEAVE, HALFWAY = 0.42, 0.4, 0.15, 14.5
"""Least height of the hover [m]; cut off its beginning and end [s]; time between the two hovers [s]."""
OUT, BACK = (6.2, 9.2), (20.1, 23.1)
"""Stretches in which the flight moves along x, forward and back [s]."""

STEADY = (*AXES, "yaw_way")
READINGS = (
    *STEADY,
    *(f"step_{axis}" for axis in AXES),
    *(f"shake_{name}" for names in SHAKEN.values() for name in names),
    *(f"tie_{one}_{other}" for pairs in TIED.values() for one, other in pairs),
)


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """Readings of one flight.

    Attributes
    ----------
    name, airframe, log, role
        as the table of tests gives them.
    readings
        (n_readings,) in the order of `READINGS`; NaN is not logged.
    out, back
        (4,) steady commands of the first and the second hover [g].
    """

    name: str
    airframe: str
    log: str
    role: str
    readings: FloatArray
    out: FloatArray
    back: FloatArray


def commands(table: pd.DataFrame) -> FloatArray:
    """Return thrust, roll / 2, pitch / 2 and yaw commands (n, 4) [g]: the mixing solved for them in log A."""
    if "m1" in table:
        m1, m2, m3, m4 = table[["m1", "m2", "m3", "m4"]].to_numpy(dtype=float).T
        columns = [m1 + m2 + m3 + m4, m3 + m4 - m1 - m2, m1 + m4 - m2 - m3, m1 - m2 + m3 - m4]
        return np.asarray(np.column_stack(columns) / 4.0 * GRAMS)
    given = table[["cmd_thrust", "cmd_roll", "cmd_pitch", "cmd_yaw"]].to_numpy(dtype=float)
    return np.asarray(given * np.array([1.0, 0.5, 0.5, 1.0]) * GRAMS)


def hovers(table: pd.DataFrame) -> list[tuple[float, float]]:
    """Return begin and end of the hover on the way out and of that on the way back [s]."""
    time, high = table["time"].to_numpy(dtype=float), table["z"].to_numpy(dtype=float) > HEIGHT
    parts = [time[high & (time < HALFWAY)], time[high & (time > HALFWAY)]]
    return [(float(part[0]) + SETTLE, float(part[-1]) - LEAVE) for part in parts]


def read_flight(folder: Path, name: str, airframe: str, log: str, role: str) -> Flight:
    """Return the readings of a flight."""
    table = pd.read_csv(folder / f"{name}.csv.gz")
    time, both, steady = table["time"].to_numpy(dtype=float), hovers(table), commands(table)
    out, back = (part.mean(axis=0) for part in _parts(time, steady, both))
    way = [float(part.mean()) for part in _parts(time, steady[:, 3], [OUT, BACK])]
    found = dict(zip(STEADY, (*(out + back) / 2.0, way[0] - way[1]), strict=True))
    for axis, column in zip(AXES, steady.T, strict=True):
        found[f"step_{axis}"] = float(np.log(_steps(time, column, both)))
    for channel in SHAKEN[log]:
        found[f"shake_{channel}"] = float(np.log(_steps(time, table[channel], both)))
    for one, other in TIED[log]:
        first, second = (table[name] / table[name].diff().std() for name in (one, other))
        joined, apart = (_steps(time, first + sign * second, both) ** 2 for sign in (1.0, -1.0))
        found[f"tie_{one}_{other}"] = (joined - apart) / (joined + apart)
    readings = np.array([found.get(reading, np.nan) for reading in READINGS])
    return Flight(name, airframe, log, role, readings, out, back)


def _parts(time: FloatArray, signal: FloatArray, stretches: Sequence[tuple[float, float]]) -> list[FloatArray]:
    """Return the samples of a signal in each stretch [s], both ends included."""
    return [signal[(time >= begin) & (time <= end)] for begin, end in stretches]


def _steps(time: FloatArray, signal: pd.Series | FloatArray, both: Sequence[tuple[float, float]]) -> float:
    """Return the rms over both hovers of the rms of the steps from sample to sample."""
    parts = _parts(time, np.asarray(signal, dtype=float), both)
    return float(np.sqrt(np.mean([np.mean(np.diff(part) ** 2) for part in parts])))


def read_flights(folder: Path) -> dict[str, Flight]:
    """Return all flights of a folder by name."""
    tests = pd.read_csv(folder / "tests.csv")
    return {
        str(row.flight): read_flight(folder, str(row.flight), str(row.airframe), str(row.log), str(row.role))
        for row in tests.itertuples()
    }
