"""The posterior over sets of candidates: which exist, how probable each is before the readings, and its evidence.

    for each noise and level of the difference that the readings bear        (`_variants`)
        for each starting state                                               (`starting_states`)
            every single candidate; the best of them beside every other;
            the best pairs beside every other, where pairs gain               (`likely_sets`)
        the best sets, each about the states that it prefers itself           (`_settled`)
        the unknown alone, and beside one effect or two                       (`_with_unknown`)

A set of k candidates has the prior P(k) / C(n_effects, k) * product of their shares (`octmip.gap.odds`). Sets with a
member that the others already imitate are the same explanation twice and are left out. What one hypothesis weighs under
several noises and levels adds up; it is shown in the one that bears it most.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb, inf, log

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.inference.candidates import explain_together, sizes_by_test
from octmip.gap.inference.evidence import Members, extensions
from octmip.gap.inference.inference import Inference, Judged
from octmip.gap.inference.inputs import Inputs, levels_without_run
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.own_sizes import about
from octmip.gap.inference.states import STATE_RESOLUTION, distance, starting_states
from octmip.gap.inference.unknown import weigh_unknown

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

OF_DAMAGE = {1.0: 0.6, 2.0: 0.3, 4.0: 0.1}
"""With a run, the levels of what damage changes. None is below 1: a gauge at which damage acts by a third more than
elsewhere has no fault."""
N_TRIED = 60
"""Best single candidates under the first noise, beside which every other noise and level is weighed."""
N_PAIRED = 3
"""Best single candidates beside which others are tried where noises are compared."""
VARIANT_BEHIND, MOST_LEVELS = 4.0, 2
"""Log units behind the best level beyond which another is not looked at; levels that are looked at for each noise."""
N_HEADS = (20, 8)
"""Sets of one and of two candidates that are extended."""
N_LOOKED = 300
"""Candidates beside a set that are weighed under its errors, the best without these: each costs a column."""
N_LONGER, N_OF_ONE_NAME = 25, 4
"""Larger sets that are kept of each size; sets of the same effects that are extended, so that places do not fill it."""
TRIPLES = 2.0
"""Log units that the best pair must weigh beyond the best single for triples to be looked at."""
UNSEEN = 0.1
"""Standard deviations that an effect must be able to move all readings together; others are no explanation."""
IMITATED = 0.02
"""A candidate is imitated by others when they leave less than this share of its squared length."""
N_EXACT, EXACT_BEHIND = 25, 15.0
"""Hypotheses whose evidence is computed exactly, at most, and the log units behind the best within which they lie."""
CONTENDING = 12.0
"""Log units behind the best within which a hypothesis may still lead about other states or under another noise."""
N_SETTLED, LEADERS, LAPS = 2, 10.0, 3
"""Sets about whose own states the model is taken in each lap, log units behind the best of these, and laps."""
START_BEHIND = 15.0
"""Log units behind the first starting state beyond which another one is not looked at."""
WEIGHTLESS = 35.0
"""Log units behind the best beyond which a hypothesis is not kept: it holds less than 1e-15."""
N_BESIDE_UNKNOWN = 10
"""Best pairs that are weighed with the unknown beside them."""
FAR, NEAR = STATE_RESOLUTION / 2, STATE_RESOLUTION / 5
"""Distance of states beyond which a set is judged about its own, and below which two models are one."""


def log_count(inputs: Inputs, k: int) -> float:
    """Return the log prior probability of each set of k effects; -inf for more than the odds know of."""
    if k >= len(inputs.odds.count):
        return -inf
    return _log(inputs.odds.count[k]) - log(max(comb(inputs.priors.n_effects, k), 1))


def log_prior(inputs: Inputs, members: Members) -> float:
    """Return the log prior probability of a set of candidates; -inf of those that are no explanation together."""
    if not explain_together([inputs.candidates[j] for j in members]):
        return -inf
    return log_count(inputs, len(members)) + float(inputs.priors.log_weight[list(members)].sum())


def weighed_hypotheses(inputs: Inputs, states: Sequence[Floats]) -> list[Judged]:
    """Return the hypotheses about inputs, under every noise and level that the readings bear.

    Parameters
    ----------
    states
        assignments (n_cells, n_parameters) to start from, the best first.
    """
    variants = _variants(about(inputs, states[0]))
    lead, first = variants[0]
    inferences = [Inference(first)]
    for assignment in states[1:]:
        model = about(first.inputs, assignment, first.level)
        if _best_single(model) > _best_single(inferences[0].model) - START_BEHIND:
            inferences.append(Inference(model))
    found: dict[Members, float] = {}
    for one in inferences:
        found |= {m: max(w, found.get(m, -inf)) for m, w in likely_sets(one).items()}
    ordered = sorted(found, key=lambda members: -found[members])
    exact = _with_parts([m for m in ordered[:N_EXACT] if found[m] > found[ordered[0]] - EXACT_BEHIND])
    inferences, weighed = _settled(inferences, exact)
    result = [w.times(lead) for w in [*weighed, *_others(inferences[0], found, exact), *_with_unknown(weighed)]]
    for log_share, model in variants[1:]:
        own = _under(model, _contenders(weighed))
        result += [w.times(log_share) for w in [*own, *_with_unknown(own)]]
    return _unexplained(result)


def _unexplained(weighed: Sequence[Judged]) -> list[Judged]:
    """Return the hypotheses; what takes a course without a name and something else is not explained, but unknown."""
    plain = max((w for w in weighed if w.has_unknown and not w.members), key=lambda w: w.log_weight)
    is_named = [
        len(w.members) < 2 or not any(w.model.inputs.candidates[j].is_nameless for j in w.members) for w in weighed
    ]
    return [w if named else replace(plain, log_weight=w.log_weight) for w, named in zip(weighed, is_named, strict=True)]


def _contenders(weighed: Sequence[Judged]) -> list[Judged]:
    """Return the hypotheses that may still lead about other states or under another noise, and that nothing acts."""
    best = max(w.log_weight for w in weighed)
    return [w for w in weighed if w.log_weight > best - CONTENDING or not w.members]


def _under(model: LinearModel, weighed: Sequence[Judged]) -> list[Judged]:
    """Return hypotheses weighed under the level and the noise of another model, each about the states that it has."""
    found = []
    for one in dict.fromkeys(w.inference for w in weighed):
        there = Inference(one.model.under(model.level, model.inputs.noise_of_means))
        found += _weigh([there], [w.members for w in weighed if w.inference is one])
    return found


def _variants(start: LinearModel) -> list[tuple[float, LinearModel]]:
    """Return the models worth a look with the log prior probability of their noise and level, the best first.

    That nothing wanders is always looked at, a walk where it bears the readings better. They are compared beside the
    best set of two at most: beside the best single effect a great noise would take the second.
    """
    best = _best(extensions(start, ())[0] + start.inputs.priors.log_weight, N_TRIED)

    def weighed(log_share: float, model: LinearModel) -> tuple[float, float, LinearModel]:
        return log_share + _best_set(model, best), log_share, model

    first, *others = start.inputs.noises
    noises = [weighed(first.log_share, start), *(weighed(one.log_share, start.under(1.0, one)) for one in others)]
    noises.sort(key=lambda one: -one[0])
    wanders = [one[2].inputs.noise.walk_sd > 0.0 for one in noises]
    still = [one for one, is_walk in zip(noises, wanders, strict=True) if not is_walk][:1]
    least = still[0][0] if still else -inf
    walks = [one for one, is_walk in zip(noises, wanders, strict=True) if is_walk and one[0] >= least]
    found = []
    for _, log_share, model in [*still, *walks[:1]]:
        at = [(model if level == 1.0 else model.under(level), log(p)) for level, p in _levels(start).items()]
        own = sorted((weighed(log_share + log_p, one) for one, log_p in at), key=lambda one: -one[0])
        found += [one for one in own if one[0] > own[0][0] - VARIANT_BEHIND][:MOST_LEVELS]
    return [(log_share, model) for _, log_share, model in sorted(found, key=lambda one: -one[0])]


def _levels(model: LinearModel) -> Mapping[float, float]:
    """Return the levels that are open: where nothing is damaged, a run of the sound asset leaves none."""
    if model.inputs.run is None:
        return levels_without_run(model.inputs)
    return OF_DAMAGE if model.rows.change.any() else {1.0: 1.0}


def _best_single(model: LinearModel) -> float:
    singles = extensions(model, ())[0] + model.inputs.priors.log_weight + log_count(model.inputs, 1)
    return model.log_none + max(log_count(model.inputs, 0), float(singles.max(initial=-inf)))


def _best_set(model: LinearModel, among: Ints) -> float:
    """Return the log of prior times evidence of the best set of none, one or two candidates among some."""
    inputs, share = model.inputs, model.inputs.priors.log_weight
    singles = extensions(model, (), among)[0] + share + log_count(inputs, 1)
    logs = [log_count(inputs, 0), float(singles.max(initial=-inf))]
    for j in _best(singles, N_PAIRED).tolist():
        pairs, new = extensions(model, (j,), among)
        own = pairs + share + share[j] + log_count(inputs, 2)
        logs.append(float(own[new > IMITATED].max(initial=-inf)))
    return model.log_none + max(logs)


def likely_sets(inference: Inference) -> dict[Members, float]:
    """Return no effect, every single candidate and the best larger sets, with approximate weights."""
    inputs = inference.model.inputs
    most = len(inputs.odds.count) - 1
    found: dict[Members, float] = {(): log_prior(inputs, ())}
    heads: list[Members] = [()]
    best = -inf
    for size in range(1, most + 1):
        longer: dict[Members, float] = {}
        inference.fits(heads)
        for members in heads:
            longer |= _extended(inference, members)
        ordered = sorted(longer.items(), key=lambda item: -item[1])
        found |= dict(ordered if size == 1 else ordered[:N_LONGER])
        if not ordered or (size > 1 and ordered[0][1] < best + TRIPLES) or size == most:
            break
        best = ordered[0][1]
        heads = _diverse(inputs, [members for members, _ in ordered], N_HEADS[size - 1])
    for members in sizes_by_test(inputs.candidates):
        found[members] = inference.fit(members).log_factor + log_prior(inputs, members)
    return found


def _extended(inference: Inference, members: Members) -> dict[Members, float]:
    """Return the sets of one more candidate with their weights, each judged under the errors of `members`."""
    model = inference.model
    inputs, prior = model.inputs, model.inputs.priors
    under = inference.allowing(members).model
    logs, new = extensions(model, members)
    if under is not model:
        logs, new = extensions(under, members, _best(logs + prior.log_weight, N_LOOKED))
    can_be_seen = 3.0 * np.hypot(prior.mean, prior.sd) * np.sqrt(model.lengths) > UNSEEN
    keep = np.flatnonzero(np.isfinite(logs) & can_be_seen & ((new > IMITATED) | (not members)))
    if members:
        keep = keep[_best((logs + prior.log_weight)[keep], N_LONGER)]
    if any(inputs.candidates[j].is_nameless for j in members):  # two such are no explanation (`log_prior`)
        keep = np.array([j for j in keep.tolist() if not inputs.candidates[j].is_nameless], dtype=np.int64)
    weights = logs[keep] + prior.log_weight[keep] + log_prior(inputs, members) + under.log_none - model.log_none
    weights += log_count(inputs, len(members) + 1) - log_count(inputs, len(members))
    joined = [tuple(sorted((*members, j))) for j in keep.tolist()]
    return dict(zip(joined, weights.tolist(), strict=True))


def _best(weights: Floats, most: int) -> Ints:
    """Return the indices (most,) of the greatest weights (n,), the greatest first."""
    return np.argsort(-weights, kind="stable")[:most]


def _diverse(inputs: Inputs, ordered: Sequence[Members], most: int) -> list[Members]:
    """Return the first sets, at most a few of the same effects."""
    taken: dict[tuple[int, ...], int] = {}
    name, kept = inputs.priors.name.tolist(), list[Members]()
    for members in ordered:
        names = tuple(sorted(name[j] for j in members))
        taken[names] = taken.get(names, 0) + 1
        kept += [members] if taken[names] <= N_OF_ONE_NAME else []
        if len(kept) == most:
            break
    return kept


def _with_parts(sets: list[Members]) -> list[Members]:
    """Return the sets, and what is left of them when members are taken out: never unjudged."""
    parts = {part for members in sets for k in range(len(members)) for part in combinations(members, k)}
    return [*sets, *sorted(parts - set(sets))]


def _settled(inferences: list[Inference], sets: list[Members]) -> tuple[list[Inference], list[Judged]]:
    """Return inferences about all states, and all sets weighed, the leaders about the states that they prefer."""
    weighed = _weigh(inferences, sets)
    for _ in range(LAPS if inferences[0].model.inputs.groups else 0):
        best = max(w.log_weight for w in weighed)
        leaders = sorted((w for w in weighed if w.log_weight > best - LEADERS), key=lambda w: -w.log_weight)
        new: list[Floats] = []
        for w in leaders:
            states = w.inference.moved(w.members)
            known = [*(one.model.states for one in inferences), *new]
            if distance(states, w.inference.model.states) > FAR and all(distance(states, s) > NEAR for s in known):
                new.append(states)
            if len(new) == N_SETTLED:
                break
        if not new:
            break
        like = inferences[0].model
        inferences = [*inferences, *(Inference(about(like.inputs, states, like.level)) for states in new)]
        again = _weigh(inferences, [w.members for w in _contenders(weighed)])
        weighed = [*{w.members: w for w in [*weighed, *again]}.values()]
    return inferences, weighed


def _weigh(inferences: Sequence[Inference], sets: list[Members]) -> list[Judged]:
    """Return prior times evidence of sets, each in the inference nearest to its own states."""
    for inference in inferences:
        inference.fits(sets)
    return [_exact(inferences, members) for members in sets]


def _exact(inferences: Sequence[Inference], members: Members) -> Judged:
    tried = [(*inference.stand(members), inference) for inference in inferences]
    near = [t for t in tried if t[0] < FAR] or [min(tried, key=lambda t: t[0])]
    _, value, nearest = max(near, key=lambda t: t[1])
    return Judged(members, False, value + log_prior(nearest.model.inputs, members), nearest)


def _others(first: Inference, found: dict[Members, float], done: Sequence[Members]) -> list[Judged]:
    """Return the hypotheses that were not judged exactly as they are, where all states are known."""
    if first.model.inputs.groups:
        return []
    least = max(found.values()) - WEIGHTLESS
    left = {members for members, weight in found.items() if weight > least} - set(done)
    return [Judged(members, False, first.model.log_none + found[members], first) for members in sorted(left)]


def _with_unknown(weighed: Sequence[Judged]) -> list[Judged]:
    """Return the unknown alone, beside every single effect and beside the best larger sets."""
    best = max(weighed, key=lambda w: w.log_weight).inference
    model, unknown = best.model, weigh_unknown(best.model)
    inputs, odds, allowing = model.inputs, model.inputs.odds.unknown, Inference(unknown.allowing)
    box = best.log_box(())
    found = [Judged((), True, model.log_none + unknown.log_factor + box + _log(odds[0]), allowing, unknown.words)]
    beside = allowing.model.log_none + box - unknown.log_kinds
    logs = beside + extensions(allowing.model, ())[0] + inputs.priors.log_weight
    logs += _log(odds[1]) - log(max(inputs.priors.n_effects, 1))
    worth = np.flatnonzero(logs > max(found[0].log_weight, max(w.log_weight for w in weighed)) - WEIGHTLESS)
    found += [Judged((j,), True, float(logs[j]), allowing, unknown.words) for j in worth.tolist()]
    larger = [w.members for w in sorted(_contenders(weighed), key=lambda w: -w.log_weight) if len(w.members) == 2]
    for members, own in zip(larger[:N_BESIDE_UNKNOWN], allowing.fits(larger[:N_BESIDE_UNKNOWN]), strict=True):
        prior = log_prior(inputs, members) - _log(inputs.odds.count[2]) + _log(odds[2])
        found.append(Judged(members, True, beside + own.log_factor + prior, allowing, unknown.words))
    return found


def _log(probability: float) -> float:
    return log(max(probability, 1e-300))


NEGLIGIBLE = 1e-7
"""Probability below which an effect beside the unknown is not kept."""


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """All hypotheses, most probable first.

    Attributes
    ----------
    judged
        ordered hypotheses; probabilities sum to 1.
    inference
        the main one: of the most probable hypothesis without the unknown, under the noise of the leading one.
    log_total
        log of the sum of prior times evidence.
    """

    judged: tuple[Judged, ...]
    inference: Inference
    log_total: float

    @property
    def model(self) -> LinearModel:
        """The main linear model."""
        return self.inference.model

    @property
    def unknown_probability(self) -> float:
        """Probability that something outside the library acts."""
        return float(sum(h.probability for h in self.judged if h.has_unknown))

    @property
    def unknown_words(self) -> str:
        """What the unknown looks like where it is most probable."""
        return next((h.words for h in self.judged if h.has_unknown), "")

    def inclusion(self) -> dict[str, float]:
        """Return the probability of every effect to be among the causes."""
        found = {candidate.name: 0.0 for candidate in self.model.inputs.candidates}
        for h in self.judged:
            for name in h.effects:
                found[name] += h.probability
        return dict(sorted(found.items(), key=lambda item: -item[1]))


def fit_together(hypotheses: Sequence[Judged]) -> None:
    """Make the fits of hypotheses, which their inferences keep: one by one they cost several times as much."""
    for inference in {id(h.inference): h.inference for h in hypotheses}.values():
        inference.fits([h.members for h in hypotheses if h.inference is inference])


def attribute(inputs: Inputs) -> Posterior:
    """Return the posterior over sets of effects."""
    weighed = weighed_hypotheses(inputs, starting_states(inputs))
    by_key: dict[tuple[Members, bool], list[Judged]] = {}
    for w in weighed:
        by_key.setdefault((w.members, w.has_unknown), []).append(w)
    total = float(logsumexp([w.log_weight for w in weighed]))
    every = (_judged(same, total) for same in by_key.values())
    judged = [h for h in every if h.probability > NEGLIGIBLE or not (h.has_unknown and h.members)]
    judged.sort(key=lambda h: -h.probability)
    best: dict[int, Judged] = {}  # by inference: a walk is asked of each once
    for w in (w for w in weighed if not w.has_unknown):
        if id(w.inference) not in best or w.log_weight > best[id(w.inference)].log_weight:
            best[id(w.inference)] = w
    walk = judged[0].model.inputs.noise.walk_sd
    alike = [w for w in best.values() if w.model.inputs.noise.walk_sd == walk] or best.values()
    return Posterior(tuple(judged), max(alike, key=lambda w: w.log_weight).inference, total)


def _judged(same: Sequence[Judged], total: float) -> Judged:
    """Return what one hypothesis weighs under all variants, in the one that bears it most."""
    best = max(same, key=lambda w: w.log_weight)
    return best.times(0.0, sum(math.exp(w.log_weight - total) for w in same))
