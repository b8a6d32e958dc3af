"""What a channel shows in a window: mean, spread, and how many independent samples the mean is worth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from octmip.errors import DataError
from octmip.recordings.recording import Channel, Floats
from octmip.recordings.windows import Window

FAR = 50.0
"""Standard deviations, as the median deviation gives them, from which equal numbers are no readings of noise."""
HUGE = 1e30
"""No reading in any unit is so large, but 9.9e37 and the largest double are what instruments write for none."""


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


def inside_of(channel: Channel, start: float, end: float) -> Floats:
    """Return the samples (n,) of a stretch of time, NaN where they are not valid."""
    part = slice(*np.searchsorted(channel.time, (start, end)))
    return np.where(channel.is_valid[part], channel.values[part], np.nan)


def statistic_of(channel: Channel, window: Window) -> Statistic:
    """Return what a channel shows in a window."""
    inside = inside_of(channel, window.start, window.end)
    values = inside[np.isfinite(inside)]
    n = len(values)
    if not n:
        return Statistic(len(inside), len(inside), np.nan, np.nan, 0.0)
    sd = float(values.std(ddof=1)) if n > 1 else np.nan
    return Statistic(len(inside), len(inside) - n, float(values.mean()), sd, worth(values))


def worth(values: Floats) -> float:
    """Return how many independent samples the mean of samples (n,) is worth; negative correlation counts as none.

    Source: Anderson (1971), section 8.2.
    """
    n, rest = len(values), values - values.mean()
    power = float(rest @ rest)
    lag1 = max(float(rest[1:] @ rest[:-1]) / power, 0.0) if power > 0.0 else 0.0
    return max(n * (1.0 - lag1) / (1.0 + lag1), 1.0)


def refuse_placeholders(channels: Mapping[str, Channel], window: Window) -> None:
    """Refuse equal numbers far off all other samples of a window, or a huge one: a logger's word for no reading."""
    for name, channel in channels.items():
        inside = inside_of(channel, window.start, window.end)
        values = inside[np.isfinite(inside)]
        middle = np.median(values) if values.size else np.nan
        spread = 1.4826 * float(np.median(np.abs(values - middle))) if values.size else 0.0
        far = values[np.abs(values - middle) > FAR * spread] if spread > 0.0 else values[:0]
        numbers, count = np.unique(far, return_counts=True)
        is_huge = np.abs(numbers) > HUGE
        if is_huge.any():
            numbers, count = numbers[is_huge], count[is_huge]
        if is_huge.any() or (0 < numbers.size <= 2 and count.max() > 1):
            number, n = float(numbers[count.argmax()]), int(count.max())
            raise DataError(
                f"channel {channel.name} holds {number:.9g} {n} time{'s' * (n > 1)} from {window.start:.6g} s to "
                f"{window.end:.6g} s, where {name} is about {middle:.6g}; expected readings; name it by --no-reading "
                f"{number:.9g} if it stands for none, else leave the window out"
            )


def refuse_bare(
    channels: Mapping[str, Channel], found: Mapping[str, Statistic], window: Window, gauges: Sequence[str]
) -> None:
    """Refuse a window without a reading, or without a sample of a load."""
    bare = [name for name, one in found.items() if one.n == one.n_invalid]
    if set(bare) - set(gauges) or set(bare) >= set(gauges):
        bare = [name for name in bare if name not in gauges] or bare
        one = channels[bare[0]]
        raise DataError(
            f"channel {one.name} has no valid sample from {window.start:.6g} s to {window.end:.6g} s; its samples go "
            f"from {one.time[0]:.6g} s to {one.time[-1]:.6g} s; give other windows"
        )
