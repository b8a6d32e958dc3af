"""The asset as it was built: the parameters of its twin that the commissioning run says.

No asset has the constants of its drawing. With values v of the parameters, nominal v0 and sd s = share |v0|, the run
r is

    r = f(v) + e,      e ~ N(0, noise + (`MODEL` size)^2 of each reading),      v ~ N(v0, s^2) within its range,

and v is its most probable value, by Gauss and Newton's steps; the slope is taken once by differences and follows the
values found by Broyden's formula, as each of its columns costs as many answers of the model as the run has loads.
What the campaign is asked for are changes from there.
Source: Tarantola (2005), "Inverse Problem Theory", section 3.4.4; Broyden (1965), Math. Comp. 19.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.doors.card import INSIDE
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
    ranges = twin.constants
    if not ranges or run.load_names != twin.loads or not all(cell.is_known for cell in run.cells):
        return None
    read = _Read.of(run, cached, twin, share)
    here = read.asked({})
    rows = read.rows_near(here)
    return _fitted(read, here, rows) if len(rows) else None


@dataclass(frozen=True, slots=True, eq=False)
class _Read:
    """The means of a run, beside a model with constants that vary.

    Attributes
    ----------
    run, cached, twin
        of the asset, and the model as it is checked and as it is asked.
    seen
        (n_cells, n_gauges) whether the run has a mean.
    mean, variance
        (n,) of those, and of their noise.
    order
        place of each of the run's gauges among the model's.
    nominal, spread
        (n_constants,) values of the drawing, and their sd.
    """

    run: Campaign
    cached: CachedTwin
    twin: FunctionTwin
    seen: NDArray[np.bool_]
    mean: Floats
    variance: Floats
    order: tuple[int, ...]
    nominal: Floats
    spread: Floats

    @classmethod
    def of(cls, run: Campaign, cached: CachedTwin, twin: FunctionTwin, share: float) -> "_Read":
        """Return those of the gauges that the model knows."""
        known = [k for k, name in enumerate(run.gauges) if name in cached.gauges]
        order = tuple(cached.gauges.index(run.gauges[k]) for k in known)
        mean, count = (np.array([getattr(cell, what) for cell in run.cells])[:, known] for what in ("mean", "count"))
        spreads = run.spreads()[:, known]
        squares = np.sum(np.nan_to_num(spreads) ** 2, axis=0) / np.maximum(np.isfinite(spreads).sum(axis=0), 1)
        seen = count > 0
        nominal = np.array([own.nominal for own in twin.constants.values()])
        variance = (squares / np.maximum(count, 1))[seen]
        return cls(run, cached, twin, seen, mean[seen], variance, order, nominal, share * np.abs(nominal))

    def values(self, shares: Floats) -> dict[str, float]:
        """Return the constants by name, given how many sd (n_constants,) each is off the drawing."""
        return dict(zip(self.twin.constants, (self.nominal + self.spread * shares).tolist(), strict=True))

    def asked(self, values: Mapping[str, float]) -> Floats:
        """Return what the model with some constants at other values reads where the run has a mean (n,)."""
        run = self.run
        settings = [(dict(zip(run.parameters, cell.state.tolist(), strict=True)), cell.load) for cell in run.cells]
        answers = np.array([self.cached.checked(partial(self.twin.ask, *at, values), *at) for at in settings])
        return np.asarray(answers[:, list(self.order)][self.seen])

    def rms(self, values: Floats) -> Floats:
        """Return the rms (n,) of the gauge of each of some values (n,)."""
        squares = np.zeros(self.seen.shape)
        squares[self.seen] = values**2
        mean = squares.sum(axis=0) / np.maximum(self.seen.sum(axis=0), 1)
        return np.asarray(np.sqrt(np.broadcast_to(mean, self.seen.shape)[self.seen]))

    def rows_near(self, here: Floats) -> NDArray[np.int64]:
        """Return the rows of gauges that read about what the model of the drawing says (n,)."""
        return np.flatnonzero(self.rms(self.mean - here) < FAR * self.rms(here))


def _fitted(read: _Read, here: Floats, rows: NDArray[np.int64]) -> Built:
    """Return the most probable constants by some rows, from what the drawing's read (n,)."""
    ends = np.array([(own.low, own.high) for own in read.twin.constants.values()])
    inside = ends + INSIDE * np.ptp(ends, axis=1)[:, None] * np.array([1.0, -1.0])
    least, most = ((inside - read.nominal[:, None]) / read.spread[:, None]).T
    size, measured, here = read.rms(here)[rows], read.mean[rows], here[rows]
    weight = (read.variance[rows] + (MODEL * size) ** 2) ** -0.5
    slopes, told = np.zeros((len(rows), len(ends))), np.ones(len(ends), dtype=bool)
    for k, (name, own) in enumerate(read.twin.constants.items()):
        value, share = own.ahead(read.spread[k])
        try:
            slopes[:, k] = (read.asked({name: value})[rows] - here) / share
        except TwinError:  # a constant at whose other values the model fails stays as drawn
            told[k] = False
    at = np.zeros(len(ends))
    for _ in range(STEPS):
        white, left = slopes * weight[:, None], (measured - here + slopes @ at) * weight
        moved = np.clip(np.linalg.solve(white.T @ white + np.eye(len(at)), white.T @ left), least, most)
        step = moved - at
        if np.abs(step).max() < CLOSE:
            break
        try:
            there = read.asked(read.values(moved))[rows]
        except TwinError:
            break
        slopes = slopes + np.outer(there - here - slopes @ step, step) / (step @ step)
        at, here = moved, there
    left = (measured - here) ** 2 - read.variance[rows]
    error = float(np.clip(PER_MISFIT * np.sqrt((np.maximum(0.0, left) / size**2).mean()), *ERRORS))
    values = {name: value for (name, value), has in zip(read.values(at).items(), told, strict=True) if has}
    return Built(values, error)
