"""How often the 95 % intervals of a beam's modes hold the truth: `python -m benchmarks.run modes`, about a minute.

One hundred simulated records of ten minutes of a cantilever under white noise. Accelerometers at four places see the
first three modes, each an oscillator by its exact recursion. Source: Blevins (1979), table 8-1.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import scipy.signal
import scipy.stats
from numpy.typing import NDArray

from benchmarks.tables import Line
from octmip.recordings import Channel, modes_of

RATE, SECONDS = 200.0, 600.0
EIGHTHS = np.linspace(0.0, SECONDS, 9)
ROOTS, SIGMA = np.array([1.87510407, 4.69409113, 7.85475744]), np.array([0.734095514, 1.018467319, 0.999224497])
FREQUENCIES = 4.0 * (ROOTS / ROOTS[0]) ** 2
"""(3,) [Hz] of the sound beam."""
DAMPING = np.array([0.015, 0.010, 0.020])
PLACES, NOISE = np.array([0.3, 0.55, 0.8, 1.0]), 0.1
"""Of the accelerometers, over the length; their noise over a mode's motion."""


def accelerations(
    seed: int, stiffness: float = 1.0, seconds: float = SECONDS, rate: float = RATE
) -> NDArray[np.float64]:
    """Return samples (n, 4) of a beam with a share of the stiffness, which moves all frequencies by its root."""
    rng, n = np.random.default_rng(seed), int(seconds * rate)
    shapes = np.cosh(np.outer(ROOTS, PLACES)) - np.cos(np.outer(ROOTS, PLACES))
    shapes -= SIGMA[:, None] * (np.sinh(np.outer(ROOTS, PLACES)) - np.sin(np.outer(ROOTS, PLACES)))
    motions = []
    for frequency, damping in zip(FREQUENCIES * np.sqrt(stiffness), DAMPING, strict=True):
        omega = 2.0 * np.pi * frequency / rate
        decay = np.exp(-damping * omega)
        turn = 2.0 * decay * np.cos(omega * np.sqrt(1.0 - damping**2))
        motion = scipy.signal.lfilter([1.0], [1.0, -turn, decay**2], rng.normal(size=n + 4000))[4000:]
        motions.append(motion / motion.std())
    samples = np.column_stack(motions) @ shapes
    return np.asarray(samples + NOISE * rng.normal(size=samples.shape), dtype=np.float64)


def series(samples: NDArray[np.float64]) -> list[Channel]:
    """Return samples (n, n_channels) as channels a1, a2, ..."""
    time = np.arange(len(samples)) / RATE
    return [Channel(f"a{k + 1}", "m/s2", time, own) for k, own in enumerate(samples.T)]


def mean_and_half_width(rows: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the mean (2 n_modes,) of frequencies, then damping, and the half width of its 95 % interval.

    Stretches (n_stretches, n_modes, 2) that lack a mode are left out.
    """
    whole = rows[np.isfinite(rows).all(axis=(1, 2))].transpose(0, 2, 1).reshape(-1, 2 * rows.shape[1])
    quantile = scipy.stats.t.ppf(0.975, len(whole) - 1)
    return whole.mean(axis=0), quantile * whole.std(axis=0, ddof=1) / np.sqrt(len(whole))


def results(limit: float, threads: Sequence[int], n: int = 100) -> Iterator[Line]:
    """Yield a line for frequencies and one for damping: shares held, bias and half width, of each mode."""
    truth = np.concatenate([FREQUENCIES, DAMPING])
    near = np.round(FREQUENCIES, 1).tolist()
    found = [mean_and_half_width(modes_of(series(accelerations(seed)), near, EIGHTHS)) for seed in range(n)]
    errors, widths = np.array([mean for mean, _ in found]) - truth, np.array([width for _, width in found])
    for name, part in (("frequency", slice(0, 3)), ("damping", slice(3, 6))):
        yield {
            "size": name,
            "seed": f"0 to {n - 1}",
            "held": np.mean(np.abs(errors) < widths, axis=0)[part].round(2).tolist(),
            "bias_percent": (100.0 * errors.mean(axis=0) / truth)[part].round(2).tolist(),
            "half_width_percent": (100.0 * np.median(widths, axis=0) / truth)[part].round(2).tolist(),
        }
