"""Sizes of effects that are not linear in them: fitted again to all readings with the effect's exact forward map.

With W the whitening of a hypothesis, r the residual less what its other members and the open states make, and g(theta)
the change that the exact map makes in all rows, Gauss and Newton's steps minimise

    |W (r - g(theta))|^2,   theta <- theta + (J' (W r - W g)) / (J' J),   J = W dg/dtheta,

from the size of the linear fit on; a step that does not lessen the sum is halved, and one that never does is not made.
The standard deviation of the linear fit is stretched by |W S| / |J|, S the signature about none.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.candidates import Candidate, bounds_of
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.posterior import Judged
from octmip.gap.inference.signatures import exact_change

Floats = NDArray[np.float64]

STEPS = 4
"""Steps, each of two forward maps for every load."""
HALVINGS = 3
SLOPE = 0.05
"""Step of the derivative over the prior sd: a table or a rough model has none at a point."""
CLOSE = 1e-4
"""Step over the prior sd below which a size is found."""


@dataclass(frozen=True, slots=True)
class ExactSize:
    """A size by the exact forward map.

    Attributes
    ----------
    size
        in the effect's unit.
    stretch
        standard deviation over that of the linear fit.
    """

    size: float
    stretch: float


def exact_size(head: Judged, member: int, size: float) -> ExactSize:
    """Return the size of a member that fits all readings best; as it was fitted where the effect is linear."""
    candidate = head.model.inputs.candidates[member]
    if candidate.forward is None or size == 0.0:
        return ExactSize(size, 1.0)
    model, own = head.allowing, head.fit
    others = [(j, float(s)) for j, s in zip(own.members, own.size, strict=True) if j != member]
    moved = model.tangents @ model.open_states.moved_by(own.members, own.size)
    left = model.residual - moved - sum((s * model.signatures[:, j] for j, s in others), np.zeros(model.n))
    return _fitted(_Map(head.allowing, candidate), member, model.whiten(left), size)


def _fitted(exact: "_Map", member: int, target: Floats, size: float) -> ExactSize:
    model, bounds = exact.model, bounds_of(exact.candidate.effect)
    sd = model.inputs.priors.sd[member]
    linear = float(np.linalg.norm(model.whiten(model.signatures[:, member])))
    found = float(np.clip(size, *bounds))
    misfit, slope = target - exact.change(found), np.zeros(model.n)
    for _ in range(STEPS):
        ahead = SLOPE * sd if found + SLOPE * sd <= bounds[1] else -SLOPE * sd
        slope = (exact.change(found + ahead) - (target - misfit)) / ahead
        squared = float(slope @ slope)
        if not squared > 0.0:
            return ExactSize(found, 1.0)
        step = float(slope @ misfit) / squared
        after, left = _shorter(exact, target, misfit, found, step, bounds)
        is_found = abs(after - found) < CLOSE * sd
        found, misfit = after, left
        if is_found:
            break
    return ExactSize(found, linear / float(np.linalg.norm(slope)) if linear > 0.0 else 1.0)


def _shorter(
    exact: "_Map",
    target: Floats,
    misfit: Floats,
    start: float,
    step: float,
    bounds: tuple[float, float],
) -> tuple[float, Floats]:
    """Return the size after a step, halved until it lessens the misfit, and the misfit there."""
    for _ in range(HALVINGS):
        ahead = float(np.clip(start + step, *bounds))
        left = target - exact.change(ahead)
        if float(left @ left) <= float(misfit @ misfit):
            return ahead, left
        step *= 0.5
    return start, misfit


@dataclass(frozen=True, slots=True, eq=False)
class _Map:
    """The exact forward map of a candidate in the linear model of a hypothesis."""

    model: LinearModel
    candidate: Candidate

    def change(self, size: float) -> Floats:
        """Return what it changes in all rows (n,), whitened."""
        model = self.model
        rows = exact_change(model.inputs, model.states, self.candidate, size)
        return model.whiten(rows[model.average, model.gauge])
