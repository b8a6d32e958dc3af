"""Signatures of all candidates as columns over the averaged readings: S of the linear model.

A structural effect is asked of the twin at each average's state, load and time. A discrete effect of the measuring
chain is a map of readings, so it is taken from what the calibrated twin predicts: the whole signal counts. An effect
that superposes (creep) answers each step of the load from its own time on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.effects.simple import test_of
from octmip.gap.inference.candidates import Candidate
from octmip.gap.inference.inputs import Inputs
from octmip.gap.twins import rows_at
from octmip.twin import Effect, Load, State, state_limits_of

Floats = NDArray[np.float64]
Steps = list[tuple[float, float]]

LATTICE = 0.2
"""Signatures of structural effects are taken at the nearest state of this lattice: they change slowly with damage."""


SMALL, MOST_RATIO = 0.1, 2.0
"""Share of the scale below which a reading says little of how good its twin is; how far that may be off."""


def signatures_of(inputs: Inputs, states: Floats, missed: Floats) -> Floats:
    """Return the signatures (n_candidates, n_averages * n_gauges).

    Parameters
    ----------
    inputs
        campaign, twin and candidates.
    states
        (n_cells, n_parameters).
    missed
        (n_averages, n_gauges) what the asset reads more than the twin before any effect.
    """
    at = _states_of(inputs, states)
    expected, ratio = _predicted(inputs, states) + missed, ratios(inputs, states, missed)
    history = load_steps(inputs.campaign)
    columns = [np.zeros((0, expected.size))]
    for effect, places in inputs.effects():
        if getattr(effect, "acts_on_readings", False):
            number = np.array([part.number for part in inputs.averages])
            first = np.flatnonzero(np.diff(number, prepend=-1) != 0)
            repeated = np.diff([*first, len(number)])  # halves of one cell have the same
            rows = list(np.repeat(on_readings(inputs, effect, places, expected[first]), repeated, axis=0))
        else:
            parts = zip(inputs.averages, at, strict=True)
            rows = [_of_twin(inputs, effect, places, part, state, history) for part, state in parts]
            if getattr(effect, "load_power", None) != 0:
                rows = [row * own for row, own in zip(rows, ratio, strict=True)]
            tests = [test_of(effect, place) for place in places]
            if any(tests):
                acts = np.array([[name in ("", part.test) for name in tests] for part in inputs.averages])
                rows = [row * own[:, None] for row, own in zip(rows, acts, strict=True)]
        columns.append(np.array(rows).transpose(1, 0, 2).reshape(len(places), -1))
    return np.concatenate(columns)


def ratios(inputs: Inputs, states: Floats, missed: Floats) -> Floats:
    """Return how many times the twin's (n_averages, n_gauges) the asset's readings are, 1 where both are small.

    Where a twin reads a share too little, what an effect changes is mostly that share too little as well.
    """
    twins, scale = _predicted(inputs, states), SMALL * inputs.frame.scale
    own = twins**2 + scale**2  # 0 where the twin reads nothing in any reading of a kind
    found = np.divide((twins + missed) * twins + scale**2, own, out=np.ones_like(own), where=own > 0.0)
    return np.asarray(np.clip(found, 1.0 / MOST_RATIO, MOST_RATIO))


def _predicted(inputs: Inputs, states: Floats) -> Floats:
    """Return what the twin reads in every average (n_averages, n_gauges)."""
    asked = [(inputs.named(states[part.number]), part.load) for part in inputs.averages]
    return np.array([inputs.twin.predict(state, load) for state, load in asked])[:, list(inputs.order)]


def exact_change(inputs: Inputs, states: Floats, candidate: Candidate, size: float) -> Floats:
    """Return what a candidate of a size changes in all averages (n_averages, n_gauges) by its exact forward map.

    The states (n_cells, n_parameters) are taken as they are.
    """
    assert candidate.forward is not None
    uses_time = bool(getattr(candidate.effect, "uses_time", False))
    known: dict[tuple[bytes, Load, float], Floats] = {}
    rows = []
    for average in inputs.averages:
        state, load = states[average.number], average.load
        time = average.time if uses_time else 0.0
        key = (state.tobytes(), load, time)
        if candidate.test not in ("", average.test):
            rows.append(np.zeros(len(inputs.order)))
            continue
        if key not in known:
            named = inputs.named(state)
            there = candidate.forward(inputs.twin, named, load, size, candidate.place, time)
            known[key] = (np.asarray(there) - inputs.twin.predict(named, load))[list(inputs.order)]
        rows.append(known[key])
    return np.array(rows)


def load_steps(campaign: Campaign) -> Steps:
    """Return each change of the one load with its time [s] since the first reading; empty without times.

    Steps of several loads do not add up along one axis: then there are none.
    """
    if not campaign.has_time or len(campaign.load_names) != 1:
        return []
    start = float(np.nanmin(campaign.time))
    begun = sorted((float(campaign.time[cell.rows].min()) - start, cell.load_factor) for cell in campaign.cells)
    loads = [0.0, *(load for _, load in begun)]
    return [(after - before, time) for (time, after), before in zip(begun, loads, strict=False)]


def on_readings(inputs: Inputs, effect: Effect, places: Sequence[str], readings: Floats) -> Floats:
    """Return what an effect changes in rows of readings (n_rows, n_gauges): (n_rows, n_places, n_gauges)."""
    gauges = tuple(inputs.twin.gauges[k] for k in inputs.order)  # a run may have more than the campaign
    units, channels = inputs.units, inputs.channels
    rows = [_Readings(gauges, row, units, channels) for row in readings]
    return np.array([rows_at(effect, row, {}, 1.0, places) for row in rows])


def _states_of(inputs: Inputs, states: Floats) -> list[dict[str, float]]:
    """Return the state at which each average's signatures are asked: its own, on the lattice where it is unknown."""
    limits = np.array(state_limits_of(inputs.twin))
    on = [np.round(np.clip(states[part.number], 0.0, None) / LATTICE) * LATTICE for part in inputs.averages]
    near = [np.minimum(place, limits) for place in on]
    is_open = {cell for group in inputs.groups for cell in group}
    return [
        inputs.named(place if part.number in is_open else states[part.number])
        for part, place in zip(inputs.averages, near, strict=True)
    ]


def _of_twin(
    inputs: Inputs, effect: Effect, places: tuple[str, ...], part: Cell, state: State, history: Steps
) -> Floats:
    """Return the signatures (n_places, n_gauges) of one average, summed over the steps of the load where they add."""
    steps: list[tuple[Load, float]] = [(change, part.time - start) for change, start in history if start <= part.time]
    if not getattr(effect, "superposes", False) or not steps:
        steps = [(part.load, part.time)]
    parts = [inputs.twin.signatures(effect, places, state, load, time) for load, time in steps]
    return np.asarray(np.sum(parts, axis=0)[:, list(inputs.order)])


@dataclass(frozen=True, slots=True, eq=False)
class _Readings:
    """A twin that answers with given readings (n_gauges,) of the campaign's gauges."""

    gauges: tuple[str, ...]
    readings: Floats
    units: tuple[str, ...]
    channels: tuple[str, ...]
    parameters: tuple[str, ...] = ()
    effects: Mapping[str, Effect] = field(default_factory=dict)

    def predict(self, state: State, load_factor: Load) -> Floats:
        """Return the readings."""
        return self.readings
