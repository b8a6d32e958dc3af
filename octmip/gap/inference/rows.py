"""Mean readings as rows: what a campaign or a commissioning run says, gauge by gauge, beside what the twin predicts."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Cell
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.twins import CachedTwin
from octmip.twin import Load, State, amounts_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


HALF = 0.5
"""Damage of the states over which a reading of unknown unit is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Mean readings, a row for each that was recorded, and what the difference of twin and asset depends on there.

    Attributes
    ----------
    average, gauge
        (n,) which average and which gauge of the campaign.
    measured, predicted
        (n,) mean reading and the twin's.
    load, test, state
        (n,) numbers, common to run and campaign.
    healthy, change
        (n,) what the twin predicts of the sound asset, and what the state changes in it.
    share
        (n,) phi.
    applied
        (n, n_loads) loads over half of their range in run and campaign.
    constants
        (n, k) what a prior sd of each constant that is open changes.
    """

    average: Ints
    gauge: Ints
    measured: Floats
    predicted: Floats
    load: Ints
    test: Ints
    state: Ints
    healthy: Floats
    change: Floats
    share: Floats
    applied: Floats
    constants: Floats

    @property
    def residual(self) -> Floats:
        """(n,) readings less the twin's predictions."""
        return self.measured - self.predicted

    def at(self, rows: Ints | NDArray[np.bool_]) -> "Rows":
        """Return some of the rows."""
        return Rows(*(getattr(self, name)[rows] for name in self.__slots__))


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What rows of run and campaign are numbered and measured by.

    Attributes
    ----------
    twin
        the model.
    order
        position in the twin's gauges of each of the campaign's.
    scale
        (n_gauges,) size against which readings are small.
    reference
        (n_gauges,) healthy prediction at the reference load.
    kind
        (n_gauges,) number of each reading's kind: its unit, one for all where the twin does not say.
    loads
        number of each load.
    """

    twin: CachedTwin
    order: tuple[int, ...]
    scale: Floats
    reference: Floats
    kind: Ints
    loads: Mapping[Load, int]

    @classmethod
    def of(cls, twin: CachedTwin, gauges: Sequence[str], reference: Load, loads: Iterable[Load]) -> "Frame":
        """Return that of the readings of some gauges of a twin."""
        order = tuple(twin.gauges.index(name) for name in gauges)
        kinds = twin.units or ("",) * len(twin.gauges)
        named = list(dict.fromkeys(kinds))
        healthy = twin.predict({}, reference)[list(order)]
        kind = np.array([named.index(kinds[k]) for k in order])
        numbers = {load: k for k, load in enumerate(dict.fromkeys(loads))}
        return cls(twin, order, _scale(twin, order, kind, reference), healthy, kind, numbers)

    def applied(self, load: Load) -> Floats:
        """Return a load (n_loads,) over half of the range of each of its amounts in run and campaign."""
        amounts = np.array([amounts_of(one) for one in self.loads])
        half = np.ptp(amounts, axis=0) / 2.0
        return np.asarray(np.array(amounts_of(load)) / np.where(half > 0.0, half, 1.0))

    @property
    def open(self) -> Mapping[str, tuple[float, float]]:
        """Constants that no run says, by name: the drawing's less the twin's, and the prior sd."""
        return self.twin.twin.departures if isinstance(self.twin.twin, FunctionTwin) and self.twin.twin.is_open else {}

    def slopes(self, state: State, load: Load) -> Floats:
        """Return what a standard deviation of each of k constants changes (n_gauges, k)."""
        if not isinstance(self.twin.twin, FunctionTwin):
            return np.zeros((len(self.order), 0))
        return np.asarray(self.twin.twin.slopes(state, load)[:, list(self.order)].T)

    def along(self, length: float) -> Floats:
        """Return a correlation (n_gauges, n_gauges) that falls along the structure, over `length` of its extent."""
        positions, n = self.twin.gauge_positions, len(self.order)
        points = np.arange(n, dtype=np.float64)[:, None] if positions is None else positions[list(self.order)]
        extent = float(np.linalg.norm(np.ptp(points, axis=0)))
        distance = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=2) / max(length * extent, 1e-12)
        return np.asarray(np.exp(-0.5 * distance**2))

    def share(self, healthy: Floats) -> float:
        """Return phi: the signed size of a healthy prediction (n_gauges,) beside that at the reference load."""
        relative = self.reference / self.scale
        return float((healthy / self.scale) @ relative / (relative @ relative))

    def shares(self, healthy: Floats) -> Floats:
        """Return phi (n_gauges,) of each reading's kind: a frequency may stay where a strain vanishes."""
        relative, own = self.reference / self.scale, healthy / self.scale
        squares = np.bincount(self.kind, relative**2)
        return np.asarray((np.bincount(self.kind, relative * own) / np.maximum(squares, 1e-300))[self.kind])

    def rows(self, averages: Sequence[Cell], states: Floats, first_test: int) -> Rows:
        """Return the rows of averages of these gauges in states (n_cells, n_parameters); tests count from a number."""
        own = states[[part.number for part in averages]]
        tests = {name: first_test + k for k, name in enumerate(dict.fromkeys(part.test for part in averages))}
        number, loads = np.array([tests[part.test] for part in averages]), [part.load for part in averages]
        return self._rows(own, loads, number, *recorded(averages), np.array([part.mean for part in averages]))

    def row_of_each_gauge(self, load: Load, state: Mapping[str, float]) -> Rows:
        """Return a row (n_gauges,) for every gauge at a load, in a test of its own, without a reading."""
        values = np.array([[state.get(name, 0.0) for name in self.twin.parameters]])
        gauge = np.arange(len(self.order), dtype=np.int64)
        return self._rows(values, [load], np.array([-1]), np.zeros_like(gauge), gauge, np.full((1, len(gauge)), np.nan))

    def _rows(
        self, states: Floats, loads: Sequence[Load], test: Ints, average: Ints, gauge: Ints, means: Floats
    ) -> Rows:
        """Return the rows of some averages and gauges, in states at loads, of means (n_averages, n_gauges)."""
        order = list(self.order)
        named = [dict(zip(self.twin.parameters, state.tolist(), strict=True)) for state in states]
        asked = list(zip(named, loads, strict=True))
        now = np.array([self.twin.predict(*one) for one in asked])[:, order]
        none = np.zeros((len(order), 0))
        healthy = np.array([self.twin.predict({}, load) for load in loads])[:, order]
        return Rows(
            average=average,
            gauge=gauge,
            measured=means[average, gauge],
            predicted=now[average, gauge],
            load=np.array([self.loads.get(load, -1) for load in loads])[average],
            test=test[average],
            state=np.array([_number(state) for state in states])[average],
            healthy=healthy[average, gauge],
            change=(now - healthy)[average, gauge],
            share=np.array([self.shares(row) for row in healthy])[average, gauge],
            applied=np.array([self.applied(load) for load in loads])[average],
            constants=np.array([self.slopes(*one) if self.open else none for one in asked])[average, gauge],
        )


def _scale(twin: CachedTwin, order: Sequence[int], kind: Ints, load: Load) -> Floats:
    """Return the size (n_gauges,) against which readings are small: the rms prediction over those of the same unit.

    A twin that announces no units may mix several, so each reading is then measured by itself, over the sound state
    and states with half of each damage: a strain that is near zero in the sound state need not be in others.
    """
    if twin.units is None:
        states = np.vstack([np.zeros(len(twin.parameters)), HALF * np.eye(len(twin.parameters))])
        squares = np.mean(twin.predict_states(states, load)[:, list(order)] ** 2, axis=0)
    else:
        own = twin.predict({}, load)[list(order)] ** 2
        squares = np.array([np.mean(own[kind == k]) for k in kind])
    return np.asarray(np.maximum(np.sqrt(squares), 1e-300))


def recorded(averages: Sequence[Cell]) -> tuple[Ints, Ints]:
    """Return average and gauge (n,) of every mean that was recorded, a row of the model each."""
    average, gauge = np.nonzero([part.count > 0 for part in averages])
    return average.astype(np.int64), gauge.astype(np.int64)


def _number(state: Floats) -> int:
    """Return a number that equal states share."""
    return hash(tuple(np.round(state, 9).tolist())) if state.any() else 0
