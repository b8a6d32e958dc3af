"""Windows of a recording in which the loads stand still: given by their times, or found.

Found on block means of the loads. A window is a longest run of blocks whose means stay within a tolerance of one
another, without the ramp's end at either side; a load that creeps all along it makes none.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from octmip.errors import DataError
from octmip.input.messages import shown
from octmip.recordings.recording import Channel, Floats

BLOCKS = 8
"""Blocks in the shortest window."""
TOLERANCE = 0.02
"""How far a load may move in a window, over its range in the recording."""
SHARE = 1 / 50
"""The shortest window over the length of the recording, where nobody says it."""
STRETCHES = 8
"""Rows of the shortest window whose modes are identified: shorter stretches bias damping."""
SCATTER = 8.0
"""Standard deviations of a block mean that a tolerance holds at the least: some hundred of them spread over half."""
NOISE = (3.5, 9.0)
"""Range over the scatter of block means, between which a load does not move at all: some hundred numbers of noise."""
MOST_TOLERANCE = 0.2
"""Tolerance over the range beyond which no plateau can be told from noise."""


@dataclass(frozen=True, slots=True)
class Window:
    """A stretch of time.

    Attributes
    ----------
    start, end
        [s] since the start of the recording; a sample at `end` is the next window's.
    test
        name of its test, "" for that of the whole recording.

    Examples
    --------
    >>> Window(start=2.0, end=8.0, test="pull")
    Window(start=2.0, end=8.0, test='pull')
    """

    start: float
    end: float
    test: str = ""

    def __post_init__(self) -> None:
        if not (np.isfinite([self.start, self.end]).all() and self.start < self.end):
            raise DataError(f"a window goes from {self.start:g} s to {self.end:g} s; expected an end behind its start")


def window_of(text: str) -> Window:
    """Return the window that a text names: START,END or START,END,TEST.

    Raises
    ------
    DataError
        it is none.
    """
    parts = [part.strip() for part in text.split(",", 2)]
    try:
        return Window(float(parts[0]), float(parts[1]), "".join(parts[2:]))
    except (ValueError, IndexError) as error:
        raise DataError(
            f"window {shown(text)}; expected START,END in seconds, or START,END,TEST with a start before the end; "
            "write it so"
        ) from error


def steady_windows(
    loads: Sequence[Channel], least: float | None = None, tolerance: float = TOLERANCE
) -> tuple[tuple[Window, ...], tuple[str, ...]]:
    """Return the windows in which all loads stand still, and sentences on how they were found.

    Parameters
    ----------
    loads
        channels.
    least
        the shortest window [s]; None for a fiftieth of the recording.
    tolerance
        how far a load may move in a window, over its range.

    Raises
    ------
    DataError
        there is no window, or a load scatters so much that none can be told.
    """
    if not loads:
        raise DataError("no channel is a load that may stand still; name one (--loads force=CHANNEL), or give windows")
    begin, end = max(load.time[0] for load in loads), min(load.time[-1] for load in loads)
    if not begin < end:
        raise DataError(f"the loads have no time in common ({begin:g} s to {end:g} s); expected loads read at once")
    least = SHARE * (end - begin) if least is None else least
    if not (least > 0.0 and 0.0 < tolerance < 1.0):
        raise DataError(
            f"the shortest window is {least:g} s, the tolerance {tolerance:g}; expected a positive time and a share of "
            "the load's range between 0 and 1; correct them"
        )
    width = max(least / BLOCKS, *(2.0 * load.step for load in loads))
    edges = begin + width * np.arange(int((end - begin) / width * (1.0 + 1e-9)) + 1)
    means = [_block_means(load, edges) for load in loads]
    bands = [_tolerance(load, mean, tolerance, len(loads) > 1) for load, mean in zip(loads, means, strict=True)]
    if not np.isfinite(bands).any():
        raise DataError("no load moves beyond its scatter; expected plateaus of a load; give --windows START,END")
    scaled = np.array(means) / np.array(bands)[:, None]
    found, creeping, longest = list[Window](), 0, 0.0
    for run in _runs(scaled):
        longest = max(longest, (run.stop - run.start) * width)
        kept = _tightened(scaled[:, run])
        first, last = run.start + kept.start + 1, run.start + kept.stop - 1  # the block at either end may hold a step
        if (last - first) * width < least * (1.0 - 1e-9):
            continue
        if _creeps(scaled[:, first:last]):
            creeping += 1
        else:
            found.append(Window(float(edges[first]), float(edges[last])))
    within = " and ".join(
        f"{load.name} stays within {band:.3g} {load.unit}".rstrip() if np.isfinite(band) else f"{load.name} is noise"
        for load, band in zip(loads, bands, strict=True)
    )
    creep = f" (left out: {creeping} in which one creeps all along)" if creeping else ""
    if not found:
        raise DataError(
            f"no window of at least {least:.3g} s in which {within}, the longest still stretch has {longest:.3g} "
            f"s{creep}; expected plateaus of the load; allow shorter ones (--least SECONDS) or give --windows START,END"
        )
    many = f"{len(found)} window{'s' * (len(found) != 1)}"
    return tuple(found), (f"{many} of at least {least:.3g} s in which {within}{creep}, by means of {width:.3g} s.",)


def ordered(windows: Sequence[Window]) -> tuple[Window, ...]:
    """Return windows in the order of time; refuse those that overlap, whose samples would count twice."""
    found = tuple(sorted(windows, key=lambda window: window.start))
    for one, other in itertools.pairwise(found):
        if other.start < one.end:
            raise DataError(
                f"windows {one.start:g},{one.end:g} and {other.start:g},{other.end:g} overlap; expected each sample in "
                "one window; move an end"
            )
    return found


def moving(loads: Sequence[Channel], windows: Sequence[Window], tolerance: float) -> tuple[str, ...]:
    """Return a sentence for each load whose mean moves by more than the tolerance from third to third of a window."""
    told = []
    for load in loads:
        extent = float(np.ptp(load.values[load.is_valid])) if load.is_valid.any() else 0.0
        moves = []
        for window in windows:
            means = _block_means(load, np.linspace(window.start, window.end, 4))
            moves.append(float(np.ptp(means[np.isfinite(means)])) if np.isfinite(means).any() else 0.0)
        k = int(np.argmax(moves))
        if moves[k] > tolerance * extent:
            told.append(
                f"Load {load.name} moves by {moves[k]:.3g} from {windows[k].start:g} s to {windows[k].end:g} s, a "
                "window that was given: its mean stands for all of it."
            )
    return tuple(told)


def _block_means(channel: Channel, edges: Floats) -> Floats:
    """Return the mean of the valid samples between edges (n_blocks + 1,), NaN where fewer than half are there."""
    place = np.searchsorted(channel.time, edges)
    valid = channel.is_valid
    total, count = (
        np.add.reduceat(np.append(array, 0.0), place)[:-1] * (np.diff(place) > 0)
        for array in (np.where(valid, channel.values, 0.0), valid)
    )
    return np.where(count > 0.5 * np.median(count), total / np.maximum(count, 1.0), np.nan)


def _tolerance(load: Channel, means: Floats, share: float, has_others: bool) -> float:
    """Return how far block means of a load may lie apart in a window; infinity where it is noise, and others move.

    Raises
    ------
    DataError
        it has no block of valid samples, or its noise hides plateaus.
    """
    known = means[np.isfinite(means)]
    if not known.size:
        raise DataError(f"channel {load.name} has no valid sample where the loads overlap; name another load")
    extent = float(np.ptp(known))
    steps = np.diff(known)
    noise = float(1.4826 * np.median(np.abs(steps - np.median(steps)))) / np.sqrt(2.0) if steps.size else 0.0
    if has_others and NOISE[0] * noise < extent < NOISE[1] * noise:
        return np.inf
    if SCATTER * noise > MOST_TOLERANCE * extent and extent > 0.0:
        raise DataError(
            f"channel {load.name} moves by {noise:.3g} from one block to the next and by {extent:.3g} in all; expected "
            "plateaus that stand out of its noise; give --windows START,END, or --steady another load"
        )
    return max(share * extent, SCATTER * noise, 1e-12 * float(np.abs(known).max()), 1e-300)


def _runs(scaled: Floats) -> Iterator[slice]:
    """Yield the longest runs of blocks whose means (n_loads, n_blocks) stay within 1 of one another."""
    start, known = 0, np.asarray(np.isfinite(scaled).all(axis=0))
    while start < scaled.shape[1]:
        stop, low, high = start, scaled[:, start], scaled[:, start]
        while stop < scaled.shape[1] and known[stop]:
            low, high = np.minimum(low, scaled[:, stop]), np.maximum(high, scaled[:, stop])
            if (high - low > 1.0).any():
                break
            stop += 1
        if stop > start:
            yield slice(start, stop)
        start = max(stop, start + 1)


def _tightened(scaled: Floats) -> slice:
    """Return the longest stretch of a run within half the tolerance about its median: without the end of a ramp."""
    near = (np.abs(scaled - np.median(scaled, axis=1, keepdims=True)) <= 0.5).all(axis=0)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]]))).reshape(-1, 2)
    return slice(*ends[np.argmax(ends[:, 1] - ends[:, 0])].tolist()) if len(ends) else slice(0, 0)


def _creeps(scaled: Floats) -> bool:
    """Whether the last third of a window lies a fifth of the tolerance off its first: a slow ramp, no plateau."""
    third = max(scaled.shape[1] // 3, 1)
    scatter = np.std(np.diff(scaled, axis=1), axis=1) / np.sqrt(third) if scaled.shape[1] > 2 else 0.0
    moved = np.abs(scaled[:, -third:].mean(axis=1) - scaled[:, :third].mean(axis=1))
    return bool((moved > np.maximum(0.2, 4.0 * scatter)).any())
