"""The noise as a hypothesis of its own: what repeats say of it, never taken for granted.

The noise of a reading is a sum of parts, each with a covariance over the gauges and a memory of its own: what single
gauges have, and what gauges share (see `noise_estimate`). Means of N repeats have the covariance

    scale(L) / N  sum_k inflation_k(N) C_k

with the inflation of the part's serial correlation (see `spectrum`) and scale(L), the ratio of the scatter at load L to
the pooled one. Halves of one cell share a little more; a part that wanders is carried from cell to cell, and a gauge
that jumped has an unknown offset from then on: `Noise.of_averages` and `Noise.of_jumps`.

How far readings wander from cell to cell, and how long they remember, is a hypothesis with a few sizes. A random walk
of all gauges that is too slow to stand out of the repeats of one cell still moves the means of later cells by more than
their scatter. Readings that step up and down some ten times in a campaign look nearly white within a cell, and leave
the variance of a mean open by a factor. So the repeats do not decide: they leave a posterior over the walk and the
memory, which is cut into sizes: of the variance of one step of a walk, and without one of the variance of a mean. Each
is a noise of its own; the evidence of the means weighs them (`octmip.gap.inference.posterior`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Cell, Fault
from octmip.gap.campaign.spectrum import STEPS, WHITE, Serial, inflation_of
from octmip.twin import Load

Floats = NDArray[np.float64]

JUMP_SD = 1e3
"""Standard deviation of the offset after a jump in those of a reading: nothing is known of it."""
RANDOM_WALK = "random_walk"
"""Name of the finding that readings wander."""


@dataclass(frozen=True, slots=True, eq=False)
class NoisePart:
    """One part of the noise.

    Attributes
    ----------
    covariance
        (n_gauges, n_gauges) of one reading [square of its unit], what wanders left out.
    serial
        its serial correlation.
    """

    covariance: Floats
    serial: Serial

    @property
    def remembers(self) -> bool:
        """Whether successive readings are correlated, more probably than not: of white campaigns 2 % are called so."""
        return self.serial.white_probability < 0.5

    def of_mean(self, n: int) -> float:
        """Return the variance of a mean of n readings over that of one."""
        return self.serial.of_mean(n) / self.serial.variance

    def between(self, averages: Sequence[Cell]) -> Floats:
        """Return the covariances (n_averages, n_averages) that `of_mean` leaves out, over the variance of a reading."""
        found = np.zeros((len(averages), len(averages)))
        step = self.serial.step_variance
        for i, one in enumerate(averages):
            for j in range(i + 1):
                other = averages[j]
                shared = step * least_moment(one.moments, other.moments) if step > 0.0 else 0.0
                if i != j and (self.remembers or one.number == other.number):
                    shared += self._neighbours(other, one)
                found[i, j] = found[j, i] = shared
        return found / self.serial.variance

    def _neighbours(self, one: Cell, other: Cell) -> float:
        """Return the covariance of the means of two averages of which one was read after the other, else 0."""
        if one.moments[0] > other.moments[0]:
            one, other = other, one
        n, m = len(one.rows), len(other.rows)
        if other.moments.min() <= one.moments.max():
            return 0.0
        return self.serial.between(n, m, max(n, round(float(other.moments.min() - one.moments.min()))))


def least_moment(one: Floats, other: Floats) -> float:
    """Return the mean of min(s, t) over the moments of two averages, which a walk from the first reading on shares."""
    if one.max() <= other.min():
        return float(one.mean())
    if other.max() <= one.min():
        return float(other.mean())
    ordered = np.sort(other)
    below = np.searchsorted(ordered, one)
    sums = np.concatenate([np.zeros(1), np.cumsum(ordered)])
    return float(np.mean(sums[below] + one * (len(ordered) - below))) / len(ordered)


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """The noise of the readings, from their repeats.

    Attributes
    ----------
    gauges
        names.
    parts
        whose sum it is, what single gauges have first, then what gauges share.
    inflation
        factor on the variance of means for serial correlation, of the typical gauge and cell.
    scale
        variance ratio by load.
    kurtosis
        excess kurtosis, 0 for a normal distribution.
    steps, rounding
        (n_gauges,) of the displays in the unit of the readings, 0 where none is seen, and the variance that they leave
        in the mean of any number of readings of one cell; empty: none.
    properties
        names of what is not plain white noise, of the effects' list, a walk left out.
    faults
        readings that were left out.
    """

    gauges: tuple[str, ...]
    parts: tuple[NoisePart, ...]
    inflation: float = 1.0
    scale: Mapping[Load, float] = field(default_factory=dict)
    kurtosis: float = 0.0
    steps: Floats = field(default_factory=lambda: np.zeros(0))
    rounding: Floats = field(default_factory=lambda: np.zeros(0))
    properties: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()

    @property
    def covariance(self) -> Floats:
        """(n_gauges, n_gauges) of one reading, in the squares of the units."""
        return np.asarray(np.sum([part.covariance for part in self.parts], axis=0)) + self._rounding

    @property
    def _rounding(self) -> Floats:
        """(n_gauges, n_gauges) what the displays leave in every mean."""
        return np.diag(self.rounding) if self.rounding.size else np.zeros((len(self.gauges), len(self.gauges)))

    @property
    def step(self) -> float:
        """The step of the typical gauge's display; 0 where none is seen."""
        return float(np.median(self.steps)) if self.steps.size else 0.0

    @property
    def remembers(self) -> bool:
        """Whether successive readings of some part are correlated."""
        return any(part.remembers for part in self.parts)

    @property
    def lag1(self) -> float:
        """Lag-1 correlation of successive repeats."""
        weight = np.array([np.trace(part.covariance) for part in self.parts])
        return float(weight @ [part.serial.lag1 for part in self.parts] / weight.sum())

    @property
    def findings(self) -> tuple[str, ...]:
        """Names of what is not plain white noise, of the effects' list."""
        wanders = any(part.serial.walk_probability > 0.5 for part in self.parts)
        return (*self.properties, *[RANDOM_WALK] * wanders)

    @property
    def stuck(self) -> tuple[str, ...]:
        """Gauges that stand still, always or for a time."""
        return tuple(fault.gauge for fault in self.faults if fault.kind == "stuck")

    @property
    def clipped(self) -> Mapping[str, float]:
        """By gauge that met the end of its range, where that lies in its unit: of two ends the upper one."""
        found: dict[str, float] = {}
        for fault in self.faults:
            if fault.kind == "clipped":
                found.setdefault(fault.gauge, fault.value)
        return found

    @property
    def walk_sd(self) -> float:
        """Standard deviation of one step of the typical gauge's walk; 0 where nothing wanders."""
        own = self.parts[0]
        step = own.serial.step_variance / own.serial.variance
        return float(np.sqrt(step * np.median(np.diag(own.covariance))))

    def of_gauges(self, gauges: Sequence[str]) -> "Noise":
        """Return the noise of these gauges, in their order."""
        order = [self.gauges.index(name) for name in gauges]
        parts = tuple(replace(part, covariance=part.covariance[np.ix_(order, order)]) for part in self.parts)
        steps, rounding = (own[order] if own.size else own for own in (self.steps, self.rounding))
        return replace(self, gauges=tuple(gauges), parts=parts, steps=steps, rounding=rounding)

    def with_own(self, serial: Serial) -> "Noise":
        """Return the noise with another memory of what single gauges have."""
        own = self.parts[0]
        part = NoisePart(own.covariance * (serial.variance / own.serial.variance), serial)
        return replace(self, parts=(part, *self.parts[1:]))

    def of_mean(self, repeats: NDArray[np.int64], load: Load) -> Floats:
        """Return the covariance (n_gauges, n_gauges) of means of so many repeats (n_gauges,), one or more per gauge."""
        count = np.maximum(repeats, 1).astype(np.float64)
        overlap = np.minimum(count[:, None], count[None, :]) / (count[:, None] * count[None, :])
        n = int(count.max())
        single = sum((n * part.of_mean(n) * part.covariance for part in self.parts), np.zeros(overlap.shape))
        return np.asarray(self.scale.get(load, 1.0) * single * overlap) + self._rounding

    def of_jumps(self, averages: Sequence[Cell], average: NDArray[np.int64], gauge: NDArray[np.int64]) -> Floats:
        """Return the covariance (n, n) that the offsets of gauges that jumped add to `of_averages`."""
        total = np.zeros((len(average), len(average)))
        for jump in (fault for fault in self.faults if fault.kind == "jump" and fault.gauge in self.gauges):
            k = self.gauges.index(jump.gauge)
            after = np.array([float((part.rows >= jump.first).mean()) for part in averages])[average] * (gauge == k)
            total += JUMP_SD**2 * self.covariance[k, k] * np.outer(after, after)
        return total

    def of_averages(self, averages: Sequence[Cell], average: NDArray[np.int64], gauge: NDArray[np.int64]) -> Floats:
        """Return the covariance (n, n) of averages; (n,) indices of average and gauge."""
        spread = np.sqrt([self.scale.get(part.load, 1.0) for part in averages])[average]
        total = self.across(averages, average, gauge) * np.outer(spread, spread)  # shared parts scale with the scatter
        number = np.array([part.number for part in averages])[average]
        total += self._rounding[np.ix_(gauge, gauge)] * (number[:, None] == number) * (average[:, None] != average)
        for k, part in enumerate(averages):
            here = np.flatnonzero(average == k)
            total[np.ix_(here, here)] += self.of_mean(part.count, part.load)[np.ix_(gauge[here], gauge[here])]
        return np.asarray(total)

    def across(self, averages: Sequence[Cell], average: NDArray[np.int64], gauge: NDArray[np.int64]) -> Floats:
        """Return the covariance (n, n) that averages share beyond `of_mean`; (n,) indices of average and gauge."""
        total = np.zeros((len(average), len(average)))
        for part in self.parts:
            shared = part.between(averages)
            if shared.any():
                total += shared[np.ix_(average, average)] * part.covariance[np.ix_(gauge, gauge)]
        return total


def given_noise(gauges: tuple[str, ...], sd: float | Mapping[str, float]) -> Noise:
    """Return white noise of a known standard deviation in the unit of the readings, of all gauges or by gauge.

    Raises
    ------
    DataError
        no positive number for some gauge.
    """
    wanted = [sd.get(name, float("nan")) if isinstance(sd, Mapping) else sd for name in gauges]
    for name, value in zip(gauges, wanted, strict=True):
        if not (np.isfinite(value) and value > 0.0):
            raise DataError(f"noise_sd of gauge {name} is {value}; expected a positive number in its unit; give it")
    return Noise(gauges, (NoisePart(np.diag(np.square(np.array(wanted, dtype=np.float64))), WHITE),))


WIDTH = 3
"""Points of the grid of steps in one size: they differ by a factor of 3 in variance."""
RATIO = 1.6
"""Ratio of the variances of a mean from one size of the memory to the next."""
NEGLIGIBLE = 0.05
"""Variance that a walk adds to the last mean, over that of its scatter, below which it is none."""
LEAST_WALK, LEAST_MEMORY = 1e-6, 0.01
"""Probability of a size after the repeats, below which it is left out."""
SHARED_BY = 2.0
"""Gauges, counted by their variance (sum squared over sum of squares), beyond which a pattern is shared."""


def sizes(noise: Noise, averages: Sequence[Cell]) -> tuple[tuple[Noise, float], ...]:
    """Return the noise for every size that the repeats leave open, each with its log probability.

    The most probable comes first.
    """
    serial = noise.parts[0].serial
    number = _numbers(serial, averages)
    found = []
    for k in np.unique(number):
        here, still = number == k, serial.walk == 0.0
        share = float(serial.weight[here].sum())
        if share > (LEAST_WALK if k > 0 else LEAST_MEMORY):
            own = serial.given(here & still if k <= 0 and (here & still).any() else here)
            found.append((noise.with_own(own), float(np.log(share))))
    return tuple(sorted(found, key=lambda pair: -pair[1]))


def _numbers(serial: Serial, averages: Sequence[Cell]) -> NDArray[np.int64]:
    """Return the size of each point of the posterior (n_points,): 1 and more of a walk that shows, else of a mean."""
    ratio = serial.walk / np.maximum(serial.white, 1e-300)
    walk = np.where(serial.walk > 0.0, np.searchsorted(STEPS[::WIDTH], ratio * (1.0 + 1e-9), side="right"), 0)
    shows = [k for k in np.unique(walk[walk > 0]) if _shows(serial.given(walk == k), averages)]
    typical = int(np.median([len(part.rows) for part in averages]))
    variance = serial.white + serial.remembering * inflation_of(serial.rho, typical)
    order = np.argsort(variance)
    middle = variance[order][int(np.searchsorted(np.cumsum(serial.weight[order]), 0.5))]
    memory = np.round(np.log(variance / middle) / np.log(RATIO)).astype(np.int64)
    return np.where(np.isin(walk, shows), walk, memory - memory.max())


def moves_together(noise: Noise, averages: Sequence[Cell]) -> float:
    """Return the probability that a pattern that gauges share wanders so far that means move by more than they scatter.

    A supply, lead wires or a temperature does that: no noise of the gauges, and no effect with a size.
    """
    found = 0.0
    for part in noise.parts[1:]:
        spread = np.diag(part.covariance)
        is_shared = float(spread.sum()) ** 2 > SHARED_BY * float(np.sum(spread**2))
        if is_shared and _shows(part.serial, averages, 1.0):
            found = max(found, part.serial.walk_probability)
    return found


def _shows(serial: Serial, averages: Sequence[Cell], least: float = NEGLIGIBLE) -> bool:
    """Return whether a walk adds so much to the variance of the last mean, over that of its scatter."""
    last = max(averages, key=lambda average: float(average.moments.mean()))
    added = serial.step_variance * least_moment(last.moments, last.moments)
    return added > least * serial.of_mean(len(last.rows))
