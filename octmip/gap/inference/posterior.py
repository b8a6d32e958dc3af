"""The posterior over sets of candidates: how probable each set is as the explanation of the readings.

Every hypothesis is judged in the linear model whose states are closest to those it prefers itself (see states.py); the
posterior is normalised over no effect, sets of one to three candidates, and the unknown. Sets whose members imitate
each other beyond what these readings can tell apart (d' < 3) are one explanation, reported under the name of its most
probable member.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import logsumexp

from octmip.gap.inference.evidence import Fit, Members, extensions
from octmip.gap.inference.hypotheses import UNKNOWN_PRIOR, Hypothesis, likely_sets, log_prior
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel, linearise
from octmip.gap.inference.states import STATE_RESOLUTION, distance, log_box, moved_states, starting_states
from octmip.gap.inference.unknown import Unknown, weigh_unknown
from octmip.gap.progress import Stage

EXACT = 100
"""Hypotheses whose evidence is computed exactly and, with open states, about their own states."""
WHOLE = 30
"""Best sets whose subsets are judged as well: an idle member must be able to leave."""
POLISHED = 8
"""Distinct hypotheses about whose own states the model is linearised again."""
BEHIND = 20
"""Log units behind the first starting state beyond which another one is not looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A hypothesis with its posterior probability and where it was judged.

    Attributes
    ----------
    members
        candidates.
    has_unknown
        whether the unknown acts beside them.
    probability
        posterior probability.
    inference
        in which it was judged.
    """

    members: Members
    has_unknown: bool
    probability: float
    inference: Inference

    @property
    def model(self) -> LinearModel:
        """The linear model about the states at which it was judged."""
        return self.inference.model

    @property
    def fit(self) -> Fit:
        """The sizes."""
        return self.inference.judge([self.members])[0].fit

    @property
    def allowing(self) -> LinearModel:
        """The linear model under the errors of the hypothesis' own signatures."""
        return self.inference.allowing(self.members).model

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of its effects, each once."""
        candidates = self.model.inputs.candidates
        return tuple(dict.fromkeys(candidates[j].name for j in self.members))


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """All hypotheses, most probable first.

    Attributes
    ----------
    judged
        ordered hypotheses; probabilities sum to 1.
    unknown
        the unknown's evidence in the main model.
    inference
        the main one (of the most probable hypothesis).
    """

    judged: tuple[Judged, ...]
    unknown: Unknown
    inference: Inference

    @property
    def model(self) -> LinearModel:
        """The main linear model."""
        return self.inference.model

    @property
    def unknown_probability(self) -> float:
        """Probability that something outside the library acts."""
        return float(sum(h.probability for h in self.judged if h.has_unknown))

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
        inference.judge([h.members for h in hypotheses if h.inference is inference])


def attribute(inputs: Inputs) -> Posterior:
    """Return the posterior over sets of effects."""
    started = [Inference(linearise(inputs, states)) for states in starting_states(inputs)]
    enough = _promise(started[0]) - BEHIND
    inferences = [started[0], *(one for one in started[1:] if _promise(one) > enough)]
    found = {h.members: h for inference in inferences for h in likely_sets(inference)}
    if inputs.groups:
        ordered = sorted(found.values(), key=lambda h: -h.log_weight)
        inferences = _polished(inferences, [h.members for h in ordered[: 4 * POLISHED]])
    return _normalised(inferences, found)


def _promise(inference: Inference) -> float:
    """Return the log evidence of the best single candidate, or of none."""
    return inference.model.log_none + float(max(0.0, extensions(inference.model, ()).max(initial=0.0)))


def _polished(started: list[Inference], sets: list[Members]) -> list[Inference]:
    """Return inferences about the states that the best hypotheses prefer."""
    kept: list[Inference] = []
    for members in sets:
        if len(kept) == POLISHED:
            break
        for start in started[:2]:
            found = _settled(start, members, kept)
            if not any(distance(found.model.states, one.model.states) < STATE_RESOLUTION / 5 for one in kept):
                kept.append(found)
    return kept


def _settled(start: Inference, members: Members, kept: list[Inference]) -> Inference:
    """Return the inference about the states that a set prefers: three steps at most, one that is kept where near."""
    found = start
    for _ in range(3):
        states = moved_states(found.model, found.fit(members))
        if distance(states, found.model.states) < STATE_RESOLUTION / 10:
            break
        near = [one for one in kept if distance(states, one.model.states) < STATE_RESOLUTION / 5]
        found = near[0] if near else Inference(linearise(found.model.inputs, states))
    return found


Weighed = tuple[Hypothesis, Inference]


def _normalised(inferences: list[Inference], found: dict[Members, Hypothesis]) -> Posterior:
    inferences[0].model.inputs.progress(Stage("weighing the best hypotheses exactly"))
    weighed = _weighed(inferences, sorted(found.values(), key=lambda h: -h.log_weight))
    best = max(weighed, key=lambda item: item[0].log_weight)[1]
    unknown = weigh_unknown(best.model)
    weighed += _with_unknown(best, unknown)
    total = float(logsumexp([h.log_weight for h, _ in weighed]))
    judged = [Judged(h.members, h.has_unknown, float(np.exp(h.log_weight - total)), where) for h, where in weighed]
    return Posterior(tuple(sorted(judged, key=lambda h: -h.probability)), unknown, best)


def _weighed(inferences: list[Inference], ordered: list[Hypothesis]) -> list[Weighed]:
    """Return the first `EXACT` hypotheses and their parts judged exactly; with known states the others as they are."""
    exact = _with_parts([h.members for h in ordered[:EXACT]])
    for inference in inferences:  # all at once: one by one costs ten times as much
        inference.judge(exact)
    weighed = [_exact(inferences, members) for members in exact]
    if len(inferences) == 1:
        done, only = set(exact), inferences[0]
        others = [h for h in ordered if h.members not in done]
        weighed += [(Hypothesis(h.members, False, h.log_weight + only.model.log_none), only) for h in others]
    return weighed


def _with_parts(sets: list[Members]) -> list[Members]:
    """Return the sets, and what is left of the first `WHOLE` of them when members are taken out: never unjudged."""
    parts = {part for members in sets[:WHOLE] for k in range(len(members)) for part in combinations(members, k)}
    return [*sets, *sorted(parts - set(sets))]


def _exact(inferences: list[Inference], members: Members) -> Weighed:
    """Return prior times evidence of a hypothesis in the inference nearest to its own states."""
    tried = []
    for inference in inferences:
        model, judgement = inference.model, inference.judge([members])[0]
        own = judgement.fit
        away = distance(moved_states(model, own), model.states) if model.inputs.groups else 0.0
        value = model.log_none + judgement.log_factor + log_box(model, own) + log_prior(model.inputs, members)
        tried.append((away, value, inference))
    near = [t for t in tried if t[0] < STATE_RESOLUTION / 2] or [min(tried, key=lambda t: t[0])]
    _, value, nearest = max(near, key=lambda t: t[1])
    return Hypothesis(members, False, value), nearest


def _with_unknown(inference: Inference, unknown: Unknown) -> list[Weighed]:
    """Return the unknown alone and beside every single effect."""
    inputs, conditioned = inference.model.inputs, unknown.allowing.model
    box = log_box(inference.model, inference.fit(()))
    alone = inference.model.log_none + unknown.log_factor + box + float(np.log(UNKNOWN_PRIOR[0]))
    found = [(Hypothesis((), True, alone), unknown.allowing)]
    logs = extensions(conditioned, ())
    for j, candidate in enumerate(inputs.candidates):
        prior = np.log(UNKNOWN_PRIOR[1]) - np.log(inputs.priors.n_effects) + np.log(candidate.weight)
        value = conditioned.log_none + float(logs[j]) + box + float(prior)
        found.append((Hypothesis((j,), True, value), unknown.allowing))
    return found
