"""From a recording to a campaign: which channels are readings, which loads, and the rows that each window makes.

The samples of a window remember one another, so they are no repeats. A window makes rows that are: means of stretches
of equal length, as many as its effective number allows,

    n_effective = n (1 - r) / (1 + r)

with the lag-1 correlation r of an AR(1) process. Each channel is averaged at its own rate over the same stretches.

Source: Wilks (2019), section 5.2.4, eq. 5.12.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from octmip.errors import DataError
from octmip.formats.table import Source, Table
from octmip.formats.table.units import unit_behind
from octmip.gap import Campaign, read_campaign
from octmip.input.messages import several, shown
from octmip.recordings.recording import Channel, Floats, Recording
from octmip.recordings.windows import TOLERANCE, Window, steady_windows
from octmip.twin import Twin, loads_of, state_parameters

FEWEST, MOST = 4, 12
"""Rows of one window: fewer say nothing of the noise, and the diagnosis gains little from more."""
ENOUGH = 0.5
"""Share of the usual number of valid samples that a mean needs."""
DIGITS = 9
"""Digits of a window's load: means of equal samples differ behind them, and would be two loads."""


@dataclass(frozen=True, slots=True)
class Statistic:
    """What a channel shows in a window.

    Attributes
    ----------
    n, n_invalid
        samples, and those of them that are left out.
    mean, sd
        of the valid samples, in the channel's unit; NaN of none.
    effective
        how many independent samples the mean is worth.
    """

    n: int
    n_invalid: int
    mean: float
    sd: float
    effective: float


@dataclass(frozen=True, slots=True, eq=False)
class Averages:
    """The windows of a recording and the rows that they make.

    Attributes
    ----------
    windows
        in the order of time.
    channels
        by the twin's name, loads first.
    statistics
        of each window, by the twin's name.
    table
        a campaign's table: `octmip.gap.read_campaign` takes it as it takes a file.
    """

    windows: tuple[Window, ...]
    channels: Mapping[str, Channel]
    statistics: tuple[Mapping[str, Statistic], ...]
    table: Table
    loads: tuple[str, ...] = field(default=())


def averages_of(
    recording: Recording,
    twin: Twin,
    readings: Mapping[str, str] | None = None,
    loads: Mapping[str, str | float] | None = None,
    *,
    windows: Sequence[Window] = (),
    steady: Sequence[str] = (),
    least: float | None = None,
    tolerance: float = TOLERANCE,
    test: str = "",
) -> Averages:
    """Return what a twin's readings and loads are in the windows of a recording.

    Parameters
    ----------
    recording, twin
        the samples, and who names readings and loads.
    readings
        channel by the twin's name for the reading; others are looked for under the twin's own name.
    loads
        channel, or a number that holds all along, by the name of a load, of a state or of "temperature".
    windows
        stretches of steady load; without them they are found.
    steady
        loads that must stand still in a window that is found; all where none is named.
    least, tolerance
        as `steady_windows` takes them.
    test
        channel whose number is the name of each window's test.

    Raises
    ------
    DataError
        a name or channel that is not there, no window, or a window without samples.
    """
    places = {**_found(recording, twin, readings or {}, loads or {})}
    numbers = {name: float(place) for name, place in places.items() if not isinstance(place, str)}
    channels = {name: recording[place] for name, place in places.items() if isinstance(place, str)}
    applied = tuple(name for name in loads_of(twin) if name in channels)
    told: tuple[str, ...] = ()
    if not windows:
        windows, told = steady_windows([_named(channels, name) for name in steady or applied], least, tolerance)
    windows = tuple(sorted(windows, key=lambda window: window.start))
    statistics = tuple({name: _statistic(one, window) for name, one in channels.items()} for window in windows)
    tests = _tests(recording, windows, test)
    rows = [
        _rows(channels, numbers, window, statistic, [*loads_of(twin), *state_parameters(twin)], name)
        for window, statistic, name in zip(windows, statistics, tests, strict=True)
    ]
    notes = (*recording.notes, *told, *_told(recording, channels, windows, statistics, len(rows[0])))
    units = tuple((name, one.unit) for name, one in channels.items() if one.unit)
    frame = pd.concat(rows, ignore_index=True)
    table = Table(Source(Path(recording.name), "parquet"), frame, notes, units)
    return Averages(windows, channels, statistics, table, applied)


def campaign_of(averages: Averages, twin: Twin) -> Campaign:
    """Return the campaign of the windows of a recording, checked and converted as one from a file is.

    Raises
    ------
    DataError
        as `octmip.gap.read_campaign`.
    """
    return read_campaign(averages.table, twin)


def _found(
    recording: Recording, twin: Twin, readings: Mapping[str, str], loads: Mapping[str, str | float]
) -> dict[str, str | float]:
    """Return channel or number by the twin's name, loads first."""
    others = (*loads_of(twin), *state_parameters(twin), "temperature")
    for given, known, what in ((readings, twin.gauges, "reading"), (loads, others, "load or state")):
        unknown = next((name for name in given if name not in known), None)
        if unknown is not None:
            raise DataError(f"the twin has no {what} {shown(unknown)}; expected {several(known, 12)}; use its names")
    named = {**{name: _by_name(recording, name) for name in (*others, *twin.gauges)}, **loads, **readings}
    missing = [name for name in loads_of(twin) if named[name] == ""]
    if missing:
        raise DataError(
            f"{recording.name}: no channel is the load {missing[0]!r}; expected --loads {missing[0]}=CHANNEL, or a "
            f"number that holds all along; its channels: {several(recording.channels, 12)}"
        )
    found = {name: _number_or(recording, named[name]) for name in (*others, *twin.gauges) if named[name] != ""}
    if not any(name in found for name in twin.gauges):
        raise DataError(
            f"{recording.name}: no channel is a reading of the twin ({several(twin.gauges, 6)}); expected --readings "
            f"{twin.gauges[0]}=CHANNEL; its channels: {several(recording.channels, 12)}"
        )
    return found


def _by_name(recording: Recording, name: str) -> str:
    """Return the channel of a name, or of this name with a unit behind it."""
    if found := recording.named(name):
        return found
    same = [one for one in recording.channels if unit_behind(one.rpartition("/")[2])[0] == name]
    return same[0] if len(same) == 1 else ""


def _number_or(recording: Recording, place: str | float) -> str | float:
    if isinstance(place, str) and place not in recording.channels:
        try:
            return float(place)
        except ValueError:
            return place
    return place


def _named(channels: Mapping[str, Channel], name: str) -> Channel:
    if name not in channels:
        raise DataError(
            f"--steady names {shown(name)}; expected a name of the twin that is a channel: {several(channels)}"
        )
    return channels[name]


def _inside(channel: Channel, start: float, end: float) -> Floats:
    """Return the samples (n,) of a stretch of time, NaN where they are not valid."""
    part = slice(*np.searchsorted(channel.time, (start, end)))
    return np.where(channel.is_valid[part], channel.values[part], np.nan)


def _statistic(channel: Channel, window: Window) -> Statistic:
    inside = _inside(channel, window.start, window.end)
    values = inside[np.isfinite(inside)]
    n = len(values)
    if not n:
        return Statistic(len(inside), len(inside), np.nan, np.nan, 0.0)
    rest = values - values.mean()
    power = float(rest @ rest)
    lag1 = float(rest[1:] @ rest[:-1]) / power if power > 0.0 else 0.0
    effective = n * (1.0 - max(lag1, 0.0)) / (1.0 + max(lag1, 0.0))
    sd = float(np.sqrt(power / (n - 1))) if n > 1 else np.nan
    return Statistic(len(inside), len(inside) - n, float(values.mean()), sd, max(effective, 1.0))


def _tests(recording: Recording, windows: Sequence[Window], channel: str) -> list[str]:
    """Return the name of each window's test."""
    whole = Path(recording.name).stem
    if not channel:
        return [window.test or whole for window in windows]
    series, found = recording[channel], []
    for window in windows:
        inside = _inside(series, window.start, window.end)
        values = np.unique(inside[np.isfinite(inside)])
        if len(values) != 1:
            raise DataError(
                f"{recording.name}: channel {channel} has {len(values)} numbers from {window.start:.6g} s to "
                f"{window.end:.6g} s; expected one, which says the test; give other windows, or leave --test out"
            )
        found.append(window.test or f"{channel.rpartition('/')[2]} {values[0]:g}")
    return found


def _rows(
    channels: Mapping[str, Channel],
    numbers: Mapping[str, float],
    window: Window,
    statistics: Mapping[str, Statistic],
    fixed: Sequence[str],
    test: str,
) -> pd.DataFrame:
    """Return the rows of a window: its loads and states, and the readings' means over stretches of equal length."""
    means = {name: statistics[name].mean for name in fixed if name in channels}
    bare = [name for name in channels if not np.isfinite(statistics[name].mean)]
    if len(bare) == len(channels) or any(name in means for name in bare):
        raise DataError(
            f"channel {channels[bare[0]].name} has no valid sample from {window.start:.6g} s to {window.end:.6g} s; it "
            f"is there from {channels[bare[0]].time[0]:.6g} s to {channels[bare[0]].time[-1]:.6g} s; move it"
        )
    averaged = [name for name in channels if name not in means]
    worth = min((statistics[name].effective for name in averaged if statistics[name].n > 1), default=1.0)
    fewest = min(FEWEST, max(statistics[name].n for name in averaged))
    n = int(np.clip(worth / 2.0, fewest, MOST))
    edges = np.linspace(window.start, window.end, n + 1)
    columns: dict[str, object] = {"test": [test] * n}
    columns |= {name: np.full(n, float(f"{value:.{DIGITS}g}")) for name, value in (means | dict(numbers)).items()}
    columns["time"] = 0.5 * (edges[1:] + edges[:-1])
    for name in averaged:
        parts = [_inside(channels[name], a, b) for a, b in itertools.pairwise(edges)]
        needed = ENOUGH * statistics[name].n / n
        columns[name] = [
            float(np.nanmean(part)) if np.isfinite(part).sum() > max(needed, 0.0) else np.nan for part in parts
        ]
    return pd.DataFrame(columns)


def _told(
    recording: Recording,
    channels: Mapping[str, Channel],
    windows: Sequence[Window],
    statistics: Sequence[Mapping[str, Statistic]],
    n_rows: int,
) -> list[str]:
    """Return what was left out, how the rates differ, and what the means are worth."""
    told = [f"{recording.name} is a recording ({recording.format}); a row is the mean of a stretch of one window."]
    said: dict[str, list[str]] = {}
    for name, channel in channels.items():
        for note in channel.notes():
            said.setdefault(note, []).append(name)
    told += [f"{', '.join(names)}: {note}." for note, names in said.items()]
    steps = {name: channel.step for name, channel in channels.items() if channel.step > 0.0}
    rates = dict.fromkeys(f"{1.0 / step:.4g} Hz" for step in steps.values())
    if len(rates) > 1:
        told.append(f"Channels have {len(rates)} rates ({', '.join(rates)}): each is averaged at its own.")
    least = min(
        ((one.effective, name, k) for k, part in enumerate(statistics) for name, one in part.items() if one.n > 1),
        default=None,
    )
    if least is not None:
        one = statistics[least[2]][least[1]]
        told.append(
            f"Samples remember one another: {one.n - one.n_invalid} samples of {least[1]} from "
            f"{windows[least[2]].start:.6g} s on are worth {least[0]:.3g} independent ones."
        )
    return told
