"""Constants of an asset of which no run tells: what the campaign says of them under every hypothesis, and together.

With z the constants in prior sds about the twin's, z ~ N(p, I), rows r = C z + S theta + e of unit noise and the
posterior theta ~ N(t, T) of a hypothesis:

    z | theta ~ N(p + C' (r - C p - S theta), I - C' C),

C and S whitened with C in the covariance. A change of a constant itself adds to it: what is told is today's value.
The mean and covariance of all hypotheses are those of their mixture.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.doors.function import FunctionTwin
from octmip.gap.inference.evidence import mixture
from octmip.gap.inference.inference import Judged
from octmip.gap.sizes import WIDTH, Parameter, changed_rows

Floats = NDArray[np.float64]

COUNTS = 1e-3
"""Probability from which a hypothesis counts."""


@dataclass(frozen=True, slots=True)
class Constant:
    """What the readings say of a constant of the asset.

    Attributes
    ----------
    name, unit
        as the card says.
    drawn
        the model's value.
    sound
        without what the most probable cause changes, at the sizes that are told; of what it changes, the drawing's.
    mean, sd
        today, all hypotheses together.
    correlation
        with the others, by name.
    """

    name: str
    unit: str
    drawn: float
    sound: float
    mean: float
    sd: float
    correlation: Mapping[str, float]

    @property
    def interval(self) -> tuple[float, float]:
        """Bounds that hold 90 % of the probability."""
        return self.mean - WIDTH * self.sd, self.mean + WIDTH * self.sd


def constants_of(judged: Sequence[Judged], told: Sequence[Parameter] = ()) -> tuple[Constant, ...]:
    """Return the constants that are open, given all hypotheses, the most probable first, and the sizes told of it."""
    open_ = judged[0].model.inputs.open if judged else {}
    if not open_:
        return ()
    twin = judged[0].model.inputs.twin.twin
    assert isinstance(twin, FunctionTwin)
    ranges = twin.card.ranges
    counted = [one for one in judged if one.probability > COUNTS] or list(judged[:1])
    share = np.array([one.probability for one in counted]) / sum(one.probability for one in counted)
    today, spread = zip(*map(_of_one, counted), strict=True)
    mean, second = mixture(share, np.array(today), np.array(spread))
    sd = np.sqrt(np.diag(second))
    correlation = second / np.outer(sd, sd)
    before, found = _without(judged[0], told), list[Constant]()
    for k, (name, (departure, _)) in enumerate(open_.items()):
        own = ranges[name]
        others = {other: float(correlation[k, j]) for j, other in enumerate(open_) if j != k}
        sound = float(np.clip(own.nominal + before[k], own.low, own.high))  # where the model has an answer
        now = own.nominal + float(mean[k])
        found.append(Constant(name, own.unit, own.nominal + departure, sound, now, float(sd[k]), others))
    return tuple(found)


def _without(judged: Judged, told: Sequence[Parameter]) -> Floats:
    """Return the mean (k,) without changes of constants, from the twin's values, by the effects' exact maps."""
    model, candidates = judged.allowing, judged.model.inputs.candidates
    sizes, left = {(one.effect, one.place): one.size for one in told}, model.residual
    for j, size in zip(judged.fit.members, judged.fit.size, strict=True):
        size = sizes.get((candidates[j].name, candidates[j].place), float(size))
        is_mapped = candidates[j].forward is not None
        left = left - (changed_rows(model, candidates[j], size) if is_mapped else model.signatures[:, j] * size)
    departure, sd = np.array([*judged.model.inputs.open.values()]).T
    rest = sd * (model.whiten(model.rows.constants).T @ model.whiten(left))
    changed = {effect for effect, _ in sizes}  # from the drawing: there its map starts
    return np.asarray(departure + rest * [name not in changed for name in judged.model.inputs.open])


def _of_one(judged: Judged) -> tuple[Floats, Floats]:
    """Return mean (k,) with the changes of constants, and covariance (k, k), from the twin's values."""
    model, fit, names = judged.allowing, judged.fit, list(judged.model.inputs.open)
    departure, sd = np.array([*judged.model.inputs.open.values()]).T
    columns, members = model.whiten(model.rows.constants), list(fit.members)
    signatures = model.white[:, members]
    middle = departure + sd * (columns.T @ (model.left - signatures @ fit.size))
    candidates = judged.model.inputs.candidates
    own = np.array([[float(candidates[j].name == name) for j in members] for name in names]).reshape(len(names), -1)
    moved = own - sd[:, None] * (columns.T @ signatures)
    spread = np.outer(sd, sd) * (np.eye(len(sd)) - columns.T @ columns)
    return middle + own @ fit.size, spread + moved @ fit.covariance @ moved.T


def constants_words(constants: Sequence[Constant], share: float) -> list[str]:
    """Return a note on constants that no run tells, which lie about a share off the drawing."""
    if not constants:
        return []
    return [
        f"No run says which constants the asset was built with: they are taken to be some {100 * share:.2g} % off the "
        "drawing (say how far), and a change of one is named as far as it stands out of that."
    ]
