"""The posterior over sets of candidates: how probable each set is as the explanation of the readings.

It is normalised over no effect, sets of candidates, and the unknown, each at every **level** of the difference between
twin and asset and with every test of a stated state doubted in turn. What one hypothesis weighs in several ways adds
up; it is shown in the one that bears it most.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from octmip.gap.inference.evidence import Fit, Members
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import Inputs, doubted_state
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.search import Weighed, nothing_else, promise, weighed_hypotheses
from octmip.gap.inference.states import highest, starting_states

SOUND_ENOUGH = 0.5
"""Probability that nothing is wrong, beyond which no stated state is doubted."""
HOPELESS = 10.0
"""Log units behind which another state of a test is no explanation."""
NEGLIGIBLE = 1e-7
"""Probability below which an effect beside the unknown is not kept."""
OPEN = 0.2
"""Probability of the unknown from which another state of a test is looked at beside an effect."""


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
    doubted
        the test whose stated state it takes as wrong; "" for none.
    words
        what the unknown looks like.
    """

    members: Members
    has_unknown: bool
    probability: float
    inference: Inference
    doubted: str = ""
    words: str = ""

    @property
    def model(self) -> LinearModel:
        """The linear model about the states at which it was judged."""
        return self.inference.model

    @property
    def fit(self) -> Fit:
        """The sizes."""
        return self.inference.fit(self.members)

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
    inference
        the main one: of the most probable hypothesis without the unknown, under the noise of the leading one.
    log_total
        log of the sum of prior times evidence.
    """

    judged: tuple[Judged, ...]
    inference: Inference
    log_total: float = 0.0

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


Key = tuple[Members, bool, str]
"""What a hypothesis says: its candidates, whether the unknown acts, the test whose state it doubts."""


def attribute(inputs: Inputs) -> Posterior:
    """Return the posterior over sets of effects."""
    found = {"": weighed_hypotheses(inputs, starting_states(inputs))}
    if _may_be_misstated(inputs, found[""]):
        found |= _with_doubts(inputs, found[""])
    return _normalised(found)


def _may_be_misstated(inputs: Inputs, weighed: Sequence[Weighed]) -> bool:
    """Return whether some stated state may be wrong: there is more to explain than no effect does."""
    known = any(cell.is_known for cell in inputs.campaign.cells)
    none = [w.log_weight for w in weighed if not w.members and not w.has_unknown]
    sound = float(logsumexp(none)) if none else -np.inf
    is_sought = bool(inputs.names) and bool((highest(inputs) > 0.0).all())
    return is_sought and known and sound - log_total(weighed) < np.log(SOUND_ENOUGH)


def _with_doubts(inputs: Inputs, weighed: Sequence[Weighed]) -> dict[str, list[Weighed]]:
    """Return what explains the readings where the stated state of one test is taken as unknown, by test.

    Tests are left out whose other state explains the readings too badly, beside all that the stated states allow: with
    nothing else wrong, or beside one effect where no effect of the library explains them at the stated states.
    """
    log_stated = log_total(weighed)
    outside = log_total([w for w in weighed if w.has_unknown])
    is_open = outside - log_stated > np.log(OPEN)
    tests = list(dict.fromkeys(cell.test for cell in inputs.campaign.cells if cell.is_known))
    prior = float(np.log(max(inputs.odds.misstated, 1e-300))) - float(np.log(max(len(tests), 1)))
    found = {}
    for test in tests:
        doubted = doubted_state(inputs, test)
        states = starting_states(doubted)
        alone = nothing_else(doubted, states[0])
        value = promise(doubted, states[0]) if is_open else alone.log_weight
        if value + prior > log_stated - HOPELESS:
            others = weighed_hypotheses(doubted, states[:1], is_quick=True)
            found[test] = [w.times(prior) for w in others]
    return found


def _normalised(found: dict[str, list[Weighed]]) -> Posterior:
    by_key: dict[Key, list[Weighed]] = {}
    for doubted, weighed in found.items():
        for w in weighed:
            by_key.setdefault((w.members, w.has_unknown, doubted), []).append(w)
    total = float(logsumexp([w.log_weight for same in by_key.values() for w in same]))
    judged = [_judged(key, same, total) for key, same in by_key.items()]
    judged = [h for h in judged if h.probability > NEGLIGIBLE or not h.has_unknown]
    judged.sort(key=lambda h: -h.probability)
    walk = judged[0].model.inputs.noise.walk_sd
    known = [w for weighed in found.values() for w in weighed if not w.has_unknown]
    alike = [w for w in known if w.inference.model.inputs.noise.walk_sd == walk]
    main = max(alike or known, key=lambda w: w.log_weight).inference
    return Posterior(tuple(judged), main, total)


def _judged(key: Key, same: Sequence[Weighed], total: float) -> Judged:
    """Return what one hypothesis weighs under all variants, in the one that bears it most."""
    members, has_unknown, doubted = key
    best = max(same, key=lambda w: w.log_weight)
    probability = sum(math.exp(w.log_weight - total) for w in same)
    return Judged(members, has_unknown, probability, best.inference, doubted, best.words)


def log_total(weighed: Sequence[Weighed]) -> float:
    """Return the log of the sum of all weights."""
    return float(logsumexp([w.log_weight for w in weighed]))
