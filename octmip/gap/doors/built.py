"""The asset as it was built: the parameters of its twin that the commissioning run says.

No asset has the constants of its drawing. With values v of the parameters, nominal v0 and sd s = `SHARE` |v0|, the run
r is

    r = f(v) + e,      e ~ N(0, noise + (`MODEL` size)^2 of each reading),      v ~ N(v0, s^2) within its range,

and v is its most probable value, by Gauss and Newton's steps; the slope is taken once by differences and follows the
values found by Broyden's formula, as each of its columns costs as many answers of the model as the run has loads.
What the campaign is asked for are changes from there.
Source: Tarantola (2005), "Inverse Problem Theory", section 3.4.4; Broyden (1965), Math. Comp. 19.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.twins import CachedTwin

Floats = NDArray[np.float64]

SHARE = 0.08
"""Sd of a constant of an asset over that of its drawing."""
MODEL = 0.01
"""What a twin with the right constants is off by, over the rms of each reading."""
STEPS = 3
PER_MISFIT, ERRORS = 2.0, (0.02, 0.10)
"""Relative sd of a signature over that of the readings of the sound asset; its least and greatest."""
INSIDE = 0.02
"""Share of its range that a constant keeps from both ends."""
SLOPE = 0.5
"""Step of the slope over the prior sd."""


def as_built(twin: CachedTwin, run: Campaign | None) -> CachedTwin:
    """Return the twin with the constants that a run says; the twin itself without a run, or where it has no card."""
    if run is None or not isinstance(twin.twin, FunctionTwin):
        return twin
    own = built_by(run, twin.twin)
    if own is None:
        return twin
    found = CachedTwin(twin.twin.at(own.values, own.signature_error))
    found.units = twin.units
    return found


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


def built_by(run: Campaign, twin: FunctionTwin) -> Built | None:
    """Return what a run of the sound asset says of its parameters; None where it has none, or no known state.

    Those whose nominal value is 0 or an end of the range are no constants that vary from asset to asset: they stay.
    """
    ranges = {name: own for name, own in twin.card.ranges.items() if own.nominal and own.low < own.nominal < own.high}
    if not ranges or not all(cell.is_known for cell in run.cells):
        return None
    nominal = np.array([own.nominal for own in ranges.values()])
    spread = SHARE * np.abs(nominal)
    low, high = np.array([(own.low, own.high) for own in ranges.values()]).T
    low, high = low + INSIDE * (high - low), high - INSIDE * (high - low)
    order = [twin.gauges.index(name) for name in run.gauges]
    mean, count = (np.array([getattr(cell, what) for cell in run.cells]) for what in ("mean", "count"))
    seen = count > 0

    def asked(shares: Floats) -> Floats:
        values = dict(zip(ranges, (nominal + spread * shares).tolist(), strict=True))
        rows = [twin.ask(_state(run, k), cell.load, values)[order] for k, cell in enumerate(run.cells)]
        return np.asarray(np.array(rows)[seen])

    here = asked(np.zeros(len(nominal)))
    rms = np.sqrt(np.nanmean(np.where(seen, mean, np.nan) ** 2, axis=0))
    sd = np.sqrt(np.nan_to_num(np.nanmean(np.vstack([run.spreads(), 0.0 * rms]) ** 2, axis=0)))
    weight = ((sd**2 / np.maximum(count, 1) + (MODEL * np.maximum(rms, 1e-12)) ** 2) ** -0.5)[seen]
    least, most = (low - nominal) / spread, (high - nominal) / spread
    ahead = np.where(most >= SLOPE, SLOPE, -SLOPE)
    slope = np.column_stack([(asked(step) - here) / step.sum() for step in np.diag(ahead)])
    at = np.zeros(len(nominal))
    for _ in range(STEPS):
        white = slope * weight[:, None]
        left = (mean[seen] - here + slope @ at) * weight
        moved = np.clip(np.linalg.solve(white.T @ white + np.eye(len(at)), white.T @ left), least, most)
        step = moved - at
        if np.abs(step).max() < 0.02:
            break
        there = asked(moved)
        slope = slope + np.outer(there - here - slope @ step, step) / (step @ step)
        at, here = moved, there
    noise = (sd**2 / np.maximum(count, 1))[seen]
    apart = float(
        np.mean(np.maximum(0.0, (mean[seen] - here) ** 2 - noise) / np.broadcast_to(rms, mean.shape)[seen] ** 2)
    )
    error = float(np.clip(PER_MISFIT * np.sqrt(apart), *ERRORS))
    return Built(dict(zip(ranges, (nominal + spread * at).tolist(), strict=True)), error)


def _state(run: Campaign, number: int) -> Mapping[str, float]:
    return dict(zip(run.parameters, run.cells[number].state.tolist(), strict=True))
