"""The search for hypotheses about inputs: sets of effects, the unknown, and their prior times evidence.

Every hypothesis is weighed at each level of the difference of twin and asset that the readings bear. With unknown
states it is judged in a model that is linear about the states that it prefers itself: a set that is right can look
absurd about the states of another one. Sets are found about each starting state and settled about their own; then
whatever still leads from afar is settled too, until nothing does.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.campaign.noise import Noise
from octmip.gap.inference.evidence import Members, extensions
from octmip.gap.inference.hypotheses import likely_sets, log_count, log_prior
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel, at_level, linearise, with_columns
from octmip.gap.inference.signatures import exact_change, ratios
from octmip.gap.inference.states import STATE_RESOLUTION, distance, log_box, moved_states
from octmip.gap.inference.unknown import weigh_unknown
from octmip.gap.progress import Stage

Floats = NDArray[np.float64]

LEVELS = {0.5: 0.2, 1.0: 0.45, 2.0: 0.25, 4.0: 0.1}
"""Levels of the difference with their probabilities before any reading."""
LEVEL_BEHIND = 4.0
"""Log units behind the best level beyond which another is not looked at."""
MOST_LEVELS = 2
"""Levels that are looked at."""
EXACT = 60
"""Hypotheses whose evidence is computed exactly and, with open states, about their own states."""
POLISHED = 6
"""Distinct hypotheses about whose own states the model is linearised before any is weighed."""
LEADERS = 10.0
"""Log units behind the best within which a hypothesis must be judged about its own states."""
LAPS = 2
"""Times that the leaders are settled again."""
BEHIND = 15.0
"""Log units behind the first starting state beyond which another one is not looked at."""
WITH_UNKNOWN = 10
"""Best pairs that are weighed with the unknown beside them."""
SECANTS, BENT = 2, 12
"""Times that signatures of effects that are not linear are taken again, and the best sets whose sizes are used."""
FAINT, LINEAR = 0.05, 0.01
"""Prior standard deviations of a size below which its effect is linear, and what a signature may bend by unnoticed."""
FAR = STATE_RESOLUTION / 2
"""Distance of states beyond which a set must be judged about its own."""
NEAR = STATE_RESOLUTION / 5
"""Distance of states below which two models are one."""


@dataclass(frozen=True, slots=True, eq=False)
class Weighed:
    """A hypothesis, the log of prior times evidence, the inference in which it was judged, words for the unknown."""

    members: Members
    has_unknown: bool
    log_weight: float
    inference: Inference
    words: str = ""

    def times(self, log_factor: float) -> "Weighed":
        """Return the hypothesis with its weight multiplied."""
        return replace(self, log_weight=self.log_weight + log_factor)


def weighed_hypotheses(inputs: Inputs, states: Sequence[Floats], *, is_quick: bool = False) -> list[Weighed]:
    """Return the hypotheses about inputs, under every noise and level that the readings bear.

    Parameters
    ----------
    states
        assignments (n_cells, n_parameters) to start from, the best first.
    is_quick
        whether to look at the best noise and level only.
    """
    found = []
    for noise, log_share in _noises(inputs, states[0])[: 1 if is_quick else None]:
        own = _under(replace(inputs, noise=noise), states, is_quick=is_quick)
        found += [w.times(log_share) for w in own]
    return found


def _noises(inputs: Inputs, states: Floats) -> list[tuple[Noise, float]]:
    """Return the noises that are worth a look: that nothing wanders always is, a walk where it explains more.

    Both with the best single effect beside them, so that no more is weighed where there is no sign of a walk.
    """
    if len(inputs.noises) < 2:
        return list(inputs.noises) or [(inputs.noise, 0.0)]
    found = []
    for noise, share in inputs.noises:
        found.append((_best_single(linearise(replace(inputs, noise=noise), states)) + share, noise, share))
    found.sort(key=lambda item: -item[0])
    still = [item for item in found if not item[1].walk_sd > 0.0][:1]
    least = still[0][0] if still else -np.inf
    walks = [item for item in found if item[1].walk_sd > 0.0 and item[0] >= least][:1]
    return [(noise, share) for _, noise, share in sorted([*still, *walks], key=lambda item: -item[0])]


def _under(inputs: Inputs, states: Sequence[Floats], *, is_quick: bool) -> list[Weighed]:
    """Return the hypotheses under one noise, at every level that the readings bear."""
    levels = _levels(inputs, states[0])
    levels = levels[:1] if is_quick else [p for p in levels if p[0] > levels[0][0] - LEVEL_BEHIND][:MOST_LEVELS]
    inferences = [Inference(levels[0][1])]
    for assignment in states[1:]:
        other = Inference(linearise(inputs, assignment, levels[0][1].level))
        if _best_single(other.model) > _best_single(inferences[0].model) - BEHIND:
            inferences.append(other)
    by_start = [likely_sets(one) for one in inferences]
    for _ in range(SECANTS if not inputs.groups else 0):
        bent = _with_secants(inferences[0], [h.members for h in by_start[0][:BENT]])
        if bent is inferences[0]:
            break
        inferences, by_start = [bent], [likely_sets(bent)]
    found = {h.members: h.log_weight for hypotheses in by_start for h in hypotheses}
    ordered = sorted(found, key=lambda members: -found[members])
    if inputs.groups:
        inferences = _polished(inferences, [[h.members for h in hypotheses] for hypotheses in by_start])
    inputs.progress(Stage("weighing the best hypotheses exactly"))
    weighed = _settled_leaders(inferences, _with_parts(ordered[:EXACT]))
    result = [*weighed, *_others(inferences, found, weighed), *_with_unknown(weighed)]
    for _, model in levels[1:]:
        own = _at_another_level(weighed, model.level)
        result += [*own, *_with_unknown(own)]
    return result


def _with_secants(inference: Inference, sets: Sequence[Members]) -> Inference:
    """Return the inference with the signatures of effects that are not linear taken between none and the size found.

    Itself where no such effect is among the sets, or none bends.
    """
    model = inference.model
    expected = np.array(model.means.expected)
    expected[model.average, model.gauge] = model.predicted
    ratio = ratios(model.inputs, model.states, expected)
    columns: dict[int, Floats] = {}
    for fit in inference.fits(sets):
        for j, size in zip(fit.members, fit.size.tolist(), strict=True):
            candidate = model.inputs.candidates[j]
            if j not in columns and candidate.forward is not None and abs(size) > FAINT * candidate.effect.prior_sd:
                change = exact_change(model.inputs, model.states, candidate, size)
                columns[j] = (change * ratio)[model.average, model.gauge] / size
    if not columns:
        return inference
    index, new = list(columns), np.column_stack(list(columns.values()))
    if not np.isfinite(new).all() or np.allclose(new, model.signatures[:, index], rtol=LINEAR, atol=0.0):
        return inference
    return Inference(with_columns(model, index, new))


def promise(inputs: Inputs, states: Floats) -> float:
    """Return the greatest log of prior times evidence of none and the single candidates, about some states."""
    return _levels(inputs, states)[0][0]


def nothing_else(inputs: Inputs, states: Floats) -> Weighed:
    """Return what it weighs that no effect acts, about some states, at the level that bears it best."""
    models = [linearise(inputs, states, level) for level in LEVELS]
    best = max(models, key=lambda model: model.log_none + np.log(LEVELS[model.level]))
    return _exact([Inference(best)], ())


def _levels(inputs: Inputs, states: Floats) -> list[tuple[float, LinearModel]]:
    """Return the models at every level with the greatest weight of none and the single candidates, the best first."""
    first = linearise(inputs, states, 1.0)
    models = [first if level == 1.0 else at_level(first, level) for level in LEVELS]
    return sorted(((_best_single(model), model) for model in models), key=lambda pair: -pair[0])


def _best_single(model: LinearModel) -> float:
    singles = extensions(model, ())[0] + model.inputs.priors.log_weight + log_count(model.inputs, 1)
    best = max(log_count(model.inputs, 0), float(singles.max(initial=-np.inf)))
    return model.log_none + best + float(np.log(LEVELS[model.level]))


def _polished(started: list[Inference], by_start: Sequence[Sequence[Members]]) -> list[Inference]:
    """Return inferences about the states that the best hypotheses of every start prefer, the best starts first."""
    kept: list[Inference] = []
    for start, sets in zip(started, by_start, strict=True):
        most = len(kept) + max(2, POLISHED // len(started))
        for members in sets[: 4 * POLISHED]:
            if len(kept) >= most:
                break
            found = _settled(start, members, kept)
            if not any(_is_near(found, one) for one in kept):
                kept.append(found)
    return kept


def _is_near(one: Inference, other: Inference) -> bool:
    return distance(one.model.states, other.model.states) < NEAR


def _settled(start: Inference, members: Members, kept: Sequence[Inference]) -> Inference:
    """Return the inference about the states that a set prefers: two steps at most, one that is kept where near."""
    found = start
    for _ in range(2):
        states = moved_states(found.model, found.fit(members))
        if distance(states, found.model.states) < NEAR / 2:
            break
        near = [one for one in kept if distance(states, one.model.states) < NEAR]
        found = near[0] if near else Inference(linearise(found.model.inputs, states, found.model.level))
    return found


def _settled_leaders(inferences: list[Inference], sets: list[Members]) -> list[Weighed]:
    """Return all sets weighed, the leaders among them about their own states."""
    weighed = _weigh(inferences, sets)
    for _ in range(LAPS if inferences[0].model.inputs.groups else 0):
        best = max(w.log_weight for w in weighed)
        far = [w for w in weighed if w.log_weight > best - LEADERS and _away(w.inference, w.members) > FAR]
        new: list[Inference] = []
        for w in sorted(far, key=lambda w: -w.log_weight)[:POLISHED]:
            found = _settled(w.inference, w.members, [*inferences, *new])
            if not any(_is_near(found, one) for one in [*inferences, *new]):
                new.append(found)
        if not new:
            break
        inferences = [*inferences, *new]
        weighed = _weigh(inferences, sets)
    return weighed


def _weigh(inferences: Sequence[Inference], sets: list[Members]) -> list[Weighed]:
    for inference in inferences:  # all at once: one by one costs ten times as much
        inference.judge(sets)
    return [_exact(inferences, members) for members in sets]


def _exact(inferences: Sequence[Inference], members: Members) -> Weighed:
    """Return prior times evidence of a hypothesis in the inference nearest to its own states."""
    tried = []
    for inference in inferences:
        model, judgement = inference.model, inference.judge([members])[0]
        value = model.log_none + judgement.log_factor + log_box(model, judgement.fit)
        tried.append((_away(inference, members), value, inference))
    near = [t for t in tried if t[0] < FAR] or [min(tried, key=lambda t: t[0])]
    _, value, nearest = max(near, key=lambda t: t[1])
    return Weighed(members, False, _weight(nearest.model, value, log_prior(nearest.model.inputs, members)), nearest)


def _weight(model: LinearModel, log_evidence: float, log_prior_: float) -> float:
    """Return the log of prior times evidence."""
    return log_evidence + log_prior_ + float(np.log(LEVELS[model.level]))


def _away(inference: Inference, members: Members) -> float:
    """Return how far the states that a set prefers lie from those of the inference."""
    model = inference.model
    if not model.inputs.groups:
        return 0.0
    return distance(moved_states(model, inference.judge([members])[0].fit), model.states)


def _with_parts(sets: list[Members]) -> list[Members]:
    """Return the sets, and what is left of them when members are taken out: never unjudged."""
    parts = {part for members in sets for k in range(len(members)) for part in combinations(members, k)}
    return [*sets, *sorted(parts - set(sets))]


def _others(inferences: Sequence[Inference], found: dict[Members, float], weighed: Sequence[Weighed]) -> list[Weighed]:
    """Return the hypotheses that were not judged exactly as they are, where all states are known."""
    first, done = inferences[0], {w.members for w in weighed}
    model = first.model
    if model.inputs.groups:
        return []
    left = [(members, weight - log_prior(model.inputs, members)) for members, weight in found.items()]
    return [
        Weighed(members, False, _weight(model, model.log_none + factor, log_prior(model.inputs, members)), first)
        for members, factor in left
        if members not in done
    ]


def _at_another_level(weighed: Sequence[Weighed], level: float) -> list[Weighed]:
    """Return hypotheses weighed at another level, each about the states about which it was weighed."""
    found = []
    for one in {id(w.inference): w.inference for w in weighed}.values():
        again = Inference(at_level(one.model, level))
        found += _weigh([again], [w.members for w in weighed if w.inference is one])
    return found


def _with_unknown(weighed: Sequence[Weighed]) -> list[Weighed]:
    """Return the unknown alone, beside every single effect and beside the best larger sets."""
    best = max(weighed, key=lambda w: w.log_weight).inference
    model, unknown = best.model, weigh_unknown(best.model)
    inputs, conditioned = model.inputs, unknown.allowing.model
    odds = inputs.odds.unknown
    box = log_box(model, best.fit(()))
    alone = _weight(model, model.log_none + unknown.log_factor + box, _log(odds[0]))
    found = [Weighed((), True, alone, unknown.allowing, unknown.words)]
    beside = conditioned.log_none + box - unknown.log_kinds
    logs = beside + extensions(conditioned, ())[0]
    prior = _log(odds[1]) - float(np.log(max(inputs.priors.n_effects, 1)))
    for j, log in enumerate(logs.tolist()):
        weight = _weight(model, log, prior + float(inputs.priors.log_weight[j]))
        found.append(Weighed((j,), True, weight, unknown.allowing, unknown.words))
    larger = [w.members for w in sorted(weighed, key=lambda w: -w.log_weight) if len(w.members) == 2][:WITH_UNKNOWN]
    for members, own in zip(larger, unknown.allowing.fits(larger), strict=True):
        prior = log_prior(inputs, members) - _log(inputs.odds.count[2]) + _log(odds[2])
        weight = _weight(model, beside + own.log_factor, prior)
        found.append(Weighed(members, True, weight, unknown.allowing, unknown.words))
    return found


def _log(probability: float) -> float:
    return float(np.log(max(probability, 1e-300)))


def log_total(weighed: Sequence[Weighed]) -> float:
    """Return the log of the sum of all weights."""
    return float(logsumexp([w.log_weight for w in weighed]))
