"""From a recording to a campaign: the rows that each window makes.

The samples of a window remember one another, so they are no repeats. A window makes rows that are: means of stretches
of equal length, as many as its effective number allows. With the lag-1 correlation r of an AR(1) process,

    n_effective = n (1 - r) / (1 + r)

Each channel is averaged at its own rate over the same stretches. Source: Anderson (1971), section 8.2.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from octmip.errors import DataError
from octmip.formats.table import Source, Table
from octmip.formats.table.units import factor_between
from octmip.gap import Campaign, read_campaign
from octmip.recordings.assignment import fixed_names, in_unit, places_of, taken, without
from octmip.recordings.levels import How, equal_blocks, levels_of, words_of
from octmip.recordings.modes import modes_of
from octmip.recordings.recording import Channel, Floats, Recording
from octmip.recordings.statistics import Statistic, inside_of, refuse_bare, refuse_placeholders, statistic_of
from octmip.recordings.windows import STRETCHES, TOLERANCE, Window, moving, ordered, steady_windows
from octmip.twin import Twin, loads_of, units_of

FEWEST, MOST = 4, 24
"""Rows of the shortest window, where the longest has no more than so many: the diagnosis gains little from more."""
WORTH = 2.0
"""Independent samples that a row is worth at the least, where the window has so many."""
ENOUGH = 0.5
"""Share of its samples that must be valid for a mean."""
DIGITS = 9
"""Digits of a window's load: means of equal samples differ behind them, and would be two loads."""


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

    Examples
    --------
    >>> from octmip.gap import function_twin
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "um/m"}, loads=["force"])
    >>> time = np.arange(0.0, 60.0, 0.5)
    >>> force = np.where(time < 20.0, 0.0, np.where(time < 40.0, 5.0, 10.0))
    >>> series = Channel("force", "", time, force), Channel("g1", "um/m", time, 2.0 * force + 0.1 * np.sin(7.0 * time))
    >>> run = Recording("made here", {one.name: lambda one=one: one for one in series})
    >>> sorted(averages_of(run, twin).channels)
    ['force', 'g1']
    """

    windows: tuple[Window, ...]
    channels: Mapping[str, Channel]
    statistics: tuple[Mapping[str, Statistic], ...]
    table: Table


def averages_of(
    recording: Recording,
    twin: Twin,
    readings: Mapping[str, str] | None = None,
    loads: Mapping[str, str | float] | None = None,
    load_units: Mapping[str, str] | None = None,
    *,
    windows: Sequence[Window] = (),
    steady: Sequence[str] = (),
    least: float | None = None,
    tolerance: float = TOLERANCE,
    test: str = "",
    no_reading: Sequence[float] = (),
    modes: Mapping[str, float] | None = None,
    vibrations: Sequence[str] = (),
    levels: Mapping[str, How] | None = None,
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
    load_units
        unit in which the twin takes a load, by its name: a channel in another unit is converted.
    windows
        stretches of steady load; without them they are found.
    steady
        loads, or channels, that must stand still in a window that is found; all loads where none is named.
    least, tolerance
        as `steady_windows` takes them.
    test
        channel whose number is the name of each window's test.
    no_reading
        numbers by which the logger says that there is no reading.
    modes
        by the twin's name of a reading in Hz, or of a damping ratio, a frequency within a tenth of its mode's [Hz].
    vibrations
        channels by which the modes are identified (`octmip.recordings.modes`).
    levels
        by the twin's name of a reading, its largest or smallest sample ("max", "min") or its level in a band [Hz]
        instead of its mean (`octmip.recordings.levels`).

    Raises
    ------
    DataError
        a name or channel that is not there, another unit, no window, or a window without samples.

    Examples
    --------
    >>> from octmip.gap import function_twin
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "um/m"}, loads=["force"])
    >>> time = np.arange(0.0, 60.0, 0.5)
    >>> force = np.where(time < 20.0, 0.0, np.where(time < 40.0, 5.0, 10.0))
    >>> series = Channel("force", "", time, force), Channel("g1", "um/m", time, 2.0 * force + 0.1 * np.sin(7.0 * time))
    >>> run = Recording("made here", {one.name: lambda one=one: one for one in series})
    >>> found = averages_of(run, twin)
    >>> [(window.start, window.end) for window in found.windows]
    [(1.0, 19.0), (21.0, 39.0), (41.0, 58.0)]
    """
    modes, levels = modes or {}, levels or {}
    if bool(modes) != bool(vibrations):
        raise DataError(
            f"{len(modes)} modes and {len(vibrations)} vibrations; expected both: --modes f1=HERTZ says which modes, "
            "--vibrations CHANNEL by which channels; give the other"
        )
    places = places_of(recording, twin, readings or {}, loads or {}, modes, levels)
    numbers = {name: float(place) for name, place in places.items() if not isinstance(place, str)}
    own = {name: without(recording[place], no_reading) for name, place in places.items() if isinstance(place, str)}
    channels = {name: in_unit(one, (load_units or {}).get(name, one.unit)) for name, one in own.items()}
    told = [f"{recording.name} is a recording ({recording.format}); a row is the mean of a stretch of one window."]
    told += taken(own, channels)
    shaken = {name: without(recording[name], no_reading) for name in vibrations}
    channels = {**channels, **shaken}
    loaded = [channels[name] for name in loads_of(twin) if name in channels]
    if windows:
        windows = ordered(windows)
        told += moving(loaded, windows, tolerance)
    else:
        still = [channels[name] if name in channels else recording[name] for name in steady] or loaded
        windows, how = steady_windows(still, least, tolerance)
        told += how
    gauges, fixed = [name for name in twin.gauges if name in channels], [*numbers, *fixed_names(twin)]
    gauges += vibrations
    for window in windows:
        refuse_placeholders(channels, window)
    statistics = tuple({name: statistic_of(one, window) for name, one in channels.items()} for window in windows)
    for window, found in zip(windows, statistics, strict=True):
        refuse_bare(channels, found, window, gauges)
    shortest = min(window.end - window.start for window in windows)
    length = shortest / STRETCHES if modes or levels else _row_length(windows, statistics, gauges)
    tests = _tests(recording, windows, test)
    frames = []
    for window, found, name in zip(windows, statistics, tests, strict=True):
        edges = equal_blocks(window, length) if levels else _edges(found, window, length)
        frame = _rows(channels, found, edges).drop(columns=list(shaken))
        loaded_at = {key: numbers[key] if key in numbers else _rounded(found[key]) for key in fixed if key in places}
        modal = _modal(modes, twin, list(shaken.values()), window, len(frame)) if modes else {}
        peaks = {key: levels_of(channels[key], how, edges) for key, how in levels.items()}
        frames.append(frame.assign(test=name, **loaded_at, **modal, **peaks))
    rows = pd.concat(frames, ignore_index=True)
    if levels:
        n_missing = int(rows[list(levels)].isna().to_numpy().sum())
        told.append(
            f"Readings are no means but levels ({words_of(tuple(levels.items()))}) of blocks of {length:.4g} s, a row "
            f"each; {n_missing} of {len(rows) * len(levels)} are missing."
        )
    if modes:
        n = [int(rows[name].isna().sum()) for name in modes]
        told.append(
            f"Modes ({', '.join(modes)}) are identified by {len(vibrations)} channels, a row each {length:.4g} s "
            f"(SSI-cov of pyOMA-2); {sum(n)} of {rows.shape[0] * len(n)} are missing."
        )
    notes = (
        *recording.notes,
        *told,
        *_told(channels, windows, statistics, [name for name in gauges if name not in shaken]),
    )
    units = tuple((name, one.unit) for name, one in channels.items() if one.unit and name not in (load_units or {}))
    units += tuple((name, "Hz" if _is_frequency(twin, name) else "1") for name in modes)
    return Averages(windows, channels, statistics, Table(Source(Path(recording.name), "parquet"), rows, notes, units))


def campaign_of(averages: Averages, twin: Twin) -> Campaign:
    """Return the campaign of the windows of a recording, checked and converted as one from a file is.

    Raises
    ------
    DataError
        as `octmip.gap.read_campaign`.

    Examples
    --------
    >>> from octmip.gap import function_twin
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "um/m"}, loads=["force"])
    >>> time = np.arange(0.0, 60.0, 0.5)
    >>> force = np.where(time < 20.0, 0.0, np.where(time < 40.0, 5.0, 10.0))
    >>> series = Channel("force", "", time, force), Channel("g1", "um/m", time, 2.0 * force + 0.1 * np.sin(7.0 * time))
    >>> run = Recording("made here", {one.name: lambda one=one: one for one in series})
    >>> campaign = campaign_of(averages_of(run, twin), twin)
    >>> campaign.gauges, np.unique(campaign.load_factor).tolist()
    (('g1',), [0.0, 5.0, 10.0])
    """
    return read_campaign(averages.table, twin)


def _tests(recording: Recording, windows: Sequence[Window], channel: str) -> list[str]:
    """Return the name of each window's test."""
    whole = Path(recording.name).name  # a stem such as max is the name of a statistic
    if not channel:
        return [window.test or whole for window in windows]
    series, found = recording[channel], []
    for window in windows:
        inside = inside_of(series, window.start, window.end)
        values = np.unique(inside[np.isfinite(inside)])
        if len(values) != 1:
            raise DataError(
                f"{recording.name}: channel {channel} has {len(values)} numbers from {window.start:.6g} s to "
                f"{window.end:.6g} s; expected one, which says the test; give other windows, or leave --test out"
            )
        found.append(window.test or f"{channel.rpartition('/')[2]} {values[0]:g}")
    return found


def _row_length(
    windows: Sequence[Window], statistics: Sequence[Mapping[str, Statistic]], gauges: Sequence[str]
) -> float:
    """Return the time [s] that a row is the mean of: much the same in all windows, whose noise is pooled."""
    lengths = [window.end - window.start for window in windows]
    worth = [min(part[name].effective for name in gauges if part[name].effective > 0.0) for part in statistics]
    independent = float(np.median([WORTH * one / n for one, n in zip(lengths, worth, strict=True)]))
    return max(min(independent, min(lengths) / FEWEST), max(lengths) / MOST)


def _rounded(load: Statistic) -> float:
    """Return the mean of a load without the digits that its own spread leaves open."""
    error = load.sd / np.sqrt(load.effective)
    mean = float(f"{load.mean:.{DIGITS}g}")
    return round(mean, int(np.ceil(1.0 - np.log10(error)))) if error > 0.0 else mean


def _edges(found: Mapping[str, Statistic], window: Window, length: float) -> Floats:
    """Return the edges of the rows of a window, each about so long."""
    n = max(1, min(round((window.end - window.start) / length), max(one.n for one in found.values())))
    return np.linspace(window.start, window.end, n + 1)


def _rows(channels: Mapping[str, Channel], found: Mapping[str, Statistic], edges: Floats) -> pd.DataFrame:
    """Return the rows of a window: means between edges (n + 1,), NaN where too few samples are valid."""
    n = len(edges) - 1
    columns = {"time": 0.5 * (edges[1:] + edges[:-1])}
    for name, channel in channels.items():
        parts = [inside_of(channel, start, end) for start, end in itertools.pairwise(edges)]
        fewest = max(ENOUGH * found[name].n / n, 1.0)
        columns[name] = np.array([np.nanmean(one) if np.isfinite(one).sum() >= fewest else np.nan for one in parts])
    return pd.DataFrame(columns)


def _modal(
    modes: Mapping[str, float], twin: Twin, series: Sequence[Channel], window: Window, n: int
) -> dict[str, Floats]:
    """Return frequencies [Hz] and damping ratios (n_stretches,) by the twin's names."""
    near = sorted(set(modes.values()))
    found = modes_of(series, near, np.linspace(window.start, window.end, n + 1))
    return {
        name: found[:, near.index(frequency), 0 if _is_frequency(twin, name) else 1]
        for name, frequency in modes.items()
    }


def _is_frequency(twin: Twin, reading: str) -> bool:
    return factor_between("Hz", units_of(twin)[twin.gauges.index(reading)]) is not None


def _told(
    channels: Mapping[str, Channel],
    windows: Sequence[Window],
    statistics: Sequence[Mapping[str, Statistic]],
    gauges: Sequence[str],
) -> list[str]:
    """Return what was left out, how the rates differ, and what the means are worth."""
    said: dict[str, list[str]] = {}
    for name, channel in channels.items():
        for note in channel.notes():
            said.setdefault(note, []).append(name)
    told = [f"{', '.join(names)}: {note}." for note, names in said.items()]
    rates = dict.fromkeys(f"{1.0 / one.step:.4g} Hz" for one in channels.values() if one.step > 0.0)
    if len(rates) > 1:
        told.append(f"Channels have {len(rates)} rates ({', '.join(rates)}): each is averaged at its own.")
    known = [(k, name) for k, part in enumerate(statistics) for name in gauges if part[name].effective > 0.0]
    if not known:
        return told
    k, name = min(known, key=lambda place: statistics[place[0]][place[1]].effective / statistics[place[0]][place[1]].n)
    one = statistics[k][name]
    told.append(
        f"Samples remember one another: {one.n - one.n_invalid} samples of {name} from {windows[k].start:.6g} s on are "
        f"worth {one.effective:.3g} independent ones."
    )
    return told
