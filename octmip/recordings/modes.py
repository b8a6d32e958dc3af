"""Natural frequencies and damping ratios from vibrations that nobody measured the force of.

A window is cut into stretches of equal length. Each is identified alone, by covariance-driven stochastic subspace
identification (SSI-cov) of pyOMA-2, and makes one row: how the rows differ is the covariance of frequencies and
damping. Price: a stretch says too much damping, 4 % where it is 28 times as long as the mode remembers,
1 / (2 pi f zeta).

Source: Peeters & De Roeck (1999), Reference-based stochastic subspace identification for output-only modal analysis.
"""

import contextlib
import io
import os
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from octmip.errors import DataError, needed_by
from octmip.recordings.recording import Channel, Floats

QUIET = {"PYOMA_LOG_LEVEL": "WARNING", "PYOMA_DISABLE_MATPLOTLIB_LOGGING": "False"}
"""Read when pyOMA-2 is imported; without the first every run writes five lines on standard error."""
NEAR = 0.1
"""A mode lies within this share of the frequency by which it is named."""
SAMPLES = 10.0
"""Samples in a period of the highest mode from which they are thinned out by two, behind a filter."""
PERIODS = 1.0
"""Periods of the lowest mode over which correlations are taken, within `BLOCKS`."""
BLOCKS = (15, 100)
MOST_ORDER, FEWEST_ORDERS = 20, 3
"""The largest model, and in how many models a mode must be stable."""
ALIKE = {"err_fn": 0.01, "err_xi": 0.05, "err_phi": 0.02}
"""How far a stable pole may lie off the one of the next smaller model: shares, and 1 less the shapes' MAC."""
APART = 0.01
"""Shares of a frequency by which stable poles of two modes lie apart."""
MOST_DAMPING = 0.2
EVEN = 0.2
"""How far a time may lie off its place, over the step."""


def modes_of(series: Sequence[Channel], near: Sequence[float], edges: Floats) -> Floats:
    """Return frequencies [Hz] and damping (n_stretches, n_modes, 2) of modes, by vibrations.

    Damping is a share of the critical one; NaN where a stretch has no such mode.

    Parameters
    ----------
    series
        accelerations, speeds, ways or strains, all read at once at one rate.
    near
        (n_modes,) a frequency within a tenth of each mode [Hz].
    edges
        (n_stretches + 1,) of the stretches [s].

    Raises
    ------
    DataError
        series of other times, a mode that fewer than half of the stretches have, or two modes near one frequency.

    Examples
    --------
    >>> time = np.arange(0.0, 400.0, 0.025)
    >>> decay = np.exp(-0.25 * time[:800]) * np.sin(25.0 * time[:800])
    >>> moved = np.convolve(np.random.default_rng(0).normal(size=len(time)), decay)[: len(time)]
    >>> found = modes_of([Channel("a", "g", time, moved)], [4.0], np.array([0.0, 200.0, 400.0]))
    >>> found.shape, (2.0 * np.pi * found[:, 0, 0]).round().tolist()
    ((2, 1, 2), [25.0, 25.0])
    """
    highest, lowest, n_stretches = max(near, default=0.0), min(near, default=0.0), len(edges) - 1
    if not (series and lowest > 0.0 and n_stretches > 1):
        raise DataError(
            f"{len(series)} channels, modes near {list(near)} Hz, {n_stretches} stretches; expected one channel, "
            "positive frequencies and two stretches at least; name them"
        )
    first = series[0]
    for one in series[1:]:
        if one.time.shape != first.time.shape or (np.abs(one.time - first.time) > EVEN * first.step).any():
            raise DataError(
                f"channels {first.name} ({1 / first.step:.4g} Hz) and {one.name} ({1 / one.step:.4g} Hz) were not read "
                "at the same times; expected vibrations read at once; name channels of one rate"
            )
    if first.step * highest > 0.4:
        raise DataError(
            f"channel {first.name} has {1 / first.step:.4g} samples a second; expected more than {2.5 * highest:.4g} "
            f"for a mode near {highest:g} Hz; name lower modes"
        )
    heard: list[float] = []
    rows = np.array([_identified(part, near, heard) for part in stretches(series, edges)])
    for k, frequency in enumerate(near):
        places = np.sort(rows[:, k, ::2], axis=1)  # one place is NaN where a stretch has one mode
        n_found, n_double = np.isfinite(places).sum(axis=0).tolist()
        middle = np.nanmedian(places, axis=0) if n_double else places[0]
        if n_double > n_stretches / 2 and (np.nanmedian(np.abs(places - middle), axis=0) < APART * frequency / 2).all():
            raise DataError(
                f"two modes lie near {frequency:g} Hz ({middle[0]:.4g} and {middle[1]:.4g} Hz in the median); expected "
                "one; name each by its own frequency"
            )
        if n_found < max(2, n_stretches / 2):
            places, counts = np.unique(np.round(np.log(heard) / APART), return_counts=True)
            often = np.sort(places[np.argsort(-counts)[:6]])
            others = ", ".join(f"{one:.3g}" for one in np.exp(often * APART)) or "none"
            raise DataError(
                f"{n_found} of {n_stretches} stretches of {edges[1] - edges[0]:.4g} s have a mode near "
                f"{frequency:g} Hz; expected half of them; most stable ones are at {others} Hz; name one of "
                "these, or a longer window"
            )
    return rows[:, :, :2]


def stretches(series: Sequence[Channel], edges: Floats) -> Iterator[tuple[Floats, float]]:
    """Yield samples (n, n_channels) and their rate; none of a stretch with a gap or an invalid sample."""
    first = series[0]
    place = np.searchsorted(first.time, edges)
    for start, end in pairwise(place.tolist()):
        time = first.time[start:end]
        steps = np.diff(time)
        parts = [one.values[start:end] for one in series]
        is_whole = end - start > 4 * BLOCKS[0] and all(one.is_valid[start:end].all() for one in series)
        is_whole &= all(np.ptp(part) > 0.0 for part in parts if is_whole)  # a dead channel is in no mode
        if is_whole and (np.abs(steps - first.step) < EVEN * first.step).all():
            yield np.column_stack(parts), len(steps) / float(time[-1] - time[0])
        else:
            yield np.zeros((0, len(series))), 0.0


def _identified(part: tuple[Floats, float], near: Sequence[float], heard: list[float]) -> Floats:
    """Return frequency and damping (n_modes, 4) of a stretch and of the next mode in the same band, NaN of none.

    A mode is the frequency at which most models have a stable pole, and the median of these.
    """
    samples, rate = part
    found = np.full((len(near), 4), np.nan)
    if not len(samples):
        return found
    for name, value in QUIET.items():
        os.environ.setdefault(name, value)
    with needed_by("the identification of modes"), np.errstate():  # the import silences NumPy for the whole program
        from pyoma2.algorithms import SSI
        from pyoma2.setup import SingleSetup
    with contextlib.redirect_stderr(io.StringIO()), np.errstate(divide="ignore", invalid="ignore"):
        setup = SingleSetup(samples, fs=rate)
        setup.detrend_data()
        while setup.fs > SAMPLES * max(near):
            setup.decimate_data(q=2)
        n_blocks = int(np.clip(np.ceil(PERIODS * setup.fs / (2.0 * min(near))), *BLOCKS))
        order = min(MOST_ORDER, (n_blocks - 1) * samples.shape[1] // 2 * 2)
        limits = {"xi_max": MOST_DAMPING, "mpc_lim": None, "mpd_lim": None, "CoV_max": None}
        identification = SSI(name="SSI", method="cov", br=n_blocks, ordmax=order, step=2, hc=limits, sc=ALIKE)
        setup.add_algorithms(identification)
        setup.run_all()
    poles = identification.result
    stable = np.where(poles.Lab == 1, poles.Fn_poles, np.nan)
    heard += stable[np.isfinite(stable)].tolist()
    for k, frequency in enumerate(near):
        band = min(NEAR * frequency, *(abs(other - frequency) / 2.0 for other in near if other != frequency), np.inf)
        own = np.abs(stable - frequency) < band
        order = np.argsort(stable[own])
        values, damping = stable[own][order], poles.Xi_poles[own][order]
        runs = np.split(np.arange(len(values)), np.flatnonzero(np.diff(values) > APART * frequency) + 1)
        runs = sorted((run for run in runs if len(run) >= FEWEST_ORDERS), key=len, reverse=True)
        for place, run in zip((slice(0, 2), slice(2, 4)), runs, strict=False):
            found[k, place] = np.median(values[run]), np.median(damping[run])
    return found
