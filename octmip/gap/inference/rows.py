"""Mean readings as rows: what a campaign or a commissioning run says, gauge by gauge, beside what the twin predicts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Cell
from octmip.gap.inference.difference import Rows
from octmip.gap.twins import CachedTwin
from octmip.twin import Load

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Means:
    """The averages of a campaign in given states, a row for each that was recorded.

    Attributes
    ----------
    average, gauge
        (n,) which average and which gauge of the campaign.
    measured, predicted
        (n,) mean reading and the twin's.
    expected
        (n_averages, n_gauges) the twin's predictions, recorded or not.
    rows
        what the difference of twin and asset depends on.
    """

    average: Ints
    gauge: Ints
    measured: Floats
    predicted: Floats
    expected: Floats
    rows: Rows


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
        (n_gauges,) size of a reading.
    reference
        (n_gauges,) healthy prediction at the reference load.
    kind
        (n_gauges,) number of each reading's kind.
    loads
        number of each load.
    """

    twin: CachedTwin
    order: tuple[int, ...]
    scale: Floats
    reference: Floats
    kind: Ints
    loads: Mapping[Load, int]

    def share(self, healthy: Floats) -> float:
        """Return phi: the signed size of a healthy prediction (n_gauges,) beside that at the reference load."""
        relative = self.reference / self.scale
        return float((healthy / self.scale) @ relative / (relative @ relative))

    def shares(self, healthy: Floats) -> Floats:
        """Return phi (n_gauges,) of each reading's kind: a frequency may stay where a strain vanishes."""
        relative, own = self.reference / self.scale, healthy / self.scale
        squares = np.bincount(self.kind, relative**2)
        return np.asarray((np.bincount(self.kind, relative * own) / np.maximum(squares, 1e-300))[self.kind])

    def means(self, averages: Sequence[Cell], states: Floats, first_test: int) -> Means:
        """Return the rows of averages of these gauges in states (n_cells, n_parameters); tests count from a number."""
        order = list(self.order)
        named = [dict(zip(self.twin.parameters, states[part.number].tolist(), strict=True)) for part in averages]
        now = np.array([self.twin.predict(state, part.load) for state, part in zip(named, averages, strict=True)])
        healthy = np.array([self.twin.predict({}, part.load) for part in averages])[:, order]
        now, (average, gauge) = now[:, order], recorded(averages)
        tests = {name: first_test + k for k, name in enumerate(dict.fromkeys(part.test for part in averages))}
        rows = Rows(
            gauge=gauge,
            load=np.array([self.loads[part.load] for part in averages])[average],
            test=np.array([tests[part.test] for part in averages])[average],
            state=np.array([_number(states[part.number]) for part in averages])[average],
            healthy=healthy[average, gauge],
            change=(now - healthy)[average, gauge],
            share=np.array([self.shares(row) for row in healthy])[average, gauge],
        )
        measured = np.array([part.mean for part in averages])[average, gauge]
        return Means(average, gauge, measured, now[average, gauge], now, rows)

    def row_of_each_gauge(self, load: Load, state: dict[str, float]) -> Rows:
        """Return a row (n_gauges,) for every gauge at a load, in a test of its own."""
        order, n = list(self.order), len(self.order)
        healthy = self.twin.predict({}, load)[order]
        now = self.twin.predict(state, load)[order]
        values = np.array([state.get(name, 0.0) for name in self.twin.parameters])
        return Rows(
            gauge=np.arange(n, dtype=np.int64),
            load=np.full(n, self.loads.get(load, -1), dtype=np.int64),
            test=np.full(n, -1, dtype=np.int64),
            state=np.full(n, _number(values), dtype=np.int64),
            healthy=healthy,
            change=now - healthy,
            share=self.shares(healthy),
        )


def recorded(averages: Sequence[Cell]) -> tuple[Ints, Ints]:
    """Return average and gauge (n,) of every mean that was recorded, a row of the model each."""
    average, gauge = np.nonzero([part.count > 0 for part in averages])
    return average.astype(np.int64), gauge.astype(np.int64)


def _number(state: Floats) -> int:
    """Return a number that equal states share."""
    return hash(tuple(np.round(state, 9).tolist())) if state.any() else 0
