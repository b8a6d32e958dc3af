"""The asset as it was built: the parameters of its twin that the commissioning run says.

No asset has the constants of its drawing. With values v of the parameters, nominal v0 and sd s = share |v0|, the run
r is

    r = f(v) + e,      e ~ N(0, noise + (`MODEL` size)^2 of each reading),      v ~ N(v0, s^2) within its range,

and v is its most probable value, by Gauss and Newton's steps; the slope is taken once by differences and follows the
values found by Broyden's formula, as each of its columns costs as many answers of the model as the run has loads.
What the campaign is asked for are changes from there.
Source: Tarantola (2005), "Inverse Problem Theory", section 3.4.4; Broyden (1965), Math. Comp. 19.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.doors.card import INSIDE
from octmip.gap.doors.function import FunctionTwin, Setting
from octmip.gap.twins import CachedTwin
from octmip.twin import Load, State

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


def as_built(twin: CachedTwin, run: Campaign | None, share: float) -> CachedTwin:
    """Return the twin with the constants that a run says; the twin itself without a run, or where it has no card.

    `share` is the prior sd of a constant over that of the drawing.

    Raises
    ------
    TwinError
        the model fails, or answers no finite numbers.
    """
    if run is None or not isinstance(twin.twin, FunctionTwin):
        return twin
    own = built_by(run, twin, share)
    if own is None:
        return twin
    found = CachedTwin(twin.twin.at(own.values, own.signature_error, slopes=own.slopes))
    found.units = twin.units
    return found


def by_campaign(twin: CachedTwin, campaign: Campaign, share: float) -> CachedTwin:
    """Return the twin with the constants that a campaign without a run makes likely, which stay open."""
    own = built_by(campaign, twin, share) if isinstance(twin.twin, FunctionTwin) else None
    if own is None or not isinstance(twin.twin, FunctionTwin):
        return twin
    drawn = twin.twin.constants
    open_ = {k: (drawn[k].nominal - value, share * abs(drawn[k].nominal)) for k, value in own.values.items()}
    found = CachedTwin(twin.twin.at(own.values, None, open_))
    found.units = twin.units
    return found


def of_drawing(
    drawn: CachedTwin, sound: CachedTwin, share: float, asked: Sequence[tuple[State, Load]]
) -> tuple[Floats, Floats]:
    """Return what the drawing reads more than the asset by its run (n, n_gauges), and slopes (k, n, n_gauges) there.

    Parameters
    ----------
    drawn, sound
        the model with the constants of its drawing, and with those of the run.
    share
        prior sd of a constant over that of the drawing.
    asked
        n states and loads.

    The slopes are per prior sd of each of the k constants that the run said; without such constants there are none.
    """
    own = drawn.twin
    if drawn is sound or not isinstance(own, FunctionTwin) or not isinstance(sound.twin, FunctionTwin):
        return np.zeros((len(asked), len(sound.gauges))), np.zeros((0, len(asked), len(sound.gauges)))
    sds = {name: share * abs(own.constants[name].nominal) for name in sound.twin.said}
    slopes = np.array([own.slopes(state, load, sds) for state, load in asked]).transpose(1, 0, 2)
    return np.array([own.predict(state, load) - sound.predict(state, load) for state, load in asked]), slopes


def departures(drawn: CachedTwin, sound: CachedTwin, share: float) -> Floats:
    """Return how many prior sds (k,) the drawing's constants are from those that the run said."""
    if drawn is sound or not isinstance(drawn.twin, FunctionTwin) or not isinstance(sound.twin, FunctionTwin):
        return np.zeros(0)
    built, own = sound.twin.card.ranges, drawn.twin.constants
    return np.array([(own[k].nominal - built[k].nominal) / (share * abs(own[k].nominal)) for k in sound.twin.said])


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
    slopes
        (n_readings,) what a unit of a parameter changes, by its name, then by states and loads of the run.
    """

    values: Mapping[str, float]
    signature_error: float
    slopes: Mapping[str, Mapping[Setting, Floats]]


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
    answers = read.asked(np.zeros(len(ranges)))
    rows = read.rows_near(read.of_run(answers))
    return _fitted(read, answers, rows) if len(rows) else None


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

    @property
    def settings(self) -> list[tuple[State, Load]]:
        """States and loads of the run's cells."""
        return [(dict(zip(self.run.parameters, c.state.tolist(), strict=True)), c.load) for c in self.run.cells]

    def asked(self, shares: Floats) -> Floats:
        """Return what the model reads in all cells (n_cells, n_readings)."""
        values = self.values(shares)
        return np.array([self.cached.checked(partial(self.twin.ask, *at, values), *at) for at in self.settings])

    def of_run(self, answers: Floats) -> Floats:
        """Return those of the model's readings (n_cells, n_readings, ...) of which the run has a mean (n, ...)."""
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


def _fitted(read: _Read, answers: Floats, rows: NDArray[np.int64]) -> Built:
    """Return the most probable constants by some rows, from what the drawing's read (n_cells, n_readings)."""
    ends = np.array([(own.low, own.high) for own in read.twin.constants.values()])
    inside = ends + INSIDE * np.ptp(ends, axis=1)[:, None] * np.array([1.0, -1.0])
    least, most = ((inside - read.nominal[:, None]) / read.spread[:, None]).T
    size, measured = read.rms(read.of_run(answers))[rows], read.mean[rows]
    weight = (read.variance[rows] + (MODEL * size) ** 2) ** -0.5
    ahead = np.array([own.ahead(sd)[1] for own, sd in zip(read.twin.constants.values(), read.spread, strict=True)])
    slopes, told = np.zeros((*answers.shape, len(ahead))), np.ones(len(ahead), dtype=bool)
    for k, step in enumerate(np.diag(ahead)):
        try:
            slopes[..., k] = (read.asked(step) - answers) / step.sum()
        except TwinError:  # a constant at whose other values the model fails stays as drawn
            told[k] = False
    at = np.zeros(len(ahead))
    for _ in range(STEPS):
        here, slope = read.of_run(answers)[rows], read.of_run(slopes)[rows]
        white, left = slope * weight[:, None], (measured - here + slope @ at) * weight
        moved = np.clip(np.linalg.solve(white.T @ white + np.eye(len(at)), white.T @ left), least, most)
        step = moved - at
        if np.abs(step).max() < CLOSE:
            break
        try:
            there = read.asked(moved)
        except TwinError:
            break
        slopes = slopes + (there - answers - slopes @ step)[..., None] * step / (step @ step)
        at, answers = moved, there
    left = (measured - read.of_run(answers)[rows]) ** 2 - read.variance[rows]
    error = float(np.clip(PER_MISFIT * np.sqrt((np.maximum(0.0, left) / size**2).mean()), *ERRORS))
    values = {name: value for (name, value), has in zip(read.values(at).items(), told, strict=True) if has}
    settings, per_unit = [read.twin.setting(*where) for where in read.settings], slopes / read.spread
    known = {name: dict(zip(settings, per_unit[..., k], strict=True)) for k, name in enumerate(read.twin.constants)}
    return Built(values, error, {name: known[name] for name in values})
