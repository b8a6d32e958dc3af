"""Which channel of a recording is which reading, load or state of a twin."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from octmip.errors import DataError
from octmip.formats.table.units import factor_between, unit_behind
from octmip.input.messages import several, shown
from octmip.recordings.recording import Channel, Recording
from octmip.twin import Twin, loads_of, state_parameters

TEMPERATURE = "temperature"


def fixed_names(twin: Twin) -> tuple[str, ...]:
    """Return the names of what has one value in a window: loads and states."""
    return (*loads_of(twin), *state_parameters(twin))


def places_of(
    recording: Recording,
    twin: Twin,
    readings: Mapping[str, str],
    loads: Mapping[str, str | float],
    modes: Mapping[str, float],
    levels: Mapping[str, object],
) -> dict[str, str | float]:
    """Return channel or number by the twin's name, loads first; names that nobody placed are looked for as they are.

    Readings that are modes have none.

    Raises
    ------
    DataError
        a name that the twin lacks, a load that is not there, or no reading.
    """
    others = (*fixed_names(twin), TEMPERATURE)
    for asked, known, what in (
        ({**readings, **modes, **levels}, twin.gauges, "reading"),
        (loads, others, "load or state"),
    ):
        unknown = next((name for name in asked if name not in known), None)
        if unknown is not None:
            raise DataError(f"the twin has no {what} {shown(unknown)}; expected {several(known, 12)}; use its names")
    given = {**loads, **readings}
    channelled = [name for name in (*others, *twin.gauges) if name not in modes]
    named = {name: given[name] if name in given else _by_name(recording, name) for name in channelled}
    missing = next((name for name in loads_of(twin) if named[name] == ""), None)
    if missing is not None:
        raise DataError(
            f"{recording.name}: no channel is the load {missing!r}; expected --loads {missing}=CHANNEL, or a number "
            f"that holds all along; its channels: {several(recording.channels, 12)}"
        )
    if not modes and not any(named[name] for name in twin.gauges):
        raise DataError(
            f"{recording.name}: no channel is a reading of the twin ({several(twin.gauges, 6)}); expected --readings "
            f"{twin.gauges[0]}=CHANNEL; its channels: {several(recording.channels, 12)}"
        )
    bare = next((name for name in levels if name in modes or not named[name]), None)
    if bare is not None:
        raise DataError(
            f"the level {bare!r} has no channel; expected --readings {bare}=CHANNEL beside --levels; name it"
        )
    found = {name: _number_or(recording, place) for name, place in named.items() if place != ""}
    places = [place for place in found.values() if isinstance(place, str)]
    twice = next((place for place in places if places.count(place) > 1), None)
    if twice is not None:
        names = [name for name, place in found.items() if place == twice]
        raise DataError(f"channel {shown(twice)} is {' and '.join(names)}; expected a channel for each; name another")
    return found


def _by_name(recording: Recording, name: str) -> str:
    """Return the channel of a name, alone, behind its groups or before its unit; "" where none or several have it."""
    if name in recording.channels:
        return name
    last = {one: one.rpartition("/")[2] for one in recording.channels}
    same = [one for one in last if last[one] == name] or [one for one in last if unit_behind(last[one])[0] == name]
    if len(same) > 1 and name != TEMPERATURE:
        raise DataError(
            f"{recording.name}: channels {several(same, 4)} may all be {name!r}; say which by {name}=CHANNEL"
        )
    return same[0] if len(same) == 1 else ""


def _number_or(recording: Recording, place: str | float) -> str | float:
    if isinstance(place, str) and place not in recording.channels:
        try:
            return float(place)
        except ValueError:
            return place
    return place


def taken(own: Mapping[str, Channel], channels: Mapping[str, Channel]) -> list[str]:
    """Return sentences on the channels of other names than the twin's, and on loads in other units than its file's."""
    others = ", ".join(f"{name} is {one.name}" for name, one in own.items() if one.name != name)
    told = [f"Channels: {others}."] if others else []
    for name, one in own.items():
        if one.unit != channels[name].unit:
            how = f"was converted from {one.unit} to" if one.unit else "has no unit in its file and is taken as"
            told.append(f"Channel {one.name} {how} {channels[name].unit}.")
    return told


def in_unit(channel: Channel, unit: str) -> Channel:
    """Return a channel in another unit.

    Raises
    ------
    DataError
        its own is no multiple of that.
    """
    factor = factor_between(channel.unit, unit) if channel.unit else 1.0
    if factor is None:
        raise DataError(
            f"channel {channel.name} is in {shown(channel.unit)}; expected {unit}, and the one is not known to be a "
            "multiple of the other; name another channel, or convert it"
        )
    return (
        replace(channel, unit=unit, values=channel.values * factor)
        if factor != 1.0 or unit != channel.unit
        else channel
    )


def without(channel: Channel, numbers: Sequence[float]) -> Channel:
    """Return a channel whose samples of these numbers are no readings."""
    is_none = np.isin(channel.values, np.asarray(numbers, dtype=np.float64))
    return replace(channel, valid=channel.is_valid & ~is_none) if is_none.any() else channel
