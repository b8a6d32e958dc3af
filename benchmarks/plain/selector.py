"""The plain selector: exact maps, Gauss and Newton's steps, Laplace's evidence of no, one or two effects, or unknown.

    mean reading = F(states, sizes) + difference + e,    size ~ N(mean, (k sd)^2) within its range, k = 1/3, 1, 3

in every cell (one test at one load) and gauge. F is the twin as the run says that it was built, asked with the effects
in it; the difference is what the run reads more at that load, else `BARE` of the reading. What an effect of the
structure changes is wrong by `SHARE` of itself at each reading. A pair holds one of `N_HEADS` single effects; those
that may count are fitted. What no effect explains is a course over the cells, of an unknown size at each gauge.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import logsumexp, ndtr

from femlib.arrays import FloatArray
from octmip.gap import Addition, AugmentedTwin, Campaign
from octmip.gap.doors.built import as_built
from octmip.gap.effects import in_chain
from octmip.gap.inference.candidates import bounds_of
from octmip.gap.preparation import library_of
from octmip.gap.twins import CachedTwin
from octmip.twin import Effect, Load, State, Twin, state_limits_of

PRIOR = {"none": 0.50, "single": 0.38, "pair": 0.07, "unknown": 0.04}
SCALES, UNKNOWN_SIZES = (1 / 3, 1.0, 3.0), (0.003, 0.01, 0.03, 0.1, 0.3)
SHARE, BARE, LEFT, CONSTANTS = 0.06, 0.05, 0.003, 0.08
"""Of what an effect changes; of the reading without a run at its load, and beside one."""
N_HEADS, N_PAIRS, STEPS, STEP, STATE_SD = 8, 24, 4, 0.2, 0.3
SEPARABLE, CREDIBLE, Z90, IDLE = 3.0, 0.95, 1.645, 1e-4
Member = tuple[Effect, str]


@dataclass(frozen=True, eq=False)
class PlainCause:
    """One explanation: (effect, place) of each member, (size, low, high) of each at 90 %, names not told apart."""

    members: tuple[Member, ...]
    sizes: FloatArray
    probability: float
    names: tuple[frozenset[str], ...]
    is_unknown: bool = False


@dataclass(frozen=True, eq=False)
class Selection:
    """Causes, most probable first, the fewest that hold 95 %, and each cell's state."""

    causes: tuple[PlainCause, ...]
    credible: tuple[PlainCause, ...]
    unknown_probability: float
    states: FloatArray


@dataclass(frozen=True, eq=False)
class _Fit:
    """Members, log evidence, open states and sizes, their sds, slopes (n, n_open + n_members), what members change."""

    members: tuple[Member, ...]
    log: float
    at: FloatArray
    spread: FloatArray
    slopes: FloatArray
    change: FloatArray


def select(campaign: Campaign, twin: Twin, run: Campaign | None = None) -> Selection:
    """Return the probability of no effect, of every single one, of pairs, and of something unknown."""
    sound = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
    sound = sound if run is None else as_built(sound, run, CONSTANTS)
    asked = Asked(campaign, sound, run)
    library = [e for e in library_of(sound, campaign).values() if not getattr(e, "is_nameless", False)]
    members = [(e, place) for e in library for place in e.places(sound)]
    share = {e.name: float(np.log(len(library) * max(1, len(e.places(sound))))) for e in library}
    none = asked.fitted(())
    singles = [asked.fitted((member,), none.at) for member in members]
    singles.sort(key=lambda fit: share[fit.members[0][0].name] - fit.log)
    pairs = [(one, two) for k, one in enumerate(singles[:N_HEADS]) for two in singles[k + 1 :]]
    pairs = [(one, two) for one, two in pairs if one.members[0][0] is not two.members[0][0]]
    logs = [asked.log_of_two(none, *pair) - sum(share[fit.members[0][0].name] for fit in pair) for pair in pairs]
    best = [pairs[k] for k in np.argsort(-np.array(logs))[:N_PAIRS]]
    doubles = [asked.fitted(a.members + b.members, [*none.at, a.at[-1], b.at[-1]]) for a, b in best]
    fits, prior = [none, *singles, *doubles], [PRIOR["none"], PRIOR["single"], 2.0 * PRIOR["pair"]]
    logs = [fit.log + np.log(prior[len(fit.members)]) - sum(share[e.name] for e, _ in fit.members) for fit in fits]
    logs.append(float(np.log(PRIOR["unknown"])) + asked.unknown(none))
    return _selection(asked, fits, np.exp(np.array(logs) - logsumexp(logs)))


class Asked:
    """The means of a campaign (n,), their variance, and what twin and effects make of them."""

    def __init__(self, campaign: Campaign, twin: CachedTwin, run: Campaign | None) -> None:
        self.twin, self.cells = twin, campaign.cells
        self.order = [twin.gauges.index(name) for name in campaign.gauges]
        self.known, limits = np.array([cell.state for cell in self.cells]), state_limits_of(twin)
        free = [(c.test, k) for c, s in zip(self.cells, self.known, strict=True) for k in np.flatnonzero(np.isnan(s))]
        self.open = {one: 0.95 * limits[one[1]] for one in free if limits[one[1]] > 0.0}
        self.of_load = {} if run is None else _differences(run, twin, campaign.gauges)
        mean, count = (np.array([getattr(cell, what) for cell in self.cells]) for what in ("mean", "count"))
        typical = np.sqrt(np.mean(self.reading((), np.zeros(len(self.open))) ** 2, axis=0))
        self.typical = np.maximum(typical, 0.01 * typical.max())
        is_run = np.array([cell.load in self.of_load for cell in self.cells])[:, None]
        variance = _noise([campaign, *([run] if run else [])]) * (1.0 + is_run) / np.maximum(count, 1)
        variance = variance + (np.where(is_run, LEFT, BARE) * self.typical) ** 2
        self.variance = np.where(count > 0, variance, 1e12 * self.typical**2)
        self.mean = np.where(count > 0, np.nan_to_num(mean), 0.0)

    def reading(self, members: Sequence[Member], at: Sequence[float] | FloatArray) -> FloatArray:
        """Return the readings (n_cells, n_gauges) with open states and sizes `at`."""
        n, states = len(self.open), np.nan_to_num(self.known)
        for (test, k), value in zip(self.open, at, strict=False):
            states[[cell.test == test for cell in self.cells], k] = value
        parts = [Addition(e, place, float(size)) for (e, place), size in zip(members, at[n:], strict=True)]
        parts.sort(key=lambda part: in_chain(part.effect))  # the structure first, the chain last
        whole = AugmentedTwin(self.twin, tuple(parts), self._difference)
        named = [dict(zip(self.twin.parameters, state.tolist(), strict=True)) for state in states]
        rows = [whole.predict(s, cell.load, cell.time) for s, cell in zip(named, self.cells, strict=True)]
        return np.array(rows)[:, self.order]

    def _difference(self, state: State, load: Load) -> FloatArray:
        return self.of_load.get(load, np.zeros(len(self.twin.gauges)))

    def fitted(self, members: tuple[Member, ...], start: Sequence[float] | FloatArray = ()) -> _Fit:
        """Return the most probable states and sizes, and the evidence; the first of them begin where they are told."""
        n, effects = len(self.open), [effect for effect, _ in members]
        low, high = np.array([*((0.0, most) for most in self.open.values()), *map(bounds_of, effects)]).reshape(-1, 2).T
        mean = np.array([0.5 * most for most in self.open.values()] + [e.prior_mean for e in effects])
        sd = np.array([STATE_SD] * n + [e.prior_sd for e in effects])
        share = np.array([0.0] * n + [0.0 if in_chain(e) else SHARE for e in effects])
        scaled = np.array([False] * n + [e.prior_mean == 0.0 for e in effects], dtype=bool)
        at = np.array([*start, *np.clip(mean, low, high)[len(start) :]])
        for _ in range(STEPS):
            here = self.reading(members, at)
            ahead = np.where(np.abs(at) > STEP * sd, -at, np.where(at + STEP * sd <= high, STEP, -STEP) * sd)
            moved = [(self.reading(members, at + step) - here).ravel() for step in np.diag(ahead)]
            slopes = (np.array(moved).reshape(len(sd), here.size) / ahead[:, None]).T
            weight = (self.variance.ravel() + np.sum((share * slopes * at) ** 2, axis=1)) ** -0.5
            white, left = slopes * weight[:, None], ((self.mean - here).ravel() + slopes @ at) * weight
            at = np.clip(_posterior(white, left, mean, np.where(scaled, SCALES[-1] * sd, sd))[0], low, high)
        logs, spread = [], np.zeros(len(sd))
        for scale in SCALES:
            own = np.where(scaled, scale * sd, sd)
            middle, covariance, log = _posterior(white, left, mean, own)
            spread = np.sqrt(np.diag(covariance))
            inside = [ndtr((high - m) / s) - ndtr((low - m) / s) for m, s in ((middle, spread), (mean, own))]
            logs.append(log + np.log(weight).sum() + np.log(np.maximum(inside[0], 1e-300) / inside[1]).sum())
        change = (self.reading(members, at) - self.reading((), at[:n])) / np.sqrt(self.variance)
        return _Fit(members, float(logsumexp(logs) - np.log(len(logs))), at, spread, slopes, change)

    def log_of_two(self, none: _Fit, one: _Fit, two: _Fit) -> float:
        """Return about what two effects have for evidence, by their slopes where they are alone."""
        weight, n = self.variance.ravel() ** -0.5, len(self.open)
        columns = np.column_stack([none.slopes, one.slopes[:, n:], two.slopes[:, n:]])
        effects = [one.members[0][0], two.members[0][0]]
        mean = np.array([*none.at, *(e.prior_mean for e in effects)])
        sd = np.array([STATE_SD] * n + [SCALES[-1] * e.prior_sd for e in effects])
        left = (self.mean - self.reading((), none.at)).ravel() + none.slopes @ none.at
        return _posterior(columns * weight[:, None], left * weight, mean, sd)[2]

    def unknown(self, none: _Fit) -> float:
        """Return the log evidence of courses over the cells, of a size of their own at every gauge."""
        here, n = self.reading((), none.at), len(self.cells)
        tests = np.array([[a.test == b.test for a in self.cells] for b in self.cells], dtype=float)
        logs = []
        for size, kind in product(UNKNOWN_SIZES, range(4)):
            total = 0.0
            for of, rest, own, typical in zip(here.T, (self.mean - here).T, self.variance.T, self.typical, strict=True):
                course = (np.ones((n, n)), np.outer(of, of) / typical**2, np.eye(n), tests)[kind]
                covariance = np.diag(own) + (size * typical) ** 2 * course
                total -= 0.5 * (rest @ np.linalg.solve(covariance, rest) + np.linalg.slogdet(covariance)[1])
            logs.append(total)
        return float(logsumexp(logs) - np.log(len(logs)))


def _posterior(
    white: FloatArray, left: FloatArray, mean: FloatArray, sd: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Return mean and covariance of what whitened columns (n, k) are multiplied by, and the log evidence of (n,)."""
    inner = white.T @ white + np.diag(sd**-2.0)
    covariance = np.asarray(np.linalg.inv(inner), dtype=np.float64)
    middle = covariance @ (white.T @ left + mean / sd**2)
    misfit = left @ left + np.sum((mean / sd) ** 2) - middle @ inner @ middle
    return middle, covariance, float(-0.5 * (misfit + np.linalg.slogdet(inner)[1]) - np.log(sd).sum())


def _differences(run: Campaign, twin: CachedTwin, gauges: Sequence[str]) -> dict[Load, FloatArray]:
    """Return what the run reads more than the twin (n_gauges of the twin,), by load; 0 where it reads nothing."""
    known = [(twin.gauges.index(name), run.gauges.index(name)) for name in gauges]
    found = {}
    for cell in run.cells:
        state = dict(zip(run.parameters, np.nan_to_num(cell.state).tolist(), strict=True))
        there, rest = twin.predict(state, cell.load), np.zeros(len(twin.gauges))
        for k, own in known:
            rest[k] = cell.mean[own] - there[k] if cell.count[own] else 0.0
        found[cell.load] = rest
    return found


def _noise(campaigns: Sequence[Campaign]) -> FloatArray:
    """Return the variance (n_gauges,) of one reading, grown by how alike neighbours in time are."""
    columns = [[one.gauges.index(name) for name in campaigns[0].gauges] for one in campaigns]
    pairs = [(one, at, cell) for one, at in zip(campaigns, columns, strict=True) for cell in one.cells]
    rests = [(one.readings[cell.rows] - cell.mean)[:, at] for one, at, cell in pairs if len(cell.rows) > 1]
    free = np.sum([np.isfinite(rest).sum(axis=0) - 1 for rest in rests], axis=0)
    variance = np.sum([np.nansum(rest**2, axis=0) for rest in rests], axis=0) / np.maximum(free, 1)
    alike = float(np.sum([np.nansum(rest[1:] * rest[:-1]) for rest in rests]))
    rho = float(np.clip(alike / max(float((variance * free).sum()), 1e-300), 0.0, 0.9))
    grown = (1.0 + rho) / (1.0 - rho) if rho > 2.0 / np.sqrt(free.sum()) else 1.0
    return np.asarray(grown * np.maximum(variance, 1e-12 * variance.max()))


def _selection(asked: Asked, fits: Sequence[_Fit], probability: FloatArray) -> Selection:
    """Return the causes: hypotheses whose changes cannot be told apart are one, under the name of the simplest."""
    n, unknown = len(asked.open), float(probability[-1])
    causes, left = [PlainCause((), np.zeros((0, 3)), unknown, (), is_unknown=True)], np.argsort(-probability[:-1])
    while len(left) and probability[left[0]] > IDLE:
        is_same = np.array([np.linalg.norm(fits[k].change - fits[left[0]].change) < SEPARABLE for k in left])
        same, left = left[is_same], left[~is_same]
        head = fits[min(same, key=lambda k: len(fits[k].members))]
        called = [{(e.name, place) for e, place in fits[k].members} for k in same]
        alike = [own for own in called if len(own) == len(head.members)]
        beside = [{(e.name, at) for e, at in head.members} - {(own.name, place)} for own, place in head.members]
        names = tuple(frozenset(name for own in alike if rest < own for name, _ in own - rest) for rest in beside)
        sizes = np.stack([head.at[n:] + z * head.spread[n:] for z in (0.0, -Z90, Z90)], axis=1)
        causes.append(PlainCause(head.members, sizes, float(probability[same].sum()), names))
    causes.sort(key=lambda cause: -cause.probability)
    before = np.cumsum([0.0, *(cause.probability for cause in causes)])
    credible = tuple(cause for cause, sum_ in zip(causes, before, strict=False) if sum_ < CREDIBLE)
    states = np.nan_to_num(asked.known)
    for (test, k), value in zip(asked.open, fits[0].at.tolist(), strict=True):
        states[[cell.test == test for cell in asked.cells], k] = value
    return Selection(tuple(causes), credible, unknown, states)
