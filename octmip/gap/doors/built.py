"""The asset as it was built: the parameters of its twin that the commissioning run says.

No asset has the constants of its drawing. With values v of the parameters, nominal v0 and sd s = share |v0|, the run
r is

    r = f(v) + e,      e ~ N(0, noise + (`MODEL` size)^2 of each reading),      v ~ N(v0, s^2) within its range,

and v is its most probable value, by Gauss and Newton's steps; the slope is taken once by differences and follows the
values found by Broyden's formula, as each of its columns costs as many answers of the model as the run has loads.
What the campaign is asked for are changes from there.
Source: Tarantola (2005), "Inverse Problem Theory", section 3.4.4; Broyden (1965), Math. Comp. 19.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.doors.card import INSIDE, Range
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.twins import CachedTwin

Floats = NDArray[np.float64]

MODEL = 0.01
"""What a twin with the right constants is off by, over the rms of each reading."""
TOLD, MOST_TOLD = 0.02, 4
"""Share of its nominal value from which a constant is told, and how many are."""
STEPS = 3
FAR = 0.5
"""Rms of what a reading is off by over its own, from which it does not count: that is no constant of an asset."""
PER_MISFIT, ERRORS = 2.0, (0.02, 0.10)
"""Relative sd of a signature over that of the readings of the sound asset; its least and greatest."""
CLOSE = 0.02
"""A step that is none, over the prior sd."""


def as_built(twin: CachedTwin, run: Campaign, share: float, is_open: bool = False) -> CachedTwin:
    """Return the twin with the constants that a run says, or those that a campaign makes likely, which stay open.

    The twin itself where it has no card, or no constants that vary. `share` is the prior sd of a constant over that of
    the drawing.

    Raises
    ------
    TwinError
        the model fails, or answers no finite numbers.
    """
    own = built_by(run, twin, share) if isinstance(twin.twin, FunctionTwin) else None
    if own is None or not isinstance(twin.twin, FunctionTwin):
        return twin
    sds = {name: share * abs(twin.twin.constants[name].nominal) for name in own.values}
    found = CachedTwin(twin.twin.at(own.values, None if is_open else own.signature_error, sds))
    found.units = twin.units
    return found


def built_words(drawn: CachedTwin, sound: CachedTwin) -> list[str]:
    """Return a note on the constants that the asset was built with, where they are not the model's."""
    if drawn is sound or not isinstance(drawn.twin, FunctionTwin) or not isinstance(sound.twin, FunctionTwin):
        return []
    pairs = [(name, own, sound.twin.card.ranges[name].nominal) for name, own in drawn.twin.card.ranges.items()]
    off = [(name, own, value) for name, own, value in pairs if abs(value - own.nominal) > TOLD * abs(own.nominal)]
    off.sort(key=lambda one: -abs(one[2] / one[1].nominal - 1.0))
    said = [f"{name.replace('_', ' ')} {value:.3g} for {own.nominal:g}" for name, own, value in off[:MOST_TOLD]]
    if not said:
        return []
    return [
        f"By its run the sound asset has other constants than the model ({', '.join(said)}): effects start from them."
    ]


@dataclass(frozen=True, slots=True)
class Built:
    """What a run says of the asset.

    Attributes
    ----------
    values
        of the parameters, by name.
    signature_error
        relative sd of what an effect changes: a twin that reads the sound asset well knows its changes well.
    """

    values: Mapping[str, float]
    signature_error: float


def built_by(run: Campaign, cached: CachedTwin, share: float) -> Built | None:
    """Return what a run of the sound asset says of its parameters.

    None where none of them varies from asset to asset, or where the run is refused anyway: unknown states, or the loads
    of another twin.
    """
    twin = cached.twin
    assert isinstance(twin, FunctionTwin)
    if not twin.constants or run.load_names != twin.loads or not all(cell.is_known for cell in run.cells):
        return None
    known = [k for k, name in enumerate(run.gauges) if name in cached.gauges]
    order = [cached.gauges.index(run.gauges[k]) for k in known]
    settings = [(dict(zip(run.parameters, cell.state.tolist(), strict=True)), cell.load) for cell in run.cells]

    def asked(values: Mapping[str, float]) -> Floats:
        return np.array([cached.checked(partial(twin.ask, *at, values), *at) for at in settings])[:, order]

    mean, count = (np.array([getattr(cell, what) for cell in run.cells])[:, known] for what in ("mean", "count"))
    spreads, seen, drawn = run.spreads()[:, known], count > 0, asked({})
    squares = np.sum(np.nan_to_num(spreads) ** 2, axis=0) / np.maximum(np.isfinite(spreads).sum(axis=0), 1)
    rows = seen & (_rms(mean - drawn, seen) < FAR * _rms(drawn, seen))  # of gauges that read about what is drawn
    if not rows.any():
        return None
    variance, size = (squares / np.maximum(count, 1))[rows], np.broadcast_to(_rms(drawn, seen), rows.shape)[rows]
    weight = (variance + (MODEL * size) ** 2) ** -0.5
    values, here = _fitted(twin.constants, share, lambda values: asked(values)[rows], mean[rows], weight)
    left = np.maximum(0.0, (mean[rows] - here) ** 2 - variance) / size**2
    return Built(values, float(np.clip(PER_MISFIT * np.sqrt(left.mean()), *ERRORS)))


def _rms(values: Floats, seen: NDArray[np.bool_]) -> Floats:
    """Return the rms (n_gauges,) of what was seen of each gauge's values (n_cells, n_gauges)."""
    squares = np.where(seen, values, 0.0) ** 2
    return np.asarray(np.sqrt(squares.sum(axis=0) / np.maximum(seen.sum(axis=0), 1)))


def _fitted(
    ranges: Mapping[str, Range],
    share: float,
    asked: Callable[[Mapping[str, float]], Floats],
    measured: Floats,
    weight: Floats,
) -> tuple[dict[str, float], Floats]:
    """Return the most probable constants, but those at whose other values the model fails, and its answers there (n,).

    Parameters
    ----------
    ranges, share
        of the constants, by name, and their prior sd over the drawing's value.
    asked
        constants that are not the drawing's -> answers (n,).
    measured, weight
        (n,) means, and 1 over the sd by which answers may be off.
    """
    own = np.array([(one.nominal, one.low, one.high) for one in ranges.values()])
    nominal, ends = own[:, 0], own[:, 1:]
    spread = share * np.abs(nominal)
    inside = ends + INSIDE * np.ptp(ends, axis=1)[:, None] * np.array([1.0, -1.0])
    least, most = ((inside - nominal[:, None]) / spread[:, None]).T
    here, at, told = asked({}), np.zeros(len(own)), list(ranges)
    slopes = np.zeros((len(here), len(own)))
    for k, (name, one) in enumerate(ranges.items()):
        value, step = one.ahead(spread[k])
        try:
            slopes[:, k] = (asked({name: value}) - here) / step
        except TwinError:  # it stays as drawn
            told.remove(name)
    for _ in range(STEPS):
        white, left = slopes * weight[:, None], (measured - here + slopes @ at) * weight
        moved = np.clip(np.linalg.solve(white.T @ white + np.eye(len(at)), white.T @ left), least, most)
        step = moved - at
        if np.abs(step).max() < CLOSE:
            break
        try:
            there = asked(dict(zip(ranges, (nominal + spread * moved).tolist(), strict=True)))
        except TwinError:
            break
        slopes = slopes + np.outer(there - here - slopes @ step, step) / (step @ step)
        at, here = moved, there
    values = dict(zip(ranges, (nominal + spread * at).tolist(), strict=True))
    return {name: values[name] for name in told}, here
