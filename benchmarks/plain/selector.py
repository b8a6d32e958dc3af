"""The plain selector: exact maps, Gauss and Newton's steps, Laplace's evidence of no, one or two effects, or unknown.

    mean reading = F(sizes) + difference + e,    size ~ N(mean, (k sd)^2) within its range, k = 1/3, 1, 3

in every cell and gauge. F is the twin as the run says that it was built, with the effects in it; the difference is what
the run reads more at that load. What an effect of the structure changes is wrong by `SHARE` of itself. Pairs hold one
of the `N_HEADS` best single effects. What no effect explains is a course over the cells. Unknown states count as sound.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from benchmarks.plain.asked import Asked, Member
from femlib.arrays import FloatArray
from octmip.gap import Campaign
from octmip.gap.effects import in_chain
from octmip.gap.inference.candidates import bounds_of
from octmip.twin import Twin

PRIOR, SCALES = {"none": 0.50, "single": 0.38, "pair": 0.07, "unknown": 0.04}, (1 / 3, 1.0, 3.0)
UNKNOWN_SIZES, SHARE, STEP, STEPS = (0.003, 0.01, 0.03, 0.1, 0.3), 0.06, 0.2, 4
N_HEADS, N_BESIDE, SEPARABLE, CREDIBLE, Z90, IDLE = 4, 8, 3.0, 0.95, 1.645, 1e-4


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
    """Causes, most probable first, the fewest that hold 95 %, and the probability of something unknown."""

    causes: tuple[PlainCause, ...]
    credible: tuple[PlainCause, ...]
    unknown_probability: float


@dataclass(frozen=True, eq=False)
class _Fit:
    """Members, log evidence, sizes (k, 3: middle, low, high of 90 %), what they change (n,) in sds."""

    members: tuple[Member, ...]
    log: float
    sizes: FloatArray
    change: FloatArray


def select(campaign: Campaign, twin: Twin, run: Campaign | None = None) -> Selection:
    """Return the probability of no effect, of every single one, of pairs, and of something unknown."""
    asked = Asked.of(campaign, twin, run)
    members = asked.members
    share = {
        e.name: float(np.log(len({o.name for o, _ in members}) * sum(o is e for o, _ in members))) for e, _ in members
    }
    singles = [_fitted(asked, (member,)) for member in members]
    heads = sorted(singles, key=lambda fit: share[fit.members[0][0].name] - fit.log)[:N_HEADS]
    pairs = {
        frozenset((effect.name, place) for effect, place in pair): pair
        for head in heads
        for pair in _pairs(asked, head, singles)
    }
    fits = [_fitted(asked, ()), *singles, *(_fitted(asked, pair) for pair in pairs.values())]
    prior = np.log([PRIOR["none"], PRIOR["single"], 2.0 * PRIOR["pair"]])
    logs = [fit.log + prior[len(fit.members)] - sum(share[e.name] for e, _ in fit.members) for fit in fits]
    logs.append(float(np.log(PRIOR["unknown"])) + _unknown(asked))
    return _selection(fits, np.exp(np.array(logs) - logsumexp(logs)))


def _pairs(asked: Asked, head: _Fit, singles: Sequence[_Fit]) -> list[tuple[Member, ...]]:
    """Return an effect with each of `N_BESIDE` others whose changes are most like what it leaves."""
    others = [one for one in singles if one.members[0][0] is not head.members[0][0]]
    rest = ((asked.mean - asked.reading((), ())) / np.sqrt(asked.variance) - head.change).ravel()
    like = [(rest @ one.change.ravel()) ** 2 / max(np.sum(one.change**2), 1e-300) for one in others]
    return [head.members + others[k].members for k in np.argsort(like)[::-1][:N_BESIDE]]


def _fitted(asked: Asked, members: tuple[Member, ...]) -> _Fit:
    """Return the most probable sizes of members and their evidence, summed over the scales of their priors."""
    low, high = np.array([bounds_of(effect) for effect, _ in members]).reshape(-1, 2).T
    mean, sd = np.array([[e.prior_mean, e.prior_sd] for e, _ in members]).reshape(-1, 2).T
    share = np.array([0.0 if in_chain(effect) else SHARE for effect, _ in members])
    at, sound = np.clip(mean, low, high), asked.reading((), ())
    for _ in range(STEPS):
        here = asked.reading(members, at)
        ahead = np.where(np.abs(at) > STEP * sd, -at, np.where(at + STEP * sd <= high, STEP, -STEP) * sd)
        moved = [(asked.reading(members, at + step) - here).ravel() for step in np.diag(ahead)]
        slopes = (np.array(moved).reshape(len(sd), here.size) / ahead[:, None]).T
        weight = (asked.variance.ravel() + np.sum((share * slopes * at) ** 2, axis=1)) ** -0.5
        white, left = slopes * weight[:, None], ((asked.mean - here).ravel() + slopes @ at) * weight
        at = _posterior(white, left, mean, np.where(mean == 0.0, SCALES[-1] * sd, sd), (low, high))[0]
    found = [_posterior(white, left, mean, np.where(mean == 0.0, scale * sd, sd), (low, high)) for scale in SCALES]
    spread = np.sqrt(np.diag(found[-1][1]))
    sizes = np.stack([at + z * spread for z in (0.0, -Z90, Z90)], axis=1)
    log = logsumexp([one[2] for one in found]) - np.log(len(SCALES)) + np.log(weight).sum()
    return _Fit(members, float(log), sizes, (asked.reading(members, at) - sound) / np.sqrt(asked.variance))


def _posterior(
    white: FloatArray, left: FloatArray, mean: FloatArray, sd: FloatArray, ends: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, float]:
    """Return what whitened columns (n, k) are multiplied by, within its ends, its covariance, and the log evidence."""
    inner = white.T @ white + np.diag(sd**-2.0)
    covariance = np.asarray(np.linalg.inv(inner), dtype=np.float64)
    middle = np.clip(covariance @ (white.T @ left + mean / sd**2), *ends)
    misfit = np.sum((left - white @ middle) ** 2) + np.sum(((middle - mean) / sd) ** 2)
    return middle, covariance, float(-0.5 * (misfit + np.linalg.slogdet(inner)[1]) - np.log(sd).sum())


def _unknown(asked: Asked) -> float:
    """Return the log evidence of a course over the cells, of a size of its own at every gauge: equal, or free."""
    rest, n = asked.mean - asked.reading((), ()), len(asked.mean)
    logs = []
    for size in UNKNOWN_SIZES:
        for course in (np.ones((n, n)), np.eye(n)):
            total = 0.0
            for own, variance, typical in zip(rest.T, asked.variance.T, asked.typical, strict=True):
                covariance = np.diag(variance) + (size * typical) ** 2 * course
                total -= 0.5 * (own @ np.linalg.solve(covariance, own) + np.linalg.slogdet(covariance)[1])
            logs.append(total)
    return float(logsumexp(logs) - np.log(len(logs)))


def _selection(fits: Sequence[_Fit], probability: FloatArray) -> Selection:
    """Return the causes: hypotheses whose changes cannot be told apart are one, under the name of the simplest."""
    unknown = float(probability[-1])
    causes, left = [PlainCause((), np.zeros((0, 3)), unknown, (), is_unknown=True)], np.argsort(-probability[:-1])
    while len(left) and probability[left[0]] > IDLE:
        is_same = np.array([np.linalg.norm(fits[k].change - fits[left[0]].change) < SEPARABLE for k in left])
        same, left = left[is_same], left[~is_same]
        head = fits[min(same, key=lambda k: len(fits[k].members))]
        called = [{(e.name, place) for e, place in fits[k].members} for k in same]
        beside = [{(e.name, at) for e, at in head.members} - {(own.name, place)} for own, place in head.members]
        alike = [own for own in called if len(own) == len(head.members)]
        names = tuple(frozenset(name for own in alike if rest < own for name, _ in own - rest) for rest in beside)
        causes.append(PlainCause(head.members, head.sizes, float(probability[same].sum()), names))
    causes.sort(key=lambda cause: -cause.probability)
    before = np.cumsum([0.0, *(cause.probability for cause in causes)])
    credible = tuple(cause for cause, sum_ in zip(causes, before, strict=False) if sum_ < CREDIBLE)
    return Selection(tuple(causes), credible, unknown)
