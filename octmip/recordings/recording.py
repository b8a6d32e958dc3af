"""Recording: what a measuring system wrote, channel by channel, each with its own times.

Nothing is resampled, filled or merged. A sample that its file calls invalid, or that is no finite number, is missing.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError
from octmip.input.messages import several, shown
from octmip.recordings.foreign_reader import foreign

Floats = NDArray[np.float64]
LONG = 1.5
"""A step of time over the median one from which it is told as a gap: a sample is lost in it."""


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """One series of samples.

    Attributes
    ----------
    name
        in its file, its groups before it: "Strain/Ch1".
    unit
        as its file writes it, "" where it says none.
    time
        (n,) [s] since the start of the recording, never falling.
    values
        (n,) in the unit; what they are where a sample is not valid means nothing.
    valid
        (n,) whether a sample is a reading; all finite ones where None is given.

    Examples
    --------
    >>> channel = Channel("g1", "um/m", time=[0.0, 0.1, 0.2, 0.9], values=[5.0, np.nan, 7.0, 6.0])
    >>> channel.is_valid.tolist()
    [True, False, True, True]
    >>> channel.notes()[1]
    '1 gap, the longest of 0.7 s at 0.2 s; nothing is filled'
    """

    name: str
    unit: str
    time: Floats
    values: Floats
    valid: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        values, time = (np.asarray(array) for array in (self.values, self.time))
        if values.dtype.kind not in "biuf" or values.ndim != 1:
            what = (
                "texts"
                if values.dtype.kind in "SUO"
                else f"values of shape {values.shape} and kind {values.dtype.kind}"
            )
            raise DataError(f"channel {shown(self.name)} holds {what}; expected one number a sample; name another")
        if time.shape != values.shape or not np.isfinite(time).all():
            raise DataError(
                f"channel {shown(self.name)} has {len(values)} samples and {int(np.isfinite(time).sum())} times; "
                "expected a time for each; name a channel that has one"
            )
        back = np.flatnonzero(np.diff(time) < 0.0)
        if back.size:
            k = int(back[0])
            raise DataError(
                f"channel {shown(self.name)}: time goes back from {time[k]:.6g} s to {time[k + 1]:.6g} s behind "
                f"sample {k + 1}; expected times in order (a counter that wrapped? pieces that overlap?); cut it there"
            )
        valid = np.isfinite(values)
        if self.valid is not None:
            valid &= self.valid
        for name, array in (("time", time), ("values", values), ("valid", valid)):
            kept = np.asarray(array, dtype=bool if name == "valid" else np.float64)
            object.__setattr__(self, name, kept)

    @property
    def is_valid(self) -> NDArray[np.bool_]:
        """(n,) whether a sample is a reading."""
        assert self.valid is not None
        return self.valid

    @property
    def step(self) -> float:
        """The median step of its time [s]; 0 of fewer than two samples."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else 0.0

    def notes(self) -> tuple[str, ...]:
        """Return what was left out of it or is not there, what a sentence says behind its name."""
        told, n = [], len(self.values)
        n_invalid = n - int(np.count_nonzero(self.is_valid))
        if n_invalid:
            told.append(f"{n_invalid} of {n} samples are invalid and left out")
        steps = np.diff(self.time)
        long = np.flatnonzero(steps > LONG * self.step) if self.step > 0.0 else np.zeros(0, dtype=np.int64)
        if long.size:
            k = int(np.argmax(steps))
            told.append(
                f"{long.size} gap{'s' * (long.size != 1)}, the longest of {steps[k]:.3g} s at {self.time[k]:.6g} s; "
                "nothing is filled"
            )
        n_same = int(np.count_nonzero(steps == 0.0))
        if n_same:
            told.append(f"{n_same} samples bear the time of the one before")
        return tuple(told)


Loader = Callable[[], Channel]
"""Reads one channel when it is asked for: a recording may be larger than memory."""


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """The channels of a file.

    Attributes
    ----------
    format
        its name, such as TDMS.
    loaders
        what reads each channel, by the channel's name.
    start
        time zero in nanoseconds since 1970, None where the file does not say it.
    notes
        sentences on how the file was read.
    name
        the file as a sentence names it.

    Examples
    --------
    >>> force = Channel("force", "N", time=[0.0, 1.0], values=[0.0, 5.0])
    >>> run = Recording("made here", {"force": lambda: force})
    >>> run.channels, run["force"].unit
    (('force',), 'N')
    """

    format: str
    loaders: Mapping[str, Loader]
    start: int | None = None
    notes: tuple[str, ...] = field(default=())
    name: str = "recording"

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(self.loaders)

    def __getitem__(self, name: str) -> Channel:
        """Return a channel by its name.

        Raises
        ------
        DataError
            there is none of that name, it holds no numbers, or no times in order.
        """
        loader = self.loaders.get(name)
        if loader is None:
            raise DataError(
                f"{self.name} has no channel {shown(name)}; expected one of its {len(self.channels)}: "
                f"{several(self.channels, 12)}; spell it as the file does"
            )
        try:
            with foreign(f"channel {shown(name)}", self.format):
                return loader()
        except DataError as error:
            raise DataError(f"{self.name}: {error}") from error


def told_apart(names: Sequence[str], others: Sequence[str]) -> list[str]:
    """Return names, each that comes twice replaced by the other name in its place."""
    count = Counter(names)
    return [name if count[name] == 1 else other for name, other in zip(names, others, strict=True)]


def seconds_since(start: int, instants: ArrayLike) -> Floats:
    """Return the seconds (n,) from `start` to instants (n,), both in nanoseconds, exact to a nanosecond for weeks."""
    return np.asarray((np.asarray(instants, dtype=np.int64) - np.int64(start)) / 1e9, dtype=np.float64)
