"""Series: the watch over the readings of one asset, which leaves out gauges that fail and takes none for damage.

Gauges fail one by one, and damage near several makes them disagree from one reading on. A gauge g was named as faulty.
Were it only that, the others would be noise once g is left out. With z_t the residual along gauge h and n readings
since tau, a shift of h that began at tau, its size normal with scale s, has the evidence

    L_h(tau) = (1 + n |p|^2 s^2)^(-1/2) exp(s^2 (sum of z since tau)^2 / (2 (1 + n |p|^2 s^2))),    p = P's column of h,

the mean over three scales. With q(tau) ~ L_g(tau), what is known of the beginning of g, h began together with g where
sum_tau q(tau) L_h(tau) is far above 1, the evidence of a sound h, and above the mean of L_h, that of a failure of its
own at any reading. Only neighbours of g are asked: two gauges may fail at almost one reading, seldom side by side.
Damage leaves the noise of a gauge, so one that is stuck (`octmip.monitor.stuck`) is faulty and asked for no beginning.
"""

import math
from collections import deque
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.monitor.finding import Finding, explain
from octmip.monitor.library import Applied
from octmip.monitor.stuck import Repeats
from octmip.monitor.watch import MonitorState, Watch

Floats = NDArray[np.float64]

SCALES = (1.0, 4.0, 16.0)
"""Scales s of a shift, standard deviations of a reading."""
LATER = 1.2
"""Ratio between the numbers of readings at which a faulty gauge's neighbours are looked at again."""


@dataclass(slots=True, eq=False)
class Series:
    """The watch at work on one asset.

    Attributes
    ----------
    watch
        the test.
    faulty
        indices of the gauges that were named and are left out since.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2", "g3"), [[100, 200, 300], [150, 200, 300]], 10.0)
    >>> series = Series(Watch(library, horizon=10, largest_load=1.0))
    >>> [series.observe([100, 200, reading], 1.0) for reading in (301, 299)]
    [None, None]
    >>> series.observe([100, 200, 400], 1.0).name
    'g3'
    """

    watch: Watch
    faulty: set[int] = field(default_factory=set)
    _state: MonitorState = field(init=False, repr=False)
    _kept: deque[tuple[Floats, float]] = field(init=False, repr=False)
    _repeats: Repeats = field(init=False, repr=False)
    _stuck: set[int] = field(init=False, repr=False, default_factory=set)
    _since: int = field(init=False, repr=False, default=0)
    _looked: int = field(init=False, repr=False, default=0)

    def __post_init__(self) -> None:
        self._state = self.watch.start(1)
        self._kept = deque(maxlen=self.watch.horizon)
        self._repeats = Repeats(np.full(len(self.watch.library.gauges), np.nan))

    @property
    def p_value(self) -> float:
        """Of the last reading in the library."""
        return float(self._state.p_value[0])

    @property
    def left_out(self) -> tuple[str, ...]:
        """Names of the gauges that were named."""
        return tuple(self.watch.library.gauges[k] for k in sorted(self.faulty))

    def without_faulty(self, row: list[float]) -> list[float]:
        """Return a reading with NaN for the gauges that were named."""
        return [math.nan if k in self.faulty else value for k, value in enumerate(row)]

    def observe(self, row: Floats, load_factor: Applied, state: int = 0) -> Finding | None:
        """Return what a reading (n_gauges,), NaN where missing, brings to light; `state`: as for `explain`."""
        was_alarm = bool(self._state.is_alarm[0])
        heard = np.where(np.isin(np.arange(len(row)), sorted(self.faulty)), np.nan, row)
        self._state = self.watch.observe(self._state, heard[None], load_factor)
        self._kept.append((row, self.watch.library.checked_load(load_factor)))
        finding = self._newly_stuck(row)
        if finding is None and self._state.is_alarm[0] and not was_alarm:
            finding = explain(self.watch, self._state, 0, state)
        if finding is not None and finding.kind == "gauge":
            self.faulty.add(self.watch.library.gauges.index(finding.name))
            if not was_alarm:
                self._state, self._since, self._looked = self.watch.start(1), 0, 0
        self._since += 1
        if self.faulty and not was_alarm and self._since > LATER * self._looked:
            self._looked = self._since
            finding = self._together(state) or finding
        return finding

    def _newly_stuck(self, row: Floats) -> Finding | None:
        """Return the finding of a gauge that is stuck by now; one that was named before is only noted."""
        gauges, rate = self.watch.library.gauges, self.watch.rate / self.watch.horizon
        self._repeats.count(row)
        new = set(np.flatnonzero(self._repeats.is_stuck(rate / len(gauges))).tolist()) - self._stuck
        self._stuck |= {g for g in new if g in self.faulty}
        for g in sorted(new - self.faulty)[:1]:
            self._stuck.add(g)
            words = f"Gauge {gauges[g]} shows {row[g]:g} again and again: it is faulty. It is left out from now on."
            return Finding("gauge", gauges[g], 1.0, (gauges[g],), max(0, self._state.n_seen - 1), None, words)
        return None

    def _together(self, state: int) -> Finding | None:
        """Return the damage that a faulty gauge and its neighbours show; the gauges are at hand again."""
        rows, loads = (np.array(part, dtype=np.float64) for part in zip(*self._kept, strict=True))
        rows[:, sorted(self._stuck)] = np.nan
        asked = self.faulty - self._stuck
        began = {g: _log_evidence(self.watch, rows, loads, asked - {g}, [g])[:, 0] for g in sorted(asked)}
        # without the others it agrees: it was named in place of one of them
        self.faulty -= {g for g, logs in began.items() if logsumexp(logs) < np.log(len(logs))}
        together = _began_together(self.watch, rows, loads, {g: began[g] for g in sorted(asked & self.faulty)})
        if not together:
            return None
        self.faulty -= {self.watch.library.gauges.index(gauge) for gauge in together}
        rows[:, sorted(self.faulty)] = np.nan
        seen = self.watch.seen(rows, loads.tolist())
        self._state = replace(seen, is_alarm=np.ones(1, dtype=bool))
        return explain(self.watch, seen, 0, state, together)


def _began_together(watch: Watch, readings: Floats, loads: Floats, began: dict[int, Floats]) -> tuple[str, ...]:
    """Return gauges that began to disagree together, a faulty one first; () where each stands alone.

    Parameters
    ----------
    readings, loads
        (n, n_gauges) in microstrain, NaN where missing, and (n,), of the readings so far, of faulty gauges too.
    began
        log L (n,) of each faulty gauge for a beginning at each reading.
    """
    faulty = set(began)
    for g, own in began.items():
        near = np.flatnonzero(watch.neighbours[g])
        log_began = own - logsumexp(own)
        sound = [h for h in near.tolist() if h not in faulty]
        logs = _log_evidence(watch, readings, loads, faulty, sound)
        for h in faulty.intersection(near.tolist()):
            sound, logs = [*sound, h], np.column_stack([logs, _log_evidence(watch, readings, loads, faulty - {h}, [h])])
        if not sound:
            continue
        together = logsumexp(log_began[:, None] + logs, axis=0)
        alone = logsumexp(logs, axis=0) - np.log(len(logs))
        is_with = (together > np.log(len(sound) / watch.rate)) & (together > alone)
        if is_with.any():
            order = [g, *(sound[k] for k in np.argsort(-together) if is_with[k])]
            return tuple(watch.library.gauges[k] for k in order)
    return ()


def _log_evidence(watch: Watch, readings: Floats, loads: Floats, without: set[int], asked: list[int]) -> Floats:
    """Return log L (n, n_asked) of gauges for a beginning at each reading; some gauges are left out."""
    known = ~np.isnan(readings)
    known[:, sorted(without)] = False
    along, squares = np.zeros((len(readings), len(asked))), np.zeros((len(readings), len(asked)))
    for load in np.unique(loads).tolist():
        for pattern in np.unique(known[loads == load], axis=0):
            if not watch.parity.can_disagree(pattern):
                continue
            rows = (loads == load) & (known == pattern).all(axis=1)
            projector = watch.parity.projector(pattern)
            along[rows] = watch.parity.residuals(readings[rows], load, pattern)[:, asked]
            squares[rows] = np.diag(projector)[asked]
    since, information = (np.cumsum(rows[::-1], axis=0)[::-1] for rows in (along, squares))
    logs = []
    for scale in SCALES:
        spread = 1.0 + scale**2 * information
        logs.append(0.5 * scale**2 * since**2 / spread - 0.5 * np.log(spread))
    return np.asarray(logsumexp(logs, axis=0) - np.log(len(SCALES)))
