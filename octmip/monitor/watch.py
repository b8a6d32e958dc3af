"""Watch: a test whether the asset is still one of the library, a p-value per reading and a sequential test over all.

Every reading leaves a residual e that no state of the library can change (octmip.monitor.parity): noise alone while the
asset is in the library. A hypothesis c (a candidate at one of its sizes) expects the residual to be shifted by d_c from
some reading on. Its evidence is a sum over the readings at which it may have begun, w = 1 / horizon each,

    R_c(t) = (R_c(t - 1) + w) exp(d_c . e_t - |d_c|^2 / 2),      E(t) = sum_c prior_c R_c(t) + (1 - t w),

and so is that of a shift in any direction, normal with scale tau, begun at one of a few readings j, with S the sum of n
residuals since then and d degrees of freedom:  (1 + n tau^2)^(-d/2) exp(tau^2 |S|^2 / (2 (1 + n tau^2))).

In the library E is a martingale that starts at 1, so the probability that it ever reaches 1 / rate within a horizon is
at most `rate`, whatever states the asset goes through. A gauge may be missing now and then: each factor is made for the
gauges at hand, and d is then n_gauges: the sum M of the n projections has log det(I + tau^2 M) <= d log(1 + n tau^2)
and M <= n I, so the formula is a lower bound of the mixture.

Source: J. Ville, Etude critique de la notion de collectif (1939); A. N. Shiryaev, Theory Probab. Appl. 8 (1963) 22-46
(a sum over beginnings); H. Robbins, Ann. Math. Statist. 41 (1970) 1397-1409 (a mixture over shifts).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import chi2

from octmip.errors import ProblemError
from octmip.monitor.candidates import Candidate, gauge_candidates
from octmip.monitor.leaf_likelihood import check_readings
from octmip.monitor.library import Applied, Library
from octmip.monitor.parity import Parity

Floats = NDArray[np.float64]

MOST_TABLES = 64
"""Tables kept, one for each load and set of gauges at hand."""

N_NEAREST = 4
"""A gauge is a neighbour of so many others that lie nearest to it."""
SCALES = (0.3, 1.0, 3.0)
"""Scales tau of a shift in an unknown direction, standard deviations per reading."""
N_BEGINNINGS = 10
"""Readings of a horizon at which a shift in an unknown direction may begin."""


@dataclass(frozen=True, slots=True, eq=False)
class MonitorState:
    """The state of a watch over n assets: the evidence of the readings so far.

    Attributes
    ----------
    n_seen
        readings since its start.
    log_evidence
        (n, n_hypotheses) log R of every hypothesis.
    sums
        (n, N_BEGINNINGS, n_gauges) sums of residuals since each beginning; loaded_sums: times their loads.
    counts
        (n, N_BEGINNINGS) readings in them; squared_loads: their loads squared.
    degrees
        (n,) d of the formula for an unknown direction.
    p_value
        (n,) of the last reading: how often a reading of the library is as far off or farther.
    log_e
        (n,) log E; is_alarm: (n,) whether E has ever reached 1 / rate.
    """

    n_seen: int
    log_evidence: Floats
    sums: Floats
    loaded_sums: Floats
    counts: Floats
    squared_loads: Floats
    degrees: Floats
    p_value: Floats
    log_e: Floats
    is_alarm: NDArray[np.bool_]


@dataclass(slots=True, eq=False)
class Watch:
    """A sequential test for what lies outside a library; keeps its tables, so it is not frozen.

    Attributes
    ----------
    library
        the states.
    candidates
        damages and faults to look for; those of single gauges are always added.
    rate
        probability of at most one false alarm in a horizon.
    horizon
        readings after which the test starts afresh (a mission).
    largest_load
        load factor that readings have at most.
    places
        (n_gauges, 2) of the gauges [m]; None: not known, and every gauge is taken as a neighbour of every other.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2", "g3"), [[100, 200, 300], [150, 200, 300]], 10.0)
    >>> watch = Watch(library, horizon=10, largest_load=1.0)
    >>> seen = watch.observe(watch.start(), np.array([[100.0, 200.0, 300.0]]), 1.0)
    >>> seen.is_alarm.tolist()
    [False]
    """

    library: Library
    candidates: Sequence[Candidate] = ()
    rate: float = 0.01
    horizon: int = 100
    largest_load: float = 3.0
    places: Floats | None = None
    parity: Parity = field(init=False, repr=False)
    neighbours: NDArray[np.bool_] = field(init=False, repr=False)
    hypotheses: tuple[tuple[Candidate, float], ...] = field(init=False, repr=False)
    _log_prior: Floats = field(init=False, repr=False)
    _tables: dict[tuple[bytes, float], Floats] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        if not 0.0 < self.rate < 1.0 or self.horizon < 1:
            raise ProblemError(
                f"rate is {self.rate} and horizon {self.horizon}; expected a rate in (0, 1) and at least one reading"
            )
        self.parity = Parity(self.library, self.largest_load)
        self.neighbours = _neighbours(len(self.library.gauges), self.places)
        everything = (*gauge_candidates(self.library), *self.candidates)
        pairs = [(one, size) for one in everything for size in one.sizes if self._can_show(one, size)]
        self.hypotheses = tuple(pairs)
        # a third each for gauges, other candidates and the unknown; alike within a third
        is_gauge = np.array([candidate.kind == "gauge" for candidate, _ in pairs])
        share = np.where(is_gauge, 1.0 / is_gauge.sum(), 1.0 / max(1, (~is_gauge).sum()))
        self._log_prior = np.log(share / (3.0 if (~is_gauge).any() else 2.0))

    def _can_show(self, candidate: Candidate, size: float) -> bool:
        """Whether a whole horizon at the largest load could show it; what could not would only dilute the rest."""
        every = np.ones(len(self.library.gauges), dtype=bool)
        scale = size * self.largest_load**candidate.load_power
        shift = scale * candidate.signature / self.library.noise_sd @ self.parity.projector(every)
        return bool(np.linalg.norm(shift) * np.sqrt(self.horizon) > np.sqrt(-2.0 * np.log(self.rate)))

    def start(self, n: int = 1) -> MonitorState:
        """Return the monitor state over n assets before any reading."""
        g = len(self.library.gauges)
        sums, counts = np.zeros((n, N_BEGINNINGS, g)), np.zeros((n, N_BEGINNINGS))
        nothing = np.full((n, len(self.hypotheses)), -np.inf)
        never = np.zeros(n, dtype=bool)
        return MonitorState(0, nothing, sums, sums, counts, counts, np.zeros(n), np.ones(n), np.zeros(n), never)

    def restarted(self, monitor_state: MonitorState, row: int) -> MonitorState:
        """Return the state with one asset's evidence and alarm cleared, after a gauge was left out or repaired."""
        kept = np.arange(len(monitor_state.p_value)) != row
        fresh = self.start(1)
        names = ("log_evidence", "sums", "loaded_sums", "counts", "squared_loads", "degrees", "log_e", "is_alarm")
        parts = {}
        for name in names:
            old, new = getattr(monitor_state, name), getattr(fresh, name)
            parts[name] = np.where(kept.reshape(-1, *(1,) * (old.ndim - 1)), old, new)
        return replace(monitor_state, **parts)

    def observe(self, monitor_state: MonitorState, readings: Floats, load_factor: Applied | Floats) -> MonitorState:
        """Return the monitor state after one reading of every asset, (n, n_gauges) in microstrain, NaN where missing.

        Raises
        ------
        DataError
            the readings have another shape or hold an infinite number, or a load is not positive.
        ProblemError
            so many gauges are missing that the library explains any reading.
        """
        rows = check_readings(readings, self.library)
        loads = self.library.checked_loads(load_factor, len(rows))
        if monitor_state.n_seen == self.horizon:
            monitor_state = replace(self.start(len(rows)), is_alarm=monitor_state.is_alarm)
        residuals, log_ratio, degrees = self._compared(rows, loads)
        has_gap = np.isnan(rows).any(axis=1)
        begins = np.arange(N_BEGINNINGS) * self.horizon // N_BEGINNINGS <= monitor_state.n_seen
        is_on = begins.astype(np.float64)
        is_seen = np.where(degrees > 0, 1.0, 0.0)[:, None] * is_on
        new = MonitorState(
            monitor_state.n_seen + 1,
            np.logaddexp(monitor_state.log_evidence, -np.log(self.horizon)) + log_ratio,
            monitor_state.sums + is_on[:, None] * residuals[:, None, :],
            monitor_state.loaded_sums + is_on[:, None] * (loads[:, None] * residuals)[:, None, :],
            monitor_state.counts + is_seen,
            monitor_state.squared_loads + is_seen * loads[:, None] ** 2,
            np.maximum(monitor_state.degrees, np.where(has_gap, len(self.library.gauges), degrees)),
            np.where(degrees > 0, chi2.sf(np.square(residuals).sum(axis=1), np.maximum(degrees, 1)), 1.0),
            monitor_state.log_e,
            monitor_state.is_alarm,
        )
        log_e = logsumexp(self.log_parts(new), axis=1)
        return replace(new, log_e=log_e, is_alarm=monitor_state.is_alarm | (log_e >= -np.log(self.rate)))

    def seen(self, readings: Floats, loads: Sequence[Applied]) -> MonitorState:
        """Return the monitor state after readings (n, n_gauges) of one asset, without those of too few gauges."""
        state = self.start()
        for row, load in zip(readings, loads, strict=True):
            if self.parity.can_disagree(~np.isnan(row)):
                state = self.observe(state, row[None], load)
        return state

    def _compared(self, rows: Floats, loads: Floats) -> tuple[Floats, Floats, Floats]:
        """Return residuals (n, n_gauges), log ratios (n, n_hypotheses) and degrees of freedom (n,)."""
        is_known = ~np.isnan(rows)
        residuals, ratios = np.zeros(rows.shape), np.zeros((len(rows), len(self.hypotheses)))
        degrees = np.zeros(len(rows))
        keys = np.column_stack([is_known.astype(np.float64), loads])
        patterns, of_row = np.unique(keys, axis=0, return_inverse=True)
        for k, pattern in enumerate(patterns):
            chosen, known, load = np.flatnonzero(of_row.ravel() == k), pattern[:-1] > 0, float(pattern[-1])
            self.library.checked_load(load)
            if not known.any():
                continue
            e = self.parity.residuals(rows[chosen], load, known)
            shifts = self._shifts(known, load)
            residuals[chosen] = e
            ratios[chosen] = e @ shifts.T - 0.5 * np.square(shifts).sum(axis=1)
            degrees[chosen] = self.parity.degrees(known)
        return residuals, ratios, degrees

    def _shifts(self, is_known: NDArray[np.bool_], load: float) -> Floats:
        """Return the shift of the residual of a reading under every hypothesis, (n_hypotheses, n_gauges)."""
        key = (is_known.tobytes(), load)
        if key not in self._tables:
            if len(self._tables) >= MOST_TABLES:  # loads and missing gauges need not ever repeat
                self._tables.clear()
            rows = [size * load**candidate.load_power * candidate.signature for candidate, size in self.hypotheses]
            self._tables[key] = np.array(rows) / self.library.noise_sd @ self.parity.projector(is_known)
        return self._tables[key]

    def log_parts(self, monitor_state: MonitorState) -> Floats:
        """Return the logs of the terms of E, (n, n_hypotheses + 2): hypotheses, the unknown, beginnings to come."""
        to_come = max(0.0, 1.0 - monitor_state.n_seen / self.horizon)
        share_known = float(np.exp(self._log_prior).sum())
        with np.errstate(divide="ignore"):
            rest = np.full(len(monitor_state.p_value), np.log(share_known * to_come))
        return np.column_stack(
            [monitor_state.log_evidence + self._log_prior, self._log_unknown(monitor_state, 1.0 - share_known), rest]
        )

    def _log_unknown(self, monitor_state: MonitorState, prior: float) -> Floats:
        """Return the log evidence (n,) of a shift in an unknown direction; beginnings to come count 1."""
        square = np.square(monitor_state.sums).sum(axis=2)
        logs = []
        for tau in SCALES:
            spread = 1.0 + monitor_state.counts * tau**2
            logs.append(0.5 * tau**2 * square / spread - 0.5 * monitor_state.degrees[:, None] * np.log(spread))
        stacked = np.concatenate(logs, axis=1)
        return np.asarray(logsumexp(stacked, axis=1) + np.log(prior / stacked.shape[1]))


def _neighbours(n: int, places: Floats | None) -> NDArray[np.bool_]:
    """Return which gauges are neighbours (n, n): one is among the nearest of the other."""
    if places is None:
        return ~np.eye(n, dtype=bool)
    if np.shape(places) != (n, 2):
        raise ProblemError(
            f"places has shape {np.shape(places)}; expected ({n}, 2), one row for each gauge; give these"
        )
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = np.zeros((n, n), dtype=bool)
    np.put_along_axis(nearest, np.argsort(apart, axis=1, kind="stable")[:, :N_NEAREST], True, axis=1)
    np.fill_diagonal(nearest, False)
    return np.asarray(nearest | nearest.T)
