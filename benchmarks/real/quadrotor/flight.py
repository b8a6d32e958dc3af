"""A flight as readings: steady commands in the coordinates of the mixing, and how they differ by the way.

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
HEIGHT, SETTLE, LEAVE, HALFWAY = 0.42, 0.4, 0.15, 14.5
"""Least height of the hover [m]; cut off its beginning and end [s]; time between the two hovers [s]."""
OUT, BACK = (6.2, 9.2), (20.1, 23.1)
"""Stretches in which the flight moves along x, forward and back [s]."""

STEADY = (*AXES, "yaw_way")
WITHIN = dict(zip(STEADY, (0.07, 0.07, 0.07, 0.08, 0.11), strict=True))
"""Standard deviation of each within a day, settled on the commissioning flights left out one at a time [g]."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """Readings of one flight.

    Attributes
    ----------
    name, airframe, role
        as the table of tests gives them.
    readings
        (n_readings,) in the order of `STEADY` [g].
    """

    name: str
    airframe: str
    role: str
    readings: FloatArray


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


def read_flight(folder: Path, name: str, airframe: str, role: str) -> Flight:
    """Return the readings of a flight."""
    table = pd.read_csv(folder / f"{name}.csv.gz")
    time, steady = table["time"].to_numpy(dtype=float), commands(table)
    out, back = (part.mean(axis=0) for part in _parts(time, steady, hovers(table)))
    way = [float(part.mean()) for part in _parts(time, steady[:, 3], [OUT, BACK])]
    return Flight(name, airframe, role, np.array([*(out + back) / 2.0, way[0] - way[1]]))


def _parts(time: FloatArray, signal: FloatArray, stretches: Sequence[tuple[float, float]]) -> list[FloatArray]:
    """Return the samples of a signal in each stretch [s], both ends included."""
    return [signal[(time >= begin) & (time <= end)] for begin, end in stretches]


def read_flights(folder: Path) -> dict[str, Flight]:
    """Return all flights of a folder by name."""
    tests = pd.read_csv(folder / "tests.csv")
    return {
        str(row.flight): read_flight(folder, str(row.flight), str(row.airframe), str(row.role))
        for row in tests.itertuples()
    }
