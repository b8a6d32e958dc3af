"""Finding: the cause of an alarm of a watch, and the state that it proposes to add to the library."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import chi2, norm

from octmip.monitor.candidates import Candidate
from octmip.monitor.watch import MonitorState, Watch

Floats = NDArray[np.float64]

RATE = 0.01
"""Chance that any gauge is named although it agrees (Bonferroni over the gauges)."""
MARGIN = 6.0
"""Chi-squared by which damage must explain a residual better than one gauge alone: odds of 20."""
MOST_FAILED = 3
"""Gauges that may have failed when the first is named."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A state to add to the library, for `Library.with_state`.

    Attributes
    ----------
    state
        values by parameter, the new one among them, damage as a fraction.
    strains
        (n_gauges,) microstrain per unit of load factor.
    size, sd, unit
        of the damage that was found, as estimated.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2", "g3"), [[100, 200, 300], [150, 200, 300]], 10.0)
    >>> bump = Candidate("tip", "bump", np.array([10.0, 30.0, 40.0]), sizes=(3.0,), unit="mm", load_power=1)
    >>> watch = Watch(library, (bump,), horizon=10, largest_load=1.0)
    >>> seen = watch.seen(np.array([[130.0, 290.0, 420.0]] * 3), [1.0] * 3)
    >>> proposal = explain(watch, seen).proposal
    >>> round(proposal.size, 1), proposal.unit, proposal.strains.round().tolist()
    (3.0, 'mm', [130.0, 290.0, 420.0])
    """

    state: Mapping[str, float]
    strains: Floats
    size: float
    sd: float
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """The probable cause why an asset is no longer one of the library.

    Attributes
    ----------
    kind
        "gauge", the name of an effect, or "unknown".
    name
        the gauge or place; "" if unknown.
    probability
        of this kind and name among all hypotheses; of "unknown" where a gauge was found by elimination.
    gauges
        names of those whose mean residual cannot be noise, farthest off first.
    together
        names of those that began to disagree at one reading, as damage near them makes them; () if none were found.
    since
        reading from which the residuals have been off, as far as that can be told.
    proposal
        the state to add; None for a gauge's fault.
    words
        the finding in one or two sentences.
    ranking
        kind, name and probability of all hypotheses, the most probable first.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2", "g3"), [[100, 200, 300], [150, 200, 300]], 10.0)
    >>> watch = Watch(library, horizon=10, largest_load=1.0)
    >>> finding = explain(watch, watch.seen(np.array([[100.0, 200.0, 400.0]] * 3), [1.0] * 3))
    >>> finding.kind, finding.name, finding.since
    ('gauge', 'g3', 0)
    """

    kind: str
    name: str
    probability: float
    gauges: tuple[str, ...]
    since: int
    proposal: Proposal | None
    words: str
    ranking: tuple[tuple[str, str, float], ...] = ()
    together: tuple[str, ...] = ()


def explain(
    watch: Watch, monitor_state: MonitorState, row: int = 0, state: int = 0, together: tuple[str, ...] = ()
) -> Finding:
    """Return the finding on one asset.

    Parameters
    ----------
    state
        index of the library's state that the asset was taken to be in.
    together
        gauges that began to disagree at one reading (`Series`): then none of them is faulty.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2", "g3"), [[100, 200, 300], [150, 200, 300]], 10.0)
    >>> watch = Watch(library, horizon=10, largest_load=1.0)
    >>> seen = watch.observe(watch.start(), np.array([[100.0, 200.0, 400.0]]), 1.0)
    >>> explain(watch, seen).name
    'g3'
    """
    logs = watch.log_parts(monitor_state)[row, :-1]
    if together:
        is_gauge = np.array([candidate.kind == "gauge" for candidate, _ in watch.hypotheses] + [False])
        logs = np.where(is_gauge, -np.inf, logs)
    share = np.exp(logs - logsumexp(logs))
    by_name: dict[tuple[str, str], float] = {}
    for (candidate, _), part in zip(watch.hypotheses, share, strict=False):
        key = (candidate.kind, candidate.name)
        by_name[key] = by_name.get(key, 0.0) + float(part)
    by_name[("unknown", "")] = float(share[-1])
    (kind, name), probability = max(by_name.items(), key=lambda item: item[1])
    window, gauges = _disagreeing(watch, monitor_state, row)
    named = _best(watch, logs, kind, name)
    if kind != "gauge" and not together and (failed := _failed_gauge(watch, monitor_state, row, window, named)):
        kind, name, named = "gauge", failed, _best(watch, logs, "gauge", failed)
    since = window * watch.horizon // monitor_state.sums.shape[1]
    proposal, hint = None, ""
    if named is None:
        proposal, hint = _unknown(watch, monitor_state, row, state, window), _nearest(watch, monitor_state, row, window)
    elif kind != "gauge":
        proposal = _proposed(watch, monitor_state, row, state, named)
    words = _words(kind, name, probability, gauges, together, proposal, hint)
    ranking = tuple((*key, part) for key, part in sorted(by_name.items(), key=lambda item: -item[1]))
    return Finding(kind, name, probability, gauges, since, proposal, words, ranking, together)


def _disagreeing(watch: Watch, monitor_state: MonitorState, row: int) -> tuple[int, tuple[str, ...]]:
    """Return the beginning since which residuals are farthest off, and the gauges that are, farthest first."""
    every = np.ones(len(watch.library.gauges), dtype=bool)
    spread = np.sqrt(np.maximum(np.diag(watch.parity.projector(every)), 1e-12))
    counts = np.maximum(monitor_state.counts[row], 1.0)
    z = monitor_state.sums[row] / np.sqrt(counts)[:, None] / spread
    limit = float(norm.isf(RATE / 2 / len(every)))
    window = int(np.argmax(np.square(monitor_state.sums[row]).sum(axis=1) / counts))
    order = np.argsort(-np.abs(z[window]), kind="stable")
    return window, tuple(watch.library.gauges[g] for g in order if abs(z[window, g]) > limit)


def _best(watch: Watch, logs: Floats, kind: str, name: str) -> Candidate | None:
    """Return the candidate of a kind and name at its most probable size; None of the unknown."""
    own = [k for k, (candidate, _) in enumerate(watch.hypotheses) if (candidate.kind, candidate.name) == (kind, name)]
    return watch.hypotheses[max(own, key=lambda k: logs[k])][0] if own else None


def _failed_gauge(watch: Watch, monitor_state: MonitorState, row: int, window: int, named: Candidate | None) -> str:
    """Return the worst of a few gauges without which the mean residual is noise, "" if there are none.

    Faults may have any size, and two gauges may fail before the first is named. Neighbours are damage, not faults.
    Where the candidate that is `named` leaves noise, one gauge must leave hardly more.
    """
    mean = monitor_state.sums[row, window] / np.sqrt(max(float(monitor_state.counts[row, window]), 1.0))
    known, failed, left, most = mean != 0.0, list[int](), np.inf, MOST_FAILED
    if named is not None:
        along = named.signature / watch.library.noise_sd @ watch.parity.projector(known)
        left = float(mean @ mean - (mean @ along) ** 2 / (along @ along))
        fits = chi2.sf(left, watch.parity.degrees(known) - 1) > RATE
        left, most = (left + MARGIN, 1) if fits else (np.inf, MOST_FAILED)
    while len(failed) < most and known.sum() > 1:
        projector = watch.parity.projector(known)
        rest = np.where(known, mean, 0.0) @ projector
        without = np.where(known, rest @ rest - rest**2 / np.maximum(np.diag(projector), 1e-12), np.inf)
        worst = int(np.argmin(without))
        if watch.neighbours[worst, failed].any():
            return ""
        failed.append(worst)
        if without[worst] < left and chi2.sf(float(without[worst]), watch.parity.degrees(known) - 1) > RATE:
            return watch.library.gauges[failed[0]]
        known[worst] = False
    return ""


def _proposed(watch: Watch, monitor_state: MonitorState, row: int, state: int, candidate: Candidate) -> Proposal:
    """Return the state with the size that fits the residuals best, by least squares over the best beginning."""
    library = watch.library
    every = np.ones(len(library.gauges), dtype=bool)
    projected = candidate.signature / library.noise_sd @ watch.parity.projector(every)
    sums, counts = monitor_state.sums, monitor_state.counts
    if candidate.load_power == 1:
        sums, counts = monitor_state.loaded_sums, monitor_state.squared_loads
    weight = np.maximum(counts[row] * float(projected @ projected), 1e-300)
    fit = sums[row] @ projected
    best = int(np.argmax(fit**2 / weight))
    size, sd = float(fit[best] / weight[best]), float(1.0 / np.sqrt(weight[best]))
    value = size / 100.0 if candidate.unit == "%" else size
    known = dict(zip(library.parameters, library.states[state].tolist(), strict=True))
    strains = library.strains[state] + size * candidate.signature
    return Proposal({**known, candidate.name: value}, strains, size, sd, candidate.unit)


def _unknown(watch: Watch, monitor_state: MonitorState, row: int, state: int, window: int) -> Proposal:
    """Return the state with the mean residual added, which no candidate explains."""
    library = watch.library
    squares = max(float(monitor_state.squared_loads[row, window]), 1e-300)
    change = monitor_state.loaded_sums[row, window] / squares * library.noise_sd
    known = dict(zip(library.parameters, library.states[state].tolist(), strict=True))
    return Proposal({**known, "outside": 1.0}, library.strains[state] + change, 1.0, 0.0, "of what was seen")


def _nearest(watch: Watch, monitor_state: MonitorState, row: int, window: int) -> str:
    """Return the place whose signature is most like the mean residual, if any has three quarters of its length."""
    library, seen = watch.library, monitor_state.sums[row, window]
    every = np.ones(len(library.gauges), dtype=bool)
    best, nearest = 0.75, ""
    for candidate in watch.candidates:
        projected = candidate.signature / library.noise_sd @ watch.parity.projector(every)
        length = float(np.linalg.norm(projected) * np.linalg.norm(seen))
        if length > 0.0 and float(projected @ seen) / length > best:
            best, nearest = float(projected @ seen) / length, candidate.name
    return nearest


def _words(
    kind: str,
    name: str,
    probability: float,
    gauges: tuple[str, ...],
    together: tuple[str, ...],
    proposal: Proposal | None,
    hint: str,
) -> str:
    off = "The readings fit no state"
    if gauges:
        verb = "Gauges {} disagree" if len(gauges) > 1 else "Gauge {} disagrees"
        off = f"{verb.format(', '.join(gauges[:4]))} with every state"
    if kind == "gauge":
        sure = f"{100 * probability:.0f} %"
        return (
            f"{off}; most likely gauge {name} is faulty ({sure}), or the structure is damaged at this gauge alone. "
            "Inspect both; it is left out meanwhile."
        )
    if together:
        off = f"Gauges {', '.join(together)} began to disagree together, as damage near them does and faults do not"
    if kind == "unknown" or proposal is None:
        like = f"; {hint} would look most like it" if hint else ""
        return f"{off}, in a way that no candidate explains{like}. Inspect the structure around them."
    thing = kind.replace("_", " ")
    return (
        f"{off}; most likely {thing} at {name} ({100 * probability:.0f} %), {proposal.size:.0f} +- {proposal.sd:.0f} "
        f"{proposal.unit}. Inspect it; if it is so, add the proposed state to the library and train the trees again."
    )
