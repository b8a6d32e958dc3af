"""The posterior over sets of candidates: how probable each set is as the explanation of the readings.

It is normalised over no effect, sets of candidates, and the unknown, each at every **level** of the difference between
twin and asset. What one hypothesis weighs in several ways adds up; it is shown in the one that bears it most.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from scipy.special import logsumexp

from octmip.gap.inference.evidence import Members
from octmip.gap.inference.inference import Inference, Judged
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.search import weighed_hypotheses
from octmip.gap.inference.states import starting_states

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


def attribute(inputs: Inputs) -> Posterior:
    """Return the posterior over sets of effects."""
    weighed = weighed_hypotheses(inputs, starting_states(inputs))
    by_key: dict[tuple[Members, bool], list[Judged]] = {}
    for w in weighed:
        by_key.setdefault((w.members, w.has_unknown), []).append(w)
    total = float(logsumexp([w.log_weight for w in weighed]))
    judged = [_judged(same, total) for same in by_key.values()]
    judged = [h for h in judged if h.probability > NEGLIGIBLE or not h.has_unknown]
    judged.sort(key=lambda h: -h.probability)
    walk = judged[0].model.inputs.noise.walk_sd
    known = [w for w in weighed if not w.has_unknown]
    alike = [w for w in known if w.inference.model.inputs.noise.walk_sd == walk]
    main = max(alike or known, key=lambda w: w.log_weight).inference
    return Posterior(tuple(judged), main, total)


def _judged(same: Sequence[Judged], total: float) -> Judged:
    """Return what one hypothesis weighs under all variants, in the one that bears it most."""
    best = max(same, key=lambda w: w.log_weight)
    probability = sum(math.exp(w.log_weight - total) for w in same)
    return replace(best, probability=probability)
