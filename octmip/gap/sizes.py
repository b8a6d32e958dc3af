"""Sizes of effects as they are reported: with a 90 % interval, in the effect's unit.

The fit gives a normal size under the hypothesis that leads. Four things make the interval wider or move it:

* other places of the same effect explain the readings too: mean and variance of the mixture over them,
  m = sum w_k m_k,  v = sum w_k (v_k + m_k^2) - m^2;
* where an effect may lie between places, size and place trade: a signature S_j (1 - x) + x S_k fitted by S_j alone has
  a size wrong by the factor 1 + x (1 / c_k - 1), c_k the best scale of the neighbour k, x ~ N(0, BETWEEN^2);
* two models of one effect differ in its whole signature somewhat less than gauge by gauge: the size is no surer;
* an effect with an exact forward map g is not linear in its size: with W the whitening of the hypothesis and r the
  residual less what its other members and the open states make, |W (r - g(theta))|^2 is made least, by Gauss and
  Newton's steps from the linear fit on, slopes by the last two answers; the sd is stretched by |W S| / |W dg/dtheta|,
  S the signature about none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.effects.words import EffectWords, words_at
from octmip.gap.inference.candidates import Candidate, bounds_of
from octmip.gap.inference.evidence import mixture
from octmip.gap.inference.inference import BETWEEN, Judged, neighbours, scales_of
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.posterior import fit_together
from octmip.gap.inference.signatures import exact_change

Floats = NDArray[np.float64]

WIDTH = 1.645
"""Standard deviations of a 90 % interval."""
NEGLIGIBLE = 1e-3
"""Share of a cause's probability below which one of its hypotheses does not move the size."""
STEPS = 24
"""Most steps of a fit with an exact forward map, each of one map for every load."""
TOLD = 0.05
"""Probability of a cause from which the model is asked for its sizes; less is not worth its answers."""
CLOSE = 0.1
"""Step over its own sd below which a size is found."""
COMMON_PART = 0.6
"""Sd of the error of a whole signature over that at one gauge: two models of one effect share most constants."""
LEAST_PART = 0.04
"""The same at least, whatever is known of the signature: of 146 gains and errors of loads on eight machines that the
diagnosis named, 117 lay in intervals without it, 131 with it."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """The size of one effect.

    Attributes
    ----------
    effect, place
        name and where it acts.
    size, low, high
        mean and 90 % interval, in `unit`.
    unit
        unit.
    words
        what the size measures.
    named
        what an engineer calls the effect there, and what to do about it.
    """

    effect: str
    place: str
    size: float
    low: float
    high: float
    unit: str
    words: str
    named: EffectWords

    @property
    def interval(self) -> str:
        """Size and 90 % interval in words, with the unit."""
        return f"{self.size:.3g} {self.unit} ({self.low:.3g} to {self.high:.3g})"


def parameters(head: Judged, same: Sequence[Judged]) -> tuple[Parameter, ...]:
    """Return the sizes of a hypothesis; `same` are the hypotheses that are the same cause, itself among them."""
    if not head.members:
        return ()
    own, probability = head.fit, sum(h.probability for h in same)
    least = NEGLIGIBLE * probability
    same = [h for h in same if h is head or (h.probability > least and not h.has_unknown)]
    fit_together(same)
    told = probability >= TOLD
    return tuple(_parameter(head, j, float(own.size[k]), same, told) for k, j in enumerate(own.members))


def _parameter(head: Judged, member: int, size: float, same: Sequence[Judged], told: bool) -> Parameter:
    candidate = head.model.inputs.candidates[member]
    effect, place = candidate.effect, candidate.place
    mean, variance = _mixture(head, member, same)
    whole = max(LEAST_PART, COMMON_PART * candidate.signature_error)
    relative = np.hypot(_place_error(head.model, member), whole)
    spread = WIDTH * float(np.sqrt(variance + (mean * relative) ** 2))
    low, high = min(size, mean - spread), max(size, mean + spread)
    is_asked = told and size and candidate.forward is not None
    exact, stretch = _exact(head, member, size) if is_asked else (size, 1.0)
    low, high = (exact + stretch * (end - size) for end in (low, high))
    size, low, high = (float(value) for value in np.clip((exact, low, high), *bounds_of(effect)))
    named = words_at(effect, head.model.inputs.twin, place)
    return Parameter(effect.name, place, size, low, high, effect.unit, effect.parameter, named)


def _exact(head: Judged, member: int, size: float) -> tuple[float, float]:
    """Return the size of a member that fits all readings best by its exact forward map, and the stretch of its sd."""
    model, own, candidate = head.allowing, head.fit, head.model.inputs.candidates[member]
    low, high = bounds_of(candidate.effect)
    moved = model.tangents @ model.moved_by(own.members, own.size)
    others = [k for k, j in enumerate(own.members) if j != member]
    moved = moved + model.signatures[:, [own.members[k] for k in others]] @ own.size[others]
    target, at = model.residual - moved, float(np.clip(model.chords.get(member, size), low, high))
    linear = slope = model.whiten(model.signatures[:, member])
    left = model.whiten(target - changed_rows(model, candidate, at))
    for k in range(STEPS):
        if (steep := float(np.linalg.norm(slope))) == 0.0:
            break
        step = float(slope @ left) / steep**2
        if abs(step) * steep < CLOSE and k:
            break
        if abs(step) * steep < CLOSE:  # the slope there is not known yet
            step = (1.0 if at + 1.0 / steep <= high else -1.0) / steep
        there = float(np.clip(at + step, low, high))
        if there == at:
            break
        ahead = model.whiten(target - changed_rows(model, candidate, there))
        slope = (left - ahead) / (there - at)
        if np.linalg.norm(ahead) < np.linalg.norm(left):
            at, left = there, ahead
    steep = float(np.linalg.norm(slope))
    return at, float(np.linalg.norm(linear)) / steep if linear.any() and steep > 0.0 else 1.0


def changed_rows(model: LinearModel, candidate: Candidate, size: float) -> Floats:
    """Return what a candidate of a size changes in the rows of a model (n_rows,)."""
    return np.asarray(exact_change(model.inputs, model.states, candidate, size)[model.average, model.gauge])


def _mixture(head: Judged, member: int, same: Sequence[Judged]) -> tuple[float, float]:
    """Return mean and variance of the size over the hypotheses that hold the member's effect once."""
    name = head.model.inputs.priors.name
    found = [(head.probability, head.fit, head.members.index(member))]
    for h in same:
        of_effect = [k for k, j in enumerate(h.members) if name[j] == name[member]]
        if h is not head and len(of_effect) == 1 and not h.has_unknown:
            found.append((h.probability, h.fit, of_effect[0]))
    weights = np.array([weight for weight, *_ in found])
    means, variances = np.array([(fit.size[k], fit.covariance[k, k]) for _, fit, k in found]).T
    mean, variance = mixture(weights / max(weights.sum(), 1e-300), means[:, None], variances[:, None, None])
    return float(mean[0]), float(variance[0, 0])


def _place_error(model: LinearModel, member: int) -> float:
    """Return the relative sd of a size whose place is known no better than its neighbours lie apart."""
    near = neighbours(model, member) if model.inputs.candidates[member].n_between else []
    if not near:
        return 0.0
    return float(BETWEEN * np.sqrt(np.mean((1.0 / scales_of(model, near, member) - 1.0) ** 2)))
