"""The search for hypotheses under one variant of the inputs: found by a beam, settled in their own states, weighed.

With unknown states every leading hypothesis is judged in a model that is linear about the states that it prefers
itself: a set that is right can look absurd about the states of another one. Sets are found about each starting state;
the best of every name are settled; then whatever still leads from afar is settled too, until nothing does.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.inference.evidence import Members, extensions
from octmip.gap.inference.hypotheses import Hypothesis, likely_sets, log_count, log_prior
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import Inputs, Variant
from octmip.gap.inference.linear_model import LinearModel, at_level, linearise, log_none_at, tail_of
from octmip.gap.inference.signature_error import with_errors
from octmip.gap.inference.states import STATE_RESOLUTION, distance, log_box, moved_states
from octmip.gap.inference.unknown import weigh_unknown
from octmip.gap.progress import Stage

Floats = NDArray[np.float64]

EXACT = 100
"""Hypotheses whose evidence is computed exactly and, with open states, about their own states."""
WHOLE = 30
"""Best sets whose subsets are judged as well: an idle member must be able to leave."""
POLISHED = 10
"""Distinct hypotheses about whose own states the model is linearised before any is weighed."""
OF_ONE_NAME = 2
"""Of them, those of the same effects."""
LEADERS = 15.0
"""Log units behind the best within which a hypothesis must be judged about its own states."""
LAPS = 3
"""Times that the leaders are settled again."""
BEHIND = 20
"""Log units behind the first starting state beyond which another one is not looked at."""
LEVEL_BEHIND = 4.0
"""Log units behind the best level of differences beyond which another level is not looked at."""
MOST_LEVELS = 3
"""Levels that are looked at."""
WITH_WIDE = 2
"""Of them, those that are looked at with wide gauges too."""
MOST_WIDE = 2
"""Wide gauges at once."""
MOST_DIFFERENCES = 5
"""Levels, with wide gauges and without, that are looked at."""
FAINT = 0.3
"""Standard deviations that a wide gauge must be able to move a reading; others make no difference."""
MOST_MEMORIES = 2
"""Sizes of the memory of readings that do not wander that are looked at."""
MOST_WALKS = 2
"""Sizes of a walk of the readings that are looked at."""
WITH_UNKNOWN = 30
"""Best sets that are weighed with the unknown beside them."""
FAR = STATE_RESOLUTION / 2
"""Distance of states beyond which a set must be judged about its own."""


@dataclass(frozen=True, slots=True, eq=False)
class Weighed:
    """A hypothesis, the log of prior times evidence, the inference in which it was judged, words for the unknown."""

    members: Members
    has_unknown: bool
    log_weight: float
    inference: Inference
    words: str = ""

    @property
    def level(self) -> float:
        """Level of differences between models at which it was judged."""
        return self.inference.model.inputs.discrepancy.level

    def times(self, log_factor: float) -> "Weighed":
        """Return the hypothesis with its weight multiplied."""
        return Weighed(self.members, self.has_unknown, self.log_weight + log_factor, self.inference, self.words)


@dataclass(frozen=True, slots=True)
class Difference:
    """How far two models differ: a level, wide gauges, and the log of their probability."""

    level: float
    wide: tuple[int, ...]
    log_share: float


def weighed_hypotheses(inputs: Inputs, states: Sequence[Floats], *, is_quick: bool = False) -> list[Weighed]:
    """Return the hypotheses about inputs, for every walk and every difference between models that the readings bear.

    Parameters
    ----------
    states
        assignments (n_cells, n_parameters) to start from, the best first.
    is_quick
        whether to look at the best walk and difference only.
    """
    found = []
    for variant in _variants(inputs, states[0])[: 1 if is_quick else None]:
        own = _under(inputs.under(variant), states, is_quick=is_quick)
        found += [w.times(variant.log_share) for w in own]
    return found


def _under(inputs: Inputs, states: Sequence[Floats], *, is_quick: bool) -> list[Weighed]:
    """Return the hypotheses under one size of the walk."""
    differences = _differences(inputs, states[0])[: 1 if is_quick else None]
    first = differences[0]
    at = replace(inputs, discrepancy=inputs.discrepancy.at(first.level, first.wide))
    started = [Inference(linearise(at, assignment)) for assignment in states]
    enough = _best_single(started[0]) - BEHIND
    inferences = [started[0], *(one for one in started[1:] if _best_single(one) > enough)]
    by_start = [sorted(likely_sets(one), key=lambda h: -h.log_weight) for one in inferences]
    found = {h.members: h for hypotheses in by_start for h in hypotheses}
    if inputs.groups:
        inferences = _polished(inferences, [[h.members for h in hypotheses] for hypotheses in by_start])
    inputs.progress(Stage("weighing the best hypotheses exactly"))
    ordered = sorted(found.values(), key=lambda h: -h.log_weight)
    sets = _with_parts([h.members for h in ordered[:EXACT]])
    weighed = _settled_leaders(inferences, sets)
    everything = [*weighed, *_others(weighed, ordered, sets), *_with_unknown(weighed)]
    result = [w.times(first.log_share) for w in everything]
    for other in differences[1:]:
        own = _weighed_under(other, weighed)
        result += [w.times(other.log_share) for w in (*own, *_with_unknown(own))]
    return result


def _weighed_under(difference: Difference, weighed: Sequence[Weighed]) -> list[Weighed]:
    """Return hypotheses weighed under another difference, each about the states about which it was weighed."""
    found = []
    for one in {id(w.inference): w.inference for w in weighed}.values():
        again = Inference(at_level(one.model, difference.level, difference.wide))
        found += _weigh([again], [w.members for w in weighed if w.inference is one])
    return found


def _variants(inputs: Inputs, states: Floats) -> list[Variant]:
    """Return the sizes of the walk that are worth a look, the best first.

    That nothing wanders always is; a walk is where it explains the readings better with the best single effect beside
    it, so that no more is weighed where there is no sign of one.
    """
    if len(inputs.variants) == 1:
        return list(inputs.variants)
    models = [linearise(inputs.under(variant), states) for variant in inputs.variants]
    logs = [max(value for value, _ in _by_level(model)) for model in models]
    found = [(log + variant.log_share, variant) for log, variant in zip(logs, inputs.variants, strict=True)]
    found.sort(key=lambda item: -item[0])
    still = [item for item in found if not item[1].wanders][:MOST_MEMORIES]
    least = max([value for value, _ in still[:1]] + [found[0][0] - LEVEL_BEHIND])
    still = [item for item in still if item[0] > still[0][0] - LEVEL_BEHIND]
    walks = [item for item in found if item[1].wanders and item[0] >= least][:MOST_WALKS]
    return [variant for _, variant in sorted([*still, *walks], key=lambda item: -item[0])]


def _differences(inputs: Inputs, states: Floats) -> list[Difference]:
    """Return each difference between models that is worth a look, the best first."""
    model = linearise(inputs, states)
    found = _by_level(model)
    levels = sorted(found, key=lambda item: -item[0])[:MOST_LEVELS]
    for value, difference in levels[:WITH_WIDE]:
        found += _with_wide(model, value, difference)
    found.sort(key=lambda item: -item[0])
    return [d for value, d in found[:MOST_DIFFERENCES] if value > found[0][0] - LEVEL_BEHIND]


def _by_level(model: LinearModel) -> list[tuple[float, Difference]]:
    """Return every level with what the best single candidate, or none, weighs there."""
    levels = model.inputs.discrepancy.log_levels
    differences = [Difference(level, (), log_share) for level, log_share in levels]
    return [(_value(at_level(model, d.level)) + d.log_share, d) for d in differences]


def _with_wide(model: LinearModel, value: float, start: Difference) -> list[tuple[float, Difference]]:
    """Return a difference with the gauges made wide, one after the other, that raise what it weighs most."""
    found: list[tuple[float, Difference]] = []
    difference, at = start, at_level(model, start.level)
    share = model.inputs.discrepancy.usual.wide_share
    log_wide = float(np.log(share / (1.0 - share)))
    for _ in range(MOST_WIDE):
        roots = {g: tail_of(at, g) for g in range(len(model.inputs.order)) if g not in difference.wide}
        tried = {g: _value(with_errors(at, root)) for g, root in roots.items() if np.abs(root).max(initial=0.0) > FAINT}
        if not tried:
            break
        g = max(tried, key=lambda g: tried[g])
        difference = Difference(start.level, (*difference.wide, g), difference.log_share + log_wide)
        own = tried[g] + difference.log_share
        if own < value - LEVEL_BEHIND:
            break
        found.append((own, difference))
        value, at = max(value, own), at_level(model, difference.level, difference.wide)
    return found


def _value(model: LinearModel) -> float:
    """Return the log of the greatest prior times evidence among none and the single candidates."""
    singles = extensions(model, ()) + model.inputs.priors.log_weight + log_count(model.inputs, 1)
    return model.log_none + max(log_count(model.inputs, 0), float(singles.max(initial=-np.inf)))


def promise(inputs: Inputs, states: Floats) -> float:
    """Return the log evidence of none or the best single candidate, about some states, at the best walk and level."""
    found = []
    for variant in inputs.variants:
        model = linearise(inputs.under(variant), states)
        levels = variant.discrepancy.log_levels
        found += [_best_single(Inference(at_level(model, at))) + share + variant.log_share for at, share in levels]
    return max(found)


def nothing_else(inputs: Inputs, states: Floats) -> Weighed:
    """Return what it weighs that no effect acts, about some states, under the walk and level that bear it best."""
    tried = []
    for variant in inputs.variants:
        model = linearise(inputs.under(variant), states)
        for level, log_share in variant.discrepancy.log_levels:
            shared = log_share + variant.log_share
            tried.append((log_none_at(model, level) + shared, shared, model, level))
    _, log_share, model, level = max(tried, key=lambda item: item[0])
    at = at_level(model, level)
    own = Inference(at)
    box = log_box(at, own.fit(()))
    return Weighed((), False, at.log_none + log_share + box + log_prior(inputs, ()), own)


def _best_single(inference: Inference) -> float:
    """Return the log evidence of the best single candidate, or of none."""
    return inference.model.log_none + float(max(0.0, extensions(inference.model, ()).max(initial=0.0)))


def _polished(started: list[Inference], by_start: Sequence[Sequence[Members]]) -> list[Inference]:
    """Return inferences about the states that the best hypotheses of every start prefer, the best starts first."""
    kept: list[Inference] = []
    for start, sets in zip(started, by_start, strict=True):
        most = len(kept) + max(2, POLISHED // len(started))
        for members in _of_different_names(start, sets):
            if len(kept) >= most:
                break
            found = _settled(start, members, kept)
            if not any(_is_near(found, one) for one in kept):
                kept.append(found)
    return kept


def _of_different_names(start: Inference, sets: Sequence[Members]) -> Iterable[Members]:
    """Return the first sets of each combination of effects, `OF_ONE_NAME` of each."""
    name, taken = start.model.inputs.priors.name, dict[tuple[int, ...], int]()
    for members in sets[: 4 * POLISHED]:
        names = tuple(sorted(name[list(members)].tolist()))
        taken[names] = taken.get(names, 0) + 1
        if taken[names] <= OF_ONE_NAME:
            yield members


def _is_near(one: Inference, other: Inference) -> bool:
    return distance(one.model.states, other.model.states) < STATE_RESOLUTION / 5


def _settled(start: Inference, members: Members, kept: Sequence[Inference]) -> Inference:
    """Return the inference about the states that a set prefers: three steps at most, one that is kept where near."""
    found = start
    for _ in range(3):
        states = moved_states(found.model, found.fit(members))
        if distance(states, found.model.states) < STATE_RESOLUTION / 10:
            break
        near = [one for one in kept if distance(states, one.model.states) < STATE_RESOLUTION / 5]
        found = near[0] if near else Inference(linearise(found.model.inputs, states))
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
        tried.append((_away(inference, members), value + log_prior(model.inputs, members), inference))
    near = [t for t in tried if t[0] < FAR] or [min(tried, key=lambda t: t[0])]
    _, value, nearest = max(near, key=lambda t: t[1])
    return Weighed(members, False, value, nearest)


def _away(inference: Inference, members: Members) -> float:
    """Return how far the states that a set prefers lie from those of the inference."""
    model = inference.model
    if not model.inputs.groups:
        return 0.0
    return distance(moved_states(model, inference.judge([members])[0].fit), model.states)


def _with_parts(sets: list[Members]) -> list[Members]:
    """Return the sets, and what is left of the first `WHOLE` of them when members are taken out: never unjudged."""
    parts = {part for members in sets[:WHOLE] for k in range(len(members)) for part in combinations(members, k)}
    return [*sets, *sorted(parts - set(sets))]


def _others(weighed: Sequence[Weighed], ordered: Sequence[Hypothesis], sets: Sequence[Members]) -> list[Weighed]:
    """Return the hypotheses that were not judged exactly as they are, where all states are known."""
    only, done = weighed[0].inference, set(sets)
    if only.model.inputs.groups:
        return []
    left = [h for h in ordered if h.members not in done]
    return [Weighed(h.members, False, h.log_weight + only.model.log_none, only) for h in left]


def _with_unknown(weighed: Sequence[Weighed]) -> list[Weighed]:
    """Return the unknown alone, beside every single effect and beside the best larger sets."""
    best = max(weighed, key=lambda w: w.log_weight).inference
    model, unknown = best.model, weigh_unknown(best.model)
    inputs, conditioned = model.inputs, unknown.allowing.model
    odds = inputs.odds.unknown
    box = log_box(model, best.fit(()))
    alone = model.log_none + unknown.log_factor + box + _log(odds[0])
    found = [Weighed((), True, alone, unknown.allowing, unknown.words)]
    beside = conditioned.log_none + box - unknown.log_kinds
    logs = beside + extensions(conditioned, ()) + _log(odds[1]) - np.log(max(inputs.priors.n_effects, 1))
    logs += inputs.priors.log_weight
    found += [Weighed((j,), True, float(log), unknown.allowing, unknown.words) for j, log in enumerate(logs)]
    larger = [w.members for w in sorted(weighed, key=lambda w: -w.log_weight) if len(w.members) == 2][:WITH_UNKNOWN]
    for members, own in zip(larger, unknown.allowing.fits(larger), strict=True):
        prior = log_prior(inputs, members) - _log(inputs.odds.count[2]) + _log(odds[2])
        found.append(Weighed(members, True, beside + own.log_factor + prior, unknown.allowing, unknown.words))
    return found


def _log(probability: float) -> float:
    return float(np.log(max(probability, 1e-300)))


def log_total(weighed: Sequence[Weighed]) -> float:
    """Return the log of the sum of all weights."""
    return float(logsumexp([w.log_weight for w in weighed]))
